"""The formats that programs read: JSON, GitHub's workflow commands and SARIF."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path, PurePosixPath
from typing import Any

import jsonschema
import pytest

from scenecc.diagnostics import Diagnostic, Location, Related
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.explain import markdown
from scenecc.diagnostics.render import FORMATS, render
from scenecc.diagnostics.render.files import relative_file, uri

SCHEMA = Path(__file__).parents[2] / "data" / "sarif" / "sarif-schema-2.1.0.json"
ROOT = PurePosixPath("/home/me/scenes")


def sarif(diagnostics: list[Diagnostic]) -> dict[str, Any]:
    log = json.loads(render(diagnostics, "sarif", root=ROOT))
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft7Validator(schema).validate(log)
    return log["runs"][0]


def test_json_says_everything_in_a_fixed_order(typo: Diagnostic, bare: Diagnostic) -> None:
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


def test_json_of_nothing_is_still_a_report() -> None:
    assert json.loads(render([], "json")) == {"diagnostics": []}


def test_github_commands(typo: Diagnostic, bare: Diagnostic) -> None:
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
def test_files_are_named_from_the_root(file: str, name: str, relative: bool) -> None:
    assert relative_file(file, ROOT) == (name, relative)


def test_the_root_is_the_working_directory_unless_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_sarif_result(typo: Diagnostic) -> None:
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


def test_sarif_without_a_file_names_the_path_alone(bare: Diagnostic) -> None:
    (result,) = sarif([bare])["results"]
    assert result["locations"] == [{"logicalLocations": [{"fullyQualifiedName": "entities.cube.mass"}]}]


def test_sarif_outside_of_the_root_is_absolute() -> None:
    (result,) = sarif([Diagnostic("SC101", "note", "x", Location("/etc/a b.yaml", 1))])["results"]
    assert result["locations"] == [
        {"physicalLocation": {"artifactLocation": {"uri": "file:///etc/a%20b.yaml"}, "region": {"startLine": 1}}}
    ]


def test_sarif_of_nothing_is_a_run_without_results() -> None:
    run = sarif([])
    assert run["results"] == []
    assert run["tool"]["driver"]["rules"] == []


def test_sarif_holds_each_rule_that_occurs_once() -> None:
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
    assert list(FORMATS) == ["text", "json", "github", "sarif"]
    with pytest.raises(KeyError):
        render([], "html")


def test_asking_for_the_formats_loads_none_of_them() -> None:
    script = "import sys, scenecc.diagnostics.render as r; print([m for m in r.FORMATS.values() if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"
