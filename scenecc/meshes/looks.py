"""Visual materials of a plan as looks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.meshes.images import Images
from scenecc.meshes.surface import Look, MeshProblem

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.meshes.surface import Image
    from scenecc.plan import ScenePlan, Value


class Looks:
    """The visual materials of a plan, each made once for each set of numbers."""

    def __init__(self, plan: ScenePlan, told: Callable[[MeshProblem], None]) -> None:
        """`told` takes images that are left out, each once."""
        self._plan = plan
        self._told = told
        self._images = Images()
        self._made: dict[tuple[object, ...], Look] = {}
        self._left_out: set[str] = set()

    def look(self, material: Value, row: int) -> Look:
        """What a material is in one row of what has it.

        Raises:
            MeshProblem: a package is missing.
        """
        index = int(material.row(row))
        made = self._plan.visual_materials[index]
        key = (index, *(value.row(row).tobytes() for value in made.values()))
        if key not in self._made:
            images = {f"{name.removesuffix('_texture')}_image": item for name, item in made.textures().items()}
            found: dict[str, Any] = {name: self._image(texture, row) for name, texture in images.items()}
            self._made[key] = Look(**_numbers(made.row(row)), **found)
        return self._made[key]

    def _image(self, texture: Any, row: int) -> Image | None:
        file = self._plan.files[int(texture.file.row(row))]
        try:
            return self._images.file(file.path, file.sha256, texture.sampling())
        except MeshProblem as problem:
            if problem.code == "SC813":
                raise
            if problem.message not in self._left_out:
                self._left_out.add(problem.message)
                self._told(problem)
            return None


def _numbers(given: dict[str, float | list[float]]) -> dict[str, Any]:
    """The plan's numbers as those of a look: a colour as a tuple, and of emission strength and colour in one."""
    found: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in given.items()}
    if "emission" in found:
        red, green, blue, strength = found["emission"]
        found["emission"] = (red * strength, green * strength, blue * strength)
    return found
