"""Materials as written to rows of the plan's tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.words import cut, suggest_name
from scenecc.plan import Friction, PhysicalMaterial, Texture, Value, VisualMaterial, literal
from scenecc.spec.material import Material, Physical, TextureMapping, Visual

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.tables import Tables

NUMBERS = ("specular", "roughness", "metallic", "transmission", "ior", "transmission_roughness")
TEXTURES = (
    "base_color_texture",
    "normal_texture",
    "roughness_texture",
    "metallic_texture",
    "emission_texture",
    "transmission_texture",
)

Rgba = tuple[float, float, float, float]

SAPIEN_DEFAULT = Friction(0.3, 0.3, 0.1)
"""`sapien.physx.get_default_material()` of SAPIEN 3.0.3."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A material, lowered.

    Attributes:
        physical: index into the physical materials; None: the default material.
        visual: what is seen; None: nothing was said.
        density: [kg/m³] or None.
    """

    physical: Value | None = None
    visual: VisualMaterial | None = None
    density: float | None = None


PLAIN = Surface()


class Materials:
    """The named materials of a document, lowered when first used."""

    def __init__(
        self, named: dict[str, Material], tables: Tables, default: Friction, origin: Origin, sink: Sink
    ) -> None:
        self._named = named
        self._tables = tables
        self._default = default
        self._origin = origin
        self._sink = sink
        self._lowered: dict[str, Surface] = {}

    def surface(self, given: str | Material | None, owner: Origin) -> Surface | None:
        """A reference or an inline material; None where nothing is written.

        Args:
            given: as written.
            owner: of the node that has the key `material`.
        """
        if given is None:
            return None
        if isinstance(given, Material):
            return self._lower(given, owner.child("material"))
        found = self._lowered.get(given)
        if found is None:
            found = self._lowered[given] = self._by_name(given, owner)
        elif given not in self._named:
            self._unknown(given, owner)
        return found

    def report_unused(self) -> None:
        """A warning for each named material that no shape has; its files are looked up all the same."""
        for name, material in self._named.items():
            if name not in self._lowered:
                place = self._origin.child(name)
                self._lower(material, place)
                self._sink.report("SC313", f"the material `{name}` is never used", place, at="key")

    def _by_name(self, name: str, owner: Origin) -> Surface:
        if name in self._named:
            return self._lower(self._named[name], self._origin.child(name))
        self._unknown(name, owner)
        return PLAIN

    def _unknown(self, name: str, owner: Origin) -> None:
        hint = suggest_name(name, self._named, self._sink) if self._named else "name it under `materials`"
        self._sink.report("SC301", f"there is no material `{cut(name)}`", owner.child("material"), hint=hint)

    def _lower(self, material: Material, origin: Origin) -> Surface:
        physical, visual = material.physical, material.visual
        return Surface(
            self._physical(physical, origin.child("physical")) if physical else None,
            self._visual(visual, origin.child("visual")) if visual else None,
            physical.density if physical else None,
        )

    def _physical(self, given: Physical, origin: Origin) -> Value | None:
        parts = (given.static_friction, given.dynamic_friction, given.restitution)
        if parts == (None, None, None):
            return None
        default = (self._default.static_friction, self._default.dynamic_friction, self._default.restitution)
        row = PhysicalMaterial(*(literal(d if part is None else part) for part, d in zip(parts, default, strict=True)))
        return self._tables.physical(row, origin)

    def _visual(self, given: Visual, origin: Origin) -> VisualMaterial:
        parts: dict[str, Any] = {
            name: literal(number) for name in NUMBERS if (number := getattr(given, name)) is not None
        }
        parts |= {
            name: self._texture(texture, origin.child(name))
            for name in TEXTURES
            if (texture := getattr(given, name)) is not None
        }
        return VisualMaterial(
            base_color=literal(rgba(given.base_color)) if given.base_color is not None else None,
            emission=literal(rgba(given.emission)) if given.emission is not None else None,
            **parts,
        )

    def _texture(self, given: str | TextureMapping, origin: Origin) -> Texture | None:
        uri, place = (given, origin) if isinstance(given, str) else (given.file, origin.child("file"))
        index = self._tables.file(uri, place)
        if index is None:
            return None
        if isinstance(given, str):
            return Texture(literal(index, "int64"))
        return Texture(literal(index, "int64"), given.mipmap_levels, given.filter_mode, given.address_mode, given.srgb)


def colored(visual: VisualMaterial | None, color: str | Sequence[float] | None) -> VisualMaterial | None:
    """A visual material with another base colour, the rest left as it is."""
    if color is None:
        return visual
    return replace(visual or VisualMaterial(), base_color=literal(rgba(color)))


def rgba(color: str | Sequence[float]) -> Rgba:
    """Four numbers: "#rrggbb" and "#rrggbbaa" are bytes over 255, without gamma; alpha is 1 if left out."""
    if isinstance(color, str):
        digits = color[1:]
        color = [int(digits[i : i + 2], 16) / 255 for i in range(0, len(digits), 2)]
    red, green, blue, *rest = color
    return (red, green, blue, rest[0] if rest else 1.0)
