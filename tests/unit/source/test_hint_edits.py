"""Text edits from hints: places, notations and comments. `tests/unit/spec/test_slips.py` applies every form of hint."""

from __future__ import annotations

import io

import pytest

from scenecc import validate
from scenecc.source.hint_edits import hint_edits, written_codes

BOX = "shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]"


def first_edit(text: str) -> str:
    """The text after the first edit of its first finding."""
    found = validate(io.StringIO(text))[0]
    return hint_edits(text, found)[0].applied(text)


def scene(*lines: str) -> str:
    return "\n".join(("scenecc: 1", "entities:", *lines, ""))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (("  a:", f"    {BOX}", "    mass: 0  # none", "  # next"), ("  a:", f"    {BOX}", "  # next")),
        (("  a:", "    mass: 0", "", f"    {BOX}"), ("  a:", "", f"    {BOX}")),
        ((f"  a: {{mass: 0, {BOX}}}",), (f"  a: {{{BOX}}}",)),
        ((f"  a: {{{BOX}, mass: 0}}",), (f"  a: {{{BOX}}}",)),
        ((f"  a: {{{BOX},", "      mass: 0}"), (f"  a: {{{BOX}}}",)),
        (
            ("  a:", "    shapes:", "      - mass: 1", "        type: sphere", "        radius: 1"),
            ("  a:", "    mass: 1", "    shapes:", "      - type: sphere", "        radius: 1"),
        ),
        (
            ("  a:", f"    {BOX}", "    pose:", "      p: [0, 0, 1]  # above", "    rotation: [0, 0, 90]"),
            ("  a:", f"    {BOX}", "    pose:", "      rpy_deg: [0, 0, 90]", "      p: [0, 0, 1]  # above"),
        ),
    ],
)  # fmt: skip
def test_edits_keep_all_other_text(before: tuple[str, ...], after: tuple[str, ...]) -> None:
    assert first_edit(scene(*before)) == scene(*after)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ((f"  a: {{{BOX}}}", "  b: {}", f"  a: {{mass: 1, {BOX}}}"), ("  b: {}", f"  a: {{mass: 1, {BOX}}}")),
        ((f"  1: {{{BOX}}}",), (f'  "1": {{{BOX}}}',)),
        (("  a:", "    visuals: [{type: sphere, radius: 1}]"), ("  a:", "    shapes: [{type: sphere, radius: 1}]")),
    ],
)
def test_words_of_hints_have_edits(before: tuple[str, ...], after: tuple[str, ...]) -> None:
    assert first_edit(scene(*before)) == scene(*after)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (("  mass:", f"    {BOX}", "    mass: -1"), ("  mass:", f"    {BOX}", "    mass: 1")),
        (
            (
                "  a:",
                f"    {BOX}",
                "lights:",
                "  b: {type: point, color: [3, 3, 3], position: [0, 0, 1], shadow: false, shadow_near: 3}",
            ),
            (
                "  a:",
                f"    {BOX}",
                "lights:",
                "  b: {type: point, color: [3, 3, 3], position: [0, 0, 1], shadow: true, shadow_near: 3}",
            ),
        ),
    ],
)
def test_no_entry_is_lost_but_that_of_the_finding(before: tuple[str, ...], after: tuple[str, ...]) -> None:
    assert first_edit(scene(*before)) == scene(*after)


def test_line_breaks_and_wide_characters_count() -> None:
    text = scene("  a:  # 😀", f"    {BOX}", '    x-note: "😀"', "    color: red # 😀").replace("\n", "\r\n")
    assert first_edit(text) == text.replace("red #", '"#ff0000" #')
    text = scene("  a:", f"    {BOX}", "    num_envs: 4").replace("\n", "\r\n")
    assert first_edit(text) == text.replace("    num_envs: 4\r\n", "").replace("entities", "num_scenes: 4\r\nentities")


def test_an_alias_is_not_edited_where_it_is_used() -> None:
    text = scene(f"  a: {{{BOX}, x-m: &m 0, mass: *m}}")
    found = next(one for one in validate(io.StringIO(text)) if one.code == "SC104")
    assert all("mass: *m" in edit.applied(text) or "mass" not in edit.applied(text) for edit in hint_edits(text, found))


@pytest.mark.parametrize(
    "line",
    [
        "  a: &a {b: *a, mass: 1kg}",
        f"  a: &a {{mass: 1kg, {BOX}}}\n  b: {{<<: *a}}",
        "  a: {shapes: [&b {type: sphere, r: 1}, *b]}",
        "  a: {shapes: [{<<: &c {type: sphere}, r: 1}]}",
    ],
)
def test_edits_of_shared_nodes_end(line: str) -> None:
    text = scene(line)
    for found in validate(io.StringIO(text)):
        assert len(hint_edits(text, found)) < 20


@pytest.mark.parametrize(
    ("hint", "codes"),
    [
        ("write `width: 64` and `height: 64` [px]", ["width: 64, height: 64"]),
        ("write `a`, or `b`", ["a", "b"]),
        ("write `mass: 1` beside `shapes`, or the `density` of this shape", ["mass: 1"]),
        ("write a smaller `timestep`", []),
        ("it is half of that (in MuJoCo, `size` is already half)", []),
    ],
)
def test_what_a_hint_says_to_write(hint: str, codes: list[str]) -> None:
    assert written_codes(hint) == codes
