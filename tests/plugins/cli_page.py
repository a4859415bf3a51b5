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

## All commands

| option | meaning |
|---|---|
| `-h`, `--help` | Show the options of the command. |
| `-q`, `--quiet` | Print only results and diagnostics: no counts, times or progress. |
| `--format FORMAT` | The format of all output: see below. |
| `-o FILE` | The output, in the format that the suffix names; `-` is standard output. |
| `--scene` | One scene, by its index; where several are possible, `0:4`, `0,2` or `::2`. |

`--format` has one meaning in all commands. With `text`, results are printed on standard output, and diagnostics
beside a result on standard error. With `json`, standard output is one JSON document: the result and the list
`diagnostics`. After an error it has only `diagnostics`. The formats `github`, `gitlab`, `junit` and `sarif` hold
diagnostics only. Wrong options are reported as text, with status 2, because the format may not be known yet.

`scenecc --install-completion` lets bash, zsh and fish complete commands, options, scene files, codes, prefabs,
parameters, entities and cameras.

"""

EVERYWHERE = ("-q, --quiet", "-h, --help")
"""Options that the section on all commands describes."""


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
    for option, meaning in (*command.help_rows(context, "argument"), *command.help_rows(context, "option")):
        if option not in EVERYWHERE:
            yield f"| `{_cell(option)}` | {_cell(meaning)} |"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    sys.stdout.write(page())
