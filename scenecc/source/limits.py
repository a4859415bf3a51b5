"""Limits of the resources that a scene file may use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import suggest

MAX_DEPTH = 1000
"""The maximum of `Limits.depth`. libyaml 0.2.6, part of PyYAML 6.0.4, parses no deeper."""

_SCENES_PER_OBJECT = 100
"""Maximum average number of scenes per object at the object limit: 130 000 objects in 65 536 scenes do not fit in
memory."""


@frozen
class Limits:
    """Limits against files that would hang or exhaust a machine. Each is a positive integer.

    Attributes:
        text_bytes: size of a scene file or stream, including all that it includes and uses [bytes of UTF-8].
        depth: nesting of mappings and lists, including the document itself, with aliases followed; and of files that
            include or use one another.
        alias_nodes: nodes reached through aliases and merge keys; each use counts.
        objects: entities; each counts once per shape, and once per eight values.
        scenes: parallel scenes.
        asset_bytes: size of one mesh, texture or robot description [bytes].
    """

    text_bytes: int = 16 * 2**20
    depth: int = 100
    alias_nodes: int = 10_000
    objects: int = 130_000
    scenes: int = 65_536
    asset_bytes: int = 64 * 2**20

    @property
    def objects_in_all_scenes(self) -> int:
        """Maximum number of objects, each counted once per scene; also of values that differ between scenes."""
        return _SCENES_PER_OBJECT * self.objects


def make_limits(changes: Mapping[str, object] | None = None) -> Limits:
    """Returns the default limits with changes.

    Args:
        changes: name of a limit → positive integer, as in `limits={"depth": 200}` or `--limit depth=200`.

    Raises:
        ValueError: a name is not a limit, a value is not a positive integer, or `depth` exceeds `MAX_DEPTH`.
    """
    changes = changes or {}
    known = [field.name for field in fields(Limits)]
    checked: dict[str, int] = {}
    for name, value in changes.items():
        if name not in known:
            raise ValueError(_describe_unknown(name, known))
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise ValueError(f"the limit {name} must be a positive integer, not {value!r}")
        if name == "depth" and value > MAX_DEPTH:
            raise ValueError(f"the limit depth must be at most {MAX_DEPTH}: the YAML parser reads no deeper")
        checked[name] = int(value)
    return replace(Limits(), **checked)


def _describe_unknown(name: object, known: list[str]) -> str:
    return f"there is no limit named {name!r}; {suggest(str(name), known)}"
