"""Terrain and rings: what may not be built is found before anything is."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any

import pytest

import scenecc

if TYPE_CHECKING:
    from pathlib import Path


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def picture(columns: int, rows: int) -> bytes:
    """A black grey PNG of 8 bits."""
    header = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    packed = zlib.compress((b"\0" + bytes(columns)) * rows)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def terrain(count: int = 1, **keys: Any) -> dict[str, Any]:
    shape = {"type": "heightfield", "size": [4, 4, 1], **keys}
    entity = {"repeat": {"i": {"count": count}}, "name": "hill${i}", "body_type": "static", "shapes": [shape]}
    return {"scenecc": 1, "entities": {"hill": entity}}


def told(scene: dict[str, Any], **options: Any) -> list[str]:
    return [f"{d.code} {d.message}" for d in scenecc.validate(scene, **options)]


@pytest.mark.parametrize(
    ("size", "heights", "words"),
    [
        ([4, 4, 1e38], [[0, 0], [0, 1e38]], "reaches 1e+76 m"),
        ([4, 4, {"uniform": [1, 1e7]}], [[0, 0], [0, 1]], "reaches 1e+07 m"),
        ([1e-20, 1, 1], [[0, 0], [0, 1]], "is smaller than"),
        ([1, 1, 1], [[0, 0], [0]], "row 0 has 2 heights, and row 1 has 1"),
    ],
)
def test_terrain_beyond_the_engines_range_is_refused(size: Any, heights: Any, words: str) -> None:
    (found,) = told(terrain(size=size, heights=heights))
    assert found.startswith("SC529")
    assert words in found


def test_each_use_of_a_height_picture_counts_towards_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hill.png").write_bytes(picture(512, 512))
    assert told(terrain(16, file="hill.png")) == []
    found = told(terrain(17, file="hill.png"))
    assert len(found) == 1
    assert "all terrain of the scene has more than 4194304 heights" in found[0]


@pytest.mark.parametrize("columns", [0, 513])
def test_a_height_picture_of_bad_size_is_refused_by_its_header(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hill.png").write_bytes(picture(columns, 600))
    (found,) = told(terrain(file="hill.png"))
    assert "it has no pixels" in found or "pixels, but a heightfield may have at most" in found


def test_the_lightest_ring_has_the_widest_hole() -> None:
    radii = {"outer_radius": {"uniform": [0.001, 0.002]}, "inner_radius": {"uniform": [0.0005, 0.000998]}}
    shape = {"type": "ring", **radii, "half_length": 0.0005}
    found = told({"scenecc": 1, "num_scenes": 256, "entities": {"washer": {"shapes": [shape]}}})
    assert [line[:5] for line in found] == ["SC511"]


@pytest.mark.parametrize(
    ("shape", "hint"),
    [
        ({"heights": [[0, {"uniform": [0, 1]}], [0, 0]]}, "use `variants` of the entity"),
        ({"heights": {"per_scene": [[[0, 0], [0, 0]]]}}, "use `variants` of the entity"),
        ({"file": {"choice": ["a.png", "b.png"]}}, "use `variants` of the entity"),
    ],
)
def test_varying_terrain_heights_are_refused(shape: dict[str, Any], hint: str) -> None:
    (found,) = scenecc.validate(terrain(**shape))
    assert found.code == "SC116"
    assert found.hint is not None
    assert found.hint.startswith(hint)


def test_a_link_with_terrain_cannot_be_made_static() -> None:
    shape = {"type": "heightfield", "size": [1, 1, 1], "heights": [[0, 1], [0, 0]]}
    root = {"name": "base", "shapes": [shape]}
    (found,) = scenecc.validate({"scenecc": 1, "entities": {"arm": {"root": root}}})
    assert (found.code, found.hint) == ("SC508", "use convex shapes")


@pytest.mark.parametrize(("top", "code"), [(1e7, "SC529"), (1.01e6, "SC514")])
def test_terrain_from_expressions_is_checked_by_rows_and_samples(top: float, code: str) -> None:
    scene = terrain(size=[4, 4, "${x}"], heights=[[0, 0], [0, 1]])
    (found,) = scenecc.validate({**scene, "draws": {"x": {"uniform": [1, top]}}})
    assert found.code == code
    assert "reaches " in found.message


def test_each_ring_of_a_plan_without_origins_is_checked() -> None:
    shape = {"type": "ring", "outer_radius": 0.1, "half_length": 0.1}
    rings = [{**shape, "inner_radius": 0.2}, {**shape, "inner_radius": 0.3}, {**shape, "inner_radius": 0.05}]
    found = told({"scenecc": 1, "entities": {"tube": {"shapes": rings}}})
    assert [one[:5] for one in found] == ["SC528", "SC528"]
