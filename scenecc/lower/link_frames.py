"""Links as reference frames: the pose of a link in the frame of its entity, at the initial joint positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY, IDENTITY_POSE, compose, from_axis_angle
from scenecc.lower.forms import VariationLowerer
from scenecc.lower.local_poses import inverse_pose, seven_numbers
from scenecc.lower.value_checks import report_draw_failure
from scenecc.lower.variation import ResettableValue, built_limit_items, drawn_limit_items, reset_node
from scenecc.plan import BodyStructure
from scenecc.plan.link_poses import steps_across
from scenecc.plan.scene import MAX_COMPOSED_POSES, shared_pose_name
from scenecc.variation.nodes import NODE_TYPES, Composed, FromAxisAngle, Posed, Rows, Shared, Stacked, draws_read_by
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan import ArticulationStructure, Value
    from scenecc.plan.articulation import Joint, Link
    from scenecc.variation.nodes import Node


@frozen
class LinkFrame:
    """A link that an object is posed relative to. `entity`, `link`: the names."""

    entity: str
    link: str


def find_link(
    entity: str,
    structures: Sequence[BodyStructure | ArticulationStructure],
    link: str | None,
    place: Origin,
    sink: Sink,
    span: tuple[int, int] | None = None,
) -> str | None:
    """The name of a link that every structure of an articulation has; None after an error.

    Args:
        entity: the name of the articulation.
        structures: all its alternatives.
        link: as written; None: the root.
        place: of the name.
        sink: receives the diagnostic.
        span: the part of the text at `place`; None: all of it.
    """
    each = [[one.name for one in other.links] for other in structures if not isinstance(other, BodyStructure)]
    shared = set(each[0]).intersection(*each[1:])
    name = each[0][0] if link is None else link
    if name in shared:
        return name
    hint = suggest_name(name, [one for one in each[0] if one in shared], sink)
    message = f"no link of `{cut(entity)}` is called `{cut(name)}`"
    if len(structures) > 1:
        message = f"not every robot of `{cut(entity)}` has a link `{cut(name)}`"
    sink.report("SC331", message, place, hint=hint, span=span)
    return None


def fix_initial_positions(structures: Sequence[Any], sampling: SamplingContext) -> bool:
    """Fixes the initial positions of all joints after the build, and returns whether a reset would redraw any."""
    found = False
    for joint in (link.joint for structure in structures for link in structure.links if link.joint is not None):
        reset = sampling.resets.pop(id(joint.qpos), None)
        if reset is not None:
            found |= reset.variation.drawn or not reset.variation.reads & sampling.random <= sampling.fixed
            sampling.fix(reset.variation)
    return found


class LinkPoseLowerer:
    """Composes the pose of a link in the frame of its entity, in float64, from the root to the link.

    Each joint adds its frame in the parent link, its motion, and the inverse of its frame in the child link.

    Args:
        key: name of the link among frames.
        fields: of its entity.
        origin: of its entity.
    """

    def __init__(self, key: str, fields: FieldLowerer, origin: Origin) -> None:
        self._key = key
        self._fields = fields
        self._origin = origin
        self._shared = 0
        self.variation = VariationLowerer(fields, origin)

    def lower(self, structures: Sequence[Any], pick: Value | None, link: str) -> Any:
        """The pose of a link: seven numbers, or a node.

        Args:
            structures: of the entity, each of which has the link.
            pick: index of each scene's structure.
            link: its name.
        """
        try:
            poses = [self._pose(structure.links, link) for structure in structures]
            if pick is None or all(pose == poses[0] for pose in poses):
                return poses[0]
            which = self._rows(pick)
            return Rows(self._fields.scenes, tuple(poses[int(row)] for row in which))
        except DrawError as error:
            self.variation.broken = True
            report_draw_failure(error, self._origin, self._fields.sampling)
            return IDENTITY_POSE

    def _pose(self, links: Sequence[Link], name: str) -> Any:
        joints: list[Joint] = []
        at: int | None = next(number for number, one in enumerate(links) if one.name == name)
        while at is not None:
            joint = links[at].joint
            joints += () if joint is None else (joint,)
            at = links[at].parent
        pose: Any = IDENTITY_POSE
        depth = 0
        for joint in reversed(joints):
            if depth == MAX_COMPOSED_POSES:
                pose, depth = self._add_shared_draw(pose), 0
            pose = composed(pose, self._across(joint))
            depth += pose.__class__ is Composed
        return pose

    def _add_shared_draw(self, pose: Any) -> Shared:
        """Makes a shared draw of a pose in a long varying chain, which limits the nesting of the rest."""
        name = shared_pose_name(f"{self._key}.joints", self._shared)
        self._shared += 1
        sampling = self._fields.sampling
        reads = frozenset(draws_read_by(pose))
        sampling.add(name, pose, reads)
        sampling.scenes_of[name] = self._fields.scenes
        if self.variation.drawn or not sampling.random.isdisjoint(reads):
            sampling.random.add(name)
        self.variation.reads.add(name)
        return Shared(name)

    def _across(self, joint: Joint) -> Any:
        """The frame of the child link in that of the parent link."""
        pose: Any = IDENTITY_POSE
        for step in steps_across(joint, self._fields.scenes):
            if step.kind == "pose":
                pose = composed(pose, self._pose_item(step.value, back=step.back))
            else:
                pose = composed(pose, moved_along_x(self._position(step.value), slides=step.kind == "slide"))
        return pose

    def _pose_item(self, value: Value, *, back: bool) -> Any:
        if value.is_constant:
            pose = seven_numbers(value)
            return inverse_pose(pose) if back else pose
        rows = self._rows(value)
        return Rows(self._fields.scenes, tuple(inverse_pose(row) if back else row for row in rows))

    def _position(self, value: Value) -> Any:
        if value.is_constant:
            return value.numbers()[0]
        reset = self._fields.sampling.resets.get(id(value))
        if reset is None:
            return Rows(self._fields.scenes, tuple(self._rows(value)))
        return self._redrawn_item(reset)

    def _redrawn_item(self, reset: ResettableValue) -> Node:
        def limit_items(limits: Value, scenes: tuple[int, ...]) -> Iterator[Any]:
            drawn = self._fields.sampling.resets.get(id(limits))
            return built_limit_items(limits, scenes) if drawn is None else drawn_limit_items(self._redrawn_item(drawn))

        self.variation.join(reset.variation)
        return reset_node(reset, limit_items)

    def _rows(self, value: Value) -> list[Any]:
        """The items of a value that is fixed after the build, one per scene."""
        self.variation.seeded |= not value.known
        rows = value.data.tolist()
        return [tuple(row) if row.__class__ is list else row for row in rows]


def composed(outer: Any, inner: Any) -> Any:
    """Composes two items: seven numbers, or a node."""
    if isinstance(outer, tuple) and isinstance(inner, tuple):
        return compose(outer, inner)  # pyright: ignore[reportUnknownArgumentType]
    return inner if outer == IDENTITY_POSE else Composed(outer, inner)


def moved_along_x(position: Any, *, slides: bool) -> Any:
    """The pose of a rotation about x [rad], or of a translation along it [m], as an item."""
    if position.__class__ in NODE_TYPES:
        if slides:
            return Posed(Stacked((position, 0.0, 0.0)), IDENTITY)
        return Posed((0.0, 0.0, 0.0), FromAxisAngle((1.0, 0.0, 0.0), position))
    if slides:
        return (position, 0.0, 0.0, *IDENTITY)
    return (0.0, 0.0, 0.0, *from_axis_angle((1.0, 0.0, 0.0), position))
