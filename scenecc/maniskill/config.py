"""A scene file's settings as the configuration of an environment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends import maniskill
from scenecc.diagnostics import Sink
from scenecc.errors import SceneError
from scenecc.options import Options
from scenecc.pipeline import compiled

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike

    from scenecc.pipeline import Source


def sim_config(
    source: Source,
    *,
    control_freq: int | None = None,
    params: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> Any:
    """The `mani_skill.utils.structs.types.SimConfig` with what a file says under `physics`.

    What the file leaves out is ManiSkill's default. Give it to `gym.make(…, sim_config=…)`, or return it from an
    environment's `_default_sim_config`. `sdf` has no place in it; `load_into` sets that while it builds.

    Args:
        source: as for `scenecc.validate`.
        control_freq: actions a second, which divides the steps a second; None: ManiSkill's 20, or the next less that
            does.
        params: as for `scenecc.validate`, like the others.
        asset_roots: as for `scenecc.validate`.
        allow_outside_assets: as for `scenecc.validate`.
        limits: as for `scenecc.validate`.

    Raises:
        SceneError: the scene is at fault, its time step is no whole part of a second, or ManiSkill is not installed.
        ValueError: `control_freq` does not divide the steps a second.
    """
    sink = Sink()
    options = Options.of(
        params=params, asset_roots=asset_roots, allow_outside_assets=allow_outside_assets, limits=limits
    )
    config = maniskill.sim_config(compiled(source, options, sink).plan, sink, control_freq)
    if config is None:
        raise SceneError(sink.diagnostics())
    return config
