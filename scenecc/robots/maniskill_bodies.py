"""Bodies and joints of an MJCF: articulations and static bodies, as ManiSkill's loader builds them.

A body of the world that contains a joint is an articulation. Its root is a link without shapes, named
`dummy_root_N`. A body with several joints gets a link without shapes for each joint but the last.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.properties import round_to_float32
from scenecc.robots.description import (
    DescribedCollision,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
    SapienJointType,
)
from scenecc.robots.maniskill_attributes import IGNORED_CLASS, ORIENTATION_ATTRIBUTES, ClassScope, own_attributes
from scenecc.robots.poses import axis_pose, compose_poses, pose_numbers, read_rotation
from scenecc.robots.xml import warn_if_degrees

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7
    from scenecc.robots.maniskill_attributes import CompilerSettings, DefaultClasses, MjcfAttributes
    from scenecc.robots.maniskill_geoms import GeomReader
    from scenecc.robots.mjcf_files import MjcfReport
    from scenecc.robots.xml import SourceElement


JOINT_ATTRIBUTES = frozenset(
    {"name", "class", "type", "pos", "axis", "range", "limited", "ref", "damping", "frictionloss"}
)
"""The attributes that are read."""

_JOINT_TYPES = ("hinge", "slide", "fixed", "ball", "free")

_MIN_AXIS_LENGTH = 1e-3
"""Below this length ManiSkill's loader takes x for the axis."""


@dataclass(frozen=True, slots=True)
class JointReader:
    """Makes joints of the elements `joint` of a file."""

    classes: DefaultClasses
    compiler: CompilerSettings

    def make(self, element: SourceElement, scope: ClassScope, in_parent: Pose7) -> DescribedJoint:
        """The joint of an element. One that cannot be built is reported, and fixed.

        Args:
            element: a `joint`.
            scope: where it stands.
            in_parent: pose of the body in the link that the joint hangs on.
        """
        joint = self.classes.attributes(element, scope, JOINT_ATTRIBUTES)
        kind = joint.word("type", _JOINT_TYPES, "hinge")
        if kind in {"ball", "free"}:
            reason = "PhysX's articulations have none" if kind == "ball" else "only a body of the world may have one"
            self.classes.report.error("SC483", f"a joint of type `{kind}` cannot be built: {reason}", joint.at("type"))
            kind = "fixed"
        start = joint.number("ref", 0.0)
        if start and kind != "fixed":
            self.classes.report.left_out(
                "ref",
                "positions count from where the file puts the body, which is 0 and not `ref`",
                joint.at("ref"),
                "a position of MuJoCo's, less `ref`, is one of `qpos`; limits are taken so",
            )
        frame = _joint_frame(joint, kind)
        limits = _read_limits(joint, self.compiler, start) if kind != "fixed" else None
        words: dict[str, SapienJointType] = {"hinge": "revolute_unwrapped", "slide": "prismatic", "fixed": "fixed"}
        word = "revolute" if kind == "hinge" and limits is None else words[kind]
        return DescribedJoint(
            name=joint.text("name"),
            type=word,
            pose_in_parent=compose_poses(in_parent, frame),
            pose_in_child=frame,
            location=element.location,
            limits=limits or (None if kind == "fixed" else (-math.inf, math.inf)),
            friction=joint.number("frictionloss", 0.0, 0.0) if "frictionloss" in joint and kind != "fixed" else None,
            damping=0.0 if kind == "fixed" else joint.number("damping", 0.0, 0.0),
        )

    def fixed(self, body: SourceElement, scope: ClassScope, in_parent: Pose7) -> DescribedJoint:
        """The joint of a body that has none: its frame is its class's, as ManiSkill's loader has it."""
        joint = self.classes.inherited("joint", body, scope)
        frame = _joint_frame(joint, "fixed")
        return DescribedJoint("", "fixed", compose_poses(in_parent, frame), frame, body.location)


def _joint_frame(joint: MjcfAttributes, kind: str) -> Pose7:
    """A frame in the body whose x is the axis."""
    p = joint.singles("pos", (0.0, 0.0, 0.0))
    axis = _read_axis(joint, kind)
    return axis_pose((float(axis[0]), float(axis[1]), float(axis[2])), (p[0], p[1], p[2]))


def _read_axis(joint: MjcfAttributes, kind: str) -> NDArray[Any]:
    """The direction of a joint's axis, of length 1 but for rounding."""
    x = np.array([1.0, 0.0, 0.0])
    if "axis" not in joint:
        if kind == "fixed":
            return x
        what = "a joint without `axis` has that along z; ManiSkill's loader takes x"
        joint.report.differs("axis", what, joint.element.location)
    axis = np.array(joint.numbers("axis", (0.0, 0.0, 1.0)), np.float32)
    length = np.linalg.norm(axis)
    if length < _MIN_AXIS_LENGTH:
        if kind == "fixed":
            return x
        if not length > 0:
            joint.wrong("axis", "has no length")
            return x
        joint.report.differs("short axis", "ManiSkill's loader takes so short an `axis` for x", joint.at("axis"))
    if not length < math.inf:
        joint.wrong("axis", "is so long that single precision does not hold its length")
        return x
    return axis / length


def _read_limits(joint: MjcfAttributes, compiler: CompilerSettings, start: float) -> tuple[float, float] | None:
    """Lowest and highest position; None: no limits. In single precision, as degrees turn to radians in the loader.

    `start`: the position at the start, which is 0 in what is built.
    """
    limited = joint.word("limited", ("auto", "true", "false"), "auto")
    if limited == "false" or (limited == "auto" and "range" not in joint):
        return None
    if "range" not in joint:
        joint.report.error("SC481", "a joint that is limited has no `range`", joint.at("limited"))
        return None
    values = joint.numbers("range", (0.0, 0.0), infinite=True)
    if limited == "auto" and not compiler.limits_by_range:
        joint.wrong("range", "limits nothing without `limited`, since `autolimits` is false", 'write `limited="true"`')
        return None
    if limited == "auto" and not any(values):
        joint.report.differs(
            "range 0 0", "a `range` of 0 0 limits nothing; ManiSkill's loader locks the joint", joint.at("range")
        )
        return None
    if values[0] > values[1]:
        joint.wrong("range", f"leads from {values[0]:g} down to {values[1]:g}")
    if start:
        what = "limits are counted from `ref`; ManiSkill's loader leaves that out"
        joint.report.differs("ref", what, joint.at("range"))
    singles = np.array([value - start for value in values], np.float32)
    if joint.text("type", "hinge") == "hinge" and compiler.degrees:
        singles = np.deg2rad(singles)
    elif joint.text("type", "hinge") == "hinge":
        warn_if_degrees(values, "a limit", joint.at("range"), joint.report.of(joint.at("range")))
    return round_to_float32(singles[0]), round_to_float32(singles[1])


_BODY_ATTRIBUTES = frozenset({"name", "childclass", "pos", *ORIENTATION_ATTRIBUTES})

_UNSUPPORTED_GENERATORS = ("frame", "replicate", "attach", "composite", "flexcomp", "flex")

_FREEJOINT_ATTRIBUTES = frozenset({"name", "group", "align"})


@dataclass(slots=True)
class LinkDraft:
    """A link under construction."""

    name: str
    element: SourceElement
    parent: int | None
    joint: DescribedJoint | None
    visuals: list[DescribedVisual] = field(default_factory=list[DescribedVisual])
    collisions: list[DescribedCollision] = field(default_factory=list[DescribedCollision])
    ignore_bits: int = 0


@dataclass(frozen=True, slots=True)
class ExcludedPair:
    """A link and the link of its parent body, which do not collide. `apart`: other links are between them."""

    first: LinkDraft
    second: LinkDraft
    apart: bool


@dataclass(slots=True)
class BodyReader:
    """Makes robots of the bodies of a file.

    Attributes:
        geoms, joints: make what bodies hold.
        report: where faults go.
        bonds: pairs of links that do not collide, in the order in which ManiSkill's loader meets them.
    """

    geoms: GeomReader
    joints: JointReader
    report: MjcfReport
    bonds: list[ExcludedPair] = field(default_factory=list[ExcludedPair])
    _names: dict[tuple[str, str], SourceElement] = field(default_factory=dict[tuple[str, str], "SourceElement"])
    _count: int = 0

    def articulation(self, body: SourceElement, number: int) -> tuple[list[LinkDraft], bool]:
        """The links of a body of the world that has joints, and whether its root is fixed to the world.

        `number`: of the body among those of the world.
        """
        free = _find_free_joint(body)
        root = LinkDraft(f"dummy_root_{number}", body, None, None)
        self.check_unique("body", root.name, body)
        links = [root]
        around, pose = ClassScope(), IDENTITY_POSE
        if _is_wrapper(body):
            self._report_unread(body, free)
            pose = self._pose(body)
            if pose != IDENTITY_POSE:
                what = "a body around another one turns and moves it; ManiSkill's loader leaves it where it is"
                self.report.differs("wrapper", what, body.location)
            around = self._scope(body, around) or around
            body = next(body.all("body"))
            inner = _find_free_joint(body)
            if inner is not None:
                self.report.error("SC483", "only a body of the world may be free", inner.location)
        self._links(body, 0, around, pose, links)
        return links, free is None

    def static_body(self, body: SourceElement) -> LinkDraft | None:
        """A body of the world without joints, with its children; None if it has no shapes."""
        made = LinkDraft(self._name(body), body, None, None)
        geoms = self._add_static_shapes(body, made, ClassScope(), IDENTITY_POSE)
        if not geoms:
            what = "a body without geoms is not built"
            self.report.not_built("empty body", what, body.location)
        return made if made.visuals or made.collisions else None

    def pose(self, body: SourceElement) -> Pose7:
        """The pose of a static body of the world."""
        pose = self._pose(body)
        if pose != IDENTITY_POSE:
            what = "a body that stands still stands where it says; ManiSkill's loader puts it at the origin"
            self.report.differs("static pose", what, body.location)
        return pose

    def _links(
        self, body: SourceElement, parent: int, scope: ClassScope, around: Pose7, links: list[LinkDraft]
    ) -> None:
        """Adds the links of a body and of those in it. `around`: pose of what the body's pose is in, in the parent."""
        inner = self._scope(body, scope)
        if inner is None:
            return
        name = self._name(body)
        own = self._pose(body)
        pose = own if around == IDENTITY_POSE else compose_poses(around, own)
        free = _find_free_joint(body)
        if free is not None and parent > 0:
            self.report.error("SC483", "only a body of the world may be free", free.location)
        self._report_unread(body, free)
        joints = [child for child in body.children if child.tag in {"joint", "freejoint"} and child is not free]
        if free is not None and joints:
            self.report.error("SC483", "a free body can have no other joints", joints[0].location)
            joints = []
        if free is not None:
            self._check_unique_name("joint", free)
        last = parent
        for i, joint in enumerate(joints or [None]):
            in_parent = pose if i == 0 else IDENTITY_POSE
            if joint is None:
                made = self.joints.fixed(body, inner, in_parent)
            else:
                made = self.joints.make(joint, inner, in_parent)
            if joint is not None and made.name:
                self.check_unique("joint", made.name, joint)
            links.append(LinkDraft(f"{name}_dummy_{i}", body, last, made))
            last = len(links) - 1
            if i + 1 < len(joints):
                self.check_unique("body", links[last].name, body)
        links[last].name = name
        self._fill(body, links[last], inner, IDENTITY_POSE)
        self.bonds.append(ExcludedPair(links[parent], links[last], apart=len(joints) > 1))
        for child in body.all("body"):
            self._links(child, last, inner, IDENTITY_POSE, links)

    def _add_static_shapes(self, body: SourceElement, made: LinkDraft, scope: ClassScope, pose: Pose7) -> int:
        """Adds the shapes of a body and its children to a static body. Returns the number of geoms."""
        inner = self._scope(body, scope)
        if inner is None:
            return 0
        self._report_unread(body, None)
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
            if own != IDENTITY_POSE:
                what = (
                    "a body in one that stands still is moved and turned as it says; ManiSkill's loader leaves that out"
                )
                self.report.differs("static child", what, child.location)
            geoms += self._add_static_shapes(
                child, made, inner, own if pose == IDENTITY_POSE else compose_poses(pose, own)
            )
        return geoms

    def _fill(self, body: SourceElement, made: LinkDraft, scope: ClassScope, pose: Pose7) -> int:
        """Adds the shapes of a body's own geoms at a pose. Returns the number of geoms."""
        geoms = list(body.all("geom"))
        for geom in geoms:
            visuals, collisions = self.make(geom, scope, pose)
            made.visuals += visuals
            made.collisions += collisions
        return len(geoms)

    def make(
        self, geom: SourceElement, scope: ClassScope, pose: Pose7
    ) -> tuple[list[DescribedVisual], list[DescribedCollision]]:
        """The visual and the collision shapes of a geom."""
        self._check_unique_name("geom", geom)
        return self.geoms.make(geom, scope, pose)

    def _scope(self, body: SourceElement, scope: ClassScope) -> ClassScope | None:
        """The class scope inside a body; None if the body is not built, which is reported."""
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
        return ClassScope((*scope.names, name)) if known else scope

    def _pose(self, body: SourceElement) -> Pose7:
        given = own_attributes(body, self.report)
        p = given.singles("pos", (0.0, 0.0, 0.0))
        return pose_numbers((p[0], p[1], p[2]), read_rotation(given, self.joints.compiler))

    def _report_unread(self, body: SourceElement, free: SourceElement | None) -> None:
        """Reports what is not built of a body."""
        self.report.unread_attributes(body, _BODY_ATTRIBUTES)
        for child in body.children:
            if child is free:
                self.report.unread_attributes(child, _FREEJOINT_ATTRIBUTES | {"type"})
            else:
                self.report_unread(child)

    def _name(self, body: SourceElement) -> str:
        """A body's name, which must be unique; by default its number among all."""
        self._count += 1
        name = body.attributes.get("name") or f"body_{self._count}"
        self.check_unique("body", name, body)
        return name

    def check_unique(self, tag: str, name: str, element: SourceElement) -> None:
        """Reports a name that another element of its kind has, a generated name included."""
        first = self._names.setdefault((tag, name), element)
        if first is not element:
            self.report.error("SC486", f"there are two of `<{tag}>` named `{cut(name)}`", element.at("name"))

    def _check_unique_name(self, tag: str, element: SourceElement) -> None:
        if element.attributes.get("name"):
            self.check_unique(tag, element.attributes["name"], element)

    def report_unread(self, child: SourceElement) -> None:
        """Reports an element in a body or the world that is not built."""
        if child.tag in _UNSUPPORTED_GENERATORS:
            self.report.error(
                "SC483",
                f"`<{child.tag}>`, of which MuJoCo makes bodies or shapes, is not read",
                child.location,
                "let MuJoCo write the model out: it then holds the bodies themselves",
            )
        elif child.tag not in {"body", "geom", "joint", "freejoint"}:
            self._check_unique_name(child.tag, child)
            self.report.unread_element(child)


def has_joint(body: SourceElement) -> bool:
    """Whether a body of the world is an articulation."""
    return body.find("freejoint") is not None or any(_subtree_joints(body))


def _subtree_joints(body: SourceElement) -> Iterator[SourceElement]:
    pending = [body]
    while pending:
        one = pending.pop()
        yield from one.all("joint")
        pending.extend(one.all("body"))


def _find_free_joint(body: SourceElement) -> SourceElement | None:
    """The `freejoint` of a body, or its joint of type `free`."""
    free = (joint for joint in body.all("joint") if joint.attributes.get("type") == "free")
    return body.find("freejoint") or next(free, None)


def _is_wrapper(body: SourceElement) -> bool:
    """Whether a body only contains another body, and so is left out."""
    tags = [child.tag for child in body.children]
    joints = [joint for joint in body.all("joint") if joint.attributes.get("type") != "free"]
    return tags.count("body") == 1 and "geom" not in tags and not joints


def describe_articulation(links: list[LinkDraft], *, fixed: bool) -> DescribedRobot:
    """An articulation of finished links."""
    return DescribedRobot(tuple(map(_describe_link, links)), fixed=fixed, location=links[0].element.location)


def describe_static_body(made: LinkDraft, pose: Pose7) -> DescribedRobot:
    """A static body, in place of an articulation."""
    return DescribedRobot((_describe_link(made),), "static", pose=pose, location=made.element.location)


def _describe_link(made: LinkDraft) -> DescribedLink:
    return DescribedLink(
        name=made.name,
        location=made.element.location,
        parent=made.parent,
        joint=made.joint,
        collisions=tuple(made.collisions),
        visuals=tuple(made.visuals),
        ignore_bits=made.ignore_bits,
    )
