"""Makes the recipes of values that a reset redraws, and finds constraints whose frames do not follow."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from operator import is_, is_not
from typing import TYPE_CHECKING, Any, TypeVar

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.variation import ResettableValue, built_limit_items, drawn_limit_items, reset_node
from scenecc.plan import BodyStructure, Value
from scenecc.plan.articulation import ArticulationStructure, Link
from scenecc.plan.constraint import Constraint, Drive
from scenecc.plan.display import to_tuples
from scenecc.plan.placement import TRIED_FIELDS
from scenecc.plan.properties import Quantity
from scenecc.plan.rendering import Camera, Light
from scenecc.plan.scene import MAX_COMPOSED_POSES, is_unnamed_draw, placing_draw_name, shared_pose_name
from scenecc.plan.schema import plan_fields
from scenecc.variation.nodes import NODES, Composed, Const, Node, Rows, Shared

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.sampling import SamplingContext
    from scenecc.lower.variation import Variation
    from scenecc.plan import Entity, Placement
    from scenecc.plan.body import Mount
    from scenecc.plan.expect import Expectation

_Holder = TypeVar("_Holder")
_Follower = TypeVar("_Follower", Light, Camera)

_PARTS: dict[type, tuple[str, ...]] = {
    ArticulationStructure: ("links",),
    Link: ("body", "joint"),
    BodyStructure: ("inertial",),
    Constraint: ("joint",),
    Drive: ("drives",),
    Light: (),
    Camera: ("lens",),
}
"""Fields of plan objects whose own fields hold values that a reset may change."""


@cache
def _value_fields(holder: type) -> tuple[str, ...]:
    """The fields of a dataclass that a reset may redraw, without its pose, which reference frames can move."""
    fields = [one for one in plan_fields(holder) if one.name != "pose"]
    return tuple(one.name for one in fields if isinstance(one.kind, Quantity) and one.kind.reset)


def fixed_draws(sampling: SamplingContext) -> frozenset[str]:
    """The shared draws that are fixed after the build: those with a fixed reader, and their dependencies."""
    found: set[str] = set()
    todo = list(sampling.fixed)
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += sampling.reads.get(name, ())
    return frozenset(found)


def _is_redrawn(variation: Variation, sampling: SamplingContext, kept: frozenset[str]) -> bool:
    """Whether a reset changes a value. `kept`: the shared draws that are fixed after the build."""
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
        self._redrawn: dict[int, Value] = {}
        self._built_poses: dict[tuple[str, tuple[int, ...]], Rows] = {}
        self._poses: dict[str, dict[tuple[int, ...], str]] = {}
        self._shared_poses: list[tuple[str, Node]] = []

    def keep_draws(self, expectations: Iterable[Expectation]) -> None:
        """Adds the shared draws that expectations read."""
        for one in expectations:
            self._read.update(
                draw for reading in getattr(one, "readings", ()) if reading.kind == "draw" for draw in reading.of
            )

    def entity(self, entity: Entity) -> Entity:
        """Adds the recipes of an entity's pose and structures."""
        structures = tuple(map(self.holder, entity.structures))
        pose = entity.pose
        if not pose.known and not self._frames.is_fixed(entity.name):
            fields = self._frames.fields(entity.name)
            read: set[str] = set()
            node = self._pose(entity.name, fields, read)
            if node is not None:
                self._read |= read
                pose = pose.with_recipe(node, entity.scene_idxs)
        if pose is entity.pose and all(map(is_, structures, entity.structures)):
            return entity
        return replace(entity, pose=pose, structures=structures)

    def holder(self, node: _Holder) -> _Holder:
        """Adds the recipes of the values of a plan object, and of its parts, that a reset changes."""
        if not self._sampling.resets or node is None:
            return node
        changed: dict[str, Any] = {}
        for field in _value_fields(type(node)):
            value: Value | None = getattr(node, field)
            made = value and self._add_recipe(value)
            if made is not value:
                changed[field] = made
        for field in _PARTS.get(type(node), ()):
            part = getattr(node, field)
            parts = part if part.__class__ is tuple else (part,)
            made_parts = tuple(map(self.holder, parts))
            if any(map(is_not, made_parts, parts)):
                changed[field] = made_parts if part.__class__ is tuple else made_parts[0]
        return replace(node, **changed) if changed else node  # pyright: ignore[reportArgumentType, reportUnknownVariableType, reportReturnType]

    def placement(self, placement: Placement) -> Placement:
        """Adds the recipes of the values that are redrawn for every try of a placement."""
        chosen = (placing_draw_name(placement.name, path) for path in ("place.region", "place.height"))
        self._read |= {name for name in chosen if name in self._sampling.draws}
        given = [(name, value) for name in TRIED_FIELDS if (value := getattr(placement, name)) is not None]
        drawn = {name: self._add_recipe(value) for name, value in given}
        if placement.frame is not None:
            drawn["frame"] = self._follower_pose(f"placements:{placement.name}", placement.frame)
        return replace(placement, **drawn) if drawn else placement  # pyright: ignore[reportArgumentType]

    def follower(self, key: str, item: _Follower) -> _Follower:
        """Adds the pose recipe of a light or a camera: its own pose, in a reference frame that may also move.

        Args:
            key: its name among frames.
            item: the object, with its pose as built.
        """
        made, pose = self.holder(item), self._follower_pose(key, item.pose)
        return made if pose is item.pose else replace(made, pose=pose)

    def _follower_pose(self, key: str, pose: Value) -> Value:
        follower = self._frames.followers.get(key)
        if follower is None:
            return self._add_recipe(pose)
        if pose.known:
            return pose
        read: set[str] = set()
        fields, local, own = follower.fields, follower.local, self._is_redrawn_here(follower.variation)
        outer: Any = None if follower.parent is None else self._pose(follower.parent, fields, read)
        if outer is None and not own:
            return pose
        if own:
            read |= follower.variation.reads
        elif local.__class__ in NODES:
            local = _pose_rows(local, fields)  # pyright: ignore[reportArgumentType]
        self._read |= read
        if outer is None:
            outer = IDENTITY_POSE if follower.parent is None else self._built_pose(follower.parent, fields)
        node: Any = local if outer == IDENTITY_POSE else Composed(outer, local)
        return pose.with_recipe(node, fields.scenes)

    def draws(self) -> tuple[tuple[str, Node], ...]:
        """The shared draws of the file and those that the recipes read, in order. Fixed ones are rows.

        The poses that recipes continue from come last.
        """
        needed: set[str] = set()
        stored = self._fixed & self._sampling.random
        todo = [*self._read, *(name for name in self._sampling.draws if not is_unnamed_draw(name))]
        while todo:
            name = todo.pop()
            if name not in needed:
                needed.add(name)
                todo += () if name in stored else self._sampling.reads.get(name, ())
        draws = [
            (name, self._rows_of(name) if name in stored else node)
            for name, node in self._sampling.draws.items()
            if name in needed
        ]
        return (*draws, *self._shared_poses)

    def _add_recipe(self, value: Value) -> Value:
        """A value with its recipe; unchanged if a reset does not change it.

        An initial joint position and its drive target share a value, so they share its recipe.
        """
        reset = self._sampling.resets.get(id(value))
        if reset is None or not self._is_changed(reset):
            return value
        found = self._redrawn.get(id(value))
        if found is None:
            node = self._reset_node(reset)
            found = self._redrawn[id(value)] = value.with_recipe(node, reset.scenes)
        return found

    def _is_redrawn_here(self, variation: Variation) -> bool:
        return _is_redrawn(variation, self._sampling, self._fixed)

    def _is_changed(self, reset: ResettableValue) -> bool:
        """Whether a reset changes a value: it, its limits or the position that it follows is redrawn."""
        limits = None if reset.limits is None else self._sampling.resets.get(id(reset.limits))
        return (
            self._is_redrawn_here(reset.variation)
            or (limits is not None and self._is_changed(limits))
            or (reset.follows is not None and self._is_changed(reset.follows.source))
        )

    def _reset_node(self, reset: ResettableValue) -> Node:
        """The recipe of a value. Records the draws that it reads."""
        source: ResettableValue | None = reset
        while source is not None:
            self._read |= source.variation.reads
            source = source.follows and source.follows.source
        return reset_node(reset, self._limit_items)

    def _limit_items(self, limits: Value, scenes: tuple[int, ...]) -> Iterator[Any]:
        """The lower and the upper limit as items of a recipe."""
        reset = self._sampling.resets.get(id(limits))
        if reset is None or not self._is_changed(reset):
            return built_limit_items(limits, scenes)
        return drawn_limit_items(self._reset_node(reset))

    def _pose(self, name: str, fields: FieldLowerer, read: set[str]) -> Any:
        """An entity's world pose as an item of a recipe, or None if a reset keeps it. `read`: receives its draws."""
        chain = list(_moving_ancestors(name, self._frames))
        at = self._frames.frame_pose(chain[-1]).parent if chain else name
        variations = [variation for one in chain if (variation := self._frames.frame_pose(one).variation) is not None]
        if not any(map(self._is_redrawn_here, variations)):
            return None
        read.update(*(variation.reads for variation in variations))
        item = IDENTITY_POSE if at is None else self._built_pose(at, fields)
        depth = 0
        for member in reversed(chain):
            if depth == MAX_COMPOSED_POSES and at is not None:
                item, depth = self._share_pose(at, item, fields), 0
            local: Any = self._frames.frame_pose(member).local
            item = local if item == IDENTITY_POSE else Composed(item, local)
            at, depth = member, depth + 1
        return item

    def _share_pose(self, name: str, item: Any, fields: FieldLowerer) -> Shared:
        """The pose of a frame at the end of a long chain, as a shared draw."""
        poses = self._poses.setdefault(name, {})
        if fields.scenes not in poses:
            # A fixed draw consists of rows, for exactly these scenes.
            poses[fields.scenes] = draw = shared_pose_name(name, len(poses))
            self._shared_poses.append((draw, item if item.__class__ in NODES else Const(item)))
        return Shared(poses[fields.scenes])

    def _built_pose(self, name: str, fields: FieldLowerer) -> Any:
        world = self._frames.frame_pose(name).world
        if world.__class__ not in NODES:
            return world
        key = (name, fields.scenes)
        if key not in self._built_poses:
            self._built_poses[key] = _pose_rows(world, fields)  # pyright: ignore[reportArgumentType]
        return self._built_poses[key]

    def _rows_of(self, name: str) -> Rows:
        """The rows of a drawn shared draw, in all scenes in which it has a value."""
        from scenecc.variation.evaluation import rows_with_value  # noqa: PLC0415 - loaded where something varies

        found = dict(rows_with_value(name, self._sampling.batch(self._sampling.scenes_of[name])))
        return Rows(tuple(found), to_tuples([*found.values()]))


def _pose_rows(pose: Node, fields: FieldLowerer) -> Rows:
    """The rows of a pose as built."""
    return Rows(fields.scenes, tuple(map(tuple, fields.evaluate(pose).tolist())))


def check_constraint_resets(constraints: tuple[Constraint, ...], sampling: SamplingContext, frames: FrameGraph) -> None:
    """Warns of each constraint without its own frame if a reset moves one of its bodies.

    A common reference frame moves both bodies equally and gives no warning.

    Args:
        constraints: those without `pose_in_parent`.
        sampling: of the fully lowered document.
        frames: poses of the entities.
    """
    kept = fixed_draws(sampling)

    for constraint in constraints:
        ends = [mount for mount in (constraint.child, constraint.parent) if mount is not None]
        chains = [list(_moving_ancestors(_frame_of(mount, frames), frames)) for mount in ends]
        # Reference frames of only one body.
        own = set(chains[0]).symmetric_difference(chains[1] if len(chains) > 1 else ())
        variations = [variation for name in own if (variation := frames.frame_pose(name).variation) is not None]
        if constraint.origin is not None and any(_is_redrawn(variation, sampling, kept) for variation in variations):
            sampling.sink.report(
                "SC343",
                f"`{cut(constraint.name)}` keeps its pose as built, but a reset redraws where its bodies start",
                constraint.origin,
                at="key",
                hint="write `pose_in_parent`, or make one body `relative_to` the other",
            )


def _moving_ancestors(name: str, frames: FrameGraph) -> Iterator[str]:
    """An entity and its chain of reference frames, up to the first that is fixed after the build."""
    at: str | None = name
    while at is not None and not frames.is_fixed(at):
        yield at
        at = frames.frame_pose(at).parent


def _frame_of(mount: Mount, frames: FrameGraph) -> str:
    """The name of a body or a link among frames."""
    return mount.entity if mount.link is None else frames.link(mount.entity, mount.link)
