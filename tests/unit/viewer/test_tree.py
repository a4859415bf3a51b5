"""Rows of the tree of objects: folders, search, and how many there are."""

from __future__ import annotations

import pytest

pytest.importorskip("viser", reason="needs the extra `view`")

from scenecc.viewer.tree import Branch, object_rows

SCENES = {0: [("ground", ()), ("desk/table", ()), ("desk/leg", ()), ("arm", ("base", "Tip"))], 2: [("ground", ())]}


def labels(rows: tuple[Branch, ...]) -> list[object]:
    return [row.label if row.key is not None else (row.label, labels(row.below)) for row in rows]


def test_names_with_slashes_and_links_are_in_folders() -> None:
    found, left = object_rows(SCENES)
    assert [(scene.index, scene.count) for scene in found] == [(0, 4), (2, 1)]
    assert labels(found[0].rows) == ["ground", ("desk", ["table", "leg"]), ("arm", ["base", "Tip"])]
    assert found[0].rows[2].below[1].key == (0, "arm", 1)
    assert left == 0


def test_a_search_lists_names_that_contain_the_text() -> None:
    found, _ = object_rows(SCENES, "TIP")
    assert [labels(scene.rows) for scene in found] == [[("arm", ["Tip"])]]
    found, _ = object_rows(SCENES, "desk/t")
    assert labels(found[0].rows) == [("desk", ["table"])]
    assert object_rows(SCENES, "nothing") == ([], 0)


def test_the_number_of_rows_is_limited() -> None:
    many = {0: [(f"box_{number}", ()) for number in range(5000)]}
    found, left = object_rows(many)
    assert len(found[0].rows) == 200
    assert (found[0].count, left) == (5000, 4800)
    found, left = object_rows(many, "box_499")
    assert (labels(found[0].rows)[0], left) == ("box_499", 0)


def test_an_articulation_and_a_folder_of_the_same_name_are_separate() -> None:
    found, _ = object_rows({0: [("desk", ()), ("desk/leg", ())]})
    assert labels(found[0].rows) == ["desk", ("desk", ["leg"])]
