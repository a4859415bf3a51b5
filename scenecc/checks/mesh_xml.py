"""XML of a mesh file as a tree: no document type, and so no entities; size, depth and counts are bounded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pyexpat import ExpatError, ParserCreate
from typing import TYPE_CHECKING

from scenecc.checks.mesh_data import AssetError

if TYPE_CHECKING:
    from scenecc.checks.mesh_text import Budget

DEPTH, ELEMENTS, EQUALS = 100, 100_000, 400_000
"""How many elements stand inside one another and in all, and signs `=` in the text, no fewer than the attributes."""

_PIECE = 2**20
_BREAK = "\0"
"""Stands in the text of an element where something else does. XML itself has no such character."""
_ELEMENT_BYTES = 1024
"""About what an element takes."""


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """An element: its name as written, its attributes, and the elements and pieces of text right inside."""

    tag: str
    attributes: dict[str, str]
    children: list[Node] = field(default_factory=list["Node"])
    characters: list[str] = field(default_factory=list[str])

    @property
    def text(self) -> str:
        """The text right inside, without blanks at its ends."""
        return "".join(self.characters).strip()

    def get(self, attribute: str) -> str:
        """An attribute; empty where there is none."""
        return self.attributes.get(attribute, "")

    def all(self, *path: str) -> Iterator[Node]:
        """The elements at a path of names from here, in order."""
        for child in self.children:
            if child.tag == path[0]:
                if len(path) == 1:
                    yield child
                else:
                    yield from child.all(*path[1:])

    def walk(self) -> Iterator[Node]:
        """This element and all inside it."""
        yield self
        for child in self.children:
            yield from child.walk()


def by_id(root: Node, library: str, tag: str) -> dict[str, Node]:
    """The elements of a library by their id.

    Raises:
        ValueError: two have the same.
    """
    found: dict[str, Node] = {}
    for node in root.all(library, tag):
        name = node.get("id")
        if name and found.setdefault(name, node) is not node:
            raise ValueError(f"two elements have the id `{name[:60]}`")
    return found


def parse_mesh_xml(data: bytes, budget: Budget) -> Node:
    """The root element.

    Raises:
        AssetError: SC412, it is no well-formed UTF-8 XML or has a document type; SC607, it is too large.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    if data.count(b"=") > EQUALS:
        raise AssetError("SC607", f"it has more than {EQUALS} attributes", "simplify the mesh")
    budget.take(len(data))
    root: list[Node] = []
    opened: list[Node] = []
    count = 0
    parser = ParserCreate("utf-8")
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        """Opens an element, among the children of the one that is open; AssetError (SC607) where there are too many."""
        nonlocal count
        count += 1
        if count > ELEMENTS or len(opened) >= DEPTH:
            most = f"{ELEMENTS} elements" if count > ELEMENTS else f"{DEPTH} elements inside one another"
            raise AssetError("SC607", f"it has more than {most}", "simplify the mesh")
        budget.take(_ELEMENT_BYTES)
        node = Node(tag, attributes)
        (opened[-1].children if opened else root).append(node)
        opened.append(node)

    def end(_tag: str) -> None:
        _check_text(opened.pop())

    def broken(*_: object) -> None:
        if opened:
            opened[-1].characters.append(_BREAK)

    def text(characters: str) -> None:
        opened[-1].characters.append(characters)

    def doctype(*_: object) -> None:
        raise ValueError("it has a document type, which may declare entities and name files")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CommentHandler = parser.ProcessingInstructionHandler = parser.StartCdataSectionHandler = broken
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = text, doctype
    try:
        for at in range(0, len(data) + 1, _PIECE):
            parser.Parse(data[at : at + _PIECE], at + _PIECE > len(data))
    except (ExpatError, ValueError) as error:
        raise AssetError("SC412", f"the XML cannot be read: {error}", "export the mesh again") from error
    return root[0]


def _check_text(node: Node) -> None:
    """Joins the text of an element, which is in one piece: of several the engine's reader takes the first."""
    pieces = "".join(node.characters).split(_BREAK)
    if sum(map(bool, map(str.strip, pieces))) > bool(not node.children):
        raise ValueError(f"the text of `{node.tag[:40]}` is broken by an element, a comment or a CDATA section")
    if len(pieces) > 1:
        node.characters[:] = ["".join(pieces)]
