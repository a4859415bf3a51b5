"""Pictures to their last byte: whole ones are taken, and what is cut short or damaged is not."""

from __future__ import annotations

import io
import random
from pathlib import Path

import pytest
from plugins.image_files import PICTURES, hdr, picture

from scenecc.checks.images import JpegBlockBudget, check_image
from scenecc.checks.mesh_data import AssetError

LIMIT = 2**24


def refused(data: bytes) -> bool:
    try:
        check_image(io.BytesIO(data), LIMIT)
    except AssetError as error:
        return error.code in {"SC420", "SC607"}
    return False


@pytest.mark.parametrize("name", PICTURES)
def test_whole_ones_are_taken_and_no_beginning_of_one(name: str) -> None:
    data = PICTURES[name]
    assert not refused(data)
    footer = 26 if name.endswith(".tga") else 0
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


def test_damage_in_a_png() -> None:
    data = PICTURES["rgb.png"]
    for at in range(8, len(data)):
        assert refused(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]), at


def test_pixels_of_another_picture() -> None:
    """Sizes that are not those of the pixels behind them."""
    for name in ("rgb.bmp", "rgb.tga"):
        other = bytearray(PICTURES[name])
        at = 18 if name.endswith("bmp") else 12
        other[at] = 200
        assert refused(bytes(other))
    assert refused(PICTURES["packed.hdr"].replace(b"+X 16", b"+X 17"))
    assert refused(PICTURES["packed.hdr"].replace(b"-Y 3", b"-Y 4"))
    assert refused(hdr(4, 3, packed=False).replace(b"-Y 3 +X 4", b"+X 4 -Y 3"))


def test_codes_of_a_jpeg() -> None:
    data = PICTURES["grey.jpg"]
    start = data.index(b"\xff\xda") + 10
    assert refused(data[:start] + b"\xff\x00" * 40 + data[start:])
    restarts = PICTURES["restarts.jpg"]
    assert refused(restarts.replace(b"\xff\xd1", b"\xff\xd2"))
    at = restarts.index(b"\xff\xd1")
    assert refused(restarts[:at] + restarts[restarts.index(b"\xff\xd2") :])


@pytest.mark.render
def test_what_is_taken_is_what_sapiens_reader_takes(tmp_path: Path, held_renderer: None) -> None:
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
        RenderTexture2D(str(path))
        taken += 1
    assert taken > 100


def test_a_jpeg_that_is_known_takes_as_much_of_the_budget_and_one_beyond_it_is_not_known() -> None:
    data = picture("JPEG", "RGB", 120, 40)
    damaged = data[:-40] + bytes(38) + data[-2:]  # only its pixels

    def left(content: bytes, budget: int) -> int:
        blocks = JpegBlockBudget(budget)
        check_image(io.BytesIO(content), LIMIT, blocks=blocks)
        return blocks.left

    assert left(damaged, 1) < 0  # its headers are fine
    with pytest.raises(AssetError):
        left(damaged, 10_000)
    assert left(data, 10_000) == left(data, 10_000) < 10_000
    assert left(data, 1) < 0
