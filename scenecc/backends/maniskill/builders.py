"""Builds a plan through ManiSkill's builders: actors, articulations, sensors and lights."""

from __future__ import annotations

from dataclasses import fields, replace
from math import atan, tan
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.maniskill.compat import (
    SHADERS,
    UNSUPPORTED_CODE,
    Actor,
    ActorBuilder,
    Articulation,
    ArticulationBuilder,
    CameraConfig,
    Pose,
    torch,
)
from scenecc.backends.sapien.engine import EngineFailure
from scenecc.backends.sapien.properties import select_rows
from scenecc.plan import ArticulationStructure, BodyStructure, Entity, Plane, Value
from scenecc.plan.rendering import Camera, Intrinsic, Orthographic, Perspective
from scenecc.variation.nodes import NODES, Composed, Rows

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.preparation import PreparedActor, PreparedArticulation, PreparedEntity
    from scenecc.plan import CollisionShape, ScenePlan

_PLANE_HINT = "environments share one simulation on the GPU: use a box, or the same plane in all environments"


def deduplicate_planes(plan: ScenePlan) -> ScenePlan:
    """Returns the plan with each plane in the first scene only, except planes that must be in every scene.

    Raises:
        EngineFailure: a plane is not the same in all scenes.
    """
    if plan.num_scenes == 1 or not any(map(_has_plane, plan.entities)):
        return plan
    entities = [
        _deduplicate_plane(entity, plan.num_scenes) if _has_plane(entity) else entity for entity in plan.entities
    ]
    return replace(plan, entities=tuple(entities))


def without_planes(structure: BodyStructure) -> BodyStructure:
    """Returns the structure without the planes that are built once."""
    return replace(structure, collisions=tuple(shape for shape in structure.collisions if not _is_shared(shape)))


def _has_plane(entity: Entity) -> bool:
    return any(map(_is_shared, (shape for body in entity.bodies for shape in body.collisions)))


def _is_shared(shape: CollisionShape) -> bool:
    return isinstance(shape.geometry, Plane) and not shape.geometry.every_scene


def _deduplicate_plane(entity: Entity, num_scenes: int) -> Entity:
    if len(entity.scene_idxs) < num_scenes:
        message = f"the plane of '{entity.name}' is only in some environments"
        raise EngineFailure(UNSUPPORTED_CODE, message, origin=entity.origin, hint=_PLANE_HINT)
    whole = entity.structures[0]
    if len(entity.structures) > 1 or not isinstance(whole, BodyStructure) or _plane_varies(entity, whole):
        message = f"the plane of '{entity.name}' differs between environments"
        raise EngineFailure(UNSUPPORTED_CODE, message, origin=entity.origin, hint=_PLANE_HINT)
    pick = np.ones(num_scenes, dtype=np.int64)
    pick[0] = 0
    return replace(entity, structures=(whole, without_planes(whole)), pick=Value(pick))


def _plane_varies(entity: Entity, structure: BodyStructure) -> bool:
    planes = filter(_is_shared, structure.collisions)
    values = [entity.pose, *(value for shape in planes for value in (shape.pose, shape.material))]
    return any(value is not None and value.varies for value in values)


_BODY_TYPES = {"none": "static"}
"""Plan's body type → ManiSkill's, where they differ. ManiSkill has no bodies without physics."""


class PlannedActorBuilder(ActorBuilder):
    """ManiSkill's builder, with entities made by a `PreparedActor`, scene by scene.

    ManiSkill's `build` names and places them, adds them to their sub-scenes and registers the actor. A `PreparedActor`
    fails on everything that the engine refuses, where ManiSkill would skip it.
    """

    def __init__(self, prepared: PreparedActor) -> None:
        super().__init__()  # pyright: ignore[reportUnknownMemberType]
        self._prepared = prepared
        # Shapes come only from the plan, so the add_* methods, which append to these, must fail.
        self.collision_records = self.visual_records = ()
        structure = prepared.parts[0].structure
        self.physx_body_type = _BODY_TYPES.get(structure.body_type, structure.body_type)

    def build_entity(self) -> Any:
        """Returns the next of the prepared actor's entities, by ascending scene index."""
        prepared = self._prepared
        index = prepared.scene_idxs[len(prepared.objs)]
        if prepared.make is not None:
            entity, component = prepared.make(index)
        else:
            own = prepared.table[index]
            assert own is not None
            entity, component = own[0](own[1])
        prepared.objs.append(entity)
        prepared.components.append(component)
        return entity


def build_actor(prepared: PreparedActor, scene: Any) -> Any:
    """Builds an entity of the plan in a `ManiSkillScene` whose sub-scenes have the plan's indices.

    If the shapes differ between its scenes, returns a view made by `Actor.merge`, in scene order. The actor in
    `scene.actors`, and in the environment's state, has the same bodies and name.

    Raises:
        EngineFailure: the engine refuses a shape or a value, or ManiSkill cannot handle the bodies as one actor.
    """
    _refuse_mixed_types(prepared)
    name = prepared.entity.name
    builder = PlannedActorBuilder(prepared)
    builder.set_scene(scene)
    builder.set_scene_idxs(list(prepared.scene_idxs))
    builder.initial_pose = batched_pose(prepared, scene)
    actor = builder.build(name)
    return Actor.merge([actor], name=name) if _shapes_differ(prepared) else actor


def batched_pose(prepared: PreparedEntity, scene: Any) -> Any:
    """Returns the initial pose of an entity: a row for each of its scenes, or one for all."""
    rows = select_rows(prepared.entity.pose, prepared.rows).astype(np.float32)
    return Pose.create(torch.from_numpy(np.ascontiguousarray(rows)), device=scene.device)


def _refuse_mixed_types(prepared: PreparedActor) -> None:
    types = sorted({part.structure.body_type for part in prepared.parts})
    if len(types) > 1:
        message = f"the variants of '{prepared.entity.name}' have different body types: {' and '.join(types)}"
        hint = "a ManiSkill actor has one type in all environments: use one type, or separate entities"
        raise EngineFailure(UNSUPPORTED_CODE, message, hint=hint)


def _shapes_differ(prepared: PreparedActor) -> bool:
    """Returns whether bodies of different scenes need different meshes."""
    if len(prepared.scene_idxs) == 1:
        return False
    first, *others = (without_planes(part.structure) for part in prepared.parts)
    return any(other != first for other in others) or any(
        value.varies
        for part in prepared.parts
        for shape in (*part.structure.collisions, *part.structure.visuals)
        for value in (shape.pose, *(getattr(shape.geometry, each.name) for each in fields(shape.geometry)))
        if isinstance(value, Value)
    )


class PlannedArticulationBuilder(ArticulationBuilder):
    """ManiSkill's builder, with links made by a `PreparedArticulation`, scene by scene.

    ManiSkill's `build` adds them to their sub-scenes and registers the articulation. A `PreparedArticulation` makes
    links, joints and mimics, because ManiSkill drops frictions and defines mimics differently.
    """

    def __init__(self, prepared: PreparedArticulation, scene_idxs: Sequence[int]) -> None:
        super().__init__()  # pyright: ignore[reportUnknownMemberType]
        self._prepared = prepared
        self._waiting = list(scene_idxs)

    def _build_entities(
        self, fix_root_link: object = None, name_prefix: str = "", initial_pose: Any = None
    ) -> list[Any]:
        del fix_root_link  # set by the prepared articulation
        own = self._prepared.table[self._waiting.pop(0)]
        assert own is not None
        builder, row = own
        entities, links = builder.make(row)
        for link in links:
            link.set_name(name_prefix + link.get_name())
            joint = link.get_joint()
            joint.set_name(name_prefix + joint.get_name())
        if initial_pose is not None:
            entities[0].set_pose(initial_pose)
        self._prepared.entities.append(entities)
        self._prepared.links.append(links)
        return entities


def build_articulation(prepared: PreparedArticulation, scene: Any) -> Any:
    """Builds an articulation of the plan in a `ManiSkillScene` whose sub-scenes have the plan's indices.

    If the links differ between its scenes, each scene has its own articulation, `NAME-INDEX`. Then the result, also in
    the environment's state, is a view made by `Articulation.merge`, in scene order.

    Raises:
        EngineFailure: the engine refuses a shape or a value.
    """
    name, pose = prepared.entity.name, batched_pose(prepared, scene)
    if len(prepared.parts) == 1:
        return _build_part(prepared, scene, name, prepared.scene_idxs, pose)
    parts: list[Any] = []
    for number, index in enumerate(prepared.scene_idxs):
        part = _build_part(prepared, scene, f"{name}-{index}", (index,), pose if len(pose) == 1 else pose[number])
        scene.remove_from_state_dict_registry(part)
        parts.append(part)
    links = [[link.name for link in part.structure.links] for part in prepared.parts]
    view = Articulation.merge(parts, name=name, merge_links=all(names == links[0] for names in links))
    view.initial_pose = pose
    scene.add_to_state_dict_registry(view)
    return view


def _build_part(prepared: PreparedArticulation, scene: Any, name: str, scene_idxs: Sequence[int], pose: Any) -> Any:
    builder = PlannedArticulationBuilder(prepared, scene_idxs)
    builder.set_scene(scene)
    builder.set_scene_idxs(list(scene_idxs))
    builder.initial_pose = pose
    before = len(prepared.links)
    articulation = builder.build(name)
    for index, links in zip(scene_idxs, prepared.links[before:], strict=True):
        prepared.objs.append(
            _start_articulation(prepared, links, index, f"scene-{index}_{name}", on_gpu=scene.gpu_sim_enabled)
        )
    return articulation


def _start_articulation(
    prepared: PreparedArticulation, links: list[Any], index: int, name: str, *, on_gpu: bool
) -> Any:
    """Sets everything that ManiSkill's builder does not. On a GPU, the buffers for positions do not exist yet."""
    own = prepared.table[index]
    assert own is not None
    builder, row = own
    articulation = builder.settle(links, row) if on_gpu else builder.start(links, row)
    articulation.set_name(name)
    return articulation


_DEFAULT_SHADER = "minimal"
"""ManiSkill's shader for sensors without one."""


def camera_configs(
    plan: ScenePlan, actors: Mapping[str, Any], articulations: Mapping[str, Any], *, on_gpu: bool
) -> list[Any]:
    """Returns ManiSkill's configuration of each camera, by its name in the plan.

    Without rendering, cameras that `unsupported_cameras` rejects are skipped. `on_gpu`: simulation on a GPU.
    """
    return [
        _camera_config(camera, actors, articulations)
        for camera in plan.cameras
        if _unsupported_camera(camera, plan, on_gpu=on_gpu) is None
    ]


def unsupported_cameras(plan: ScenePlan, *, on_gpu: bool = False) -> Iterator[EngineFailure]:
    """Yields cameras and hidden entities that ManiSkill does not support. `on_gpu`: simulation on a GPU."""
    for camera in plan.cameras:
        found = _unsupported_camera(camera, plan, on_gpu=on_gpu)
        if found is not None:
            message, hint = found
            yield EngineFailure(
                UNSUPPORTED_CODE, f"the camera '{camera.name}' {message}", origin=camera.origin, hint=hint
            )
    for entity in plan.entities:
        if entity.hidden and not _can_hide(entity):
            message = f"'{entity.name}' is hidden, but ManiSkill can only hide movable bodies without collision shapes"
            hint = "set `body_type: kinematic`, and give it `visuals` only"
            yield EngineFailure(UNSUPPORTED_CODE, message, origin=entity.origin, hint=hint)


def hidden_objects(plan: ScenePlan, scene: Any) -> list[Any]:
    """Returns the actors that are hidden from sensors, not views of them, since ManiSkill cannot hide views.

    Without rendering, those that `unsupported_cameras` rejects are skipped.
    """
    return [scene.actors[entity.name] for entity in plan.entities if entity.hidden and _can_hide(entity)]


def _follows_drawn_frame(camera: Camera) -> bool:
    """Returns whether a camera's pose is relative to a frame that a reset redraws."""
    recipe = camera.pose.recipe
    return isinstance(recipe, Composed) and isinstance(recipe.outer, NODES) and not isinstance(recipe.outer, Rows)


def _unsupported_camera(camera: Camera, plan: ScenePlan, *, on_gpu: bool) -> tuple[str, str] | None:
    """Returns what is wrong with a camera, and a hint."""
    if len(camera.scene_idxs) < plan.num_scenes:
        return "is only in some environments", "ManiSkill's sensors are in all environments: leave `scene_idxs` out"
    if on_gpu and _follows_drawn_frame(camera):
        return "is posed relative to a frame that a reset redraws", "mount it on a body, so that it moves on a GPU"
    mount = camera.mount and next(entity for entity in plan.entities if entity.name == camera.mount.entity)
    if mount is not None and _has_several_links(mount):
        reason = f"is mounted on '{mount.name}', whose links differ between environments"
        return reason, "ManiSkill's view of such robots has no links: leave `mount` out"
    return _unsupported_lens(camera)


def _unsupported_lens(camera: Camera) -> tuple[str, str] | None:
    """Returns what is wrong with a camera's lens or shader, and a hint."""
    if not isinstance(camera.lens, Perspective | Intrinsic):
        return "is not a perspective camera", "ManiSkill's sensors must be: give it a `fovy`"
    if isinstance(camera.lens, Intrinsic) and camera.lens.skew.data.any():
        return "has a skew", "ManiSkill's sensors do not support skew"
    if camera.shader is not None and camera.shader not in SHADERS:
        return f"needs the shader '{camera.shader}'", f"ManiSkill has {', '.join(SHADERS)}"
    return None


def _has_several_links(entity: Entity) -> bool:
    """Returns whether the entity's variants are articulations with different link names."""
    links = [[link.name for link in one.links] for one in entity.structures if isinstance(one, ArticulationStructure)]
    return any(names != links[0] for names in links)


def _can_hide(entity: Entity) -> bool:
    return all(
        isinstance(structure, BodyStructure)
        and structure.body_type in ("dynamic", "kinematic")
        and not structure.collisions
        for structure in entity.structures
    )


def _camera_config(camera: Camera, actors: Mapping[str, Any], articulations: Mapping[str, Any]) -> Any:
    mount: Any = None
    if camera.mount is not None and camera.mount.entity in actors:
        mount = actors[camera.mount.entity]
    elif camera.mount is not None:
        articulation = articulations[camera.mount.entity]
        mount = articulation.root if camera.mount.link is None else articulation.links_map[camera.mount.link]
    pose = np.ascontiguousarray(camera.pose.data.astype(np.float32))
    return CameraConfig(
        uid=camera.name,
        pose=Pose.create(torch.from_numpy(pose)),
        width=camera.width,
        height=camera.height,
        near=_shared_or_listed(camera.near),
        far=_shared_or_listed(camera.far),
        mount=mount,
        shader_pack=camera.shader or _DEFAULT_SHADER,
        **_lens_arguments(camera),
    )


def _shared_or_listed(value: Value) -> float | list[float]:
    found: list[float] = value.data.astype(np.float64).tolist()
    return found if value.varies else found[0]


def _lens_arguments(camera: Camera) -> dict[str, Any]:
    lens: Perspective | Intrinsic | Orthographic = camera.lens
    if isinstance(lens, Perspective):
        if lens.fovx is None:
            assert lens.fovy is not None
            return {"fov": _shared_or_listed(lens.fovy)}
        if lens.fovy is None:
            # ManiSkill's lens with square pixels.
            upright = [2 * atan(tan(fovx / 2) * camera.height / camera.width) for fovx in lens.fovx.data.tolist()]
            return {"fov": upright if lens.fovx.varies else upright[0]}
        fx, fy = (
            side / 2 / np.tan(fov.data / 2) for side, fov in ((camera.width, lens.fovx), (camera.height, lens.fovy))
        )
        return {"intrinsic": _intrinsic_matrix(fx, fy, np.array([camera.width / 2]), np.array([camera.height / 2]))}
    assert isinstance(lens, Intrinsic)
    return {"intrinsic": _intrinsic_matrix(lens.fx.data, lens.fy.data, lens.cx.data, lens.cy.data)}


def _intrinsic_matrix(*numbers: NDArray[np.float64]) -> NDArray[np.float32]:
    """Returns (B, 3, 3), or (3, 3) if all cameras have the same."""
    fx, fy, cx, cy = np.broadcast_arrays(*numbers)
    found = np.zeros((len(fx), 3, 3), np.float32)
    found[:, 0, 0], found[:, 1, 1], found[:, 0, 2], found[:, 1, 2], found[:, 2, 2] = fx, fy, cx, cy, 1
    return found if len(found) > 1 else found[0]
