"""Bodies that constraints, lights and cameras hold on to: kept by scene and name while the entities are built."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.layout import Node, Source, string

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import Mount


class Held:
    """What of a plan is held on to."""

    def __init__(self, plan: ScenePlan) -> None:
        mounts = [mount for constraint in plan.constraints for mount in (constraint.child, constraint.parent)]
        mounts += [item.mount for section in (plan.lights, plan.cameras) for item in section]
        self._links: dict[str, dict[str | None, None]] = {}
        for mount in mounts:
            if mount is not None:
                self._links.setdefault(mount.entity, {})[mount.link] = None

    @staticmethod
    def expression(mount: Mount) -> str:
        """The `sapien.Entity` that is held on to, in `scene`."""
        link = "" if mount.link is None else f", {string(mount.link)}"
        return f"held[scene, {string(mount.entity)}{link}]"

    def is_body(self, names: tuple[str, ...]) -> bool:
        """Whether an entity of one of these names is held on to as a body."""
        return None in self._of(names)

    def links(self, names: tuple[str, ...]) -> list[str]:
        """The links of them that are held on to."""
        return [link for link in self._of(names) if link is not None]

    def _of(self, names: tuple[str, ...]) -> dict[str | None, None]:
        return {link: None for name in names for link in self._links.get(name, ())}

    def write_head(self, source: Source) -> None:
        """The dictionary, where anything is held on to."""
        if self._links:
            source.line()
            source.comment("What constraints, lights and cameras hold on to, by scene and name.")
            source.line("held = {}")

    @staticmethod
    def write_body(source: Source, name: Node, entity: str) -> None:
        """Keeps a body. `name`: an expression for its entity's name. `entity`: one for the entity."""
        source.statement(entity, assign=f"held[scene, {name}]")

    @staticmethod
    def write_link(source: Source, name: Node, link: str, entity: str) -> None:
        """Keeps a link, likewise."""
        source.statement(entity, assign=f"held[scene, {name}, {string(link)}]")
