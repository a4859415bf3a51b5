"""A scene file in a scene of ManiSkill's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.scene import check_environments, load_scene

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike

    from scenecc.backends.maniskill import LoadedScene, ManiSkillScene
    from scenecc.pipeline import Source


def load_into(
    scene: ManiSkillScene,
    source: Source,
    *,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> LoadedScene:
    """Builds a scene file in a `ManiSkillScene`, one of its scenes in each environment. Call it in `_load_scene`.

    Actors and articulations are made by ManiSkill's own builders, stand in `scene.actors` and `scene.articulations`
    under their names in the file, and belong to the environment's state. Where they start is set by `initialize` of
    what is returned, in `_initialize_episode`.

    Args:
        scene: of the environment, `self.scene`.
        source: as for `scenecc.validate`; its `num_scenes` gives way to the number of environments.
        seed: of all draws, in place of the file's.
        params: values of the file's parameters.
        draws: values of its shared draws, a row an environment.
        asset_roots: folders in which `asset://` is looked up.
        allow_outside_assets: let paths leave the scene's folder and the asset roots.
        limits: limits to raise or lower, by name.

    Raises:
        SceneError: the scene, the engine or the machine is at fault.
        TypeError: `scene` is no environment's.
    """
    check_environments(scene)
    return load_scene(
        source,
        scene=scene,
        seed=seed,
        params=params,
        draws=draws,
        asset_roots=asset_roots,
        allow_outside_assets=allow_outside_assets,
        limits=limits,
    )
