"""Lowers shapes and their geometry. Each table has one row per type."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from scenecc import plan
from scenecc.diagnostics.frozen import frozen
from scenecc.lower.field_types import COLOR, MIRROR_SCALE, SCALE, FieldType, field_type, report_unused_key
from scenecc.lower.local_poses import shape_pose
from scenecc.lower.materials import (
    DENSITY,
    PLAIN_SURFACE,
    LoweredMaterial,
    MaterialChoice,
    MaterialLowerer,
    with_base_color,
)
from scenecc.lower.references import PlanTables, select_per_scene
from scenecc.plan import CollisionShape, Mesh, Plane, Value, VisualShape, literal
from scenecc.plan.body import VisualMaterial
from scenecc.plan.geometry import MAX_HEIGHTS, MAX_TOTAL_HEIGHTS, REVOLVED_SOLIDS, SOLIDS, heights_fault
from scenecc.plan.properties import DEFAULT_DENSITY, properties_of

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer

GeometryLowerer = Callable[[Any, "PlanTables", "FieldLowerer", "Origin"], Any]


_HALF_SIZE_2 = field_type("VisualPlane.half_size")

_REPEAT = field_type("TiledPlane.texture_repeat")

_TERRAIN_SIZE = field_type("Heightfield.size")


def _size(shape: Any, name: str, kind: FieldType, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> Value:
    given = getattr(shape, name)
    # Equal sizes share a value.
    return tables.size(given) if given.__class__ in _PLAIN else fields.value(given, kind, origin, name)


_PLAIN = frozenset((float, int, tuple))


def _solid_lowerer(make: Callable[..., Any], **sizes: FieldType) -> GeometryLowerer:
    """Makes a lowerer for a shape that only has sizes, in the order of its dataclass."""

    def lower(shape: Any, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> Any:
        return make(*[_size(shape, name, kind, tables, fields, origin) for name, kind in sizes.items()])

    return lower


def _scale(shape: Any, kind: FieldType, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> Value:
    scale: Any = shape.scale
    if scale.__class__ not in _PLAIN:
        return fields.value(scale, kind, origin, "scale")
    return tables.size(scale if scale.__class__ is tuple else (scale, scale, scale))


def _file_lowerer(make: Callable[..., Any], scale: FieldType, *others: Callable[[Any], Any]) -> GeometryLowerer:
    """Makes a lowerer for a shape with a file and a scale. `others`: get its other fields."""

    def lower(shape: Any, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> Any:
        file = tables.files_of(shape.file, origin.child("file"), fields)
        return file and make(file, _scale(shape, scale, tables, fields, origin), *(other(shape) for other in others))

    return lower


_MAX_PNG_BYTES = 4 * MAX_HEIGHTS


def _heightfield(shape: Any, tables: PlanTables, fields: FieldLowerer, origin: Origin) -> plan.Heightfield | None:
    """Lowers terrain; None after an error in its heights."""
    if shape.file is None and shape.heights is None:
        fields.sink.report("SC102", "a heightfield needs heights", origin, hint="give one of `file` and `heights`")
        return None
    if shape.file is None:
        heights, place = tuple(tuple(map(float, row)) for row in shape.heights), origin.child("heights")
    else:
        heights, place = _file_heights(shape.file, tables, origin.child("file"), fields.sink), origin.child("file")
    if heights is None:
        return None
    fault = count_heights(heights, tables)
    if fault is not None:
        fields.sink.report("SC529", f"invalid heightfield: {fault}", place)
        return None
    return plan.Heightfield(_size(shape, "size", _TERRAIN_SIZE, tables, fields, origin), heights)


def count_heights(heights: tuple[tuple[float, ...], ...], tables: PlanTables) -> str | None:
    """Adds the heights of a terrain to those of the document. Returns why they are invalid, or None."""
    count = len(heights) * len(heights[0]) if heights else 0
    tables.height_count += count
    fault = heights_fault(heights)
    if fault is None and count > MAX_HEIGHTS:
        fault = f"there are more than {MAX_HEIGHTS} heights"
    if fault is None and tables.height_count > MAX_TOTAL_HEIGHTS:
        fault = f"all terrain of the scene has more than {MAX_TOTAL_HEIGHTS} heights"
    return fault


def _file_heights(uri: str, tables: PlanTables, origin: Origin, sink: Sink) -> tuple[tuple[float, ...], ...] | None:
    from scenecc.assets.images import read_heights  # noqa: PLC0415 - loaded where a heightfield has a file
    from scenecc.files import TooLongError, read_at_most  # noqa: PLC0415

    found = tables.resolve(uri, origin)
    if found is None:
        return None
    if found.path in tables.heights:
        return tables.heights[found.path]
    try:
        heights = tables.heights[found.path] = read_heights(read_at_most(found.path, _MAX_PNG_BYTES), MAX_HEIGHTS)
        return heights  # noqa: TRY300 - what may raise is above
    except TooLongError as error:
        sink.report("SC529", f"cannot read heights from {uri}: {error.strerror}", origin)
    except OSError as error:
        sink.report("SC407", f"{uri} may not be read: {error.strerror}", origin)
    except ValueError as error:
        sink.report("SC529", f"cannot read heights from {uri}: {error}", origin)
    return None


def _plane(shape: Any, _tables: PlanTables, _fields: FieldLowerer, _origin: Origin) -> plan.Plane:
    return plan.Plane(shape.every_scene)


def coacd_params(keys: Any) -> plan.CoacdParams | None:
    """CoACD's parameters for a `decomposition`; None if it does not use CoACD."""
    if keys.decomposition != "coacd":
        return None
    given = keys.decomposition_params
    return plan.CoacdParams(**given.model_dump()) if given else plan.CoacdParams()


_SOLIDS = {
    kind: _solid_lowerer(solid, **{name: field_type(f"{solid.__name__}.{name}") for name in solid.__slots__})
    for kind, solid in (SOLIDS | REVOLVED_SOLIDS).items()
}

COLLISION_GEOMETRY: dict[str, GeometryLowerer] = {
    **_SOLIDS,
    "plane": _plane,
    "heightfield": _heightfield,
    "convex_mesh": _file_lowerer(plan.ConvexMesh, SCALE),
    "convex_parts": _file_lowerer(plan.ConvexParts, SCALE, coacd_params),
    "triangle_mesh": _file_lowerer(plan.TriangleMesh, SCALE, attrgetter("sdf")),
}
"""Lowerer of each type of collision shape; gives None after an error in a file."""

VISUAL_GEOMETRY: dict[str, GeometryLowerer] = {
    **_SOLIDS,
    "plane": _solid_lowerer(plan.VisualPlane, half_size=_HALF_SIZE_2),
    "heightfield": _heightfield,
    **dict.fromkeys(("convex_mesh", "convex_parts", "triangle_mesh", "mesh"), _file_lowerer(plan.Mesh, MIRROR_SCALE)),
    "tiled_plane": _solid_lowerer(plan.TiledPlane, half_size=_HALF_SIZE_2, texture_repeat=_REPEAT),
}
"""Lowerer of each type of visual shape; gives None after an error in a file."""

_CONTACT_FIELDS = tuple(
    (row.key, row.field, field_type(row.quantity)) for row in properties_of("shape", "groups") if row.field != "density"
)
"""Key of the language, field of the plan, and type of the field."""

_CONTACT_ITEMS = attrgetter(*(key for key, _, _ in _CONTACT_FIELDS))

_LEFT_OUT = (None,) * len(_CONTACT_FIELDS)

_SHAPE_LISTS = ("shapes", "collisions", "visuals")
"""Keys of the shape lists: for both collision and visual shapes, and for only one of these."""


@frozen
class ShapeDefaults:
    """Defaults for the shapes of a body.

    Attributes:
        surface: of shapes without a material.
        color: (·, 4) or None.
        density: (·,) [kg/m³] of shapes without a density of their own or of their material, or None.
    """

    surface: LoweredMaterial | MaterialChoice = PLAIN_SURFACE
    color: Value | None = None
    density: Value | None = None


class ShapeLowerer:
    """Lowers the shapes of a document."""

    def __init__(self, tables: PlanTables, materials: MaterialLowerer, sink: Sink) -> None:
        self._tables = tables
        self._materials = materials
        self._sink = sink
        self._colored: dict[tuple[int, tuple[float, ...] | int], tuple[Any, Value, VisualMaterial]] = {}

    def shapes(
        self, layers: Sequence[tuple[Any, Origin]], default: ShapeDefaults, fields: FieldLowerer
    ) -> tuple[list[CollisionShape], list[VisualShape]]:
        """Lowers the collision and visual shapes of a body, without those with errors.

        Args:
            layers: models with lists of shapes, and their nodes; the lists are concatenated.
            default: of the body.
            fields: of the object.
        """
        collisions: list[CollisionShape] = []
        visuals: list[VisualShape] = []
        for key in _SHAPE_LISTS:
            for body, origin in layers:
                for i, shape in enumerate(getattr(body, key)):
                    collides, seen = self._lower_sides(shape, key, default, fields, origin.child(key, i))
                    if collides is not None:
                        collisions.append(collides)
                    if seen is not None:
                        visuals.append(seen)
        return collisions, visuals

    def _lower_sides(
        self, shape: Any, key: str, default: ShapeDefaults, fields: FieldLowerer, origin: Origin
    ) -> tuple[CollisionShape | None, VisualShape | None]:
        """Lowers the collision and visual side of a shape in the list under a key."""
        collides = seen = None
        if key != "visuals":
            collides = self._geometry(shape, fields, origin)
        if key != "collisions":
            make = VISUAL_GEOMETRY[shape.type]
            shared = key == "shapes" and make is COLLISION_GEOMETRY[shape.type]
            seen = collides if shared else make(shape, self._tables, fields, origin)
        surface, pose = self._surface(shape, default, fields, origin), shape_pose(shape, origin, fields)
        return (
            collides and self._make_collision(collides, shape, default, surface, pose, fields, origin),
            seen and self._make_visual(seen, shape, default, surface, pose, fields, origin),
        )

    def _make_collision(
        self,
        geometry: Any,
        shape: Any,
        default: ShapeDefaults,
        surface: LoweredMaterial | MaterialChoice,
        pose: Value | None,
        fields: FieldLowerer,
        origin: Origin,
    ) -> CollisionShape:
        density = None
        if shape.density is not None:
            density = fields.value(shape.density, DENSITY, origin, "density")
        if isinstance(surface, MaterialChoice):
            physical, otherwise = self._choose_physicals(surface, default, geometry, fields)
        else:
            physical, otherwise = surface.physical, default.density if surface.density is None else surface.density
        written = _CONTACT_ITEMS(shape)
        values: dict[str, Value | None] = {}
        if written != _LEFT_OUT:
            values = {
                field: fields.optional(item, kind, origin, key)
                for item, (key, field, kind) in zip(written, _CONTACT_FIELDS, strict=True)
            }
        density = otherwise if density is None else density
        return CollisionShape(geometry, pose, physical, density, **values, origin=origin)

    def _choose_physicals(
        self, surfaces: MaterialChoice, default: ShapeDefaults, geometry: Any, fields: FieldLowerer
    ) -> tuple[Value | None, Value | None]:
        """The physical material and the density if scenes have different materials."""
        pick, scenes = surfaces.pick, fields.scenes
        physicals = [surface.physical for surface in surfaces.each]
        physical = _select_or_default(physicals, self._materials.default(), pick, scenes)
        left_out = literal(0.0 if isinstance(geometry, Plane) else DEFAULT_DENSITY)
        densities = [default.density if surface.density is None else surface.density for surface in surfaces.each]
        return physical, _select_or_default(densities, left_out, pick, scenes)

    def _make_visual(
        self,
        geometry: Any,
        shape: Any,
        default: ShapeDefaults,
        surface: LoweredMaterial | MaterialChoice,
        pose: Value | None,
        fields: FieldLowerer,
        origin: Origin,
    ) -> VisualShape:
        color = None if shape.color is None else fields.value(shape.color, COLOR, origin, "color")
        named = shape.material is not None
        if isinstance(surface, MaterialChoice):
            visuals = [self._visual(one.visual, color, default, named=named) for one in surface.each]
            if isinstance(geometry, Mesh) and None in visuals and any(visual is not None for visual in visuals):
                message = (
                    "in some scenes this mesh would keep the materials of its file, and in others use one of these"
                )
                hint = "give every alternative a `visual`"
                self._sink.report("SC321", message, origin.child("material"), hint=hint)
            fresh = self._tables.visual_materials.value(VisualMaterial())
            material = _select_or_default(visuals, fresh, surface.pick, fields.scenes)
        else:
            material = self._visual(surface.visual, color, default, named=named)
        return VisualShape(geometry, pose, material, shape.name, shape.front_face, origin)

    def _visual(
        self, visual: VisualMaterial | None, color: Value | None, default: ShapeDefaults, *, named: bool
    ) -> Value | None:
        """The visual material of a shape: its material with the colour of the shape, or else of the body.

        A material on the shape itself has precedence over the body's colour.
        """
        if color is None and not (named and visual is not None and visual.base_color is not None):
            color = default.color
        if color is not None:
            visual = self._with_color(visual, color)
        return None if visual is None else self._tables.visual_materials.value(visual)

    def _with_color(self, visual: VisualMaterial | None, color: Value) -> VisualMaterial | None:
        # Shapes of one colour share a material. A varying colour is compared by identity.
        key = (id(visual), color.numbers() if color.is_constant else id(color))
        known = self._colored.get(key)
        if known is None:
            made = with_base_color(visual, color)
            assert made is not None
            known = self._colored[key] = (visual, color, made)
        return known[2]

    def _geometry(self, shape: Any, fields: FieldLowerer, origin: Origin) -> Any:
        """Lowers a collision geometry; None after an error."""
        if shape.type == "convex_parts" and shape.decomposition == "none" and shape.decomposition_params:
            hint = "set `decomposition: coacd`, or leave it out"
            report_unused_key("decomposition_params", "without a decomposition", origin, self._sink, hint=hint)
        return COLLISION_GEOMETRY[shape.type](shape, self._tables, fields, origin)

    def _surface(
        self, shape: Any, default: ShapeDefaults, fields: FieldLowerer, origin: Origin
    ) -> LoweredMaterial | MaterialChoice:
        if shape.material is None:
            return default.surface
        return self._materials.surface(shape.material, origin, fields) or PLAIN_SURFACE


def _select_or_default(
    values: Sequence[Value | None], otherwise: Value, pick: Value, scenes: tuple[int, ...]
) -> Value | None:
    """Selects one of several values or the default in each scene; None if there are none."""
    if all(value is None for value in values):
        return None
    return select_per_scene([otherwise if value is None else value for value in values], pick, scenes)
