"""What bodies share: physical materials, render materials, textures and files of a plan, each made once."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.assets_on_disk import crashes_the_reader
from scenecc.backends.sapien.decomposition import decompose
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.plan import Texture

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from scenecc.backends.sapien.columns import Column
    from scenecc.plan import CoacdParams, ScenePlan, VisualMaterial


class Resources:
    """The tables of a plan as objects of the engine.

    Materials are shared by all shapes that name them, in all scenes, as in a script that makes each
    once: changing a friction later changes it for all of them.
    """

    def __init__(self, plan: ScenePlan) -> None:
        self._plan = plan
        default = plan.physics.default_material
        self.default_material: Any = physx.get_default_material() if default is None else _physical(default)
        self._physical = [_physical(material) for material in plan.physical_materials]
        self._visual: dict[int, Any] = {}
        self._textures: dict[Texture, Any] = {}

    def physical(self, indices: NDArray[np.int64] | None) -> Column:
        """`PhysxMaterial` a row; None: the default material."""
        return [self.default_material] if indices is None else [self._physical[i] for i in indices.tolist()]

    def visual(self, indices: NDArray[np.int64]) -> Column:
        """`RenderMaterial` a row."""
        return [self._visual_material(i) for i in indices.tolist()]

    def meshes(self, indices: NDArray[np.int64], code: str) -> Column:
        """Path of a mesh a row.

        Raises:
            EngineFailure: with `code`, where there is no such file (SAPIEN's own words for it are no help).
        """
        files = self._plan.files
        paths: dict[int, Path] = {i: files[i].path for i in set(map(int, indices))}
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
        cut = {path: str(decompose(Path(path), params)) for path in dict.fromkeys(whole)}
        return [cut[path] for path in whole]

    def path(self, index: int) -> str:
        """Where the plan's file number `index` is on this machine."""
        return str(self._plan.files[index].path)

    def _visual_material(self, index: int) -> Any:
        if index not in self._visual:
            self._visual[index] = self._make_visual(self._plan.visual_materials[index])
        return self._visual[index]

    def _make_visual(self, material: VisualMaterial) -> Any:
        given = {f.name: value for f in fields(material) if (value := getattr(material, f.name)) is not None}
        made = render.RenderMaterial(**{name: x for name, x in given.items() if not isinstance(x, Texture)})
        for name, texture in given.items():
            if isinstance(texture, Texture):
                setattr(made, name, self._texture(texture))
        return made

    def _texture(self, texture: Texture) -> Any:
        if texture not in self._textures:
            names = ("mipmap_levels", "filter_mode", "address_mode", "srgb")
            given = {name: value for name in names if (value := getattr(texture, name)) is not None}
            path = self.path(texture.file)
            try:
                self._textures[texture] = render.RenderTexture2D(path, **given)
            except RuntimeError as error:
                raise EngineFailure("SC807", f"the renderer cannot load the texture '{path}': {error}") from error
        return self._textures[texture]


def _physical(material: Any) -> Any:
    return physx.PhysxMaterial(material.static_friction, material.dynamic_friction, material.restitution)
