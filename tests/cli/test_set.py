"""`--set NAME=VALUE`: what is read from the command line."""

from __future__ import annotations

import re
from typing import Any

import pytest
import typer

from scenecc.cli.options import parse_params


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x=0.5", 0.5),
        ("x= 1 ", 1),
        ("x=-1e3", -1000.0),
        ("x=yes", "yes"),
        ("x=true", True),
        ("x=[1, 2.5]", [1, 2.5]),
        ("x={physical: {density: 3}}", {"physical": {"density": 3}}),
        ("x=#ff0000", "#ff0000"),
        ('x="#ff0000"', "#ff0000"),
        ("x=a=b", "a=b"),
        ("x=1 # one", 1),
        ('x=""', ""),
        ("x='a: b'", "a: b"),
    ],
)
def test_values_of_set_are_yaml(text: str, value: Any) -> None:
    found = parse_params([text])["x"]
    assert (type(found), found) == (type(value), value)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["x"], "name=value"),
        (["=1"], "name=value"),
        (["x="], "no value"),
        (["x=null"], "no value"),
        (["x=a: 1"], "quote the value"),
        (["x=[1"], "never closed"),
        (["x=1\ny: 2"], "several lines"),
        (["x=!!python/name:os.system 1"], "core schema"),
        (["x=1", "x=1"], "twice"),
        (["x=\x1b[2J\x1b"], "control character"),
    ],
)
def test_an_invalid_value_of_set_is_wrong_usage(given: list[str], said: str) -> None:
    with pytest.raises(typer.BadParameter, match=re.escape(said)) as caught:
        parse_params(given)
    assert "\x1b" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_without_set_no_parameter_is_set() -> None:
    assert parse_params(None) == {}
