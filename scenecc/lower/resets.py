"""Recipes of what a reset draws again, and constraints whose frames do not follow."""

from __future__ import annotations

from dataclasses import replace
from operator import is_, is_not
from typing import TYPE_CHECKING, Any, TypeVar

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import Value, varying
from scenecc.plan.articulation import JOINT_STATE_FIELDS, VELOCITY_FIELDS, ArticulationStructure
from scenecc.plan.constraint import Drive
from scenecc.plan.placement import TRIED_FIELDS
from scenecc.plan.properties import FLOAT32_MAX
from scenecc.plan.scene import MAX_COMPOSED_POSES, shared_pose_name
from scenecc.variation.nodes import NODES, AffineClamp, Composed, Const, Rows, Shared

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.lower.deferred_checks import ResettableValue
    from scenecc.lower.fields import FieldLowerer, SamplingContext
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.variation import VariationLowerer
    from scenecc.plan import BodyStructure, Constraint, Entity, Placement
    from scenecc.plan.articulation import Joint, Link
    from scenecc.plan.body import Mount
    from scenecc.variation.nodes import Node


_TARGETS = ("target", "linear_velocity_target", "angular_velocity_target")
_Holder = TypeVar("_Holder", "BodyStructure | ArticulationStructure", "Joint", "Drive", "Placement")


def fixed_draws(sampling: SamplingContext) -> frozenset[str]:
    """The shared draws that stay as they are built: those that a field reads which does, and what these read."""
    found: set[str] = set()
    todo = list(sampling.fixed)
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += sampling.reads.get(name, ())
    return frozenset(found)


def _is_drawn_again(variation: VariationLowerer, sampling: SamplingContext, kept: frozenset[str]) -> bool:
    """Whether a reset changes a value. `kept`: the shared draws that stay as they are built."""
    return variation.drawn or any(name in sampling.random and name not in kept for name in variation.reads)


class RecipeBuilder:
    """Makes the recipes of a document's entities.

    Args:
        sampling: of the document.
        frames: poses of its entities.
    """

    def __init__(self, sampling: SamplingContext, frames: FrameGraph) -> None:
        self._sampling = sampling
        self._frames = frames
        self._fixed = fixed_draws(sampling)
        self._read: set[str] = set()
        self._anew: dict[int, Value] = {}
        self._frozen: dict[tuple[str, tuple[int, ...]], Rows] = {}
        self._poses: dict[str, dict[tuple[int, ...], str]] = {}
        self._shared_poses: list[tuple[str, Node]] = []

    def entity(self, entity: Entity) -> Entity:
        """The entity with the recipes of its pose and velocities."""
        structures = tuple(map(self._structure, entity.structures))
        pose = entity.pose
        if not pose.known and not self._frames.is_fixed(entity.name):
            fields = self._frames.fields(entity.name)
            read: set[str] = set()
            node = self._pose(entity.name, fields, read)
            if node is not None:
                self._read |= read
                pose = _with_recipe(pose, node, len(entity.scene_idxs))
        if pose is entity.pose and all(map(is_, structures, entity.structures)):
            return entity
        return replace(entity, pose=pose, structures=structures)

    def constraint(self, constraint: Constraint) -> Constraint:
        """The constraint with the recipes of what its drives are driven to."""
        if not isinstance(constraint.joint, Drive):
            return constraint
        joint = self._with_recipes(constraint.joint, _TARGETS)
        return constraint if joint is constraint.joint else replace(constraint, joint=joint)

    def placement(self, placement: Placement) -> Placement:
        """The placement with the recipes of what is drawn anew for every try."""
        placement = self._with_recipes(placement, TRIED_FIELDS)
        if placement.frame is None:
            return placement
        return replace(placement, frame=self.follower(f"placements:{placement.name}", placement.frame))

    def follower(self, key: str, pose: Value) -> Value:
        """The pose of a light or a camera, with the recipe of its reference frame.

        Args:
            key: what it is known as.
            pose: in the world, as built.
        """
        follower = self._frames.followers.get(key)
        if pose.known or follower is None or follower.parent is None:
            return pose
        read: set[str] = set()
        fields = follower.fields
        outer = self._pose(follower.parent, fields, read)
        if outer is None:
            return pose
        self._read |= read
        local: Any = follower.local
        if local.__class__ in NODES:
            local = _pose_rows(local, fields)
        return _with_recipe(pose, Composed(outer, local), len(fields.scenes))

    def draws(self) -> tuple[tuple[str, Node], ...]:
        """The shared draws that the recipes read, in order; those that stay as they are built are their rows.

        The poses that they go on from come last.
        """
        needed: set[str] = set()
        todo = list(self._read)
        while todo:
            name = todo.pop()
            if name not in needed:
                needed.add(name)
                todo += () if name in self._fixed else self._sampling.reads.get(name, ())
        draws = [
            (name, self._rows_of(name) if name in self._fixed and name in self._sampling.random else node)
            for name, node in self._sampling.draws.items()
            if name in needed
        ]
        return (*draws, *self._shared_poses)

    def _structure(self, structure: BodyStructure | ArticulationStructure) -> BodyStructure | ArticulationStructure:
        made = self._with_recipes(structure, VELOCITY_FIELDS)
        if isinstance(made, ArticulationStructure):
            links = tuple(map(self._link, made.links))
            if any(map(is_not, links, made.links)):
                return replace(made, links=links)
        return made

    def _link(self, link: Link) -> Link:
        joint = link.joint and self._with_recipes(link.joint, JOINT_STATE_FIELDS)
        return link if joint is link.joint else replace(link, joint=joint)

    def _with_recipes(self, node: _Holder, names: tuple[str, ...]) -> _Holder:
        """What holds values that a reset may change, with the recipes of those that it does."""
        drawn: dict[str, Any] = {}
        for field in names:
            value: Value | None = getattr(node, field)
            reset = self._sampling.resets.get(id(value))
            if value is not None and reset is not None and self._is_drawn(reset.variation):
                drawn[field] = self._drawn_anew(value, reset)
        return replace(node, **drawn) if drawn else node

    def _drawn_anew(self, value: Value, reset: ResettableValue) -> Value:
        """A value with its recipe. Where joints start is what their drives hold: one value, and one with a recipe."""
        found = self._anew.get(id(value))
        if found is None:
            self._read |= reset.variation.reads
            found = self._anew[id(value)] = _with_recipe(value, _reset_node(reset), len(reset.fields.scenes))
        return found

    def _is_drawn(self, variation: VariationLowerer) -> bool:
        return _is_drawn_again(variation, self._sampling, self._fixed)

    def _pose(self, name: str, fields: FieldLowerer, read: set[str]) -> Any:
        """An entity's pose in the world as an item of a recipe; None where a reset does not change it.

        Args:
            name: of the entity.
            fields: of it.
            read: takes the shared draws that it reads.
        """
        chain = list(_moving_ancestors(name, self._frames))
        at = self._frames.frame_pose(chain[-1]).parent if chain else name
        drawn = [one for one in chain if not self._frames.is_still(one)]
        variations = [variation for one in drawn if (variation := self._frames.frame_pose(one).variation) is not None]
        if not any(map(self._is_drawn, variations)):
            return None
        read.update(*(variation.reads for variation in variations))
        item = IDENTITY_POSE if at is None else self._as_built(at, fields)
        depth = 0
        for member in reversed(chain):
            if depth == MAX_COMPOSED_POSES and at is not None:
                item, depth = self._shared(at, item, fields), 0
            local: Any = self._frames.frame_pose(member).local
            if local.__class__ in NODES and self._frames.is_still(member):
                local = _pose_rows(local, fields)
            item = local if item == IDENTITY_POSE else Composed(item, local)
            at, depth = member, depth + 1
        return item

    def _shared(self, name: str, item: Any, fields: FieldLowerer) -> Shared:
        """The pose of a frame at the end of a long chain, as a shared draw."""
        poses = self._poses.setdefault(name, {})
        if fields.scenes not in poses:
            # What stays as it is built is rows, in these scenes and no others.
            poses[fields.scenes] = draw = shared_pose_name(name, len(poses))
            self._shared_poses.append((draw, item if item.__class__ in NODES else Const(item)))
        return Shared(poses[fields.scenes])

    def _as_built(self, name: str, fields: FieldLowerer) -> Any:
        world = self._frames.frame_pose(name).world
        if world.__class__ not in NODES:
            return world
        key = (name, fields.scenes)
        if key not in self._frozen:
            self._frozen[key] = _pose_rows(world, fields)  # pyright: ignore[reportArgumentType]
        return self._frozen[key]

    def _rows_of(self, name: str) -> Rows:
        """A shared draw as drawn, in all scenes that it has a value in."""
        scenes = self._sampling.scenes_of[name]
        rows = self._sampling.fields(scenes).batch().shared(name).tolist()
        return Rows(scenes, tuple(tuple(row) if row.__class__ is list else row for row in rows))


def _pose_rows(pose: Node, fields: FieldLowerer) -> Rows:
    """A pose as it is built."""
    return Rows(fields.scenes, tuple(map(tuple, fields.evaluate(pose).tolist())))


def _reset_node(reset: ResettableValue) -> Node:
    """What draws a value anew, held within limits that stay as they are built."""
    node, scenes, follows = reset.node, reset.fields.scenes, reset.follows
    if follows is not None:
        factor, offset = (_constant_item(value.data, scenes) for value in (follows.multiplier, follows.offset))
        node = AffineClamp(_reset_node(follows.source), -1, -FLOAT32_MAX, FLOAT32_MAX, factor, offset)
    if reset.limits is not None and isinstance(node, AffineClamp):
        low, high = (_constant_item(side.clip(-FLOAT32_MAX, FLOAT32_MAX), scenes) for side in reset.limits.data.T)
        node = replace(node, low=low, high=high)
    return node


def _constant_item(rows: NDArray[Any], scenes: tuple[int, ...]) -> Any:
    """Numbers (1,) or (B,) that a reset does not change, as an item of a recipe."""
    return Rows(scenes, tuple(rows.tolist())) if len(rows) > 1 else rows.item()


def _with_recipe(value: Value, node: Node, rows: int) -> Value:
    def draw() -> NDArray[Any]:
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        return np.broadcast_to(value.data, (rows, *value.data.shape[1:]))

    return varying(draw, bounds=value.bounds, recipe=node, rows=rows)


def check_constraint_resets(
    constraints: tuple[Constraint, ...], built: tuple[Entity, ...], sampling: SamplingContext, frames: FrameGraph
) -> None:
    """A warning for each constraint without a frame of its own one of whose bodies starts elsewhere at a reset.

    A common reference frame moves both alike, and is no reason.

    Args:
        constraints: whose `pose_in_parent` was left out.
        built: the entities.
        sampling: of the document, all of which is lowered.
        frames: poses of the entities.
    """
    entities = {entity.name: entity for entity in built}
    kept = fixed_draws(sampling)

    for constraint in constraints:
        ends = [mount for mount in (constraint.child, constraint.parent) if mount is not None]
        chains = [list(_moving_ancestors(mount.entity, frames)) for mount in ends]
        # Reference frames of only one of the two.
        own = set(chains[0]).symmetric_difference(chains[1] if len(chains) > 1 else ())
        variations = [variation for name in own if (variation := frames.frame_pose(name).variation) is not None]
        variations += [
            variation for mount in ends for variation in _joint_variations(mount, entities[mount.entity], sampling)
        ]
        if constraint.origin is not None and any(
            _is_drawn_again(variation, sampling, kept) for variation in variations
        ):
            sampling.sink.report(
                "SC343",
                f"`{cut(constraint.name)}` stays where it is built, and a reset draws anew where its bodies start",
                constraint.origin,
                at="key",
                hint="write `pose_in_parent`, or let one body stand `relative_to` the other",
            )


def _moving_ancestors(name: str, frames: FrameGraph) -> Iterator[str]:
    """An entity and its chain of reference frames, up to the first that stays as built."""
    at: str | None = name
    while at is not None and not frames.is_fixed(at):
        yield at
        at = frames.frame_pose(at).parent


def _joint_variations(mount: Mount, entity: Entity, sampling: SamplingContext) -> Iterator[VariationLowerer]:
    """What was read of the positions of joints on the way to a link."""
    for structure in entity.structures:
        if not isinstance(structure, ArticulationStructure):
            continue
        numbers = {link.name: number for number, link in enumerate(structure.links)}
        at = numbers.get(mount.link or "")
        while at is not None:
            joint = structure.links[at].joint
            reset = None if joint is None else sampling.resets.get(id(joint.qpos))
            if reset is not None:
                yield reset.variation
            at = structure.links[at].parent
