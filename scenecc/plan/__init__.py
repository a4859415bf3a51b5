"""The plan: frozen, engine-free data between the compiler and everything that consumes a scene.

SI units, names resolved, poses composed, one entry a logical object with values per scene as arrays.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from scenecc.plan.body import (
    AssetFile,
    BodyStructure,
    BodyType,
    CollisionShape,
    Friction,
    Inertial,
    Mount,
    NamedFile,
    PhysicalMaterial,
    Texture,
    VisualMaterial,
    VisualShape,
)
from scenecc.plan.geometry import (
    Box,
    Capsule,
    CoacdParams,
    CollisionGeometry,
    Cone,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Heightfield,
    Mesh,
    MeshGeometry,
    Plane,
    Ring,
    Sphere,
    TiledPlane,
    TriangleMesh,
    VisualGeometry,
    VisualPlane,
)
from scenecc.plan.scene import Entity, GpuMemory, Physics, ScenePlan, SdfConfig
from scenecc.plan.value import Value, constant, literal, per_scene, recalled, varying

if TYPE_CHECKING:
    from scenecc.plan.articulation import ArticulationStructure, DriveMode, Joint, JointType, Link, Mimic
    from scenecc.plan.constraint import (
        AxisDrive,
        AxisLimit,
        Connection,
        Constraint,
        Distance,
        Drive,
        DriveAxis,
        Gear,
        LimitAxis,
        Weld,
    )
    from scenecc.plan.placement import Nearness, Placement
    from scenecc.plan.rendering import (
        AreaLight,
        Camera,
        CubeMap,
        DirectionalLight,
        Environment,
        Intrinsic,
        Light,
        Orthographic,
        Perspective,
        PointLight,
        Shadow,
        SkyMap,
        SpotLight,
        TexturedLight,
    )

__all__ = [
    "AreaLight",
    "ArticulationStructure",
    "AssetFile",
    "AxisDrive",
    "AxisLimit",
    "BodyStructure",
    "BodyType",
    "Box",
    "Camera",
    "Capsule",
    "CoacdParams",
    "CollisionGeometry",
    "CollisionShape",
    "Cone",
    "Connection",
    "Constraint",
    "ConvexMesh",
    "ConvexParts",
    "CubeMap",
    "Cylinder",
    "DirectionalLight",
    "Distance",
    "Drive",
    "DriveAxis",
    "DriveMode",
    "Entity",
    "Environment",
    "Friction",
    "Gear",
    "GpuMemory",
    "Heightfield",
    "Inertial",
    "Intrinsic",
    "Joint",
    "JointType",
    "Light",
    "LimitAxis",
    "Link",
    "Mesh",
    "MeshGeometry",
    "Mimic",
    "Mount",
    "NamedFile",
    "Nearness",
    "Orthographic",
    "Perspective",
    "PhysicalMaterial",
    "Physics",
    "Placement",
    "Plane",
    "PointLight",
    "Ring",
    "ScenePlan",
    "SdfConfig",
    "Shadow",
    "SkyMap",
    "Sphere",
    "SpotLight",
    "Texture",
    "TexturedLight",
    "TiledPlane",
    "TriangleMesh",
    "Value",
    "VisualGeometry",
    "VisualMaterial",
    "VisualPlane",
    "VisualShape",
    "Weld",
    "constant",
    "literal",
    "per_scene",
    "recalled",
    "varying",
]

_LATER = {
    name: module
    for module, names in {
        "articulation": "ArticulationStructure DriveMode Joint JointType Link Mimic",
        "constraint": "AxisDrive AxisLimit Connection Constraint Distance Drive DriveAxis Gear LimitAxis Weld",
        "placement": "Nearness Placement",
        "rendering": (
            "AreaLight Camera CubeMap DirectionalLight Environment Intrinsic Light Orthographic Perspective PointLight "
            "Shadow SkyMap SpotLight TexturedLight"
        ),
    }.items()
    for name in names.split()
}
"""What most scenes have nothing of, and its module, which is loaded when the name is first asked for."""


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
    return found
