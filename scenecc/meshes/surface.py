"""Triangles, materials and images of visual shapes."""

from __future__ import annotations

from dataclasses import field, replace
from hashlib import sha256
from importlib import import_module
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final, Literal

from scenecc.assets.errors import AssetError
from scenecc.colors import linear_to_srgb, srgb_to_linear
from scenecc.diagnostics.frozen import frozen
from scenecc.files import ChangedError, read_checked

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray
    from PIL.Image import Image as Pixels

    from scenecc.diagnostics import Origin
    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.plan import ScenePlan, Value

Vec4 = tuple[float, float, float, float]

Channel = Literal["r", "g", "b"]

Suffix = Literal[".png", ".jpg"]

_WHITE: Final[Vec4] = (1.0, 1.0, 1.0, 1.0)


@frozen
class Surface:
    """Triangles of one material. Arrays are read-only; surfaces compare by identity.

    Attributes:
        vertices: (V, 3) float32 [m].
        faces: (F, 3) int64, counterclockwise from outside.
        normals: (V, 3) float32 unit vectors; None: flat shading.
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
        digest: hash of `data`; equal images have equal digests.
        data: a PNG or JPEG.
        suffix: ".png" or ".jpg".
        pixels: Pillow image.
        name: file name for display.
        channel: channel that is read if the image replaces a number.
        srgb: whether 8-bit values are sRGB; SAPIEN applies this to images of numbers too.
        filter_mode, address_mode: as in `scenecc.plan.Texture`, with SAPIEN's defaults.
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
    """Values of SAPIEN's `RenderMaterial`, with defaults. An image replaces a number.

    Attributes:
        base_color: linear RGBA in 0..1.
        visibility: visibility of the body.
        emission: linear RGB times strength; an image is multiplied by it.
        specular: SAPIEN's value; the reflectance is 0.08 times it.
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
        """Displayed base colour, linear RGBA; with an image, its factor."""
        red, green, blue, alpha = self.base_color if self.base_color_image is None else _WHITE
        return red, green, blue, alpha * self.visibility


@frozen
class MeshPart:
    """A surface and its material."""

    surface: Surface
    look: SurfaceMaterial


@frozen
class MeshShape:
    """A shape of a body.

    Attributes:
        name: name in the plan; "" if it has none.
        kind: shape type.
        parts: surfaces, before scaling.
        pose: in the body's frame.
        scale: along the shape's own axes; a mirrored shape still faces outwards.
        turned: whether its triangles face the other side.
        endless: whether it is an infinite plane, with a surface of 2 m × 2 m.
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


_READABLE_SUFFIXES: Final = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".tga"})

_PORTABLE_SUFFIXES: Final[dict[str, Suffix]] = {".png": ".png", ".jpg": ".jpg", ".jpeg": ".jpg"}
"""Formats that other programs read directly → their suffix. Others are converted to PNG."""


class ImageCache:
    """Cache of a plan's image files; each is read once."""

    def __init__(self) -> None:
        self._read: dict[Path, tuple[bytes, Suffix, Pixels]] = {}

    def file(self, path: Path, digest: str | None, sampling: dict[str, Any]) -> Image:
        """Returns the image of a file.

        Args:
            path: path of the file.
            digest: SHA-256 of the checked content.
            sampling: filter mode, address mode and sRGB, as far as given.

        Raises:
            AssetError: it cannot be read.
        """
        if path not in self._read:
            self._read[path] = _open_image(path, digest)
        data, suffix, pixels = self._read[path]
        given = {name: sampling[name] for name in ("srgb", "filter_mode", "address_mode") if name in sampling}
        return Image(_digest(data), data, suffix, pixels, path.stem, **given)


def convert_image(pixels: Pixels | None, name: str, channel: Channel = "r", *, srgb: bool) -> Image | None:
    """Converts an image of a mesh file, as read by trimesh."""
    if pixels is None:
        return None
    data = encode_png(pixels)
    return Image(_digest(data), data, ".png", pixels, name, channel, srgb)


def convert_color_space(image: Image, *, srgb: bool) -> Image:
    """Converts an image to sRGB or linear values; returns it unchanged if it already has them."""
    if image.srgb == srgb:
        return image
    curve = linear_to_srgb if srgb else srgb_to_linear
    table = [round(curve(byte / 255) * 255) for byte in range(256)]
    clear = image.pixels.mode in {"RGBA", "LA", "PA"}
    made = image.pixels.convert("RGBA" if clear else "RGB").point([*table * 3, *(range(256) if clear else ())])
    data = encode_png(made)
    return replace(image, digest=_digest(data), data=data, suffix=".png", pixels=made, srgb=srgb)


def encode_png(pixels: Pixels) -> bytes:
    """Returns an image as PNG."""
    data = BytesIO()
    pixels.save(data, format="PNG")
    return data.getvalue()


def _open_image(path: Path, digest: str | None) -> tuple[bytes, Suffix, Pixels]:
    suffix = path.suffix.lower()
    if suffix not in _READABLE_SUFFIXES:
        raise AssetError("SC748", f"images of type `{suffix}` are left out", "save it as PNG or JPEG")
    pillow: Any = import_module("PIL.Image")
    try:
        data = read_checked(path, digest)
        pixels = pillow.open(BytesIO(data))
        pixels.load()
    except ChangedError as error:
        raise AssetError("SC422", f"'{path}' changed while the scene was built") from error
    except (OSError, ValueError) as error:
        raise AssetError("SC748", f"'{path}' cannot be read: {error}", "save it as PNG or JPEG") from error
    return (
        (data, _PORTABLE_SUFFIXES[suffix], pixels)
        if suffix in _PORTABLE_SUFFIXES
        else (encode_png(pixels), ".png", pixels)
    )


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()


class MaterialCache:
    """Cache of a plan's visual materials; equal ones are created once."""

    def __init__(self, plan: ScenePlan, on_left_out: Callable[[AssetError], None]) -> None:
        self._plan = plan
        self._on_left_out = on_left_out
        self._images = ImageCache()
        self._made: dict[tuple[object, ...], SurfaceMaterial] = {}
        self._left_out: set[str] = set()

    def look(self, material: Value, row: int) -> SurfaceMaterial:
        """Returns the material in one row of its shape."""
        index = int(material.row(row))
        made = self._plan.visual_materials[index]
        key = (index, *(value.row(row).tobytes() for value in made.values()))
        if key not in self._made:
            images = {f"{name.removesuffix('_texture')}_image": item for name, item in made.textures().items()}
            found: dict[str, Any] = {name: self._image(texture, row) for name, texture in images.items()}
            self._made[key] = SurfaceMaterial(**_material_numbers(made.row(row)), **found)
        return self._made[key]

    def _image(self, texture: Any, row: int) -> Image | None:
        file = self._plan.files[int(texture.file.row(row))]
        try:
            return self._images.file(file.path, file.sha256, texture.sampling())
        except AssetError as problem:
            if problem.message not in self._left_out:
                self._left_out.add(problem.message)
                self._on_left_out(problem)
            return None


def _material_numbers(given: dict[str, float | list[float]]) -> dict[str, Any]:
    """Converts the plan's numbers for `SurfaceMaterial`: colours as tuples, emission times its strength."""
    found: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in given.items()}
    if "emission" in found:
        red, green, blue, strength = found["emission"]
        found["emission"] = (red * strength, green * strength, blue * strength)
    return found
