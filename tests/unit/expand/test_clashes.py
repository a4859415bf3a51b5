"""Names that two uses bring in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc import validate

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic

PART = "scenecc: 1\nentities:\n  cube: {body_type: static, shapes: [{type: sphere, radius: 0.1}]}\n"


def clash(folder: Path, *entities: str) -> Diagnostic:
    (folder / "part.yaml").write_text(PART)
    (folder / "top.yaml").write_text("scenecc: 1\nentities:\n  " + "\n  ".join(entities) + "\n")
    (found,) = validate(folder / "top.yaml")
    assert found.code == "SC221"
    return found


def places(found: Diagnostic) -> list[tuple[str, int]]:
    locations = [found.location, *(related.location for related in found.related)]
    return [(str(location.file).rpartition("/")[2], location.line or 0) for location in locations]


def test_two_uses_without_prefix_are_told_at_both(tmp_path: Path) -> None:
    found = clash(tmp_path, 'a: {use: part.yaml, prefix: ""}', 'b: {use: part.yaml, prefix: ""}')
    assert places(found) == [("top.yaml", 4), ("top.yaml", 3)]
    assert "another `prefix`" in (found.hint or "")


def test_a_use_without_prefix_and_an_entity(tmp_path: Path) -> None:
    cube = "cube: {body_type: static, shapes: [{type: sphere, radius: 0.1}]}"
    for entities in ((cube, 'b: {use: part.yaml, prefix: ""}'), ('b: {use: part.yaml, prefix: ""}', cube)):
        found = clash(tmp_path, *entities)
        assert places(found) == [("top.yaml", 4), ("top.yaml", 3)]
        assert 'other than ""' in (found.hint or "")
