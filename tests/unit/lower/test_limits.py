"""What one file may ask for."""

from __future__ import annotations

import time
from typing import Any

import pytest
from plugins.nightly import assert_took
from unit.lower.scenes import BALL, codes, scene

from scenecc import SceneError, compile_scene
from scenecc.source import Limits


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ({"objects": 3}, []),
        ({"objects": 2}, [("SC604", "entities")]),
        ({"scenes": 5}, []),
        ({"scenes": 4}, [("SC605", "num_scenes")]),
    ],
    ids=str,
)
def test_the_border_of_each_limit(limits: dict[str, int], expected: list[tuple[str, str]]) -> None:
    document = scene({"shapes": [*BALL, *BALL]}, num_scenes=5)
    document["entities"]["marker"] = {"body_type": "none", "visuals": BALL}
    assert codes(document, limits=limits) == expected


def test_what_is_no_body_counts_too() -> None:
    document = scene({"shapes": BALL}, num_scenes=5)
    document["lights"] = {name: {"type": "directional", "direction": [0, 0, -1], "color": [1, 1, 1]} for name in "ab"}
    assert codes(document, limits={"objects": 3}) == []
    assert codes(document, limits={"objects": 2}) == [("SC604", "entities")]


@pytest.mark.parametrize("count", [65_537, 10**11, 10**99])
def test_many_scenes_are_refused_at_once(count: int) -> None:
    started = time.process_time()
    assert codes(scene(num_scenes=count)) == [("SC605", "num_scenes")]
    assert codes(scene(), num_scenes=count) == [("SC605", "num_scenes")]
    assert_took(time.process_time() - started, most=0.5)


def test_few_bodies_in_many_scenes_are_refused_before_any_selection_is_made() -> None:
    entities = {f"b{i}": {"shapes": BALL} for i in range(199)}
    started = time.process_time()
    document = {"scenecc": 1, "num_scenes": 65_536, "entities": entities}
    assert codes(document) == [("SC604", "num_scenes")]
    assert_took(time.process_time() - started, most=1)


def test_a_thousand_misspelt_names_take_no_time() -> None:
    entities = {f"entity_{i}": {"shapes": BALL, "pose": {"relative_to": f"entyti_{i}"}} for i in range(1000)}
    started = time.process_time()
    assert len(codes({"scenecc": 1, "entities": entities})) == 1000
    assert_took(time.process_time() - started, most=5)


def test_a_circle_of_thousands_is_one_short_diagnostic() -> None:
    from scenecc import validate

    count = 5000
    frames = {f"f{i}": {"pose": {"relative_to": f"f{(i + 1) % count}"}} for i in range(count)}
    started = time.process_time()
    (found,) = validate({"scenecc": 1, "frames": frames})
    assert found.code == "SC304"
    assert len(found.message) < 500
    assert len(found.related) < 50
    assert_took(time.process_time() - started, most=5)


@pytest.mark.parametrize(
    ("idxs", "counted"),
    [(None, 12), ("::3", 4), ("2:4", 2), ([0, 5], 2), ([0, "6:"], 7), ("-3:", 3), (["::-1"], 12)],
    ids=str,
)
def test_an_entity_counts_in_the_scenes_that_it_is_in(idxs: Any, counted: int, monkeypatch: pytest.MonkeyPatch) -> None:
    keys = {"shapes": [*BALL, *BALL]} | ({} if idxs is None else {"scene_idxs": idxs})
    document = scene(keys, num_scenes=12)
    monkeypatch.setattr(Limits, "objects_in_all_scenes", 2 * counted)
    assert codes(document) == []
    monkeypatch.setattr(Limits, "objects_in_all_scenes", 2 * counted - 1)
    assert codes(document) == [("SC604", "num_scenes")]


def test_objects_in_all_scenes_are_a_multiple_of_objects() -> None:
    body = {"shapes": [*BALL, *BALL]}
    assert codes(scene(body, num_scenes=100), limits={"objects": 2}) == []
    assert codes(scene(body, num_scenes=101), limits={"objects": 2}) == [("SC604", "num_scenes")]


def test_thousands_of_bodies_of_one_scene_each() -> None:
    count = 4096
    entities = {f"b{i}": {"shapes": BALL, "scene_idxs": [i]} for i in range(count)}
    assert codes({"scenecc": 1, "num_scenes": count, "entities": entities}) == []


LISTS = {f"l{i}": f"${{[u + {i}] * 500}}" for i in range(4)}


@pytest.mark.parametrize(
    "draws",
    [
        {name: text.replace("u", "scene") for name, text in LISTS.items()},
        {"u": {"uniform": [0, 1]}, **LISTS},
        {"u": {"uniform": [0, 1]}, **{f"l{i}": f"${{u + {i}}}" for i in range(40)}},
    ],
    ids=["lists of the scene", "lists of draws", "many expressions"],
)
def test_an_exceeded_limit_of_operations_is_reported_once(draws: dict[str, Any]) -> None:
    entities = {f"e{name}": {"mass": f"${{{name}[0] + 1}}", "shapes": BALL} for name in draws if name in LISTS}
    document = scene(draws=draws, num_scenes=300)
    document["entities"] |= entities
    assert [code for code, _ in codes(document, limits={"objects": 100}) if code != "SC319"] == ["SC604"]


def test_operations_of_the_recipes_count_too() -> None:
    """The rows of a fixed draw are computed in all scenes, though a field reads only those of one."""
    draws = {"u": {"once": {"uniform": [0, 1]}}, "d": {"once": "${[u] * 8}"}, "w": {"uniform": [0, 1]}}
    body = {"scene_idxs": [0], "pose": ["${d[0] + w}", 0, 0]}
    document = scene(body, draws=draws, num_scenes=3000)
    assert codes(document, limits={"objects": 200}) == []
    with pytest.raises(SceneError) as caught:
        compile_scene(document, limits={"objects": 200})
    assert [(one.code, one.path) for one in caught.value.diagnostics] == [("SC604", "draws.d.once")]
