"""What stands in the scenes, for whatever is built once all entities of a scene are there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.turn import ArticulationTurn

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.backends.sapien.turn import AnyTurn
    from scenecc.plan.body import Mount


class Standing:
    """Bodies by their mounts.

    Attributes:
        scene_idxs: which of the plan's scenes are built, ascending.
        scenes: the `sapien.Scene`s in this order.
    """

    def __init__(self, scene_idxs: tuple[int, ...], scenes: list[Any], turns: Sequence[AnyTurn]) -> None:
        self.scene_idxs = scene_idxs
        self.scenes = scenes
        self._turns = {turn.entity.name: turn for turn in turns}
        self._row_of = {turn.entity.name: {index: row for row, index in enumerate(turn.scene_idxs)} for turn in turns}

    def component(self, mount: Mount, number: int) -> Any:
        """The physical component that a mount names in the scene of a number: of a body, or of a link.

        None for a body of the type none. An articulation itself stands for its root.

        Raises:
            KeyError: the entity is not in this scene, or has no such link there.
        """
        turn = self._turns[mount.entity]
        row = self._row_of[mount.entity][self.scene_idxs[number]]
        if not isinstance(turn, ArticulationTurn):
            if mount.link is not None:
                raise KeyError(mount.link)
            return turn.components[row]
        if mount.link is None:
            return turn.links[row][0]
        return named(turn.links[row], mount.link)

    def entity(self, mount: Mount, number: int) -> Any:
        """The `sapien.Entity` of it. Raises KeyError as `component` does."""
        turn = self._turns[mount.entity]
        if isinstance(turn, ArticulationTurn):
            return self.component(mount, number).get_entity()
        if mount.link is not None:
            raise KeyError(mount.link)
        return turn.objs[self._row_of[mount.entity][self.scene_idxs[number]]]

    def entities(self, index: int) -> Iterator[tuple[str, Any]]:
        """The `sapien.Entity`s of a scene of the plan by name, those of links as ENTITY/LINK."""
        for name, turn in self._turns.items():
            row = self._row_of[name].get(index)
            if row is None:
                continue
            if not isinstance(turn, ArticulationTurn):
                yield name, turn.objs[row]
                continue
            for link in turn.links[row]:
                yield f"{name}/{link.get_name()}", link.get_entity()


def named(links: Sequence[Any], name: str) -> Any:
    """The link of a name. Raises KeyError."""
    for link in links:
        if link.get_name() == name:
            return link
    raise KeyError(name)
