"""Python source laid out as formatters lay it out: on one line if it fits, else an item a line.

An item a line always ends in a comma, which is what makes formatters keep it so.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

WIDTH = 100
_STEP = 4


@dataclass(frozen=True, slots=True)
class Group:
    """Items in brackets. `head` ends in the opening one: `sapien.Pose(`, `[`."""

    head: str
    items: tuple[Node, ...]
    tail: str


Node = str | Group
"""A piece of source: text that is never broken, or a group."""


def call(function: str, *args: Node, **keywords: Node) -> Group:
    """A call of `function`."""
    return Group(f"{function}(", (*args, *(_keyword(name, node) for name, node in keywords.items())), ")")


def list_of(items: Sequence[Node]) -> Group:
    """A list literal."""
    return Group("[", tuple(items), "]")


def string(text: str) -> str:
    """A string literal, in double quotes unless that takes more escapes."""
    # With both quotes in front, repr escapes every ' and no ".
    body = repr("'\"" + text)[4:-1]
    if text.count('"') > text.count("'"):
        return f"'{body}'"
    body = body.replace("\\'", "'").replace('"', '\\"')
    return f'"{body}"'


class Source:
    """Lines of a script, written from top to bottom."""

    def __init__(self, *, depth: int = 0) -> None:
        self._lines: list[str] = []
        self._indent = depth * _STEP

    @property
    def depth(self) -> int:
        """How many blocks the next line is in."""
        return self._indent // _STEP

    @property
    def text(self) -> str:
        """What was written, with a final line break."""
        return "\n".join(self._lines) + "\n"

    def line(self, text: str = "") -> None:
        """A line as it is; an empty one is never the first of a block."""
        self._lines.append(" " * self._indent + text if text else "")

    def gap(self) -> None:
        """An empty line, but not as the first of a block."""
        if self._lines and not self._lines[-1].endswith(":"):
            self._lines.append("")

    @property
    def is_empty(self) -> bool:
        """Whether nothing was written yet."""
        return not self._lines

    def append(self, other: Source) -> None:
        """The lines of another one, which began at its own depth."""
        self._lines.extend(other._lines)

    def lines(self, text: str) -> None:
        """Several lines as they are."""
        self._lines.extend(text.splitlines())

    def comment(self, text: str) -> None:
        """A comment of one line, whatever is in `text`."""
        shown = text if text.isprintable() else repr(text)[1:-1]
        self.line(f"# {shown}".rstrip())

    def statement(self, node: Node, *, assign: str = "") -> None:
        """An expression, assigned to `assign` if that is given."""
        head = f"{assign} = " if assign else ""
        self._lines.extend(_lines(_prefixed(head, node), self._indent, 0))

    @contextmanager
    def block(self, header: str) -> Generator[None]:
        """Lines inside belong to `header`."""
        self.line(header)
        self._indent += _STEP
        yield
        self._indent -= _STEP


def _keyword(name: str, node: Node) -> Node:
    return _prefixed(f"{name}=", node)


def _prefixed(prefix: str, node: Node) -> Node:
    return replace(node, head=prefix + node.head) if isinstance(node, Group) else prefix + node


def _flat(node: Node) -> str:
    if isinstance(node, str):
        return node
    return node.head + ", ".join(map(_flat, node.items)) + node.tail


def _lines(node: Node, indent: int, after: int) -> list[str]:
    """The lines of a node. `after`: how many characters follow its last one."""
    flat = _flat(node)
    margin = " " * indent
    if isinstance(node, str) or not node.items or indent + len(flat) + after <= WIDTH:
        return [margin + flat]
    lines = [margin + node.head]
    for item in node.items:
        lines.extend(_lines(item, indent + _STEP, 1))
        lines[-1] += ","
    return [*lines, margin + node.tail]
