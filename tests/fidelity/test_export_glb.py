"""A GLB's shapes are where SAPIEN renders them: the boxes around every body of the examples."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

import scenecc
from scenecc import export_scene

ROOT = Path(__file__).parents[2]
Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def boxes(data: bytes) -> dict[str, np.ndarray]:
    """Around the shapes right below each node: (2, 3) in the scene's frame."""
    scene = trimesh.load_scene(io.BytesIO(data), file_type="glb")
    points: dict[str, list[np.ndarray]] = {}
    for node in scene.graph.nodes_geometry:
        place, geometry = scene.graph[node]
        shape = node.rpartition("/")[0]
        body = shape.rpartition("/")[0] if node.rpartition("/")[2].isdigit() else shape
        points.setdefault(body, []).append(trimesh.transform_points(scene.geometry[geometry].vertices, place) @ Y_UP)
    found = {body: np.concatenate(every) for body, every in points.items()}
    return {body: np.array([every.min(axis=0), every.max(axis=0)]) for body, every in found.items()}


def rendered(obj: Any) -> np.ndarray | None:
    """Around the triangles that SAPIEN renders of an entity: (2, 3); None where it renders none."""
    from sapien import render

    component = obj.find_component_by_type(render.RenderBodyComponent)
    points = []
    for shape in [] if component is None else component.render_shapes:
        match shape:
            case render.RenderShapeBox():
                scale = shape.half_size
            case render.RenderShapeSphere():
                scale = np.full(3, shape.radius)
            case render.RenderShapeCylinder():
                scale = np.array([shape.half_length, shape.radius, shape.radius])
            case render.RenderShapeCapsule():
                scale = np.ones(3)
            case _:
                scale = np.array(shape.scale)
        place = (obj.pose * shape.local_pose).to_transformation_matrix()
        points += [trimesh.transform_points(part.vertices * scale, place) for part in shape.parts]
    every = np.concatenate(points) if points else None
    return None if every is None else np.array([every.min(axis=0), every.max(axis=0)])


@pytest.mark.render
@pytest.mark.parametrize("name", ["tabletop", "materials", "knobs", "robot_door", "robot_arm", "constraints"])
def test_bodies_are_where_they_are_rendered(name: str) -> None:
    path = ROOT / "scenes" / f"{name}.yaml"
    drawn = boxes(next(iter(export_scene(path, "glb", name="out").values())))
    with scenecc.load_scene(path, scene_idxs=[0], render=True) as batch:
        seen: dict[str, Any] = {entity: bodies.objs[0] for entity, bodies in batch.entities.items()}
        for entity, robots in batch.articulations.items():
            seen |= {f"{entity}/{link.name}": link.entity for link in robots.objs[0].get_links()}
        found = {body: rendered(obj) for body, obj in seen.items()}
    there = {body: box for body, box in found.items() if box is not None}
    assert drawn.keys() == there.keys()
    for body, box in there.items():
        assert_allclose(drawn[body], box, rtol=1e-6, atol=2e-6, err_msg=body)
