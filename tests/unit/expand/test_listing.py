"""Parameters of files, and the prefabs that ship with their editions."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from plugins.expander import Expander

from scenecc import ParamRow
from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.expand.documents import edition_here, editions, scene_loader, shipped_file, shipped_names
from scenecc.expand.listing import list_params, list_prefabs
from scenecc.source import Limits, read_file
from scenecc.source.paths import AssetScope


def rows(folder: Path, text: str, sink: Sink) -> list[ParamRow] | None:
    (folder / "scene.yaml").write_text("scenecc: 1\n" + text)
    document = read_file(folder / "scene.yaml", sink)
    assert document is not None
    return list_params(document, load=scene_loader(AssetScope(folder), Limits(), sink), limits=Limits(), sink=sink)


def test_parameters_with_their_ranges(tmp_path: Path) -> None:
    (tmp_path / "inc.yaml").write_text("scenecc: 1\nparams: {first: {type: number, min: 0, description: of all}}")
    found = rows(
        tmp_path,
        """
include: [inc.yaml]
params:
  size: {type: vector, default: [1, 2], min: 0, max: [3, 4]}
  kind: {type: choice, options: [a, 2, true], default: a}
  twice: "${first * 2}"
  tint: "#ffffff"
  most: {type: integer, default: 3, max: 5}
""",
        Sink(),
    )
    assert found is not None
    assert [(row.name, row.type, row.default, row.range, row.description) for row in found] == [
        ("first", "number", None, "at least 0", "of all"),
        ("size", "vector", "[1, 2]", "0 to [3, 4]", ""),
        ("kind", "choice", "a", "a, 2, true", ""),
        ("twice", "any", "${first * 2}", "", ""),
        ("tint", "color", "#ffffff", "", ""),
        ("most", "integer", "3", "at most 5", ""),
    ]


def test_what_is_wrong_is_told(tmp_path: Path) -> None:
    sink = Sink()
    assert rows(tmp_path, "params: {a: {type: nubmer}}", sink) is None
    assert [(found.code, found.line) for found in sink.diagnostics()] == [("SC214", 2)]


def test_prefabs_that_ship_have_descriptions() -> None:
    found = list_prefabs()
    assert [row.name for row in found] == [f"scenecc:{name}" for name in shipped_names()]
    assert len(found) >= 15
    for row in found:
        assert row.description
        assert "\n" not in row.description
        for param in row.params:
            assert param.description, (row.name, param.name)
            assert (param.default is None) == (param.type == "entity"), (row.name, param.name)


USE = "entities: {t: {use: 'scenecc:table_workspace', prefix: ''}}"


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package of this name that cannot be imported."""
    (tmp_path / "mani_skill").mkdir()
    (tmp_path / "mani_skill" / "__init__.py").write_text("raise AssertionError('imported')\n")
    monkeypatch.delitem(sys.modules, "mani_skill", raising=False)
    monkeypatch.syspath_prepend(tmp_path)


@pytest.fixture
def missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mani_skill", None)


def test_editions_are_no_names_of_prefabs() -> None:
    assert "table_workspace" in shipped_names()
    assert not [name for name in shipped_names() if "." in name or "/" in name]
    assert editions("table_workspace") == ["mani_skill"]
    assert editions("table") == []


@pytest.mark.usefixtures("installed")
def test_the_edition_of_a_package_that_is_installed() -> None:
    assert edition_here("table_workspace", AssetScope()) == "mani_skill"
    assert edition_here("table", AssetScope()) is None
    assert shipped_file("table_workspace", "mani_skill") == "table_workspace.mani_skill.yaml"


@pytest.mark.usefixtures("missing")
def test_no_edition_where_the_package_is_not_installed() -> None:
    assert edition_here("table_workspace", AssetScope()) is None
    assert shipped_file("table_workspace", None) == "table_workspace.yaml"


def test_a_folder_that_is_no_package_makes_no_edition(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mani_skill").mkdir()
    monkeypatch.delitem(sys.modules, "mani_skill", raising=False)
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert edition_here("table_workspace", AssetScope()) is None


@pytest.mark.usefixtures("installed")
def test_a_diagnostic_names_the_edition(expanded: Expander) -> None:
    found = expanded.one("entities: {t: {use: 'scenecc:table_workspace', with: {visual: wood}}}")
    assert found.related[0].location.file == "scenecc:table_workspace.mani_skill"


@pytest.mark.usefixtures("installed")
def test_the_edition_decides_what_is_built(expanded: Expander) -> None:
    expansion = expanded.good(USE)
    assert [shape["type"] for shape in expansion.data["entities"]["table-workspace"]["visuals"]] == ["mesh"]
    origin = expansion.trace(Origin(None, ("entities", "table-workspace", "visuals")))
    assert origin.file == "pkg://scenecc/prefabs/parts/table_workspace.yaml"


@pytest.mark.usefixtures("missing")
def test_the_plain_prefab_where_there_is_none(expanded: Expander) -> None:
    expansion = expanded.good(USE)
    assert {shape["type"] for shape in expansion.data["entities"]["table-workspace"]["visuals"]} == {"box"}


def test_an_edition_cannot_be_named(expanded: Expander) -> None:
    found = expanded.one("entities: {t: {use: 'scenecc:table_workspace.mani_skill'}}")
    assert (found.code, found.hint) == ("SC240", "did you mean `scenecc:table_workspace`?")


def listed() -> tuple[tuple[str, ...], str | None, str | None]:
    (row,) = (row for row in list_prefabs() if row.name == "scenecc:table_workspace")
    (visual,) = (param for param in row.params if param.name == "visual")
    return row.editions, row.edition, visual.default


@pytest.mark.usefixtures("installed")
def test_the_list_tells_the_edition_that_is_used() -> None:
    assert listed() == (("mani_skill",), "mani_skill", "mesh")


@pytest.mark.usefixtures("missing")
def test_the_list_tells_the_plain_prefab() -> None:
    assert listed() == (("mani_skill",), None, "boxes")
