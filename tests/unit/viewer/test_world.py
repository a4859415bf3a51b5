"""Live scenes that are looked at, and what is shown of them, held against SAPIEN's own scenes.

A page as a file.
"""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import trimesh
import zstandard

import scenecc
from scenecc.extras import install_hint
from scenecc.options import Options
from scenecc.viewer import PageAddress, ViewOptions, page_of_source, view_scene
from scenecc.viewer.cameras import first_view
from scenecc.viewer.nodes import Frame, Name, SurfaceNode
from scenecc.viewer.surfaces import SurfaceFiles
from scenecc.viewer.world import Loading, World, check_selected_scene, load

BALL = {"type": "sphere", "radius": 0.1, "color": [1, 0, 0]}
BOX = {"type": "box", "half_size": [0.1, 0.2, 0.3], "pose": [0, 0, 0.5]}
ARM = {
    "pose": [1, 0, 0],
    "root": {
        "name": "base",
        "shapes": [BOX],
        "children": [{"name": "tip", "joint": {"type": "revolute", "name": "turn"}, "shapes": [BALL]}],
    },
}
SCENE: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 3,
    "params": {"mass": {"default": 2, "min": 1, "max": 5}},
    "entities": {
        "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "ball": {"pose": [0, 0, 1], "mass": "${mass}", "shapes": [BALL]},
        "other": {"pose": {"p": [{"per_scene": [1, 2]}, 2, 0.4]}, "shapes": [BOX], "scene_idxs": [1, 2]},
        "arm": ARM,
    },
}


def loaded(scene: dict[str, Any] = SCENE, **given: Any) -> Loading:
    return load(scene, Options.of(), given)


def world(look: ViewOptions | None = None, scene: dict[str, Any] = SCENE, **given: Any) -> World:
    found = loaded(scene, **given)
    assert found.loaded is not None, found.diagnostics
    return World(found.loaded, look or ViewOptions())


def test_the_page_shows_the_entities_of_a_scene() -> None:
    made, files = world(ViewOptions(scene=1)), SurfaceFiles()
    assert made.scene_idxs == (1,)
    picture = made.picture(ViewOptions(scene=1), files)
    assert [*picture.nodes] == [
        "/scene 1",
        "/scene 1/ground",
        "/scene 1/ground/visual 0",
        "/scene 1/ball",
        "/scene 1/ball/visual 0",
        "/scene 1/other",
        "/scene 1/other/visual 0",
        "/scene 1/arm",
        "/scene 1/arm/base",
        "/scene 1/arm/base/visual 0",
        "/scene 1/arm/tip",
        "/scene 1/arm/tip/visual 0",
    ]
    ball, other = picture.nodes["/scene 1/ball"], picture.nodes["/scene 1/other/visual 0"]
    assert isinstance(ball, Frame)
    assert isinstance(other, SurfaceNode)
    assert ball.position == (0, 0, 1)
    assert (other.position, other.scale) == ((0, 0, 0.5), (0.1, 0.2, 0.3))
    assert picture.bodies[1, "arm", 1] == "/scene 1/arm/tip"
    # Balls are one surface, boxes another, the ground a third.
    assert len(files.contents) == 3
    assert all(content.startswith(b"glTF") for content in files.contents.values())
    made.close()


def test_view_options_select_what_is_shown() -> None:
    made, files = world(), SurfaceFiles()
    plain = made.picture(ViewOptions(), files)
    named = made.picture(ViewOptions(names=True, frames=True), files)
    both = made.picture(ViewOptions(collision=True), files)
    colliding = made.picture(ViewOptions(collision=True, visual=False), files)
    base, tip = named.nodes["/scene 0/arm/base/name"], named.nodes["/scene 0/arm/tip/name"]
    assert isinstance(base, Name)
    assert isinstance(tip, Name)
    assert (base.text, tip.text) == ("arm", "tip")
    chosen = [None, (0, "ball", 0), (0, "arm", 0), (0, "arm", 1)]
    assert [base.is_shown(key) for key in chosen] == [True] * 4
    assert [tip.is_shown(key) for key in chosen] == [False, False, True, True], "only with its articulation"
    grid = made.picture(ViewOptions(grid=True), files)
    assert [node.text for node in grid.nodes.values() if isinstance(node, Name)] == ["Scene 0"]
    frame = plain.nodes["/scene 0/arm/tip"]
    assert isinstance(frame, Frame)
    assert named.nodes["/scene 0/arm/tip"] == replace(frame, axes=True)
    assert set(both.nodes) - set(plain.nodes) == {path for path in both.nodes if "/collision" in path}
    assert set(colliding.nodes) == {path for path in both.nodes if "/visual" not in path}
    one, other = (each.nodes["/scene 0/ball/collision 0"] for each in (both, colliding))
    assert isinstance(one, SurfaceNode)
    assert isinstance(other, SurfaceNode)
    assert one.file != other.file, "over what is seen, it can be seen through"
    made.close()


def test_scenes_of_a_grid_are_apart() -> None:
    look = ViewOptions(grid=True)
    made = world(look)
    assert (made.scene_idxs, made.left_out) == ((0, 1, 2), 0)
    picture = made.picture(look, SurfaceFiles())
    origins = []
    for index in range(3):
        frame = picture.nodes[f"/scene {index}"]
        assert isinstance(frame, Frame)
        origins.append(frame.position)
    assert len({*origins}) == 3
    assert "/scene 0/other" not in picture.nodes
    assert {key[0] for key in picture.bodies} == {0, 1, 2}
    assert np.ptp(picture.corners, axis=0).max() > 4
    made.close()


def test_a_ground_does_not_widen_the_grid() -> None:
    tiles = {"type": "tiled_plane", "half_size": [8, 4], "texture_repeat": [16, 8]}
    ground = {"body_type": "static", "visuals": [tiles], "collisions": [{"type": "plane"}]}
    scene = {"scenecc": 1, "num_scenes": 2, "entities": {"ground": ground, "ball": {"shapes": [BALL]}}}
    made, files = world(ViewOptions(grid=True), scene), SurfaceFiles()
    apart = made.picture(ViewOptions(grid=True), files)
    tiled = apart.nodes["/scene 1/ground/visual 0"]
    second = apart.nodes["/scene 1"]
    assert isinstance(tiled, SurfaceNode)
    assert isinstance(second, Frame)
    assert second.position[0] < 1
    assert tiled.scale[0] == tiled.scale[1] == second.position[0] / 2
    mesh = next(iter(trimesh.load_scene(io.BytesIO(files.contents[tiled.file]), file_type="glb").geometry.values()))
    # One tile a metre, as the whole of it has.
    assert np.ptp(mesh.visual.uv, axis=0) == pytest.approx(2 * np.array(tiled.scale[:2]))
    whole = world(ViewOptions(), scene)
    alone = whole.picture(ViewOptions(), files).nodes["/scene 0/ground/visual 0"]
    assert isinstance(alone, SurfaceNode)
    assert alone.scale == (8, 4, 1)
    for each in (made, whole):
        each.close()


def test_collision_shapes_count_for_the_grid_if_shown() -> None:
    box = {"type": "box", "half_size": [5, 5, 5]}
    scene = {"scenecc": 1, "num_scenes": 2, "entities": {"only": {"collisions": [box]}}}
    look = ViewOptions(grid=True, collision=True)
    made = world(look, scene)
    picture = made.picture(look, SurfaceFiles())
    first, second = (picture.nodes[f"/scene {index}"] for index in range(2))
    assert isinstance(first, Frame)
    assert isinstance(second, Frame)
    assert second.position[0] - first.position[0] > 10
    assert np.ptp(picture.corners, axis=0)[0] > 20
    made.close()


def test_scenes_with_too_many_bodies_are_left_out_of_the_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.viewer.world._MOST_BODIES", 9)
    made = world(ViewOptions(grid=True))
    # Four bodies in scene 0 and five in scene 1.
    assert (made.scene_idxs, made.left_out) == ((0, 1), 1)
    made.close()


def test_the_viewer_simulates_like_a_batch() -> None:
    made = world(ViewOptions(scene=2))
    with scenecc.load_scene(SCENE, scene_idxs=[2], render=False) as batch:
        assert made.timestep == batch.timestep
        for steps in (0, 1, 60):
            made.step(steps)
            batch.step(steps)
            found = dict(zip(made.keys, made.poses(), strict=True))
            assert np.array_equal(found[2, "ball", 0], batch.entities["ball"].pose[0])
            tip = batch.articulations["arm"].links["tip"][0].entity_pose
            assert np.array_equal(found[2, "arm", 1], np.concatenate([tip.p, tip.q]))
            assert (2, "ground", 0) not in found, "it cannot move"
    assert made.steps == 61
    assert made.time == pytest.approx(0.61)
    made.reset(0)
    assert (made.steps, made.poses()[0][2]) == (0, 1)
    made.close()


def test_the_viewer_shows_the_facts_of_inspect() -> None:
    made = world(ViewOptions(scene=1), mass=3)
    facts = made.facts((1, "ball", 0))
    assert facts is not None
    assert facts.data()["mass"] == 3
    assert made.facts((0, "ball", 0)) is None, "that scene is not built"
    assert made.facts((1, "nobody", 0)) is None
    assert made.entities() == {1: [("ground", ()), ("ball", ()), ("other", ()), ("arm", ("base", "tip"))]}
    made.close()


def test_a_page_refuses_a_missing_scene_index() -> None:
    found = loaded()
    assert found.loaded is not None
    with pytest.raises(scenecc.SceneError) as caught:
        check_selected_scene(ViewOptions(scene=3), found.loaded.plan)
    assert caught.value.diagnostics[0].code == "SC908"
    check_selected_scene(ViewOptions(scene=2), found.loaded.plan)


def test_loading_returns_the_files_used_and_looked_for(tmp_path: Any) -> None:
    (tmp_path / "part.yaml").write_text("scenecc: 1\nentities: {cube: {shapes: [{type: sphere, radius: 0.1}]}}\n")
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scenecc: 1\ninclude: [part.yaml]\nentities:\n  a: {shapes: [{type: convex_mesh, file: no.obj}]}\n"
    )
    options = Options.of()
    found = load(str(scene), options, {})
    assert found.loaded is None
    assert [one.code for one in found.diagnostics] == ["SC401"]
    assert found.files == {(tmp_path / name).resolve() for name in ("part.yaml", "no.obj")}


def test_files_are_dropped_when_nothing_shows_them() -> None:
    made, files = world(), SurfaceFiles()
    picture = made.picture(ViewOptions(), files)
    used = {node.file for node in picture.nodes.values() if isinstance(node, SurfaceNode)}
    assert set(files.contents) == used
    files.keep(set())
    assert not files.contents
    again = made.picture(ViewOptions(), files)
    assert again.nodes.keys() == picture.nodes.keys()
    assert set(files.contents) == {node.file for node in again.nodes.values() if isinstance(node, SurfaceNode)}


def test_a_name_with_a_slash_is_one_step_of_a_path() -> None:
    """What is below a path on the page would move with it."""
    scene = {"scenecc": 1, "entities": {"desk": {"use": "scenecc:cube", "pose": [1, 0, 0]}}}
    made = world(scene=scene)
    picture = made.picture(ViewOptions(), SurfaceFiles())
    names = [name for name, _ in made.entities()[0]]
    assert any("/" in name for name in names)
    assert {path.count("/") for path, node in picture.nodes.items() if isinstance(node, Frame)} == {1, 2}
    assert len(picture.bodies) == len(names)
    made.close()


pytest.importorskip("viser", reason="needs the extra `view`")


RECORDED_SCENE = """\
scenecc: 1
name: <b>balls</b>
num_scenes: 2
entities:
  ball: {pose: [0, 0, 1], shapes: [{type: sphere, radius: 0.1}]}
  still: {pose: [3, 0, 0], body_type: static, shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""


def recorded(page: str) -> tuple[float, list[tuple[float, dict[str, object]]]]:
    """How long a page plays [s], and its messages with their times."""
    found = re.search(r'__VISER_EMBED_DATA__="([^"]*)"', page)
    assert found
    data = zstandard.ZstdDecompressor().decompress(base64.b64decode(found[1])[8:])
    held = msgspec.msgpack.decode(data[8 : 8 + int.from_bytes(data[:8], "little")])
    return held["durationSeconds"], held["messages"]


def test_an_exported_page_contains_the_scene(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(RECORDED_SCENE)
    page = page_of_source(path).html
    duration, messages = recorded(page)
    assert "<title>&lt;b&gt;balls&lt;/b&gt;</title>" in page
    assert duration == 0
    names = {message.get("name") for _, message in messages}
    assert {"/scene 0/ball/visual 0", "/scene 0/still/visual 0"} <= names
    assert not any(str(name).startswith("/scene 1") for name in names)


def test_an_exported_page_plays_in_real_time(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(RECORDED_SCENE)
    duration, messages = recorded(page_of_source(path, steps=50, options=ViewOptions(scene=1)).html)
    assert duration == pytest.approx(0.5)
    falls = [
        (time, message["position"])
        for time, message in messages
        if message.get("name") == "/scene 1/ball" and message["type"] == "SetPositionMessage"
    ]
    heights = [position[2] for _, position in falls]  # pyright: ignore[reportIndexIssue] - a list of numbers
    assert heights == sorted(heights, reverse=True)
    with scenecc.load_scene(path, scene_idxs=[1], render=False) as batch:
        batch.step(50)
        assert heights[-1] == float(batch.entities["ball"].pose[0, 2])
    moved = {message["name"] for time, message in messages if time > 0}
    assert moved == {"/scene 1/ball"}, "what stands still is not told again"


def test_a_bad_scene_gives_no_page(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(RECORDED_SCENE.replace("sphere", "spere"))
    with pytest.raises(scenecc.SceneError) as caught:
        page_of_source(path)
    assert caught.value.at_fault == "scene"
    path.write_text(RECORDED_SCENE)
    with pytest.raises(scenecc.SceneError) as caught:
        page_of_source(path, options=ViewOptions(scene=2))
    assert caught.value.diagnostics[0].code == "SC908"
    with pytest.raises(ValueError, match="scene must be at least 0, not -1"):
        page_of_source(path, options=ViewOptions(scene=-1))
    for port in (-1, 65536):
        with pytest.raises(ValueError, match=f"a port must be from 0 to 65535, not {port}"):
            PageAddress(port=port)
    with pytest.raises(ValueError, match="steps must be at least 0"):
        page_of_source(path, steps=-1)


def test_missing_viewer_packages_give_an_install_hint(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.extras.find_spec", lambda name: None)
    for call in (page_of_source, view_scene):
        with pytest.raises(scenecc.SceneError) as caught:
            call({"scenecc": 1})
        (told,) = caught.value.diagnostics
        assert (told.file, told.place) == (None, "scenecc")
        assert (told.code, told.hint) == ("SC816", install_hint("view"))
        assert told.message == "a page needs viser and watchfiles, not installed here"
        assert caught.value.at_fault == "machine"


def test_a_diverging_simulation_gives_no_page(tmp_path: Path) -> None:
    path = tmp_path / "balls.yaml"
    path.write_text(f"physics: {{gravity: [0, 0, -1.0e+6], timestep: 1}}\n{RECORDED_SCENE}")
    page_of_source(path)
    with pytest.raises(scenecc.SceneError) as caught:
        page_of_source(path, steps=20)
    assert ([found.code for found in caught.value.diagnostics], caught.value.at_fault) == (["SC820"], "scene")


def test_a_page_opens_at_the_files_camera_or_at_what_moves() -> None:
    wall = {"type": "box", "half_size": [0.1, 8, 3]}
    room = {
        "wall": {"body_type": "static", "pose": [6, 0, 3], "shapes": [wall]},
        "cube": {"pose": [0, 0, 0.1], "shapes": [BOX]},
        "arm": ARM,
    }
    cameras = {
        "hand": {"mount": "arm/tip", "fovy_deg": 40, "width": 64, "height": 48},
        "side": {"pose": {"p": [0, 5, 1], "look_at": [0, 0, 1]}, "fovx_deg": 90, "width": 64, "height": 48},
        "flat": {
            "pose": {"p": [0, 0, 5], "rpy_deg": [0, 89, 0]},
            "orthographic": {"top": 2},
            "width": 64,
            "height": 48,
        },
    }
    scene = {"scenecc": 1, "entities": room, "cameras": cameras}
    made = world(scene=scene)
    picture = made.picture(ViewOptions(), SurfaceFiles())
    hand, side, flat = picture.views
    assert (hand.name, hand.mounted, side.mounted) == ("hand", True, False)
    assert first_view(picture.views, picture.solids, grid=False) == side
    assert first_view(picture.views, picture.solids, grid=True) is None
    assert side.position == pytest.approx((0, 5, 1))
    assert side.look_at[0] == pytest.approx(0, abs=1e-6)
    assert side.fov == pytest.approx(2 * np.arctan(48 / 64))
    distance = np.linalg.norm(np.subtract(flat.look_at, flat.position))
    assert distance * np.tan(flat.fov / 2) == pytest.approx(2)
    opened = first_view((), picture.solids, grid=False)
    assert opened is not None
    # Not of the wall, which is much larger than what moves before it.
    assert np.linalg.norm(np.subtract(opened.look_at, (0.5, 0, 0.5))) < 1
    assert np.linalg.norm(opened.position) < 8
    made.close()
