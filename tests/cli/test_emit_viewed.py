"""`scenecc emit --to glb` and `--to usd`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from plugins.plan_parts import ROOT

SCENES = """\
scenecc: 1
num_scenes: 4
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [0, 0, {per_scene: [1, 2, 3, 4]}], shapes: [{type: box, half_size: [0.1, 0.2, 0.3], color: "#ff0000"}]}
"""


def test_one_scene_is_exported_as_glb(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENES)
    done = run("emit", "scene.yaml", "--to", "glb", "--scene", "2", "-o", "out.glb")
    assert (done.returncode, done.stdout) == (0, "")
    scene = trimesh.load_scene(tmp_path / "out.glb")
    assert {"out", "cube/box", "ground/plane"} <= set(scene.graph.nodes)
    place, geometry = scene.graph["cube/box"]
    assert np.allclose(place[:3, 3], [0, 3, 0])  # y is up in the file
    assert tuple(scene.geometry[geometry].visual.material.baseColorFactor) == (255, 0, 0, 255)


def test_a_grid_is_exported_as_glb(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENES)
    done = run("emit", "scene.yaml", "--to", "glb", "--grid", "--show", "collision", "-o", "out.glb")
    assert done.returncode == 0
    assert "scene.yaml:4" in done.stderr
    assert "SC746" in done.stderr
    nodes = set(trimesh.load_scene(tmp_path / "out.glb").graph.nodes)
    assert {f"scene {k}/cube/box" for k in range(4)} <= nodes


def test_glb_is_written_to_standard_output_as_bytes(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENES)
    done = run("emit", "scene.yaml", "--to", "glb")
    assert done.returncode == 0
    assert done.stdout.startswith("glTF")


def test_the_usd_suffix_selects_text_or_binary(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENES)
    for suffix, start in (("usda", b"#usda 1.0"), ("usdc", b"PXR-USDC"), ("usd", b"PXR-USDC")):
        assert run("emit", "scene.yaml", "--to", "usd", "-o", f"out.{suffix}").returncode == 0
        assert (tmp_path / f"out.{suffix}").read_bytes().startswith(start)


def test_usd_textures_are_in_a_folder_beside_the_file(run, tmp_path: Path) -> None:
    (tmp_path / "checker.png").write_bytes((ROOT / "scenes" / "assets" / "checker.png").read_bytes())
    (tmp_path / "scene.yaml").write_text(
        "scenecc: 1\nmaterials: {checked: {visual: {base_color_texture: checker.png}}}\n"
        "entities: {a: {body_type: static, material: checked, shapes: [{type: sphere, radius: 1}]}}\n"
    )
    assert run("emit", "scene.yaml", "--to", "usd", "-o", "out.usda").returncode == 0
    (image,) = (tmp_path / "out.assets").iterdir()
    assert image.read_bytes() == (tmp_path / "checker.png").read_bytes()
    assert f"@./out.assets/{image.name}@" in (tmp_path / "out.usda").read_text()
    done = run("emit", "scene.yaml", "--to", "usd")
    assert done.returncode != 0
    assert "SC904" in done.stderr


def test_incompatible_emit_options_are_refused(run, tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENES)
    for options in (
        ("--to", "glb", "--grid", "--scene", "1"),
        ("--to", "usd", "--grid"),
        ("--to", "glb", "--scene", "9"),
    ):
        done = run("emit", "scene.yaml", *options, "-o", "out.glb")
        assert done.returncode == 2, done.stderr
        assert not (tmp_path / "out.glb").exists()
