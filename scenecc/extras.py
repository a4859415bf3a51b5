"""The extras of the package: their purposes, and how to install a missing one."""

from __future__ import annotations

import json
import shlex
from importlib.metadata import PackageNotFoundError, distribution, requires
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, NamedTuple
from urllib.parse import unquote, urlsplit


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
    "mcp": Extra("the server for agents", ("mcp",)),
    "gymnasium": Extra("vector environments of Gymnasium", ("gymnasium",)),
    "sweep": Extra("sweeps over many seeds, as a Parquet table", ("pyarrow",)),
    "ray": Extra("sweeps on a cluster", ("ray", "pyarrow")),
}
"""Extras by name, as in `pyproject.toml`, except those for developers."""


def install_hint(extra: str, *others: str) -> str:
    """Returns the command that installs an extra from where scenecc came. `others`: packages to install before it."""
    return f"run `{' '.join(['pip install', *others, _requirement(extra)])}`"


def install_origin() -> dict[str, Any]:
    """Returns where pip installed scenecc from: `direct_url.json` of PEP 610, which is empty for a package index."""
    clone = Path(__file__).parent.parent
    if (clone / "pyproject.toml").is_file() and (clone / ".git").exists():
        return {"url": clone.as_uri(), "dir_info": {"editable": True}}
    try:
        return json.loads(distribution("scenecc").read_text("direct_url.json") or "{}")
    except PackageNotFoundError:
        return {}


def local_path(url: str) -> Path:
    """Returns the path that a `file:` URL names."""
    return Path(unquote(urlsplit(url).path))


def _requirement(extra: str) -> str:
    """Returns arguments of `pip install`. If the folder or the wheel is gone, these are the packages of the extra."""
    origin = install_origin()
    url, named = origin.get("url", ""), f"scenecc[{extra}]"
    if "vcs_info" in origin:
        vcs = origin["vcs_info"]
        return shlex.quote(f"{named} @ {vcs['vcs']}+{url}@{vcs.get('requested_revision') or vcs['commit_id']}")
    if not url.startswith("file:"):
        return shlex.quote(f"{named} @ {url}" if url else named)
    path = local_path(url)
    if path.exists():
        return "-e " * bool(origin.get("dir_info", {}).get("editable")) + shlex.quote(f"{path}[{extra}]")
    packages = [need.partition(";") for need in requires("scenecc") or ()]
    return " ".join(
        shlex.quote(name.strip()) for name, _, marker in packages if marker.strip() == f"extra == '{extra}'"
    )


DRIVER_HINT: Final = (
    "with a GPU, install its Vulkan driver (in an NVIDIA container, request the capability `graphics`);\n"
    "without one, Mesa's lavapipe, 24.3 or later, renders on the CPU: `apt-get install mesa-vulkan-drivers libvulkan1`"
)
"""How to get a render device, in two lines."""

ROBOTS_HINT: Final = "run `pip install --no-deps mani_skill`: its robots and meshes, without PyTorch"
"""How to get the files of ManiSkill's package, which scenes name by `pkg://mani_skill/…`."""

_ROBOT_FILES: Final = {"panda": "panda/panda_v2.urdf"} | {
    name: f"{name}/{name}.urdf" for name in ("fetch", "so100", "xarm7")
}


def robot_hint(written: str) -> str | None:
    """Returns what to write instead of the bare name of a robot that is in ManiSkill's package, or None."""
    path = _ROBOT_FILES.get(written.lower().removesuffix(".urdf"))
    return path and f"write `pkg://mani_skill/assets/robots/{path}`, after `pip install --no-deps mani_skill`"
