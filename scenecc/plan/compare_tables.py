"""The tables of two plans as one, so that indices of both can be compared."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenecc.plan.value import Value

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    from numpy.typing import NDArray

    from scenecc.plan.fields import Table
    from scenecc.plan.material import AssetFile, VisualMaterial
    from scenecc.plan.scene import ScenePlan

Side = Literal[0, 1]

_SHOWN = 12
"""Digits of a hash that people are shown."""


class Tables:
    """Numbers for the entries of two plans' tables: equal entries have one.

    Attributes:
        same: whether the tables are the same, entry by entry.
        names: of each file, by its number.
        materials: by table, with the numbers of their files in place of the indices.
    """

    def __init__(self, a: ScenePlan, b: ScenePlan) -> None:
        self.same = all(
            getattr(a, name) == getattr(b, name) for name in ("files", "physical_materials", "visual_materials")
        )
        self.names: list[str] = []
        self._numbers: dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]] = {"files": self._files(a.files, b.files)}
        tables: dict[str, tuple[Sequence[Hashable], Sequence[Hashable]]] = {
            "physical_materials": (a.physical_materials, b.physical_materials),
            "visual_materials": (
                [self._named(material, 0) for material in a.visual_materials],
                [self._named(material, 1) for material in b.visual_materials],
            ),
        }
        self.materials: dict[str, list[Any]] = {}
        for name, (first, second) in tables.items():
            self._numbers[name] = self._joined(name, first, second)

    def numbered(self, indices: NDArray[np.int64], table: Table, side: Side) -> NDArray[np.int64]:
        """Indices of one of the plans as numbers of both."""
        return self._numbers[table][side][indices]

    def _files(self, a: Sequence[AssetFile], b: Sequence[AssetFile]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        known: dict[object, int] = {}
        told: list[AssetFile] = []
        numbers: tuple[list[int], list[int]] = ([], [])
        for side, files in enumerate((a, b)):
            for file in files:
                content = (file.sha256, tuple(one.sha256 for one in file.names))
                number = known.get((file.uri, content), known.get((file.path, content), len(self.names)))
                if number == len(self.names):
                    self.names.append(file.uri)
                    told.append(file)
                known.setdefault((file.uri, content), number)
                known.setdefault((file.path, content), number)
                numbers[side].append(number)
        count = Counter(self.names)
        self.names[:] = [file.uri if count[file.uri] == 1 else _with_content(file) for file in told]
        return np.array(numbers[0], np.int64), np.array(numbers[1], np.int64)

    def _named(self, material: VisualMaterial, side: Side) -> VisualMaterial:
        """The material with the numbers of its files in place of their indices."""
        textures: dict[str, Any] = {
            name: replace(texture, file=Value(self.numbered(texture.file.data, "files", side)))
            for name, texture in material.textures().items()
        }
        return replace(material, **textures)

    def _joined(
        self, table: str, a: Sequence[Hashable], b: Sequence[Hashable]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        known: dict[Hashable, int] = {}
        first, second = ([known.setdefault(row, len(known)) for row in rows] for rows in (a, b))
        self.materials[table] = list(known)
        return np.array(first, np.int64), np.array(second, np.int64)


def _with_content(file: AssetFile) -> str:
    """A file's uri, and what it and those that it names hold, in short."""
    hashes = [(file.sha256 or "unknown")[:_SHOWN], *(f"{one.uri} {one.sha256[:_SHOWN]}" for one in file.names)]
    return f"{file.uri} (SHA-256 {', '.join(hashes)})"
