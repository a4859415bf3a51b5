"""Names of the links and joints of a robot that was not built: of its file, or of a tree of links in a scene."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from scenecc.source.document import WrittenNode


class RobotParts(NamedTuple):
    """Names of links, and of joints that move."""

    links: list[str]
    joints: list[str]


_ELEMENT: Final = re.compile(r"<(link|body|joint)\b([^<>]*)")
"""An element of a URDF or MJCF that may be a link or joint, with its attributes."""

_NAME: Final = re.compile(r"\bname\s*=\s*(?:\"([^\"$]+)\"|'([^'$]+)')")
"""A name without a macro."""


def parts_of_file(text: str) -> RobotParts:
    """Returns the names in the text of a URDF or MJCF, which may be incomplete."""
    links: dict[str, None] = {}
    joints: dict[str, None] = {}
    for kind, attributes in _ELEMENT.findall(text):
        name = _NAME.search(attributes)
        if name is not None and 'type="fixed"' not in attributes:
            (joints if kind == "joint" else links)[name[1] or name[2]] = None
    return RobotParts([*links], [*joints])


def find_joint(line: str, name: str) -> tuple[int, int] | None:
    """Returns the columns of a joint's element in a line of a URDF or MJCF, up to its name; None if it has none."""
    found = re.search(rf"<joint\b[^<>]*\bname\s*=\s*[\"']{re.escape(name)}[\"']", line)
    return None if found is None else found.span()


def parts_of_tree(root: WrittenNode) -> RobotParts:
    """Returns the names in a `root` and its children."""
    links: list[str] = []
    joints: list[str] = []
    todo, seen = [root], set[int]()
    while todo:
        node = todo.pop()
        if id(node) in seen:  # an alias may lead to itself
            continue
        seen.add(id(node))
        entries = node.entries
        if "name" in entries and entries["name"].node.text:
            links.append(entries["name"].node.text)
        joint = entries["joint"].node.entries.get("name") if "joint" in entries else None
        if joint is not None and joint.node.text:
            joints.append(joint.node.text)
        todo += reversed(entries["children"].node.items if "children" in entries else ())
    return RobotParts(links, joints)
