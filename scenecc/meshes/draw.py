"""Bodies as shapes that can be drawn: what is seen of them, or what of them collides."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from scenecc.meshes import primitives
from scenecc.meshes.files import MeshFiles
from scenecc.meshes.looks import Looks
from scenecc.meshes.surface import Look, MeshProblem, Part, Shape
from scenecc.plan import Box, Capsule, Cylinder, Mesh, Sphere, TiledPlane, VisualPlane
from scenecc.plan.pictured import COLLISION_COLORS
from scenecc.plan.pose import IDENTITY_POSE, Pose7

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Origin
    from scenecc.meshes.surface import Surface, Vec3
    from scenecc.plan import BodyStructure, ScenePlan, VisualShape
    from scenecc.plan.measured import MeasuredBody, MeasuredShape

_COLLISION_LOOKS: Final = {kind: Look(base_color=color) for kind, color in COLLISION_COLORS.items()}

_SIZES: Final[dict[type, Callable[[Any, int], tuple[Any, ...]]]] = {
    Box: lambda g, row: (primitives.box(), tuple(g.half_size.row(row))),
    Sphere: lambda g, row: (primitives.sphere(), (g.radius.row(row),) * 3),
    Cylinder: lambda g, row: (
        primitives.cylinder(),
        (g.half_length.row(row), g.radius.row(row), g.radius.row(row)),
    ),
    VisualPlane: lambda g, row: (primitives.plane(), (1.0, *g.half_size.row(row))),
}
"""Primitives that are one surface, scaled."""


class Drawer:
    """Draws the bodies of a plan. What several shapes have in common is one object, files are read once."""

    def __init__(self, plan: ScenePlan, told: Callable[[MeshProblem, Origin | None], None]) -> None:
        """`told` takes what is left out, each once, and the shape that first had it."""
        self._plan = plan
        self._now: Origin | None = None
        self._looks = Looks(plan, lambda problem: told(problem, self._now))
        self._files = MeshFiles()
        self._sized: dict[tuple[float, ...], Surface] = {}
        self._meshes: dict[str, Surface] = {}
        self._flat: dict[Surface, Surface] = {}

    def visuals(self, body: BodyStructure, row: int) -> tuple[Shape, ...]:
        """What is seen of a body in a row of its entity; nothing where its visibility is 0.

        Raises:
            MeshProblem: a file cannot be shown, or a package is missing. `Drawer.at` is the shape that has it.
        """
        visibility = 1.0 if body.visibility is None else float(body.visibility.row(row))
        if visibility == 0:
            return ()
        flat = body.shading_mode is not None and int(body.shading_mode.row(row)) == 1
        return tuple(self._visual(shape, row, visibility, flat=flat) for shape in body.visuals)

    def collisions(self, body: MeasuredBody) -> tuple[Shape, ...]:
        """The colliding shapes of a body, meshes as they were cooked."""
        return tuple(self.collision(shape, body) for shape in body.shapes)

    @property
    def at(self) -> Origin | None:
        """The shape that was drawn last."""
        return self._now

    def _visual(self, shape: VisualShape, row: int, visibility: float, *, flat: bool) -> Shape:
        self._now = shape.origin
        own = None if shape.material is None else self._looks.look(shape.material, row)
        parts, scale = self._parts(shape.geometry, row, own)
        if visibility != 1 or flat:
            shown = [self._shaded(part.surface, flat=flat) for part in parts]
            looks = [replace(part.look, visibility=visibility) for part in parts]
            parts = tuple(map(Part, shown, looks))
        mirrored = isinstance(shape.geometry, Mesh) and scale[0] * scale[1] * scale[2] < 0
        turned = shape.front_face is not None and (shape.front_face == "clockwise") != mirrored
        pose = IDENTITY_POSE if shape.pose is None else _pose(shape.pose.row(row))
        kind = _WORDS[type(shape.geometry)]
        return Shape(shape.name or "", kind, parts, pose, scale, turned, origin=shape.origin)

    def _parts(self, geometry: Any, row: int, own: Look | None) -> tuple[tuple[Part, ...], Vec3]:
        """A geometry's surfaces and looks, and its scale."""
        if isinstance(geometry, Mesh):
            parts = self._files.parts(self._plan.files[int(geometry.file.row(row))])
            if own is not None:
                parts = tuple(Part(part.surface, own) for part in parts)
            return parts, _vec3(geometry.scale.row(row))
        look = own or Look()
        if isinstance(geometry, Capsule):
            capsule = self._capsule(float(geometry.radius.row(row)), float(geometry.half_length.row(row)))
            return (Part(capsule, look),), (1.0, 1.0, 1.0)
        if isinstance(geometry, TiledPlane):
            u, v = map(float, geometry.texture_repeat.row(row))
            x, y = map(float, geometry.half_size.row(row))
            return (Part(primitives.tiled_plane((u, v)), look),), (x, y, 1.0)
        surface, scale = _SIZES[type(geometry)](geometry, row)
        return (Part(surface, look),), _vec3(scale)

    def _capsule(self, radius: float, half_length: float) -> Surface:
        key = (radius, half_length)
        if key not in self._sized:
            self._sized[key] = primitives.capsule(radius, half_length)
        return self._sized[key]

    def _shaded(self, surface: Surface, *, flat: bool) -> Surface:
        return self._flat.setdefault(surface, replace(surface, normals=None)) if flat else surface

    def collision(self, shape: MeasuredShape, body: MeasuredBody) -> Shape:
        """One of them."""
        scale: Vec3 = (1.0, 1.0, 1.0)
        match shape.kind, shape.sizes:
            case "box", (x, y, z):
                surface, scale = primitives.box(), (x, y, z)
            case "sphere", (radius,):
                surface, scale = primitives.sphere(), (radius, radius, radius)
            case "capsule", (radius, half_length):
                surface = self._capsule(radius, half_length)
            case "cylinder", (radius, half_length):
                surface, scale = primitives.cylinder(), (half_length, radius, radius)
            case "plane", _:
                surface = primitives.plane()
            case _:
                surface = self._cooked(shape)
        parts = (Part(surface, _COLLISION_LOOKS[body.body_type]),)
        endless = shape.kind == "plane"
        return Shape("", shape.kind, parts, shape.pose, scale, endless=endless, origin=shape.shape.origin)

    def _cooked(self, shape: MeasuredShape) -> Surface:
        mesh = shape.mesh
        assert mesh is not None  # of every shape that is no primitive
        if mesh.digest not in self._meshes:
            self._meshes[mesh.digest] = primitives.surface(mesh.vertices, mesh.triangles, None, None)
        return self._meshes[mesh.digest]


_WORDS: Final = {
    Box: "box",
    Sphere: "sphere",
    Capsule: "capsule",
    Cylinder: "cylinder",
    VisualPlane: "plane",
    TiledPlane: "tiled_plane",
    Mesh: "mesh",
}


def _pose(row: Any) -> Pose7:
    x, y, z, qw, qx, qy, qz = map(float, row)
    return x, y, z, qw, qx, qy, qz


def _vec3(row: Any) -> Vec3:
    x, y, z = map(float, row)
    return x, y, z
