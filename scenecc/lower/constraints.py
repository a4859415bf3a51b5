"""Constraints as written to those of the plan: what they tie together, and where."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.lower.joints import lower_joint
from scenecc.lower.names import WORLD
from scenecc.lower.placing.chains import Step, chained, to_link
from scenecc.lower.placing.shape_poses import local_pose
from scenecc.plan import ArticulationStructure, Constraint
from scenecc.spec.known import known_as

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.entities import Entities
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.mounts import Mounts
    from scenecc.lower.names import Names
    from scenecc.plan import Entity, Mount, Value

_FRAME = "the frame of a constraint"


class Constraints:
    """Lowers the constraints of a document.

    Args:
        built: its entities, lowered.
        entities: what lowered them.
        mounts: finds what is tied together.
        drawing: of the document.
        names: likewise.
        sink: takes the diagnostics.
    """

    def __init__(
        self, built: tuple[Entity, ...], entities: Entities, mounts: Mounts, drawing: Drawing, names: Names, sink: Sink
    ) -> None:
        self._built = {entity.name: entity for entity in built}
        self._entities = entities
        self._mounts = mounts
        self._drawing = drawing
        self._names = names
        self._sink = sink

    def lower(self, written: Mapping[str, Any], origin: Origin) -> tuple[Constraint, ...]:
        """The constraints of the plan; what was reported is missing among them. `origin`: of `constraints`."""
        found = [self._constraint(name, one, origin.child(name)) for name, one in written.items()]
        made = tuple(one for one in found if one is not None)
        if self._drawing.resets and not self._sink.failed:
            from scenecc.lower.apart import report_torn  # noqa: PLC0415 - loaded where something varies

            left_out = tuple(one for one in made if written[one.name].pose_in_parent is None)
            report_torn(left_out, tuple(self._built.values()), self._drawing, self._entities.places)
        return made

    def _constraint(self, name: str, written: Any, origin: Origin) -> Constraint | None:
        scope = self._names.scopes.get(known_as("constraints", name), "")
        child = self._mount("child", written.child, scope, origin)
        parent = self._mount("parent", written.parent, scope, origin)
        if child is None or (parent is None and written.parent != WORLD):
            return None
        scenes = self._scenes(name, (child, parent), scope, origin)
        if not scenes:
            return None
        for key, mount in (("child", child), ("parent", parent)):
            if mount is not None:
                self._mounts.find(getattr(written, key), scope, scenes, origin.child(key))
        leaves = self._drawing.leaves(scenes, scope)
        in_child = None
        if written.pose_in_child is not None:
            in_child = local_pose(written.pose_in_child, origin, ("pose_in_child",), _FRAME, leaves)
        return Constraint(
            name=name,
            scene_idxs=scenes,
            joint=lower_joint(written, leaves, origin),
            child=child,
            parent=parent,
            pose_in_parent=self._in_parent(written, (child, parent), in_child, leaves, origin),
            pose_in_child=in_child,
            origin=origin,
        )

    def _mount(self, key: str, written: str, scope: str, origin: Origin) -> Mount | None:
        if written != WORLD:
            return self._mounts.find(written, scope, (), origin.child(key))
        if key == "child":
            message = "the world cannot be the child of a constraint: a body that moves carries it"
            hint = "write `parent: world`, and as `child` what is fastened to it"
            self._sink.report("SC340", message, origin.child(key), hint=hint)
        return None

    def _scenes(
        self, name: str, mounts: tuple[Mount | None, ...], scope: str, origin: Origin
    ) -> tuple[int, ...] | None:
        """The scenes of a constraint: those that it selects, or else those that its bodies are in."""
        selections = self._entities.selections
        selected = selections.get(known_as("constraints", name))
        if selected is not None and selected is not selections.get(self._names.anchors.get(scope, "")):
            return selected
        scenes = self._drawing.everywhere
        for mount in mounts:
            others = None if mount is None else self._built[mount.entity].scene_idxs
            if others is not None and others is not scenes:
                scenes = others if scenes is self._drawing.everywhere else _shared(scenes, others)
        if not scenes:
            message = f"`{cut(name)}` ties together what is never in the same scene"
            self._sink.report("SC341", message, origin, at="key")
        return scenes

    def _in_parent(
        self,
        written: Any,
        mounts: tuple[Mount, Mount | None],
        in_child: Value | None,
        leaves: Leaves,
        origin: Origin,
    ) -> Value | None:
        """The frame in the parent's: as written, or where the child's stands at the start."""
        child, parent = mounts
        scenes = leaves.scenes
        if written.pose_in_parent is not None:
            value = local_pose(written.pose_in_parent, origin, ("pose_in_parent",), _FRAME, leaves)
            anchor = self._names.anchors.get(leaves.scope) if parent is None else None
            if anchor is None:
                return value
            # The world of a prefab is where its instance stands.
            around = self._entities.places.world(anchor, origin, fixed=True)
            return chained([Step(around, self._entities.leaves(anchor).scenes), Step(value, scenes)], scenes)
        steps = self._to(child, "child", origin)
        outer = [] if parent is None else self._to(parent, "parent", origin)
        if steps is None or outer is None:
            return None
        back = [Step(step.value, step.scenes, step.kind, not step.back) for step in reversed(outer)]
        last = [] if in_child is None else [Step(in_child, scenes)]
        return chained([*back, *steps, *last], scenes)

    def _to(self, mount: Mount, key: str, origin: Origin) -> list[Step] | None:
        """The steps from the world to a body at the start; None where it has not one way there, which is reported."""
        entity = self._built[mount.entity]
        steps = [Step(entity.pose, entity.scene_idxs)]
        if mount.link is None:
            return steps
        first, *others = entity.structures
        if isinstance(first, ArticulationStructure) and mount.link != first.links[0].name:
            if others:
                message = f"where `{cut(mount.link)}` starts differs between the structures of `{cut(mount.entity)}`"
                self._sink.report("SC342", message, origin.child(key), hint="write `pose_in_parent`")
                return None
            steps += to_link(first, mount.link, entity.scene_idxs)
        return steps


def _shared(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[int, ...]:
    others = frozenset(b)
    return tuple(scene for scene in a if scene in others)
