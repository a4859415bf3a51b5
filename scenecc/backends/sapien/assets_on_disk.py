"""What SAPIEN remembers of files, and whether it is still true.

PhysX's meshes and the renderer's models and images are kept for the life of the process by path. A
file that was written again keeps its path, and would be built as it was.
"""

from __future__ import annotations

import json
import os
import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote_to_bytes

from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.engine_log import DROPPED_PART, engine_log
from scenecc.plan import MeshGeometry

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.plan import CollisionGeometry, ScenePlan, VisualGeometry

Signature = tuple[tuple[int, int, int, int], ...]
"""Change time, modification time, size and inode of a file and of those that it names."""

_NAMES = re.compile(rb"^\s*(?:mtllib|map_\S+|bump|norm|disp|decal|refl)\s+(?:-\S+\s+\S+\s+)*(\S.*?)\s*$", re.MULTILINE)
_IMAGES = re.compile(rb"<(?:init_from|ref)>\s*([^<]+?)\s*<")
"""Names of images in a COLLADA, and of what else it calls so: no files, which are passed over."""
_HEAD = 1 << 20
"""Bytes of an OBJ or a material library in which names are looked for; they stand at the top."""
_MARGIN = 2_000_000_000
"""Nanoseconds by which the start of the process may be off: the kernel tells its boot time in whole seconds."""


class Remembered:
    """Files that the engine has in one of its caches, as they were when it read them."""

    def __init__(self, clear: Callable[[], None]) -> None:
        self._clear = clear
        self._signatures: dict[str, Signature] = {}

    def refresh(self, paths: Iterable[Path]) -> None:
        """Empties the cache if one of the files that are about to be read is not what the cache may hold.

        A file seen for the first time may have been read by others in this process. What they read is
        still true if the file has not changed since the process started.
        """
        present = {str(path): signature(path) for path in paths}
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
    MESHES.refresh(_paths(plan, (shape.geometry for body in bodies for shape in body.collisions)))
    if rendered:
        textures = (texture for material in plan.visual_materials for texture in material.textures().values())
        indices = (int(index) for texture in textures for index in texture.file.data)
        images = [plan.files[index].path for index in indices]
        LOOKS.refresh([*_paths(plan, (shape.geometry for body in bodies for shape in body.visuals)), *images])


def _paths(plan: ScenePlan, geometries: Iterable[CollisionGeometry | VisualGeometry]) -> list[Path]:
    used: set[int] = set()
    for geometry in geometries:
        if isinstance(geometry, MeshGeometry):
            used.update(geometry.file.data.tolist())
    return [plan.files[index].path for index in sorted(used)]


def signature(path: Path) -> Signature:
    """Tells one state of a file, and of the files that it names, from another; empty for a missing file."""
    found: list[tuple[int, int, int, int]] = []
    for each in (path, *named_by(path)):
        try:
            status = each.stat()
        except OSError:
            continue
        found.append((status.st_ctime_ns, status.st_mtime_ns, status.st_size, status.st_ino))
    return tuple(found)


def crashes_the_reader(path: Path) -> bool:
    """Whether it is a binary PLY on which SAPIEN's reader ends the whole process.

    After the header the reader skips line breaks, also one that is the first byte of the data (one file
    in 128), and then reads indices out of the middle of numbers.
    """
    if path.suffix.lower() != ".ply":
        return False
    with path.open("rb") as file:
        head = file.read(_HEAD)
    return re.match(rb"ply\s.*?\bformat binary_.*?\bend_header\r?\n[\r\n]", head, re.DOTALL) is not None


def named_by(path: Path) -> list[Path]:
    """Buffers and images of a glTF, material libraries of an OBJ and their images, images of a COLLADA.

    Others hold all in one file.
    """
    try:
        match path.suffix.lower():
            case ".gltf" | ".glb":
                document = json.loads(_gltf_text(path))
                items = [item for key in ("buffers", "images") for item in document.get(key, [])]
                return [path.parent / item["uri"] for item in items if not item.get("uri", "data:").startswith("data:")]
            case ".obj":
                libraries = _names_in(path)
                return libraries + [image for library in libraries for image in _names_in(library)]
            case ".dae":
                return [
                    path.parent / os.fsdecode(unquote_to_bytes(name)) for name in _IMAGES.findall(path.read_bytes())
                ]
            case _:
                return []
    except (OSError, ValueError, AttributeError, TypeError, KeyError):
        # Not a file of that kind: the engine will say so.
        return []


def _gltf_text(path: Path) -> bytes:
    """The JSON of a glTF: all of it, or the first chunk of a binary one."""
    with path.open("rb") as file:
        head = file.read(20)
        return file.read(int.from_bytes(head[12:16], "little")) if head[:4] == b"glTF" else head + file.read()


def _names_in(path: Path) -> list[Path]:
    if not path.is_file():
        return []
    with path.open("rb") as file:
        return [path.parent / os.fsdecode(name) for name in _NAMES.findall(file.read(_HEAD))]


def _newest(state: Signature) -> int:
    return max((max(change, modification) for change, modification, _, _ in state), default=0)


def _started() -> int:
    """When this process started [ns since the epoch]; 0, which trusts no file, where the system does not tell."""
    try:
        ticks = int(Path("/proc/self/stat").read_text().rsplit(")", 1)[1].split()[19])
        running = time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError, ValueError, IndexError):
        return 0
    return time.time_ns() - int(running * 1e9)
