"""A tree for people."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from scenecc.cli.table import plain
from scenecc.diagnostics.render import wants_color

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text
    from rich.tree import Tree

    from scenecc.api import Item

_ENDLESS: Final = 10**6
"""Characters of a line that nobody looks at on a terminal: a program takes each item as one line."""

_INLINE: Final = frozenset({"shapes", "links", "variants", "joint"})
"""Groups whose items stand right below what has them."""


def tree_text(item: Item) -> str:
    """A tree as standard output takes it: with colours and as wide as the terminal, where it is one."""
    console = terminal()
    with console.capture() as captured:
        console.print(tree(item))
    lines = captured.get().splitlines()
    return "".join(f"{line.rstrip()}\n" for line in lines)


def terminal() -> Console:
    """Standard output, on which nothing is guessed: no markup, no emoji, no numbers found in a text."""
    from rich.console import Console

    color = wants_color(sys.stdout)
    return Console(
        force_terminal=color,
        color_system="standard" if color else None,
        no_color=not color,
        highlight=False,
        markup=False,
        emoji=False,
        width=None if sys.stdout.isatty() else _ENDLESS,
    )


def tree(item: Item) -> Tree:
    """An item with all that is below it."""
    from rich.tree import Tree

    made = Tree(_line(item), guide_style="dim")
    _grow(made, item)
    return made


def _grow(branch: Tree, item: Item) -> None:
    for name, group in item.groups:
        if not isinstance(group, tuple):
            _grow(branch.add(_line(group, "" if group.name else name)), group)
            continue
        below = branch if name in _INLINE else branch.add(_head(name, len(group)))
        grown: list[Tree] = []
        for one in group:
            above = below if one.under is None else grown[one.under]
            grown.append(above.add(_line(one)))
            _grow(grown[-1], one)


def _head(name: str, count: int) -> Text:
    from rich.text import Text

    return Text.assemble((name, "bold"), (f" ({count})", "dim"))


def _line(item: Item, name: str = "") -> Text:
    """Name, type and facts. `name`: of an item that has none."""
    from rich.text import Text

    line = Text(overflow="fold")
    parts = [(plain(item.name or name), "bold"), (plain(item.type), "cyan")]
    for text, style in parts:
        if text:
            line.append(f"{'  ' * bool(line)}{text}", style)
    told = [fact for fact in item.facts if fact.words]
    for number, fact in enumerate(told):
        line.append("  " if number == 0 else " · ", "dim")
        line.append(f"{plain(fact.label)} " if fact.label else "", "dim")
        line.append(plain(fact.words))
    if item.hidden:
        line.append(f"  … {item.hidden} more below", "dim")
    return line
