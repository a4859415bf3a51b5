"""Convex meshes of a negative scale, which PhysX cannot have, as files of their own."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.assets_on_disk import all_parts
from scenecc.backends.sapien.coacd_worker import ply
from scenecc.backends.sapien.decomposition import cache_folder
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.files import replace_all

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.columns import Column
    from scenecc.plan import Value

Signs = tuple[float, float, float]
"""1 or -1 for each axis of a mesh."""

AS_IT_IS: Signs = (1.0, 1.0, 1.0)


def signs_of(scale: Value, row: int) -> Signs:
    """Along which axes a scale mirrors, in one row."""
    x, y, z = np.sign(scale.row(row)).tolist()
    return x, y, z


def mirrored_column(meshes: Column, scale: NDArray[np.float64], *, parts: bool) -> Column:
    """As `mirrored`, a row; one for all where both have one."""
    if (scale > 0).all():
        return meshes
    signs: list[Signs] = list(map(tuple, np.sign(scale).tolist()))
    count = max(len(meshes), len(signs))
    pairs = list(zip(meshes * (count // len(meshes)), signs * (count // len(signs)), strict=True))
    found = {pair: mirrored(*pair, parts=parts) for pair in dict.fromkeys(pairs)}
    return [found[pair] for pair in pairs]


def mirrored(mesh: str, signs: Signs, *, parts: bool) -> str:
    """Path of the convex hull of a mesh, or of the hulls of its connected parts, mirrored; of the mesh where it is not.

    PhysX allows no negative scale of a convex mesh: its faces would look inwards, it would weigh nothing, and the
    process would die at the first contact. The file stands in the user's cache folder, named by what it holds.

    Raises:
        EngineFailure: the engine cannot read the mesh, or the cache folder cannot be written.
    """
    if min(signs) > 0:
        return mesh
    try:
        shapes = _hulls(mesh, parts=parts)
    except (RuntimeError, ValueError) as error:
        raise EngineFailure("SC801", f"the engine cannot make this shape: {error}") from error
    turned = -1 if np.prod(signs) < 0 else 1
    content = ply([(shape.vertices * np.array(signs), shape.triangles[:, ::turned]) for shape in shapes])
    folder = cache_folder("mirrored")
    file = folder / f"{hashlib.sha256(content).hexdigest()}.ply"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not file.exists():
            replace_all({file: content})
    except OSError as error:
        hint = f"mirrored meshes are kept in '{folder}'; XDG_CACHE_HOME names another place"
        raise EngineFailure("SC801", f"the mirrored '{mesh}' cannot be written: {error}", hint=hint) from error
    return str(file)


def _hulls(mesh: str, *, parts: bool) -> list[Any]:
    hull = physx.PhysxCollisionShapeConvexMesh
    material: Any = physx.get_default_material()
    if parts:
        return all_parts(lambda: hull.load_multiple(mesh, AS_IT_IS, material))
    return [hull(mesh, AS_IT_IS, material)]
