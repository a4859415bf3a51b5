"""Any valid scene compiles and comes back; any mutation of one gives diagnostics and never an exception."""

from __future__ import annotations

import copy
import io
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import jsonschema
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.scene_models import ARTICULATIONS, all_keys, choices, written
from plugins.scene_nodes import is_copied, nodes
from plugins.scene_strategy import FOLDER, document, documents, randoms

from scenecc import compile_scene, emit_scene, json_schema, load_scene, validate
from scenecc.diagnostics.codes import CODES
from scenecc.spec.articulation import TreeLink
from scenecc.spec.document import SceneFile
from scenecc.spec.pose import FrameSpec

slow_to_draw = settings(
    max_examples=examples(60), suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)


@pytest.fixture(autouse=True, scope="module")
def _beside_the_assets() -> Iterator[None]:
    """A dict names its files from the current folder."""
    before = Path.cwd()
    os.chdir(FOLDER)
    yield
    os.chdir(before)


def shown(found: list[Any]) -> list[str]:
    return [str(diagnostic) for diagnostic in found]


@pytest.mark.quick
@given(documents())
@slow_to_draw
def test_a_valid_scene_has_no_error(scene: dict[str, Any]) -> None:
    found = [diagnostic for diagnostic in validate(scene) if diagnostic.severity == "error"]
    assert not found, shown(found)


def test_every_key_and_choice_of_the_language_is_generated() -> None:
    random, keys, words = Random(0), set(), set()
    written_by = (SceneFile, *ARTICULATIONS)
    # The key is known of any link, and a root has none.
    wanted = {*all_keys(*written_by)} - {(TreeLink, "joint")}, {*choices(*written_by)}
    # Of instances alone, whose frames the expansion writes.
    wanted[0].discard((FrameSpec, "place"))
    wanted[0].discard((SceneFile, "starts"))  # a file that only `settle` can make
    for _ in range(1500):
        if wanted[0] <= keys and wanted[1] <= words:
            break
        for key, value in written(SceneFile, document(random)):
            keys.add(key)
            words.update((key, item) for item in (value if isinstance(value, list) else [value]) if _is_word(item))
    assert not sorted(f"{model.__name__}.{name}" for model, name in wanted[0] - keys)
    assert not sorted(f"{model.__name__}.{name}: {word}" for (model, name), word in wanted[1] - words)


def _is_word(item: Any) -> bool:
    return isinstance(item, (str, int)) and not isinstance(item, bool)


@given(documents())
@slow_to_draw
def test_a_plan_comes_back_from_its_json(scene: dict[str, Any]) -> None:
    plan = compile_scene(scene)
    text = emit_scene(plan, "json")
    again = compile_scene(text)
    assert again == plan
    assert emit_scene(again, "json") == text


@given(documents())
@slow_to_draw
def test_a_scene_read_back_from_yaml_gives_the_same_plan(scene: dict[str, Any]) -> None:
    plan = compile_scene(scene)
    for text in (yaml_text(scene), json_text(scene)):
        assert compile_scene(io.StringIO(text)) == plan


class _Quoting(yaml.SafeDumper):
    """Quotes every text: PyYAML writes by the rules of YAML 1.1, by which other words are numbers."""

    def ignore_aliases(self, data: object) -> bool:
        return True


_Quoting.add_representer(str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"'))


def yaml_text(scene: dict[str, Any]) -> str:
    return yaml.dump(scene, Dumper=_Quoting, sort_keys=False, allow_unicode=True)


def json_text(scene: dict[str, Any]) -> str:
    """JSON, but for what it has no number for."""
    return json.dumps(scene, ensure_ascii=False).replace("Infinity", ".inf")


@pytest.fixture(scope="module")
def schema() -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(json_schema())


@given(scene=documents())
@settings(slow_to_draw, max_examples=examples(30))
def test_the_schema_takes_a_valid_scene(scene: dict[str, Any], schema: jsonschema.Draft202012Validator) -> None:
    assert [error.message for error in schema.iter_errors(scene)] == []


def quick(scene: dict[str, Any]) -> dict[str, Any]:
    """A scene without what takes long to build: CoACD takes seconds, and distance fields tenths of one."""
    for node in nodes(scene):
        if node.pop("decomposition", None):
            node.pop("decomposition_params", None)
        if node.get("type") == "triangle_mesh" and node.pop("sdf", None):
            node["type"] = "convex_mesh"
    return scene


@pytest.mark.quick
@given(documents().map(quick))
@settings(slow_to_draw, max_examples=examples(40))
def test_a_valid_scene_is_built_as_it_is_written(scene: dict[str, Any]) -> None:
    with load_scene(scene, render=False) as batch:
        for section, found in (
            ("entities", [*batch.entities, *batch.articulations]),
            ("constraints", batch.constraints),
            ("lights", batch.lights),
            ("cameras", batch.cameras),
        ):
            # Copies have names of their own.
            alone = [name for name, one in scene.get(section, {}).items() if not is_copied(one)]
            assert set(alone) <= set(found)
        batch.step()


def built_by_script(scene: dict[str, Any], *, render: bool) -> list[Any]:
    """The scenes that the emitted script builds, in this process."""
    text = emit_scene(compile_scene(scene), "python")
    module: dict[str, Any] = {"__name__": "scenes", "__file__": str(FOLDER / "scenes.py")}
    exec(compile(text, "scenes.py", "exec"), module)
    return module["build_scenes"](render=render)


def assert_script_builds_the_same(scene: dict[str, Any], *, render: bool = False) -> None:
    from fidelity import compare

    scripted = built_by_script(scene, render=render)
    with load_scene(scene, render=render) as batch:
        for ours, theirs in zip(batch.scenes, scripted, strict=True):
            compare.assert_same_scene(ours, theirs)
        compare.assert_same_trajectory(batch.scenes, scripted, steps=3)


@given(documents().map(quick))
@settings(slow_to_draw, max_examples=examples(40))
def test_an_emitted_script_builds_what_is_built(scene: dict[str, Any]) -> None:
    assert_script_builds_the_same(scene)


def small(scene: dict[str, Any]) -> dict[str, Any]:
    """A scene whose pictures software draws in little time; ray tracing needs a device that has it."""
    for camera in scene.get("cameras", {}).values():
        camera |= {"width": 16, "height": 12, "shader": "default"}
    for light in scene.get("lights", {}).values():
        if "shadow_map_size" in light:
            light["shadow_map_size"] = 64
    return scene


@pytest.mark.render
@given(documents().map(quick).map(small))
@settings(slow_to_draw, max_examples=examples(10))
def test_and_what_is_seen_with_a_renderer(scene: dict[str, Any]) -> None:
    assert_script_builds_the_same(scene, render=True)


JUNK: list[Any] = [0, -1, 1e300, float("nan"), True, "", "x", "${x}", None, [], [1, 2], {}, {"uniform": [0, 1]}, 10**99]


def mutated(scene: dict[str, Any], random: Random) -> dict[str, Any]:
    """The scene with one to three things done to it."""
    scene = copy.deepcopy(scene)
    for _ in range(random.randint(1, 3)):
        containers = list(_containers(scene))
        container = random.choice(containers)
        keys = list(container) if isinstance(container, dict) else list(range(len(container)))
        change = random.choice(["delete", "rename", "replace", "swap", "insert"])
        if change == "insert" or not keys:
            if isinstance(container, dict):
                container[random.choice(["x", "mass", "pose", "type", "q", "use", "x-note", "shapes"])] = _junk(random)
            else:
                container.insert(random.randint(0, len(container)), _junk(random))
            continue
        key = random.choice(keys)
        other = random.choice(containers)
        if change == "delete":
            del container[key]
        elif change == "rename" and isinstance(container, dict):
            word = str(key)
            container[random.choice([word + "x", word[1:], word.upper(), "type"])] = container.pop(key)
        elif change == "swap" and other:
            place = random.choice(list(other) if isinstance(other, dict) else list(range(len(other))))
            one, two = copy.deepcopy(container[key]), copy.deepcopy(other[place])
            other[place] = one
            if isinstance(container, dict) or key < len(container):
                container[key] = two
        else:
            container[key] = _junk(random)
    return scene


def _junk(random: Random) -> Any:
    return copy.deepcopy(random.choice(JUNK))


def _containers(node: Any) -> Iterator[Any]:
    if isinstance(node, (dict, list)):
        yield node
        for item in node.values() if isinstance(node, dict) else node:
            yield from _containers(item)


def mutations() -> st.SearchStrategy[dict[str, Any]]:
    return randoms().map(lambda random: mutated(document(random), random))


@given(mutations())
@settings(slow_to_draw, max_examples=examples(200))
def test_a_mutated_scene_gives_diagnostics_at_places_that_exist(scene: dict[str, Any]) -> None:
    for diagnostic in validate(scene):
        assert diagnostic.code in CODES
        if diagnostic.file is not None:
            # In a prefab, whose use stands beside it.
            assert diagnostic.related
            continue
        path = parsed(diagnostic.path)
        assert exists(scene, path) or exists(scene, path[:-1]), str(diagnostic)


@given(mutations())
@slow_to_draw
def test_a_mutated_scene_gives_the_same_as_a_dict_and_as_a_text(scene: dict[str, Any]) -> None:
    by_dict, by_text = validate(scene), validate(io.StringIO(yaml_text(scene)))
    assert {(d.code, d.path) for d in by_text} == {(d.code, d.path) for d in by_dict}
    assert all(d.line is not None for d in by_text)


_STEP = re.compile(r'\.?([^.\[\]"]+)|\[(\d+)\]|\["((?:[^"\\]|\\.)*)"\]')


def parsed(path: str) -> list[str | int]:
    """A dotted path as keys and indices."""
    keys: list[str | int] = []
    end = 0
    for match in _STEP.finditer(path):
        assert match.start() == end, path
        end = match.end()
        name, index, quoted = match.groups()
        keys.append(int(index) if index else name or re.sub(r"\\(.)", r"\1", quoted))
    assert end == len(path), path
    return keys


def exists(node: Any, path: list[str | int]) -> bool:
    for key in path:
        items: Any = node
        if isinstance(key, str):
            there = isinstance(node, dict) and key in node
        else:
            there = isinstance(node, (list, tuple)) and key < len(node)
        if not there:
            return False
        node = items[key]
    return True
