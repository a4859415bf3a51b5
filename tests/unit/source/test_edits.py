"""Edits of a text at the places of its nodes: nothing else changes."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from scenecc.source.edits import EditError, TextEdits

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


def test_set_scalar_replaces_a_value() -> None:
    found = edited(lambda it: it.set_scalar(("entities", "cube", "pose", 2), "1.25"))
    assert found == TEXT.replace("0,  1]", "0,  1.25]")
    found = edited(lambda it: it.set_scalar(("entities", "ball", "pose", 0), "-1"))
    assert found == TEXT.replace("- 1   # x", "- -1   # x")


def test_several_edits_of_a_text_are_independent() -> None:
    def both(edits: TextEdits) -> None:
        edits.set_scalar(("entities", "ball", "pose", 1), "222222")
        edits.wrap(("entities", "cube", "pose"), "{p: ", ", q: [0, 0, 0, 1]}")
        edits.set_scalar(("entities", "cube", "pose", 0), "100")

    wanted = TEXT.replace("[0, 0,  1]", "{p: [100, 0,  1], q: [0, 0, 0, 1]}").replace("- 2\n", "- 222222\n")
    assert edited(both) == wanted


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_add_key_inserts_at_the_start_of_a_mapping(end: str) -> None:
    text = TEXT.replace("\n", end)
    found = edited(lambda it: it.add_key(("entities", "cube"), "gravity", "false"), text)
    assert found == text.replace("{pose: [0, 0,", "{gravity: false, pose: [0, 0,")
    found = edited(lambda it: it.add_key(("entities", "ball"), "gravity", "false"), text)
    assert found == text.replace("    pose:", f"    gravity: false{end}    pose:")


@pytest.mark.parametrize("before", ["é = 'ü' # ", "# \U0001f4a1 ", "#\t"])
def test_edit_positions_count_characters(before: str) -> None:
    text = f"{before}\n{TEXT}" if before.startswith("#") else f"x-{before}\n".replace(" = ", ": ") + TEXT
    found = edited(lambda it: it.set_scalar(("entities", "cube", "mass"), "3"), text)
    assert found == text.replace("mass: 2", "mass: 3")


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (lambda it: it.set_scalar(("entities", "twin", "mass"), "1"), "`mass` is written elsewhere, at an anchor"),
        (lambda it: it.set_scalar(("entities", "twin", "gravity"), "1"), "`gravity` is not written there"),
        (lambda it: it.set_scalar(("entities", "cube", "pose", 3), "1"), "`3` is not written there"),
        (lambda it: it.set_scalar(("entities", "cube", "pose"), "1"), "`pose` is not a single value"),
        (lambda it: it.wrap(("entities", "ball", "pose"), "{", "}"), "`pose` has no brackets"),
        (lambda it: it.add_key(("entities", "cube", "pose"), "a", "1"), "`pose` is not a mapping"),
    ],
)
def test_edits_in_other_places_are_refused(edit: Callable[[TextEdits], None], said: str) -> None:
    with pytest.raises(EditError, match=said):
        edited(edit)
