"""The page on the command line: `python tests/plugins/cli_page.py > docs/reference/cli.md` writes it."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from typing import Any

from typer.main import get_command

from scenecc.cli.app import COMMANDS, application

HEAD = """\
# Command line

<!-- Generated from the help of the commands by `python tests/plugins/cli_page.py > docs/reference/cli.md`. -->

`scenecc COMMAND --help` prints the same. [Exit statuses](../how-to/integration.md#in-any-other-pipeline) are the same
for every command except `diff`.

"""


def commands() -> dict[str, Any]:
    """Each command by its name, as the parser knows it."""
    group: Any = get_command(application())
    return {name: group.commands[name] for name in COMMANDS}


def examples(command: Any) -> list[str]:
    """The lines below "Examples:" in its help."""
    _, _, listed = inspect.cleandoc(command.help).partition("Examples:\n")
    return [line.strip() for line in listed.splitlines()]


def page() -> str:
    """The whole page."""
    listed = [f"| [`{name}`](#{name}) | {_prose(command)[0]} |" for name, command in commands().items()]
    sections = [line for name, command in commands().items() for line in _section(name, command)]
    return "\n".join([HEAD + "| command | what it does |", "|---|---|", *listed, *sections, ""])


def _prose(command: Any) -> list[str]:
    """Its help without the examples: paragraphs, each a line."""
    text, _, _ = inspect.cleandoc(command.help).partition("Examples:\n")
    return [" ".join(part.split()) for part in text.replace("\b", "").split("\n\n") if part.strip()]


def _section(name: str, command: Any) -> Iterator[str]:
    context = command.context_class(command, info_name=f"scenecc {name}")
    usage = " ".join(command.collect_usage_pieces(context))
    yield from ("", f"## {name}", "", f"`scenecc {name} {usage}`")
    for paragraph in _prose(command):
        yield from ("", paragraph)
    yield from ("", "```console", *(f"$ {line}" if line[:1] != "#" else line for line in examples(command)), "```", "")
    yield from ("| argument or option | meaning |", "|---|---|")
    for param in command.get_params(context):
        record = param.get_help_record(context)
        if record and "--help" not in param.opts:
            yield f"| `{_cell(record[0])}` | {_cell(record[1])} |"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    sys.stdout.write(page())
