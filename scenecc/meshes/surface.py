"""Triangle surfaces, materials and shapes of a body, and the error for a file that cannot be shown."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics import Location
from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from PIL.Image import Image as Pixels

    from scenecc.diagnostics import Origin, Sink
    from scenecc.geometry.rotations import Pose7


Vec3 = tuple[float, float, float]


Vec4 = tuple[float, float, float, float]

Channel = Literal["r", "g", "b"]

Suffix = Literal[".png", ".jpg"]

_WHITE: Final[Vec4] = (1.0, 1.0, 1.0, 1.0)


class MeshError(Exception):
    """A file that cannot be shown.

    Attributes:
        code: of the diagnostic.
        message: what is wrong.
        hint: what to do.
    """

    def __init__(self, code: str, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.code, self.message, self.hint = code, message, hint


@frozen
class Surface:
    """Triangles of one look. Its arrays are read-only, and surfaces are told apart by identity.

    Attributes:
        vertices: (V, 3) float32 [m].
        faces: (F, 3) int64, counterclockwise from outside.
        normals: (V, 3) float32 of unit length; None: every triangle is flat.
        uvs: (V, 2) float32 from the image's top left corner, as in SAPIEN and glTF; None: (0, 0) everywhere.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int64]
    normals: NDArray[np.float32] | None = None
    uvs: NDArray[np.float32] | None = None

    __eq__ = object.__eq__
    __hash__ = object.__hash__


@frozen
class Image:
    """An image, and how it is sampled.

    Attributes:
        digest: of `data`; images with the same are the same.
        data: a PNG or a JPEG. suffix: ".png" or ".jpg".
        pixels: Pillow's.
        name: of its file, for people.
        channel: the one that counts where one number is read.
        srgb: whether its 8-bit values are sRGB: SAPIEN goes by this also where an image stands for a number.
        filter_mode, address_mode: as in `scenecc.plan.Texture`, SAPIEN's defaults filled in.
    """

    digest: str
    data: bytes = field(compare=False)
    suffix: Suffix = field(compare=False)
    pixels: Pixels = field(compare=False)
    name: str = ""
    channel: Channel = "r"
    srgb: bool = True
    filter_mode: Literal["nearest", "linear"] = "linear"
    address_mode: Literal["repeat", "border", "edge", "mirror"] = "repeat"


@frozen
class SurfaceMaterial:
    """What SAPIEN's `RenderMaterial` says, its defaults filled in. An image stands in place of the number.

    Attributes:
        base_color: linear RGBA in 0..1.
        visibility: of the body that has it.
        emission: linear RGB, its strength multiplied in; an image is multiplied with it.
        specular: SAPIEN's, which reflects 0.08 times as much.
    """

    base_color: Vec4 = (1.0, 1.0, 1.0, 1.0)
    visibility: float = 1.0
    emission: Vec3 = (0.0, 0.0, 0.0)
    specular: float = 0.0
    roughness: float = 1.0
    metallic: float = 0.0
    transmission: float = 0.0
    ior: float = 1.45
    transmission_roughness: float = 0.0
    base_color_image: Image | None = None
    normal_image: Image | None = None
    roughness_image: Image | None = None
    metallic_image: Image | None = None
    emission_image: Image | None = None
    transmission_image: Image | None = None

    @property
    def tint(self) -> Vec4:
        """What is seen of the base colour, linear RGBA: with an image, what multiplies its own."""
        red, green, blue, alpha = self.base_color if self.base_color_image is None else _WHITE
        return red, green, blue, alpha * self.visibility


@frozen
class MeshPart:
    """A surface and its look."""

    surface: Surface
    look: SurfaceMaterial


@frozen
class MeshShape:
    """One shape of a body.

    Attributes:
        name: the plan's own; "" where it has none.
        kind: its type in the language.
        parts: its surfaces, before they are scaled.
        pose: in the body's frame.
        scale: along the shape's own axes; what it mirrors is seen from outside all the same.
        turned: whether its triangles are seen from the other side.
        endless: a plane without an end, whose surface is 2 m × 2 m.
        origin: in the document.
    """

    name: str
    kind: str
    parts: tuple[MeshPart, ...]
    pose: Pose7
    scale: Vec3 = (1.0, 1.0, 1.0)
    turned: bool = False
    endless: bool = False
    origin: Origin | None = field(default=None, compare=False)


def report_mesh_error(problem: MeshError, place: Origin | None, sink: Sink) -> None:
    """Reports a problem of the shape at a place."""
    sink.report(problem.code, problem.message, place or Location(None), hint=problem.hint)
