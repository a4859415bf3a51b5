"""Includes: one namespace from several files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from plugins.expander import Expander


def test_included_files_are_merged_ahead_in_order(expanded: Expander) -> None:
    expansion = expanded.good(
        "include: [sub/a.yaml, b.yaml]\nparams: {n: 1}\nentities: {z: {mass: '${n + m}'}}\nphysics: {timestep: 0.1}",
        {
            "sub/a.yaml": "include: [c.yaml]\nparams: {m: 2}\nphysics: {enable_ccd: true}\n"
            "entities: {y: {mass: '${n}'}}",
            "sub/c.yaml": "entities: {x: {mass: 1, repeat: {i: [1, 2]}}}\nmaterials: {oak: {physical: {density: 1}}}",
            "b.yaml": "include: [sub/c.yaml]\nentities: {w: {mass: 4}}",
        },
    )
    data = expansion.data
    assert list(data["entities"]) == ["x_0", "x_1", "y", "w", "z"]
    assert data["entities"]["z"] == {"mass": 3}
    assert data["physics"] == {"enable_ccd": True, "timestep": 0.1}
    assert not expanded.found
    origin = expansion.trace(Origin(None, ("entities", "x_1", "mass")))
    assert (Path(str(origin.file)).name, origin.path, origin.copy) == ("c.yaml", ("entities", "x", "mass"), "i=2")
    assert origin.parent is not None
    assert origin.parent.path == ("include", 0)
    assert origin.parent.parent is not None
    assert Path(str(origin.parent.parent.file)).name == "scene.yaml"
    assert expansion.trace(Origin(None, ("physics", "enable_ccd"))).file == str(expanded.folder / "sub/a.yaml")


def test_files_of_parameters_are_found_from_every_file(expanded: Expander) -> None:
    data = expanded.data(
        "include: [sub/a.yaml]\nparams: {mesh: {type: file, default: m.obj}}\n"
        "entities: {z: {shapes: [{type: mesh, file: '${mesh}'}]}}",
        {"sub/a.yaml": "entities: {y: {shapes: [{type: convex_mesh, file: '${mesh}'}]}}"},
    )
    files = [entity["shapes"][0]["file"] for entity in data["entities"].values()]
    assert files == [f"{expanded.folder.as_posix()}/m.obj"] * 2


def test_names_in_two_files(expanded: Expander) -> None:
    expanded(
        "include: [a.yaml]\nphysics: {timestep: 0.1}\nentities: {x: {mass: 1}}\nparams: {n: 1}",
        {"a.yaml": "entities: {x: {mass: 1}}\nphysics: {timestep: 0.2}\nparams: {n: 1}"},
    )
    found = expanded.found
    assert [(each.code, each.line, each.column) for each in found] == [
        ("SC231", 3, 11),
        ("SC231", 4, 12),
        ("SC231", 5, 10),
    ]
    assert [each.related[0].location.line for each in found] == [3, 2, 4]


@pytest.mark.parametrize("key", ["name: a", "description: a", "num_scenes: 2", "seed: 1"])
def test_keys_of_the_whole(expanded: Expander, key: str) -> None:
    found = expanded.one("include: [a.yaml]", {"a.yaml": key})
    assert (found.code, found.line, found.column) == ("SC230", 2, 1)
    assert [(related.message, related.location.line) for related in found.related] == [("included from here", 2)]


def test_circles_print_the_chain(expanded: Expander) -> None:
    found = expanded.one("include: [a.yaml]", {"a.yaml": "include: [b.yaml]", "b.yaml": "include: [a.yaml]"})
    assert found.code == "SC232"
    assert found.message.endswith(": scene.yaml → a.yaml → b.yaml → a.yaml")
    assert expanded.one("include: [scene.yaml]").code == "SC232"


def test_an_included_file_cannot_use_what_includes_it(expanded: Expander) -> None:
    assert expanded.one("include: [a.yaml]", {"a.yaml": "entities: {x: {use: scene.yaml}}"}).code == "SC232"


def test_chains_have_a_limit(expanded: Expander) -> None:
    files = {f"p{i}.yaml": f"include: [p{i + 1}.yaml]" for i in range(100)}
    assert expanded.one("include: [p0.yaml]", files).code == "SC602"


@pytest.mark.parametrize(("reference", "code"), [("missing.yaml", "SC401"), ("'${n}.yaml'", "SC203")])
def test_what_cannot_be_included(expanded: Expander, reference: str, code: str) -> None:
    assert expanded.one(f"include: [{reference}]\nparams: {{n: a}}").code == code


def test_an_included_prefab_has_its_own_parameters(expanded: Expander) -> None:
    data = expanded.data(
        "params: {n: 1}\nentities: {a: {use: p.yaml, with: {m: '${n * 2}'}}}",
        {"p.yaml": "include: [q.yaml]\nparams: {m: 1}", "q.yaml": "entities: {it: {mass: '${m}'}}"},
    )
    assert data["entities"] == {"a/it": {"mass": 2}}
