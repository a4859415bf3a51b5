"""The text format: what people read, and what a terminal must not be made to do."""

from __future__ import annotations

import io
import re

import pytest
from rich.cells import cell_len

from scenecc.diagnostics import Diagnostic, Location
from scenecc.diagnostics.render import render, wants_color
from scenecc.diagnostics.render.excerpt import excerpt
from scenecc.diagnostics.render.terminal import visible


def at(text: str, column: int, end_column: int | None = None) -> Diagnostic:
    return Diagnostic("SC101", "error", "wrong", Location("s.yaml", 7, column, end_column, text))


def underlined(text: str, column: int, end_column: int | None = None) -> tuple[str, str]:
    """The source line as shown, and the underline below it, from the same cell on."""
    lines = render([at(text, column, end_column)]).splitlines()
    assert lines[1].startswith("7 |")
    assert lines[2].startswith("  | ")
    return lines[1][4:], lines[2][4:]


def test_whole_report(typo: Diagnostic, bare: Diagnostic) -> None:
    assert render([typo, bare]) == (
        "scene.yaml:4:20: error SC101: `half_sise` is not a key of a box\n"
        "    --> entities.cube.shapes[0].half_sise\n"
        "  4 |       - {type: box, half_sise: [1, 1, 1]}\n"
        "    |                    ^^^^^^^^^\n"
        "    = hint: did you mean `half_size`?\n"
        "    = note: scene.yaml:112:9: the box is here\n"
        "112 |       - {type: box}\n"
        "    |         ^\n"
        "\n"
        "<dict>: warning SC501: the mass is tiny\n"
        "  --> entities.cube.mass\n"
        "\n"
        "1 error, 1 warning\n"
    )


def test_nothing_to_say_is_an_empty_text() -> None:
    assert render([]) == ""


def test_the_last_line_counts(typo: Diagnostic, bare: Diagnostic) -> None:
    note = Diagnostic("SC502", "note", "so it is", Location(None))
    last = render([typo, typo, bare, note, note]).splitlines()[-1]
    assert last == "2 errors, 1 warning, 2 notes"
    assert render([bare]).splitlines()[-1] == "0 errors, 1 warning"


def test_order_is_kept(typo: Diagnostic, bare: Diagnostic) -> None:
    text = render([bare, typo])
    assert text.index("SC501") < text.index("SC101")


def test_a_hint_of_several_lines_stays_indented(typo: Diagnostic) -> None:
    hint = "write\nbox:\n  half_size: 1\n\x1b[2J"
    lines = render([Diagnostic("SC101", "error", "wrong", Location("s.yaml"), hint=hint)]).splitlines()
    assert lines[1:5] == ["  = hint: write", "          box:", "            half_size: 1", "          ␛[2J"]


def test_a_message_cannot_start_a_line_of_its_own() -> None:
    forged = "wrong\nother.yaml:1:1: error SC999: forged\r\x1b[1A"
    lines = render([Diagnostic("SC101", "error", forged, Location("s\n.yaml"), path="a\nb")]).splitlines()
    assert lines[0] == "s␊.yaml: error SC101: wrong␊other.yaml:1:1: error SC999: forged␍␛[1A"
    assert lines[1] == "  --> a␊b"


@pytest.mark.parametrize(
    ("text", "column", "end_column", "under"),
    [
        ("mass: -1", 7, 9, "-1"),
        ("mass: -1", 7, None, "-"),
        ("mass: -1", 7, 7, "-"),
        ("mass: -1", 7, 3, "-"),
        ("mass: -1", 7, 99, "-1"),
        ("名前: 箱", 5, 6, "箱"),
        ("名前: 箱子", 1, 3, "名前"),
        ("🤖: 🦾🦿", 4, 6, "🦾🦿"),
        ("e\u0301te\u0301: x", 8, 9, "x"),
        ("a:\t\tb", 5, 6, "b"),
        ("\ta: bc", 5, 7, "bc"),
        ("a: \x1b[31mred", 9, 12, "red"),
        ("a: \u202egnp.exe", 5, 8, "gnp"),
    ],
)
def test_the_underline_is_below_what_it_means(text: str, column: int, end_column: int | None, under: str) -> None:
    shown, marks = underlined(text, column, end_column)
    indent = len(marks) - len(marks.lstrip())
    before = shown[: shown.rindex(under)]
    assert cell_len(before) == indent
    assert len(marks.strip()) == cell_len(under)
    assert set(marks.strip()) == {"^"}


def test_a_place_after_the_last_character() -> None:
    assert underlined("mass:", 6) == ("mass:", "     ^")
    assert underlined("mass:", 600) == ("mass:", "     ^")
    assert underlined("", 1) == ("", "^")


@pytest.mark.parametrize("column", [1, 30, 5_000, 9_990, 10_001])
@pytest.mark.parametrize("unit", ["a", "箱", "\t", "\x00", "e\u0301", "\u202e"])
def test_a_long_line_is_cut_around_the_place(column: int, unit: str) -> None:
    text = (unit * 10_000)[:10_000]
    part = excerpt(text[: column - 1] + "X" + text[column:], column, column + 1, width=80)
    assert cell_len(part.shown) <= 80
    assert "…" in part.shown
    assert part.shown.index("X") == len(part.shown) - len(part.shown[part.shown.index("X") :])
    assert cell_len(part.shown[: part.shown.index("X")]) == part.indent
    assert part.length == 1


def test_an_underline_that_runs_out_of_the_cut_line_ends_with_it() -> None:
    part = excerpt("x" * 1_000, 500, 900, width=80)
    assert part.indent + part.length <= cell_len(part.shown) <= 80
    assert part.length > 20


def test_a_line_that_fits_is_not_cut() -> None:
    text = "x" * 80
    assert excerpt(text, 80, 81, width=80).shown == text


def test_a_line_of_sixteen_mebibytes_is_quick() -> None:
    part = excerpt("ab " * 5_000_000, 7_000_000, 7_000_001, width=80)
    assert cell_len(part.shown) <= 80


def test_colour_only_when_asked(typo: Diagnostic) -> None:
    plain, coloured = render([typo]), render([typo], color=True)
    assert "\x1b" not in plain
    assert "\x1b[1;31merror SC101\x1b[0m" in coloured
    assert _without_colour(coloured) == plain


def _without_colour(text: str) -> str:
    return re.sub(r"\x1b\[[0-9;]*m", "", text)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain text", "plain text"),
        ("naïve 箱 🤖 é", "naïve 箱 🤖 é"),
        ("\x00\x07\x1b\x7f", "␀␇␛␡"),
        ("\x85\x9b", "<U+0085><U+009B>"),
        ("\u2028\u2029", "<U+2028><U+2029>"),
        ("\u202e\u2066\ufeff\u200b", "<U+202E><U+2066><U+FEFF><U+200B>"),
        ("\ud800", "<U+D800>"),
        ("\U000e0041", "<U+E0041>"),
        ("👩\u200d🔬", "👩\u200d🔬"),
    ],
)
def test_what_would_steer_a_terminal_shows(text: str, shown: str) -> None:
    assert visible(text) == shown


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("environ", "terminal", "pipe"),
    [
        ({}, True, False),
        ({"NO_COLOR": "1"}, False, False),
        ({"NO_COLOR": ""}, True, False),
        ({"FORCE_COLOR": "1"}, True, True),
        ({"FORCE_COLOR": ""}, True, False),
        ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, False, False),
        ({"TERM": "dumb"}, False, False),
        ({"TERM": "dumb", "FORCE_COLOR": "1"}, True, True),
    ],
)
def test_who_decides_about_colour(environ: dict[str, str], terminal: bool, pipe: bool) -> None:
    assert wants_color(Terminal(), environ) is terminal
    assert wants_color(io.StringIO(), environ) is pipe


def test_the_process_environment_is_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert wants_color(io.StringIO())
    monkeypatch.setenv("NO_COLOR", "1")
    assert not wants_color(io.StringIO())
