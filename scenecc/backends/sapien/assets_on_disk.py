"""What SAPIEN remembers of files, and whether it is still true.

PhysX's meshes and the renderer's models and images are kept for the life of the process by path. A
file that was written again keeps its path, and would be built as it was.
"""

from __future__ import annotations

import os
import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.engine_log import DROPPED_PART, engine_log
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.files import State, open_regular, state_now
from scenecc.plan import MeshGeometry

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.plan import AssetFile, ScenePlan

Signature = tuple[State, ...]
"""Of a file and of those that it names."""

_HEAD = 1 << 20
"""Bytes in which the header of a PLY ends."""
_MARGIN = 2_000_000_000
"""Nanoseconds by which the start of the process may be off: the kernel tells its boot time in whole seconds."""


class Remembered:
    """Files that the engine has in one of its caches, as they were when it read them."""

    def __init__(self, clear: Callable[[], None]) -> None:
        self._clear = clear
        self._signatures: dict[str, Signature] = {}

    def refresh(self, files: Iterable[AssetFile]) -> None:
        """Empties the cache if one of the files that are about to be read is not what the cache may hold.

        A file seen for the first time may have been read by others in this process. What they read is
        still true if the file has not changed since the process started.
        """
        present = {str(file.path): signature(file) for file in files}
        known = self._signatures
        if any(known[p] != s if p in known else _newest(s) > _started() - _MARGIN for p, s in present.items()):
            self.forget()
        known.update(present)

    def forget(self) -> None:
        """Empties the cache."""
        self._clear()
        self._signatures.clear()


MESHES = Remembered(physx.clear_cache)
"""What PhysX has cooked."""

LOOKS = Remembered(lambda: render.clear_cache(models=True, images=True))
"""What the renderer has loaded."""


def all_parts(load: Callable[[], Any]) -> Any:
    """What `load` gives of a mesh's parts.

    Raises:
        ValueError: the engine cannot cook some. SAPIEN leaves these out and says so in its log alone.
    """
    with engine_log() as log:
        made = load()
    if (dropped := log.text.count(DROPPED_PART)) > 0:
        # The next one to ask would get what is left of the parts from the cache, without a word.
        MESHES.forget()
        raise ValueError(f"{dropped} of the mesh's parts cannot be cooked")
    return made


def refresh(plan: ScenePlan, *, rendered: bool) -> None:
    """To be called before the plan's files are read: nothing that has changed is taken from a cache."""
    if not plan.files:
        return
    bodies = [body for entity in plan.entities for body in entity.bodies]
    used: set[int] = set()
    for geometry in (shape.geometry for body in bodies for shape in body.collisions):
        if isinstance(geometry, MeshGeometry):
            used.update(geometry.file.data.tolist())
    MESHES.refresh(plan.files[index] for index in sorted(used))
    if rendered:
        LOOKS.refresh(plan.files)


def signature(file: AssetFile) -> Signature:
    """Tells one state of a file, and of those that it names, from another; empty for a missing file."""
    states = [state_now(path) for path in (file.path, *(one.path for one in file.names)) if path is not None]
    return tuple(state for state in states if state is not None)


def check_unchanged(files: Iterable[AssetFile]) -> None:
    """Whether files are what they were when they were checked: the engine opens them by their names.

    Raises:
        EngineFailure: one is not.
    """
    for file in files:
        for one in (file, *file.names):
            if one.state is not None and one.path is not None and state_now(one.path) != one.state:
                hint = "build it again, when all is written"
                raise EngineFailure("SC422", f"'{one.path}' changed while the scene was built", hint=hint)


def crashes_the_reader(path: Path) -> bool:
    """Whether it is a binary PLY on which SAPIEN's reader ends the whole process.

    After the header the reader skips line breaks, also one that is the first byte of the data (one file
    in 128), and then reads indices out of the middle of numbers.
    """
    if path.suffix.lower() != ".ply":
        return False
    with open_regular(path) as file:
        head = file.read(_HEAD)
    return re.match(rb"ply\s.*?\bformat binary_.*?\bend_header\r?\n[\r\n]", head, re.DOTALL) is not None


def _newest(state: Signature) -> int:
    return max((max(times) for _, _, _, *times in state), default=0)


def _started() -> int:
    """When this process started [ns since the epoch]; 0, which trusts no file, where the system does not tell."""
    try:
        ticks = int(Path("/proc/self/stat").read_text().rsplit(")", 1)[1].split()[19])
        running = time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError, ValueError, IndexError):
        return 0
    return time.time_ns() - int(running * 1e9)
