"""Forms and expressions of one field, and the key that a draw is known by, as `docs/reference/draws.md` lists them."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.structures import body_of
from unit.lower.scenes import BALL, codes, compiled, entity, scene

from scenecc import compile_scene, validate
from scenecc.plan import Value
from scenecc.variation import evaluation
from scenecc.variation.nodes import Key

BOX: dict[str, Any] = {"type": "box", "half_size": [0.1, 0.2, 0.3]}


def shape(body: dict[str, Any], **top: Any) -> Any:
    """The first colliding shape of a body over four scenes."""
    return body_of(entity(compiled(body, num_scenes=4, **top))).collisions[0]


def size(half_size: Any, **top: Any) -> np.ndarray:
    return shape({"shapes": [{"type": "box", "half_size": half_size}]}, **top).geometry.half_size.data


def masses(form: Any, num_scenes: int = 4) -> Value:
    """The mass of a body over some scenes."""
    value = body_of(entity(compiled({"mass": form}, num_scenes=num_scenes))).mass
    assert value is not None
    return value


def mass(form: Any) -> list[float]:
    return masses(form).data.tolist()


@pytest.mark.parametrize(
    ("form", "expected"),
    [
        ({"per_scene": [1, 2, 3, 4]}, [1, 2, 3, 4]),
        ({"per_scene": {"0": 1, "3": 2, "default": 5}}, [1, 5, 5, 2]),
        ({"cycle": [1, 2, 3]}, [1, 2, 3, 1]),
        ({"cycle": [1, {"per_scene": {"1": 7, "default": 8}}]}, [1, 7, 1, 8]),
        ({"per_scene": [3, 3, 3, 3]}, [3]),
        ("${1 + scene * num_scenes}", [1, 5, 9, 13]),
    ],
)
def test_what_the_scene_decides(form: Any, expected: list[float]) -> None:
    assert mass(form) == expected


@pytest.mark.parametrize(
    ("form", "low", "high"),
    [
        ({"uniform": [1, 2]}, 1, 2),
        ({"log_uniform": [0.1, 10]}, 0.1, 10),
        ({"normal": [1, 0.1], "clip": [0.5, 2]}, 0.5, 2),
        ({"uniform": [1, {"cycle": [2, 3]}]}, 1, 3),
        ({"choice": [{"uniform": [1, 2]}, {"uniform": [3, 4]}]}, 1, 4),
    ],
)
def test_what_is_drawn_stays_within_its_bounds(form: Any, low: float, high: float) -> None:
    drawn = mass(form)
    assert len(set(drawn)) == 4
    assert all(low <= number <= high for number in drawn)
    support = masses(form).bounds
    assert (support.low, support.high) == (low, high)


def test_a_choice_gives_its_items_alone() -> None:
    drawn = masses({"choice": [1, 2], "weights": [1, 3]}, 400).data
    assert set(drawn.tolist()) == {1, 2}
    assert 0.6 < np.mean(drawn == 2) < 0.9


def test_integers_stay_integers() -> None:
    body = body_of(entity(compiled({"solver_position_iterations": {"integers": [1, 8]}}, num_scenes=64)))
    value = body.solver_position_iterations
    assert value is not None
    assert value.data.dtype == np.int64
    assert set(value.data.tolist()) == set(range(1, 9))


def test_flags_are_picked_and_turned_into_their_opposite() -> None:
    body = body_of(entity(compiled({"gravity": {"cycle": [True, False]}}, num_scenes=3)))
    assert body.disable_gravity is not None
    assert body.disable_gravity.data.tolist() == [False, True, False]


def test_a_flag_by_expression() -> None:
    body = body_of(entity(compiled({"gravity": "${scene < 2}"}, num_scenes=3)))
    assert body.disable_gravity is not None
    assert body.disable_gravity.data.tolist() == [False, False, True]


def test_components_have_the_draws_of_the_whole() -> None:
    whole = size({"uniform": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]]})
    parts = size([{"uniform": [0.1, 0.2]}, 0.15, {"uniform": [0.1, 0.2]}])
    assert whole[:, [0, 2]].tolist() == parts[:, [0, 2]].tolist()
    assert parts[:, 1].tolist() == [0.15] * 4
    assert len(set(whole.ravel())) == 12


def test_an_expression_may_give_a_whole_vector() -> None:
    draws = {"half": {"uniform": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]]}}
    assert (
        size("${half}", draws=draws).tolist() == size(["${half[0]}", "${half[1]}", "${half[2]}"], draws=draws).tolist()
    )


def test_a_scale_is_one_number_for_all_axes_or_three(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")

    def scales(form: Any) -> np.ndarray:
        mesh = {"type": "mesh", "file": "asset://a.obj", "scale": form}
        body = {"body_type": "kinematic", "shapes": [], "visuals": [mesh]}
        plan = compile_scene(scene(body, num_scenes=4), asset_roots=[tmp_path])
        geometry: Any = body_of(entity(plan)).visuals[0].geometry
        return geometry.scale.data

    one = scales({"uniform": [1, 2]})
    assert (one == one[:, :1]).all()
    assert len(set(one[:, 0])) == 4
    three = scales({"uniform": [[1, 1, -2], [2, 2, -1]]})
    assert three[:, 0].tolist() == one[:, 0].tolist()
    assert len(set(three.ravel())) == 12
    mixed = scales({"cycle": [2, [1, 2, 3], "${scene + 1}"]})
    assert mixed.tolist() == [[2, 2, 2], [1, 2, 3], [3, 3, 3], [2, 2, 2]]


def colors(body: dict[str, Any], **top: Any) -> list[list[float]]:
    plan = compiled(body, num_scenes=4, **top)
    index = int(body_of(entity(plan)).visuals[0].material.data[0])  # type: ignore[union-attr]
    base = plan.visual_materials[index].base_color
    assert base is not None
    return base.data.tolist()


RED, GREEN, BLUE = [1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0.2]


def test_colours_are_texts_and_lists_in_one_form() -> None:
    assert colors({"color": {"cycle": ["#ff0000", [0, 1, 0], [0, 0, 1, 0.2]]}}) == [RED, GREEN, BLUE, RED]
    assert colors({"shapes": [{**BOX, "color": {"cycle": ["#ff0000", [0, 1, 0]]}}]}) == [RED, GREEN, RED, GREEN]


def test_colours_by_expression_are_read_as_they_turn_out() -> None:
    draws = {"paint": {"cycle": ["#ff0000", "#00ff00"]}}
    assert colors({"color": "${paint}"}, draws=draws) == [RED, GREEN, RED, GREEN]
    assert colors({"color": {"cycle": ["${paint}", [0, 0, 1, 0.2]]}}, draws=draws) == [RED, BLUE, RED, BLUE]
    assert colors({"color": "${[1, 0, 0] if scene else [0, 1, 0]}"}) == [GREEN, RED, RED, RED]


def test_the_alpha_that_is_left_out_does_not_vary() -> None:
    drawn = np.array(colors({"color": {"uniform": [[0, 0, 0], [1, 1, 1]]}}))
    assert (drawn[:, 3] == 1).all()
    assert len(set(drawn[:, :3].ravel())) == 12
    part = np.array(colors({"color": [{"uniform": [0, 1]}, 0, 0]}))
    assert part[:, 0].tolist() == drawn[:, 0].tolist()
    assert part[:, 1:].tolist() == [[0, 0, 1]] * 4


def test_a_colour_of_the_body_is_drawn_once_for_its_shapes() -> None:
    plan = compiled({"color": {"uniform": [[0, 0, 0], [1, 1, 1]]}, "shapes": [BOX, BOX]}, num_scenes=4)
    first, second = (visual.material for visual in body_of(entity(plan)).visuals)
    assert first is not None
    assert second is not None
    assert first.data.tolist() == second.data.tolist()


def test_a_colour_that_is_none_is_told_with_its_scene() -> None:
    with pytest.raises(Exception, match="in scene 1: it gives 'red'"):
        compiled({"color": "${'red' if scene == 1 else '#ff0000'}"}, num_scenes=2)


@pytest.mark.parametrize(
    ("form", "code", "path"),
    [
        ({"per_scene": [1, 2]}, "SC314", "mass.per_scene"),
        ({"per_scene": {"0": 1, "1": 2}}, "SC315", "mass.per_scene"),
        ({"per_scene": {"0": 1, "9": 2, "default": 3}}, "SC315", "mass.per_scene.9"),
        ({"choice": [1, {"per_scene": [1]}]}, "SC314", "mass.choice[1].per_scene"),
    ],
)
def test_values_by_scene_for_other_scenes(form: Any, code: str, path: str) -> None:
    assert codes(scene({"mass": form}, num_scenes=3)) == [(code, f"entities.body.{path}")]


def test_lists_by_scene_follow_the_scenes_of_the_entity() -> None:
    plan = compiled({"mass": {"per_scene": [5, 6]}, "scene_idxs": [1, 3]}, num_scenes=4)
    assert body_of(entity(plan)).mass.data.tolist() == [5, 6]  # type: ignore[union-attr]
    assert codes(scene({"mass": {"per_scene": {"0": 1, "default": 2}}, "scene_idxs": [1, 3]}, num_scenes=4)) == [
        ("SC315", "entities.body.mass.per_scene.0")
    ]


def test_plain_forms_are_validated_without_a_draw(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise AssertionError("something was drawn")

    monkeypatch.setattr(evaluation, "words", refuse)
    document = scene(
        {
            "pose": {"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}, "q": "uniform"},
            "mass": {"log_uniform": [1, 2]},
            "material": {"choice": ["a", "b"]},
            "color": {"choice": ["#ff0000", "#00ff00"]},
            "shapes": [
                {
                    "type": "box",
                    "half_size": {"uniform": [[0.1, 0.1, 0.1], [1, 1, 1]]},
                    "contact_offset": {"uniform": [0.1, 0.2]},
                    "rest_offset": {"uniform": [0.0, 0.01]},
                    "density": {"choice": [1, 2]},
                }
            ],
        },
        num_scenes=8,
        materials={"a": {"physical": {"static_friction": {"uniform": [0.5, 1]}}}, "b": {"visual": {"roughness": 0.5}}},
    )
    document["entities"]["other"] = {
        "pose": {"relative_to": "body", "rpy_deg": [0, 0, {"uniform": [0, 90]}]},
        "pick": {"choice": [0, 1]},
        "variants": [{"shapes": [BOX]}, {"shapes": [{"type": "sphere", "radius": {"uniform": [1, 2]}}]}],
    }
    assert validate(document) == []
    with pytest.raises(AssertionError, match="something was drawn"):
        assert entity(compile_scene(document)).pose.data.shape


ONE: dict[str, Any] = {"uniform": [0.1, 1]}
THREE: dict[str, Any] = {"uniform": [[1, 0, 0], [1, 1, 1]]}
SPHERE: dict[str, Any] = {"type": "sphere", "radius": ONE}

LEG = """
scenecc: 1
params: {length: 0.4}
draws: {w: {uniform: [1, 2]}}
materials: {oak: {physical: {density: {uniform: [600, 800]}}}}
entities:
  leg:
    material: oak
    mass: "${w * length}"
    pose: {p: {uniform: [[0, 0, 0], [1, 1, 1]]}}
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
"""


def draw_all(item: Any) -> None:
    """Draws every value of a plan."""
    if isinstance(item, Value):
        assert item.data.size
    elif isinstance(item, tuple):
        for part in item:  # pyright: ignore[reportUnknownVariableType]
            draw_all(part)
    elif is_dataclass(item):
        for field in fields(item):
            draw_all(getattr(item, field.name))


@pytest.fixture
def keys(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The keys that compiling a document draws with."""
    drawn: set[str] = set()
    key_of = evaluation.philox_key

    def noted(seed: int, key: Key) -> tuple[int, int]:
        drawn.add(f"{key.section} {key.name} {key.path}".rstrip())
        return key_of(seed, key)

    monkeypatch.setattr(evaluation, "philox_key", noted)

    def run(document: Any, **options: Any) -> set[str]:
        draw_all(compile_scene({"scenecc": 1, "num_scenes": 3, **document}, **options))
        return drawn

    return run


@pytest.mark.parametrize(
    ("body", "paths"),
    [
        ({"pose": THREE}, {"pose.p"}),
        ({"pose": [ONE, ONE, 0]}, {"pose.p"}),
        ({"pose": {"p": [ONE, 0, 0]}}, {"pose.p"}),
        ({"pose": {"choice": [[0, 0, 1], [1, 1, 1]]}}, {"pose.p"}),
        ({"pose": {"choice": [{"p": THREE}, [0, 0, 1]]}}, {"pose", "pose.choice[0].p"}),
        ({"pose": {"q": "uniform"}}, {"pose.q"}),
        ({"pose": {"rpy": THREE}}, {"pose.rpy"}),
        ({"pose": {"rpy_deg": [0, 0, ONE]}}, {"pose.rpy_deg"}),
        ({"pose": {"axis_angle": {"axis": THREE, "angle": ONE}}}, {"pose.axis_angle.axis", "pose.axis_angle.angle"}),
        ({"pose": {"axis_angle": {"axis": "x", "angle_deg": ONE}}}, {"pose.axis_angle.angle_deg"}),
        ({"pose": {"p": [9, 9, 9], "look_at": THREE}}, {"pose.look_at"}),
        ({"mass": {"choice": [1, {"uniform": [2, 3]}]}}, {"mass", "mass.choice[1]"}),
        ({"mass": {"uniform": [1, {"uniform": [2, 3]}]}}, {"mass", "mass.uniform[1]"}),
        ({"mass": {"normal": [ONE, 0.1], "clip": [0.1, ONE]}}, {"mass", "mass.normal[0]", "mass.clip[1]"}),
        ({"mass": {"per_scene": {0: ONE, "default": 1}}}, {"mass.per_scene.0"}),
        ({"inertial": {"mass": ONE, "inertia": [1, 1, 1]}}, {"inertial.mass"}),
        ({"material": {"physical": {"density": ONE}}}, {"material.physical.density"}),
        ({"shapes": [{**SPHERE, "repeat": {"i": [1, 2]}}, SPHERE]}, {f"shapes[{i}].radius" for i in range(3)}),
        ({"shapes": [], "collisions": [{**BALL[0], "pose": THREE}]}, {"collisions[0].pose.p"}),
    ],
    # Sets would be written in another order by each worker.
    ids=lambda part: str(sorted(part)),
)
def test_paths_of_a_body(body: dict[str, Any], paths: set[str], keys: Any) -> None:
    assert keys({"entities": {"cube": {"shapes": BALL, **body}}}) == {f"entities cube {path}" for path in paths}


def test_keys_of_variants(keys: Any) -> None:
    variants = [{"shapes": [SPHERE]}, {"shapes": [SPHERE]}]
    paths = {"pick", "variants[0].shapes[0].radius", "variants[1].shapes[0].radius"}
    found = keys({"entities": {"bin": {"pick": {"choice": [0, 1]}, "variants": variants}}})
    assert found == {f"entities bin {path}" for path in paths}


def test_keys_of_a_prefab(tmp_path: Path, keys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "leg.yaml").write_text(LEG)
    monkeypatch.chdir(tmp_path)
    found = keys({"entities": {"x": {"use": "leg.yaml", "with": {"length": ONE}, "pose": THREE}}})
    assert found == {
        "draws x/length",
        "draws x/w",
        "entities x/leg pose.p",
        "frames x pose.p",
        "materials x/oak physical.density",
    }


def test_keys_of_a_parameter(keys: Any) -> None:
    document = {"params": {"m": 1}, "entities": {"cube": {"shapes": BALL, "mass": "${m}"}}}
    assert keys(document, params={"m": ONE}) == {"draws m"}


def test_keys_of_frames_and_materials(keys: Any) -> None:
    cube = {"shapes": BALL, "material": "oak", "pose": {"p": [0, 0, 1], "relative_to": "spot"}}
    oak = {"physical": {"density": ONE}}
    found = keys({"entities": {"cube": cube}, "materials": {"oak": oak}, "frames": {"spot": {"pose": THREE}}})
    assert found == {"materials oak physical.density", "frames spot pose.p"}
