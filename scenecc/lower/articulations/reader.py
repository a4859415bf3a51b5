"""What lowering asks of whoever reads robots' files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.plan import AssetFile
    from scenecc.robots.description import Description


@dataclass(frozen=True, slots=True)
class RobotRequest:
    """How a file is to be read.

    Attributes:
        format: of the file.
        uri: as written.
        srdf: as written; "none": none; None: the one beside the file.
        package_dir: as written; None: none is given.
        scale: of all lengths.
        collision_is_visual: whether what collides is seen too.
    """

    format: Literal["urdf", "mjcf"]
    uri: str
    srdf: str | None = None
    package_dir: str | None = None
    scale: float = 1.0
    collision_is_visual: bool = False


RobotReader = Callable[[RobotRequest, Mapping[str, "Origin"]], "tuple[AssetFile, Description] | None"]
"""The file of a request and what it says; None where it was reported. Takes where the keys are written that are: the
format's own, `srdf` and `package_dir`."""
