"""Hulls that PhysX cooks with another volume than their files have are reported at the build."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from plugins.mesh_files import FACES, POINTS, TETRA, glb, ply, stl, stl_text, write
from unit.assets.test_mesh_dae import DAE

from scenecc import SceneError, check_scene, compile_scene, load_scene, validate
from scenecc.backends.sapien import instantiate
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.geometry.ply import encode_ply

NEEDLE = POINTS * [0.003, 0.003, 3]
"""0.3 mm thick and 30 cm long: PhysX makes it 1 mm thick."""

GOOD = {
    "a.obj": TETRA,
    "a.stl": stl(),
    "text.stl": stl_text(),
    "a.ply": ply(),
    "text.ply": ply(kind="ascii"),
    "big.ply": ply(kind="binary_big_endian"),
    "a.glb": glb(),
    "a.dae": DAE,
}


def entity(shape: str) -> str:
    """A body with a shape, whose file is named on the sixth line."""
    return f"entities:\n  a:\n    body_type: static\n    shapes:\n      - {shape}\n"


def found(folder: Path, text: str) -> list[Diagnostic]:
    """What a check reports of hulls and the engine, in a scene that is valid."""
    scene = write(folder, "scene.yaml", f"scenecc: 1\n{text}")
    assert not [one for one in validate(scene) if one.severity == "error"]
    return [one for one in check_scene(scene) if one.code in {"SC416", "SC423"} or one.code > "SC8"]


@pytest.mark.parametrize("name", GOOD)
def test_a_correctly_cooked_hull_is_not_reported(name: str, tmp_path: Path) -> None:
    write(tmp_path, name, GOOD[name])
    shapes = [f"{{type: convex_mesh, file: {name}}}"]
    if not name.endswith(".stl"):  # which has no parts (SC421)
        shapes.append(f"{{type: convex_parts, file: {name}}}")
    assert found(tmp_path, entity("\n      - ".join(shapes))) == []


def test_vertices_that_no_triangle_uses_belong_to_the_hull_of_a_ply(tmp_path: Path) -> None:
    """As SAPIEN takes them. Of an OBJ it takes those of triangles."""
    points = np.concatenate([POINTS, POINTS + 1])
    write(tmp_path, "a.ply", encode_ply(points, FACES))
    write(tmp_path, "a.obj", TETRA + "v 1 1 1\nv 1 1 2\n")
    for name in ("a.ply", "a.obj"):
        assert found(tmp_path, entity(f"{{type: convex_mesh, file: {name}}}")) == []


@pytest.mark.parametrize(("kind", "whose"), [("convex_mesh", "hull to 1111% of its"), ("convex_parts", "hulls to")])
def test_a_needle_that_is_cooked_thicker_is_reported(kind: str, whose: str, tmp_path: Path) -> None:
    write(tmp_path, "needle.ply", ply(NEEDLE))
    (one,) = found(tmp_path, entity(f"{{type: {kind}, file: needle.ply}}"))
    assert (one.code, one.line, one.column, one.path) == ("SC423", 6, 24 + len(kind), "entities.a.shapes[0].file")
    assert f"needle.ply: PhysX cooks the {whose}" in one.message
    assert one.hint is not None
    assert "`scale`" in one.hint


@pytest.mark.parametrize(("half", "codes"), [(0.0009, ["SC423"]), (0.003, ["SC416"]), (0.05, [])])
def test_a_ball_that_is_cooked_smaller_is_reported(half: float, codes: list[str], tmp_path: Path) -> None:
    ball = np.random.default_rng(0).normal(size=(300, 3))
    ball *= half / np.linalg.norm(ball, axis=1)[:, None]
    corners = np.arange(298)[:, None] + [0, 1, 2]
    write(tmp_path, "ball.ply", encode_ply(ball, corners))
    assert [one.code for one in found(tmp_path, entity("{type: convex_mesh, file: ball.ply}"))] == codes


@pytest.mark.parametrize("kind", ["convex_mesh", "convex_parts"])
def test_a_mesh_file_that_sapien_misreads_is_reported(kind: str, tmp_path: Path) -> None:
    """Its reader takes the number in the comment for a count."""
    write(tmp_path, "counting.ply", ply(kind="ascii").replace(b"comment made", b"comment 2"))
    (one,) = found(tmp_path, entity(f"type: {kind}\n        scale: 2\n        file: counting.ply"))
    assert (one.code, one.line, one.column) == ("SC423", 8, 15)
    assert one.message == "counting.ply: SAPIEN reads a different mesh: its hull has 30000% of the volume"
    assert one.hint == "export the mesh again, as GLB or OBJ"


def test_a_file_is_reported_once_for_each_use_in_the_order_of_shapes(tmp_path: Path) -> None:
    write(tmp_path, "needle.ply", ply(NEEDLE))
    shapes = ["convex_parts", "convex_mesh", "convex_mesh", "triangle_mesh", "convex_parts"]
    lines = [
        f"{name}: {{body_type: static, shapes: [{{type: {kind}, file: needle.ply}}]}}"
        for name, kind in enumerate(shapes)
    ]
    text = "entities:\n" + "".join(f"  e{line}\n" for line in lines)
    assert [(one.code, one.path) for one in found(tmp_path, text)] == [
        ("SC423", "entities.e0.shapes[0].file"),
        ("SC423", "entities.e1.shapes[0].file"),
    ]


@pytest.fixture
def two_scenes(tmp_path: Path) -> Path:
    """Two scenes, the second of which has a hull that is cooked to another."""
    write(tmp_path, "good.ply", ply())
    write(tmp_path, "needle.ply", ply(NEEDLE))
    varied = entity("{type: convex_mesh, file: {per_scene: [good.ply, needle.ply]}}")
    return write(tmp_path, "scene.yaml", f"scenecc: 1\nnum_scenes: 2\n{varied}")


def test_only_hulls_of_the_scenes_that_are_built_are_compared(two_scenes: Path) -> None:
    (one,) = check_scene(two_scenes)
    assert (one.code, one.line) == ("SC423", 7)
    assert one.message.startswith("needle.ply")
    load_scene(two_scenes, render=False, scene_idxs=[0]).close()
    with pytest.raises(SceneError, match=r"needle\.ply"):
        load_scene(two_scenes, render=False, scene_idxs=[1])


def test_every_file_of_an_entity_is_compared(two_scenes: Path) -> None:
    write(two_scenes.parent, "good.ply", ply(NEEDLE / 2))
    assert sorted(one.message[:8] for one in check_scene(two_scenes)) == ["good.ply", "needle.p"]


def test_a_hull_file_that_changed_after_the_check_is_reported(tmp_path: Path) -> None:
    """Its volume is not compared with that of another file."""
    write(tmp_path, "a.ply", ply())
    plan = compile_scene(write(tmp_path, "scene.yaml", "scenecc: 1\n" + entity("{type: convex_mesh, file: a.ply}")))
    write(tmp_path, "a.ply", ply(NEEDLE))
    sink = Sink()
    assert instantiate(plan, sink, render=False) is None
    assert [one.code for one in sink.diagnostics()] == ["SC422"]
