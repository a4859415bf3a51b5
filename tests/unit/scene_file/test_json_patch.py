"""JSON Patch on the text of a scene: what changes, what stays, and what is refused."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from scenecc.scene_file.json_patch import PatchError, parse_patch, patch_text
from scenecc.source import Limits

TEXT = """\
# a scene
scenecc: 1

entities:
  cube:   {pose: [0, 0,  1], mass: 2}   # a cube
  ball:
    # where it is
    pose: {p: [1, 2, 3]}   # in the air
    shapes:
      # the only shape
      - {type: sphere, radius: 0.1}
      - type: box   # another
        half_size:
          - 0.1   # x
          - 0.2
          - 0.3
    name: 'a ball'
  # at the end
"""

ANCHORS = """\
entities:
  a: &base
    mass: &heavy 5
    pose: [0, 0, 1]
  b:
    <<: *base
    pose: [1, 0, 1]
  c: {mass: *heavy, pose: [2, 0, 1]}
"""


def patched(*operations: dict[str, Any], text: str = TEXT) -> str:
    return patch_text(text, operations, Limits())


def op(name: str, path: str, **others: Any) -> dict[str, Any]:
    return {"op": name, "path": path, **others}


def moved(name: str, source: str, path: str) -> dict[str, Any]:
    return {"op": name, "from": source, "path": path}


BALL = TEXT[TEXT.index("  ball:") : TEXT.index("  # at the end")]

CHANGES: dict[str, tuple[dict[str, Any], str, str]] = {
    "number": (op("replace", "/entities/cube/pose/2", value=0.25), "0,  1]", "0,  0.25]"),
    "block number": (op("replace", "/entities/ball/shapes/1/half_size/0", value=9), "- 0.1   # x", "- 9   # x"),
    "quotes": (op("replace", "/entities/ball/name", value="the ball"), "'a ball'", "the ball"),
    "other type": (op("replace", "/entities/ball/name", value=3), "'a ball'", "3"),
    "flow key": (op("add", "/entities/cube/body_type", value="static"), "mass: 2}", "mass: 2, body_type: static}"),
    "flow item": (op("add", "/entities/cube/pose/1", value=7), "[0, 0,", "[0, 7, 0,"),
    "block key": (
        op("add", "/entities/ball/mass", value=1),
        "    name: 'a ball'\n",
        "    name: 'a ball'\n    mass: 1\n",
    ),
    "list": (
        op("replace", "/entities/ball/shapes/1/half_size", value=[1, 2, 3]),
        "half_size:\n          - 0.1   # x\n          - 0.2\n          - 0.3\n",
        "half_size: [1, 2, 3]\n",
    ),
    "first item": (
        op("add", "/entities/ball/shapes/0", value={"type": "box"}),
        "      - {type: sphere",
        "      - {type: box}\n      - {type: sphere",
    ),
    "item": (op("remove", "/entities/ball/shapes/0"), "      - {type: sphere, radius: 0.1}\n", ""),
    "first key of an item": (
        op("remove", "/entities/ball/shapes/1/type"),
        "- type: box   # another\n        half_size",
        "- half_size",
    ),
    "flow entry": (op("remove", "/entities/cube/pose"), "pose: [0, 0,  1], ", ""),
    "last flow entry": (op("remove", "/entities/cube/mass"), ", mass: 2", ""),
    "only entry": (op("remove", "/entities/ball/pose/p"), "{p: [1, 2, 3]}", "{}"),
    "block for a value": (
        op("replace", "/entities/ball/name", value={"a": {"b": {"c": {"d": 1}}}}),
        " 'a ball'\n",
        "\n      a: {b: {c: {d: 1}}}\n",
    ),
    "rename": (moved("move", "/entities/ball", "/entities/egg"), "  ball:", "  egg:"),
    "copy": (moved("copy", "/entities/ball", "/entities/egg"), BALL, BALL + BALL.replace("ball:", "egg:")),
    "move": (
        moved("move", "/entities/ball/shapes/0", "/entities/ball/shapes/1"),
        "      - {type: sphere, radius: 0.1}\n" + BALL[BALL.index("      - type: box") : BALL.index("    name")],
        BALL[BALL.index("      - type: box") : BALL.index("    name")] + "      - {type: sphere, radius: 0.1}\n",
    ),
    "new section": (op("add", "/name", value="x"), "  # at the end\n", "  # at the end\n\nname: x\n"),
}


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("change", CHANGES)
def test_an_operation_changes_only_its_place(change: str, end: str) -> None:
    made, old, new = CHANGES[change]
    wanted = TEXT.replace(old, new)
    assert wanted != TEXT
    if change == "copy":  # the comment of the mapping stays last
        wanted = TEXT + BALL.replace("ball:", "egg:")
    found = patched(made, text=TEXT.replace("\n", end))
    assert found == wanted.replace("\n", end)


def test_a_new_entry_is_separated_by_a_blank_line_like_the_others() -> None:
    text = "entities:\n  a: {mass: 1}\n\n  b:\n    mass: 1\nname: x"
    found = patched(op("add", "/entities/c", value={"pose": [0, 0, 1]}), text=text)
    assert found == text.replace("\nname", "\n\n  c:\n    pose: [0, 0, 1]\nname")


def test_indentation_of_the_file_is_kept() -> None:
    text = "entities:\n    a:\n        pose:\n            p: [0, 0, 1]\n"
    found = patched(op("add", "/entities/b", value={"pose": {"p": [1, 2, 3], "rpy_deg": [0, 0, 90]}}), text=text)
    assert found == text + "    b:\n        pose: {p: [1, 2, 3], rpy_deg: [0, 0, 90]}\n"


def test_a_comment_in_brackets_stays_a_comment() -> None:
    text = "a: {b: [1, 0],   # one\n    c: 2}\n"
    assert patched(op("remove", "/a/b"), text=text) == "a: { # one\n    c: 2}\n"


def test_a_scene_in_json_stays_json() -> None:
    text = '{\n  "scenecc": 1,\n  "entities": {"cube": {"mass": 1}}\n}\n'
    made = [
        op("add", "/entities/ball", value={"pose": [0, 0, 1], "name": "b"}),
        op("add", "/entities/cube/on", value=True),
        op("replace", "/entities/cube/mass", value=2),
    ]
    assert json.loads(patched(*made, text=text)) == {
        "scenecc": 1,
        "entities": {"cube": {"mass": 2, "on": True}, "ball": {"pose": [0, 0, 1], "name": "b"}},
    }


def test_block_scalars_keep_their_ends() -> None:
    text = "a:\n  text: |\n    one\n    # two\n  # after\nb: 1\n"
    assert patched(op("add", "/a/c", value=1), text=text) == text.replace("# after\n", "# after\n  c: 1\n")
    assert patched(op("replace", "/a/text", value="x"), text=text) == "a:\n  text: x\n  # after\nb: 1\n"
    assert patched(op("remove", "/a/text"), text=text) == "a: {}\n  # after\nb: 1\n"


def test_anchors_stay_and_merged_keys_are_overridden() -> None:
    found = patched(op("replace", "/entities/b/mass", value=1), text=ANCHORS)
    assert found == ANCHORS.replace("    pose: [1, 0, 1]\n", "    pose: [1, 0, 1]\n    mass: 1\n")
    found = patched(op("replace", "/entities/c/mass", value=1), text=ANCHORS)
    assert found == ANCHORS.replace("mass: *heavy", "mass: 1")


@pytest.mark.parametrize(
    ("made", "said", "hint"),
    [
        (op("replace", "/entities/a/mass", value=1), "there is no anchor `&heavy` before this alias", None),
        (op("add", "/entities/a/name", value="x"), "other places use it through an anchor", None),
        (op("remove", "/entities/a"), "could not be read again", None),
        (op("remove", "/entities/b/mass"), "`mass` is not written there: it comes from a merge key", None),
        (op("replace", "/entities/bb/mass", value=1), "there is no key `bb` in /entities", "did you mean `b`?"),
        (op("replace", "/entities/b/masss", value=1), "no key `masss` in /entities/b; `add` adds a key", "`mass`"),
        (op("add", "/entities/b/pose/4", value=1), "there is no item `4` in /entities/b/pose, which has 3", None),
        (op("add", "/entities/b/pose/01", value=1), "there is no item `01`", None),
        (op("add", "/entities/b/pose/x/y", value=1), "there is no item `x`", None),
        (op("add", "/entities/b/pose/0/y", value=1), "/entities/b/pose/0 is a number, which has no `y`", None),
        (op("remove", "/entities/b/pose/-"), "there is no item `-`", None),
        (op("test", "/entities/b/pose/0", value=True), "the value is 1, not true", None),
        (op("remove", ""), "the whole document cannot be replaced", None),
        (moved("move", "/entities/b", "/entities/b/pose"), "/entities/b/pose is inside of /entities/b", None),
        (op("add", "/x", value=[{"y": None}]), "is there a null?", None),
        (op("add", "/x", value={1: 2}), "a scene file cannot hold the value", None),
        (op("add", "/x", value="\ud800"), "could not be read again", None),
        (op("add", "/x", value={1, 2}), "a scene file cannot hold the value", None),
        (op("add", "/x", value=10**200), "could not be read again: the number", None),
        (
            op("add", "/x", value=json.loads("[" * 110 + "]" * 110)),
            "could not be read again: more than 100 nested",
            None,
        ),
        (op("add", "x", value=1), "`path` x must begin with a slash", "write `/x`"),
        (op("add", "/~2", value=1), "`~` must be written as `~0`", None),
        (op("ad", "/x", value=1), "has the unknown `op` ad", "did you mean `add`?"),
        (op("add", "/x"), "(`add`) has no `value`", None),
        ({"op": "move", "form": "/a", "path": "/b"}, "(`move`) has no `from`", "did you mean `form`?"),
        ({"path": "/b"}, "has no `op`", "known: add"),
        ({"op": "add", "path": 3, "value": 1}, "`path` is a number, not a JSON Pointer", None),
        ([], "operation 2 of 2 is a list, not a mapping", "for example"),
    ],
)
def test_a_wrong_operation_is_refused_with_its_number(made: Any, said: str, hint: str | None) -> None:
    with pytest.raises(PatchError, match="operation 2 of 2") as found:
        patched(op("test", "/entities/b/pose/0", value=1.0), made, text=ANCHORS)
    assert said in str(found.value)
    assert (hint or "") in (found.value.hint or "")


def test_the_only_key_of_a_document_stays() -> None:
    with pytest.raises(PatchError, match="the whole document cannot be replaced"):
        patched(op("remove", "/entities"), text="entities:\n  a: {mass: 1}\n")


def test_integers_are_compared_exactly() -> None:
    with pytest.raises(PatchError, match="the value is 987654321, not 987654322"):
        patched(op("test", "/seed", value=987654322), text="seed: 987654321\n")


def test_values_deeper_than_the_stack_are_refused() -> None:
    value: Any = 1
    for _ in range(5000):
        value = [value]
    with pytest.raises(PatchError, match="deeper than Python's stack"):
        patched(op("add", "/x", value=value))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1", "the patch is not JSON: Expecting ',' delimiter, line 1 column 3"),
        ('[{"op": "add", "path": "/a", "value": NaN}]', "the patch contains NaN"),
        ('{"op": "add"}', "the patch is a mapping, not a list of operations"),
        ('[{"op": "add", "op": "remove"}]', "a key occurs twice"),
        ("[" * 100_000, "the patch is not JSON"),
    ],
)
def test_a_patch_that_is_not_json_is_refused(text: str, said: str) -> None:
    with pytest.raises(PatchError, match=re.escape(said)):
        parse_patch(text)
