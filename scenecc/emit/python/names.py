"""Names of things as Python identifiers, each used once."""

from __future__ import annotations

import builtins
import keyword
import re

_SCRIPT = {
    "FILES", "HERE", "Iterator", "Path", "articulation", "asset_file", "atexit", "base64", "body", "body_name",
    "body_names", "build_scenes", "builder", "coacd", "component", "config", "constraint", "contextmanager",
    "convex_parts", "default_material", "entities", "entity", "file", "functools", "held", "i", "importlib",
    "joint", "joint_name", "joint_names", "k", "links", "look", "main", "mirrored", "name", "np", "os",
    "package_file", "packed_file", "parts", "physics_settings", "physx", "qpos", "render", "sapien", "scene",
    "scenes", "shape", "shutil", "systems", "target", "targets", "tempfile", "trimesh", "zlib",
}  # fmt: skip
"""What a script itself may use."""


class Names:
    """Hands out identifiers that clash neither with one another nor with what a script uses."""

    def __init__(self) -> None:
        self._taken = {*_SCRIPT, *keyword.kwlist, *keyword.softkwlist, *dir(builtins)}
        self._last: dict[str, int] = {}
        self._local: dict[str, str] = {}

    def take(self, wanted: str) -> str:
        """An identifier like `wanted`: what no identifier may hold becomes `_`, and `_2` tells namesakes apart."""
        stem = re.sub(r"[^A-Za-z0-9_]+", "_", wanted[:60]).strip("_") or "unnamed"
        if stem[0].isdigit() or len(stem) == 1:  # a lone l, O or I is taken for a digit
            stem = f"the_{stem}"
        count = self._last.get(stem, 1)
        name = stem
        while name in self._taken:
            count += 1
            name = f"{stem}_{count}"
        self._last[stem] = count
        self._taken.add(name)
        return name

    def local(self, wanted: str) -> str:
        """An identifier for what is made anew in every block that speaks of it: the same for the same text."""
        if wanted not in self._local:
            self._local[wanted] = self.take(wanted)
        return self._local[wanted]
