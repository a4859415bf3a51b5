"""Settings that SAPIEN keeps for the whole process, in a script: set while its scenes are built, then put back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.columns import number
from scenecc.emit.python.layout import Group, Node, Source, call, list_of
from scenecc.plan.physics import SCENE_CONFIG_FIELDS, process_wide_settings

if TYPE_CHECKING:
    from scenecc.plan import Physics


class Settings:
    """The defaults that a plan changes."""

    def __init__(self, physics: Physics) -> None:
        self._workers = physics.cpu_workers
        self._changes = {
            kind: {name: _node(value) for name, value in given.items()}
            for kind, given in process_wide_settings(physics).items()
        }

    @property
    def needed(self) -> bool:
        """Whether any is changed."""
        return bool(self._kinds())

    def imports(self) -> list[str]:
        """What `write` needs of the standard library."""
        if not self.needed:
            return []
        return ["from collections.abc import Iterator", "from contextlib import contextmanager"]

    def write(self, source: Source) -> None:
        """A context manager `physics_settings`."""
        if not self.needed:
            return
        source.line()
        source.line()
        source.line("@contextmanager")
        with source.block("def physics_settings() -> Iterator[None]:"):
            source.line('"""SAPIEN keeps these for the whole process: they are put back once the scenes are built."""')
            for kind in self._kinds():
                source.line(f"{kind}_config = physx.get_{kind}_config()")
            for kind in self._kinds():
                self._write_change(source, kind)
            with source.block("try:"):
                source.line("yield")
            with source.block("finally:"):
                for kind in self._kinds():
                    source.line(f"physx.set_{kind}_config({kind}_config)")

    def _kinds(self) -> list[str]:
        return [
            kind for kind, table in self._changes.items() if table or (kind == "scene" and self._workers is not None)
        ]

    def _write_change(self, source: Source, kind: str) -> None:
        source.line(f"config = physx.get_{kind}_config()")
        for name, node in self._changes[kind].items():
            source.statement(node, assign=f"config.{name}")
        source.statement(self._setter(kind))

    def _setter(self, kind: str) -> Group:
        if kind != "scene" or self._workers is None:
            return call(f"physx.set_{kind}_config", "config")
        # The number of workers is no property of the object, and the call that takes it sets everything.
        everything: dict[str, Node] = {name: f"config.{name}" for name in SCENE_CONFIG_FIELDS}
        return call("physx.set_scene_config", **everything, cpu_workers=str(self._workers))


def _node(value: float | tuple[float, ...]) -> Node:
    if isinstance(value, tuple):
        return list_of([number(float(x)) for x in value])
    return number(value)
