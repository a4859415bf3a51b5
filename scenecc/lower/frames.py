"""World poses of entities, frames, cameras and lights, composed along `relative_to` chains.

A link that something is posed relative to is a frame too: it is in its entity, at the initial joint positions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY, Pose7
from scenecc.lower.field_types import report_unused_key
from scenecc.lower.forms import FieldPlace, VariationLowerer
from scenecc.lower.link_frames import LinkFrame, LinkPoseLowerer, composed, find_link, fix_initial_positions
from scenecc.lower.poses import POSE, lower_pose, pose_item, pose_varies
from scenecc.lower.references import name_prefixes
from scenecc.lower.value_checks import report_draw_failure
from scenecc.plan import literal
from scenecc.plan.scene import MAX_COMPOSED_POSES, shared_pose_name
from scenecc.spec.pose import PoseMapping
from scenecc.variation.nodes import NODE_TYPES, Node, Placed, Rows, Shared
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.plan import ArticulationStructure, BodyStructure, Value
    from scenecc.spec.references import NameScopes

_SHOWN = 20
"""Most members of a cycle that are named."""

_JOINED = 10
"""Operations to merge the variations of two poses."""


@frozen
class FramePose:
    """The pose of an entity, a frame or a link.

    Attributes:
        local: its pose in the frame of `parent`: seven numbers, or a node.
        variation: of its pose; None if it is the same in every scene.
        parent: its reference frame; None: the world.
        world: its pose in the world: seven numbers, or a node.
        around: the nearest of itself and its ancestors that is in some scenes only, such as an entity or a frame of an
            instance.
        depth: number of poses composed in `world`.
        read: the nearest of itself and its ancestors with a variation; None: there is none.
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
    """A light or a camera. It has a pose, but nothing is posed relative to it.

    Attributes:
        local: its own pose as built: seven numbers, or a node.
        variation: of its pose.
        parent: its reference entity or frame; None: the world.
        fields: of the object.
    """

    local: Pose7 | Node
    variation: VariationLowerer
    parent: str | None
    fields: FieldLowerer


class FrameGraph:
    """World poses of a document's objects, composed in float64.

    Names come from `scenecc.spec.references.qualified_name`.

    Args:
        sections: section → name → object with a `pose`; only cameras without a mount.
        fields_of: gives the field lowerer of an entity or a frame, by its name.
        names: resolves names of the document.
        origin: of its root.
        sink: receives the diagnostics.

    Attributes:
        unread: entities with an error in their file, which was reported. Their other objects are unknown.
        followers: lights and cameras by name.
        articulations: structures and pick of each articulation, by name.
        structures: structures and pick of each entity, by name.
        vertices: reads the vertices (n, 3) [m] of a file of the plan; None after an error.
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
        self.articulations: dict[str, tuple[tuple[ArticulationStructure, ...], Value | None]] = {}
        self.structures: dict[str, tuple[tuple[BodyStructure | ArticulationStructure, ...], Value | None]] = {}
        self.vertices: Callable[[int, Origin], Any] | None = None
        self._links: dict[str, LinkFrame] = {}
        # Entities whose joints start at their built positions.
        self._still: set[str] = set()

    def add(self, name: str, owner: Origin, node: Any) -> None:
        """Adds an object that an entity makes besides itself: a robot of its file.

        Args:
            name: of the object.
            owner: the entity's node.
            node: has a `pose` as in the models, relative to the entity.
        """
        self._placed[name] = node
        self._origins[name] = owner

    def world(self, name: str, owner: Origin, *, fixed: bool) -> Value:
        """The world pose of an object as a value.

        Args:
            name: of the object.
            owner: its node.
            fixed: whether it is fixed after the build.
        """
        pose = self._placed[name].pose
        apart = not self._is_placed(name) and (
            pose.__class__ is not PoseMapping or (pose.relative_to is None and pose.anchor is None)
        )
        if apart and not self._names.scopes.get(name) and not pose_varies(pose):
            # Shortcut: most poses are in the world frame and few of these are needed again.
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

        Its own pose and its reference frame may be redrawn; a reset moves it.

        Args:
            key: its name, from `scenecc.spec.references.qualified_name`.
            relative_to: as written.
            local: seven numbers, or a node.
            variation: of the pose.
            fields: of the object.
            origin: of the node that has the key `pose`, or of `place`.
        """
        pose = () if origin.path[-1:] == ("place",) else ("pose",)
        parent = self._known_parent(key, relative_to, origin.child(*pose, "relative_to"))
        whole = VariationLowerer(fields, origin)
        whole.join(variation)
        world = local
        if parent is not None:
            outer = self.frame_pose(parent)
            if outer.around is not None:
                self._is_wherever(key, fields.scenes, outer.around, origin)
            world = composed(outer.world, local)
            for other in self._readings(parent):
                whole.join(other)
        self.followers[key] = Follower(local, variation, parent, fields)
        if world.__class__ not in NODE_TYPES:
            return literal(world)
        return fields.finish(world, whole, POSE, origin.child("pose"), reset=True)

    def fix(self, name: str) -> None:
        """Marks an object and its chain of reference frames as fixed after the build."""
        at: str | None = name
        below = name
        while at is not None and at not in self._fixed:
            self._fixed.add(at)
            if at in self._links:
                self._fix_start(self._links[at].entity, below, "relative_to")
            below, at = at, self.frame_pose(at).parent

    def _fix_start(self, entity: str, user: str, key: str) -> None:
        """Fixes the initial joint positions of an articulation, as required by the `key` of the pose of `user`."""
        if entity in self._still:
            return
        self._still.add(entity)
        sampling = self._fields_of(entity).sampling
        if fix_initial_positions(self.articulations[entity][0], sampling):
            self._sink.report(
                "SC347",
                f"the `qpos` of `{cut(entity)}` keeps its values as built, although a reset would redraw it",
                self.origin(user).child("pose", key),
                hint="leave `anchor` out" if key == "anchor" else "make the body kinematic, so that a reset moves it",
            )

    def link(self, entity: str, link: str) -> str:
        """The name of an articulation's link among frames."""
        # Names in a document have no colon, so this is unique.
        key = f"{entity}:{link}"
        self._links.setdefault(key, LinkFrame(entity, link))
        return key

    def fields(self, name: str) -> FieldLowerer:
        """The field lowerer of an entity, a frame or a link."""
        return self._fields_of(self._links[name].entity if name in self._links else name)

    def is_fixed(self, name: str) -> bool:
        """Whether an object is fixed after the build."""
        return name in self._fixed or (name in self._links and self._links[name].entity in self._still)

    def frame_pose(self, name: str) -> FramePose:
        """The pose of an entity or a frame."""
        found = self._standing.get(name)
        if found is not None:
            return found
        chain = self._chain(name)
        for member, parent in reversed(chain.items()):
            if member not in self._standing:
                self._standing[member] = self._frame_pose(member, parent)
        return self._standing[name]

    def _is_placed(self, name: str) -> bool:
        return getattr(self._placed.get(name), "place", None) is not None

    def placed_root(self, name: str) -> str | None:
        """The nearest placed object among an entity or a frame and its ancestors; None if there is none."""
        at: str | None = name
        while at is not None and not self._is_placed(at):
            at = self.frame_pose(at).parent
        return at

    def _readings(self, name: str) -> list[VariationLowerer]:
        """The variations of a pose and of its chain of reference frames."""
        variations: list[VariationLowerer] = []
        at = self.frame_pose(name).read
        while at is not None:
            frame_pose = self.frame_pose(at)
            assert frame_pose.variation is not None
            variations.append(frame_pose.variation)
            at = None if frame_pose.parent is None else self.frame_pose(frame_pose.parent).read
        # In a long varying chain, each member merges the variations of all its ancestors.
        self._fields_of(name).sampling.count_operations(_JOINED * len(variations), self.origin(name))
        return variations

    def _local(self, name: str) -> tuple[Any, VariationLowerer | None]:
        """The pose of an object in its reference frame, and its variation; None if it does not vary."""
        origin = self.origin(name)
        if name in self._links:
            link = self._links[name]
            lowerer = LinkPoseLowerer(name, self.fields(name), origin)
            local = lowerer.lower(*self.articulations[link.entity], link.link)
            return local, lowerer.variation if local.__class__ in NODE_TYPES else None
        pose = self._placed[name].pose
        local: Any
        variation = None
        if pose_varies(pose):
            variation = VariationLowerer(self._fields_of(name), origin)
            local = pose_item(pose, FieldPlace(origin.child("pose"), "pose"), variation, self._sink)
        else:
            local = lower_pose(pose, origin, ("pose",), self._sink)
        if pose.__class__ is not PoseMapping or pose.anchor is None:
            return local, variation
        return self._pose_of_origin(name, local, pose.anchor, variation)

    def _pose_of_origin(
        self, name: str, local: Any, anchor: str, variation: VariationLowerer | None
    ) -> tuple[Any, VariationLowerer | None]:
        """The pose of the origin, computed from the pose of an anchor point."""
        from scenecc.lower.anchors import AnchorError, AnchorPoints  # noqa: PLC0415 - loaded where there is one

        place = self.origin(name).child("pose")
        if name not in self.structures:
            if name not in self.unread:
                report_unused_key("anchor", "here", place, self._sink, hint="only one entity has bounds")
            return local, variation
        if name in self.articulations:
            self._fix_start(name, name, "anchor")
        fields, place = self._fields_of(name), place.child("anchor")
        structures, pick = self.structures[name]

        def vertices(index: int) -> Any:
            return None if self.vertices is None else self.vertices(index, place)

        try:
            points = AnchorPoints(structures, pick, fields.scenes, vertices)
            rows = [(0.0 - x, 0.0 - y, 0.0 - z, *IDENTITY) for x, y, z in points.rows(anchor)]
        except AnchorError as error:
            self._sink.report("SC348", f"`{cut(name)}` has no {anchor}: {error}", place)
            return local, variation
        except DrawError as error:
            report_draw_failure(error, place, fields.sampling)
            return local, variation
        if len(rows) == 1:
            return composed(local, rows[0]), variation
        variation = variation or VariationLowerer(fields, self.origin(name))
        variation.seeded |= not points.known
        return composed(local, Rows(fields.scenes, tuple(rows))), variation

    def _frame_pose(self, name: str, parent: str | None) -> FramePose:
        if self._is_placed(name):
            variation = VariationLowerer(self._fields_of(name), self.origin(name))
            variation.drawn = True
            return FramePose(Placed(name), variation, None, Placed(name), name, 1, name)
        outer = self._standing.get(parent) if parent is not None else None
        local, variation = self._local(name)
        around = outer.around if outer is not None else None
        if name not in self._links and (name not in self._frames or self._is_narrowed(name)):
            # A plain frame has no scenes of its own; it inherits those of its parent.
            if around is not None:
                self._is_wherever(name, self._fields_of(name).scenes, around, self.origin(name))
            around = name
        read = name if variation is not None else outer and outer.read
        if outer is None or parent is None:
            return FramePose(local, variation, None, local, around, 1, read)
        if outer.depth < MAX_COMPOSED_POSES:
            return FramePose(local, variation, parent, composed(outer.world, local), around, outer.depth + 1, read)
        world = composed(self._share_pose(parent, outer.world), local)
        return FramePose(local, variation, parent, world, around, 2, read)

    def _share_pose(self, name: str, world: Any) -> Any:
        """Makes a shared draw of a pose in a long varying chain, which limits the nesting of the rest."""
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

    def _chain(self, name: str) -> dict[str, str | None]:
        """An object and its ancestors, up to the first with a world pose or an error, each with its reference frame."""
        chain: dict[str, str | None] = {name: None}
        outermost = name
        while outermost not in self._standing and (parent := self._parent(outermost)) is not None:
            chain[outermost] = parent
            if parent in chain:
                members = list(chain)
                self._cycle([one for one in members[members.index(parent) :] if one not in self._links])
                break
            chain[parent] = None
            outermost = parent
        return chain

    def _parent(self, name: str) -> str | None:
        if self._is_placed(name):
            return None
        if name in self._links:
            return self._links[name].entity
        written = self._relative_to(name)
        return self._known_parent(name, written, self.origin(name).child("pose", "relative_to"))

    def _known_parent(self, name: str, written: str | None, place: Origin) -> str | None:
        parent = self._names.parent(name, written)
        if parent is None or parent in self._placed:
            return parent
        whole = next((ahead for ahead in name_prefixes(parent) if ahead in self._placed), "")
        if whole in self.articulations:
            structures, _ = self.articulations[whole]
            link = find_link(whole, structures, parent[len(whole) + 1 :], place, self._sink)
            return link and self.link(whole, link)
        if whole in self.unread:
            return None
        shown = str(written).removeprefix("/")
        outside = (other for other in self._placed if not self._names.scopes.get(other))
        seen = self._names.seen_by(name, self._placed) if shown == written else outside
        message = f"there is no entity, frame or camera `{cut(shown)}` with a pose in the world"
        self._sink.report("SC303", message, place, hint=suggest_name(shown, seen, self._sink))
        return None

    def _is_wherever(self, name: str, mine: tuple[int, ...], parent: str, origin: Origin) -> None:
        """Reports a scene that contains the object but not its reference entity."""
        others = self._fields_of(parent).scenes
        if mine is others or not (missing := set(mine).difference(others)):
            return
        shown = name.rpartition(":")[2]
        self._sink.report(
            "SC311",
            f"`{parent}` is not in scene {min(missing)}, but `{shown}` is relative to it there",
            origin.child("pose", "relative_to"),
            related=[(f"the scenes of `{parent}`", self.origin(parent).child("scene_idxs"), "value")],
        )

    def _cycle(self, members: list[str]) -> None:
        # One report per cycle, at its first member in the file.
        rank = {name: i for i, name in enumerate(self._placed)}
        start = members.index(min(members, key=rank.__getitem__))
        ordered = members[start:] + members[:start]
        shown = [*ordered[:_SHOWN], "…"] if len(ordered) > _SHOWN else ordered
        self._sink.report(
            "SC304",
            "circular poses: " + " → ".join([*map(cut, shown), cut(ordered[0])]),
            self.origin(ordered[0]).child("pose", "relative_to"),
            related=[
                ("and here", self.origin(name).child("pose", "relative_to"), "value") for name in ordered[1:_SHOWN]
            ],
        )

    def origin(self, name: str) -> Origin:
        """The node of an entity or a frame."""
        found = self._origins.get(name)
        if found is None and name in self._links:
            return self.origin(self._links[name].entity)
        if found is None:
            section = next(section for section, nodes in self._sections.items() if name in nodes)
            found = self._origins[name] = self._origin.child(section, name)
        return found
