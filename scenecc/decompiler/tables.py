"""Properties to read from each SAPIEN class; a test compares these tables with the classes."""

from __future__ import annotations

_BODY = (
    "is_enabled",
    "auto_compute_mass",
    "mass",
    "cmass_local_pose",
    "inertia",
    "disable_gravity",
    "linear_damping",
    "angular_damping",
    "linear_velocity",
    "angular_velocity",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
)
_JOINT = ("is_enabled", "pose_in_parent", "pose_in_child")
_LIGHT = ("is_enabled", "local_pose", "color", "shadow", "shadow_near", "shadow_far", "shadow_map_size")

COMPONENTS: dict[str, tuple[str, ...]] = {
    "PhysxRigidStaticComponent": ("is_enabled",),
    "PhysxRigidDynamicComponent": (
        *_BODY,
        "kinematic",
        "locked_motion_axes",
        "sleep_threshold",
        "solver_position_iterations",
        "solver_velocity_iterations",
        "is_sleeping",
    ),
    "PhysxArticulationLinkComponent": (*_BODY, "is_root", "index", "sleeping"),
    "PhysxDriveComponent": (
        *_JOINT,
        "drive_target",
        "drive_velocity_target",
        *(f"limit_{axis}" for axis in ("x", "y", "z", "twist", "cone", "pyramid")),
        *(f"drive_property_{axis}" for axis in ("x", "y", "z", "twist", "swing", "slerp")),
    ),
    "PhysxGearComponent": (*_JOINT, "gear_ratio", "is_hinges_enabled"),
    "PhysxDistanceJointComponent": _JOINT,
    "RenderBodyComponent": ("is_enabled", "visibility", "shading_mode", "is_render_id_disabled"),
    "RenderCameraComponent": (
        "is_enabled",
        "local_pose",
        "width",
        "height",
        "near",
        "far",
        "fx",
        "fy",
        "cx",
        "cy",
        "skew",
        "mode",
        "ortho_left",
        "ortho_right",
        "ortho_bottom",
        "ortho_top",
    ),
    "RenderPointLightComponent": _LIGHT,
    "RenderDirectionalLightComponent": (*_LIGHT, "shadow_half_size"),
    "RenderSpotLightComponent": (*_LIGHT, "inner_fov", "outer_fov"),
    "RenderTexturedLightComponent": (*_LIGHT, "inner_fov", "outer_fov"),
    "RenderParallelogramLightComponent": (*_LIGHT, "half_width", "half_height", "angle"),
}
"""Properties of each component class. If a class has only a getter (`get_limit_x`), the getter is called."""

ARTICULATION = (
    "dof",
    "root_pose",
    "root_linear_velocity",
    "root_angular_velocity",
    "qpos",
    "qvel",
    "qf",
    "qlimits",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "sleep_threshold",
)
JOINT = ("type", "dof", "pose_in_parent", "pose_in_child")
AXIS = (
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
"""Properties of an active joint; SAPIEN has none of these for a fixed joint."""

_SHAPE = (
    "local_pose",
    "density",
    "collision_groups",
    "contact_offset",
    "rest_offset",
    "patch_radius",
    "min_patch_radius",
)
SHAPES: dict[str, tuple[str, ...]] = {
    "PhysxCollisionShapeBox": ("half_size", *_SHAPE),
    "PhysxCollisionShapeSphere": ("radius", *_SHAPE),
    "PhysxCollisionShapeCapsule": ("radius", "half_length", *_SHAPE),
    "PhysxCollisionShapeCylinder": ("radius", "half_length", *_SHAPE),
    "PhysxCollisionShapePlane": _SHAPE,
    "PhysxCollisionShapeConvexMesh": ("scale", "vertices", "triangles", *_SHAPE),
    "PhysxCollisionShapeTriangleMesh": ("scale", "vertices", "triangles", *_SHAPE),
}
PHYSICAL_MATERIAL = ("static_friction", "dynamic_friction", "restitution")
VISUALS: dict[str, tuple[str, ...]] = {
    "RenderShapeBox": ("half_size",),
    "RenderShapeSphere": ("radius",),
    "RenderShapeCapsule": ("radius", "half_length"),
    "RenderShapeCylinder": ("radius", "half_length"),
    "RenderShapePlane": ("scale",),
    "RenderShapeTriangleMesh": ("filename", "scale"),
}
VISUAL = ("local_pose", "front_face")
VISUAL_MATERIAL = (
    "base_color",
    "emission",
    "specular",
    "roughness",
    "metallic",
    "transmission",
    "ior",
    "transmission_roughness",
)
TEXTURES = ("base_color", "normal", "roughness", "metallic", "emission", "transmission")
TEXTURE = ("filename", "mipmap_levels", "filter_mode", "address_mode", "is_srgb", "width", "height", "format")
