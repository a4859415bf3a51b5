"""What of a USD stage no reader reads, so that nothing is lost silently."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from scenecc.importers.usd_frames import Prim
    from scenecc.importers.usd_stage import UsdStage

_VENDOR: Final = re.compile(r"(physx|newton|mjc|mjcf|state|isaac|omniphysics)[A-Za-z]*:")
"""Namespaces of schemas for simulation that usd-core does not have."""

_READ: Final = re.compile(
    r"physxRigidBody:(disableGravity|linearDamping|angularDamping|max\w+Velocity|maxContactImpulse|sleepThreshold"
    r"|solver\w+IterationCount|locked\w+Axis)"
    r"|physxCollision:(contact|rest)Offset|physxJoint:(jointFriction|armature|maxJointVelocity)"
    r"|physxArticulation:(enabledSelfCollisions|solver\w+IterationCount)|physxScene:timeStepsPerSecond"
)
"""Attributes of PhysX's schema that the readers take."""

_SOFT: Final = re.compile(r"Deformable|Particle|Cloth|Vehicle|Tendon|SurfaceVelocity|ForceAPI|MimicJoint|Gear")
"""Schemas that make a stage move in other ways than by bodies and joints."""


def report_unread(stage: UsdStage) -> None:
    """Tells of prims, schemas, animations and attributes that the scene does not hold."""
    attributes: dict[str, list[Prim]] = {}
    for prim in stage.prims():
        info = prim.GetPrimTypeInfo()
        name = str(info.GetTypeName())
        schemas = [str(each) for each in info.GetAppliedAPISchemas()]
        soft = next((each for each in (name, *schemas) if _SOFT.search(each)), None)
        if soft is not None:
            stage.lose("soft-bodies", f"`{soft}`", prim)
        elif prim.IsA(stage.geom.PointInstancer):
            stage.lose("point-instancers", "a `PointInstancer`", prim)
        elif name and prim.GetPrimDefinition() is not None and info.GetSchemaType().isUnknown:
            stage.lose("unknown-prims", f"a prim of the type `{name}`, which usd-core does not know", prim)
        if prim.IsA(stage.geom.Xformable) and stage.geom.Xformable(prim).TransformMightBeTimeVarying():
            stage.lose("animations", "a motion over time, of which the first pose is taken", prim)
        for each in prim.GetAuthoredAttributes():
            label = str(each.GetName())
            if _VENDOR.match(label) and not _READ.fullmatch(label):
                attributes.setdefault(label, []).append(prim)
    for label, prims in attributes.items():
        stage.lose("vendor-attributes", f"`{label}` of {len(prims)} prims", prims[0])
