"""A plan in numbers and words that a person checks at a glance: a row an object, and what differs between scenes."""

from scenecc.inspect.entities import SummaryRow, summarize
from scenecc.inspect.facts import Fact, Item
from scenecc.inspect.varying import VaryingField

__all__ = ["Fact", "Item", "SummaryRow", "VaryingField", "summarize"]
