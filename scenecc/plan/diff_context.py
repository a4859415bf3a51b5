"""What the comparison of two plans shares: tables with common indices, and resets evaluated with the same seeds."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.plan.value import Value
from scenecc.variation.errors import DrawError
from scenecc.variation.per_scene_arrays import to_field_rows

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    from numpy.typing import NDArray

    from scenecc.plan.material import AssetFile, VisualMaterial
    from scenecc.plan.scene import ScenePlan
    from scenecc.plan.schema import TableName
    from scenecc.variation.evaluation import Batch


Side = Literal[0, 1]

_HASH_DIGITS = 12
"""Digits of a hash that people are shown."""


class MergedTables:
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

    def numbered(self, indices: NDArray[np.int64], table: TableName, side: Side) -> NDArray[np.int64]:
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
        self.names[:] = [file.uri if count[file.uri] == 1 else _uri_with_hashes(file) for file in told]
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


def _uri_with_hashes(file: AssetFile) -> str:
    """A file's uri, and what it and those that it names hold, in short."""
    hashes = [
        (file.sha256 or "unknown")[:_HASH_DIGITS],
        *(f"{one.uri} {one.sha256[:_HASH_DIGITS]}" for one in file.names),
    ]
    return f"{file.uri} (SHA-256 {', '.join(hashes)})"


MIN_SEEDS: Final = 4

MIN_DRAWS: Final = 256
"""So many seeds at least, and so many draws of each value over all scenes: one that is seldom another shows."""

_FIRST_SEED: Final = 0x5CE9E


class ResetComparison:
    """Evaluates the recipes of two plans with the same seeds.

    Attributes:
        plans: the two.
        same_draws: whether their shared draws are written alike.
    """

    def __init__(self, a: ScenePlan, b: ScenePlan) -> None:
        self.same_draws = repr(a.draws) == repr(b.draws) and a.num_scenes == b.num_scenes
        self.plans = (a, b)
        self._batches: dict[tuple[Side, bytes], Batch] = {}

    def differing(
        self,
        scenes: NDArray[np.int64],
        values: tuple[Value, Value],
        rows: tuple[NDArray[Any], NDArray[Any]],
        part: slice | None = None,
    ) -> int:
        """In how many scenes some seed gives the two something else.

        Args:
            scenes: indices of those that both have (B,).
            values: of the two plans.
            rows: their data there, or a part of it (B, …) or (1, …), for what a reset leaves as it is.
            part: of each row that a recipe gives; None: all of it.
        """
        x, y = values
        if x.recipe is None and y.recipe is None:
            return 0
        if self.same_draws and repr(x.recipe) == repr(y.recipe):
            return 0
        first, second = self._given(0, scenes, x, rows[0], part), self._given(1, scenes, y, rows[1], part)
        if isinstance(first, str) or isinstance(second, str):
            # What has no value with one of the seeds is the same only as what fails alike.
            return 0 if isinstance(first, str) and first == second else len(scenes)
        return int((first != second).any(axis=(0, 2)).sum())

    def _given(
        self, side: Side, scenes: NDArray[np.int64], value: Value, rows: NDArray[Any], part: slice | None
    ) -> NDArray[np.uint8] | str:
        """What the seeds give, to the bit: (seeds, B, bytes); or why one of them gives nothing."""
        seeds = max(MIN_SEEDS, -(-MIN_DRAWS // len(scenes)))
        if value.recipe is None:
            data = np.broadcast_to(rows, (seeds, len(scenes), *rows.shape[1:]))
        else:
            try:
                data = to_field_rows(self._batch(side, scenes, seeds).evaluate(value.recipe))
            except DrawError as error:
                return str(error)
            data = data if part is None else data[:, part]
        numbers = np.ascontiguousarray(data, dtype=np.float64)
        return numbers.reshape(seeds, len(scenes), -1).view(np.uint8)

    def _batch(self, side: Side, scenes: NDArray[np.int64], seeds: int) -> Batch:
        from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - most plans have no recipes

        key = (side, scenes.tobytes())
        if key not in self._batches:
            plan = self.plans[side]
            each = np.repeat(np.arange(_FIRST_SEED, _FIRST_SEED + seeds), len(scenes)).tolist()
            self._batches[key] = Batch(np.tile(scenes, seeds), tuple(each), plan.num_scenes, dict(plan.draws), {})
        return self._batches[key]


@dataclass(frozen=True, slots=True)
class ComparisonContext:
    """What two objects have in common.

    Attributes:
        tables, resets: of their plans.
        scenes: indices of the scenes that both are in; (1,) for what is in none.
        rows: of each, those of these scenes; None: all rows of both.
    """

    tables: MergedTables
    resets: ResetComparison
    scenes: NDArray[np.int64]
    rows: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None
