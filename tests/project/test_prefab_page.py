"""The page on prefabs says what the prefabs say."""

from __future__ import annotations

from pathlib import Path

import pytest
from plugins.prefab_page import GROUPS, PREFABS, page, params, prefab

ROOT = Path(__file__).parents[2]
NAMES = sorted(file.stem for file in PREFABS.glob("*.yaml") if "." not in file.stem)


def test_the_page_is_generated_from_the_prefabs() -> None:
    assert (ROOT / "docs/reference/prefabs.md").read_text(encoding="utf-8") == page()


def test_every_prefab_is_on_the_page() -> None:
    assert sorted(name for _, names in GROUPS.values() for name in names) == NAMES


@pytest.mark.parametrize("file", sorted(PREFABS.glob("*.*.yaml")), ids=lambda file: file.stem)
def test_an_edition_is_the_prefab_with_other_defaults(file: Path) -> None:
    name = file.stem.partition(".")[0]
    assert file.read_text(encoding="utf-8").startswith("# ")
    for key in ("name", "description"):
        assert prefab(file.stem)[key] == prefab(name)[key]
    ours, theirs = params(name), params(file.stem)
    assert ours != theirs
    for key in ("type", "options", "min", "max", "description"):
        assert [(p, ours[p].get(key)) for p in ours] == [(p, theirs[p].get(key)) for p in theirs]


@pytest.mark.parametrize("name", NAMES)
def test_a_prefab_begins_with_a_comment_and_describes_itself_and_its_parameters(name: str) -> None:
    data = prefab(name)
    assert (PREFABS / f"{name}.yaml").read_text(encoding="utf-8").startswith("# ")
    assert data["name"] == name
    assert data["description"].endswith(".")
    assert "\n" not in data["description"]
    for parameter in params(name).values():
        # An entity is one of the file that uses the prefab.
        required = {"type", "description"} | ({"default"} if parameter["type"] != "entity" else set())
        assert required <= parameter.keys()
        assert parameter["type"] != "choice" or parameter["default"] in parameter["options"]
    # Left out of an instance with a note, so none of ours has it.
    assert not data.keys() & {"physics", "environment", "num_scenes", "seed"}
