"""The section, name and path that a draw is known by, as `docs/draws.md` lists them."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest
from unit.lower.scenes import BALL

from scenecc import compile_scene
from scenecc.plan import Value
from scenecc.variation import generator
from scenecc.variation.nodes import Key

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
    key_of = generator.philox_key

    def noted(seed: int, key: Key) -> tuple[int, int]:
        drawn.add(f"{key.section} {key.name} {key.path}".rstrip())
        return key_of(seed, key)

    monkeypatch.setattr(generator, "philox_key", noted)

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
