"""What named nodes are known as across the sections of a document."""

from __future__ import annotations

SHARED_NAMES = ("frames", "entities", "cameras")
"""Sections whose names are one namespace."""


def known_as(section: str, name: str) -> str:
    """What a named node is known as among those of all sections: by its name, or with its section before it.

    Args:
        section: `frames`, `entities`, `cameras`, `constraints` or `lights`.
        name: the full one. No name has a colon.
    """
    return name if section in SHARED_NAMES else f"{section}:{name}"
