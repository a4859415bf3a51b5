"""Reads YAML text and Python dicts as plain data, with limits against hostile files.

The position of a node is found lazily, by its path.
"""

from scenecc.source.document import Document
from scenecc.source.limits import Limits, make_limits
from scenecc.source.read import read_dict, read_file, read_text, read_value

__all__ = [
    "Document",
    "Limits",
    "make_limits",
    "read_dict",
    "read_file",
    "read_text",
    "read_value",
]
