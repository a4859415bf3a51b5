"""Geoms: colliding ones in group 3, and what is seen, which collides with nothing, in group 0."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.emit.mjcf.looks import write_look
from scenecc.emit.xml import frames
from scenecc.emit.xml.frames import Z_TO_X
from scenecc.emit.xml.meshes import obj
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.meshes import baked
from scenecc.plan import Box, Capsule, Cylinder, Sphere, VisualPlane

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.emit.mjcf.model import Model
    from scenecc.emit.xml.elements import Element
    from scenecc.meshes import Baked, Shape
    from scenecc.plan import BodyStructure, VisualGeometry
    from scenecc.plan.snapshot import MeasuredBody, MeasuredMesh, MeasuredShape

COLLIDING, SEEN = 3, 0

_GRID = 1.0
"""Distance of the lines that a plane is drawn with [m]."""

_OF_A_SHAPE = ("contact_offset", "rest_offset", "patch_radius", "min_patch_radius")


def write_collisions(model: Model, name: str, body: MeasuredBody, element: Element) -> None:
    """A geom for each colliding shape of the engine, without a mass of its own."""
    for shape in body.shapes:
        pose, attributes = _colliding(model, name, shape)
        bits, mask, _, _ = map(_signed, shape.groups)
        element.add(
            "geom",
            name=model.name("geom", f"{element.attributes['name']}/collision"),
            **attributes,
            **placed(pose),
            contype=None if bits == 1 else bits,
            conaffinity=None if mask == 1 else mask,
            friction=(shape.dynamic_friction,),
            group=COLLIDING,
        )
        _tell(model, name, shape)


def _colliding(model: Model, name: str, shape: MeasuredShape) -> tuple[Pose7, dict[str, Any]]:
    """The pose of a geom and what it is."""
    upright = frames.compose(shape.pose, Z_TO_X)
    match shape.kind, shape.mesh:
        case "box" | "sphere", _:
            return shape.pose, {"type": shape.kind, "size": shape.sizes}
        case "capsule" | "cylinder", _:
            return upright, {"type": shape.kind, "size": shape.sizes}
        case "plane", _:
            return upright, {"type": "plane", "size": (0, 0, _GRID)}
        case _, mesh:
            assert mesh is not None  # of every shape that is no primitive
            if shape.kind == "triangle_mesh":
                words = "a triangle mesh collides as its convex hull, as all meshes in MuJoCo"
                model.lost.change(name, words, shape.shape.origin)
            return shape.pose, {"type": "mesh", "mesh": cooked(model, name, mesh)}


def cooked(model: Model, name: str, mesh: MeasuredMesh) -> str:
    """The mesh asset of a cooked mesh."""
    return _mesh_asset(model, f"{name}_collision", obj(mesh.vertices, mesh.triangles))


def _tell(model: Model, name: str, shape: MeasuredShape) -> None:
    plan, lost = shape.shape, model.lost
    lost.fields(name, plan, _OF_A_SHAPE, plan.origin, " of a shape")
    if plan.material is None:
        return
    if shape.static_friction != shape.dynamic_friction:
        words = "`static_friction` is that of movement: MuJoCo has one coefficient"
        lost.change(name, words, plan.origin)
    if shape.restitution:
        lost.leave_out(name, "`restitution` of a shape", plan.origin)


def write_visuals(model: Model, name: str, row: int, body: BodyStructure, element: Element, *, held: bool) -> None:
    """Geoms for all that is seen of a body. `held`: whether nothing moves it. Raises MeshProblem."""
    for shape, plan in zip(model.drawer.visuals(body, row), body.visuals, strict=False):
        parts = baked(shape)
        native = None if parts[0].look.base_color_image else _native(plan.geometry, row, held=held)
        if native is not None:
            turn, attributes = native
            _write_seen(
                model, name, shape, {**attributes, **placed(frames.compose(shape.pose, turn))}, parts[0], element
            )
            continue
        for part in parts:
            data = obj(part.vertices, part.faces, part.uvs if part.look.base_color_image else None)
            mesh = _mesh_asset(model, shape.name or name, data)
            _write_seen(model, name, shape, {"type": "mesh", "mesh": mesh, **placed(shape.pose)}, part, element)


def _native(geometry: VisualGeometry, row: int, *, held: bool) -> tuple[Pose7, dict[str, Any]] | None:
    """A geom's own type for what is seen, and how it is turned there; None: it is drawn of triangles."""
    match geometry:
        case Box(half_size=size):
            return IDENTITY_POSE, {"type": "box", "size": size.row(row)}
        case Sphere(radius=radius):
            return IDENTITY_POSE, {"type": "sphere", "size": radius.row(row)}
        case Capsule(radius=radius, half_length=length) | Cylinder(radius=radius, half_length=length):
            kind = "capsule" if isinstance(geometry, Capsule) else "cylinder"
            return Z_TO_X, {"type": kind, "size": (radius.row(row), length.row(row))}
        case VisualPlane(half_size=size) if held:  # MuJoCo has planes on what does not move alone
            return Z_TO_X, {"type": "plane", "size": (*size.row(row), _GRID)}
        case _:
            return None


def _write_seen(
    model: Model, name: str, shape: Shape, attributes: dict[str, Any], part: Baked, element: Element
) -> None:
    element.add(
        "geom",
        name=model.name("geom", shape.name) if shape.name else None,
        **attributes,
        contype=0,
        conaffinity=0,
        group=SEEN,
        material=write_look(model, part.look, shape, name),
    )


def _mesh_asset(model: Model, stem: str, data: bytes) -> str:
    """The asset of a mesh's file; of files that hold the same, one. Its inertia is asked of nobody."""
    file = model.beside.add(stem, ".obj", data)
    name = file.removesuffix(".obj")
    if name not in model.meshes:
        model.meshes.add(name)
        model.sections["asset"].add("mesh", name=name, file=file, inertia="shell")
    return name


def placed(pose: Pose7) -> dict[str, Sequence[float] | None]:
    """A pose as attributes, those of the identity left out."""
    return {
        "pos": None if pose[:3] == IDENTITY_POSE[:3] else pose[:3],
        "quat": None if pose[3:] == IDENTITY_POSE[3:] else pose[3:],
    }


def _signed(bits: int) -> int:
    """32 bits as MuJoCo reads them."""
    return bits - (1 << 32) if bits >= 1 << 31 else bits
