"""A file with overrides means the same as the file written out by hand."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples

from scenecc import compile_scene, emit_scene, validate
from scenecc.plan import ScenePlan

Node = dict[str, Any]

BALL = {"type": "sphere", "radius": 0.5}
OBJECTS: dict[str, dict[str, Node]] = {
    "materials": {
        "wood": {"physical": {"static_friction": 0.5, "dynamic_friction": 0.4}, "visual": {"roughness": 0.5}},
        "steel": {"visual": {"metallic": 1}},
    },
    "frames": {"spot": {"pose": {"p": [0, 0, 1], "rpy_deg": [0, 0, 30]}}},
    "entities": {
        "box": {
            "pose": {"p": [0, 1, 2], "q": [0.6, 0.8, 0, 0], "relative_to": "spot"},
            "mass": 2,
            "material": "wood",
            "shapes": [{"type": "box", "half_size": [0.1, 0.2, 0.3]}, {**BALL, "material": "steel"}, BALL],
        },
        "arm": {
            "links": {"h.*": {"linear_damping": 1, "mass": 2}, "hand": {"mass": 3}},
            "drives": {".*": {"stiffness": 10}, "slide": {"damping": 2}},
            "root": {
                "name": "base",
                "shapes": [BALL],
                "children": [
                    {
                        "name": "hand",
                        "shapes": [BALL],
                        "joint": {"name": "slide", "type": "prismatic", "limits": [0, 1]},
                    }
                ],
            },
        },
    },
    "lights": {"lamp": {"type": "point", "position": [0, 0, 3], "color": [1, 1, 1]}},
    "cameras": {"eye": {"pose": [0, 0, 1], "fovy_deg": 50, "mount": "arm/hand"}},
    "constraints": {"tie": {"type": "weld", "parent": "arm/hand", "child": "box", "pose_in_child": [0, 0, 1]}},
}
"""What a prefab holds."""

numbers = st.integers(1, 9).map(lambda number: number / 4)
points = st.lists(st.integers(-4, 4), min_size=3, max_size=3)
given_numbers = numbers | st.just({"uniform": [1, 2]}) | st.sampled_from(["${k}", "${k + lean}"])

CHANGES: dict[tuple[str, str], st.SearchStrategy[tuple[Node, list[tuple[tuple[Any, ...], Any, tuple[str, ...]]]]]] = {}
"""Object → an override, and the same as changes by hand: where, what, and which keys beside it go."""


def change(
    section: str, name: str, *options: st.SearchStrategy[tuple[Node, tuple[Any, ...], Any, tuple[str, ...]]]
) -> None:
    def joined(made: list[tuple[Node, tuple[Any, ...], Any, tuple[str, ...]]]) -> Any:
        override: Node = {}
        for part, *_ in made:
            _join(override, part)
        return override, [tuple(rest) for _, *rest in made]

    CHANGES[section, name] = st.lists(
        st.sampled_from(range(len(options))), min_size=1, max_size=len(options), unique=True
    ).flatmap(lambda chosen: st.tuples(*(options[i] for i in chosen)).map(lambda made: joined(list(made))))


def _join(node: Node, more: Node) -> None:
    for key, item in more.items():
        if isinstance(node.get(key), dict) and isinstance(item, dict):
            _join(node[key], item)
        else:
            node[key] = item


def at(*path: Any, value: st.SearchStrategy[Any], without: tuple[str, ...] = ()) -> Any:
    """An override of one value: keys of a path that are numbers are indices."""

    def made(found: Any) -> tuple[Node, tuple[Any, ...], Any, tuple[str, ...]]:
        node = found
        for key in reversed(path):
            node = {str(key): node}
        return node, path, found, without

    return value.map(made)


change(
    "materials",
    "wood",
    at("physical", "restitution", value=numbers.map(lambda x: x / 4)),
    at("visual", "ior", value=numbers.map(lambda x: x + 1)),
)
change(
    "frames", "spot", at("pose", "p", value=points), at("pose", "q", value=st.just([0, 1, 0, 0]), without=("rpy_deg",))
)
change(
    "entities",
    "box",
    at("pose", "p", value=points | st.just({"uniform": [[0, 0, 0], [1, 1, 1]]})),
    at("pose", "rpy_deg", value=points, without=("q",)),
    at("inertial", value=st.just({"mass": 1, "inertia": [1, 1, 1]}), without=("mass",)),
    at("linear_damping", value=given_numbers),
    at("shapes", 1, "radius", value=given_numbers),
    at("shapes", 0, "half_size", 2, value=numbers),
    at("shapes", 2, "material", value=st.just({"visual": {"roughness": 0.25}})),
)
change(
    "entities",
    "arm",
    at("qpos", value=st.just({"slide": 0.5})),
    at("root", "children", 0, "joint", "limits", 1, value=st.integers(2, 5)),
)
change(
    "lights",
    "lamp",
    at("color", value=points.map(lambda p: [abs(x) for x in p])),
    at("position", 0, value=given_numbers),
)
change("cameras", "eye", at("fovx", value=st.just(1), without=("fovy_deg",)), at("pose", value=points))
change("constraints", "tie", at("pose_in_child", value=points))


def apply(node: Any, path: tuple[Any, ...], value: Any, without: tuple[str, ...]) -> None:
    for key in path[:-1]:
        node = node.setdefault(key, {}) if isinstance(node, dict) else node[key]
    for key in without:
        node.pop(key, None)
    node[path[-1]] = value


def write(file: Path, document: Node) -> None:
    file.write_text(yaml.safe_dump(document, sort_keys=False))


def without_recipes(plan: ScenePlan) -> Any:
    """A plan as plain data, without its recipes: one reads the outer file's draws, the other its own parameters."""

    def plain(node: Any) -> Any:
        if isinstance(node, dict):
            return {key: plain(item) for key, item in node.items() if key not in {"recipe", "draws"}}
        return [plain(item) for item in node] if isinstance(node, list) else node

    return plain(json.loads(emit_scene(plan, "json")))


def plan_of(folder: Path, document: Node) -> ScenePlan:
    file = folder / "scene.yaml"
    write(file, document)
    return compile_scene(file)


HEAD: Node = {"scenecc": 1, "num_scenes": 3, "params": {"k": 2}, "draws": {"lean": {"uniform": [0, 1]}}}
INNER_HEAD: Node = {"scenecc": 1, "params": {"k": 2, "lean": 0.5}}
"""What `${…}` reads is the same in both files."""


@pytest.mark.quick
@given(st.data())
@settings(max_examples=examples(40), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_overrides_mean_what_a_person_would_write(tmp_path: Path, data: st.DataObject) -> None:
    by_hand = json.loads(json.dumps(OBJECTS))  # nothing of it stands at two places
    overrides: list[Node] = [{}, {}]
    for section, name in data.draw(st.lists(st.sampled_from(list(CHANGES)), min_size=1, unique=True)):
        key = name if section == "entities" else f"{section}/{name}"
        # The inner file's own override first, so that the outer one wins.
        for number in (0, 1) if data.draw(st.booleans()) else (1,):
            override, changes = data.draw(CHANGES[section, name])
            overrides[number][key] = override
            for path, value, without in changes:
                apply(by_hand[section][name], path, value, without)
    inner: Node = {"use": "inner.yaml", "prefix": "", "override": overrides[0]}
    shared: Node = {"prefix": "", "with": {"lean": "${lean}"}}
    middle: Node = {"use": "middle.yaml", **shared, "override": overrides[1]}
    write(tmp_path / "inner.yaml", {"scenecc": 1, **OBJECTS})
    write(tmp_path / "middle.yaml", {**INNER_HEAD, "entities": {"i": inner}})
    write(tmp_path / "whole.yaml", {**INNER_HEAD, **by_hand})
    short = {**HEAD, "entities": {"m": middle}}
    long = {**HEAD, "entities": {"m": {"use": "whole.yaml", **shared}}}
    one, other = plan_of(tmp_path, short), plan_of(tmp_path, long)
    assert [entity.name for entity in one.entities] == [entity.name for entity in other.entities]
    assert without_recipes(one) == without_recipes(other)


@pytest.mark.parametrize("section", ["lights", "cameras", "constraints", "entities"])
def test_what_is_removed_is_as_if_it_had_not_been_written(tmp_path: Path, section: str) -> None:
    for name in OBJECTS[section]:
        left = copy.deepcopy(OBJECTS)
        del left[section][name]
        for key in ("cameras", "constraints") if section == "entities" else ():
            # They hold on to the entities.
            del left[key]
        gone = ["cameras/eye", "constraints/tie", name] if section == "entities" else [f"{section}/{name}"]
        write(tmp_path / "all.yaml", {"scenecc": 1, **OBJECTS})
        write(tmp_path / "left.yaml", {"scenecc": 1, **left})
        use = {"use": "all.yaml", "override": dict.fromkeys(gone, "remove")}
        assert plan_of(tmp_path, {"scenecc": 1, "entities": {"m": use}}) == plan_of(
            tmp_path, {"scenecc": 1, "entities": {"m": {"use": "left.yaml"}}}
        )


KEYS = (
    "pose", "p", "q", "relative_to", "shapes", "type", "radius", "material", "mass", "inertial", "uniform", "choice",
    "links", "drives", ".*", "root", "children", "joint", "repeat", "if", "with", "scene_idxs", "collision_group",
    "mount",
)  # fmt: skip

NAMES = (
    "box", "arm", "lights/lamp", "cameras/eye", "constraints/tie", "frames/spot", "materials/wood", "zzz", "a/b/c",
)  # fmt: skip

ANYTHING: st.SearchStrategy[Any] = st.recursive(
    st.sampled_from([0, -1, 1e300, True, "", "remove", "box", "world", "${k}", "${lean}", "${nope}", "a/b"]),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["0", "1", "7", *KEYS]), inner, max_size=4)
    ),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(NAMES), ANYTHING, max_size=4))
@settings(max_examples=examples(40), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_override_gives_diagnostics_and_no_exception(tmp_path: Path, override: Node) -> None:
    write(tmp_path / "all.yaml", {"scenecc": 1, **OBJECTS})
    file = tmp_path / "scene.yaml"
    write(file, {**HEAD, "entities": {"m": {"use": "all.yaml", "override": override}}})
    for found in validate(file):
        assert found.location is not None
