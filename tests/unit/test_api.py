"""The public names, as a user finds them."""

from __future__ import annotations

import dataclasses
import io
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.expectations import GOOD

import scenecc
from scenecc import SceneError
from scenecc.cli.output import Status, status
from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.diagnostic import Location
from scenecc.plan.json_codec import plan_to_json


@pytest.mark.parametrize("name", scenecc.__all__)
def test_no_folder_of_the_package_has_a_public_name(name: str) -> None:
    """Importing a folder binds its name in the package, over whatever had it before."""
    assert not (GOOD.parents[2] / "scenecc" / name).is_dir()
    assert getattr(scenecc, name) is not None
    assert name in dir(scenecc)


def test_every_public_function_can_be_called_twice() -> None:
    script = (
        "import sys, scenecc\n"
        "for _ in range(2):\n"
        "    assert scenecc.validate(sys.argv[1]) == []\n"
        "    plan = scenecc.compile_scene(sys.argv[1])\n"
        "    assert scenecc.emit_scene(plan, 'json') and scenecc.emit_scene(plan, 'python')\n"
        "    scenecc.load_scene(plan, render=False).close()\n"
        "    assert scenecc.json_schema()\n"
        "    print('called')\n"
    )
    command = [sys.executable, "-c", script, str(GOOD / "cube.yaml")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "called\n" * 2


CUBE = {"scenecc": 1, "entities": {"cube": {"shapes": [{"type": "box", "half_size": [0.1, 0.2, 0.3]}]}}}


@pytest.mark.parametrize("name", ["num_scenes", "seed"])
@pytest.mark.parametrize("value", [True, np.True_, 2.0, "2", np.float64(2), [2], 1j])
def test_number_arguments_must_be_integers(name: str, value: Any) -> None:
    given: dict[str, Any] = {name: value}
    for function in (scenecc.validate, scenecc.compile_scene, scenecc.load_scene):
        with pytest.raises(TypeError, match=f"{name} must be an integer"):
            function(CUBE, **given)


@pytest.mark.parametrize("value", [[True], [0.0], ["0"], "0", [None], np.array([0.5]), np.array([True])])
def test_index_arguments_must_be_integers(value: Any) -> None:
    with pytest.raises(TypeError, match=r"scene_idxs must be (an integer|integers)"):
        scenecc.load_scene(CUBE, scene_idxs=value)


def test_number_arguments_are_range_checked() -> None:
    below: list[dict[str, Any]] = [{"num_scenes": 0}, {"seed": -1}, {"scene_idxs": [-1]}]
    for given in below:
        with pytest.raises(ValueError, match="must be at least"):
            scenecc.load_scene(CUBE, **given)


@pytest.mark.parametrize("kind", [int, np.int8, np.uint64])
def test_numpy_integers_are_accepted(kind: Any) -> None:
    plan = scenecc.compile_scene(CUBE, num_scenes=kind(3), seed=kind(7))
    assert (plan.num_scenes, plan.seed) == (3, 7)
    assert type(plan.num_scenes) is type(plan.seed) is int
    with scenecc.load_scene(plan, scene_idxs=np.array([2, 0], kind), render=False) as batch:
        assert batch.scene_idxs == (0, 2)
        assert all(type(idx) is int for idx in batch.scene_idxs)


@pytest.mark.parametrize(
    "codes", [["SC101"], ["SC801"], ["SC101", "SC801"], ["SC801", "SC101"], ["SC801", "SC907"]], ids=str
)
def test_at_fault_agrees_with_the_exit_status(codes: list[str]) -> None:
    diagnostics = [Diagnostic(code, "error", "", Location(None)) for code in codes]
    assert (SceneError(diagnostics).at_fault == "machine") == (status(diagnostics) is Status.machine)
    warned = [dataclasses.replace(one, severity="warning") for one in diagnostics]
    assert SceneError(warned).at_fault == "scene"


def _sorted(text: str) -> str:
    return json.dumps(json.loads(text), sort_keys=True)


def _as_yaml(text: str) -> str:
    """YAML that is no JSON: the plan's own key comes last, and unquoted."""
    data = json.loads(text)
    keys = [key for key in data if key != "scenecc_plan"]
    return "# a plan\n" + "".join(f"{key}: {json.dumps(data[key])}\n" for key in keys) + "scenecc_plan: 1\n"


@pytest.mark.parametrize("rewritten", [str, _sorted, _as_yaml, lambda text: "\ufeff" + _sorted(text)])
def test_a_plan_is_recognised_in_any_key_order_and_syntax(rewritten: Callable[[str], str], tmp_path: Path) -> None:
    plan = scenecc.compile_scene({**CUBE, "description": "é"}, num_scenes=3)
    text = rewritten(plan_to_json(plan))
    file = tmp_path / "plan.json"
    file.write_text(text, encoding="utf-8")
    sources: list[Any] = [file, io.StringIO(text), io.BytesIO(text.encode())]
    sources += [text] if text.startswith("{") else []
    sources += [json.loads(text)] if "# a plan" not in text and text.startswith("{") else []
    for source in sources:
        assert scenecc.compile_scene(source) == plan
    file.write_text(text.replace('"dynamic"', '"dinamic"'), encoding="utf-8")
    assert [found.code[:3] for found in scenecc.validate(file)] == ["SC7"]


def test_a_scene_that_mentions_the_plan_key_is_a_scene(tmp_path: Path) -> None:
    for description in ('"scenecc_plan": 1', "scenecc_plan"):
        scene = {**CUBE, "description": description}
        assert scenecc.validate(scene) == []
        for text in (json.dumps(scene), json.dumps({**scene, "x-note": {"scenecc_plan": 1}})):
            assert scenecc.validate(io.StringIO(text)) == []
    broken = io.StringIO('{"scenecc": 1, "x-a": "scenecc_plan", "scenecc_plan": ')
    assert {found.code[:3] for found in scenecc.validate(broken)} == {"SC0"}


def test_a_mesh_too_large_to_weigh_is_an_error_of_the_scene() -> None:
    shape = {"type": "convex_mesh", "file": str(GOOD.parents[2] / "scenes/assets/gem.stl"), "scale": 1e20}
    with pytest.raises(scenecc.SceneError) as caught:
        scenecc.load_scene(
            {"scenecc": 1, "entities": {"gem": {"mass": 1, "shapes": [shape]}}}, render=False, allow_outside_assets=True
        )
    assert [found.code for found in caught.value.diagnostics if found.severity == "error"] == ["SC512"]
    assert caught.value.at_fault == "scene"


def test_a_single_asset_root_is_accepted() -> None:
    mug = {"scenecc": 1, "entities": {"mug": {"shapes": [{"type": "convex_parts", "file": "asset://mug.obj"}]}}}
    assert scenecc.validate(mug, asset_roots=str(GOOD.parents[2] / "scenes/assets")) == []


@pytest.mark.parametrize("given", [1, "u", ["u"], [("u", [1, 2])], {1, 2}])
@pytest.mark.parametrize("name", ["params", "draws"])
def test_params_and_draws_must_be_mappings(name: str, given: Any) -> None:
    with pytest.raises(TypeError, match=f"{name} must be a mapping"):
        scenecc.validate(CUBE, **{name: given})


DRAWN: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 2,
    "draws": {"half": {"uniform": [0.1, 0.2]}},
    "entities": {"ball": {"shapes": [{"type": "sphere", "radius": "${half}"}]}},
}


@pytest.mark.parametrize("name", [1, None, ("half",), b"half", "half/x", ""])
def test_an_invalid_draw_name_is_reported_as_unknown(name: Any) -> None:
    (found,) = scenecc.validate(DRAWN, draws={name: [1, 2]})
    assert found.code == "SC250"
    assert found.hint in {"known here: half", "did you mean `half`?"}


def test_masked_draws_are_reported() -> None:
    assert scenecc.validate(DRAWN, draws={"half": np.ma.array([1.0, 2.0])}) == []
    found = scenecc.validate(DRAWN, draws={"half": np.ma.array([1.0, 2.0], mask=[False, True])})
    assert [diagnostic.code for diagnostic in found] == ["SC318"]


@pytest.mark.parametrize("function", [scenecc.validate, scenecc.compile_scene])
def test_a_compilation_without_plan_and_error_raises(
    function: Callable[[Any], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scenecc.lower.lower", lambda *_args, **_given: None)
    with pytest.raises(RuntimeError, match="no plan of this scene and found no error"):
        function(CUBE)
