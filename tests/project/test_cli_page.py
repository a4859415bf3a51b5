"""The page on the command line says what the help says, and the help's examples take options that exist."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from plugins.cli_page import commands, examples, page

from scenecc.cli.app import COMMANDS

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def no_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["scenecc"])


def test_the_page_is_generated_from_the_help() -> None:
    committed = (ROOT / "docs/reference/cli.md").read_text(encoding="utf-8")
    assert committed == page(), "run `python tests/plugins/cli_page.py > docs/reference/cli.md`"


@pytest.mark.parametrize("name", COMMANDS)
def test_an_example_is_a_call_that_the_command_takes(name: str) -> None:
    calls = [line.rpartition("| ")[2] for line in examples(commands()[name]) if not line.startswith("#")]
    assert calls
    for call in calls:
        words = shlex.split(call.partition(" > ")[0])
        assert words[0] == "scenecc", call
        command = commands()[words[1]]
        unknown = command.make_context(words[1], words[2:], resilient_parsing=True, ignore_unknown_options=True).args
        assert not [word for word in unknown if word.startswith("-")], call
