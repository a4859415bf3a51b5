"""Physical materials of which a reset draws one of a few values: shapes with equal numbers share one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

if TYPE_CHECKING:
    from collections.abc import Callable

Friction3 = tuple[float, float, float]
"""Static friction, dynamic friction and restitution."""


class MaterialPool:
    """The shared materials of a batch, each while a shape has it. `make` takes the three numbers."""

    def __init__(self) -> None:
        self._made: WeakValueDictionary[Friction3, Any] = WeakValueDictionary()

    def take(self, numbers: Friction3, make: Callable[..., Any]) -> Any:
        """Returns the material with the given numbers."""
        found = self._made.get(numbers)
        if found is None:
            self._made[numbers] = found = make(*numbers)
        return found


class SharedMaterial:
    """The material of some shapes in one scene, with the setters and properties of a `PhysxMaterial`.

    Setting a number gives the shapes another material, because theirs may belong to other scenes, too. PhysX reads
    friction and restitution from the material of a shape at each step, so the contacts do not differ from those of a
    material of its own.

    Args:
        pool: of the batch.
        numbers: at first.
        make: makes a material.

    Attributes:
        material: at present.
        shapes: those that have it.
    """

    def __init__(self, pool: MaterialPool, numbers: Friction3, make: Callable[..., Any]) -> None:
        self._pool, self._make = pool, make
        self._numbers = numbers
        self.material: Any = pool.take(numbers, make)
        self.shapes: list[Any] = []

    static_friction = property(lambda self: self.material.static_friction)
    dynamic_friction = property(lambda self: self.material.dynamic_friction)
    restitution = property(lambda self: self.material.restitution)

    def set_static_friction(self, value: float) -> None:
        """Sets the static friction."""
        self._set((value, *self._numbers[1:]))

    def set_dynamic_friction(self, value: float) -> None:
        """Sets the dynamic friction."""
        self._set((self._numbers[0], value, self._numbers[2]))

    def set_restitution(self, value: float) -> None:
        """Sets the restitution."""
        self._set((*self._numbers[:2], value))

    def _set(self, numbers: Friction3) -> None:
        self._numbers = numbers
        found = self._pool.take(numbers, self._make)
        if found is not self.material:
            self.material = found
            for shape in self.shapes:
                shape.set_physical_material(found)


def add_shape(shape: Any, material: SharedMaterial | None) -> None:
    """Adds a shape that was made with a shared material; None: with one that is not shared."""
    if material is not None:
        material.shapes.append(shape)
