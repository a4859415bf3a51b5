"""Prefabs that are another file where a package is installed."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from plugins.expander import Expander

from scenecc.diagnostics import Origin
from scenecc.expand.documents import edition_here, editions, shipped_file, shipped_names
from scenecc.expand.listing import list_prefabs
from scenecc.source.paths import AssetScope

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
    assert (found.code, found.hint) == ("SC240", "did you mean `table_workspace`?")


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
