"""The layout of scene files: what is written is read back, and is written as a person would."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.diagnostics import Sink
from scenecc.scene_file.layout import KEY_ORDER, NAMED, WIDTH, number_text, scene_text
from scenecc.source import Limits, read_text
from scenecc.source.read import read_yaml
from scenecc.source.syntax_errors import SourceReporter
from scenecc.source.text import TextLines
from scenecc.spec.json_schema import json_schema

ROOT = Path(__file__).parents[3]

SCENES = sorted([*(ROOT / "scenes").rglob("*.yaml"), *(ROOT / "scenecc" / "prefabs").rglob("*.yaml")])

TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\ufffe\uffff\0"), max_size=20)

SCALARS = st.booleans() | st.integers(-(10**30), 10**30) | st.floats() | st.floats(width=32) | TEXTS

WORDS = st.sampled_from(
    ["scenecc", "entities", "pose", "per_scene", "true", "1", "links", "- a", "a: b", "#", "~", "1e3", "two\nlines"]
)

DATA = st.dictionaries(
    TEXTS | WORDS,
    st.recursive(
        SCALARS | WORDS,
        lambda below: st.lists(below, max_size=8) | st.dictionaries(TEXTS | WORDS, below, max_size=8),
        max_leaves=30,
    ),
    min_size=1,
    max_size=5,
)


def is_same(written: Any, read: Any) -> bool:
    """Equal, where numbers of single precision may come back as another number of the same single precision."""
    if isinstance(written, dict):
        assert isinstance(read, dict)
        return written.keys() == read.keys() and all(is_same(written[key], read[key]) for key in written)
    if isinstance(written, list):
        return len(written) == len(read) and all(map(is_same, written, read))
    if isinstance(written, float) and not isinstance(read, bool | str):
        if math.isnan(written):
            return math.isnan(read)
        with np.errstate(over="ignore"):
            single = np.float32(written)
            return written == read or (float(single) == written and single == np.float32(read))
    return type(written) is type(read) and written == read


def strictly_read(text: str) -> Any:
    sink = Sink()
    found = read_yaml(SourceReporter(TextLines(None, text), sink), Limits())
    assert found is not None, sink.diagnostics()
    return found


def read_back(text: str) -> Any:
    sink = Sink()
    document = read_text(text, None, sink)
    assert document is not None, sink.diagnostics()
    return document.data


@given(DATA)
def test_written_documents_read_back_unchanged(data: dict[str, Any]) -> None:
    text = scene_text(data)
    assert is_same(data, read_back(text)), text
    assert is_same(data, strictly_read(text)), text


@pytest.mark.parametrize("file", SCENES, ids=lambda file: str(file.relative_to(ROOT)))
def test_scenes_are_written_within_the_line_width_and_read_back(file: Path) -> None:
    data = read_back(file.read_text("utf-8"))
    text = scene_text(data, comments={(): "A head."})
    assert is_same(data, read_back(text))
    long = [line for line in text.splitlines() if len(line) > WIDTH and re.search(r"[\[{](?!.*\").*, ", line)]
    assert not long


def test_the_key_order_lists_only_known_keys() -> None:
    schema = json_schema()
    models = [schema, *schema["$defs"].values()]
    keys = {key for model in models for key in model.get("properties", {})}
    assert set(KEY_ORDER) | NAMED <= keys | {"override", "attach", "per_scene"}
    assert len(set(KEY_ORDER)) == len(KEY_ORDER)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (0.1, "0.1"),
        (float(np.float32(0.1)), "0.1"),
        (0.1000000001, "0.1000000001"),
        (1.0, "1"),
        (-0.0, "-0.0"),
        (1e-5, "1.0e-5"),
        (1e10, "1.0e+10"),
        (4.616100039319855e16, "4.616100039319855e+16"),
        (1e-4, "0.0001"),
        (250000.0, "250000"),
        (1234567.0, "1234567"),
        (-0.00012, "-1.2e-4"),
        (3.4028234663852886e38, "3.4028234663852886e+38"),
        (1e300, "1.0e+300"),
        (math.inf, ".inf"),
        (True, "true"),
        (7, "7"),
    ],
)
def test_numbers_are_as_short_as_they_can_be(number: Any, text: str) -> None:
    assert number_text(number) == text


def test_a_scene_is_laid_out_as_a_person_writes_it() -> None:
    box = {"type": "box", "half_size": [0.1, 0.1, 0.2], "pose": [0.0, 0.0, float(np.float32(0.3))]}
    scene = {
        "entities": {
            "ground": {"shapes": [{"type": "plane"}], "body_type": "static"},
            "tower": {"shapes": [box, {**box, "color": [1.0, 0.5, 0.25], "density": 812.5, "material": "oak wood"}]},
            "robot": {"urdf": "pkg://robots/arm.urdf", "qpos": [0.123456789] * 12},
        },
        "lights": {"sun": {"direction": [0, 0, -1], "type": "directional"}},
        "description": "Two: one\non the other.\n",
        "scenecc": 1,
    }
    comments = {(): "From `arm.sdf`.", ("entities", "tower", "shapes", 1): "was a cone"}
    assert scene_text(scene, comments=comments) == (
        """\
# From `arm.sdf`.
scenecc: 1

description: |
  Two: one
  on the other.

entities:
  ground: {body_type: static, shapes: [{type: plane}]}

  tower:
    shapes:
      - {type: box, pose: [0, 0, 0.3], half_size: [0.1, 0.1, 0.2]}
      # was a cone
      - {type: box, pose: [0, 0, 0.3], half_size: [0.1, 0.1, 0.2], density: 812.5,
          material: oak wood, color: [1, 0.5, 0.25]}

  robot:
    urdf: pkg://robots/arm.urdf
    qpos: [0.123456789, 0.123456789, 0.123456789, 0.123456789, 0.123456789, 0.123456789,
      0.123456789, 0.123456789, 0.123456789, 0.123456789, 0.123456789, 0.123456789]

lights:
  sun: {type: directional, direction: [0, 0, -1]}
"""
    )


def test_the_children_of_a_link_are_its_last_key() -> None:
    child = {"name": "arm", "joint": {"type": "fixed"}}
    link = {"name": "base", "children": [child], "linear_damping": 0.1, "shapes": [], "collision_group": "robot"}
    text = scene_text({"scenecc": 1, "entities": {"robot": {"root": link}}})
    found = [text.index(key) for key in ("collision_group", "shapes", "linear_damping", "children")]
    assert found == sorted(found)
