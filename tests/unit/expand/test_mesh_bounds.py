"""`bounds(PATH)` in expressions: numbers of meshes, against trimesh."""

from __future__ import annotations

import io
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from scenecc import compile_scene, open_scene, validate
from scenecc.plan.json_codec import plan_to_json

ASSETS = Path(__file__).resolve().parents[3] / "scenes" / "assets"
BOX = "body_type: kinematic, shapes: [{type: box, half_size: [1, 1, 1]}]"


def position(folder: Path, expression: str, before: str = "", **options: Any) -> Any:
    """What a position holds that an expression gives, (scenes, 3)."""
    entity = f'b: {{pose: {{p: "{expression}"}}, {BOX}}}'
    (folder / "scene.yaml").write_text(f"scenecc: 1\n{before}\nentities:\n  {entity}\n")
    return compile_scene(folder / "scene.yaml", **options).entities[0].pose.data[:, :3]


def text_stl(mesh: trimesh.Trimesh) -> str:
    lines = ["solid"]
    for triangle in mesh.triangles:
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid"])


@pytest.mark.parametrize("suffix", ["obj", "ply", "ascii.ply", "stl", "ascii.stl", "glb"])
def test_they_are_those_that_trimesh_reads(tmp_path: Path, suffix: str) -> None:
    random = np.random.default_rng(3)
    mesh = trimesh.Trimesh(random.normal(size=(40, 3)) + 0.1, random.integers(0, 40, size=(60, 3)), process=False)
    file = tmp_path / f"mesh.{suffix.rpartition('.')[2]}"
    match suffix:
        case "obj":
            rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
            file.write_text("\n".join([*rows, *(f"f {a} {b} {c}" for a, b, c in mesh.faces + 1)]) + "\n")
        case "ascii.stl":
            file.write_text(text_stl(mesh))
        case "ascii.ply":
            mesh.export(file, encoding="ascii")
            file.write_text(file.read_text().replace("property float", "property double"))
        case "glb":
            turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0.2, 0.3])
            trimesh.Scene({"part": mesh}).apply_transform(turn).export(file)
        case _:
            mesh.export(file)
    found = [position(tmp_path, f"${{bounds('{file.name}')[{corner}]}}")[0] for corner in (0, 1)]
    known = trimesh.load(file, process=False).bounds  # pyright: ignore[reportAttributeAccessIssue]
    assert np.array_equal(found, known) if suffix != "glb" else np.allclose(found, known, rtol=0, atol=1e-15)


def test_a_path_is_computed_of_parameters_and_loop_variables(tmp_path: Path) -> None:
    shutil.copy(ASSETS / "mug.obj", tmp_path)
    params = "params: {mesh: {type: file, default: mug.obj}, bounds: 2}"
    assert position(tmp_path, "${bounds(mesh)[1]}", params).tolist() == [[0.067, 0.04, 0.09]]
    assert position(tmp_path, "${bounds('mu' + 'g.obj')[1]}").tolist() == [[0.067, 0.04, 0.09]]
    assert position(tmp_path, "${[bounds( mesh )[1][2] * bounds, bounds, 0]}", params).tolist() == [[0.18, 2, 0]]
    loop = f"  c: {{repeat: {{name: [mug, cup]}}, pose: [0, 0, \"${{bounds(name + '.obj')[1][2]}}\"], {BOX}}}"
    shutil.copy(ASSETS / "bowl.obj", tmp_path / "cup.obj")
    (tmp_path / "loop.yaml").write_text(f"scenecc: 1\nentities:\n{loop}\n")
    heights = [float(entity.pose.data[0, 2]) for entity in compile_scene(tmp_path / "loop.yaml").entities]
    assert heights == [0.09, *trimesh.load(ASSETS / "bowl.obj", process=False).bounds[1:, 2]]  # pyright: ignore[reportAttributeAccessIssue]


def test_beside_a_draw_it_is_a_constant_of_the_plan(tmp_path: Path) -> None:
    shutil.copy(ASSETS / "mug.obj", tmp_path)
    draws = "num_scenes: 5\nparams: {mesh: mug.obj}\ndraws: {s: {uniform: [1, 2]}}"
    expression = "${[0, 0, bounds(mesh)[1][2] * s]}"
    found = position(tmp_path, expression, draws)
    assert np.array_equal(found, position(tmp_path, "${[0, 0, 0.09 * s]}", draws))
    position(tmp_path, expression, draws)
    plan = compile_scene(tmp_path / "scene.yaml")
    text = plan_to_json(plan)
    (tmp_path / "mug.obj").unlink()
    assert compile_scene(io.StringIO(text)) == plan
    assert '"bounds(mesh)": [[-0.04, -0.04, 0.0], [0.067, 0.04, 0.09]]' in json.dumps(json.loads(text))


def test_a_prefab_reads_its_own_files_and_those_that_it_is_given(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    shutil.copy(ASSETS / "mug.obj", tmp_path / "inner")
    shutil.copy(ASSETS / "gem.stl", tmp_path)
    params = "params: {mesh: {type: file, default: mug.obj}}"
    prefab = f'scenecc: 1\n{params}\nentities: {{b: {{pose: {{p: "${{bounds(mesh)[1]}}"}}, {BOX}}}}}\n'
    (tmp_path / "inner/prefab.yaml").write_text(prefab)
    use = "{use: inner/prefab.yaml}, given: {use: inner/prefab.yaml, with: {mesh: gem.stl}}"
    (tmp_path / "scene.yaml").write_text(f"scenecc: 1\nentities: {{own: {use}}}\n")
    scene = open_scene(tmp_path / "scene.yaml")
    tops = [entity.pose.data[0, 2] for entity in scene.plan.entities]
    assert tops == [0.09, trimesh.load(ASSETS / "gem.stl").bounds[1][2]]  # pyright: ignore[reportAttributeAccessIssue]
    shown = str(scene.inspect().item)
    assert "mug.obj" in shown
    assert "gem.stl" in shown


@pytest.mark.parametrize(
    ("expression", "code", "words"),
    [
        ("bounds('none.obj')", "SC401", "no file"),
        ("bounds('../none.obj')", "SC402", "leaves the folders"),
        ("bounds('empty.obj')", "SC413", "no triangles"),
        ("bounds('far.obj')", "SC417", "from its origin"),
        ("bounds('scene.yaml')", "SC410", "not a supported mesh format"),
        ("bounds('broken.stl')", "SC412", "length"),
        ("bounds(3)", "SC202", "the path of a mesh, not a number"),
        ("bounds()", "SC118", "takes 1 argument, not 0"),
        ("bounds('a.obj', 1)", "SC118", "takes 1 argument, not 2"),
        ("bounds(bounds('mug.obj'))", "SC201", "unknown name `bounds('mug.obj')`"),
        ("bounds(mseh)", "SC201", "unknown name `mseh`"),
        ("bounds(drawn)", "SC203", "the path of a mesh is the same in every scene"),
        ("bounds(varied)", "SC203", "the path of `bounds` cannot read a value that differs"),
        ("bounds('mug.obj')[2]", "SC202", "index 2 is out of range"),
        ("bounds(" + "-" * 200 + "1)", "SC118", "operations deep"),
    ],
)
def test_what_has_no_bounds_is_an_error_at_its_place(tmp_path: Path, expression: str, code: str, words: str) -> None:
    shutil.copy(ASSETS / "mug.obj", tmp_path)
    (tmp_path / "empty.obj").write_text("v 1 2 3\n")
    (tmp_path / "far.obj").write_text("v 1e30 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    (tmp_path / "broken.stl").write_text("nothing")
    params = "params: {mesh: mug.obj, varied: {type: file, default: {choice: [mug.obj]}}}"
    before = f"{params}\ndraws: {{drawn: {{choice: [mug.obj]}}}}"
    file = tmp_path / "scene.yaml"
    text = f'scenecc: 1\n{before}\nentities:\n  b: {{pose: {{p: "${{{expression}[0]}}"}}, {BOX}}}\n'
    file.write_text(text)
    (found,) = [one for one in validate(file) if one.severity == "error"]
    assert (found.code, found.line) == (code, 5)
    assert words in found.message


def test_a_faulty_mesh_is_told_once_and_limits_hold(tmp_path: Path) -> None:
    (tmp_path / "empty.obj").write_text("v 1 2 3\n")
    file = tmp_path / "scene.yaml"
    body = f"repeat: {{i: {{count: 9}}}}, pose: {{p: \"${{bounds('empty.obj')[0]}}\"}}, {BOX}"
    file.write_text(f"scenecc: 1\nentities:\n  b: {{{body}}}\n")
    assert [one.code for one in validate(file)] == ["SC413"]
    shutil.copy(ASSETS / "mug.obj", tmp_path / "empty.obj")
    assert [one.code for one in validate(file, limits={"asset_bytes": 1000})] == ["SC607"]
