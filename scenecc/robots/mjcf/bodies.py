"""Bodies of an MJCF: trees of links, and bodies that stand still.

As ManiSkill's loader has it, a body of the world with a joint in it is an articulation: a root link without shapes,
named `dummy_root_N`, the body hanging on it, and of a body with several joints a link without shapes for each but the
last.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.robots.description import (
    DescribedCollision,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
)
from scenecc.robots.mjcf.attributes import ORIENTATIONS, own_attributes
from scenecc.robots.mjcf.classes import IGNORED_CLASS, Scope
from scenecc.robots.mjcf.rotations import rotation
from scenecc.robots.pose32 import IDENTITY, compose, pose_numbers

if TYPE_CHECKING:
    from scenecc.robots.description import PoseNumbers
    from scenecc.robots.mjcf.geoms import Geoms
    from scenecc.robots.mjcf.joints import Joints
    from scenecc.robots.mjcf.report import Report
    from scenecc.robots.xml import Element

_READ = frozenset({"name", "childclass", "pos", *ORIENTATIONS})
_MAKERS = ("frame", "replicate", "attach", "composite", "flexcomp", "flex")
_FREE = frozenset({"name", "group", "align"})


@dataclass(slots=True)
class Draft:
    """A link while it is made. `several`: whether other links stand between it and the one that its body is in."""

    name: str
    element: Element
    parent: int | None
    joint: DescribedJoint | None
    visuals: list[DescribedVisual] = field(default_factory=list[DescribedVisual])
    collisions: list[DescribedCollision] = field(default_factory=list[DescribedCollision])
    ignore_bits: int = 0


@dataclass(frozen=True, slots=True)
class Bond:
    """Two links of bodies of which one is in the other, and which do not collide. `apart`: other links are between."""

    first: Draft
    second: Draft
    apart: bool


@dataclass(slots=True)
class Bodies:
    """Makes robots of the bodies of a file.

    Attributes:
        geoms, joints: make what bodies hold.
        report: where faults go.
        bonds: pairs of links that do not collide, in the order in which ManiSkill's loader meets them.
    """

    geoms: Geoms
    joints: Joints
    report: Report
    bonds: list[Bond] = field(default_factory=list[Bond])
    _names: dict[tuple[str, str], Element] = field(default_factory=dict[tuple[str, str], "Element"])
    _count: int = 0

    def articulation(self, body: Element, number: int) -> tuple[list[Draft], bool]:
        """The links of a body of the world that has joints, and whether its root is fixed to the world.

        `number`: of the body among those of the world.
        """
        free = _free_joint(body)
        root = Draft(f"dummy_root_{number}", body, None, None)
        self.once("body", root.name, body)
        links = [root]
        around, pose = Scope(), IDENTITY
        if _is_wrapping(body):
            self._look_over(body, free)
            pose = self._pose(body)
            if pose != IDENTITY:
                what = "a body around another one turns and moves it; ManiSkill's loader leaves it where it is"
                self.report.differs("wrapper", what, body.location)
            around = self._scope(body, around) or around
            body = next(body.all("body"))
            inner = _free_joint(body)
            if inner is not None:
                self.report.error("SC483", "only a body of the world may be free", inner.location)
        self._links(body, 0, around, pose, links)
        return links, free is None

    def standing(self, body: Element) -> Draft | None:
        """A body of the world without joints, with all that is in it; None: it has no shapes."""
        made = Draft(self._name(body), body, None, None)
        geoms = self._stand(body, made, Scope(), IDENTITY)
        if not geoms:
            what = "a body without geoms is not built"
            self.report.not_built("empty body", what, body.location)
        return made if made.visuals or made.collisions else None

    def pose(self, body: Element) -> PoseNumbers:
        """Where a body of the world stands."""
        pose = self._pose(body)
        if pose != IDENTITY:
            what = "a body that stands still stands where it says; ManiSkill's loader puts it at the origin"
            self.report.differs("static pose", what, body.location)
        return pose

    def _links(self, body: Element, parent: int, scope: Scope, around: PoseNumbers, links: list[Draft]) -> None:
        """Adds the links of a body and of those in it. `around`: pose of what the body's pose is in, in the parent."""
        inner = self._scope(body, scope)
        if inner is None:
            return
        name = self._name(body)
        own = self._pose(body)
        pose = own if around == IDENTITY else compose(around, own)
        free = _free_joint(body)
        if free is not None and parent > 0:
            self.report.error("SC483", "only a body of the world may be free", free.location)
        self._look_over(body, free)
        joints = [child for child in body.children if child.tag in {"joint", "freejoint"} and child is not free]
        if free is not None and joints:
            self.report.error("SC483", "a free body can have no other joints", joints[0].location)
            joints = []
        if free is not None:
            self._once_named("joint", free)
        last = parent
        for i, joint in enumerate(joints or [None]):
            in_parent = pose if i == 0 else IDENTITY
            if joint is None:
                made = self.joints.fixed(body, inner, in_parent)
            else:
                made = self.joints.make(joint, inner, in_parent)
            if joint is not None and made.name:
                self.once("joint", made.name, joint)
            links.append(Draft(f"{name}_dummy_{i}", body, last, made))
            last = len(links) - 1
            if i + 1 < len(joints):
                self.once("body", links[last].name, body)
        links[last].name = name
        self._fill(body, links[last], inner, IDENTITY)
        self.bonds.append(Bond(links[parent], links[last], apart=len(joints) > 1))
        for child in body.all("body"):
            self._links(child, last, inner, IDENTITY, links)

    def _stand(self, body: Element, made: Draft, scope: Scope, pose: PoseNumbers) -> int:
        """Adds the shapes of a body and of those in it to a body that stands still; how many geoms there were."""
        inner = self._scope(body, scope)
        if inner is None:
            return 0
        self._look_over(body, None)
        if (free := body.find("freejoint")) is not None:
            self.report.error("SC483", "only a body of the world may be free", free.location)
        geoms = self._fill(body, made, inner, pose)
        children = list(body.all("body"))
        if len(children) > 1:
            what = "all bodies in one that stands still are built; ManiSkill's loader builds the first of them"
            self.report.differs("static bodies", what, children[1].location)
        for child in children:
            self._name(child)
            own = self._pose(child)
            if own != IDENTITY:
                what = (
                    "a body in one that stands still is moved and turned as it says; ManiSkill's loader leaves that out"
                )
                self.report.differs("static child", what, child.location)
            geoms += self._stand(child, made, inner, own if pose == IDENTITY else compose(pose, own))
        return geoms

    def _fill(self, body: Element, made: Draft, scope: Scope, pose: PoseNumbers) -> int:
        """Adds the shapes of a body's own geoms, which are in a frame of some pose; how many geoms there are."""
        geoms = list(body.all("geom"))
        for geom in geoms:
            visuals, collisions = self.make(geom, scope, pose)
            made.visuals += visuals
            made.collisions += collisions
        return len(geoms)

    def make(
        self, geom: Element, scope: Scope, pose: PoseNumbers
    ) -> tuple[list[DescribedVisual], list[DescribedCollision]]:
        """What is seen of a geom, and what of it collides."""
        self._once_named("geom", geom)
        return self.geoms.make(geom, scope, pose)

    def _scope(self, body: Element, scope: Scope) -> Scope | None:
        """The classes of what is in a body; None, told: the body is not built."""
        name = body.attributes.get("childclass")
        if name is None:
            return scope
        if name.startswith(IGNORED_CLASS):
            what = (
                f"bodies whose `childclass` begins with `{IGNORED_CLASS}` are not built, as ManiSkill's loader has it"
            )
            self.report.not_built("motor bodies", what, body.at("childclass"))
            return None
        known = self.joints.classes.known(name, body, "childclass")
        return Scope((*scope.names, name)) if known else scope

    def _pose(self, body: Element) -> PoseNumbers:
        given = own_attributes(body, self.report)
        p = given.singles("pos", (0.0, 0.0, 0.0))
        return pose_numbers((p[0], p[1], p[2]), rotation(given, self.joints.compiler))

    def _look_over(self, body: Element, free: Element | None) -> None:
        """Tells what in a body is not built."""
        self.report.unread_attributes(body, _READ)
        for child in body.children:
            if child is free:
                self.report.unread_attributes(child, _FREE | {"type"})
            else:
                self.look_over(child)

    def _name(self, body: Element) -> str:
        """A body's name, which is no other's; of one without a name its number among all."""
        self._count += 1
        name = body.attributes.get("name") or f"body_{self._count}"
        self.once("body", name, body)
        return name

    def once(self, tag: str, name: str, element: Element) -> None:
        """Reports a name that another one of its kind has, be it one that is made up for want of one."""
        first = self._names.setdefault((tag, name), element)
        if first is not element:
            self.report.error("SC486", f"there are two of `<{tag}>` named `{cut(name)}`", element.at("name"))

    def _once_named(self, tag: str, element: Element) -> None:
        if element.attributes.get("name"):
            self.once(tag, element.attributes["name"], element)

    def look_over(self, child: Element) -> None:
        """Tells of an element in a body or the world that nothing is made of."""
        if child.tag in _MAKERS:
            self.report.error(
                "SC483",
                f"`<{child.tag}>`, of which MuJoCo makes bodies or shapes, is not read",
                child.location,
                "let MuJoCo write the model out: it then holds the bodies themselves",
            )
        elif child.tag not in {"body", "geom", "joint", "freejoint"}:
            self._once_named(child.tag, child)
            self.report.unread_element(child)


def has_joint(body: Element) -> bool:
    """Whether a body of the world is an articulation."""
    return body.find("freejoint") is not None or any(_joints(body))


def _joints(body: Element) -> Iterator[Element]:
    pending = [body]
    while pending:
        one = pending.pop()
        yield from one.all("joint")
        pending.extend(one.all("body"))


def _free_joint(body: Element) -> Element | None:
    """What makes a body free: a `freejoint`, or a joint of that type."""
    free = (joint for joint in body.all("joint") if joint.attributes.get("type") == "free")
    return body.find("freejoint") or next(free, None)


def _is_wrapping(body: Element) -> bool:
    """Whether a body is nothing but another one, for whose sake it is left out."""
    tags = [child.tag for child in body.children]
    joints = [joint for joint in body.all("joint") if joint.attributes.get("type") != "free"]
    return tags.count("body") == 1 and "geom" not in tags and not joints


def described(links: list[Draft], *, fixed: bool) -> DescribedRobot:
    """An articulation of links that are made."""
    return DescribedRobot(tuple(map(_link, links)), fixed=fixed, location=links[0].element.location)


def described_body(made: Draft, pose: PoseNumbers) -> DescribedRobot:
    """A body that stands still, in place of an articulation."""
    return DescribedRobot((_link(made),), "static", pose=pose, location=made.element.location)


def _link(made: Draft) -> DescribedLink:
    return DescribedLink(
        name=made.name,
        location=made.element.location,
        parent=made.parent,
        joint=made.joint,
        collisions=tuple(made.collisions),
        visuals=tuple(made.visuals),
        ignore_bits=made.ignore_bits,
    )
