"""Doubtful meshes: each rule on a mesh that breaks it, and on one that does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from scenecc import check_scene, compile_scene, load_scene
from scenecc.assets.surface_measures import measure_surface


@pytest.fixture(autouse=True)
def _empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    measure_surface.cache_clear()


def box(**changes: Any) -> trimesh.Trimesh:
    """A cube of 0.2 m. `changes`: `faces`, what is done to its triangles; `move`, to its corners."""
    mesh = trimesh.creation.box((0.2, 0.2, 0.2))
    faces, vertices = np.array(mesh.faces), np.array(mesh.vertices)
    faces = changes["faces"](faces) if "faces" in changes else faces
    vertices = changes["move"](vertices) if "move" in changes else vertices
    return trimesh.Trimesh(vertices, faces, process=False)


def cup() -> trimesh.Trimesh:
    profile = [[0, 0], [0.05, 0], [0.05, 0.1], [0.048, 0.1], [0.048, 0.002], [0, 0.002]]
    return trimesh.creation.revolve(np.array(profile), sections=32)


def found(folder: Path, mesh: Any, shape: str, body: str = "body_type: static") -> list[tuple[str, int]]:
    """Codes and lines of a scene with one shape of a mesh on line 6."""
    mesh.export(folder / "mesh.ply")
    lines = [
        "scenecc: 1", "physics: {gravity: [0, 0, 0]}", "entities:", "  thing:", f"    {body}",
        f"    {shape}",
    ]  # fmt: skip
    (folder / "scene.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    diagnostics = check_scene(folder / "scene.yaml", settle=0)
    return [(d.code, d.line or 0) for d in diagnostics if d.code != "SC542"]  # it is not seen


COLLIDES = "collisions: [{{type: {}, file: mesh.ply{}}}]"
TRIANGLES = COLLIDES.format("triangle_mesh", "")
FIELD = COLLIDES.format("triangle_mesh", ", sdf: true")
HULL = COLLIDES.format("convex_mesh", "")
SEEN = "visuals: [{type: mesh, file: mesh.ply}]"

FAULTS = {
    "SC434": (box(faces=lambda faces: faces[1:]), FIELD, "body_type: static"),
    "SC435": (box(faces=lambda faces: faces[:, ::-1]), TRIANGLES, "body_type: static"),
    "SC436": (box(faces=lambda faces: np.vstack([faces, faces[:3, [0, 1, 1]]])), TRIANGLES, "body_type: static"),
    "SC437": (box(move=lambda vertices: vertices * 400), HULL, "body_type: dynamic"),
    "SC438": (box(move=lambda vertices: vertices + 9), HULL, "body_type: dynamic"),
    "SC439": (cup(), HULL, "body_type: dynamic"),
    "SC440": (box(move=lambda vertices: np.vstack([vertices, [0, 0, 1]])), HULL, "body_type: dynamic"),
}


@pytest.mark.parametrize("code", FAULTS)
def test_a_mesh_fault_is_reported_at_the_file_of_the_shape(code: str, tmp_path: Path) -> None:
    assert found(tmp_path, *FAULTS[code]) == [(code, 6)]


@pytest.mark.parametrize(
    ("mesh", "shape", "body"),
    [
        (box(), FIELD, "body_type: static"),
        (box(), HULL, "body_type: dynamic"),
        (FAULTS["SC434"][0], TRIANGLES, "body_type: static"),
        (FAULTS["SC434"][0], SEEN, "body_type: static"),
        (FAULTS["SC435"][0], HULL, "body_type: dynamic"),
        (FAULTS["SC435"][0], SEEN, "body_type: static"),
        (FAULTS["SC437"][0], TRIANGLES, "body_type: static"),
        (FAULTS["SC438"][0], TRIANGLES, "body_type: static"),
        (cup(), TRIANGLES, "body_type: static"),
        (FAULTS["SC440"][0], TRIANGLES, "body_type: static"),
        (box(move=lambda vertices: np.vstack([vertices, [0, 0, 0.05]])), HULL, "body_type: dynamic"),
    ],
)
def test_mesh_faults_without_effect_on_a_use_are_not_reported(
    mesh: trimesh.Trimesh, shape: str, body: str, tmp_path: Path
) -> None:
    assert found(tmp_path, mesh, shape, body) == []


def test_convex_parts_that_fill_hollows_are_reported(tmp_path: Path) -> None:
    parts = COLLIDES.format("convex_parts", "")
    two = trimesh.util.concatenate([box(), box(move=lambda vertices: vertices + 1)])
    assert found(tmp_path, cup(), parts, "body_type: dynamic") == [("SC439", 6)]
    assert found(tmp_path, two, parts, "body_type: dynamic") == []
    assert found(tmp_path, two, HULL, "body_type: dynamic") == [("SC439", 6)]


def test_inconsistent_winding_is_reported(tmp_path: Path) -> None:
    turned = box(faces=lambda faces: np.vstack([faces[:1, ::-1], faces[1:]]))
    assert found(tmp_path, turned, TRIANGLES) == [("SC435", 6)]


def test_a_mesh_of_micrometres_is_reported(tmp_path: Path) -> None:
    assert found(tmp_path, box(move=lambda vertices: vertices / 2500), SEEN) == [("SC437", 6)]


def test_visuals_away_from_collision_are_reported_in_each_scene(tmp_path: Path) -> None:
    shape = "collisions: [{type: convex_mesh, file: mesh.ply}], visuals: [{type: mesh, file: mesh.ply, pose: %s}]"
    for pose, expected in (
        ("[0.3, 0, 0]", ["SC441"]),
        ("{per_scene: [[0, 0, 0], [0, 0, 1]]}", ["SC441"]),
        ("[0.1, 0, 0]", ["SC441"]),
        ("[0.01, 0, 0]", ["SC441"]),
        ("{rpy_deg: [0, 0, 180]}", ["SC441"]),
        ("[0.001, 0, 0]", []),
    ):
        box().export(tmp_path / "mesh.ply")
        scenes = 2 if "per_scene" in pose else 1
        text = f"scenecc: 1\nnum_scenes: {scenes}\nentities:\n  thing: {{body_type: static, {shape % pose}}}\n"
        (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
        diagnostics = check_scene(tmp_path / "scene.yaml", settle=0)
        assert [d.code for d in diagnostics] == expected
        assert all((d.line, d.column) == (4, 3) for d in diagnostics)


def test_the_visual_of_a_mesh_is_compared_beside_other_shapes(tmp_path: Path) -> None:
    for scale, codes in (("1", ["SC441"]), ("0.5", [])):
        box().export(tmp_path / "mesh.ply")
        mesh = f"{{type: mesh, file: mesh.ply, pose: [0.02, 0, 0], scale: [{scale}, {scale}, {scale}]}}"
        ball = "{type: sphere, radius: 0.05}"
        shapes = f"collisions: [{{type: convex_mesh, file: mesh.ply}}, {ball}], visuals: [{ball}, {mesh}]"
        text = f"scenecc: 1\nentities:\n  thing: {{body_type: static, {shapes}}}\n"
        (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
        assert [one.code for one in check_scene(tmp_path / "scene.yaml", settle=0)] == codes


def test_loose_vertices_count_as_in_the_engine(tmp_path: Path) -> None:
    """SAPIEN's hull goes around those of a PLY; the reader of other formats leaves them out."""
    mesh = FAULTS["SC440"][0]
    heights: dict[str, float] = {}
    for suffix in ("ply", "obj", "glb"):
        mesh.export(tmp_path / f"mesh.{suffix}")
        shape = {"type": "convex_mesh", "file": str(tmp_path / f"mesh.{suffix}")}
        scene = {"scenecc": 1, "entities": {"thing": {"body_type": "static", "shapes": [shape]}}}
        with load_scene(scene, render=False, asset_roots=[tmp_path], allow_outside_assets=True) as batch:
            (component,) = batch.scenes[0].physx_system.get_rigid_static_components()
            heights[suffix] = float(component.get_global_aabb_fast()[1][2])
    assert heights == pytest.approx({"ply": 1.0, "obj": 0.1, "glb": 0.1})


@pytest.mark.parametrize(("away", "size", "codes"), [(0.15, 0.1, []), (0.5, 0.1, ["SC442"]), (0.5, 0.01, [])])
def test_a_large_visual_without_collision_is_reported(
    away: float, size: float, codes: list[str], tmp_path: Path
) -> None:
    box().export(tmp_path / "mesh.ply")
    collisions = "collisions: [{type: convex_mesh, file: mesh.ply}]"
    part = f"{{type: sphere, radius: {size}, pose: [0, 0, {away}]}}"
    text = f"scenecc: 1\nentities:\n  thing:\n    body_type: static\n    {collisions}\n    visuals:\n"
    text += f"      - {{type: mesh, file: mesh.ply}}\n      - {part}\n"
    (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
    found = check_scene(tmp_path / "scene.yaml", settle=0)
    assert [(d.code, d.line) for d in found] == [(code, 8) for code in codes]


def test_file_names_that_differ_only_in_case_are_reported(tmp_path: Path) -> None:
    for name in ("mesh.ply", "Mesh.ply"):
        box().export(tmp_path / name)
    shapes = "shapes: [{type: convex_mesh, file: mesh.ply}, {type: convex_mesh, file: Mesh.ply, pose: [1, 0, 0]}]"
    (tmp_path / "scene.yaml").write_text(
        f"scenecc: 1\nentities:\n  thing: {{body_type: static, {shapes}}}\n", encoding="utf-8"
    )
    assert [(d.code, d.line) for d in check_scene(tmp_path / "scene.yaml", settle=0)] == [("SC443", 3)]


def test_surface_measures_of_a_box_are_exact(tmp_path: Path) -> None:
    box().export(tmp_path / "mesh.ply")
    text = f"scenecc: 1\nentities:\n  thing: {{body_type: static, {HULL}}}\n"
    (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
    (file,) = compile_scene(tmp_path / "scene.yaml").files
    found = measure_surface(file)
    assert found.volume == pytest.approx(0.008)
    assert found.hull_volume == pytest.approx(0.008, rel=0.01)
    assert found.is_watertight
    assert found.consistent
    assert (found.faces, found.degenerate, found.unused) == (12, 0, 0)
