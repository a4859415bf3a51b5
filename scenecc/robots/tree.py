"""Links and joints of a URDF as trees, in the order in which SAPIEN's loader builds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.robots.findings import Findings
    from scenecc.robots.joints import JointRow
    from scenecc.robots.xml import Element

_LISTED = 5


@frozen
class Branch:
    """A tree of links, the root first, each after its parent.

    Attributes:
        links: their names.
        joints: the joint of each to its parent; of the root None, or the floating joint that it hangs on.
    """

    links: tuple[str, ...]
    joints: tuple[JointRow | None, ...]


def grow(links: dict[str, Element], rows: Sequence[JointRow], findings: Findings) -> tuple[Branch, ...] | None:
    """The trees of a file: the one of the root, then one for each floating joint.

    Args:
        links: by name, in the order of the file.
        rows: joints of different names, in the order of the file.
        findings: where it is told what makes it no tree: joints of links that do not exist (SC461), links with two
            parents (SC462), no root or several (SC463), floating joints elsewhere than at the root (SC464).
    """
    wrong = [row for row in rows if not _ends_exist(row, links, findings)]
    if wrong:
        return None
    above: dict[str, JointRow] = {}
    children: dict[str, list[JointRow]] = {name: [] for name in links}
    is_tree = True
    for row in rows:
        first = above.setdefault(row.child, row)
        if first is not row:
            is_tree = False
            _two_parents(row, first, findings)
            continue
        children[row.parent].append(row)
    roots = [name for name in links if name not in above]
    if not is_tree or not _has_one_root(roots, links, above, findings):
        return None
    floating = [row for row in rows if row.kind == "floating"]
    for row in floating:
        if row.parent != roots[0]:
            is_tree = False
            findings.report(
                "SC464",
                f"the floating joint `{cut(row.name)}` hangs on `{cut(row.parent)}`, which is not the root",
                row.element.at("type"),
                hint=f"let it hang on the root `{cut(roots[0])}`: what it carries is then a robot of its own",
            )
    if not is_tree:
        return None
    return (_branch(roots[0], None, children), *(_branch(row.child, row, children) for row in floating))


def _ends_exist(row: JointRow, links: dict[str, Element], findings: Findings) -> bool:
    is_good = True
    for tag, name in (("parent", row.parent), ("child", row.child)):
        end = row.element.find(tag)
        if name in links or end is None:
            continue
        is_good = False
        findings.report(
            "SC461",
            f"the joint `{cut(row.name)}` has the {tag} `{cut(name)}`, and there is no such link",
            end.at("link"),
            hint=findings.near(name, links),
        )
    if is_good and row.parent == row.child:
        findings.report(
            "SC461", f"the joint `{cut(row.name)}` leads from `{cut(row.child)}` to itself", row.element.location
        )
        return False
    return is_good


def _two_parents(row: JointRow, first: JointRow, findings: Findings) -> None:
    findings.report(
        "SC462",
        f"the link `{cut(row.child)}` is the child of two joints, `{cut(first.name)}` and `{cut(row.name)}`",
        row.element.location,
        hint="a link has one parent; a loop is closed by a constraint of the scene",
        related=[("the first is here", first.element.location, "value")],
    )


def _has_one_root(roots: list[str], links: dict[str, Element], above: dict[str, JointRow], findings: Findings) -> bool:
    if len(roots) > 1:
        shown = ", ".join(f"`{cut(name)}`" for name in roots[:_LISTED])
        more = f" and {len(roots) - _LISTED} more" if len(roots) > _LISTED else ""
        findings.report(
            "SC463",
            f"{len(roots)} links are children of no joint, and a robot has one root: {shown}{more}",
            links[roots[1]].location,
            hint="connect them with joints, a fixed one or, at the root, a floating one; or part them into files",
            related=[("the first is here", links[roots[0]].location, "value")],
        )
    circle = _circle(links, above)
    if circle:
        shown = " → ".join(f"`{cut(name)}`" for name in [*circle[:_LISTED], *(["…"] if len(circle) > _LISTED else [])])
        findings.report(
            "SC463",
            f"links hang on one another in a circle: {shown} → `{cut(circle[0])}`",
            above[circle[0]].element.location,
            hint="a loop is closed by a constraint of the scene",
        )
    return len(roots) == 1 and not circle


def _circle(links: Iterable[str], above: dict[str, JointRow]) -> list[str]:
    """Links that hang on one another in a circle, from parent to child; none where there is none."""
    settled: set[str] = set()
    for start in links:
        path: dict[str, None] = {}
        name = start
        while name in above and name not in settled and name not in path:
            path[name] = None
            name = above[name].parent
        if name in path:
            names = list(path)
            circle = names[names.index(name) :][::-1]
            first = circle.index(start) if start in circle else 0
            return circle[first:] + circle[:first]
        settled.update(path)
    return []


def _branch(root: str, floating: JointRow | None, children: dict[str, list[JointRow]]) -> Branch:
    """Depth first, the children of a link in the order of the file."""
    links: list[str] = []
    joints: list[JointRow | None] = []
    stack: list[tuple[str, JointRow | None]] = [(root, floating)]
    while stack:
        name, row = stack.pop()
        links.append(name)
        joints.append(row)
        stack.extend((below.child, below) for below in reversed(children[name]) if below.kind != "floating")
    return Branch(tuple(links), tuple(joints))
