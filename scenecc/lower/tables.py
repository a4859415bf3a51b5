"""The plan's tables as they grow: files, materials, and values that many shapes share."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import fields
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from scenecc.lower.forms import place_of
from scenecc.lower.words import Unwrap, as_it_is, read_names
from scenecc.plan import AssetFile, PhysicalMaterial, Texture, Value, VisualMaterial, literal

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves

FileResolver = Callable[[str, "Origin"], AssetFile | None]
"""Finds a file that a document names; reports and gives None where there is none."""

Row = TypeVar("Row")


class Table(Generic[Row]):
    """Rows without repetition, in the order in which they first came."""

    def __init__(self, key: Callable[[Row], Hashable]) -> None:
        """`key`: of rows that are the same."""
        self._key = key
        self._rows: list[Row] = []
        self._indices: dict[Hashable, Value] = {}
        self._known: dict[int, tuple[Row, Value]] = {}

    def value(self, row: Row) -> Value:
        """The row's index as a value that is the same in every scene; it is added where it is new."""
        known = self._known.get(id(row))
        if known is None:
            # By identity, since the key of a material takes longer than all else here; kept, so that its id stays
            # its own.
            key = self._key(row)
            value = self._indices.get(key)
            if value is None:
                value = self._indices[key] = literal(len(self._rows), "int64")
                self._rows.append(row)
            known = self._known[id(row)] = (row, value)
        return known[1]

    def index(self, row: Row) -> int:
        """The row's index."""
        return int(self.value(row).numbers()[0])

    @property
    def rows(self) -> tuple[Row, ...]:
        """All rows, by index."""
        return tuple(self._rows)


def _content(row: Any) -> Hashable:
    """What a material consists of; what may vary is only itself, since comparing it would draw it."""
    if isinstance(row, Value):
        return row.numbers() if row.is_constant else ("value", id(row))
    members = _MEMBERS.get(row.__class__)
    return row if members is None else tuple([None if part is None else _content(part) for part in members(row)])


_MEMBERS: dict[type[Any], Callable[[Any], tuple[Any, ...]]] = {
    kind: attrgetter(*(field.name for field in fields(kind))) for kind in (PhysicalMaterial, VisualMaterial, Texture)
}


class Tables:
    """What the shapes of a plan refer to.

    Attributes:
        file_origins: for each file, the first place that names it.
        material_origins: for each physical material, the first place that asks for it.
    """

    def __init__(self, resolve: FileResolver) -> None:
        self.files: Table[AssetFile] = Table(lambda file: file)
        self.physical_materials: Table[PhysicalMaterial] = Table(_content)
        self.visual_materials: Table[VisualMaterial] = Table(_content)
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

    def files_of(self, given: Any, origin: Origin, leaves: Leaves, unwrap: Unwrap = as_it_is) -> Value | None:
        """A leaf that names a file as indices into `files`; None where one of its alternatives was reported.

        Args:
            given: as the models have it.
            origin: of the leaf.
            leaves: of the object.
            unwrap: what names the file in an alternative that is a mapping.
        """
        if given.__class__ is str:
            index = self.file(given, origin)
            return None if index is None else literal(index, "int64")
        named = read_names(given, place_of(origin), leaves, self.file, unwrap)
        return None if None in named.found else named.indices(leaves)

    def physical(self, row: PhysicalMaterial, origin: Origin) -> Value:
        """A physical material's index as a value."""
        value = self.physical_materials.value(row)
        self.material_origins.setdefault(int(value.numbers()[0]), origin)
        return value

    def size(self, size: tuple[float, ...] | float) -> Value:
        """A positive size as a value; equal sizes share one. (0.0 and -0.0 would be one key.)"""
        found = self._sizes.get(size)
        if found is None:
            found = self._sizes[size] = literal(size)
        return found
