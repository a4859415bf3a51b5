"""The extras of the package: their purposes, and how to install a missing one."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Final, NamedTuple


class Extra(NamedTuple):
    """The purpose of an extra, and the modules that it installs."""

    purpose: str
    modules: tuple[str, ...]

    @property
    def missing(self) -> list[str]:
        """Its modules that are not installed."""
        return [name for name in self.modules if find_spec(name) is None]


EXTRAS: Final[dict[str, Extra]] = {
    "maniskill": Extra("scenes in ManiSkill's environments", ("mani_skill", "gymnasium", "torch")),
    "mjcf": Extra("robots and scenes in MJCF", ("mujoco",)),
    "import": Extra("worlds in SDF and USD", ("lxml", "scipy", "pxr")),
    "export": Extra("USD and a check of MJCF", ("mujoco", "pxr")),
    "convex": Extra("convex decomposition of meshes by CoACD", ("coacd",)),
    "pictures": Extra("videos in MP4", ("imageio_ffmpeg",)),
    "view": Extra("the viewer in the browser", ("viser", "watchfiles")),
    "lsp": Extra("the language server for editors", ("pygls",)),
    "gymnasium": Extra("vector environments of Gymnasium", ("gymnasium",)),
    "sweep": Extra("sweeps over many seeds, as a Parquet table", ("pyarrow",)),
    "ray": Extra("sweeps on a cluster", ("ray", "pyarrow")),
}
"""Extras by name, as in `pyproject.toml`, except those for developers."""


def install_hint(extra: str, *others: str) -> str:
    """Returns how to install an extra: from this clone, or else from the package index. `others`: packages to install
    before it.
    """
    before = "".join(f"{other} " for other in others)
    clone = Path(__file__).parent.parent
    if (clone / "pyproject.toml").is_file() and (clone / ".git").exists():
        return f"run `pip install {before}-e '.[{extra}]'` in the clone"
    return f'run `pip install {before}"scenecc[{extra}]"`'


DRIVER_HINT: Final = (
    "with a GPU, install its Vulkan driver (in an NVIDIA container, request the capability `graphics`);\n"
    "without one, Mesa's lavapipe, 24.3 or later, renders on the CPU: `apt-get install mesa-vulkan-drivers libvulkan1`"
)
"""How to get a render device, in two lines."""

ROBOTS_HINT: Final = "run `pip install --no-deps mani_skill`: its robots and meshes, without PyTorch"
"""How to get the files of ManiSkill's package, which scenes name by `pkg://mani_skill/…`."""
