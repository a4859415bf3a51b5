"""The reports that GitLab and services that read JUnit show."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import PurePosixPath
from xml.etree import ElementTree as ET

import jsonschema

from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.diagnostic import Location, Related
from scenecc.diagnostics.formats import render

FOUND = Diagnostic("SC526", "warning", "90 radians", Location("a/s.yaml", 7, 3), "entities.b", "write `rpy_deg`")
CODE_QUALITY = {
    # What https://docs.gitlab.com/ci/testing/code_quality/ requires of a report.
    "type": "array",
    "items": {
        "type": "object",
        "required": ["description", "check_name", "fingerprint", "severity", "location"],
        "properties": {
            "description": {"type": "string", "minLength": 1},
            "check_name": {"type": "string", "minLength": 1},
            "fingerprint": {"type": "string", "minLength": 1},
            "severity": {"enum": ["info", "minor", "major", "critical", "blocker"]},
            "location": {
                "type": "object",
                "required": ["path", "lines"],
                "properties": {
                    "path": {"type": "string", "pattern": r"^(?!\./)"},
                    "lines": {
                        "type": "object",
                        "required": ["begin"],
                        "properties": {"begin": {"type": "integer", "minimum": 1}},
                    },
                },
            },
        },
    },
}


def test_gitlab_issues_have_the_fields_of_code_quality() -> None:
    bare = Diagnostic("SC101", "error", "wrong", Location(None))
    issues = json.loads(render([FOUND, FOUND, bare], "gitlab", root=PurePosixPath("/r")))
    jsonschema.validate(issues, CODE_QUALITY)
    assert issues[0]["location"] == {"path": "a/s.yaml", "lines": {"begin": 7}}
    assert issues[0]["severity"] == "minor"
    assert len({issue["fingerprint"] for issue in issues}) == 3
    assert json.loads(render([], "gitlab")) == []


def test_a_gitlab_issue_stays_the_same_when_lines_above_it_change() -> None:
    moved = replace(FOUND, location=Location("a/s.yaml", 70, 3))
    first, second = (json.loads(render([one], "gitlab"))[0]["fingerprint"] for one in (FOUND, moved))
    assert first == second


def test_junit_has_one_case_per_file() -> None:
    note = Diagnostic("SC222", "note", "empty <repeat> & \x1b]0;x\ufffe", Location("n.yaml", 1))
    text = render([FOUND, note], "junit", files=["good.yaml", "a/s.yaml", "n.yaml"], strict=["a/s.yaml"])
    (suite,) = ET.fromstring(text)
    assert suite.attrib == {"name": "scenecc", "tests": "3", "failures": "1", "errors": "0"}
    good, bad, noted = suite
    assert (good.get("name"), len(good)) == ("good.yaml", 0)
    (failure,) = bad
    assert (failure.tag, failure.get("type")) == ("failure", "warning")
    assert "a/s.yaml:7:3: warning SC526: 90 radians" in (failure.text or "")
    assert [part.tag for part in noted] == ["system-out"]
    placed = replace(FOUND, related=(Related("the place in the prefab", Location("scenecc:cube", 12, 3)),))
    assert "; note: scenecc:cube:12:3: the place in the prefab</system-out>" in render([placed], "junit")
    assert 'failures="0"' in render([placed], "junit", files=["a/s.yaml"])
