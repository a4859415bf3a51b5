"""Places of findings that are in no file: a fault of the machine has none, a fault of the caller names the argument."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import scenecc
from scenecc import SceneError
from scenecc.backends.sapien import build as sapien_build
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location, Origin
from scenecc.diagnostics.formats import render
from scenecc.render import render_scene
from scenecc.viewer import ViewOptions

ARM = """\
scenecc: 1
num_scenes: 2
entities:
  ball: {shapes: [{type: sphere, radius: 0.1}], scene_idxs: [0]}
cameras:
  eye: {pose: [1, 0, 0], scene_idxs: [0]}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(ARM)
    return path


def raised(call: Callable[[], object]) -> Diagnostic:
    with pytest.raises(SceneError) as caught:
        call()
    (found,) = (one for one in caught.value.diagnostics if one.severity == "error")
    return found


def test_an_error_of_the_machine_has_no_file(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sapien_build, "render_problem", lambda: "no driver")
    found = raised(lambda: scenecc.load_scene(scene, render=True))
    assert (found.code, found.location, found.path) == ("SC803", Location(None), "")
    assert str(found).startswith("scenecc: error SC803: ")
    assert render([found]).startswith("scenecc: error SC803: ")
    (record,) = json.loads(render([found], "json"))["diagnostics"]
    assert (record["file"], record["line"], record["path"]) == (None, None, "")
    assert render([found], "github").startswith("::error title=SC803::")
    (result,) = json.loads(render([found], "sarif"))["runs"][0]["results"]
    assert "locations" not in result


def test_an_error_of_the_machine_at_an_entity_is_reported_there() -> None:
    sink = Sink()
    sink.report("SC806", "CoACD is not there", Origin("scene.yaml", ("entities", "mug")))
    sink.report("SC806", "CoACD is not there", Origin("scene.yaml"))
    assert [(one.file, one.path) for one in sink.diagnostics()] == [(None, ""), ("scene.yaml", "entities.mug")]


CALLS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "inspect scene": ("scene", lambda file: scenecc.inspect_scene(file, scene=9)),
    "inspect entity": ("entity", lambda file: scenecc.inspect_scene(file, entity="bal")),
    "export scene": ("scene", lambda file: scenecc.export_scene(file, "mjcf", scene=9)),
    "export entity": ("entity", lambda file: scenecc.export_scene(file, "urdf", entity="bal")),
    "export robots": ("target", lambda file: scenecc.export_scene(file, "urdf")),
    "page scene": ("scene", lambda file: scenecc.export_page(file, options=ViewOptions(scene=9))),
    "build scenes": ("scenes", lambda file: scenecc.build_scene(file, scenes="9")),
    "render scenes": ("scenes", lambda file: render_scene(file, scenes="9")),
    "render camera": ("camera", lambda file: render_scene(file, camera="ey")),
    "render scene of a camera": ("camera", lambda file: render_scene(file, camera="eye", scenes="1")),
    "render focus": ("focus", lambda file: render_scene(file, focus="bal")),
    "render scene of a focus": ("focus", lambda file: render_scene(file, focus="ball", scenes="1")),
    "render size": ("size", lambda file: render_scene(file, size=(16384, 16384))),
    "render samples": ("samples", lambda file: render_scene(file, size=(4000, 4000), samples=256)),
}


@pytest.mark.parametrize("call", CALLS)
def test_wrong_usage_names_the_argument(scene: Path, call: str) -> None:
    argument, function = CALLS[call]
    found = raised(lambda: function(scene))
    assert (found.location, found.path) == (Location(None), argument)
    assert render([found]).startswith(f"{argument}: error {found.code}: ")
    assert str(found).startswith(f"{argument}: error {found.code}: ")
    assert "--" not in f"{found.message} {found.hint}", "an option of the command line"
    assert "file" not in render([found], "github").partition("::error ")[2].partition("::")[0]


def test_an_error_in_a_dict_names_its_path() -> None:
    found = scenecc.validate({"scenecc": 1, "entities": {"a": {"shape": []}}})
    assert render(found).startswith("<dict>: error SC101: ")
