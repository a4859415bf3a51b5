"""Every renderer takes every diagnostic: the texts in them come from strangers' files."""

from __future__ import annotations

import json
import re
import unicodedata
from pathlib import Path, PurePosixPath

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.diagnostics import Diagnostic, Location, Related
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.render import FORMATS, render

SARIF = jsonschema.Draft7Validator(
    json.loads((Path(__file__).parents[2] / "data" / "sarif" / "sarif-schema-2.1.0.json").read_text(encoding="utf-8"))
)
ROOT = PurePosixPath("/home/me/scenes")

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
def test_output_can_be_written(name: str, found: list[Diagnostic]) -> None:
    text = render(found, name, root=ROOT)
    text.encode("utf-8")
    assert text.endswith("\n") or not found


@given(found=reports)
def test_text_steers_no_terminal(found: list[Diagnostic]) -> None:
    plain = render(found)
    assert not [c for c in plain if c != "\n" and unicodedata.category(c) in {"Cc", "Cs", "Zl", "Zp"}]
    assert not set(plain) & set("\u202a\u202b\u202d\u202e\u2066\u2067\u2068\u2069\ufeff")
    coloured = render(found, color=True)
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain


@given(found=reports)
def test_text_starts_a_line_for_each_finding_and_no_other(found: list[Diagnostic]) -> None:
    blocks = render(found).split("\n\n")
    starts = [line for line in render(found).split("\n")[:-2] if line and not re.match(r" |\d+ \|", line)]
    assert len(starts) <= len(found)
    assert len(blocks) == (len(found) + 1 if found else 1)


@given(found=reports)
def test_json_parses_back(found: list[Diagnostic]) -> None:
    back = json.loads(render(found, "json"))["diagnostics"]
    assert len(back) == len(found)
    for record, diagnostic in zip(back, found, strict=True):
        assert record["line"] == diagnostic.line
        assert (record["hint"] is None) == (diagnostic.hint is None)
        assert len(record["related"]) == len(diagnostic.related)
        if not any("\ud800" <= c <= "\udfff" for c in diagnostic.message):
            assert record["message"] == diagnostic.message


@given(found=reports)
def test_github_has_one_line_a_diagnostic(found: list[Diagnostic]) -> None:
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
def test_sarif_is_sarif(found: list[Diagnostic]) -> None:
    log = json.loads(render(found, "sarif", root=ROOT))
    SARIF.validate(log)
    assert len(log["runs"][0]["results"]) == len(found)
