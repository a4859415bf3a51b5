"""Pictures to their last byte: whole ones are taken, and what is cut short or damaged is not."""

from __future__ import annotations

import io
import json
import random
import struct
import zlib
from contextlib import suppress
from pathlib import Path

import pytest
from PIL import Image
from plugins.image_files import PICTURES, hdr, picture
from unit.assets.test_assets import png

from scenecc import validate
from scenecc.assets.errors import AssetError
from scenecc.assets.images import check_image

LIMIT = 2**24


def refused(data: bytes) -> bool:
    try:
        check_image(data, LIMIT)
    except AssetError as error:
        return error.code in {"SC420", "SC607"}
    return False


@pytest.mark.parametrize("name", PICTURES)
def test_complete_images_are_accepted_and_truncated_ones_refused(name: str) -> None:
    data = PICTURES[name]
    assert not refused(data)
    footer = {".tga": 26, ".png": 4, ".bmp": 3}.get(Path(name).suffix, 0)  # what no pixel needs
    assert all(refused(data[:end]) for end in range(len(data) - footer))


@pytest.mark.parametrize("how", [{}, {"progressive": True}, {"subsampling": 0}, {"optimize": True}, {"quality": 100}])
@pytest.mark.parametrize("mode", ["RGB", "L", "CMYK"])
@pytest.mark.parametrize("size", [(1, 1), (8, 8), (17, 40), (100, 61)])
def test_jpegs_of_all_kinds_are_taken(mode: str, size: tuple[int, int], how: dict[str, object]) -> None:
    assert not refused(picture("JPEG", mode, *size, **how))


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "LA", "P", "1", "I;16"])
@pytest.mark.parametrize("size", [(1, 1), (7, 3), (300, 200)])
def test_pngs_of_all_kinds_are_taken(mode: str, size: tuple[int, int]) -> None:
    assert not refused(picture("PNG", mode, *size))


def test_a_png_with_any_damaged_byte_is_refused() -> None:
    data = PICTURES["rgb.png"]
    for at in range(8, len(data) - 12):
        assert refused(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]), at


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def test_a_png_whose_pixels_do_not_end_is_refused() -> None:
    """Pillow needs no end. SAPIEN unpacks zeros behind it, until it hangs at 2 GB."""
    data = PICTURES["rgb.png"]
    start, end = data.index(b"IDAT") - 4, len(data) - 12
    pixels = zlib.decompress(data[start + 8 :])
    for packer, rest in ((zlib.compressobj(), b""), (zlib.compressobj(0), b"\0\0"), (zlib.compressobj(), b"\xff")):
        packed = packer.compress(pixels) + packer.flush(zlib.Z_SYNC_FLUSH) + rest
        assert refused(data[:start] + chunk(b"IDAT", packed) + data[end:])


@pytest.mark.parametrize(
    ("before", "rows", "wrong"),
    [(b"", 3, False), (b"", 2**16, True), (chunk(b"CgBI", bytes(4)), 1, True)],
    ids=["some", "many", "unpacked otherwise"],
)
def test_a_png_with_more_rows_than_its_header_is_refused(before: bytes, rows: int, *, wrong: bool) -> None:
    """Pillow stops at the last row. SAPIEN unpacks them all, in its own process, and hangs at 2 GB."""
    data = PICTURES["rgb.png"]
    start, end = data.index(b"IDAT") - 4, len(data) - 12
    (columns,) = struct.unpack_from(">I", data, 16)
    size = struct.unpack_from(">I", data, start)[0]
    pixels = zlib.decompress(data[start + 8 : start + 8 + size])
    packed = zlib.compress(pixels + bytes(rows * (1 + 3 * columns)))
    assert refused(data[:start] + before + chunk(b"IDAT", packed) + data[end:]) == wrong


def test_an_image_whose_size_does_not_match_its_pixels_is_refused() -> None:
    """Sizes that are not those of the pixels behind them."""
    for name in ("rgb.bmp", "rgb.tga"):
        other = bytearray(PICTURES[name])
        at = 18 if name.endswith("bmp") else 12
        other[at] = 200
        assert refused(bytes(other))
    assert refused(PICTURES["packed.hdr"].replace(b"+X 16", b"+X 17"))
    assert refused(PICTURES["packed.hdr"].replace(b"-Y 3", b"-Y 4"))
    assert refused(hdr(4, 3, packed=False).replace(b"-Y 3 +X 4", b"+X 4 -Y 3"))


def test_a_damaged_jpeg_is_refused() -> None:
    """Where Pillow reports it: of other codes in the middle of the pixels it does not."""
    for name in ("rgb.jpg", "progressive.jpg", "restarts.jpg"):
        data = PICTURES[name]
        scan = data.index(b"\xff\xda")
        assert refused(data[: len(data) // 2]), name
        assert refused(data[:scan] + data[-2:]), name
        assert refused(data[: scan + 30] + b"\xff\xd8" + data[scan + 32 :]), name
        assert refused(data.replace(b"\xff\xc4", b"\xff\xc5", 1)), name


def test_a_jpeg_of_many_scans_is_refused() -> None:
    data = PICTURES["progressive.jpg"]
    last = data.rindex(b"\xff\xda")
    repeated = data[last:-2] * 200
    assert refused(data[:-2] + repeated + data[-2:])


def test_the_size_is_checked_before_pillows_own_limit() -> None:
    """`PIL.Image.open` warns of the first and refuses the second in other words."""
    for side, code in ((10_000, "SC420"), (20_000, "SC607")):
        with pytest.raises(AssetError) as caught:
            check_image(png(side, side), 2**30)
        assert caught.value.code == code


@pytest.mark.parametrize("kind", ["GIF", "TIFF", "WEBP", "PPM", "ICO"])
def test_other_image_formats_that_pillow_reads_are_refused(kind: str) -> None:
    assert refused(picture(kind, "RGB", 16, 16))


def test_a_damaged_image_is_refused_beside_any_number_of_others(tmp_path: Path) -> None:
    """More pixels than scenecc once decoded for one scene."""
    large = picture("JPEG", "L", 64, 64).replace(struct.pack(">HH", 64, 64), struct.pack(">HH", 4000, 4000))
    with pytest.raises(AssetError):
        check_image(large, LIMIT)
    file = io.BytesIO()
    Image.new("L", (4000, 4000)).save(file, "JPEG")
    visuals, materials = [], {}
    for i, data in enumerate([*[file.getvalue()] * 5, PICTURES["rgb.jpg"][:-40]]):
        (tmp_path / f"{i}.jpg").write_bytes(data + b"\0" * i)
        materials[f"m{i}"] = {"visual": {"roughness_texture": f"{i}.jpg"}}
        visuals.append({"type": "sphere", "radius": 0.1, "material": f"m{i}"})
    scene = {"scenecc": 1, "entities": {"ball": {"body_type": "none", "visuals": visuals}}, "materials": materials}
    (tmp_path / "scene.yaml").write_text(json.dumps(scene))
    found = validate(tmp_path / "scene.yaml")
    assert [(one.code, one.path) for one in found] == [("SC420", "materials.m5.visual.roughness_texture")]


@pytest.mark.render
def test_accepted_images_are_loaded_or_reported_by_sapien(tmp_path: Path, held_renderer: None) -> None:
    from sapien.render import RenderTexture2D

    how = random.Random(5)
    taken = 0
    for i in range(1500):
        name = how.choice(sorted(PICTURES))
        data = bytearray(PICTURES[name])
        for _ in range(how.choice([1, 1, 3])):
            at = how.randrange(2, len(data))
            data[at : at + how.choice([1, 1, 4])] = how.randbytes(how.choice([0, 1, 1, 4]))
        if refused(bytes(data)):
            continue
        path = tmp_path / f"{i}{Path(name).suffix}"
        path.write_bytes(data)
        with suppress(RuntimeError):
            RenderTexture2D(str(path))
        taken += 1
    assert taken > 100
