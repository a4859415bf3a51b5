"""Poses of entities, frames, cameras and lights in the world: composed `relative_to` chains."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose
from scenecc.lower.poses import POSE, lower_pose, pose_item, pose_varies
from scenecc.lower.variation import FieldPlace, VariationLowerer
from scenecc.plan import Value, literal
from scenecc.plan.scene import MAX_COMPOSED_POSES, shared_pose_name
from scenecc.spec.pose import PoseMapping
from scenecc.variation.nodes import NODE_TYPES, Composed, Placed, Shared

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.spec.references import NameScopes
    from scenecc.variation.nodes import Node

_SHOWN = 20
"""How many members of a circle are named."""

_JOINED = 10
"""How many operations it takes to join what was read of two poses."""


@frozen
class FramePose:
    """The pose of an entity or a frame.

    Attributes:
        local: its own pose, in the frame of `parent`: seven numbers, or a node.
        variation: what was read of it; None where it is the same in every scene.
        parent: its reference frame; None: the world.
        world: its pose in the world, likewise.
        around: itself if it is in some scenes only, as entities and the frames of instances can be; of another frame
            the first such thing that it stands relative to.
        depth: how many poses are composed in `world`.
        read: the first of itself and all that it stands relative to of which something was read; None: there is none.
    """

    local: Pose7 | Node
    variation: VariationLowerer | None
    parent: str | None
    world: Pose7 | Node
    around: str | None
    depth: int
    read: str | None


@frozen
class Follower:
    """A light or a camera: it has a pose, and nothing is posed relative to it.

    Attributes:
        local: its own pose, as it is built: seven numbers, or a node.
        parent: the entity or frame in whose frame that is; None: the world.
        fields: of it.
    """

    local: Pose7 | Node
    parent: str | None
    fields: FieldLowerer


class FrameGraph:
    """World poses of what a document places, composed in float64.

    Names are those of `scenecc.spec.references.qualified_name`.

    Args:
        sections: name → section → what has a `pose` there; of cameras those that are mounted on nothing.
        fields_of: gives the field lowerer of an entity or a frame, by its name.
        names: what names of the document mean.
        origin: of its root.
        sink: takes the diagnostics.

    Attributes:
        unread: entities whose files are wrong, which was reported: what these make beside themselves is not known.
        followers: lights and cameras by name.
    """

    def __init__(
        self,
        sections: Mapping[str, Mapping[str, Any]],
        fields_of: Callable[[str], FieldLowerer],
        names: NameScopes,
        origin: Origin,
        sink: Sink,
    ) -> None:
        self._placed = {name: node for nodes in sections.values() for name, node in nodes.items()}
        self._sections = sections
        self._frames = sections.get("frames", {})
        self._fields_of = fields_of
        self._names = names
        self._origin = origin
        self.sink = self._sink = sink
        self._origins: dict[str, Origin] = {}
        self._standing: dict[str, FramePose] = {}
        self._fixed: set[str] = set()
        self.unread: set[str] = set()
        self.followers: dict[str, Follower] = {}

    def add(self, name: str, owner: Origin, node: Any) -> None:
        """Takes in what an entity makes beside itself: a robot of its file.

        Args:
            name: of what it makes.
            owner: the entity's node.
            node: has a `pose` as the models have it, relative to the entity.
        """
        self._placed[name] = node
        self._origins[name] = owner

    def world(self, name: str, owner: Origin, *, fixed: bool) -> Value:
        """The world pose of something as a value.

        Args:
            name: that it is known as.
            owner: its node.
            fixed: whether it stays as it is built.
        """
        pose = self._placed[name].pose
        apart = not self._is_placed(name) and (pose.__class__ is not PoseMapping or pose.relative_to is None)
        if apart and not self._names.scopes.get(name) and not pose_varies(pose):
            # Most poses are in the world frame, and few of these are asked for again.
            return literal(lower_pose(pose, owner, ("pose",), self._sink))
        frame_pose = self.frame_pose(name)
        fields = self._fields_of(name)
        variations = self._readings(name)
        if fixed:
            self.fix(name)
        if not variations:
            return literal(frame_pose.world)  # pyright: ignore[reportArgumentType] - nothing varies
        whole = VariationLowerer(fields, self.origin(name))
        for variation in variations:
            whole.join(variation)
        return fields.finish(frame_pose.world, whole, POSE, self.origin(name).child("pose"), reset=not fixed)

    def follow(
        self,
        key: str,
        relative_to: str | None,
        local: Any,
        variation: VariationLowerer,
        fields: FieldLowerer,
        origin: Origin,
    ) -> Value:
        """The world pose of a light or a camera as a value.

        Its own pose stays as built; its reference frame may be drawn again, and a reset follows it.

        Args:
            key: what it is known as, as `scenecc.spec.references.qualified_name` has it.
            relative_to: as written.
            local: seven numbers, or a node.
            variation: of them.
            fields: of it.
            origin: of the node that has the key `pose`.
        """
        fields.fix(variation)
        parent = self._known_parent(key, relative_to, origin)
        whole = VariationLowerer(fields, origin)
        whole.join(variation)
        world = local
        if parent is not None:
            outer = self.frame_pose(parent)
            if outer.around is not None:
                self._is_wherever(key, fields.scenes, outer.around, origin)
            world = _composed(outer.world, local)
            for other in self._readings(parent):
                whole.join(other)
            self.followers[key] = Follower(local, parent, fields)
        if world.__class__ not in NODE_TYPES:
            return literal(world)
        return fields.finish(world, whole, POSE, origin.child("pose"), reset=True)

    def fix(self, name: str) -> None:
        """Notes that an object stays where it is built, and with it its chain of reference frames."""
        at: str | None = name
        while at is not None and at not in self._fixed:
            self._fixed.add(at)
            at = self.frame_pose(at).parent

    def fields(self, name: str) -> FieldLowerer:
        """The field lowerer of an entity or a frame."""
        return self._fields_of(name)

    def is_still(self, name: str) -> bool:
        """Whether the pose that something has of its own stays as it is built, though what is around it need not."""
        return name in self._sections.get("cameras", {})

    def is_fixed(self, name: str) -> bool:
        """Whether something stays where it is built."""
        return name in self._fixed

    def frame_pose(self, name: str) -> FramePose:
        """The pose of an entity or a frame."""
        found = self._standing.get(name)
        if found is not None:
            return found
        chain = self._chain(name)
        for member in reversed(chain):
            if member not in self._standing:
                self._standing[member] = self._stand(member)
        return self._standing[name]

    def _is_placed(self, name: str) -> bool:
        return getattr(self._placed[name], "place", None) is not None

    def placed_root(self, name: str) -> str | None:
        """What is placed of an entity or a frame and its chain of reference frames; None: nothing is."""
        at: str | None = name
        while at is not None and not self._is_placed(at):
            at = self.frame_pose(at).parent
        return at

    def _readings(self, name: str) -> list[VariationLowerer]:
        """The variation of a pose and of its chain of reference frames."""
        variations: list[VariationLowerer] = []
        at = self.frame_pose(name).read
        while at is not None:
            frame_pose = self.frame_pose(at)
            assert frame_pose.variation is not None
            variations.append(frame_pose.variation)
            at = None if frame_pose.parent is None else self.frame_pose(frame_pose.parent).read
        # Of a long chain that varies each member joins what was read of all before it.
        self._fields_of(name).sampling.count_operations(_JOINED * len(variations), self.origin(name))
        return variations

    def _stand(self, name: str) -> FramePose:
        if self._is_placed(name):
            variation = VariationLowerer(self._fields_of(name), self.origin(name))
            variation.drawn = True
            return FramePose(Placed(name), variation, None, Placed(name), name, 1, name)
        parent = self._names.parent(name, self._relative_to(name))
        outer = self._standing.get(parent) if parent is not None else None
        pose, origin, variation = self._placed[name].pose, self.origin(name), None
        local: Any
        if pose_varies(pose):
            variation = VariationLowerer(self._fields_of(name), origin)
            local = pose_item(pose, FieldPlace(origin.child("pose"), "pose"), variation, self._sink)
        else:
            local = lower_pose(pose, origin, ("pose",), self._sink)
        around = outer.around if outer is not None else None
        if name not in self._frames or self._is_narrowed(name):
            # Another frame is wherever somebody stands relative to it, so it passes on whose scenes count.
            if around is not None:
                self._exists_wherever(name, around)
            around = name
        read = name if variation is not None else outer and outer.read
        if outer is None or parent is None:
            return FramePose(local, variation, None, local, around, 1, read)
        if outer.depth < MAX_COMPOSED_POSES:
            return FramePose(local, variation, parent, _composed(outer.world, local), around, outer.depth + 1, read)
        world = _composed(self._shared(parent, outer.world), local)
        return FramePose(local, variation, parent, world, around, 2, read)

    def _shared(self, name: str, world: Any) -> Any:
        """A pose by its name: of a chain that varies and has no end, the rest would nest in it without end."""
        if world.__class__ not in NODE_TYPES:
            return world
        draw = shared_pose_name(name)
        self._fields_of(name).sampling.draws[draw] = world
        return Shared(draw)

    def _is_narrowed(self, frame: str) -> bool:
        """Whether a frame belongs to an instance that is in some scenes only."""
        fields = self._fields_of(frame)
        return fields.scenes is not fields.sampling.all_scenes

    def _relative_to(self, name: str) -> str | None:
        pose = self._placed[name].pose
        return pose.relative_to if isinstance(pose, PoseMapping) else None

    def _chain(self, name: str) -> list[str]:
        """What is not placed yet, from the name outwards, and the first that is; cut where something was reported."""
        chain = {name: None}
        outermost = name
        while outermost not in self._standing and (parent := self._parent(outermost)) is not None:
            if parent in chain:
                members = list(chain)
                self._cycle(members[members.index(parent) :])
                break
            chain[parent] = None
            outermost = parent
        return list(chain)

    def _parent(self, name: str) -> str | None:
        if self._is_placed(name):
            return None
        written = self._relative_to(name)
        return self._known_parent(name, written, self.origin(name))

    def _known_parent(self, name: str, written: str | None, origin: Origin) -> str | None:
        parent = self._names.parent(name, written)
        if parent is None or parent in self._placed:
            return parent
        whole = parent.rpartition("/")[0]
        if whole in self.unread:
            return None
        hint = "no pose is relative to a link; a light or a camera is fastened to one by `mount`"
        if not self._is_one_robot(whole):
            hint = suggest_name(str(written), self._names.seen_by(name, self._placed), self._sink)
        self._sink.report(
            "SC303",
            f"there is no entity, frame or camera `{cut(str(written))}` that stands in the world",
            origin.child("pose", "relative_to"),
            hint=hint,
        )
        return None

    def _is_one_robot(self, name: str) -> bool:
        """Whether something is an articulation that makes nothing beside itself: names under its own are of links."""
        node = self._placed.get(name)
        return hasattr(node, "fix_root_link") and not any(other.startswith(f"{name}/") for other in self._placed)

    def _exists_wherever(self, name: str, parent: str) -> None:
        """Reports a scene that the one entity is in and the other is not."""
        self._is_wherever(name, self._fields_of(name).scenes, parent, self.origin(name))

    def _is_wherever(self, name: str, mine: tuple[int, ...], parent: str, origin: Origin) -> None:
        others = self._fields_of(parent).scenes
        if mine is others or not (missing := set(mine).difference(others)):
            return
        shown = name.rpartition(":")[2]
        self._sink.report(
            "SC311",
            f"`{parent}` is not in scene {min(missing)}, where `{shown}` stands relative to it",
            origin.child("pose", "relative_to"),
            related=[(f"where `{parent}` is", self.origin(parent).child("scene_idxs"), "value")],
        )

    def _cycle(self, members: list[str]) -> None:
        # One report for a cycle, at its first member in the file.
        rank = {name: i for i, name in enumerate(self._placed)}
        start = members.index(min(members, key=rank.__getitem__))
        ordered = members[start:] + members[:start]
        shown = [*ordered[:_SHOWN], "…"] if len(ordered) > _SHOWN else ordered
        self._sink.report(
            "SC304",
            "poses stand relative to one another in a circle: " + " → ".join([*map(cut, shown), cut(ordered[0])]),
            self.origin(ordered[0]).child("pose", "relative_to"),
            related=[
                ("and here", self.origin(name).child("pose", "relative_to"), "value") for name in ordered[1:_SHOWN]
            ],
        )

    def origin(self, name: str) -> Origin:
        """The node of an entity or a frame."""
        found = self._origins.get(name)
        if found is None:
            section = next(section for section, nodes in self._sections.items() if name in nodes)
            found = self._origins[name] = self._origin.child(section, name)
        return found


def _composed(outer: Any, inner: Any) -> Any:
    if isinstance(outer, tuple) and isinstance(inner, tuple):
        return compose(outer, inner)  # pyright: ignore[reportUnknownArgumentType]
    return inner if outer == IDENTITY_POSE else Composed(outer, inner)
