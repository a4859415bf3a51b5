"""Content of a USD stage that is not imported, which is a loss, and attributes of the wrong type, which are errors."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Location

if TYPE_CHECKING:
    from collections.abc import Collection

    from scenecc.diagnostics import Sink
    from scenecc.importers.usd_stage import Prim, UsdStage

_VENDOR: Final = re.compile(r"(physx|newton|mjc|mjcf|state|isaac|omniphysics)[A-Za-z]*:")
"""Namespaces of simulation schemas that usd-core does not have."""

_OF_OTHERS: Final = re.compile(
    r"physxMaterial:(\w+CombineMode|compliantContact\w+)|physxMimicJoint:\w+:referenceJointAxis|physxSurfaceVelocity:\w+"
)
"""Other attributes that are read, that follow from those that are, or whose schema is reported."""

_SOFT: Final = re.compile(r"Deformable|Particle|Cloth|Vehicle|Tendon|ForceAPI|Gear")
"""Schemas for dynamics other than rigid bodies and joints."""


def report_unread(stage: UsdStage, mimics: Collection[str]) -> None:
    """Reports unsupported prims, schemas, animations and attributes. `mimics`: paths of joints that follow another."""
    attributes: dict[str, list[Prim]] = {}
    for prim in stage.prims():
        info = prim.GetPrimTypeInfo()
        name = str(info.GetTypeName())
        schemas = [str(each) for each in info.GetAppliedAPISchemas()]
        soft = next((each for each in (name, *schemas) if _SOFT.search(each)), None)
        if soft is not None:
            stage.lose("soft-bodies", f"`{soft}`", prim)
        elif any("Mimic" in each for each in schemas) and str(prim.GetPath()) not in mimics:
            words = "a joint that follows one of several freedoms or of another articulation, or not by PhysX's schema"
            stage.lose("joint-couplings", words, prim)
        elif any("SurfaceVelocity" in each for each in schemas):
            stage.lose("moving-surfaces", "the velocity of a surface; rollers with a `velocity_target` convey", prim)
        elif name and prim.GetPrimDefinition() is not None and info.GetSchemaType().isUnknown:
            stage.lose("unknown-prims", f"a prim of type `{name}`, which is unknown to usd-core", prim)
        if prim.IsA(stage.geom.Xformable) and stage.geom.Xformable(prim).TransformMightBeTimeVarying():
            stage.lose("animations", "an animated transform; the first pose is used", prim)
        _report_missing_materials(stage, prim)
        for each in prim.GetAuthoredAttributes():
            label = str(each.GetName())
            if _VENDOR.match(label) and not _READ_OF_PHYSX.fullmatch(label) and not _OF_OTHERS.fullmatch(label):
                attributes.setdefault(label, []).append(prim)
    for label, prims in attributes.items():
        stage.lose("vendor-attributes", f"`{label}` of {len(prims)} prims", prims[0])


def _report_missing_materials(stage: UsdStage, prim: Prim) -> None:
    for name, kind in (("material:binding:physics", "contact-materials"), ("material:binding", "material-looks")):
        binding = prim.GetRelationship(name)
        for target in binding.GetTargets() if binding else ():
            found = stage.prim(target)
            if not (found and found.IsA(stage.shade.Material)):
                stage.lose(kind, f"the material `{target}`, which is missing or no `Material`", prim)


_READ_OF_PHYSX: Final = re.compile(
    r"physxRigidBody:(disableGravity|linearDamping|angularDamping|max\w+Velocity|maxContactImpulse|sleepThreshold"
    r"|solver\w+IterationCount|locked\w+Axis)"
    r"|physxCollision:(contact|rest)Offset|physxJoint:(jointFriction|armature|maxJointVelocity)"
    r"|physxMimicJoint:\w+:(gearing|offset)|physxJointAxis:\w+:dynamicFrictionEffort|mjc:frictionloss"
    r"|physxArticulation:(enabledSelfCollisions|solver\w+IterationCount)|physxScene:timeStepsPerSecond"
)
"""Supported attributes of the schemas of PhysX and MuJoCo. Each is a number or a boolean."""

_OF_LOOKS: Final = {
    **dict.fromkeys(("diffuseColor", "emissiveColor", "diffuse_color_constant"), "GfVec3"),
    **dict.fromkeys(("roughness", "metallic", "opacity", "ior"), "number"),
    **dict.fromkeys(("reflection_roughness_constant", "metallic_constant"), "number"),
    **dict.fromkeys(("file", "diffuse_texture"), "SdfAssetPath"),
}
"""Shader inputs, which no prim schema declares."""

_NUMBER: Final = re.compile(r"\b(bool|u?int(64)?|unsigned \w+|(pxr_half::)?half|float|double)\b")
_PRECISION: Final = re.compile(r"(?<=\d)[fdhi]\b|(?<=Quat)[fdh]\b")
_TEXT: Final = re.compile(r"\b(TfToken|string)\b")


def check_attribute_types(stage: UsdStage, sink: Sink) -> None:
    """Reports attributes of the wrong type (SC430), such as numbers where text is expected."""
    for prim in stage.prims():
        is_shader = prim.IsA(stage.shade.Shader)
        definition = prim.GetPrimDefinition()
        for attribute in prim.GetAuthoredAttributes():
            name = str(attribute.GetName())
            declared = definition.GetSchemaAttributeSpec(name)
            if declared is not None:
                wanted = _type_family(declared.typeName.type)
            elif _READ_OF_PHYSX.fullmatch(name):
                wanted = "number"
            else:
                wanted = _OF_LOOKS.get(name.removeprefix("inputs:")) if is_shader else None
            found = {_type_family(each.typeName.type) for each in attribute.GetPropertyStack(stage.time)}
            if wanted is not None and (wrong := found - {wanted}):
                message = f"`{name}` of {prim.GetPath()} has type `{wrong.pop()}`, not `{wanted}`"
                sink.report("SC430", message, Location(str(stage.path)))


def _type_family(kind: Any) -> str:
    """Returns the name of a usd-core type without its numeric precision."""
    return _TEXT.sub("text", _PRECISION.sub("", _NUMBER.sub("number", str(kind.typeName))))
