"""What is written of links and joints as values: each place once, however many links and joints it speaks of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.lower.articulations.maps import said
from scenecc.lower.articulations.written_limits import limits_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.lower.articulations.draft import Layer
    from scenecc.lower.kinds import Kind
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.materials import Materials, Surface, Surfaces
    from scenecc.plan import Value


class Said:
    """The values of one articulation.

    A value that a pattern gives is one value, and drawn once, whatever it matches.

    Args:
        materials: of the document.
        leaves: of the entity.
    """

    def __init__(self, materials: Materials, leaves: Leaves) -> None:
        self.leaves = leaves
        self._materials = materials
        self._known: dict[tuple[int, str], Any] = {}

    def value(self, layers: Sequence[Layer], key: str, kind: Kind, *, reset: bool = False) -> Value | None:
        """What the nearest layer with a key says; None where none has it."""
        layer = said(layers, key)
        return None if layer is None else self.of(layer, key, kind, reset=reset)

    def of(self, layer: Layer, key: str, kind: Kind, *, reset: bool = False) -> Value:
        """What a layer says that has a key."""
        keys, origin = layer
        found = self._known.get((id(keys), key))
        if found is None:
            found = self.leaves.value(getattr(keys, key), kind, origin, key, reset=reset)
            self._known[id(keys), key] = found
        return found

    def limits(self, layer: Layer) -> Value | None:
        """The limits that a layer says; None where it says none."""
        keys, origin = layer
        found = self._known.get((id(keys), "limits"))
        if found is None:
            found = self._known[id(keys), "limits"] = limits_of(keys, origin, self.leaves)
        return found

    def surface(self, layers: Sequence[Layer]) -> Surface | Surfaces | None:
        """The material of the nearest layer that has one."""
        layer = said(layers, "material")
        if layer is None:
            return None
        keys, origin = layer
        found = self._known.get((id(keys), "material"))
        if found is None:
            found = self._known[id(keys), "material"] = self._materials.surface(keys.material, origin, self.leaves)
        return found
