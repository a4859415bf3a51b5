"""What a place in a half-typed text is for."""

from time import process_time

import pytest
from plugins.nightly import assert_took

from scenecc.lsp.cursor import cursor_at

ENTITY = ("entities", "cube")

CASES = {
    "nothing": ("¦", (), "kv", ""),
    "a section": ("ent¦", (), "kv", "ent"),
    "a key of an entity": ("entities:\n  cube:\n    ma¦", ENTITY, "kv", "ma"),
    "a key after others": ("entities:\n  cube:\n    mass: 1\n    ¦", ENTITY, "kv", ""),
    "a blank line between": ("entities:\n  cube:\n    mass: 1\n\n    co¦", ENTITY, "kv", "co"),
    "another entity": ("entities:\n  cube:\n    mass: 1\n  ba¦", ("entities",), "kv", "ba"),
    "a value": ("entities:\n  cube:\n    body_type: st¦", (*ENTITY, "body_type"), "v", "st"),
    "a value without a blank": ("entities:\n  cube:\n    body_type:¦", (*ENTITY, "body_type"), "v", ""),
    "a value in double quotes": ('entities:\n  cube:\n    color: "#ff¦', (*ENTITY, "color"), "v", "#ff"),
    "a value in single quotes": ("entities:\n  cube:\n    material: 'oa¦", (*ENTITY, "material"), "v", "oa"),
    "the next line of a key": ("entities:\n  cube:\n    pose:\n      re¦", (*ENTITY, "pose"), "kv", "re"),
    "an item": ("include:\n  - ¦", ("include", 0), "kv", ""),
    "the second item": ("include:\n  - a.yaml\n  - b¦", ("include", 1), "kv", "b"),
    "items as deep as their key": ("include:\n- a.yaml\n- b¦", ("include", 1), "kv", "b"),
    "a key of an item": ("shapes:\n  - type: box\n    ha¦", ("shapes", 0), "kv", "ha"),
    "the first key of an item": ("shapes:\n  - ty¦", ("shapes", 0), "kv", "ty"),
    "items of items": ("a:\n  - - b\n    - c¦", ("a", 0, 1), "kv", "c"),
    "braces": ("entities:\n  cube: {ma¦", ENTITY, "k", "ma"),
    "a value in braces": ("entities:\n  cube: {pose: {relative_to: ta¦", (*ENTITY, "pose", "relative_to"), "v", "ta"),
    "a second key in braces": ("entities:\n  cube: {mass: 1, ¦", ENTITY, "k", ""),
    "brackets": ("include: [a.yaml, ¦", ("include", 1), "v", ""),
    "braces in brackets": ("shapes: [{type: box}, {type: sp¦", ("shapes", 1, "type"), "v", "sp"),
    "brackets over lines": ("shapes: [\n    {type: box,\n  ha¦", ("shapes", 0), "k", "ha"),
    "what follows brackets": ("shapes: [{type: box}] ¦", ("shapes",), "", ""),
    "a key after brackets over lines": ("a: [\n  1,\n  2]\nb¦", (), "kv", "b"),
    "braces in a quoted text": ('a: {b: "x{", c¦', ("a",), "k", "c"),
    "an expression": ('a: {b: "${si¦', ("a", "b"), "v", "${si"),
    "a comment": ("a: 1\n# b¦", ("a",), "", ""),
    "a comment behind a value": ("a: b  # c¦", ("a",), "", "b  # c"),
    "block text": ("description: |\n  entities: [¦", ("description",), "", ""),
    "a key after block text": ("description: |\n  entities: [\n\nent¦", (), "kv", "ent"),
    "a quoted key": ('"a b":\n  c¦', ("a b",), "kv", "c"),
    "an anchor": ("a: &one\n  b¦", ("a",), "kv", "b"),
    "a value with a colon": ("use: scenecc:¦", ("use",), "v", "scenecc:"),
    "a path": ("file: pkg://a/b¦", ("file",), "v", "pkg://a/b"),
}


@pytest.mark.parametrize("case", CASES)
def test_the_cursor_finds_the_typed_node(case):
    text, path, kinds, typed = CASES[case]
    lines = text.removesuffix("¦").split("\n")
    found = cursor_at(lines, len(lines) - 1, len(lines[-1]))
    assert found.path == path
    assert ("k" * found.keys + "v" * found.values, found.typed) == (kinds, typed)
    if kinds:
        assert lines[-1][found.start :] == typed


def test_the_cursor_knows_earlier_keys():
    lines = ["entities:", "  cube:", "    body_type: static", "    shapes: [{type: box, "]
    found = cursor_at(lines, 3, len(lines[3]))
    assert found.seen[("entities", "cube")]["body_type"] == "static"
    assert found.seen[("entities", "cube", "shapes", 0)] == {"type": "box"}


@pytest.mark.parametrize("part", ["[", "{a: ", "- ", " ", "'", "a:", "&a ", "a b", "? "])
def test_hostile_lines_are_parsed_fast(part):
    line = part * 50_001 + ":"
    before = process_time()
    cursor_at([line], 0, len(line))
    assert_took(process_time() - before, most=5)
