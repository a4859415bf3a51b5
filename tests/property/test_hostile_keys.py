"""A key that no scene has is told at its own place, wherever a mapping may stand and however the key is spelled."""

from __future__ import annotations

import copy
import io
import os
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.scene_nodes import SHAPE_LISTS
from plugins.scene_strategy import FOLDER, document

from scenecc import validate
from scenecc.diagnostics.diagnostic import Path as Steps
from scenecc.diagnostics.diagnostic import dotted
from scenecc.spec import nodes

LABELS = sorted(label for label in vars(nodes).values() if isinstance(label, str) and label.startswith("\0"))
"""What the compiler itself notes among the keys that pydantic tells."""

OWN = ["[key]", *LABELS, *(label.replace("\0", "#") for label in LABELS)]

KEYS = st.sampled_from(OWN) | st.builds(str.__add__, st.sampled_from(["#", "[", "\0", "é", " "]), st.text(max_size=5))
"""None of them is a name, a note or a pattern of names."""

VALUES = st.sampled_from([8, "text", True, {}, {"#": 8}, {"[key]": 8}, {"type": "box", "box": 1}, [], [{"#": 8}]])


@pytest.fixture(autouse=True, scope="module")
def _beside_the_assets() -> Iterator[None]:
    """A dict names its files from the current folder."""
    before = Path.cwd()
    os.chdir(FOLDER)
    yield
    os.chdir(before)


def places(node: Any, path: Steps = ()) -> Iterator[Steps]:
    """The paths of all mappings."""
    if isinstance(node, dict):
        yield path
    entries = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in entries:
        yield from places(item, (*path, key))


def with_key(scene: dict[str, Any], path: Steps, key: str, value: Any) -> dict[str, Any]:
    scene = copy.deepcopy(scene)
    node: Any = scene
    for step in path:
        node = node[step]
    node[key] = value
    return scene


@given(st.integers(0, 2**32), KEYS, VALUES, st.booleans())
@example(0, "#mass", 8, False)
@example(0, "[key]", 8, True)
@settings(max_examples=examples(60))
def test_a_key_that_no_scene_has_is_told_where_it_stands(seed: int, key: str, value: Any, as_text: bool) -> None:
    random = Random(seed)
    scene = document(random)
    for entity in scene["entities"].values():
        # What is left out has no joints or links by which names could be judged.
        entity.pop("if", None)
    every = list(places(scene))
    for path in random.sample(every, min(len(every), 5)):
        wrong = with_key(scene, path, key, value)
        found = validate(io.StringIO(yaml.safe_dump(wrong, sort_keys=False)) if as_text else wrong)
        told = [one.path for one in found if one.severity == "error"]
        where = dotted((*path, key))
        assert any(one.startswith(where) for one in told), (where, told)


@pytest.mark.parametrize("name", SHAPE_LISTS)
@pytest.mark.parametrize("key", ["box", "sphere"])
def test_a_key_that_is_called_like_the_type_beside_it_is_told_too(name: str, key: str) -> None:
    shape = {"type": key, "half_size": [1, 1, 1], "radius": 1, key: 1}
    variants = [{name: [shape], "type": "fast", "fast": 1}]
    found = validate({"scenecc": 1, "entities": {"a": {"variants": variants, "pick": 0}}})
    unknown = {"entities.a.variants[0]." + rest for rest in ("type", "fast", f"{name}[0].{key}")}
    assert unknown <= {one.path for one in found if one.code == "SC101"}
