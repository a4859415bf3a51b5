"""Shapes as written to shapes of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.lower.geometry import COLLIDING, SEEN
from scenecc.lower.kinds import COLOR, number
from scenecc.lower.materials import DENSITY, PLAIN, Materials, Surface, Surfaces, colored
from scenecc.lower.picked import picked
from scenecc.lower.placing.shape_poses import shape_pose
from scenecc.plan import CollisionShape, Mesh, Plane, Value, VisualShape, literal
from scenecc.plan import VisualMaterial as SeenMaterial

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.tables import Tables
    from scenecc.plan import VisualMaterial

_NEAR = tuple((name, number(name)) for name in ("contact_offset", "rest_offset", "patch_radius", "min_patch_radius"))
_LEFT_OUT = (None,) * len(_NEAR)

SAPIEN_DENSITY = 1000.0
"""Of what gives none, but for a plane, which has none [kg/m³]."""


@frozen
class Defaults:
    """What the shapes of a body have that name nothing themselves.

    Attributes:
        surface: of the shapes that name no material.
        color: (·, 4) or None.
        density: (·,) [kg/m³] of the shapes whose material gives none either, or None.
    """

    surface: Surface | Surfaces = PLAIN
    color: Value | None = None
    density: Value | None = None


class Shapes:
    """Lowers the shapes of a document."""

    def __init__(self, tables: Tables, materials: Materials, sink: Sink) -> None:
        self._tables = tables
        self._materials = materials
        self._sink = sink
        self._colored: dict[tuple[int, tuple[float, ...] | int], tuple[Any, Value, VisualMaterial]] = {}

    def both(
        self, shape: Any, default: Defaults, leaves: Leaves, origin: Origin
    ) -> tuple[CollisionShape | None, VisualShape | None]:
        """The two sides of a shape from `shapes`; None where one was reported.

        Args:
            shape: as written.
            default: of its body.
            leaves: of the object.
            origin: of the shape.
        """
        type_ = shape.type
        make = SEEN[type_]
        collides = self._geometry(shape, leaves, origin)
        seen = collides if make is COLLIDING[type_] else make(shape, self._tables, leaves, origin)
        surface, pose = self._surface(shape, default, leaves, origin), shape_pose(shape, origin, leaves)
        return (
            collides and self._colliding(collides, shape, default, surface, pose, leaves, origin),
            seen and self._seen(seen, shape, default, surface, pose, leaves, origin),
        )

    def collision(self, shape: Any, default: Defaults, leaves: Leaves, origin: Origin) -> CollisionShape | None:
        """A shape from `collisions`; otherwise as `both`."""
        geometry = self._geometry(shape, leaves, origin)
        surface, pose = self._surface(shape, default, leaves, origin), shape_pose(shape, origin, leaves)
        return geometry and self._colliding(geometry, shape, default, surface, pose, leaves, origin)

    def visual(self, shape: Any, default: Defaults, leaves: Leaves, origin: Origin) -> VisualShape | None:
        """A shape from `visuals`; otherwise as `both`."""
        geometry = SEEN[shape.type](shape, self._tables, leaves, origin)
        surface, pose = self._surface(shape, default, leaves, origin), shape_pose(shape, origin, leaves)
        return geometry and self._seen(geometry, shape, default, surface, pose, leaves, origin)

    def _colliding(
        self,
        geometry: Any,
        shape: Any,
        default: Defaults,
        surface: Surface | Surfaces,
        pose: Value | None,
        leaves: Leaves,
        origin: Origin,
    ) -> CollisionShape:
        density = None
        if shape.density is not None:
            density = leaves.value(shape.density, DENSITY, origin, "density")
        if isinstance(surface, Surfaces):
            physical, otherwise = self._physicals(surface, default, geometry, leaves)
        else:
            physical, otherwise = surface.physical, default.density if surface.density is None else surface.density
        near = (shape.contact_offset, shape.rest_offset, shape.patch_radius, shape.min_patch_radius)
        if near != _LEFT_OUT:
            near = tuple(leaves.given(item, kind, origin, key) for item, (key, kind) in zip(near, _NEAR, strict=True))
        contact, rest, patch, min_patch = near
        density = otherwise if density is None else density
        return CollisionShape(geometry, pose, physical, density, contact, rest, patch, min_patch, origin)

    def _physicals(
        self, surfaces: Surfaces, default: Defaults, geometry: Any, leaves: Leaves
    ) -> tuple[Value | None, Value | None]:
        """The physical material and the density where the scenes have one of several materials."""
        pick, rows = surfaces.pick, len(leaves.scenes)
        physicals = [surface.physical for surface in surfaces.each]
        physical = _one_of(physicals, self._materials.default(), pick, rows)
        left_out = literal(0.0 if isinstance(geometry, Plane) else SAPIEN_DENSITY)
        densities = [default.density if surface.density is None else surface.density for surface in surfaces.each]
        return physical, _one_of(densities, left_out, pick, rows)

    def _seen(
        self,
        geometry: Any,
        shape: Any,
        default: Defaults,
        surface: Surface | Surfaces,
        pose: Value | None,
        leaves: Leaves,
        origin: Origin,
    ) -> VisualShape:
        color = None if shape.color is None else leaves.value(shape.color, COLOR, origin, "color")
        named = shape.material is not None
        if isinstance(surface, Surfaces):
            visuals = [self._visual(one.visual, color, default, named=named) for one in surface.each]
            if isinstance(geometry, Mesh) and None in visuals and any(visual is not None for visual in visuals):
                message = "in some scenes this mesh would have the materials of its file, and in others one of these"
                hint = "give every alternative a `visual`"
                self._sink.report("SC321", message, origin.child("material"), hint=hint)
            fresh = self._tables.visual_materials.value(SeenMaterial())
            material = _one_of(visuals, fresh, surface.pick, len(leaves.scenes))
        else:
            material = self._visual(surface.visual, color, default, named=named)
        return VisualShape(geometry, pose, material, shape.name, shape.front_face, origin)

    def _visual(
        self, visual: VisualMaterial | None, color: Value | None, default: Defaults, *, named: bool
    ) -> Value | None:
        """The row of what is seen: a material with the colour of the shape or, if nothing closer gives one, the body's.

        A material that the shape itself names is closer to it than the body's colour.
        """
        if color is None and not (named and visual is not None and visual.base_color is not None):
            color = default.color
        if color is not None:
            visual = self._with_color(visual, color)
        return None if visual is None else self._tables.visual_materials.value(visual)

    def _with_color(self, visual: VisualMaterial | None, color: Value) -> VisualMaterial | None:
        # Of one colour there is one material, however many shapes have it. What may vary is only itself.
        key = (id(visual), color.numbers() if color.is_constant else id(color))
        known = self._colored.get(key)
        if known is None:
            made = colored(visual, color)
            assert made is not None
            known = self._colored[key] = (visual, color, made)
        return known[2]

    def _geometry(self, shape: Any, leaves: Leaves, origin: Origin) -> Any:
        """What collides; None where it was reported."""
        if shape.type == "convex_parts" and shape.decomposition == "none" and shape.decomposition_params:
            self._sink.report(
                "SC115",
                "`decomposition_params` does nothing without a decomposition",
                origin.child("decomposition_params"),
                at="key",
                hint="set decomposition: coacd, or leave it out",
            )
        return COLLIDING[shape.type](shape, self._tables, leaves, origin)

    def _surface(self, shape: Any, default: Defaults, leaves: Leaves, origin: Origin) -> Surface | Surfaces:
        if shape.material is None:
            return default.surface
        return self._materials.surface(shape.material, origin, leaves) or PLAIN


def _one_of(values: Sequence[Value | None], otherwise: Value, pick: Value, rows: int) -> Value | None:
    """What one of several gives in each scene; None where none gives anything."""
    if all(value is None for value in values):
        return None
    return picked([otherwise if value is None else value for value in values], pick, rows)
