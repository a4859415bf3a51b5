"""What bodies share: physical materials, render materials, textures and files of a plan, each made once."""

from __future__ import annotations

import gc
from dataclasses import astuple
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from weakref import WeakSet

import numpy as np

from scenecc.backends.sapien.assets_on_disk import check_unchanged, crashes_the_reader
from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.decomposition import decompose
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.failure import EngineFailure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.columns import Column
    from scenecc.plan import CoacdParams, ScenePlan, Texture, Value, VisualMaterial

_MOST_MATERIALS: Final = 65_534
"""PhysX has 65 535 numbers for those of a process, and one of them is its default material's."""

_materials: Final[WeakSet[Any]] = WeakSet()
"""Those of all batches that are open: what a batch was built from lives as long as it."""


class Resources:
    """The tables of a plan as objects of the engine.

    Materials are shared by all shapes that name them, in all scenes where their numbers are the same, as in a
    script that makes each once: changing a friction later changes it for all of them.
    """

    def __init__(self, plan: ScenePlan) -> None:
        self._plan = plan
        default = plan.physics.default_material
        self._physical: dict[tuple[float, ...], Any] = {}
        self._lacking = 0
        self.default_material: Any = (
            physx.get_default_material() if default is None else self._physical_material((-1, *astuple(default)))
        )
        self._same: dict[int, Column | None] = {}
        self._visual: dict[tuple[object, ...], Any] = {}
        self._textures: dict[tuple[object, ...], Any] = {}

    def physical(self, material: Value | None, rows: NDArray[np.intp]) -> Column:
        """`PhysxMaterial` a row, or one for all; None: the default material."""
        if material is None:
            return [self.default_material]
        if not material.varies and (fixed := self._fixed(int(material.as_drawn()[0]))) is not None:
            return fixed
        indices = np.broadcast_to(taken(material, rows), len(rows))
        numbers = np.empty((len(rows), 3))
        for index in np.unique(indices).tolist():
            where = indices == index
            numbers[where] = self._numbers(index, rows[where])
        return list(map(self._physical_material, zip(indices.tolist(), *numbers.T.tolist(), strict=True)))

    def crowded(self) -> EngineFailure | None:
        """What is wrong if the engine cannot number all physical materials that were asked for."""
        if not self._lacking:
            return None
        count = len(self._physical)
        others = _MOST_MATERIALS - (count - self._lacking)
        return EngineFailure(
            "SC821",
            f"these scenes need {count} physical materials{f' beside {others} of other batches' * (others > 0)};"
            f" a process holds {_MOST_MATERIALS}",
            hint="build fewer scenes in one process, or draw friction and restitution from few values (`choice`)",
        )

    def _fixed(self, index: int) -> Column | None:
        """A physical material that is the same in every scene, as the column of all shapes that have it."""
        if index not in self._same:
            values = self._plan.physical_materials[index].values()
            numbers = [value.as_drawn()[0] for value in values]
            differs = any(value.varies for value in values)
            self._same[index] = None if differs else [self._physical_material((index, *numbers))]
        return self._same[index]

    def _numbers(self, index: int, rows: NDArray[np.intp]) -> NDArray[np.float64]:
        """Of a physical material (B, 3)."""
        columns = [taken(value, rows) for value in self._plan.physical_materials[index].values()]
        return np.stack(np.broadcast_arrays(*columns), axis=1)

    def _physical_material(self, key: tuple[float, ...]) -> Any:
        if key not in self._physical:
            self._physical[key] = self._new_material(*key[1:])
        return self._physical[key]

    def _new_material(self, *numbers: float) -> Any:
        if not self._lacking and len(_materials) == _MOST_MATERIALS:
            gc.collect()  # a batch that was dropped without being closed may still have some
        if self._lacking or len(_materials) == _MOST_MATERIALS:
            # SAPIEN crashes on one too many. From here on they are counted, for `crowded`, and not made.
            self._lacking += 1
            return physx.get_default_material()
        made = _physical(*numbers)
        _materials.add(made)
        return made

    def visual(self, material: Value, rows: NDArray[np.intp]) -> Column:
        """`RenderMaterial` a row, or one for all."""
        table = self._plan.visual_materials
        indices: list[int] = taken(material, rows).tolist()
        varying = {i: [value for value in table[i].values() if value.varies] for i in dict.fromkeys(indices)}
        if len(indices) == 1 and varying[indices[0]]:
            indices *= len(rows)
        column: Column = []
        for index, row in zip(indices, rows.tolist(), strict=False):
            key = (index, *(value.data[row].tobytes() for value in varying[index]))
            if key not in self._visual:
                self._visual[key] = self._make_visual(table[index], row)
            column.append(self._visual[key])
        return column

    def meshes(self, indices: NDArray[np.int64], code: str) -> Column:
        """Path of a mesh a row.

        Raises:
            EngineFailure: with `code`, where there is no such file (SAPIEN's own words for it are no help).
        """
        files = self._plan.files
        paths: dict[int, Path] = {i: files[i].path for i in set(map(int, indices))}
        check_unchanged(files[i] for i in paths)
        for path in paths.values():
            if not path.is_file():
                raise EngineFailure(code, f"there is no file '{path}'")
            if crashes_the_reader(path):
                raise EngineFailure(
                    code,
                    f"SAPIEN's reader crashes on this PLY file, whose data begin like a line break: '{path}'",
                    hint="write it as OBJ, or with its vertices in another order",
                )
        return [str(paths[i]) for i in indices.tolist()]

    def parts(self, indices: NDArray[np.int64], params: CoacdParams | None) -> Column:
        """Path a row of a mesh whose connected parts are convex; CoACD has cut it where `params` are given."""
        whole = self.meshes(indices, "SC801")
        if params is None:
            return whole
        order: list[int] = indices.tolist()
        cut = {i: str(decompose(self._plan.files[i], params)) for i in dict.fromkeys(order)}
        return [cut[i] for i in order]

    def path(self, index: int) -> str:
        """Where the plan's file number `index` is on this machine."""
        check_unchanged([self._plan.files[index]])
        return str(self._plan.files[index].path)

    def _make_visual(self, material: VisualMaterial, row: int) -> Any:
        made = render.RenderMaterial(**material.row(row))
        for name, texture in material.textures().items():
            setattr(made, name, self.texture(texture, row))
        return made

    def texture(self, texture: Texture, row: int) -> Any:
        """A `RenderTexture2D` as in one row of what has it; one for all that sample a file alike.

        Raises:
            EngineFailure: the renderer cannot load the file.
        """
        path, sampling = self.path(int(texture.file.row(row))), texture.sampling()
        key = (path, *sampling.items())
        if key not in self._textures:
            try:
                self._textures[key] = render.RenderTexture2D(path, **sampling)
            except RuntimeError as error:
                raise EngineFailure("SC807", f"the renderer cannot load the texture '{path}': {error}") from error
        return self._textures[key]


def _physical(static_friction: float, dynamic_friction: float, restitution: float) -> Any:
    return physx.PhysxMaterial(static_friction, dynamic_friction, restitution)
