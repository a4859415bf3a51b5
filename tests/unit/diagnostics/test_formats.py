"""Diagnostics as text, JSON, GitHub's commands and SARIF."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import unicodedata
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from scenecc import validate
from scenecc.diagnostics import Diagnostic, Related
from scenecc.diagnostics.codes import CODES, Severity
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.formats import FORMATS, render, wants_color
from scenecc.diagnostics.formats.style import relative_file, uri, visible
from scenecc.diagnostics.formats.text import excerpt
from scenecc.diagnostics.reference import markdown


def at(text: str, column: int, end_column: int | None = None) -> Diagnostic:
    return Diagnostic("SC101", "error", "wrong", Location("s.yaml", 7, column, end_column, text))


def underlined(text: str, column: int, end_column: int | None = None) -> tuple[str, str]:
    """The source line as shown, and the underline below it, from the same cell on."""
    lines = render([at(text, column, end_column)]).splitlines()
    assert lines[1].startswith("7 |")
    assert lines[2].startswith("  | ")
    return lines[1][4:], lines[2][4:]


def test_a_text_report_is_complete(typo: Diagnostic, bare: Diagnostic) -> None:
    assert render([typo, bare]) == (
        "<dict>: warning SC501: the mass is tiny\n"
        "  --> entities.cube.mass\n"
        "\n"
        "scene.yaml:4:20: error SC101: `half_sise` is not a key of a box; did you mean `half_size`?\n"
        "    --> entities.cube.shapes[0].half_sise\n"
        "  4 |       - {type: box, half_sise: [1, 1, 1]}\n"
        "    |                    ^^^^^^^^^\n"
        "    = note: scene.yaml:112:9: the box is here\n"
        "112 |       - {type: box}\n"
        "    |         ^\n"
        "\n"
        "1 error, 1 warning\n"
    )


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("entities: {", "keys and values, parameters and prefabs, names and poses, physics"),
        ("entities: {a: {x: 1}}", "parameters and prefabs, names and poses, physics"),
        ("entities: {a: {use: scenecc:cubes}}", "names and poses, physics"),
        ("entities: {a: {shapes: [{type: sphere, radius: 1}], pose: {relative_to: b}}}", "physics"),
    ],
)
def test_what_was_not_checked_because_of_an_error_is_said_in_one_line(text: str, missing: str) -> None:
    found = validate(io.StringIO(f"scenecc: 1\n{text}\n"))
    line = f"not checked because of these errors: {missing}"
    assert render(found).splitlines()[-1] == line
    assert json.loads(render(found, "json"))["unchecked"] == {"<stream>": missing.split(", ")}
    assert f"::notice title=scenecc::{line}\n" in render(found, "github")
    (done,) = json.loads(render(found, "sarif"))["runs"][0]["invocations"]
    assert done["toolExecutionNotifications"][0]["message"]["text"] == line
    assert f"{line}</system-out>" in render(found, "junit", files=["<stream>"])
    named = {4: "a.yaml, b.yaml, c.yaml, d.yaml", 7: "a.yaml, b.yaml, c.yaml and 4 other files"}
    for count, files in named.items():
        several = [replace(one, location=Location(f"{name}.yaml", 2)) for name in "abcdefg"[:count] for one in found]
        assert render(several).splitlines()[-1] == f"{line} of {files}"
    two = [*found, *validate(io.StringIO("scenecc: 1\nx: 1\n"), num_scenes=2)]
    assert render(two).splitlines()[-1].startswith("not checked because of these errors: ")


def test_errors_come_last_in_text_and_by_place_in_other_formats() -> None:
    said: list[tuple[Severity, int]] = [("error", 1), ("note", 2), ("warning", 3), ("error", 4), ("note", 5)]
    found = [Diagnostic("SC101", severity, "x", Location("s.yaml", line)) for severity, line in said]
    assert re.findall(r"(?m)^s\.yaml:(\d)", render(found)) == ["2", "5", "3", "1", "4"]
    assert [each["line"] for each in json.loads(render(found, "json"))["diagnostics"]] == [1, 2, 3, 4, 5]


def test_no_diagnostics_give_an_empty_text() -> None:
    assert render([]) == ""


def test_the_last_line_counts_errors_and_warnings(typo: Diagnostic, bare: Diagnostic) -> None:
    note = Diagnostic("SC502", "note", "so it is", Location(None))
    last = render([typo, typo, bare, note, note]).splitlines()[-1]
    assert last == "2 errors, 1 warning, 2 notes"
    assert render([bare]).splitlines()[-1] == "0 errors, 1 warning"


def test_the_order_within_a_severity_is_kept(typo: Diagnostic, bare: Diagnostic) -> None:
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
def test_the_underline_is_below_its_text(text: str, column: int, end_column: int | None, under: str) -> None:
    shown, marks = underlined(text, column, end_column)
    indent = len(marks) - len(marks.lstrip())
    before = shown[: shown.rindex(under)]
    assert cell_len(before) == indent
    assert len(marks.strip()) == cell_len(under)
    assert set(marks.strip()) == {"^"}


def test_a_location_after_the_last_character_is_underlined() -> None:
    assert underlined("mass:", 6) == ("mass:", "     ^")
    assert underlined("mass:", 600) == ("mass:", "     ^")
    assert underlined("", 1) == ("", "^")


@pytest.mark.parametrize("column", [1, 30, 5_000, 9_990, 10_001])
@pytest.mark.parametrize("unit", ["a", "箱", "\t", "\x00", "e\u0301", "\u202e"])
def test_a_long_line_is_cut_around_the_caret(column: int, unit: str) -> None:
    text = (unit * 10_000)[:10_000]
    part = excerpt(text[: column - 1] + "X" + text[column:], column, column + 1, width=80)
    assert cell_len(part.shown) <= 80
    assert "…" in part.shown
    assert part.shown.index("X") == len(part.shown) - len(part.shown[part.shown.index("X") :])
    assert cell_len(part.shown[: part.shown.index("X")]) == part.indent
    assert part.length == 1


def test_an_underline_ends_with_the_cut_line() -> None:
    part = excerpt("x" * 1_000, 500, 900, width=80)
    assert part.indent + part.length <= cell_len(part.shown) <= 80
    assert part.length > 20


def test_a_line_that_fits_is_not_cut() -> None:
    text = "x" * 80
    assert excerpt(text, 80, 81, width=80).shown == text


def test_a_line_of_sixteen_mebibytes_is_rendered_quickly() -> None:
    part = excerpt("ab " * 5_000_000, 7_000_000, 7_000_001, width=80)
    assert cell_len(part.shown) <= 80


def test_text_is_coloured_only_on_request(typo: Diagnostic) -> None:
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
def test_control_characters_are_spelled_out(text: str, shown: str) -> None:
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
def test_no_color_force_color_and_term_decide_about_colour(environ: dict[str, str], terminal: bool, pipe: bool) -> None:
    assert wants_color(Terminal(), environ) is terminal
    assert wants_color(io.StringIO(), environ) is pipe


def test_wants_color_reads_the_process_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert wants_color(io.StringIO())
    monkeypatch.setenv("NO_COLOR", "1")
    assert not wants_color(io.StringIO())


SCHEMA = Path(__file__).parents[2] / "data" / "sarif" / "sarif-schema-2.1.0.json"
ROOT = PurePosixPath("/home/me/scenes")


def sarif(diagnostics: list[Diagnostic]) -> dict[str, Any]:
    log = json.loads(render(diagnostics, "sarif", root=ROOT))
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft7Validator(schema).validate(log)
    return log["runs"][0]


def test_json_has_all_fields_in_a_fixed_order(typo: Diagnostic, bare: Diagnostic) -> None:
    text = render([typo, bare], "json")
    first, second = json.loads(text)["diagnostics"]
    assert list(first.items()) == [
        ("code", "SC101"),
        ("severity", "error"),
        ("message", "`half_sise` is not a key of a box"),
        ("file", "scene.yaml"),
        ("line", 4),
        ("column", 20),
        ("end_column", 29),
        ("path", "entities.cube.shapes[0].half_sise"),
        ("hint", "did you mean `half_size`?"),
        (
            "related",
            [{"message": "the box is here", "file": "scene.yaml", "line": 112, "column": 9, "end_column": 10}],
        ),
    ]
    assert list(second) == list(first)
    assert second["file"] is None
    assert second["line"] is None
    assert text.endswith("}\n")
    assert text.isascii()


def test_json_without_diagnostics_is_a_report() -> None:
    assert json.loads(render([], "json")) == {"diagnostics": []}


def test_github_prints_workflow_commands(typo: Diagnostic, bare: Diagnostic) -> None:
    note = Diagnostic("SC502", "note", "so it is", Location("a.yaml", 3))
    message = (
        "`half_sise` is not a key of a box%0Aat entities.cube.shapes[0].half_sise"
        "%0Ahint: did you mean `half_size`?%0Ascene.yaml:112:9: the box is here"
    )
    assert render([typo, bare, note], "github", root=ROOT).splitlines() == [
        f"::error file=scene.yaml,line=4,col=20,endColumn=29,title=SC101::{message}",
        "::warning title=SC501::the mass is tiny%0Aat entities.cube.mass",
        "::notice file=a.yaml,line=3,title=SC502::so it is",
    ]


def test_github_escapes_what_its_runner_unescapes() -> None:
    odd = Diagnostic("SC101", "error", "100%\r\n::error::x,y: z\x1b\u2028", Location("a,b:c%.yaml", 1, 1))
    assert render([odd], "github", root=ROOT) == (
        "::error file=a%2Cb%3Ac%25.yaml,line=1,col=1,title=SC101::100%25%0A::error::x,y: z␛<U+2028>\n"
    )


@pytest.mark.parametrize(
    ("file", "name", "relative"),
    [
        ("scene.yaml", "scene.yaml", True),
        ("./a/../scene.yaml", "scene.yaml", True),
        ("/home/me/scenes/deep/scene.yaml", "deep/scene.yaml", True),
        ("/home/me/scenes2/scene.yaml", "/home/me/scenes2/scene.yaml", False),
        ("../other/scene.yaml", "/home/me/other/scene.yaml", False),
        ("<stdin>", "<stdin>", True),
    ],
)
def test_file_names_are_relative_to_the_root(file: str, name: str, relative: bool) -> None:
    assert relative_file(file, ROOT) == (name, relative)


def test_the_default_root_is_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert relative_file(str(tmp_path / "a" / "s.yaml"), None) == ("a/s.yaml", True)


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("a b#1?.yaml", "a%20b%231%3F.yaml"),
        ("100%.yaml", "100%25.yaml"),
        ("a:b.yaml", "a%3Ab.yaml"),
        ("箱.yaml", "%E7%AE%B1.yaml"),
        ("caf\udce9.yaml", "caf%E9.yaml"),
        ("\ud800.yaml", "%3F.yaml"),
        ("/etc/a b.yaml", "file:///etc/a%20b.yaml"),
    ],
)
def test_uris_are_percent_encoded(file: str, expected: str) -> None:
    assert uri(file, ROOT)[0] == expected


def test_a_sarif_result_has_all_fields(typo: Diagnostic) -> None:
    run = sarif([typo])
    assert run["columnKind"] == "unicodeCodePoints"
    assert run["tool"]["driver"]["name"] == "scenecc"
    place = {"artifactLocation": {"uri": "scene.yaml", "uriBaseId": "%SRCROOT%"}}
    assert run["results"] == [
        {
            "ruleId": "SC101",
            "ruleIndex": 0,
            "level": "error",
            "message": {"text": "`half_sise` is not a key of a box\nHint: did you mean `half_size`?"},
            "locations": [
                {
                    "physicalLocation": {**place, "region": {"startLine": 4, "startColumn": 20, "endColumn": 29}},
                    "logicalLocations": [{"fullyQualifiedName": "entities.cube.shapes[0].half_sise"}],
                }
            ],
            "relatedLocations": [
                {
                    "id": 0,
                    "physicalLocation": {**place, "region": {"startLine": 112, "startColumn": 9, "endColumn": 10}},
                    "message": {"text": "the box is here"},
                }
            ],
        }
    ]


def test_sarif_without_a_file_has_only_the_path(bare: Diagnostic) -> None:
    (result,) = sarif([bare])["results"]
    assert result["locations"] == [{"logicalLocations": [{"fullyQualifiedName": "entities.cube.mass"}]}]


def test_sarif_uris_outside_the_root_are_absolute() -> None:
    (result,) = sarif([Diagnostic("SC101", "note", "x", Location("/etc/a b.yaml", 1))])["results"]
    assert result["locations"] == [
        {"physicalLocation": {"artifactLocation": {"uri": "file:///etc/a%20b.yaml"}, "region": {"startLine": 1}}}
    ]


def test_sarif_without_diagnostics_is_a_run_without_results() -> None:
    run = sarif([])
    assert run["results"] == []
    assert run["tool"]["driver"]["rules"] == []


def test_sarif_lists_each_rule_once() -> None:
    rows = list(CODES.values())
    found = [Diagnostic(row.code, row.severity, "x", Location("s.yaml")) for row in reversed(rows)] * 2
    run = sarif(found)
    rules = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == sorted(CODES)
    for rule in rules:
        row = CODES[rule["id"]]
        assert rule["shortDescription"]["text"] == row.title
        assert rule["defaultConfiguration"]["level"] == row.severity
        assert rule["help"]["markdown"] == markdown(row)
    assert all(rules[result["ruleIndex"]]["id"] == result["ruleId"] for result in run["results"])


def test_related_places_without_a_file_are_kept() -> None:
    found = Diagnostic("SC101", "error", "x", Location("s.yaml"), related=(Related("there", Location(None)),))
    (result,) = sarif([found])["results"]
    assert result["relatedLocations"] == [{"id": 0, "message": {"text": "there"}}]
    assert render([found], "github", root=ROOT).rstrip().endswith("%0Athere")


def test_every_format_is_found_by_name() -> None:
    assert list(FORMATS) == ["text", "json", "github", "gitlab", "junit", "sarif"]
    with pytest.raises(KeyError):
        render([], "html")


def test_listing_the_formats_loads_none_of_them() -> None:
    script = "import sys, scenecc.diagnostics.formats as r; print([m for m in r.FORMATS.values() if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


SARIF = jsonschema.Draft7Validator(
    json.loads((Path(__file__).parents[2] / "data" / "sarif" / "sarif-schema-2.1.0.json").read_text(encoding="utf-8"))
)

hostile = st.sampled_from("\x00\t\n\r\x0b\x1b\x7f\x85\x9b\u2028\u202e\ufeff\ud800\udfff\u200d\u0301箱🤖%:,/")
texts = st.text(st.one_of(st.characters(), hostile), max_size=40)
lines = st.one_of(texts, texts.map(lambda text: text * 20))
numbers = st.one_of(st.none(), st.integers(1, 1_000_000), st.integers(1, 40))
locations = st.builds(
    Location,
    file=st.one_of(st.none(), texts),
    line=numbers,
    column=numbers,
    end_column=numbers,
    text=st.one_of(st.none(), lines),
)
diagnostics = st.builds(
    Diagnostic,
    code=st.one_of(st.sampled_from([*CODES, "SC000"]), texts),
    severity=st.sampled_from(["error", "warning", "note"]),
    message=texts,
    location=locations,
    path=texts,
    hint=st.one_of(st.none(), texts),
    related=st.lists(st.builds(Related, message=texts, location=locations), max_size=3).map(tuple),
)
reports = st.lists(diagnostics, max_size=4)


@pytest.mark.parametrize("name", FORMATS)
@given(found=reports)
def test_every_format_can_be_encoded(name: str, found: list[Diagnostic]) -> None:
    text = render(found, name, root=ROOT)
    text.encode("utf-8")
    assert text.endswith("\n") or not found


@given(found=reports)
def test_text_has_no_control_characters(found: list[Diagnostic]) -> None:
    plain = render(found)
    assert not [c for c in plain if c != "\n" and unicodedata.category(c) in {"Cc", "Cs", "Zl", "Zp"}]
    assert not set(plain) & set("\u202a\u202b\u202d\u202e\u2066\u2067\u2068\u2069\ufeff")
    coloured = render(found, color=True)
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain


@given(found=reports)
def test_text_starts_one_line_per_finding(found: list[Diagnostic]) -> None:
    blocks = render(found).split("\n\n")
    starts = [line for line in render(found).split("\n")[:-2] if line and not re.match(r" |\d+ \|", line)]
    assert len(starts) <= len(found)
    assert len(blocks) == (len(found) + 1 if found else 1)


@given(found=reports)
def test_json_can_be_parsed(found: list[Diagnostic]) -> None:
    back = json.loads(render(found, "json"))["diagnostics"]
    assert len(back) == len(found)
    for record, diagnostic in zip(back, found, strict=True):
        assert record["line"] == diagnostic.line
        assert (record["hint"] is None) == (diagnostic.hint is None)
        assert len(record["related"]) == len(diagnostic.related)
        if not any("\ud800" <= c <= "\udfff" for c in diagnostic.message):
            assert record["message"] == diagnostic.message


@given(found=reports)
def test_github_has_one_line_per_diagnostic(found: list[Diagnostic]) -> None:
    text = render(found, "github", root=ROOT)
    assert len(text.splitlines()) == len(found)
    for line, diagnostic in zip(text.splitlines(), found, strict=True):
        command = re.fullmatch(r"::(?:error|warning|notice) (.*?)::(.*)", line)
        assert command is not None
        properties, message = command.groups()
        assert {p.split("=")[0] for p in properties.split(",")} <= {"file", "line", "col", "endColumn", "title"}
        plain = message.replace("%0A", "\n").replace("%0D", "\r").replace("%25", "%")
        if diagnostic.message.isascii() and diagnostic.message.isprintable():
            assert plain.startswith(diagnostic.message)


@given(found=reports)
def test_sarif_follows_its_schema(found: list[Diagnostic]) -> None:
    log = json.loads(render(found, "sarif", root=ROOT))
    SARIF.validate(log)
    assert len(log["runs"][0]["results"]) == len(found)
