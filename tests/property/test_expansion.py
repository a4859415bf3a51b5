"""A file that repeats, or uses another, means the same as the file written out."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples

from scenecc import compile_scene
from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.expand.documents import scene_loader
from scenecc.expand.expand import expand
from scenecc.expand.expansion import Expansion
from scenecc.named_files import mesh_measurer
from scenecc.source import Limits, read_dict
from scenecc.source.paths import AssetScope

NAMES = ("i", "j", "k")
numbers = st.integers(-5, 5)


@st.composite
def axes(draw: st.DrawFn) -> dict[str, Any]:
    """A `repeat`: some names, each with a list or a count."""
    names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True))
    counts = st.builds(lambda count: {"count": count}, st.integers(0, 3))
    lists = st.lists(numbers, min_size=1, max_size=3, unique=True)
    return {name: draw(lists | counts) for name in names}


def copies(repeat: Mapping[str, Any]) -> list[dict[str, int]]:
    """What the variables are in each copy."""
    lists = [range(axis["count"]) if isinstance(axis, dict) else axis for axis in repeat.values()]
    return [dict(zip(repeat, values, strict=True)) for values in itertools.product(*lists)]


@st.composite
def fields(draw: st.DrawFn, names: tuple[str, ...]) -> tuple[Any, Any]:
    """A number as written, and the function that gives its value from those of the variables."""
    base = draw(st.floats(-2, 2, width=32))
    if not draw(st.booleans()):
        return base, lambda values: base
    name, factor = draw(st.sampled_from((*names, "gap"))), draw(numbers)
    return f"${{{base!r} + {name} * {factor}}}", lambda values: base + values[name] * factor


class Written:
    """Two ways of writing one scene."""

    def __init__(self) -> None:
        self.short: dict[str, Any] = {}
        self.long: dict[str, Any] = {}


@st.composite
def scenes(draw: st.DrawFn) -> Written:
    scene = Written()
    gap = draw(numbers)
    for index in range(draw(st.integers(1, 3))):
        outer = draw(axes())
        inner = draw(axes().map(lambda found: {f"{name}{name}": axis for name, axis in found.items()}))
        pose = [draw(fields(tuple(outer))) for _ in range(3)]
        place = [draw(fields((*outer, *inner))) for _ in range(3)]
        name = f"e{index}"
        fixed = {"type": "sphere", "radius": 0.5}
        scene.short[name] = {
            "repeat": outer,
            "body_type": "static",
            "pose": [text for text, _ in pose],
            "shapes": [fixed, {"repeat": inner, **fixed, "pose": [text for text, _ in place]}, fixed],
        }
        for number, values in enumerate(copies(outer)):
            known = {**values, "gap": gap}
            shapes = [{**fixed, "pose": [f({**known, **more}) for _, f in place]} for more in copies(inner)]
            scene.long[f"{name}_{number}"] = {
                "body_type": "static",
                "pose": [f(known) for _, f in pose],
                "shapes": [fixed, *shapes, fixed],
            }
    scene.short = {"scenecc": 1, "params": {"gap": gap}, "entities": scene.short}
    scene.long = {"scenecc": 1, "entities": scene.long}
    _others(draw, scene, gap)
    return scene


BALL = {"type": "sphere", "radius": 0.5}
OTHERS: dict[str, dict[str, Any]] = {
    "entities": {"root": {"name": "r", "shapes": [BALL]}},
    "constraints": {"type": "weld", "parent": "world", "child": "bob"},
    "lights": {"type": "point", "color": [1, 1, 1]},
    "cameras": {"width": 8, "height": 8},
}
PLACES = {"constraints": "pose_in_child", "lights": "position"}
"""Where a place stands that is no `pose`."""


def _others(draw: st.DrawFn, scene: Written, gap: int) -> None:
    """What is repeated beside bodies: an articulation, and what holds on to a body of its own."""
    for written in (scene.short, scene.long):
        written["entities"]["bob"] = {"pose": [0, 0, 1], "shapes": [BALL]}
    for section, keys in OTHERS.items():
        repeat = draw(axes())
        place = [draw(fields(tuple(repeat))) for _ in range(3)]
        key, name = PLACES.get(section, "pose"), f"more_{section}"
        short, long = scene.short.setdefault(section, {}), scene.long.setdefault(section, {})
        short[name] = {"repeat": repeat, **keys, key: [text for text, _ in place]}
        for number, values in enumerate(copies(repeat)):
            known = {**values, "gap": gap}
            long[f"{name}_{number}"] = {**keys, key: [f(known) for _, f in place]}


def expanded(data: dict[str, Any], folder: Path) -> Expansion:
    sink, limits = Sink(), Limits()
    document = read_dict(data, sink)
    assert document is not None
    found = expand(
        document,
        params={},
        num_scenes=None,
        seed=None,
        draws=(),
        load=scene_loader(AssetScope(folder), limits, sink),
        measure=mesh_measurer(AssetScope(folder), limits, sink),
        limits=limits,
        sink=sink,
    )
    assert found is not None, sink.diagnostics()
    return found


@given(scenes())
@settings(max_examples=examples(60), deadline=None)
def test_a_repeated_file_is_the_file_written_out(scene: Written) -> None:
    found = expanded(scene.short, Path())
    short, long = compile_scene(scene.short), compile_scene(scene.long)
    for section in OTHERS:
        expected = scene.long[section]
        assert found.data.get(section, {}) == expected
        assert list(found.data.get(section, {})) == list(expected)
        assert getattr(short, section) == getattr(long, section)


@given(scenes())
@settings(max_examples=examples(30), deadline=None)
def test_every_node_is_led_back_to_one_that_is_written(scene: Written) -> None:
    found = expanded(scene.short, Path())
    for name, entity in found.data.get("entities", {}).items():
        if not name.startswith("e"):
            continue
        for path in [("pose", 0), *(("shapes", index, "radius") for index in range(len(entity["shapes"])))]:
            origin = found.trace(Origin(None, ("entities", name, *path)))
            node: Any = scene.short
            for step in origin.path:
                node = node[step]
            several = len(list(copies(scene.short["entities"][origin.path[1]]["repeat"]))) > 1
            assert bool(origin.copy) == several or path[0] == "shapes"
            assert origin.path[1] == name.split("_")[0]


@given(scene=scenes(), place=st.lists(st.floats(-3, 3, width=32), min_size=3, max_size=3))
@settings(max_examples=examples(25), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_prefab_at_a_place_is_its_file_at_that_place(
    scene: Written, place: list[float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import json

    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.yaml").write_text(json.dumps(scene.short))
    used = compile_scene({"scenecc": 1, "entities": {"part": {"use": "part.yaml", "pose": place}}})
    by_hand = compile_scene({"scenecc": 1, "frames": {"here": {"pose": place}}, **_put("here", scene.long)})
    for section in OTHERS:
        inside, outside = getattr(used, section), getattr(by_hand, section)
        assert [one.name.replace("/", ".") for one in inside] == [one.name for one in outside]
        fields_compared = COMPARED.get(section, ("pose",))
        for one, other in zip(inside, outside, strict=True):
            for field in ("scene_idxs", *fields_compared):
                assert getattr(one, field) == getattr(other, field)


COMPARED = {
    "entities": ("pose", "structures"),
    "constraints": ("joint", "pose_in_parent", "pose_in_child"),
    "cameras": ("pose", "lens"),
}
"""Fields of the plan that tell no name."""


def _put(frame: str, written: dict[str, Any]) -> dict[str, Any]:
    """What a file holds, by the names that a prefab gives, relative to a frame."""
    found: dict[str, Any] = {}
    for section in OTHERS:
        for name, one in written[section].items():
            put = dict(one)
            if section == "constraints":
                put["child"] = f"part.{put['child']}"
            else:
                put["pose"] = {"p": put.pop("position" if section == "lights" else "pose"), "relative_to": frame}
            found.setdefault(section, {})[f"part.{name}"] = put
    return found
