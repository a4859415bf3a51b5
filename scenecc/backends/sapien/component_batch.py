"""One thing of the plan that is a component of the engine in each scene: what lights, cameras and constraints share."""

from __future__ import annotations

from typing import Any


class ComponentBatch:
    """One thing of the plan, in every scene that has it.

    Args:
        name: in the plan.
        scene_idxs: the scenes of the batch that have it, ascending.
        objs: its components in this order.
    """

    def __init__(self, name: str, scene_idxs: tuple[int, ...], objs: list[Any]) -> None:
        self._name = name
        self._scene_idxs = scene_idxs
        self._objs = objs
        self._closed = False

    def __len__(self) -> int:
        return len(self._scene_idxs)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._name!r}, scene_idxs={list(self._scene_idxs)})"

    @property
    def name(self) -> str:
        """Its name in the plan; the components have the same."""
        return self._name

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Indices among all scenes of the plan: those of this batch that have it."""
        return self._scene_idxs

    @property
    def objs(self) -> list[Any]:
        """SAPIEN's component in each of these scenes. Raises RuntimeError once the batch is closed."""
        if self._closed:
            raise RuntimeError(f"the scenes of '{self._name}' are closed")
        return self._objs

    def _close(self) -> None:
        self._closed = True
        self._objs = []
