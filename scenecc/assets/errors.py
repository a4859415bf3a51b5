"""Errors of assets, and references from assets to other files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scenecc.diagnostics.coded_error import CodedError


class AssetError(CodedError):
    """An asset cannot be used. Has a code SC4xx or SC6xx, a message and a hint."""


@dataclass(frozen=True, slots=True)
class AssetReference:
    """A file that an asset names.

    Attributes:
        uri: as written.
        kind: images and OBJ material files matter only for visual meshes, buffers for all. "fallback" is a file that
            the engine opens if a material file is missing.
        escaped: whether it has percent escapes. SAPIEN does not decode these, and would look for the escaped name.
    """

    uri: str
    kind: Literal["material", "image", "buffer", "fallback"]
    escaped: bool = False
