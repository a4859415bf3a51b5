"""Parameters that nothing reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc import validate

if TYPE_CHECKING:
    from pathlib import Path

PART = 'scenecc: 1\nparams: {inner: {type: number, default: 1}}\nentities: {%s: {mass: "${%s}", shapes: [%s]}}\n'
BALL = "{type: sphere, radius: 0.1}"


def unread(folder: Path, top: str) -> list[str]:
    (folder / "part.yaml").write_text(PART % ("a", "outer", BALL))
    (folder / "prefab.yaml").write_text(f"scenecc: 1\nparams: {{outer: 1}}\nentities: {{b: {{shapes: [{BALL}]}}}}\n")
    (folder / "top.yaml").write_text(f"scenecc: 1\n{top}\n")
    found = validate(folder / "top.yaml")
    assert {one.code for one in found} <= {"SC322"}
    return [one.path for one in found]


def test_what_an_included_file_reads_is_read_and_what_it_declares_may_not_be(tmp_path: Path) -> None:
    assert unread(tmp_path, "params: {outer: 1}\ninclude: [part.yaml]") == ["params.inner"]


def test_a_prefab_reads_its_own(tmp_path: Path) -> None:
    top = "params: {outer: 1, given: 2}\nentities: {p: {use: prefab.yaml, with: {outer: '${given}'}}}"
    assert unread(tmp_path, top) == ["params.outer"]


def test_a_draw_that_is_the_same_in_every_scene_is_read_like_any_other(tmp_path: Path) -> None:
    top = tmp_path / "top.yaml"
    top.write_text(
        "scenecc: 1\ndraws: {one: 1, two: 2, three: {uniform: [0, 1]}, four: {uniform: [1, 2]}}\n"
        f"entities: {{a: {{mass: '${{two + four}}', shapes: [{BALL}]}}}}\n"
    )
    assert [(found.code, found.path) for found in validate(top)] == [("SC319", "draws.one"), ("SC319", "draws.three")]
