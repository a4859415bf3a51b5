from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import find as find_example
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.plan_strategy import plans
from plugins.sample_plans import ROOT, SAMPLES, entity, pose, solid
from plugins.structures import body_of

from scenecc import compile_scene, plan_text, validate
from scenecc import plan as plan_package
from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import (
    BodyStructure,
    CollisionShape,
    Entity,
    Heightfield,
    Physics,
    ScenePlan,
    Sphere,
    VisualShape,
    constant,
    per_scene,
)
from scenecc.plan.body import AssetFile
from scenecc.plan.json_codec import plan_from_json, plan_to_json
from scenecc.plan.schema import ListKind, ObjectKind, UnionKind, plan_fields
from scenecc.source.limits import Limits

BASE = Path("/files")
DATACLASSES: set[type] = {
    item
    for item in (getattr(plan_package, name) for name in plan_package.__all__)
    if isinstance(item, type) and dataclasses.is_dataclass(item)
} - {plan_package.Value}


def find(uri: str, origin: Origin) -> Path:
    return BASE / uri


def load(text: str, **options: Any) -> ScenePlan:
    sink = Sink()
    plan = plan_from_json(text, base=BASE, sink=sink, resolve=find, **options)
    assert plan is not None, sink.diagnostics()
    assert not sink.diagnostics()
    return plan


def faults(text: str, **options: Any) -> list[tuple[str, str]]:
    sink = Sink()
    assert plan_from_json(text, base=BASE, sink=sink, **options) is None
    return [(found.code, found.path) for found in sink.diagnostics()]


@given(plans(recipes=True))
@settings(max_examples=examples(30), suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_any_plan_comes_back_and_its_text_is_canonical(plan: ScenePlan) -> None:
    text = plan_to_json(plan)
    again = load(text)
    assert again == plan
    assert plan_to_json(again) == text
    assert json.loads(text)["scenecc_plan"] == 2


@pytest.mark.filterwarnings("ignore:Generating overly large repr")
def test_the_strategy_draws_every_field_of_every_dataclass() -> None:
    drawn: set[tuple[str, str]] = set()

    def note(node: Any) -> None:
        if isinstance(node, tuple):
            for item in node:
                note(item)
        elif dataclasses.is_dataclass(node) and type(node) in DATACLASSES:
            for slot in plan_fields(type(node)):
                item = getattr(node, slot.name)
                if item is not None:
                    drawn.add((type(node).__name__, slot.name))
                    note(item)

    wanted = {(cls.__name__, slot.name) for cls in DATACLASSES for slot in plan_fields(cls)}
    enough = settings(max_examples=examples(2000), phases=[Phase.generate], derandomize=True, database=None)
    find_example(plans(full=True), lambda plan: note(plan) or wanted <= drawn, settings=enough)
    assert drawn == wanted


def test_every_dataclass_of_the_plan_is_reached_from_the_top() -> None:
    reached: set[type] = set()

    def visit(kind: Any) -> None:
        if isinstance(kind, ListKind):
            visit(kind.item)
        classes = (kind.cls,) if isinstance(kind, ObjectKind) else ()
        for cls in (*classes, *(cls for _, cls in kind.by_type)) if isinstance(kind, UnionKind) else classes:
            if cls not in reached:
                reached.add(cls)
                for slot in plan_fields(cls):
                    visit(slot.kind)

    visit(ObjectKind(ScenePlan))
    assert reached == DATACLASSES


def test_what_is_outside_a_plans_identity_is_not_written() -> None:
    left_out = {
        (cls.__name__, item.name)
        for cls in DATACLASSES
        for item in dataclasses.fields(cls)
        if item.name not in {slot.name for slot in plan_fields(cls)}
    }
    assert {name for _, name in left_out} == {"origin", "limits_origin", "path", "state"}


def ball(value: Any = 0.1, **options: Any) -> ScenePlan:
    body = solid(Sphere(constant(value)))
    return ScenePlan("p", 2, (entity("ball", options.pop("at", pose(0, 0, 1)), body),), Physics(**options))


def test_equal_plans_give_equal_text() -> None:
    assert plan_to_json(ball(timestep=1)) == plan_to_json(ball(timestep=1.0))
    assert plan_to_json(ball(gravity=(0, -0.0, 0))) == plan_to_json(ball(gravity=(0.0, 0.0, 0.0)))
    counted = dataclasses.replace(ball(), num_scenes=np.int64(2), seed=np.int32(0))  # pyright: ignore[reportArgumentType]
    assert plan_to_json(counted) == plan_to_json(ball())
    here, there = ball(), dataclasses.replace(ball(), origin=Origin("x", ("y",)))
    assert plan_to_json(here) == plan_to_json(there)


@pytest.mark.parametrize("other", [math.nextafter(0.1, 1), math.nextafter(0.1, 0), 2e-38, 3.4e38])
def test_a_bit_of_difference_is_a_difference(other: float) -> None:
    text = plan_to_json(ball(other))
    assert text != plan_to_json(ball(0.1))
    assert load(text) == ball(other)


def test_the_sign_of_a_zero_survives_in_a_value() -> None:
    plan = ball(at=pose(-0.0, 0, 1))
    assert "[-0.0, 0.0, 1.0" in plan_to_json(plan)
    assert load(plan_to_json(plan)) == plan
    assert plan != ball()


def test_a_plan_reads_like_this() -> None:
    assert plan_to_json(ball(at=per_scene([[0, 0, 1, 1, 0, 0, 0], [0, 0, 2, 1, 0, 0, 0]]))) == (
        """{
  "scenecc_plan": 2,
  "name": "p",
  "num_scenes": 2,
  "entities": [
    {
      "name": "ball",
      "scene_idxs": "0:2",
      "pose": {"per_scene": [[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0]]},
      "structures": [
        {
          "body_type": "dynamic",
          "collisions": [{"geometry": {"type": "sphere", "radius": 0.1}}],
          "visuals": []
        }
      ]
    }
  ],
  "physics": {},
  "files": [],
  "physical_materials": [],
  "visual_materials": [],
  "description": "",
  "seed": 0
}
"""
    )


@pytest.mark.parametrize(
    ("idxs", "text"),
    [
        ((0, 1, 2, 3), '"0:4"'),
        ((2, 3), '"2:4"'),
        ((0, 2, 4), '"0:5:2"'),
        ((1, 4, 7), '"1:8:3"'),
        ((5,), "[5]"),
        ((0, 2), "[0, 2]"),
        ((0, 1, 3), "[0, 1, 3]"),
        ((0, 2, 3), "[0, 2, 3]"),
    ],
)
def test_scenes_are_written_as_a_slice_where_they_are_one(idxs: tuple[int, ...], text: str) -> None:
    plan = dataclasses.replace(ball(), num_scenes=8)
    plan = dataclasses.replace(plan, entities=(dataclasses.replace(plan.entities[0], scene_idxs=idxs),))
    assert f'"scene_idxs": {text},' in plan_to_json(plan)
    assert load(plan_to_json(plan)) == plan


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_numbers_that_are_not_finite_are_refused(number: float) -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        plan_to_json(ball(number))


def test_half_a_surrogate_pair_can_be_written_to_a_file() -> None:
    plan = dataclasses.replace(ball(), description="é \ud800 \"'\n")
    text = plan_to_json(plan)
    assert "é" in text
    assert load(text.encode("utf-8").decode("utf-8")) == plan


def test_uris_are_rewritten_for_another_folder() -> None:
    files = (
        AssetFile("assets/a.obj", BASE / "assets/a.obj"),
        AssetFile("pkg://some/b.obj", Path("/packages/some/b.obj")),
        AssetFile("/abs/c.obj", Path("/abs/c.obj")),
    )
    plan = dataclasses.replace(ball(), files=files)
    uris = [item["uri"] for item in json.loads(plan_to_json(plan, base=BASE / "out" / "deep"))["files"]]
    assert uris == ["../../assets/a.obj", "pkg://some/b.obj", "/abs/c.obj"]
    assert plan_to_json(plan, base=BASE) == plan_to_json(plan)


def test_relative_uris_start_at_the_folder_of_the_json() -> None:
    plan = dataclasses.replace(ball(), files=(AssetFile("../a.obj", Path("/elsewhere/a.obj")),))
    sink = Sink()
    again = plan_from_json(plan_to_json(plan), base=Path("/files/sub"), sink=sink)
    assert again is not None
    assert again == plan
    assert again.files[0].path == Path("/files/sub/../a.obj")


def terrain(*heights: tuple[tuple[float, ...], ...]) -> ScenePlan:
    """Static terrain that is seen and collides, once for each of some heights."""
    shapes = [Heightfield(constant([4.0, 3.0, 0.5]), one) for one in heights]
    body = BodyStructure("static", tuple(map(CollisionShape, shapes)), tuple(map(VisualShape, shapes)))
    return ScenePlan("t", 1, (Entity("t", (0,), pose(0, 0, 0), (body,)),), Physics())


def test_heights_of_large_terrain_stand_once() -> None:
    row = tuple(number / 7 for number in range(101))
    small, large, other = (row,) * 2, (row,) * 100, (row[::-1],) * 100
    plan = terrain(small, large, other, large)
    text = plan_to_json(plan)
    data = json.loads(text)
    collisions = data["entities"][0]["structures"][0]["collisions"]
    first, one, two, again = [shape["geometry"]["heights"] for shape in collisions]
    assert first == [list(row)] * 2
    assert one == again != two
    assert {name: len(rows) for name, rows in data["heights"].items()} == {one: 100, two: 100}
    assert load(text) == plan
    assert plan_to_json(load(text)) == text
    assert plan_to_json(terrain(((0.0,) * 101,) * 100)) == plan_to_json(terrain(((-0.0,) * 101,) * 100))
    collisions[1]["geometry"]["heights"] = data["heights"][one]
    assert load(json.dumps(data)) == plan


HEIGHTS = ("entities", 0, "structures", 0, "collisions", 0, "geometry", "heights")
AT_HEIGHTS = "entities[0].structures[0].collisions[0].geometry.heights"


@pytest.mark.parametrize(
    ("path", "value", "where"),
    [
        (HEIGHTS, "hill", AT_HEIGHTS),
        (HEIGHTS, [[0.0], [0.0]], AT_HEIGHTS),
        (("heights",), [], "heights"),
        (("heights",), {"hill": [[1, "2"]]}, "heights.hill"),
    ],
    ids=["name", "columns", "table", "number"],
)
def test_each_fault_of_heights_is_reported_at_its_place(path: tuple[Any, ...], value: Any, where: str) -> None:
    assert faults(edited(terrain(((0.0, 1.0), (2.0, 3.0))), (path, value))) == [("SC701", where)]


def test_origins_lead_to_the_json() -> None:
    plan = load(plan_to_json(ball()), file="ball.json")
    assert plan.entities[0].origin == Origin("ball.json", ("entities", 0))
    shape = body_of(plan.entities[0]).collisions[0]
    assert shape.origin == Origin("ball.json", ("entities", 0, "structures", 0, "collisions", 0))


EXAMPLES = [row for code, row in CODES.items() if "SC700" < code <= "SC720"]


@pytest.mark.parametrize("row", EXAMPLES, ids=lambda row: row.code)
def test_the_example_of_each_code_gives_it(row: Any) -> None:
    if row.example.startswith("$ "):
        pytest.skip("a command")
    assert {code for code, _ in faults(row.example)} == {row.code}


def edited(plan: ScenePlan, *edits: tuple[tuple[Any, ...], Any]) -> str:
    data = json.loads(plan_to_json(plan))
    for path, value in edits:
        node = data
        for key in path[:-1]:
            node = node[key]
        if value is ...:
            del node[path[-1]]
        else:
            node[path[-1]] = value
    return json.dumps(data)


BALL = ("entities", 0)
SHAPE = (*BALL, "structures", 0, "collisions", 0)
RADIUS = (*SHAPE, "geometry", "radius")


@pytest.mark.parametrize(
    ("path", "value", "where"),
    [
        (("nam",), "x", "nam"),
        (("num_scenes",), True, "num_scenes"),
        (("num_scenes",), 0, "num_scenes"),
        (("name",), 3, "name"),
        (("physics",), [], "physics"),
        (("physics", "timestep"), 10**400, "physics.timestep"),
        (("physics", "timestep"), float("nan"), "physics.timestep"),
        (("physics", "gravity"), [0, 0], "physics.gravity"),
        (("physics", "gravity"), [0, 0, "9"], "physics.gravity[2]"),
        (
            ("physics", "default_material"),
            {"static_friction": 1, "dynamic_friction": 1},
            "physics.default_material",
        ),
        ((*BALL, "pose"), [0, 0, 0, 0, 0, 0, 0], "entities[0].pose"),
        ((*BALL, "pose"), [0, 0, 0], "entities[0].pose"),
        ((*BALL, "pose"), {"per_scene": [[0] * 7]}, "entities[0].pose.per_scene"),
        ((*BALL, "pose"), {"cycle": []}, "entities[0].pose"),
        ((*BALL, "pose"), {"per_scene": [[0, 0, 0, 1, 0, 0, 0], 1]}, "entities[0].pose.per_scene[1]"),
        ((*BALL, "pose"), [1e38, 1e999, 0, 1, 0, 0, 0], "entities[0].pose[1]"),
        ((*BALL, "pose"), [0, 0, 0, 1e30, 1e30, 0, 0], "entities[0].pose"),
        (
            RADIUS,
            {"per_scene": [0.1, 0]},
            "entities[0].structures[0].collisions[0].geometry.radius.per_scene[1]",
        ),
        (RADIUS, False, "entities[0].structures[0].collisions[0].geometry.radius"),
        (RADIUS, None, "entities[0].structures[0].collisions[0].geometry.radius"),
        ((*SHAPE, "geometry", "type"), "sphare", "entities[0].structures[0].collisions[0].geometry.type"),
        ((*SHAPE, "geometry", "type"), ["box"], "entities[0].structures[0].collisions[0].geometry.type"),
        ((*SHAPE, "geometry"), {}, "entities[0].structures[0].collisions[0].geometry"),
        ((*SHAPE, "material"), 0, "entities[0].structures[0].collisions[0].material"),
        ((*SHAPE, "material"), 2**80, "entities[0].structures[0].collisions[0].material"),
        ((*SHAPE, "material"), 0.0, "entities[0].structures[0].collisions[0].material"),
        ((*BALL, "scene_idxs"), [], "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), [1, 0], "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), [0, 0], "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), [-1], "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), [0.0], "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), "0:3", "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), "0:2:0", "entities[0].scene_idxs"),
        ((*BALL, "scene_idxs"), "::2", "entities[0].scene_idxs"),
        ((*BALL, "pick"), [0], "entities[0].pick"),
        ((*BALL, "pick"), 1, "entities[0].pick"),
        ((*BALL, "pick"), {"per_scene": [0]}, "entities[0].pick.per_scene"),
        ((*BALL, "pick"), {"per_scene": [0, 1]}, "entities[0].pick.per_scene[1]"),
        ((*BALL, "pick"), {"per_scene": [0, -1]}, "entities[0].pick.per_scene[1]"),
        ((*BALL, "structures"), [], "entities[0].structures"),
        ((*BALL, "structures", 0, "body_type"), "moving", "entities[0].structures[0].body_type"),
        ((*BALL, "structures"), ..., "entities[0]"),
        (("files",), [{"uri": "mesh://egg.ply", "data": "not base64"}], "files[0].data"),
        (("files",), [{"uri": "mesh://egg.ply", "data": 3}], "files[0].data"),
        (("entities",), {}, "entities"),
    ],
)
def test_what_is_missing_or_invalid_is_reported_at_its_place(path: tuple[Any, ...], value: Any, where: str) -> None:
    ((code, found),) = faults(edited(ball(), (path, value)))
    assert code == "SC701"
    assert found
    assert where.startswith(found) or found.startswith(where)


def test_the_message_names_the_path_and_how_to_make_the_plan_again() -> None:
    sink = Sink()
    assert plan_from_json(edited(ball(), (RADIUS, -1)), base=BASE, sink=sink) is None
    (found,) = sink.diagnostics()
    assert found.message == (
        "this is not a plan of this version of scenecc: "
        "`entities[0].structures[0].collisions[0].geometry.radius` is missing or invalid"
    )
    assert found.hint is not None
    assert "scenecc emit SCENE --to json" in found.hint


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ({"uri": "asset://x"}, "SC711"),
        ({"uri": "a\0b"}, "SC711"),
        ({"uri": "mesh://egg.ply"}, "SC711"),
        ({"uri": "mesh://egg\u202e.ply", "data": ""}, "SC701"),
    ],
)
def test_a_uri_that_names_no_file_is_an_error(file: dict[str, Any], code: str) -> None:
    assert faults(edited(ball(), (("files",), [file]))) == [(code, "files[0].uri")]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "null",
        "1",
        '"x"',
        "{}",
        "{",
        "[" * 100_000,
        '{"a":' * 100_000,
        "\0",
        '{"scenecc_plan": true}',
        '{"scenecc_plan": 1' + "0" * 5000 + "}",
        '{"scenecc_plan": "1"}',
        "\ufeff",
    ],
    ids=range(14),
)
def test_what_is_no_plan_is_one_error(text: str) -> None:
    assert [code for code, _ in faults(text)] == ["SC701"]


def test_limits_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.source.limits._SCENES_PER_OBJECT", 1)
    text = plan_to_json(ball())
    for limits in (Limits(text_bytes=10), Limits(scenes=1), Limits(objects=1)):
        assert faults(text, limits=limits) == [("SC712", "")]


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["0:2", "box", "x"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
TEXTS = [plan_to_json(make()) for make in SAMPLES.values()]


@given(st.sampled_from(TEXTS), st.data())
@settings(max_examples=examples(300))
def test_a_mutated_plan_is_a_plan_or_diagnostics_and_never_an_exception(text: str, data: st.DataObject) -> None:
    tree = json.loads(text)
    for _ in range(data.draw(st.integers(1, 3))):
        node: Any = tree
        while True:
            key = data.draw(st.sampled_from(sorted(node) if isinstance(node, dict) else range(len(node))))
            if not isinstance(node[key], dict | list) or not node[key] or data.draw(st.integers(0, 5)) == 0:
                break
            node = node[key]
        match data.draw(st.integers(0, 2)):
            case 0:
                node[key] = data.draw(JSON)
            case 1 if isinstance(node, dict) and node is not tree:
                del node[key]
            case _:
                node[key] = [node[key]]
    sink = Sink()
    plan = plan_from_json(json.dumps(tree), base=ROOT, sink=sink)
    assert (plan is None) == sink.failed
    if plan is not None:
        assert plan_from_json(plan_to_json(plan), base=ROOT, sink=sink) == plan


def test_repeated_rows_are_kept_as_they_are() -> None:
    one = ball()
    rows = np.repeat(one.entities[0].pose.data, 2, axis=0)
    two = dataclasses.replace(one, entities=(dataclasses.replace(one.entities[0], pose=plan_package.Value(rows)),))
    assert one != two
    assert load(plan_to_json(two)) == two


def test_ten_thousand_entities_share_their_scenes() -> None:
    first = ball().entities[0]
    entities = tuple(dataclasses.replace(first, name=f"b{i}") for i in range(100))
    plan = load(plan_to_json(dataclasses.replace(ball(), entities=entities)))
    assert len({id(entity.scene_idxs) for entity in plan.entities}) == 1
    assert isinstance(plan.entities[0], Entity)


def test_the_bounds_are_those_of_the_language() -> None:
    from scenecc.plan import schema
    from scenecc.spec import physics

    assert schema.SCALAR_BOUNDS["Physics.cpu_workers"].high == physics.MAX_THREADS
    assert schema.SCALAR_BOUNDS["SdfConfig.num_threads_for_construction"].high == physics.MAX_THREADS


def test_a_rule_checks_the_rows_of_a_plan_scene_by_scene() -> None:
    keys = {"width": 8, "height": 8, "fovy_deg": 60, "near": "${0.9 * u}", "far": "${u}"}
    document = {"scenecc": 1, "num_scenes": 4, "draws": {"u": {"uniform": [0.1, 1]}}, "cameras": {"eye": keys}}
    text = plan_text(compile_scene(document))
    assert validate(text) == []
    eye = json.loads(text)
    eye["cameras"][0]["near"]["per_scene"][2] = 1.0
    assert [one.code for one in validate(json.dumps(eye))] == ["SC550"]
