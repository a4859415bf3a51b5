"""The plan: frozen data, independent of the engine, between the compiler and all consumers of a scene.

SI units, resolved names, composed poses. One entry per logical object, with arrays of values per scene.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from scenecc.plan.articulation import ArticulationStructure as ArticulationStructure
    from scenecc.plan.articulation import DriveMode as DriveMode
    from scenecc.plan.articulation import Joint as Joint
    from scenecc.plan.articulation import JointType as JointType
    from scenecc.plan.articulation import Link as Link
    from scenecc.plan.articulation import Mimic as Mimic
    from scenecc.plan.body import AssetFile as AssetFile
    from scenecc.plan.body import BodyStructure as BodyStructure
    from scenecc.plan.body import BodyType as BodyType
    from scenecc.plan.body import CollisionShape as CollisionShape
    from scenecc.plan.body import Friction as Friction
    from scenecc.plan.body import Inertial as Inertial
    from scenecc.plan.body import Mount as Mount
    from scenecc.plan.body import NamedFile as NamedFile
    from scenecc.plan.body import PhysicalMaterial as PhysicalMaterial
    from scenecc.plan.body import Texture as Texture
    from scenecc.plan.body import VisualMaterial as VisualMaterial
    from scenecc.plan.body import VisualShape as VisualShape
    from scenecc.plan.constraint import AxisDrive as AxisDrive
    from scenecc.plan.constraint import AxisLimit as AxisLimit
    from scenecc.plan.constraint import Connection as Connection
    from scenecc.plan.constraint import Constraint as Constraint
    from scenecc.plan.constraint import Distance as Distance
    from scenecc.plan.constraint import Drive as Drive
    from scenecc.plan.constraint import DriveAxis as DriveAxis
    from scenecc.plan.constraint import Gear as Gear
    from scenecc.plan.constraint import LimitAxis as LimitAxis
    from scenecc.plan.constraint import Weld as Weld
    from scenecc.plan.expect import BodyPair as BodyPair
    from scenecc.plan.expect import Condition as Condition
    from scenecc.plan.expect import NoOverlap as NoOverlap
    from scenecc.plan.expect import Reading as Reading
    from scenecc.plan.expect import Settled as Settled
    from scenecc.plan.geometry import Box as Box
    from scenecc.plan.geometry import Capsule as Capsule
    from scenecc.plan.geometry import CoacdParams as CoacdParams
    from scenecc.plan.geometry import CollisionGeometry as CollisionGeometry
    from scenecc.plan.geometry import Cone as Cone
    from scenecc.plan.geometry import ConvexMesh as ConvexMesh
    from scenecc.plan.geometry import ConvexParts as ConvexParts
    from scenecc.plan.geometry import Cylinder as Cylinder
    from scenecc.plan.geometry import Heightfield as Heightfield
    from scenecc.plan.geometry import Mesh as Mesh
    from scenecc.plan.geometry import MeshGeometry as MeshGeometry
    from scenecc.plan.geometry import Plane as Plane
    from scenecc.plan.geometry import Ring as Ring
    from scenecc.plan.geometry import Sphere as Sphere
    from scenecc.plan.geometry import TiledPlane as TiledPlane
    from scenecc.plan.geometry import TriangleMesh as TriangleMesh
    from scenecc.plan.geometry import VisualGeometry as VisualGeometry
    from scenecc.plan.geometry import VisualPlane as VisualPlane
    from scenecc.plan.placement import Nearness as Nearness
    from scenecc.plan.placement import NextTo as NextTo
    from scenecc.plan.placement import Placement as Placement
    from scenecc.plan.rendering import AreaLight as AreaLight
    from scenecc.plan.rendering import Camera as Camera
    from scenecc.plan.rendering import CubeMap as CubeMap
    from scenecc.plan.rendering import DirectionalLight as DirectionalLight
    from scenecc.plan.rendering import Environment as Environment
    from scenecc.plan.rendering import Intrinsic as Intrinsic
    from scenecc.plan.rendering import Light as Light
    from scenecc.plan.rendering import Orthographic as Orthographic
    from scenecc.plan.rendering import Perspective as Perspective
    from scenecc.plan.rendering import PointLight as PointLight
    from scenecc.plan.rendering import Shadow as Shadow
    from scenecc.plan.rendering import SkyMap as SkyMap
    from scenecc.plan.rendering import SpotLight as SpotLight
    from scenecc.plan.rendering import TexturedLight as TexturedLight
    from scenecc.plan.scene import Entity as Entity
    from scenecc.plan.scene import GpuMemory as GpuMemory
    from scenecc.plan.scene import Physics as Physics
    from scenecc.plan.scene import ScenePlan as ScenePlan
    from scenecc.plan.scene import SdfConfig as SdfConfig
    from scenecc.plan.scene import SettledStart as SettledStart
    from scenecc.plan.value import Value as Value
    from scenecc.plan.value import constant as constant
    from scenecc.plan.value import derived as derived
    from scenecc.plan.value import literal as literal
    from scenecc.plan.value import per_scene as per_scene
    from scenecc.plan.value import recalled as recalled
    from scenecc.plan.value import varying as varying

_MODULES: Final = {
    "articulation": "ArticulationStructure DriveMode Joint JointType Link Mimic",
    "body": (
        "AssetFile BodyStructure BodyType CollisionShape Friction Inertial Mount NamedFile PhysicalMaterial "
        "Texture VisualMaterial VisualShape"
    ),
    "constraint": "AxisDrive AxisLimit Connection Constraint Distance Drive DriveAxis Gear LimitAxis Weld",
    "expect": "BodyPair Condition NoOverlap Reading Settled",
    "geometry": (
        "Box Capsule CoacdParams CollisionGeometry Cone ConvexMesh ConvexParts Cylinder Heightfield Mesh "
        "MeshGeometry Plane Ring Sphere TiledPlane TriangleMesh VisualGeometry VisualPlane"
    ),
    "placement": "Nearness NextTo Placement",
    "rendering": (
        "AreaLight Camera CubeMap DirectionalLight Environment Intrinsic Light Orthographic Perspective "
        "PointLight Shadow SkyMap SpotLight TexturedLight"
    ),
    "scene": "Entity GpuMemory Physics ScenePlan SdfConfig SettledStart",
    "value": "Value constant derived literal per_scene recalled varying",
}
"""Names by module. A module is loaded when one of its names is first accessed."""

_HOME: Final = {name: module for module, names in _MODULES.items() for name in names.split()}

__all__ = [*_HOME]  # noqa: PLE0604  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    return found
