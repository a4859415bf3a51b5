"""Edits of a text at the places of its nodes: nothing else changes."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from scenecc.source.edits import EditError, TextEdits, as_is

TEXT = """\
# a scene
entities:
  cube:   {pose: [0, 0,  1], mass: 2}   # a cube
  ball:
    # where it is
    pose:
      - 1   # x
      - 2
      - 3
    mass: &heavy 5
  twin: {mass: *heavy, <<: {gravity: false}}
"""


def edited(edit: Callable[[TextEdits], None], text: str = TEXT) -> str:
    edits = TextEdits(text)
    edit(edits)
    return edits.result()


def test_replace_changes_a_value() -> None:
    found = edited(lambda it: it.replace(("entities", "cube", "pose", 2), as_is("1.25")))
    assert found == TEXT.replace("0,  1]", "0,  1.25]")
    found = edited(lambda it: it.replace(("entities", "ball", "pose", 0), as_is("-1")))
    assert found == TEXT.replace("- 1   # x", "- -1   # x")


def test_several_edits_of_a_text_are_independent() -> None:
    def both(edits: TextEdits) -> None:
        edits.replace(("entities", "ball", "pose", 1), as_is("222222"))
        edits.insert(("entities", "cube"), "on", "on", as_is("true"))
        edits.replace(("entities", "cube", "pose", 0), as_is("100"))

    wanted = TEXT.replace("[0, 0,  1], mass: 2", "[100, 0,  1], mass: 2, on: true").replace("- 2\n", "- 222222\n")
    assert edited(both) == wanted


@pytest.mark.parametrize("before", ["é = 'ü' # ", "# \U0001f4a1 ", "#\t"])
def test_edit_positions_count_characters(before: str) -> None:
    text = f"{before}\n{TEXT}" if before.startswith("#") else f"x-{before}\n".replace(" = ", ": ") + TEXT
    found = edited(lambda it: it.replace(("entities", "cube", "mass"), as_is("3")), text)
    assert found == text.replace("mass: 2", "mass: 3")


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda it: it.replace(("entities", "twin", "mass", 0), as_is("1")), "`0` is written elsewhere, at an anchor"),
        (lambda it: it.replace(("entities", "twin", "gravity"), as_is("1")), "`gravity` is not written there"),
        (lambda it: it.replace(("entities", "cube", "pose", 3), as_is("1")), "`3` is not written there"),
        (lambda it: it.insert(("entities", "twin", "mass"), 0, "", as_is("1")), "`mass` is written elsewhere"),
    ],
)
def test_edits_in_other_places_are_refused(edit: Callable[[TextEdits], None], said: str) -> None:
    with pytest.raises(EditError, match=said):
        edited(edit)
