"""Terrain in MJCF, and flat meshes, as MuJoCo reads them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import scenecc
from scenecc.geometry.surfaces import heightfield_surface

if TYPE_CHECKING:
    from pathlib import Path

mujoco: Any = pytest.importorskip("mujoco")

POSE = (0.3, -0.2, 0.5)
SIZE = (4.0, 3.0, 0.8)
HEIGHTS = ((0.0, 0.7, 0.2, 0.9), (0.4, -0.5, 0.6, 0.1), (0.8, 0.3, -0.2, 0.5))


def compile_exported(scene: dict[str, Any] | Path) -> tuple[Any, list[str]]:
    emitted = scenecc.open_scene(scene).emit("mjcf")
    name, *others = emitted.files
    files = {one: emitted.files[one] for one in others}
    return mujoco.MjModel.from_xml_string(emitted.files[name].decode(), files), [d.message for d in emitted.diagnostics]


def hill(heights: Any = HEIGHTS, **others: Any) -> dict[str, Any]:
    shape = {"type": "heightfield", "size": list(SIZE), "heights": [list(row) for row in heights]}
    body = {"body_type": "static", "pose": list(POSE), "shapes": [shape]}
    return {"scenecc": 1, "entities": {"hill": body, **others}}


def level(vertices: Any, triangles: Any, x: float, y: float) -> float:
    """The height of a surface of triangles over a point."""
    for corners in vertices[triangles]:
        edges = np.stack([corners[1] - corners[0], corners[2] - corners[0]], axis=1)
        s, t = np.linalg.solve(edges[:2], np.array([x, y]) - corners[0, :2])
        if min(s, t) >= 0 and s + t <= 1:
            return float(corners[0, 2] + edges[2] @ (s, t))
    raise AssertionError((x, y))


def test_mujoco_terrain_has_the_triangles_of_sapien() -> None:
    model, messages = compile_exported(hill())
    assert messages == []
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    vertices, triangles, *_ = heightfield_surface(SIZE, HEIGHTS)
    for x, y in np.random.default_rng(3).uniform([-1.95, -1.45], [1.95, 1.45], (200, 2)):
        start, hit = np.array([x, y, 5.0]) + POSE, np.array([-1], np.int32)
        collides = np.array([0, 0, 0, 1, 0, 0], np.uint8)
        distance = mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, -1.0]), collides, 1, -1, hit)
        assert 5.0 - distance == pytest.approx(level(vertices, triangles, x, y), abs=2e-6)


def test_a_ball_on_mujoco_terrain_comes_to_rest_as_in_sapien() -> None:
    bowl = ((1.0, 1.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0))
    ball = {"shapes": [{"type": "sphere", "radius": 0.2}], "pose": [0.4, -0.3, 1.8], "angular_damping": 5}
    scene = hill(bowl, ball=ball)
    model, _ = compile_exported(scene)
    data = mujoco.MjData(model)
    batch = scenecc.load_scene(scene, render=False)
    for _ in range(1500):
        batch.step()
        mujoco.mj_step(model, data)
    place = batch.entities["ball"].pose[0, :3]
    assert data.body("ball").xpos == pytest.approx(place, abs=0.01)
    assert place[2] == pytest.approx(POSE[2] + 0.2, abs=0.05)


def test_flat_terrain_collides() -> None:
    model, messages = compile_exported(hill(((0, 0), (0, 0))))
    assert messages == []
    assert model.ngeom == 2
    assert model.nhfield == 1


def test_a_flat_triangle_mesh_is_left_out_with_a_warning(tmp_path: Path) -> None:
    file = tmp_path / "floor.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
    floor = {"body_type": "static", "shapes": [{"type": "triangle_mesh", "file": "floor.obj"}]}
    path = tmp_path / "scene.yaml"
    path.write_text(f"scenecc: 1\nentities: {{floor: {floor}}}\n")
    model, messages = compile_exported(path)
    assert any("flat collision mesh" in message for message in messages)
    assert not model.geom_contype.any()
