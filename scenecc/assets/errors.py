"""Why an asset cannot be used, and the files that an asset names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scenecc.diagnostics.coded_error import CodedError


class AssetError(CodedError):
    """Why an asset cannot be used: a code of band 4 or 6, a message and what to do."""


@dataclass(frozen=True, slots=True)
class AssetReference:
    """A file that an asset names.

    Attributes:
        uri: as written.
        kind: images and OBJ material files matter to visual meshes, buffers to all; "fallback" is a file that the
            engine opens in place of a missing material file.
        escaped: it has percent escapes, which SAPIEN does not decode: it would look for a file of that very name.
    """

    uri: str
    kind: Literal["material", "image", "buffer", "fallback"]
    escaped: bool = False
