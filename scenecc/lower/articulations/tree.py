"""Trees of links, as the scene file writes them, to drafts."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.lower.articulations.draft import Draft, DraftJoint, DraftLink, DraftMimic, Touch
from scenecc.lower.articulations.written_limits import doubt_limits, limits_fit, limits_of
from scenecc.lower.forms import VARYING, Place, Reading, Step, place_of
from scenecc.lower.kinds import number, vector
from scenecc.lower.placing.pose_nodes import POSE, pose_item
from scenecc.lower.placing.poses import IDENTITY_POSE, direction, turned
from scenecc.lower.placing.rotations import IDENTITY, shortest_from_x
from scenecc.lower.placing.shape_poses import local_pose
from scenecc.plan import CollisionShape, Value, VisualShape, literal
from scenecc.spec.pose import AXES
from scenecc.variation.nodes import Composed, Pointing, Posed

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.shapes import Shapes
    from scenecc.plan.articulation import JointType
    from scenecc.spec.articulation_tree import TreeJoint, TreeLink

_JOINT_NUMBERS = ("friction", "damping", "armature")
_ONLY_MOVING = (*_JOINT_NUMBERS, "axis", "pose_in_child", "limits", "limits_deg", "mimic")
_OF_COLLIDING = ("density", "patch_radius", "min_patch_radius")
_DIRECTION = vector(3, "")
_NO_LIMITS = (-math.inf, math.inf)


class Trees:
    """Makes drafts of trees of links.

    Args:
        shapes: lowers their shapes.
        sink: takes the diagnostics.
    """

    def __init__(self, shapes: Shapes, sink: Sink) -> None:
        self._shapes = shapes
        self._sink = sink

    def draft(self, root: TreeLink, origin: Origin, leaves: Leaves) -> Draft:
        """A tree as a draft.

        Args:
            root: of it.
            origin: of the root.
            leaves: of the entity.
        """
        links: list[DraftLink] = []
        waiting: list[tuple[TreeLink, Origin, int | None]] = [(root, origin, None)]
        while waiting:
            link, place, parent = waiting.pop()
            number = len(links)
            links.append(self._link(link, place, parent, leaves))
            below = [(child, place.child("children", i), number) for i, child in enumerate(link.children)]
            waiting += reversed(below)
        return Draft(tuple(links), origin)

    def _link(self, link: TreeLink, origin: Origin, parent: int | None, leaves: Leaves) -> DraftLink:
        joint = None
        if parent is None and link.joint is not None:
            self._nothing("joint", "the root, which hangs on nothing: `fix_root_link` fixes it", origin)
        elif parent is not None and link.joint is None:
            self._sink.report("SC102", f"the link `{link.name}` lacks the key `joint`", origin, at="key")
        elif link.joint is not None:
            joint = self._joint(link.joint, origin.child("joint"), leaves)
        self._idle(link, origin)

        def shaping(touch: Touch) -> tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]:
            return self._shaped(link, touch, origin, leaves)

        return DraftLink(link.name, origin, shaping, parent, joint, own=(link, origin))

    def _idle(self, link: TreeLink, origin: Origin) -> None:
        """What a link says for shapes that it has not."""
        if link.shapes or link.collisions:
            return
        for key in _OF_COLLIDING if link.visuals else (*_OF_COLLIDING, "material"):
            if getattr(link, key) is not None:
                shape = "shape" if key == "material" else "colliding shape"
                self._nothing(key, f"a link without a {shape}", origin)

    def _shaped(
        self, link: TreeLink, touch: Touch, origin: Origin, leaves: Leaves
    ) -> tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]:
        collisions: list[CollisionShape | None] = []
        visuals: list[VisualShape | None] = []
        for i, shape in enumerate(link.shapes):
            collides, seen = self._shapes.both(shape, touch.default, leaves, origin.child("shapes", i))
            collisions.append(collides)
            visuals.append(seen)
        for i, shape in enumerate(link.collisions):
            collisions.append(self._shapes.collision(shape, touch.default, leaves, origin.child("collisions", i)))
        for i, shape in enumerate(link.visuals):
            visuals.append(self._shapes.visual(shape, touch.default, leaves, origin.child("visuals", i)))
        touching = tuple(_touched(shape, touch) for shape in collisions if shape is not None)
        return touching, tuple(shape for shape in visuals if shape is not None)

    def _joint(self, joint: TreeJoint, origin: Origin, leaves: Leaves) -> DraftJoint:
        given = joint.model_fields_set
        self._one_way(joint, origin)
        in_parent, in_child = self._poses(joint, origin, leaves)
        name = joint.name or ""
        if joint.type == "fixed":
            for key in _ONLY_MOVING:
                # Where a fixed joint's frame stands in the child says where the child stands.
                if key in given and key != "pose_in_child":
                    self._nothing(key, "a fixed joint", origin)
            return DraftJoint("fixed", name, origin, in_parent, in_child)
        type_: JointType = "revolute" if joint.type == "continuous" else joint.type
        numbers = {key: leaves.given(getattr(joint, key), number(key), origin, key) for key in _JOINT_NUMBERS}
        mimic = None
        if joint.mimic is not None:
            place = origin.child("mimic")
            if not name:
                message = "a joint that follows another lacks the key `name`"
                self._sink.report("SC102", message, origin, hint="it is known by its name, as the one that it follows")
            multiplier = leaves.given(joint.mimic.multiplier, number("multiplier"), place, "multiplier")
            offset = leaves.given(joint.mimic.offset, number("offset"), place, "offset")
            mimic = DraftMimic(joint.mimic.joint, multiplier or literal(1.0), offset or literal(0.0), place)
        limits = limits_of(joint, origin, leaves) or literal(_NO_LIMITS)
        doubt_limits(joint, joint.type, origin, self._sink)
        place = origin.child("limits" if joint.limits_deg is None else "limits_deg")
        return DraftJoint(type_, name, origin, in_parent, in_child, limits, place, **numbers, mimic=mimic)

    def _one_way(self, joint: TreeJoint, origin: Origin) -> None:
        """A joint is placed in URDF's way or in SAPIEN's, and its limits are written once."""
        given = joint.model_fields_set
        pairs = [(a, b) for a in ("origin", "axis") for b in ("pose_in_parent", "pose_in_child")]
        for first, second in pairs:
            if first in given and second in given:
                self._exclude(first, second, origin)
                return
        if joint.type == "continuous" and (wrong := next(iter(given & {"limits", "limits_deg"}), None)):
            message = f"a continuous joint has no `{wrong}`"
            self._sink.report("SC111", message, origin.child(wrong), at="key", hint="write type: revolute")
        limits_fit(joint, joint.type, origin, self._sink)

    def _poses(self, joint: TreeJoint, origin: Origin, leaves: Leaves) -> tuple[Value | None, Value | None]:
        """The joint's frame in the parent's and in the child's."""
        if joint.pose_in_parent is not None or joint.pose_in_child is not None:
            return (
                self._pose(joint.pose_in_parent, "pose_in_parent", origin, leaves),
                self._pose(joint.pose_in_child, "pose_in_child", origin, leaves),
            )
        if joint.axis.__class__ in VARYING:
            return self._turning(joint, origin, leaves)
        stands = self._pose(joint.origin, "origin", origin, leaves)
        turn = IDENTITY
        if joint.axis is not None:
            written: Any = joint.axis
            axis = direction(written)
            if not any(axis):
                self._sink.report("SC114", "an axis of length 0 has no direction", origin.child("axis"))
                return None, None
            turn = shortest_from_x(axis)
        if turn == IDENTITY:
            return stands, None
        return self._turned(stands, turn, joint, origin, leaves), literal((0.0, 0.0, 0.0, *turn))

    @staticmethod
    def _pose(pose: Any, key: str, origin: Origin, leaves: Leaves) -> Value | None:
        return None if pose is None else local_pose(pose, origin, (key,), "a joint", leaves)

    @staticmethod
    def _turned(stands: Value | None, turn: Any, joint: TreeJoint, origin: Origin, leaves: Leaves) -> Value:
        if stands is None:
            return literal((0.0, 0.0, 0.0, *turn))
        if stands.is_constant:
            x, y, z, a, b, c, d = stands.numbers()
            return literal(turned((x, y, z, a, b, c, d), turn, (0.0, 0.0, 0.0)))
        place = place_of(origin.child("origin"))
        reading = Reading(leaves, place.origin)
        item = Composed(pose_item(joint.origin, place, reading, leaves.sink), (0.0, 0.0, 0.0, *turn))
        return leaves.finish(item, reading, POSE, place.origin)

    def _turning(self, joint: TreeJoint, origin: Origin, leaves: Leaves) -> tuple[Value, Value]:
        """Of an axis that differs from scene to scene."""
        place = place_of(origin)
        reading = Reading(leaves, origin.child("axis"))

        def leaf(one: Any, around: Place, step: Step) -> Any:
            if one.__class__ is str:
                return AXES[one]
            return reading.item(one, _DIRECTION, around.inside(step) if step else around)

        axis = reading.select(joint.axis, place.key("axis"), leaf)
        turn = Posed((0.0, 0.0, 0.0), Pointing(axis))
        reading.risk(turn.q, origin.child("axis"))
        in_child = leaves.finish(turn, reading, POSE, origin.child("axis"))
        stands = IDENTITY_POSE
        if joint.origin is not None:
            stands = pose_item(joint.origin, place.key("origin"), reading, leaves.sink)
        return leaves.finish(Composed(stands, turn), reading, POSE, origin.child("origin")), in_child

    def _exclude(self, first: str, second: str, origin: Origin) -> None:
        self._sink.report(
            "SC111",
            f"`{first}` and `{second}` exclude each other",
            origin.child(second),
            at="key",
            related=[("the first", origin.child(first), "key")],
        )

    def _nothing(self, key: str, what: str, origin: Origin) -> None:
        self._sink.report(
            "SC115", f"`{key}` does nothing on {what}", origin.child(key), at="key", hint=f"leave `{key}` out"
        )


def _touched(shape: CollisionShape, touch: Touch) -> CollisionShape:
    """A shape with the radii of its link, where it has none itself."""
    radii = {
        name: radius
        for name in ("patch_radius", "min_patch_radius")
        if (radius := getattr(touch, name)) is not None and getattr(shape, name) is None
    }
    return replace(shape, **radii) if radii else shape
