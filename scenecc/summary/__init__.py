"""A plan in numbers and words that a person checks at a glance: a row an object, and what differs between scenes."""

from scenecc.summary.fields import VaryingField
from scenecc.summary.item import Fact, Item
from scenecc.summary.rows import SummaryRow, summarize

__all__ = ["Fact", "Item", "SummaryRow", "VaryingField", "summarize"]
