"""The plan: frozen, engine-free data between the compiler and everything that consumes a scene.

SI units, names resolved, poses composed, one entry a logical object with values per scene as arrays.
"""

from scenecc.plan.body import BodyStructure, BodyType, CollisionShape, Inertial, VisualShape
from scenecc.plan.geometry import (
    Box,
    Capsule,
    CoacdParams,
    CollisionGeometry,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Mesh,
    MeshGeometry,
    Plane,
    Sphere,
    TiledPlane,
    TriangleMesh,
    VisualGeometry,
    VisualPlane,
)
from scenecc.plan.material import AssetFile, Friction, PhysicalMaterial, Texture, VisualMaterial
from scenecc.plan.physics import GpuMemory, Physics, SdfConfig
from scenecc.plan.scene import Entity, ScenePlan
from scenecc.plan.value import Value, constant, literal, per_scene, recalled, varying

__all__ = [
    "AssetFile",
    "BodyStructure",
    "BodyType",
    "Box",
    "Capsule",
    "CoacdParams",
    "CollisionGeometry",
    "CollisionShape",
    "ConvexMesh",
    "ConvexParts",
    "Cylinder",
    "Entity",
    "Friction",
    "GpuMemory",
    "Inertial",
    "Mesh",
    "MeshGeometry",
    "PhysicalMaterial",
    "Physics",
    "Plane",
    "ScenePlan",
    "SdfConfig",
    "Sphere",
    "Texture",
    "TiledPlane",
    "TriangleMesh",
    "Value",
    "VisualGeometry",
    "VisualMaterial",
    "VisualPlane",
    "VisualShape",
    "constant",
    "literal",
    "per_scene",
    "recalled",
    "varying",
]
