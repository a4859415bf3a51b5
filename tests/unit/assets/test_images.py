"""EXR, KTX and grey images: what is taken, and what SAPIEN's own reader takes."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from plugins.image_files import GL_RGBA16F, exr, exr_head, ktx, ktx2, picture
from unit.assets.test_assets import png

from scenecc import validate
from scenecc.assets.images import check_image

GOOD: dict[str, bytes] = {
    "a.exr": exr(8, 4),
    "window.exr": exr(8, 4).replace(b"displayWindow", b"displayWindew"),
    "a.ktx": ktx(8, 4),
    "levels.ktx": ktx(8, 4, levels=4),
    "cube.ktx": ktx(8, 8, sides=6),
    "second.ktx": ktx2(8, 4),
    "packed.ktx": ktx2(8, 4, packed=True),
}
BROKEN: dict[str, bytes] = {
    "png.exr": png(),
    "png.ktx": png(),
    "exr.png": exr(8, 4),
    "ktx.png": ktx(8, 4),
    "large.EXR": exr(8, 4),
    "large.KTX": ktx(8, 4),
    "half.ktx": ktx(8, 4, kind=GL_RGBA16F),
    "srgb.ktx": ktx2(8, 4, kind=43),
    "cut.exr": exr(8, 4)[:-1],
    "packed.exr": exr(8, 4).replace(b"compression\0\1\0\0\0\0", b"compression\0\1\0\0\0\x0f"),
    "cut.ktx": ktx(8, 4)[:-8],
    "cut2.ktx": ktx2(8, 4)[:-8],
    "no_levels.ktx": ktx(8, 4, levels=0),
}
UNREAD: dict[str, bytes] = {
    "empty.exr": b"",
    "empty.ktx": b"",
    "deep.exr": exr_head(8, 4, version=2 | 0x800),
    "old.exr": exr_head(8, 4, version=1),
    "no_size.exr": exr_head(8, 4)[:60],
    "nothing.exr": exr_head(0, 4),
    "order.ktx": ktx(8, 4)[:12] + bytes(100),
    "smaller.ktx": ktx(8, 4).replace(struct.pack("<2I", 8, 4), struct.pack("<2I", 4, 4)),
    "deep.ktx": ktx(8, 4).replace(struct.pack("<3I", 8, 4, 0), struct.pack("<3I", 8, 4, 2)),
    "supercompressed.ktx": ktx2(8, 4)[:44] + b"\1" + ktx2(8, 4)[45:],
}
MISREAD: dict[str, bytes] = {
    "1.bmp": picture("BMP", "1", 8, 4),
    "os2.bmp": b"BM" + struct.pack("<IHHIIHHHH", 26 + 24, 0, 0, 26, 12, 4, 2, 1, 24) + bytes(range(24)),
}
"""What SAPIEN shows other pixels of."""

UNBUILT: dict[str, bytes] = {
    "line.exr": exr(8, 4).replace(struct.pack("<iI", 2, 48), struct.pack("<iI", 2, 44)),
}
"""What only SAPIEN refuses."""

HUGE: dict[str, bytes] = {
    "stub.exr": exr_head(1 << 31, 1 << 30, left=-(1 << 31)),
    "wide.exr": exr_head(1 << 20, 1 << 16),
}


def told(folder: Path, name: str, data: bytes, **environment: Any) -> list[str]:
    path = folder / name
    path.write_bytes(data)
    ball = {"visuals": [{"type": "sphere", "radius": 0.1, "material": "paint"}], "body_type": "none"}
    materials = {"paint": {"visual": {"base_color_texture": str(path)}}}
    scene = {"scenecc": 1, "entities": {"ball": ball}, "materials": materials, **environment}
    return [found.code for found in validate(scene, asset_roots=[folder])]


@pytest.mark.parametrize("name", UNBUILT)
def test_the_checks_pass_images_that_the_build_refuses(tmp_path: Path, name: str) -> None:
    assert told(tmp_path, name, UNBUILT[name]) == []


@pytest.mark.parametrize("name", GOOD)
def test_valid_images_are_accepted(tmp_path: Path, name: str) -> None:
    assert told(tmp_path, name, GOOD[name]) == []
    size = check_image((tmp_path / name).read_bytes(), 2**24, Path(name).suffix)
    assert (size.columns, size.rows) == ((8, 8) if name == "cube.ktx" else (8, 4))


def test_a_big_endian_ktx_is_accepted(tmp_path: Path) -> None:
    assert told(tmp_path, "a.ktx", ktx(8, 4, levels=2, order=">")) == []


@pytest.mark.parametrize("name", BROKEN | UNREAD | MISREAD)
def test_invalid_images_are_refused(tmp_path: Path, name: str) -> None:
    assert told(tmp_path, name, (BROKEN | UNREAD | MISREAD)[name]) == ["SC420"]


@pytest.mark.parametrize("name", HUGE)
def test_images_above_the_limit_of_bytes_are_refused(tmp_path: Path, name: str) -> None:
    assert told(tmp_path, name, HUGE[name]) == ["SC607"]
    path = tmp_path / name
    scene = {"scenecc": 1, "entities": {}, "environment": {"map": str(path)}}
    assert "SC607" in [found.code for found in validate(scene, asset_roots=[tmp_path])]


SKIES: dict[str, tuple[bytes, list[str]]] = {
    "cube.ktx": (ktx(8, 8, sides=6, levels=4), []),
    "few.ktx": (ktx(8, 8, sides=6, levels=2), ["SC554"]),
    "flat.ktx": (ktx(8, 4, levels=4), ["SC554"]),
    "tall.ktx": (ktx(8, 4, sides=6, levels=4), ["SC554"]),
    "a.exr": (exr(8, 4), []),
    "square.exr": (exr(8, 8), ["SC554"]),
}


@pytest.mark.parametrize("name", SKIES)
def test_environment_maps_are_checked(tmp_path: Path, name: str) -> None:
    data, codes = SKIES[name]
    path = tmp_path / name
    path.write_bytes(data)
    scene = {"scenecc": 1, "entities": {}, "environment": {"map": str(path)}}
    assert [found.code for found in validate(scene, asset_roots=[tmp_path])] == codes


@pytest.mark.parametrize(("levels", "codes"), [(4, []), (2, ["SC553"])])
def test_sides_of_a_cube_map_are_checked(tmp_path: Path, levels: int, codes: list[str]) -> None:
    path = tmp_path / "side.ktx"
    path.write_bytes(ktx(8, 8, levels=levels))
    sides = dict.fromkeys(("px", "nx", "py", "ny", "pz", "nz"), str(path))
    scene = {"scenecc": 1, "entities": {}, "environment": {"map": sides}}
    assert [found.code for found in validate(scene, asset_roots=[tmp_path])] == codes


@pytest.mark.render
@pytest.mark.parametrize("name", GOOD | BROKEN | UNBUILT)
def test_sapien_accepts_the_same_images(tmp_path: Path, name: str) -> None:
    from sapien.render import RenderTexture2D

    path = tmp_path / name
    path.write_bytes((GOOD | BROKEN | UNBUILT)[name])
    if name not in GOOD:
        with pytest.raises(RuntimeError):
            RenderTexture2D(str(path))
        return
    texture = RenderTexture2D(str(path))
    size = check_image(path.read_bytes(), 2**24, path.suffix)
    assert (texture.width, texture.height) == (size.columns, size.rows)
    assert texture.format == ("R16G16B16A16Sfloat" if name.endswith(".exr") else "R8G8B8A8Unorm")


GREY = {
    **{f"{mode}.png": picture("PNG", mode, 8, 4) for mode in ("L", "1", "I;16")},
    "L.jpg": picture("JPEG", "L", 8, 4),
    "L.tga": picture("TGA", "L", 8, 4),
}
COLORED = {
    **{f"{mode}.png": picture("PNG", mode, 8, 4) for mode in ("LA", "P", "RGB", "RGBA")},
    "key.png": picture("PNG", "L", 8, 4, transparency=0),
    "L.bmp": picture("BMP", "L", 8, 4),
    "LA.tga": picture("TGA", "LA", 8, 4),
    "RGB.jpg": picture("JPEG", "RGB", 8, 4),
}


@pytest.mark.parametrize("name", GREY | COLORED)
def test_grey_textures_are_reported(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes((GREY | COLORED)[name])
    material = {"base_color_texture": str(path), "roughness_texture": str(path)}
    visual = {"type": "sphere", "radius": 1, "material": {"visual": material}}
    scene = {"scenecc": 1, "entities": {"ball": {"body_type": "none", "visuals": [visual]}}}
    found = [(one.code, one.severity, one.path) for one in validate(scene, asset_roots=[tmp_path])]
    place = "entities.ball.visuals[0].material.visual.base_color_texture"
    assert found == ([("SC424", "warning", place)] if name in GREY else [])


def test_a_grey_texture_that_is_also_used_elsewhere_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "L.png"
    path.write_bytes(GREY[path.name])
    material = {"base_color_texture": str(path), "emission_texture": str(path)}
    visual = {"type": "sphere", "radius": 1, "material": {"visual": material}}
    scene = {"scenecc": 1, "entities": {"ball": {"body_type": "none", "visuals": [visual]}}}
    found = {one.path: one.message.partition("only: as ")[2] for one in validate(scene, asset_roots=[tmp_path])}
    place = "entities.ball.visuals[0].material"
    assert found == {
        f"{place}.visual.base_color_texture": "base_color_texture, the shape is invisible",
        place: "emission_texture, there is no emission",
    }


@pytest.mark.render
@pytest.mark.parametrize("name", GREY | COLORED)
def test_sapien_loads_grey_textures_with_one_channel(tmp_path: Path, name: str) -> None:
    from sapien.render import RenderTexture2D

    (tmp_path / name).write_bytes((GREY | COLORED)[name])
    assert RenderTexture2D(str(tmp_path / name)).channels == (1 if name in GREY else 4)
