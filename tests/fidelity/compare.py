"""Two scenes, every property of every body and shape, to the last bit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

STEPS = 300

_RIGID = (
    "mass",
    "inertia",
    "cmass_local_pose",
    "linear_damping",
    "angular_damping",
    "linear_velocity",
    "angular_velocity",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "disable_gravity",
    "locked_motion_axes",
    "kinematic",
    "auto_compute_mass",
    "is_sleeping",
    "name",
)
_LINK = tuple(
    name
    for name in _RIGID
    if name not in ("sleep_threshold", "locked_motion_axes", "kinematic", "is_sleeping")
    and not name.startswith("solver")
)
_JOINT = (
    "name",
    "type",
    "pose_in_parent",
    "pose_in_child",
    "dof",
    "limits",
    "friction",
    "armature",
    "max_velocity",
    "stiffness",
    "damping",
    "force_limit",
    "drive_mode",
    "drive_target",
    "drive_velocity_target",
)
_ARTICULATION = (
    "name",
    "dof",
    "qpos",
    "qvel",
    "root_pose",
    "root_linear_velocity",
    "root_angular_velocity",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
)
_BODY = {
    "PhysxArticulationLinkComponent": (*_LINK, "index", "sleeping"),
    "PhysxRigidDynamicComponent": _RIGID,
    "PhysxRigidStaticComponent": ("name",),
    "RenderBodyComponent": ("visibility", "shading_mode", "is_render_id_disabled", "name"),
}
_TIE = ("name", "is_enabled", "pose_in_parent", "pose_in_child", "relative_pose")
_TIES = {
    "PhysxDriveComponent": (
        *_TIE,
        "drive_target",
        "get_drive_velocity_target",
        *(f"get_limit_{axis}" for axis in ("x", "y", "z", "twist", "cone", "pyramid")),
        *(f"get_drive_property_{axis}" for axis in ("x", "y", "z", "twist", "swing", "slerp")),
    ),
    "PhysxDistanceJointComponent": (*_TIE, "distance"),
    "PhysxGearComponent": (*_TIE, "gear_ratio", "is_hinges_enabled"),
}
"""Of constraints; the limits of a distance, and the scales of masses, SAPIEN lets nobody read."""
_LIGHT = ("name", "color", "shadow", "shadow_near", "shadow_far", "shadow_map_size", "local_pose")
_SEEN = {
    "RenderDirectionalLightComponent": (*_LIGHT, "shadow_half_size"),
    "RenderPointLightComponent": _LIGHT,
    "RenderSpotLightComponent": (*_LIGHT, "inner_fov", "outer_fov"),
    "RenderParallelogramLightComponent": (*_LIGHT, "half_width", "half_height", "angle"),
    "RenderTexturedLightComponent": (*_LIGHT, "inner_fov", "outer_fov"),
    "RenderCameraComponent": (
        *("name", "local_pose", "width", "height", "near", "far", "fovx", "fovy", "fx", "fy", "cx", "cy", "skew"),
        *("mode", "ortho_left", "ortho_right", "ortho_bottom", "ortho_top"),
    ),
}
"""Of lights and cameras; a camera's shaders SAPIEN lets nobody read."""
_COLLISION = (
    "half_size",
    "radius",
    "half_length",
    "scale",
    "vertices",
    "triangles",
    "local_pose",
    "density",
    "collision_groups",
    "contact_offset",
    "rest_offset",
    "patch_radius",
    "min_patch_radius",
)
_PHYSICAL = ("static_friction", "dynamic_friction", "restitution")
_VISUAL = ("half_size", "radius", "half_length", "scale", "local_pose", "front_face", "name", "filename")
_MATERIAL = (
    "base_color",
    "emission",
    "specular",
    "roughness",
    "metallic",
    "transmission",
    "ior",
    "transmission_roughness",
)
_TEXTURES = ("base_color", "normal", "roughness", "metallic", "emission", "transmission")
_TEXTURE = ("filename", "mipmap_levels", "filter_mode", "address_mode", "is_srgb", "width", "height", "format")
_SCENE = (
    "gravity",
    "bounce_threshold",
    "enable_pcm",
    "enable_tgs",
    "enable_ccd",
    "enable_enhanced_determinism",
    "enable_friction_every_iteration",
)


def assert_same_scene(a: Any, b: Any) -> None:
    """The same entities in the same order with the same components, shapes and properties, to the bit."""
    left, right = scene_facts(a), scene_facts(b)
    assert [name for name, _ in left["entities"]] == [name for name, _ in right["entities"]]
    different = _differences("scene", left, right)
    assert not different, "\n".join(different)


def assert_same_trajectory(scenes_a: Sequence[Any], scenes_b: Sequence[Any], steps: int = STEPS) -> None:
    """Steps both lists and compares every pose and velocity after every step, to the bit."""
    assert len(scenes_a) == len(scenes_b)
    for number, (a, b) in enumerate(zip(scenes_a, scenes_b, strict=True)):
        for step in range(steps):
            a.step()
            b.step()
            assert a.pack_poses() == b.pack_poses(), f"poses differ in scene {number} after step {step + 1}"
        assert a.physx_system.pack() == b.physx_system.pack(), f"velocities differ in scene {number}"


def scene_facts(scene: Any) -> dict[str, Any]:
    """All that can be read of a scene, as plain data; floats as their bytes."""
    config = scene.physx_system.config
    return {
        "timestep": _plain(scene.timestep),
        "config": {name: _plain(getattr(config, name)) for name in _SCENE},
        "ambient_light": _readable(scene, "ambient_light"),
        "entities": [(entity.name, entity_facts(entity)) for entity in scene.entities],
    }


def entity_facts(entity: Any) -> dict[str, Any]:
    """All that can be read of an entity."""
    return {"pose": _plain(entity.pose), "components": [_component(component) for component in entity.components]}


def _component(component: Any) -> dict[str, Any]:
    kind = type(component).__name__
    facts: dict[str, Any] = {"type": kind}
    if kind in _TIES:
        return facts | _tie(component, _TIES[kind])
    if kind in _SEEN:
        facts |= {name: _readable(component, name) for name in _SEEN[kind]}
        if kind == "RenderTexturedLightComponent":
            facts["texture"] = {key: _plain(getattr(component.texture, key)) for key in _TEXTURE}
        return facts
    facts |= {name: _plain(getattr(component, name)) for name in _BODY[kind]}
    if kind == "RenderBodyComponent":
        facts["shapes"] = [_visual(shape) for shape in component.render_shapes]
    else:
        facts["shapes"] = [_collision(shape) for shape in component.collision_shapes]
    if kind == "PhysxArticulationLinkComponent":
        facts["parent"] = None if component.parent is None else component.parent.index
        # Of a root's joint, which has no degree of freedom, SAPIEN lets nobody read the rest.
        known = _JOINT if component.parent is not None and component.joint.dof else ("name", "type", "dof")
        facts["joint"] = {name: _plain(getattr(component.joint, name)) for name in known}
        facts["articulation"] = {name: _plain(getattr(component.articulation, name)) for name in _ARTICULATION}
    return facts


def _readable(component: Any, name: str) -> Any:
    """What something has of the name: a scene without a renderer has no light, and a camera only its projection."""
    try:
        return _plain(getattr(component, name))
    except RuntimeError as error:
        return str(error)


def _tie(component: Any, names: Sequence[str]) -> dict[str, Any]:
    found = {name: getattr(component, name) for name in names}
    facts = {name: _plain(one() if callable(one) else one) for name, one in found.items()}
    parent = component.get_parent()
    facts["parent"] = None if parent is None else parent.get_entity().name
    return facts


def _collision(shape: Any) -> dict[str, Any]:
    facts: dict[str, Any] = {"type": type(shape).__name__}
    facts |= {name: _plain(getattr(shape, name)) for name in _COLLISION if hasattr(shape, name)}
    facts["material"] = {name: _plain(getattr(shape.physical_material, name)) for name in _PHYSICAL}
    return facts


def _visual(shape: Any) -> dict[str, Any]:
    facts: dict[str, Any] = {"type": type(shape).__name__}
    facts |= {name: _plain(getattr(shape, name)) for name in _VISUAL if hasattr(shape, name)}
    facts["parts"] = [
        {
            "vertices": _plain(part.vertices),
            "triangles": _plain(part.triangles),
            "normals": _plain(part.get_vertex_normal()),
            "uvs": _plain(part.get_vertex_uv()),
            "material": _material(part.material),
        }
        for part in shape.parts
    ]
    return facts


def _material(material: Any) -> dict[str, Any]:
    facts: dict[str, Any] = {name: _plain(getattr(material, name)) for name in _MATERIAL}
    for name in _TEXTURES:
        texture = getattr(material, f"{name}_texture")
        facts[f"{name}_texture"] = None if texture is None else {key: _plain(getattr(texture, key)) for key in _TEXTURE}
    return facts


def _plain(value: Any) -> Any:
    if hasattr(value, "__getstate__") and type(value).__name__ == "Pose":
        value = np.array(value.__getstate__(), dtype=np.float32)
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return (value.shape, value.dtype.str, value.tobytes(), value.tolist() if value.size < 8 else "…")
    if isinstance(value, float):
        return (np.float64(value).tobytes(), value)
    return value


def _differences(where: str, a: Any, b: Any) -> list[str]:
    match a, b:
        case dict(), dict() if a.keys() == b.keys():
            return [line for key in a for line in _differences(f"{where}.{key}", a[key], b[key])]
        case list(), list() if len(a) == len(b):
            pairs = enumerate(zip(a, b, strict=True))
            return [line for i, (x, y) in pairs for line in _differences(f"{where}[{i}]", x, y)]
        case (str(), dict()), (str(), dict()):
            return _differences(f"{where}({a[0]})", a[1], b[1])
        case _:
            return [] if a == b else [f"{where}: {a!r} against {b!r}"]
