"""Why scenes are not built on the GPU: in this version always for one of these reasons."""

from __future__ import annotations

import ctypes
import platform
from pathlib import Path

from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.failure import EngineFailure

RELEASES = "https://github.com/sapien-sim/physx-precompiled/releases/download"
_ARCHIVES = {
    ("Linux", "x86_64"): "linux-so.zip",
    ("Linux", "AMD64"): "linux-so.zip",
    ("Linux", "aarch64"): "linux-aarch64-so.zip",
    ("Linux", "arm64"): "linux-aarch64-so.zip",
    ("Windows", "AMD64"): "windows-dll.zip",
}


def library() -> Path:
    """Where `sapien.physx.enable_gpu` looks for PhysX's GPU library, and would download it to."""
    name = "PhysXGpu_64.dll" if platform.system() == "Windows" else "libPhysXGpu_64.so"
    return Path.home() / ".sapien" / "physx" / physx.version() / name


def refusal() -> EngineFailure:
    """The first thing that stands in the way. Nothing is downloaded and nothing is written."""
    path = library()
    archive = _ARCHIVES.get((platform.system(), platform.machine()))
    if archive is None:
        return _no(f"SAPIEN has no GPU physics for {platform.system()} on {platform.machine()}", "use the cpu backend")
    if not path.is_file():
        url = f"{RELEASES}/{physx.version()}/{archive}"
        return _no(
            f"PhysX's GPU library is not at '{path}'",
            f"use the cpu backend, the one that this version runs; SAPIEN's GPU physics wants {url} unpacked into "
            f"'{path.parent}' (scenecc downloads nothing)",
        )
    driver = "nvcuda.dll" if platform.system() == "Windows" else "libcuda.so.1"
    try:
        ctypes.CDLL(driver)
    except OSError:
        return _no(f"there is no CUDA driver on this machine: '{driver}' cannot be loaded", "use the cpu backend")
    return _no("this version of scenecc does not run scenes on the GPU yet", "use the cpu backend")


def _no(message: str, hint: str) -> EngineFailure:
    return EngineFailure("SC804", message, hint=hint)
