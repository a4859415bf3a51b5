"""The extras of the package: what each is for, and how what is missing is installed."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Final, NamedTuple


class Extra(NamedTuple):
    """What an extra is for, and the modules that it brings."""

    purpose: str
    modules: tuple[str, ...]

    @property
    def missing(self) -> list[str]:
        """Its modules that are not installed."""
        return [name for name in self.modules if find_spec(name) is None]


EXTRAS: Final[dict[str, Extra]] = {
    "maniskill": Extra("scenes in ManiSkill's environments", ("mani_skill",)),
    "mjcf": Extra("robots and scenes in MJCF", ("mujoco",)),
    "import": Extra("worlds in SDF and USD", ("lxml", "scipy", "pxr")),
    "export": Extra("USD and a check of MJCF", ("mujoco", "pxr")),
    "convex": Extra("meshes cut into convex parts by CoACD", ("coacd",)),
    "pictures": Extra("films in MP4", ("imageio_ffmpeg",)),
    "view": Extra("the viewer in the browser", ("viser", "watchfiles")),
    "lsp": Extra("the language server for editors", ("pygls",)),
    "gymnasium": Extra("vector environments of Gymnasium", ("gymnasium",)),
    "sweep": Extra("sweeps over many seeds, as a Parquet table", ("pyarrow",)),
    "ray": Extra("sweeps on a cluster", ("ray", "pyarrow")),
}
"""By name, as `pyproject.toml` declares them, but those of its developers."""


def install_hint(extra: str, *others: str) -> str:
    """How an extra is installed: from the clone that this is, or else from an index. `others`: packages before it."""
    before = "".join(f"{other} " for other in others)
    clone = Path(__file__).parent.parent
    if (clone / "pyproject.toml").is_file() and (clone / ".git").exists():
        return f"run `pip install {before}-e '.[{extra}]'` in the clone"
    return f'run `pip install {before}"scenecc[{extra}]"`'


DRIVER_HINT: Final = (
    "with a GPU, install its Vulkan driver (in a container of NVIDIA's, ask for the capability `graphics`);\n"
    "without one, Mesa's lavapipe, 24.3 or later, renders on the CPU: `apt-get install mesa-vulkan-drivers libvulkan1`"
)
"""How to get a render device, in two lines."""
