"""What expressions give to parameters: judged as it is validated where it is known, and as it is drawn elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from scenecc import SceneError, compile_scene, validate

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic

PREFAB = """scenecc: 1
params:
  p: {%s}
entities:
  leg: {shapes: [{type: sphere, radius: "${1 if p == p else 2}"}]}
"""

SCENE = """scenecc: 1
num_scenes: 4
draws:
  u: {uniform: [0, 1]}
  v: {uniform: [[0, 0], [1, 1]]}
  n: {choice: [1, 2, 3]}
  far: {integers: [0, 1000000]}
entities:
  a: {use: prefab.yaml, with: {p: %s}%s}
  b: {shapes: [{type: sphere, radius: "${1 + u + v[0] + n + far}"}]}
"""


def write(folder: Path, declared: str, given: str, rest: str = "") -> Path:
    (folder / "prefab.yaml").write_text(PREFAB % declared)
    (folder / "scene.yaml").write_text(SCENE % (given, rest))
    return folder / "scene.yaml"


def errors(found: tuple[Diagnostic, ...] | list[Diagnostic]) -> list[str]:
    return [one.code for one in found if one.severity == "error"]


@pytest.mark.parametrize(
    ("declared", "given", "code"),
    [
        ("type: number, min: 0", '"${u - 0.5}"', "SC212"),
        ("type: number, max: 2", '"${n}"', "SC212"),
        ("type: number, max: 2", '{cycle: [1, "${n}"]}', "SC212"),
        ("type: number, max: 2", '{uniform: [0, "${n}"]}', "SC212"),
        ("type: number, max: 2", '"${scene}"', "SC212"),
        ("type: number", '"${v}"', "SC211"),
        ("type: integer", '"${n * 0.5}"', "SC211"),
        ("type: string", '"${u}"', "SC211"),
        ("type: boolean", '"${n}"', "SC211"),
        ("type: vector", '"${u}"', "SC211"),
        ("type: vector, default: [0, 0, 0]", '"${v}"', "SC211"),
        ("type: vector, default: [0, 0], min: 0.5", '"${v}"', "SC212"),
        ("type: color", '"${v}"', "SC211"),
        ("type: choice, options: [1, 2], default: 1", '"${n}"', "SC211"),
        ("type: file", '"${n}"', "SC211"),
        ("type: list", '"${n}"', "SC211"),
        ("type: number, min: 0, max: 1", '"${u}"', None),
        ("type: number, min: 0, max: 1", '"${n / 3}"', None),
        ("type: vector, default: [0, 0], min: 0", '"${v}"', None),
        ("type: choice, options: [1, 2, 3], default: 1", '"${n}"', None),
        ("type: boolean", '"${n > 1}"', None),
    ],
)
def test_what_is_known_is_judged_without_drawing(tmp_path: Path, declared: str, given: str, code: str | None) -> None:
    found = [one for one in validate(write(tmp_path, declared, given)) if one.severity == "error"]
    assert [one.code for one in found] == ([] if code is None else [code])
    for one in found:
        assert one.location.line == 9
        assert "the parameter `p` must" in one.message
        assert [Path(str(related.location.file)).name for related in one.related] == ["prefab.yaml"]


@pytest.mark.parametrize(
    ("declared", "given", "code"),
    [
        ("type: number, max: 2", '"${u * u - u + 3}"', "SC212"),
        ("type: vector, default: [0, 0], max: 2", '"${[3 + u * u - u, 0]}"', "SC212"),
        ("type: integer", '"${u}"', "SC211"),
        ("type: choice, options: [1, 2], default: 1", '"${u}"', "SC211"),
        ("type: integer", '"${far * 0.5}"', "SC211"),
    ],
)
def test_the_rest_is_judged_as_it_is_drawn(tmp_path: Path, declared: str, given: str, code: str) -> None:
    file = write(tmp_path, declared, given)
    assert errors(validate(file)) == []
    with pytest.raises(SceneError) as raised:
        compile_scene(file)
    assert errors(raised.value.diagnostics) == [code]
    assert "which this gives in scene 0" in raised.value.diagnostics[-1].message


def test_scenes_in_which_an_instance_is_not_do_not_matter(tmp_path: Path) -> None:
    assert errors(validate(write(tmp_path, "type: number, max: 2", '"${scene}"', ", scene_idxs: [0, 1, 2]"))) == []
    file = write(tmp_path, "type: number, max: 2", '"${scene}"', ", scene_idxs: [1, 3]")
    [found] = [one for one in validate(file) if one.severity == "error"]
    assert found.code == "SC212"
    assert "in scene 3" in found.message


def test_an_array_for_a_parameter_is_judged_too(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        "scenecc: 1\nnum_scenes: 2\nparams: {p: {type: number, min: 0, default: {uniform: [0, 1]}}}\n"
        'entities: {a: {shapes: [{type: sphere, radius: "${p + 2}"}]}}\n'
    )
    assert errors(validate(file, draws={"p": [0.0, 1.0]})) == []
    assert errors(validate(file, draws={"p": [0.0, -1.0]})) == ["SC212"]
