"""Poses that are written into a scene file: what changes in its text, and where that is refused."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest

from scenecc.geometry.rotations import Pose7, from_rpy
from scenecc.options import Options
from scenecc.source.edits import EditError
from scenecc.viewer.editor import FileEditor
from scenecc.viewer.world import Loaded, load

HEAD = "scenecc: 1\n# two things\nnum_scenes: 2\n"
SHAPES = "shapes: [{type: box, half_size: [0.1, 0.2, 0.3]}]"
QUARTER = from_rpy(0, 0, math.pi / 2)
UNTURNED = (1.0, 0.0, 0.0, 0.0)


def opened(path: Path, text: str, **params: object) -> tuple[FileEditor, Loaded]:
    path.write_bytes(text.encode())
    found = load(str(path), Options.of(), params)
    assert found.loaded is not None, found.diagnostics
    return FileEditor(path), found.loaded


def write(editor: FileEditor, loaded: Loaded, pose: Pose7, name: str = "cube", scene: int = 0) -> bool:
    entity = next(one for one in loaded.plan.entities if one.name == name)
    return editor.write_pose(loaded, Options.of(), entity, scene, pose)


@pytest.mark.parametrize(
    ("before", "pose", "after"),
    [
        ("pose: [1,  2, 3]  # there", (1.0, 2.5, 3.0, *UNTURNED), "pose: [1,  2.5, 3]  # there"),
        ("pose: [1, 2, 3]", (1.0, 2.0, 0.123456, *UNTURNED), "pose: [1, 2, 0.1235]"),
        ("pose: [1, 2, 3]", (1.0, 2.0, 3.0, *QUARTER), "pose: {p: [1, 2, 3], q: [0.707107, 0, 0, 0.707107]}"),
        ("pose: {p: [1, 2, 3], rpy_deg: [0, 0, 45]}", (1.0, 2.0, 4.0, *QUARTER), None),
        ("pose: {p: [1, 2, 3]} # x", (1.0, 2.0, 3.0, *QUARTER), None),
        ("pose:\n      p: [1, 2, 3]  # p\n      rpy: [0, 0, 0.5] # r", (0.0, 2.0, 3.0, *QUARTER), None),
        ("pose:\n      q: [1, 0, 0, 0]", (0.0, 2.0, 3.0, *QUARTER), None),
        ("pose:\n      - 1\n      - 2 # two\n      - 3", (9.0, 2.0, 3.0, *UNTURNED), None),
        ("pose: {p: [1, 2, 3], axis_angle: {axis: z, angle_deg: 90}}", (1.0, 2.0, 4.0, *QUARTER), None),
        ("pose: {p: [1, 2, 3], anchor: bottom}", (1.0, 2.0, 5.0, *UNTURNED), None),
        ("pose: {p: [1, 2, 3], relative_to: other}", (1.0, 2.0, 5.0, *QUARTER), None),
    ],
)
def test_a_written_pose_changes_nothing_else_in_the_file(
    tmp_path: Path, before: str, pose: Pose7, after: str | None
) -> None:
    other = "  other: {pose: {p: [1, 1, 1], rpy_deg: [0, 0, 90]}, body_type: static, " + SHAPES + "}\n"
    text = f"{HEAD}entities:\n{other}  cube:\n    {before}\n    {SHAPES}\n# the end\n"
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, text)
    assert write(editor, loaded, pose)
    written = path.read_text()
    start, end = f"{HEAD}entities:\n{other}  cube:\n    ", f"\n    {SHAPES}\n# the end\n"
    assert written.startswith(start)
    assert written.endswith(end)
    if after is not None:
        assert written == f"{start}{after}{end}"
    for comment in ("# two", "# p", "# r", "# x", "# there"):
        assert (comment in before) <= (comment in written)
    again = load(str(path), Options.of(), {})
    assert again.loaded is not None
    found = next(one for one in again.loaded.plan.entities if one.name == "cube").pose.row(0)
    assert found[:3] == pytest.approx(pose[:3], abs=1e-4)
    assert abs(found[3:] @ pose[3:]) == pytest.approx(1, abs=1e-6)
    editor.undo()
    assert path.read_bytes() == text.encode()
    assert not editor.can_undo


@pytest.mark.parametrize(
    ("pose", "added"),
    [
        ((0.0, 0.0, 4.0, *UNTURNED), "pose: [0, 0, 4]"),
        ((0.0, 0.0, 4.0, *QUARTER), "pose: {p: [0, 0, 4], q: [0.707107, 0, 0, 0.707107]}"),
    ],
)
def test_a_pose_is_added_where_there_is_none(tmp_path: Path, pose: Pose7, added: str) -> None:
    text = f"{HEAD}entities:\n  cube:\n    {SHAPES}  # a cube\n# the end\n"
    path = tmp_path / "scene.yaml"
    assert write(*opened(path, text), pose)
    assert path.read_text() == text.replace("# a cube\n", f"# a cube\n    {added}\n")


def test_a_turn_removes_no_comments_from_a_list(tmp_path: Path) -> None:
    text = f"{HEAD}entities:\n  cube:\n    pose:\n      - 1  # x\n      - 2\n      - 3\n    {SHAPES}\n"
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, text)
    with pytest.raises(EditError, match="a list over several lines"):
        write(editor, loaded, (1.0, 2.0, 3.0, *QUARTER))
    assert path.read_text() == text


@pytest.mark.parametrize("start", ["﻿", ""])
@pytest.mark.parametrize("end", ["\r\n", "\n"])
def test_byte_order_marks_and_line_ends_are_kept(tmp_path: Path, start: str, end: str) -> None:
    text = start + f"{HEAD}entities:\n  cube: {{pose: [0, 0, 1], {SHAPES}}}\n".replace("\n", end)
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, text)
    write(editor, loaded, (0.0, 0.0, 2.0, *UNTURNED))
    assert path.read_bytes() == text.replace("0, 1]", "0, 2]").encode()


@pytest.mark.parametrize(
    ("entity", "name", "said"),
    [
        ('{pose: [0, 0, "${height}"], %s}', "cube", "`pose` is an expression or a form"),
        ("{pose: {p: [0, 0, {uniform: [0, 1]}]}, %s}", "cube", "`p` is an expression or a form"),
        ("{pose: {per_scene: [[0, 0, 1], [0, 0, 2]]}, %s}", "cube", "a form or a matrix (`per_scene`)"),
        ("{pose: {q: uniform}, %s}", "cube", "`q` is an expression or a form"),
        ("{repeat: {i: {count: 2}}, pose: [0, 0, 1], %s}", "cube_1", "a copy made by the `repeat` of `cube`"),
        ("{pose: {p: [1, 0, 0], look_at: [0, 0, 0]}, %s}", "cube", "`look_at` sets its rotation from its position"),
        ("{use: scenecc:cube, pose: [0, 0, 1]}", "cube/cube", "the prefab that `cube` uses"),
        ("{pose: &there [0, 0, 1], %s}\n  twin: {pose: *there, %s}", "twin", "written elsewhere, at an anchor"),
        ("{pose: &there [0, 0, 1], %s}\n  twin: {pose: *there, %s}", "cube", "would change with it"),
        ("{<<: {pose: [0, 0, 1]}, %s}", "cube", "not written there: it comes from a merge key"),
        ("{variants: [{%s}, {%s}], pick: {cycle: [0, 1]}, pose: [0, 0, 1]}", "cube", "`variants` sets its pose"),
    ],
)
def test_a_pose_set_by_something_else_is_not_written(tmp_path: Path, entity: str, name: str, said: str) -> None:
    text = f"{HEAD}params: {{height: 1}}\nentities:\n  cube: {entity.replace('%s', SHAPES)}\n"
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, text)
    with pytest.raises(EditError) as caught:
        write(editor, loaded, (0.5, 0.5, 0.5, *UNTURNED), name)
    assert said in str(caught.value)
    assert path.read_text() == text
    assert not editor.can_undo


def test_a_move_that_causes_an_error_is_refused(tmp_path: Path) -> None:
    text = f"{HEAD}entities:\n  cube: {{pose: [0, 0, 1], {SHAPES}}}\n"
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, text)
    options = Options.of(limits={"text_bytes": len(text)})
    with pytest.raises(EditError, match="the file would have an error"):
        editor.write_pose(loaded, options, loaded.plan.entities[0], 0, (0.0, 0.0, 1.5, *UNTURNED))
    assert path.read_text() == text


def test_a_file_changed_meanwhile_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    text = f"{HEAD}entities:\n  cube: {{pose: [0, 0, 1], {SHAPES}}}\n"
    editor, loaded = opened(path, text)
    path.write_text(text + "# more\n")
    with pytest.raises(EditError, match="the file has changed since it was loaded"):
        write(editor, loaded, (0.0, 0.0, 2.0, *UNTURNED))
    path.write_text(text)
    assert write(editor, loaded, (0.0, 0.0, 2.0, *UNTURNED))
    path.write_text(text + "# more\n")
    with pytest.raises(EditError, match="the file cannot be written: it has changed meanwhile"):
        editor.undo()
    assert path.read_text() == text + "# more\n"


def test_a_link_is_written_through_to_its_first_target(tmp_path: Path) -> None:
    real, other, link = (tmp_path / name for name in ("real.yaml", "other.yaml", "link.yaml"))
    text = f"{HEAD}entities:\n  cube: {{pose: [0, 0, 1], {SHAPES}}}\n"
    real.write_text(text)
    other.write_text(text)
    link.symlink_to(real)
    found = load(str(link), Options.of(), {}).loaded
    assert found is not None
    editor = FileEditor(link)
    link.unlink()
    link.symlink_to(other)
    assert write(editor, found, (0.0, 0.0, 2.0, *UNTURNED))
    assert other.read_text() == text
    assert real.read_text() == text.replace("0, 1]", "0, 2]")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_an_unwritable_file_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, f"{HEAD}entities:\n  cube: {{pose: [0, 0, 1], {SHAPES}}}\n")
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(EditError, match="the file cannot be written"):
            write(editor, loaded, (0.0, 0.0, 2.0, *UNTURNED))
    finally:
        tmp_path.chmod(0o700)


def test_a_read_only_file_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "scene.yaml"
    editor, loaded = opened(path, f"{HEAD}entities:\n  cube: {{pose: [0, 0, 1], {SHAPES}}}\n")
    before = path.read_bytes()
    monkeypatch.setattr("os.access", lambda at, mode: (Path(at), mode) != (path, os.W_OK))
    with pytest.raises(EditError, match="the file cannot be written: Permission denied"):
        write(editor, loaded, (0.0, 0.0, 2.0, *UNTURNED))
    assert path.read_bytes() == before


def test_only_scene_files_are_written() -> None:
    found = load({"scenecc": 1, "entities": {"cube": {"shapes": [{"type": "sphere", "radius": 1}]}}}, Options.of(), {})
    assert found.loaded is not None
    with pytest.raises(EditError, match="not a YAML scene file"):
        write(FileEditor(None), found.loaded, (0.0, 0.0, 2.0, *UNTURNED))


def test_a_public_page_without_token_writes_no_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    _, loaded = opened(path, f"{HEAD}entities:\n  cube:\n    pose: [0, 0, 1]\n    {SHAPES}\n")
    before = path.read_bytes()
    with pytest.raises(EditError, match="--token auto"):
        write(FileEditor(path, writes=False), loaded, (0.0, 0.0, 2.0, *UNTURNED))
    assert path.read_bytes() == before
