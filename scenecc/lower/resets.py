"""Recipes of what a reset draws again, and constraints whose frames do not follow."""

from __future__ import annotations

from dataclasses import replace
from operator import is_, is_not
from typing import TYPE_CHECKING, Any, TypeVar

from scenecc.diagnostics.messages import cut
from scenecc.geometry.float32 import FLOAT32_MAX
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import Value, varying
from scenecc.plan.articulation import JOINT_STATE_FIELDS, VELOCITY_FIELDS, ArticulationStructure
from scenecc.plan.constraint import Drive
from scenecc.plan.scene import MAX_COMPOSED_POSES, shared_pose_name
from scenecc.variation.nodes import NODES, AffineClamp, Composed, Const, Rows, Shared

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.lower.deferred_checks import ResettableValue
    from scenecc.lower.fields import FieldLowerer, SamplingContext
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.variation import VariationLowerer
    from scenecc.plan import BodyStructure, Constraint, Entity
    from scenecc.plan.articulation import Joint, Link
    from scenecc.plan.body import Mount
    from scenecc.variation.nodes import Node


_TARGETS = ("target", "linear_velocity_target", "angular_velocity_target")
_Holder = TypeVar("_Holder", "BodyStructure | ArticulationStructure", "Joint", "Drive")


def fixed_draws(drawing: SamplingContext) -> frozenset[str]:
    """The shared draws that stay as they are built: those that a field reads which does, and what these read."""
    found: set[str] = set()
    todo = list(drawing.fixed)
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += drawing.reads.get(name, ())
    return frozenset(found)


def _is_drawn_again(reading: VariationLowerer, drawing: SamplingContext, kept: frozenset[str]) -> bool:
    """Whether a reset changes a value. `kept`: the shared draws that stay as they are built."""
    return reading.drawn or any(name in drawing.random and name not in kept for name in reading.reads)


class RecipeBuilder:
    """Makes the recipes of a document's entities.

    Args:
        drawing: of the document.
        places: where its entities stand.
    """

    def __init__(self, drawing: SamplingContext, places: FrameGraph) -> None:
        self._drawing = drawing
        self._places = places
        self._stays = fixed_draws(drawing)
        self._read: set[str] = set()
        self._anew: dict[int, Value] = {}
        self._frozen: dict[tuple[str, tuple[int, ...]], Rows] = {}
        self._poses: dict[str, dict[tuple[int, ...], str]] = {}
        self._shared_poses: list[tuple[str, Node]] = []

    def entity(self, entity: Entity) -> Entity:
        """The entity with the recipes of its pose and velocities."""
        structures = tuple(map(self._structure, entity.structures))
        pose = entity.pose
        if not pose.known and not self._places.is_fixed(entity.name):
            leaves = self._places.leaves(entity.name)
            read: set[str] = set()
            node = self._pose(entity.name, leaves, read)
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

    def follower(self, key: str, pose: Value) -> Value:
        """The pose of a light or a camera, with the recipe of what it stands relative to.

        Args:
            key: what it is known as.
            pose: in the world, as built.
        """
        follower = self._places.followers.get(key)
        if pose.known or follower is None or follower.parent is None:
            return pose
        read: set[str] = set()
        leaves = follower.leaves
        outer = self._pose(follower.parent, leaves, read)
        if outer is None:
            return pose
        self._read |= read
        local: Any = follower.local
        if local.__class__ in NODES:
            local = _pose_rows(local, leaves)
        return _with_recipe(pose, Composed(outer, local), len(leaves.scenes))

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
                todo += () if name in self._stays else self._drawing.reads.get(name, ())
        draws = [
            (name, self._rows_of(name) if name in self._stays and name in self._drawing.random else node)
            for name, node in self._drawing.draws.items()
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

    def _with_recipes(self, node: _Holder, fields: tuple[str, ...]) -> _Holder:
        """What holds values that a reset may change, with the recipes of those that it does."""
        drawn: dict[str, Any] = {}
        for field in fields:
            value: Value | None = getattr(node, field)
            reset = self._drawing.resets.get(id(value))
            if value is not None and reset is not None and self._is_drawn(reset.reading):
                drawn[field] = self._drawn_anew(value, reset)
        return replace(node, **drawn) if drawn else node

    def _drawn_anew(self, value: Value, reset: ResettableValue) -> Value:
        """A value with its recipe. Where joints start is what their drives hold: one value, and one with a recipe."""
        found = self._anew.get(id(value))
        if found is None:
            self._read |= reset.reading.reads
            found = self._anew[id(value)] = _with_recipe(value, _reset_node(reset), len(reset.leaves.scenes))
        return found

    def _is_drawn(self, reading: VariationLowerer) -> bool:
        return _is_drawn_again(reading, self._drawing, self._stays)

    def _pose(self, name: str, leaves: FieldLowerer, read: set[str]) -> Any:
        """An entity's pose in the world as an item of a recipe; None where a reset does not change it.

        Args:
            name: of the entity.
            leaves: of it.
            read: takes the shared draws that it reads.
        """
        chain = list(_moving_ancestors(name, self._places))
        at = self._places.standing(chain[-1]).parent if chain else name
        drawn = [one for one in chain if not self._places.is_still(one)]
        readings = [reading for one in drawn if (reading := self._places.standing(one).reading) is not None]
        if not any(map(self._is_drawn, readings)):
            return None
        read.update(*(reading.reads for reading in readings))
        item = IDENTITY_POSE if at is None else self._as_built(at, leaves)
        depth = 0
        for member in reversed(chain):
            if depth == MAX_COMPOSED_POSES and at is not None:
                item, depth = self._shared(at, item, leaves), 0
            local: Any = self._places.standing(member).local
            if local.__class__ in NODES and self._places.is_still(member):
                local = _pose_rows(local, leaves)
            item = local if item == IDENTITY_POSE else Composed(item, local)
            at, depth = member, depth + 1
        return item

    def _shared(self, name: str, item: Any, leaves: FieldLowerer) -> Shared:
        """The pose of what many stand relative to, one after the other, by its name."""
        poses = self._poses.setdefault(name, {})
        if leaves.scenes not in poses:
            # What stays as it is built is rows, in these scenes and no others.
            poses[leaves.scenes] = draw = shared_pose_name(name, len(poses))
            self._shared_poses.append((draw, item if item.__class__ in NODES else Const(item)))
        return Shared(poses[leaves.scenes])

    def _as_built(self, name: str, leaves: FieldLowerer) -> Any:
        world = self._places.standing(name).world
        if world.__class__ not in NODES:
            return world
        key = (name, leaves.scenes)
        if key not in self._frozen:
            self._frozen[key] = _pose_rows(world, leaves)  # pyright: ignore[reportArgumentType]
        return self._frozen[key]

    def _rows_of(self, name: str) -> Rows:
        """A shared draw as drawn, in all scenes that it has a value in."""
        scenes = self._drawing.scenes_of[name]
        rows = self._drawing.leaves(scenes).batch().shared(name).tolist()
        return Rows(scenes, tuple(tuple(row) if row.__class__ is list else row for row in rows))


def _pose_rows(pose: Node, leaves: FieldLowerer) -> Rows:
    """A pose as it is built."""
    return Rows(leaves.scenes, tuple(map(tuple, leaves.evaluate(pose).tolist())))


def _reset_node(reset: ResettableValue) -> Node:
    """What draws a value anew, held within limits that stay as they are built."""
    node, scenes, follows = reset.node, reset.leaves.scenes, reset.follows
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
    constraints: tuple[Constraint, ...], built: tuple[Entity, ...], drawing: SamplingContext, places: FrameGraph
) -> None:
    """A warning for each constraint without a frame of its own one of whose bodies starts elsewhere at a reset.

    What both of them stand relative to moves them alike, and is no reason.

    Args:
        constraints: whose `pose_in_parent` was left out.
        built: the entities.
        drawing: of the document, all of which is lowered.
        places: where the entities stand.
    """
    entities = {entity.name: entity for entity in built}
    kept = fixed_draws(drawing)

    for constraint in constraints:
        ends = [mount for mount in (constraint.child, constraint.parent) if mount is not None]
        chains = [list(_moving_ancestors(mount.entity, places)) for mount in ends]
        # What only one of the two stands relative to.
        own = set(chains[0]).symmetric_difference(chains[1] if len(chains) > 1 else ())
        readings = [reading for name in own if (reading := places.standing(name).reading) is not None]
        readings += [reading for mount in ends for reading in _joint_variations(mount, entities[mount.entity], drawing)]
        if constraint.origin is not None and any(_is_drawn_again(reading, drawing, kept) for reading in readings):
            drawing.sink.report(
                "SC343",
                f"`{cut(constraint.name)}` stays where it is built, and a reset draws anew where its bodies start",
                constraint.origin,
                at="key",
                hint="write `pose_in_parent`, or let one body stand `relative_to` the other",
            )


def _moving_ancestors(name: str, places: FrameGraph) -> Iterator[str]:
    """An entity and all that it stands relative to, up to what stays as it is built."""
    at: str | None = name
    while at is not None and not places.is_fixed(at):
        yield at
        at = places.standing(at).parent


def _joint_variations(mount: Mount, entity: Entity, drawing: SamplingContext) -> Iterator[VariationLowerer]:
    """What was read of the positions of joints on the way to a link."""
    for structure in entity.structures:
        if not isinstance(structure, ArticulationStructure):
            continue
        numbers = {link.name: number for number, link in enumerate(structure.links)}
        at = numbers.get(mount.link or "")
        while at is not None:
            joint = structure.links[at].joint
            reset = None if joint is None else drawing.resets.get(id(joint.qpos))
            if reset is not None:
                yield reset.reading
            at = structure.links[at].parent
