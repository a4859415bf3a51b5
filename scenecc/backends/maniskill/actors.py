"""Bodies of the plan as ManiSkill's actors, through its own builder."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.maniskill.failure import UNFIT
from scenecc.backends.maniskill.planes import without_planes
from scenecc.backends.maniskill.theirs import Actor, ActorBuilder, Pose, torch
from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.plan import Value

if TYPE_CHECKING:
    from scenecc.backends.sapien.turn import AnyTurn, Turn

_TYPES = {"none": "static"}
"""What ManiSkill calls a body that it does not know by our name: one that never moves."""


class PlannedActorBuilder(ActorBuilder):
    """ManiSkill's builder, whose entities come from a turn of the plan, scene by scene.

    ManiSkill's `build` names them, places them, adds them to their sub-scenes and registers the actor. What it would
    have made of its records is made by the turn, which leaves out nothing that the engine refuses.
    """

    def __init__(self, turn: Turn) -> None:
        super().__init__()  # pyright: ignore[reportUnknownMemberType]
        self._turn = turn
        # Shapes come from the plan alone: the add_* methods append to these, and must not do so unheard.
        self.collision_records = self.visual_records = ()
        structure = turn.parts[0].structure
        self.physx_body_type = _TYPES.get(structure.body_type, structure.body_type)

    def build_entity(self) -> Any:
        """The next of the turn's entities, by ascending scene index."""
        turn = self._turn
        index = turn.scene_idxs[len(turn.objs)]
        if turn.make is not None:
            entity, component = turn.make(index)
        else:
            own = turn.table[index]
            assert own is not None
            entity, component = own[0](own[1])
        turn.objs.append(entity)
        turn.components.append(component)
        return entity


def build_actor(turn: Turn, scene: Any) -> Any:
    """One entity of the plan in a `ManiSkillScene`, all of whose sub-scenes are among the turn's, by their index.

    Where the shapes are not the same in all of its scenes, what is returned is a view by `Actor.merge`, in scene order.
    The actor in `scene.actors`, and in the environment's state, has the same bodies and name.

    Raises:
        EngineFailure: the engine refuses a shape or a value, or ManiSkill cannot handle the bodies as one actor.
    """
    _refuse_mixed_types(turn)
    name = turn.entity.name
    builder = PlannedActorBuilder(turn)
    builder.set_scene(scene)
    builder.set_scene_idxs(list(turn.scene_idxs))
    builder.initial_pose = batched_pose(turn, scene)
    actor = builder.build(name)
    return Actor.merge([actor], name=name) if _differs(turn) else actor


def batched_pose(turn: AnyTurn, scene: Any) -> Any:
    """Where an entity starts: a row for each of its scenes, or one for all."""
    rows = taken(turn.entity.pose, turn.rows).astype(np.float32)
    return Pose.create(torch.from_numpy(np.ascontiguousarray(rows)), device=scene.device)


def _refuse_mixed_types(turn: Turn) -> None:
    types = sorted({part.structure.body_type for part in turn.parts})
    if len(types) > 1:
        message = f"the variants of '{turn.entity.name}' are bodies of the types {' and '.join(types)}"
        hint = "an actor of ManiSkill's is of one type in all environments: give them one, or entities of their own"
        raise EngineFailure(UNFIT, message, hint=hint)


def _differs(turn: Turn) -> bool:
    """Whether a mesh of one scene's body would be wrong for another's."""
    if len(turn.scene_idxs) == 1:
        return False
    first, *others = (without_planes(part.structure) for part in turn.parts)
    return any(other != first for other in others) or any(
        value.varies
        for part in turn.parts
        for shape in (*part.structure.collisions, *part.structure.visuals)
        for value in (shape.pose, *(getattr(shape.geometry, each.name) for each in fields(shape.geometry)))
        if isinstance(value, Value)
    )
