"""The JSON Schema: as committed, valid, and of the same mind as the compiler about the shape of a file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from plugins.expectations import BAD, GOOD, ROOT, expectations, file_id, scene_files
from plugins.scene_models import all_keys

from scenecc import json_schema
from scenecc.source import make_limits, read_text
from scenecc.spec.document import SceneFile

SCHEMA = ROOT / "schemas/scene.v1.schema.json"
GOOD_FILES = [*scene_files(GOOD), *scene_files(ROOT / "scenes")]


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(json_schema())


def data_of(file: Path, sink: Any) -> dict[str, Any]:
    document = read_text(file.read_text(encoding="utf-8"), str(file), sink, make_limits(), file)
    assert document is not None
    return document.data


def test_the_committed_schema_is_that_of_the_models() -> None:
    # As data: one release of pydantic writes 0 where another writes 0.0.
    committed = json.loads(SCHEMA.read_text(encoding="utf-8"))
    assert committed == json_schema(), "run `scenecc schema > schemas/scene.v1.schema.json`"


def test_it_is_a_schema() -> None:
    assert json_schema()["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    jsonschema.Draft202012Validator.check_schema(json_schema())


@pytest.mark.parametrize("file", GOOD_FILES, ids=file_id)
def test_it_accepts_good_files(file: Path, validator: jsonschema.Draft202012Validator, sink: Any) -> None:
    assert [error.message for error in validator.iter_errors(data_of(file, sink))] == []


SHAPE_OF_DATA = {"SC100", "SC101", "SC102", "SC103", "SC104", "SC105", "SC106", "SC107", "SC108", "SC110"}
"""Codes that follow from a key's type alone, which is what a schema knows."""

IN_LANGUAGE = [
    file
    for file in scene_files(BAD / "language")
    if {code for *_, code in expectations(file)} <= SHAPE_OF_DATA
    # A key or a number that only a rule over several values refuses.
    and file.stem not in {"single_precision", "zero_scale", "missing_angle"}
]


@pytest.mark.parametrize("file", IN_LANGUAGE, ids=file_id)
def test_it_refuses_what_is_wrong_in_itself(file: Path, validator: jsonschema.Draft202012Validator, sink: Any) -> None:
    assert not validator.is_valid(data_of(file, sink))


BROKEN = """
scenecc: 2
---
{}
---
{scenecc: 1, entities: []}
---
{scenecc: 1, entitys: {}}
---
{scenecc: 1, num_scenes: 0}
---
{scenecc: 1, entities: {"red cube": {shapes: [{type: sphere, radius: 1}]}}}
---
{scenecc: 1, entities: {a: {shapes: [{type: sphere}]}}}
---
{scenecc: 1, entities: {a: {shapes: [{type: sphere, radius: -1}]}}}
---
{scenecc: 1, entities: {a: {shapes: [{type: sphere, radius: 1, half_size: [1, 1, 1]}]}}}
---
{scenecc: 1, entities: {a: {shapes: [{type: box, half_size: [1, 1]}]}}}
---
{scenecc: 1, entities: {a: {shapes: [{type: mesh, file: a.obj}]}}}
---
{scenecc: 1, entities: {a: {body_type: fixed}}}
---
{scenecc: 1, entities: {a: {pose: [0, 0]}}}
---
{scenecc: 1, entities: {a: {pose: {quat: [1, 0, 0, 0]}}}}
---
{scenecc: 1, entities: {a: {color: red}}}
---
{scenecc: 1, entities: {a: {mass: null}}}
---
{scenecc: 1, entities: {a: {scene_idxs: 0}}}
---
{scenecc: 1, materials: {oak: {visual: {roughness: 2}}}}
---
{scenecc: 1, physics: {gravity: -9.81}}
---
{scenecc: 1, lights: {key: {type: point}}}
"""


@pytest.mark.parametrize("document", list(yaml.safe_load_all(BROKEN)), ids=str)
def test_it_refuses_broken_documents(document: dict[str, Any], validator: jsonschema.Draft202012Validator) -> None:
    assert not validator.is_valid(document)


@pytest.mark.parametrize(
    "document",
    [
        {"scenecc": 1, "x-notes": {"anything": [1]}},
        {
            "scenecc": 1,
            "entities": {"x-note": 3, "a": {"x-why": None, "shapes": [{"type": "sphere", "radius": 1, "x-n": 1}]}},
        },
        {"scenecc": 1, "physics": {"x-a": 1}, "materials": {"x-b": []}, "frames": {"x-c": ""}},
    ],
)
def test_it_lets_notes_stand_anywhere(document: dict[str, Any], validator: jsonschema.Draft202012Validator) -> None:
    assert validator.is_valid(document)


def test_every_key_says_what_it_means() -> None:
    """An editor shows it when the cursor is over the key."""
    for model, name in all_keys(SceneFile):
        if name == "type":
            continue
        description = model.model_fields[name].description
        assert description, f"{model.__name__}.{name} has no description"


def test_lengths_masses_and_times_say_their_unit() -> None:
    with_unit = re.compile(
        r"half_size|half_length|^radius|offset|velocity$|mass$|damping|timestep|gravity|density|spacing"
    )
    for model, name in all_keys(SceneFile):
        annotation = str(model.model_fields[name].annotation)
        if with_unit.search(name) and "bool" not in annotation and "Literal" not in annotation:
            assert "[" in str(model.model_fields[name].description), f"{model.__name__}.{name}"
