"""What the names of a document mean where they are written: inside an instance, what is inside of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from scenecc.spec.params import ParamType

WORLD = "world"


def _nothing() -> dict[str, str]:
    return {}


@dataclass(frozen=True, slots=True)
class NameScopes:
    """How names are looked up; of a file without instances as they are written.

    Attributes:
        scopes: entity or frame → the instance that it is inside of.
        prefixes: scope → what stands before the names of its entities and frames.
        anchors: scope → the frame in which it stands.
        given: draws that stand for what a `with` says → the scope in which that is written.
        used_materials: materials that a `with` names.
        wanted: draws that stand for parameters → what the parameter takes.
    """

    scopes: Mapping[str, str] = field(default_factory=_nothing)
    prefixes: Mapping[str, str] = field(default_factory=_nothing)
    anchors: Mapping[str, str] = field(default_factory=_nothing)
    given: Mapping[str, str] = field(default_factory=_nothing)
    used_materials: Iterable[str] = ()
    wanted: Mapping[str, ParamType] = field(default_factory=dict)  # pyright: ignore[reportUnknownVariableType]

    def parent(self, name: str, relative_to: str | None) -> str | None:
        """What an entity or a frame stands relative to; None: the world.

        Args:
            name: of the entity or frame.
            relative_to: as written in its pose.
        """
        scope = self.scopes.get(name, "")
        if relative_to in (None, WORLD):
            return self.anchors.get(scope) if scope else None
        return self.prefixes.get(scope, "") + relative_to

    def seen_by(self, name: str, names: Iterable[str]) -> Iterator[str]:
        """The entities and frames that something may stand relative to, as it would write them."""
        scope = self.scopes.get(name, "")
        prefix = self.prefixes.get(scope, "")
        return (
            other[len(prefix) :]
            for other in names
            if other != name and self.scopes.get(other, "") == scope and other.startswith(prefix)
        )


def scope_of(name: str) -> str:
    """The scope of a material, group or draw of the expansion."""
    return name.rpartition("/")[0]


def qualified(name: str, scope: str) -> str:
    """The full name of a material, group or draw that is named in a scope; after a `/` it is one of the whole."""
    if name.startswith("/"):
        return name[1:]
    return f"{scope}/{name}" if scope else name
