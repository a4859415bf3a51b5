"""What can be asked of files without expanding them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics import Sink
from scenecc.expand.documents import scene_loader, shipped_names
from scenecc.expand.listing import ParamRow, list_params, list_prefabs
from scenecc.source import Limits, read_file
from scenecc.source.paths import AssetScope

if TYPE_CHECKING:
    from pathlib import Path


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
            assert param.default is not None, (row.name, param.name)
