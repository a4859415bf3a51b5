"""Makes one body of all links of an articulation that never moves its joints (`body_type` of a robot)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.link_frames import fix_initial_positions
from scenecc.lower.local_poses import chain_poses
from scenecc.plan import BodyStructure
from scenecc.plan.link_poses import PoseStep, steps_to_link

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.lower.fields import FieldLowerer
    from scenecc.plan import ArticulationStructure, CollisionShape, Value, VisualShape


def fuse_links(
    structure: ArticulationStructure, body_type: Literal["static", "kinematic"], fields: FieldLowerer, sink: Sink
) -> BodyStructure:
    """One body with the shapes of all links, at the link poses that `qpos` gives, in the frame of the root.

    Drawn positions keep the values of the build, since shapes cannot move.

    Args:
        structure: the articulation.
        body_type: of the body.
        fields: of the entity.
        sink: receives the diagnostics.
    """
    fix_initial_positions([structure], fields.sampling)
    collisions: list[CollisionShape] = []
    visuals: list[VisualShape] = []
    for link in structure.links:
        frame = chain_poses(steps_to_link(structure, link.name, fields.scenes), fields.scenes)
        body = link.body
        for shape in body.collisions:
            groups = shape.collision_groups or body.collision_groups
            collisions.append(replace(shape, pose=_moved(frame, shape.pose, fields), collision_groups=groups))
        visuals += (replace(shape, pose=_moved(frame, shape.pose, fields)) for shape in body.visuals)
    return BodyStructure(
        body_type=body_type,
        collisions=tuple(collisions),
        visuals=tuple(visuals),
        visibility=_visibility(structure, sink),
        origin=structure.origin,
    )


def _moved(frame: Value, pose: Value | None, fields: FieldLowerer) -> Value | None:
    """The pose of a shape of a link in the frame of the root; None: the identity."""
    if frame.is_constant and frame.numbers() == IDENTITY_POSE:
        return pose
    steps = [PoseStep(frame, fields.scenes), *([] if pose is None else [PoseStep(pose, fields.scenes)])]
    return chain_poses(steps, fields.scenes)


def _visibility(structure: ArticulationStructure, sink: Sink) -> Value | None:
    """The visibility of all links with visual shapes. Links that differ are an error (SC332)."""
    visible = [link for link in structure.links if link.body.visuals]
    first, *others = visible or structure.links
    for other in others:
        if not _is_same(first.body.visibility, other.body.visibility):
            message = f"`{first.name}` and `{other.name}` differ in `visibility`, but are shapes of one body"
            place = other.body.origin or structure.origin
            assert place is not None
            sink.report("SC332", message, place, hint="write `visibility` beside `body_type`, for all links")
            break
    return first.body.visibility


def _is_same(a: Value | None, b: Value | None) -> bool:
    if a is None or b is None:
        return a is b
    return a is b or (a.is_constant and b.is_constant and a.numbers() == b.numbers())
