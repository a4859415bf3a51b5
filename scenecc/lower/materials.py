"""Lowers materials to rows of the plan's tables."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.field_types import COLOR, EMISSION, FieldType, field_type
from scenecc.lower.forms import FieldPlace, field_place
from scenecc.lower.references import PlanTables, qualified, read_references, scope_of
from scenecc.plan import Value, literal
from scenecc.plan.body import Friction, PhysicalMaterial, Texture, VisualMaterial
from scenecc.plan.properties import DYNAMIC_FRICTION, RESTITUTION, STATIC_FRICTION
from scenecc.spec.shapes import Material, Physical, TextureMapping, Visual

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer

NUMBERS = ("specular", "roughness", "metallic", "transmission", "ior", "transmission_roughness")
TEXTURES = (
    "base_color_texture",
    "normal_texture",
    "roughness_texture",
    "metallic_texture",
    "emission_texture",
    "transmission_texture",
)
FRICTION_TYPES: dict[str, FieldType] = {
    name: field_type(f"PhysicalMaterial.{name}") for name in ("static_friction", "dynamic_friction", "restitution")
}
DENSITY = field_type("CollisionShape.density")
_VISUAL_TYPES: dict[str, FieldType] = {
    **{name: field_type(f"VisualMaterial.{name}") for name in NUMBERS},
    "base_color": COLOR,
    "emission": EMISSION,
}

SAPIEN_DEFAULT = Friction(STATIC_FRICTION, DYNAMIC_FRICTION, RESTITUTION)


@frozen
class LoweredMaterial:
    """A lowered material.

    Attributes:
        physical: index into the physical materials; None: the default material.
        visual: its appearance; None: not given.
        density: [kg/m³] or None.
    """

    physical: Value | None = None
    visual: VisualMaterial | None = None
    density: Value | None = None


@frozen
class MaterialChoice:
    """Several materials, one of which each scene has.

    Attributes:
        each: the materials.
        pick: (·,) index into `each`.
    """

    each: tuple[LoweredMaterial, ...]
    pick: Value


PLAIN_SURFACE = LoweredMaterial()


class MaterialLowerer:
    """The named materials of a document, lowered when first used."""

    def __init__(
        self, named: Mapping[str, Material], tables: PlanTables, default: Friction, origin: Origin, sink: Sink
    ) -> None:
        self._named = named
        self._tables = tables
        self._default = {name: literal(getattr(default, name)) for name in FRICTION_TYPES}
        self._origin = origin
        self._sink = sink
        self._lowered: dict[str, LoweredMaterial] = {}
        self._varying: dict[str, dict[tuple[int, ...], LoweredMaterial]] = {}

    def surface(self, given: Any, owner: Origin, fields: FieldLowerer) -> LoweredMaterial | MaterialChoice | None:
        """Lowers a reference, an inline material or several alternatives; None if not given.

        Args:
            given: as written.
            owner: of the node that has the key `material`.
            fields: of the object.
        """
        if given is None:
            return None
        if given.__class__ is str:
            return self._find_material(given, owner, ("material",), fields)
        if isinstance(given, Material):
            return self._lower(given, owner.child("material"), fields)

        def find(one: Any, place: Origin) -> LoweredMaterial:
            if isinstance(one, Material):
                return self._lower(one, place, fields)
            return self._find_material(one, place, (), fields)

        named = read_references(given, field_place(owner.child("material")), fields, find)
        each = tuple(found or PLAIN_SURFACE for found in named.found)
        return each[0] if len(each) == 1 else MaterialChoice(each, named.value)

    def report_unused(self, used: frozenset[str], fields: FieldLowerer) -> None:
        """Warns of each named material that no shape has, after resolving its files.

        Args:
            used: names with a reference, although no shape has the material.
            fields: of the whole batch.
        """
        for name, material in self._named.items():
            if name not in self._lowered:
                place = self._origin.child(name)
                self._lower(material, place, fields.inside(scope_of(name)))
                if name not in used:
                    self._sink.report("SC313", f"the material `{cut(name)}` is never used", place, at="key")

    def _find_material(self, name: str, owner: Origin, at: tuple[str, ...], fields: FieldLowerer) -> LoweredMaterial:
        full = qualified(name, fields.scope) if fields.scope or name[0] == "/" else name
        found = self._lowered.get(full)
        if found is None:
            given = self._named.get(full)
            if given is None:
                self._report_unknown(name, owner.child(*at), fields)
                return PLAIN_SURFACE
            before = fields.sampling.read
            found = self._lowered[full] = self._lower(given, self._origin.child(full), fields.inside(scope_of(full)))
            if fields.sampling.read != before:
                self._varying[full] = {fields.scenes: found}
        by_scenes = self._varying.get(full)
        if by_scenes is None:
            return found
        if fields.scenes not in by_scenes:
            # Its values have rows for the scenes of the object that uses it.
            place, inside = self._origin.child(full), fields.inside(scope_of(full))
            by_scenes[fields.scenes] = self._lower(self._named[full], place, inside)
        return by_scenes[fields.scenes]

    def _report_unknown(self, name: str, place: Origin, fields: FieldLowerer) -> None:
        full = qualified(name, fields.scope)
        prefix = qualified("", scope_of(full))
        name = full[len(prefix) :]
        names = [other[len(prefix) :] for other in self._named if other.startswith(prefix)]
        hint = (
            suggest_name(name, names, self._sink)
            if names
            else f"declare it at the top: `materials: {{{cut(name)}: {{physical: {{static_friction: 0.5}}}}}}`"
        )
        self._sink.report("SC301", f"there is no material `{cut(name)}`", place, hint=hint)

    def _lower(self, material: Material, origin: Origin, fields: FieldLowerer) -> LoweredMaterial:
        given, seen = material.physical, material.visual
        return LoweredMaterial(
            self._physical(given, origin.child("physical"), fields) if given else None,
            self._visual(seen, origin.child("visual"), fields) if seen else None,
            fields.optional(given.density, DENSITY, origin, "physical", "density") if given else None,
        )

    def _physical(self, given: Physical, origin: Origin, fields: FieldLowerer) -> Value | None:
        parts: dict[str, Any] = {name: getattr(given, name) for name in FRICTION_TYPES}
        if all(part is None for part in parts.values()):
            return None
        values = {
            name: self._default[name] if part is None else fields.value(part, FRICTION_TYPES[name], origin, name)
            for name, part in parts.items()
        }
        return self._tables.physical(PhysicalMaterial(**values), origin)

    def default(self) -> Value:
        """The row of the default material, for a shape that has it in some scenes only."""
        return self._tables.physical(PhysicalMaterial(**self._default), self._origin)

    def _visual(self, given: Visual, origin: Origin, fields: FieldLowerer) -> VisualMaterial:
        parts: dict[str, Any] = {}
        for name, kind in _VISUAL_TYPES.items():
            if (item := getattr(given, name)) is not None:
                parts[name] = fields.value(item, kind, origin, name)
        for name in TEXTURES:
            if (item := getattr(given, name)) is not None:
                parts[name] = self.texture(item, origin.child(name), fields)
        return VisualMaterial(**parts)

    def texture(self, given: Any, origin: Origin, fields: FieldLowerer) -> Texture | None:
        """Lowers an image and its sampling; None after an error.

        Args:
            given: as written: a file, a mapping, or a form of these.
            origin: of the image.
            fields: of the object.
        """
        samplings: list[tuple[Any, FieldPlace]] = []

        def unwrap(one: Any, place: FieldPlace) -> tuple[Any, FieldPlace]:
            mapping = isinstance(one, TextureMapping)
            samplings.append((_read_sampling(one) if mapping else None, place))
            return (one.file, place.key("file")) if mapping else (one, place)

        file = self._tables.files_of(given, origin, fields, unwrap)
        sampling = samplings[0][0] if samplings else None
        for other, place in samplings:
            if other != sampling:
                message = "alternatives of a texture may differ only in their files"
                self._sink.report("SC321", message, place.origin, hint="give each the same keys beside its `file`")
                return None
        return file and Texture(file, *(sampling or ()))


def _read_sampling(given: TextureMapping) -> tuple[Any, ...]:
    return (given.mipmap_levels, given.filter_mode, given.address_mode, given.srgb)


def with_base_color(visual: VisualMaterial | None, color: Value | None) -> VisualMaterial | None:
    """Replaces the base colour of a visual material."""
    if color is None:
        return visual
    return replace(visual or VisualMaterial(), base_color=color)
