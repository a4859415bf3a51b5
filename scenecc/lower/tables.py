"""The plan's tables as they grow: files, materials, and values that many shapes share."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Generic, TypeVar

from scenecc.plan import AssetFile, PhysicalMaterial, Value, VisualMaterial, literal

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin

FileResolver = Callable[[str, "Origin"], AssetFile | None]
"""Finds a file that a document names; reports and gives None where there is none."""

Row = TypeVar("Row", bound=Hashable)


class Table(Generic[Row]):
    """Rows without repetition, in the order in which they first came."""

    def __init__(self) -> None:
        self._indices: dict[Row, int] = {}
        self._values: list[Value] = []
        self._known: dict[int, tuple[Row, Value]] = {}

    def index(self, row: Row) -> int:
        """The row's index; it is added where it is new."""
        index = self._indices.setdefault(row, len(self._indices))
        if index == len(self._values):
            self._values.append(literal(index, "int64"))
        return index

    def value(self, row: Row) -> Value:
        """The row's index as a value that is the same in every scene."""
        known = self._known.get(id(row))
        if known is None:
            # By identity, since hashing a material takes longer than all else here; kept, so that its id stays its own.
            known = self._known[id(row)] = (row, self._values[self.index(row)])
        return known[1]

    @property
    def rows(self) -> tuple[Row, ...]:
        """All rows, by index."""
        return tuple(self._indices)


class Tables:
    """What the shapes of a plan refer to.

    Attributes:
        file_origins: for each file, the first place that names it.
        material_origins: for each physical material, the first place that asks for it.
    """

    def __init__(self, resolve: FileResolver) -> None:
        self.files: Table[AssetFile] = Table()
        self.physical_materials: Table[PhysicalMaterial] = Table()
        self.visual_materials: Table[VisualMaterial] = Table()
        self.file_origins: dict[int, Origin] = {}
        self.material_origins: dict[int, Origin] = {}
        self._resolve = resolve
        self._sizes: dict[tuple[float, ...] | float, Value] = {}

    def file(self, uri: str, origin: Origin) -> int | None:
        """The index of a file in `files`; None where it was reported."""
        found = self._resolve(uri, origin)
        if found is None:
            return None
        index = self.files.index(found)
        self.file_origins.setdefault(index, origin)
        return index

    def physical(self, row: PhysicalMaterial, origin: Origin) -> Value:
        """A physical material's index as a value."""
        self.material_origins.setdefault(self.physical_materials.index(row), origin)
        return self.physical_materials.value(row)

    def size(self, size: tuple[float, ...] | float) -> Value:
        """A positive size as a value; equal sizes share one. (0.0 and -0.0 would be one key.)"""
        found = self._sizes.get(size)
        if found is None:
            found = self._sizes[size] = literal(size)
        return found
