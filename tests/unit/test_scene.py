"""`open_scene`: a scene that is compiled once, and what can be made of it."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

import scenecc
from scenecc import SceneError, open_scene, pipeline
from scenecc.export import FileChoices

SCENE = """\
scenecc: 1
num_scenes: 2
params: {size: {default: 0.1, min: 0.05, max: 1}}
draws: {x: {uniform: [0, 1]}}
entities:
  ball: {pose: ["${x}", 0, 1], shapes: [{type: sphere, radius: "${size}"}]}
"""
BAD = "scenecc: 1\nentities:\n  ball: {shapes: [{type: sphere, radius: -1}]}\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_an_opened_scene_is_compiled_once(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled: list[object] = []
    real = pipeline._run_stages
    monkeypatch.setattr(pipeline, "_run_stages", lambda *a, **k: compiled.append(a) or real(*a, **k))
    scene = open_scene(file, num_scenes=3, seed=5, params={"size": 0.2})
    assert compiled == []  # nothing is done before it is asked for
    assert scene.diagnostics == []
    assert (scene.plan.num_scenes, scene.plan.seed) == (3, 5)
    assert [row.name for row in scene.params] == ["size"]
    with scene.build(render=False) as batch:
        assert batch.entities["ball"].pose.shape == (3, 7)
    assert scene.inspect(build=False).item.name == "scene"
    assert scene.emit("json").text == scenecc.plan_text(scene.plan)
    assert not scene.diff(scene)
    assert len(compiled) == 1


def test_only_diagnostics_of_a_bad_scene_does_not_raise(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(BAD)
    scene = open_scene(path)
    assert [(one.code, one.line) for one in scene.diagnostics] == [("SC104", 3)]
    uses = (
        lambda: scene.plan,
        lambda: scene.params,
        lambda: scene.build(render=False),
        lambda: scene.emit("json"),
        lambda: scene.export(tmp_path / "bad.json"),
        scene.inspect,
        lambda: scene.diff(scene),
    )
    for use in uses:
        with pytest.raises(SceneError) as error:
            use()
        assert [(one.code, one.line) for one in error.value.diagnostics][:1] == [("SC104", 3)]
    assert not (tmp_path / "bad.json").exists()


@pytest.mark.parametrize("options", [{"num_scenes": 0}, {"seed": -1}, {"limits": {"nothing": 1}}])
def test_open_scene_checks_options_at_once(file: Path, options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(options))[:-1]):
        open_scene(file, **options)


def test_an_opened_stream_is_read_once(file: Path) -> None:
    scene = open_scene(io.StringIO(SCENE), num_scenes=2)
    assert scene.plan == scene.plan
    assert scene.emit("python").text.startswith("# A script of plain SAPIEN calls")
    assert not scene.diff(open_scene(file, num_scenes=2))


@pytest.mark.parametrize("name", ["scene.py", "scene.json", "scene.glb", "scene.xml", "scene.urdf"])
def test_the_suffix_selects_the_export_target(file: Path, name: str) -> None:
    scene, path = open_scene(file), file.parent / "out" / name
    path.parent.mkdir()
    choices: FileChoices = {"entity": "ball"} if path.suffix == ".urdf" else {}
    made = scene.export(path, **choices)
    assert made.paths[0] == path.resolve()
    assert {one.read_bytes() for one in made.paths} == {*made.files.values()}
    target = {".py": "python", ".xml": "mjcf"}.get(path.suffix, path.suffix[1:])
    again = scene.emit(target, base=path.parent if target in {"python", "json"} else None, name="scene", **choices)
    assert again.files == made.files


@pytest.mark.parametrize(
    ("name", "choices"),
    [
        ("other.xml", {"target": "urdf", "entity": "ball"}),
        ("a: b.xml", {}),
        (f"{'long' * 20}.py", {}),
        ("scene.mjcf", {}),
        ("scene.usd", {}),
    ],
)
def test_an_export_lists_the_written_files(file: Path, name: str, choices: dict[str, Any]) -> None:
    if name.endswith("usd"):
        pytest.importorskip("pxr")
    made = open_scene(file).export(file.parent / name, **choices)
    assert made.paths[0] == file.parent.resolve() / name
    assert [one.relative_to(file.parent.resolve()).as_posix() for one in made.paths] == [*made.files]
    assert [one.read_bytes() for one in made.paths] == [*made.files.values()]


def test_export_target_may_differ_from_the_suffix_but_must_exist(file: Path) -> None:
    scene = open_scene(file)
    assert b"<robot" in next(iter(scene.export(file.with_suffix(".xml"), target="urdf", entity="ball").files.values()))
    with pytest.raises(ValueError, match=r"scene\.txt must end in one of \.py, \.json"):
        scene.export(file.with_suffix(".txt"))
    with pytest.raises(ValueError, match="glb does not support `entity`"):
        scene.export(file.with_suffix(".glb"), entity="ball")


def test_results_have_diagnostics_of_the_scene_and_their_own(tmp_path: Path) -> None:
    path = tmp_path / "warned.yaml"
    path.write_text(SCENE.replace("params: {", "params: {unread: 1, "))
    scene = open_scene(path)
    (unused,) = scene.diagnostics
    assert unused.severity == "warning"
    made = scene.emit("urdf", entity="ball")
    assert unused in made.diagnostics
    assert scene.inspect().diagnostics == [unused]
    assert scene.diff(open_scene(path)).diagnostics == [unused, unused]
    # What one use finds, no other tells.
    assert scene.diagnostics == [unused]


def test_an_engine_failure_is_a_scene_error(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.backends.sapien import build

    scene = open_scene(file)
    monkeypatch.setattr(build, "render_problem", lambda: "failed to find a rendering device")
    with pytest.raises(SceneError) as error:
        scene.build(render=True)
    assert error.value.diagnostics[0].code == "SC803"
    with pytest.raises(ValueError, match="scene_idxs"):
        scene.build(scene_idxs=[7], render=False)


def test_wrong_arguments_of_scene_methods_raise(file: Path) -> None:
    scene = open_scene(file, asset_roots=(root for root in [str(file.parent)]))
    assert scene._given.get("asset_roots") == (str(file.parent),)
    with pytest.raises(TypeError, match="must be a scene from `open_scene`, not str"):
        scene.diff(str(file))  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match="audit must be True or False, not 'some'"):
        scene.build(audit="some")  # pyright: ignore[reportArgumentType]
    for wrong in ({"limits": 3}, {"asset_roots": 3}, {"asset_roots": [3]}):
        with pytest.raises(TypeError, match=f"{next(iter(wrong))} must be .*, not"):
            open_scene(file, **wrong)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="Open the scene by its path, or call `view_scene` with the stream"):
        open_scene(io.StringIO(SCENE)).view()
    for flag in ("grid", "collision", "hidden"):
        with pytest.raises(TypeError, match=f"{flag} must be True or False, not 'yes'"):
            scene.render(**{flag: "yes"})  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match="build must be True or False, not 1"):
        scene.inspect(build=1)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="depth must be at least 0, not -1"):
        scene.inspect(build=False, depth=-1)
    with pytest.raises(TypeError, match="depth must be an integer"):
        scene.inspect(build=False, depth=1.5)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("method", "given", "wanted"),
    [
        ("page", {"options": 3}, "a ViewOptions"),
        ("page", {"steps": True}, "an integer"),
        ("view", {"options": 3}, "a ViewOptions"),
        ("view", {"address": "localhost"}, "a PageAddress"),
        ("view", {"on_ready": 3}, "a function"),
        ("render", {"scenes": True}, "a string"),
        ("render", {"camera": 3}, "a string"),
        ("render", {"size": True}, "two integers"),
        ("render", {"size": "16x16"}, "two integers"),
        ("render", {"size": (16,)}, "two integers"),
        ("render", {"size": (16, 1.5)}, "two integers"),
        ("render", {"what": ["color"]}, "one of color, depth, segmentation, normal"),
        ("render", {"video": ["gif"]}, "one of gif, mp4"),
        ("render", {"path": 3}, "a string or a path"),
        ("build", {"audit": "full"}, "True or False"),
        ("build", {"render": "no"}, "True or False"),
        ("build", {"scene_idxs": 3}, "integers, as in [0, 2] or range(4)"),
        ("build", {"scene_idxs": "01"}, "integers, as in [0, 2] or range(4)"),
        ("emit", {"target": "glb", "show": ["visual"]}, "one of visual, collision"),
        ("emit", {"target": "urdf", "name": 3}, "a string"),
        ("emit", {"target": "urdf", "entity": 3}, "a string"),
        ("emit", {"target": "urdf", "progress": 3}, "a function"),
        ("emit", {"target": "json", "base": 3}, "a string or a path"),
        ("export", {"path": 3}, "a string or a path"),
        ("inspect", {"entity": 3}, "a string"),
        ("inspect", {"progress": 3}, "a function"),
    ],
)
def test_an_argument_of_the_wrong_type_is_named_with_the_expected_one(
    file: Path, method: str, given: dict[str, Any], wanted: str
) -> None:
    name, value = list(given.items())[-1]
    message = f"Scene.{method}(): {name} must be {wanted}, not {value!r}"
    with pytest.raises(TypeError, match=f"^{re.escape(message)}$"):
        getattr(open_scene(file), method)(**given)


@pytest.mark.parametrize(
    ("name", "given", "wanted"),
    [
        ("validate", {"rules": ["SC4"]}, "rules must be a mapping from names to values, not ['SC4']"),
        ("check_scene", {"settle": "a"}, "settle must be a number, not 'a'"),
        ("check_scene", {"settle": True}, "settle must be a number, not True"),
        ("check_scene", {"seeds": 3}, "seeds must be integers, as in [0, 2] or range(4), not 3"),
        ("check_scene", {"seeds": "0:2"}, "seeds must be integers, as in [0, 2] or range(4), not '0:2'"),
        ("build_scene", {"scenes": 3}, "scenes must be a string, not 3"),
        ("build_scene", {"dry_run": 1}, "dry_run must be True or False, not 1"),
        ("load_scene", {"audit": "off"}, "audit must be True or False, not 'off'"),
        ("export_page", {"options": 3}, "options must be a ViewOptions, not 3"),
        ("view_scene", {"options": 3}, "options must be a ViewOptions, not 3"),
        ("emit_scene", {"target": "json", "base": 3}, "base must be a string or a path, not 3"),
        ("plan_text", {}, "plan must be a ScenePlan, not "),
        ("list_params", {"limits": 3}, "limits must be a mapping from names to values, not 3"),
        ("open_scene", {"asset_roots": ["a", 3]}, "asset_roots must be paths of folders, not ['a', 3]"),
    ],
)
def test_type_errors_name_the_function_and_the_argument(
    file: Path, name: str, given: dict[str, Any], wanted: str
) -> None:
    with pytest.raises(TypeError, match=f"^{re.escape(f'{name}(): {wanted}')}"):
        getattr(scenecc, name)(file, **given)


def test_items_of_an_iterator_are_checked_when_read(file: Path) -> None:
    roots: Any = (root for root in [3])
    with pytest.raises(TypeError, match=r"^asset_roots must be paths of folders, not 3$"):
        scenecc.validate(file, asset_roots=roots)


def test_an_asset_root_must_be_a_folder(file: Path) -> None:
    with pytest.raises(ValueError, match=r"^asset_roots: there is no folder `.*nodir`$"):
        scenecc.validate(file, asset_roots=[file.parent, file.parent / "nodir"])
    with pytest.raises(ValueError, match=r"^asset_roots: `.*` is not a folder$"):
        open_scene(file, asset_roots=[file])


@pytest.mark.parametrize(
    ("function", "target", "writer"), [("emit_scene", "mjcf", "export_scene"), ("export_scene", "json", "emit_scene")]
)
def test_a_target_of_another_function_names_that_function(file: Path, function: str, target: str, writer: str) -> None:
    with pytest.raises(ValueError, match=rf"^unknown target '{target}'; use `{writer}` for it; the targets are "):
        getattr(scenecc, function)(file, target)


@pytest.mark.parametrize("method", ["export", "render"])
def test_a_path_with_a_null_character_is_refused_before_anything_is_built(file: Path, method: str) -> None:
    with pytest.raises(
        ValueError, match=rf"^Scene\.{method}\(\): path must not contain a null character: 'a\\x00\.glb'$"
    ):
        getattr(open_scene(file), method)("a\0.glb")
    with pytest.raises(ValueError, match="asset_roots must not contain a null character"):
        open_scene(file, asset_roots=["a\0"])


def test_names_are_compared_unless_they_follow_from_the_files(tmp_path: Path) -> None:
    def scene_named(stem: str, text: str) -> Path:
        path = tmp_path / f"{stem}.yaml"
        path.write_text(f"scenecc: 1\n{text}entities: {{ball: {{shapes: [{{type: sphere, radius: 0.1}}]}}}}\n")
        return path

    def found(first: str, second: str) -> list[tuple[str, str | None, str | None]]:
        both = scene_named("na", first), scene_named("nb", second)
        return [(one.path, one.a, one.b) for one in scenecc.compare_scenes(*both)]

    assert found("", "") == []
    assert found("name: na\n", "name: nb\n") == [("name", "na", "nb")]
    assert found("name: na\n", "") == [("name", "na", "nb")]


def test_functions_and_scene_methods_agree(file: Path) -> None:
    scene = open_scene(file)
    assert scenecc.emit_scene(file, "json", base=file.parent) == scene.emit("json", base=file.parent).text
    assert scenecc.export_scene(file, "mjcf", seed=3) == open_scene(file, seed=3).emit("mjcf").files
    assert scenecc.inspect_scene(file, build=False) == scene.inspect(build=False).item
    other = open_scene(file, seed=9)
    assert scenecc.compare_scenes(scene.plan, other.plan) == scene.diff(other).differences
    assert json.loads(scene.emit("json").text)["scenecc_plan"]


@pytest.mark.parametrize(
    ("method", "arguments", "wrong", "near"),
    [
        ("emit", ("json",), "sceen", "scene"),
        ("export", ("scene.json",), "gird", "grid"),
        ("export", ("scene.json",), "name", "scene"),
        ("render", (), "camra", "camera"),
        ("inspect", (), "dept", "depth"),
        ("build", (), "scenes", "scene_idxs"),
        ("build", (), "rendr", "render"),
    ],
)
def test_an_unknown_keyword_of_a_method_names_the_method_and_the_nearest_keyword(
    file: Path, method: str, arguments: tuple[str, ...], wrong: str, near: str
) -> None:
    said = rf"^Scene\.{method}\(\) has no argument `{wrong}`; (did you mean `{near}`\?|the nearest here: .*\b{near}\b)"
    with pytest.raises(TypeError, match=said):
        getattr(open_scene(file), method)(*arguments, **{wrong: 1})


@pytest.mark.parametrize("option", ["seed", "params"])
def test_methods_take_no_compile_options(file: Path, option: str) -> None:
    with pytest.raises(TypeError, match=rf"Scene\.inspect\(\) has no argument `{option}`"):
        open_scene(file).inspect(**{option: 1})  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("name", "arguments", "wrong", "near"),
    [
        ("open_scene", (), "sedd", "seed"),
        ("validate", (), "param", "params"),
        ("compile_scene", (), "sedd", "seed"),
        ("load_scene", (), "rendr", "render"),
        ("load_scene", (), "scenes", "scene_idxs"),
        ("build_scene", (), "dry_rn", "dry_run"),
        ("emit_scene", ("json",), "num_scene", "num_scenes"),
        ("export_scene", ("mjcf",), "foldr", "folder"),
        ("inspect_scene", (), "entiy", "entity"),
        ("render_scene", (), "camra", "camera"),
    ],
)
def test_an_unknown_keyword_of_a_function_names_a_public_function(
    file: Path, name: str, arguments: tuple[str, ...], wrong: str, near: str
) -> None:
    with pytest.raises(TypeError, match=rf"^{name}\(\) has no argument `{wrong}`; did you mean `{near}`\?"):
        getattr(scenecc, name)(file, *arguments, **{wrong: 1})


@pytest.mark.parametrize("wrong", ["no", 1, None])
def test_flag_arguments_must_be_true_or_false(file: Path, wrong: Any) -> None:
    uses = (
        lambda: scenecc.validate(file, allow_outside_assets=wrong),
        lambda: scenecc.export_scene(file, "glb", grid=wrong),
        lambda: scenecc.export_scene(file, "usd", binary=wrong),
    )
    for use in uses:
        with pytest.raises(TypeError, match="must be True or False"):
            use()


@pytest.mark.parametrize("target", ["", "JSON", ["json"], None])
def test_an_unknown_target_is_refused_with_the_known_ones(file: Path, target: Any) -> None:
    scene = open_scene(file)
    uses = (
        lambda: scene.emit(target),
        lambda: scenecc.emit_scene(file, target),
        lambda: scenecc.export_scene(file, target),
        *([] if target is None else [lambda: scene.export(file.with_suffix(".json"), target=target)]),
    )
    for use in uses:
        with pytest.raises(ValueError, match=r"^unknown target .*; the targets are \w+"):
            use()
    assert not file.with_suffix(".json").exists()


@pytest.mark.parametrize("mode", ["r", "rb"])
def test_a_stream_closed_too_early_is_refused_with_a_hint(file: Path, mode: str) -> None:
    with file.open(mode) as stream:
        scene = open_scene(stream)
    for use in (lambda: scene.diagnostics, lambda: scene.plan, lambda: scenecc.validate(stream)):
        with pytest.raises(ValueError, match="is closed: keep it open"):
            use()


@pytest.mark.parametrize(
    ("name", "choices", "words"),
    [
        ("picture.jpg", {}, "picture.jpg must end in one of .png, .mp4, .gif"),
        ("picture", {}, "picture must end in one of"),
        ("video.mp4", {"video": "gif", "steps": 1}, "video is 'gif', but video.mp4 has another suffix"),
        ("video.gif", {}, "video needs at least 1 step"),
    ],
)
def test_a_picture_suffix_must_fit_the_rendering(file: Path, name: str, choices: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        open_scene(file).render(file.parent / name, **choices)
    assert not (file.parent / name).exists()


@pytest.mark.render
def test_the_suffix_selects_picture_or_video(file: Path) -> None:
    scene = open_scene(file)
    made = scene.render(file.parent / "picture.PNG", size=(16, 16), steps=2, video="gif")
    assert (file.parent / "picture.PNG").read_bytes() == made.png()
    assert made.video is not None
    video = scene.render(file.parent / "video.gif", size=(16, 16), steps=2)
    assert (file.parent / "video.gif").read_bytes() == video.video
    assert made.video == video.video
