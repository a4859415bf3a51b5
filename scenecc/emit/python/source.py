"""Formats Python source: on one line if it fits, else one item per line. Provides unique identifiers.

A group with one item per line always ends in a comma, so that formatters keep it.
"""

from __future__ import annotations

import builtins
import keyword
import math
import re
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

from scenecc.names import UniqueNames

WIDTH = 100

_INDENT_WIDTH = 4


@dataclass(frozen=True, slots=True)
class Group:
    """Items in brackets. `head` ends in the opening bracket: `sapien.Pose(`, `[`."""

    head: str
    items: tuple[SourceNode, ...]
    tail: str


SourceNode = str | Group
"""A piece of source: text that is never broken, or a group."""


def call(function: str, *args: SourceNode, **keywords: SourceNode) -> Group:
    """Returns a call of `function`."""
    return Group(f"{function}(", (*args, *(_add_prefix(f"{name}=", node) for name, node in keywords.items())), ")")


def list_of(items: Sequence[SourceNode]) -> Group:
    """Returns a list literal."""
    return Group("[", tuple(items), "]")


def string(text: str) -> str:
    """Returns a string literal, in double quotes unless that needs more escapes."""
    # With both quotes in front, repr escapes every ' but no ".
    body = repr("'\"" + text)[4:-1]
    if text.count('"') > text.count("'"):
        return f"'{body}'"
    body = body.replace("\\'", "'").replace('"', '\\"')
    return f'"{body}"'


class SourceWriter:
    """Lines of a script, written from top to bottom."""

    def __init__(self, *, depth: int = 0) -> None:
        self._lines: list[str] = []
        self._indent = depth * _INDENT_WIDTH

    @property
    def depth(self) -> int:
        """Number of blocks around the next line."""
        return self._indent // _INDENT_WIDTH

    @property
    def text(self) -> str:
        """Returns what was written, with a final line break."""
        return "\n".join(self._lines) + "\n"

    def line(self, text: str = "") -> None:
        """Writes a line as it is. An empty line is dropped at the start of a block."""
        self._lines.append(" " * self._indent + text if text else "")

    def gap(self) -> None:
        """Writes an empty line, except at the start of a block."""
        if self._lines and not self._lines[-1].endswith(":"):
            self._lines.append("")

    @property
    def is_empty(self) -> bool:
        """Returns whether nothing was written yet."""
        return not self._lines

    def append(self, other: SourceWriter) -> None:
        """Appends the lines of another writer, which has its own depth."""
        self._lines.extend(other._lines)

    def lines(self, text: str) -> None:
        """Writes several lines as they are."""
        self._lines.extend(text.splitlines())

    def comment(self, text: str) -> None:
        """Writes a comment of one line, whatever `text` contains."""
        shown = text if text.isprintable() else repr(text)[1:-1]
        self.line(f"# {shown}".rstrip())

    def statement(self, node: SourceNode, *, assign: SourceNode = "") -> None:
        """Writes an expression, assigned to `assign` if given."""
        head = f"{_format_flat(assign)} = " if assign else ""
        lines = _format_lines(_add_prefix(head, node), self._indent, 0)
        if isinstance(assign, Group) and len(lines[0]) > WIDTH:
            *lines, _ = _format_lines(assign, self._indent, WIDTH)
            first, *rest = _format_lines(_add_prefix(f"{assign.tail} = ", node), self._indent, 0)
            lines = [*lines, first, *rest]
        self._lines.extend(lines)

    @contextmanager
    def block(self, header: str) -> Generator[None]:
        """Opens a block below `header`."""
        self.line(header)
        self._indent += _INDENT_WIDTH
        yield
        self._indent -= _INDENT_WIDTH


def _add_prefix(prefix: str, node: SourceNode) -> SourceNode:
    return replace(node, head=prefix + node.head) if isinstance(node, Group) else prefix + node


def _format_flat(node: SourceNode) -> str:
    if isinstance(node, str):
        return node
    return node.head + ", ".join(map(_format_flat, node.items)) + node.tail


def _format_lines(node: SourceNode, indent: int, after: int) -> list[str]:
    """Returns the lines of a node. `after`: number of characters after its last one."""
    flat = _format_flat(node)
    margin = " " * indent
    if isinstance(node, str) or not node.items or indent + len(flat) + after <= WIDTH:
        return [margin + flat]
    lines = [margin + node.head]
    for item in node.items:
        lines.extend(_format_lines(item, indent + _INDENT_WIDTH, 1))
        lines[-1] += ","
    return [*lines, margin + node.tail]


_RESERVED = {
    "FILES", "HERE", "Iterator", "Path", "articulation", "asset_file", "atexit", "base64", "body", "build_scenes",
    "builder", "coacd", "collada_mesh", "component", "config", "constraint", "contextmanager", "convex_parts",
    "default_material", "entities", "entity", "file", "functools", "held", "i", "importlib", "io", "joint", "k",
    "links", "look", "main", "mirrored", "name", "np", "os", "package_file", "packed_file", "parts", "physics_settings",
    "physx", "ply_file", "re", "render", "sapien", "scene", "scenes", "shape", "shutil", "systems", "tempfile",
    "trimesh", "zlib",
}  # fmt: skip
"""Names that a script itself may use."""


class Identifiers:
    """Provides identifiers that clash neither with each other nor with names that a script uses."""

    def __init__(self) -> None:
        self._names = UniqueNames(*_RESERVED, *keyword.kwlist, *keyword.softkwlist, *dir(builtins))
        self._local: dict[str, str] = {}

    def take(self, wanted: str) -> str:
        """Returns a unique identifier like `wanted`: invalid characters become `_`, and duplicates get a number."""
        stem = re.sub(r"[^A-Za-z0-9_]+", "_", wanted[:60]).strip("_") or "unnamed"
        if stem[0].isdigit() or len(stem) == 1:  # a single l, O or I looks like a digit
            stem = f"the_{stem}"
        return self._names.new(stem)

    def local(self, wanted: str) -> str:
        """Returns an identifier for a variable that each block assigns again: the same for the same text."""
        if wanted not in self._local:
            self._local[wanted] = self.take(wanted)
        return self._local[wanted]


def number_literal(item: float) -> str:
    """Returns the shortest literal of a float64 (a short whole number without its point), integer or flag.

    Infinity, which limits may be, has no literal.
    """
    if isinstance(item, float) and math.isinf(item):
        return f'float("{item}")'
    if isinstance(item, float) and item.is_integer() and abs(item) < 1e6 and str(item) != "-0.0":
        return str(int(item))
    return repr(item).replace("e+", "e")
