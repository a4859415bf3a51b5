"""Readable summaries of a plan or a built scene: one row per object, the fields that vary, and a tree of facts."""

from scenecc.inspect.entities import SummaryRow, summarize
from scenecc.inspect.facts import Fact, Item
from scenecc.inspect.varying import VaryingField

__all__ = ["Fact", "Item", "SummaryRow", "VaryingField", "summarize"]
