"""Replaces the point instancers of a stage by their instances, so that all other readers see prims."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from scenecc.importers.usd_stage import Prim, UsdStage


_HALF: Final = 1e-3
"""Bound of the error of a rotation from a quaternion in half precision."""

_MAX_DEPTH: Final = 100
"""Maximum depth of an instancer; one that contains itself has none."""


def expand_instancers(stage: UsdStage, limit: int) -> None:
    """Makes each instance an Xform with a reference to its prototype, in the stage's session layer, which is no file.

    `limit`: maximum number of instances; further instancers, and invalid ones, are losses.
    """
    layer = stage.stage.GetSessionLayer()
    while found := [prim for prim in stage.prims() if prim.IsA(stage.geom.PointInstancer)]:
        for prim, instances in [(prim, _instances(stage, prim)) for prim in found]:
            if not (prim and prim.IsActive()):  # in a prototype of one that is replaced
                continue
            if prim.IsInstanceProxy():  # which nothing can override
                above = prim
                while above.IsInstanceProxy():
                    above = above.GetParent()
                _over(layer, above).instanceable = False
                break
            limit -= len(instances)
            if instances and limit >= 0 and prim.GetPath().pathElementCount <= _MAX_DEPTH:
                _report_losses(stage, prim)
                _replace(layer, prim, instances)
            else:
                stage.lose("point-instancers", "a `PointInstancer` that is invalid, empty or too large", prim)
                _over(layer, prim).SetInfo("active", False)  # noqa: FBT003 - no keyword


def _over(layer: Any, prim: Prim) -> Any:
    return import_module("pxr.Sdf").CreatePrimInLayer(layer, prim.GetPath())


def _instances(stage: UsdStage, prim: Prim) -> list[tuple[Any, Any]]:
    """Returns the path of the prototype, and the matrix in the instancer's frame, of each visible instance."""
    instancer, whole = stage.geom.PointInstancer(prim), prim.GetPath()
    samples = instancer.GetPositionsAttr().GetTimeSamples()
    time = stage.usd.TimeCode(samples[0]) if samples else stage.usd.TimeCode.Default()
    rows, paths = instancer.GetProtoIndicesAttr(), instancer.GetPrototypesRel().GetForwardedTargets()
    indices: list[int] = [*(rows.Get(time) or ())] if rows.GetTypeName() == "int[]" else []
    how = instancer.ExcludeProtoXform, instancer.IgnoreMask
    matrices: list[Any] = [*instancer.ComputeInstanceTransformsAtTime(time, time, *how)] if indices else []
    mask = instancer.ComputeMaskAtTime(time) or [True] * len(indices)
    scales = instancer.GetScalesAttr().Get(time) or [(1, 1, 1)] * len(indices)
    turns = instancer.GetOrientationsAttr().Get(time) or indices
    known = (0 <= k < len(paths) and stage.prim(paths[k]) and not whole.HasPrefix(paths[k]) for k in indices)
    if not all(known) or {*map(len, (matrices, mask, scales, turns))} != {len(indices)}:
        return []
    found = zip(indices, map(_without_rounding, matrices, scales), mask, strict=True)
    return [(paths[index], matrix) for index, matrix, seen in found if seen]


def _without_rounding(matrix: Any, scale: Any) -> Any:
    """Returns a matrix without the stretch of a quaternion in half precision, which is 0.02 % too short or long."""
    if not all(scale):
        return matrix
    gf: Any = import_module("pxr.Gf")
    turn = gf.Matrix4d().SetScale(gf.Vec3d(*(1 / each for each in scale))) * matrix
    near = turn.GetOrthonormalized(False)  # noqa: FBT003 - without a warning; there is no keyword
    return gf.Matrix4d().SetScale(gf.Vec3d(*scale)) * near if gf.IsClose(turn, near, _HALF) else matrix


def _report_losses(stage: UsdStage, prim: Prim) -> None:
    of_motion = [stage.authored(prim, name) for name in ("velocities", "angularVelocities", "accelerations")]
    of_poses = [prim.GetAttribute(name) for name in ("positions", "orientations", "scales", "protoIndices")]
    if any(of_motion) or any(each.ValueMightBeTimeVarying() for each in of_poses):
        stage.lose("animations", "the motion of instances; the first poses are used", prim)
    for each in stage.geom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
        if each.GetInterpolation() != stage.geom.Tokens.constant:
            stage.lose("material-looks", f"`{each.GetPrimvarName()}` of each instance", prim)


def _replace(layer: Any, prim: Prim, instances: list[tuple[Any, Any]]) -> None:
    sdf: Any = import_module("pxr.Sdf")
    with sdf.ChangeBlock():
        whole = _over(layer, prim)
        whole.typeName = "Xform"
        for child in prim.GetAllChildren():
            _over(layer, child).SetInfo("active", False)  # noqa: FBT003 - no keyword
        for number, (prototype, matrix) in enumerate(instances):
            one = sdf.PrimSpec(whole, f"{prototype.name}_{number}", sdf.SpecifierDef, "Xform")
            sdf.AttributeSpec(one, "xformOp:transform", sdf.ValueTypeNames.Matrix4d).default = matrix
            order = sdf.AttributeSpec(one, "xformOpOrder", sdf.ValueTypeNames.TokenArray, sdf.VariabilityUniform)
            order.default = ["xformOp:transform"]
            inner = sdf.PrimSpec(one, prototype.name, sdf.SpecifierDef)
            inner.referenceList.prependedItems = [sdf.Reference("", prototype)]
            inner.SetInfo("active", True)  # noqa: FBT003 - no keyword
