"""Options of what a page shows, and the address at which it is served."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from ipaddress import ip_address
from typing import Any, Final

_LAST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class ViewOptions:
    """What of a scene file is shown.

    Attributes:
        scene: index of the scene that is shown.
        grid: show all scenes, side by side.
        visual: show bodies as they are seen.
        collision: show what of them collides.
        frames: show the axes of each body and link.
        names: show their names.
        shadows: draw shadows: what a browser that draws without a GPU takes longest for.
        contacts: show where bodies touch, and the forces there.
        hidden: names of entities that are not shown.
    """

    scene: int = 0
    grid: bool = False
    visual: bool = True
    collision: bool = False
    frames: bool = False
    names: bool = False
    shadows: bool = True
    contacts: bool = False
    hidden: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class PageAddress:
    """Where a page is served.

    Attributes:
        host: the address to listen at. At a loopback address, only pages of this machine's own may talk to it.
        port: to listen at; 0: any that is free; None: 8080, or the next one that is free.
        token: what a page's address must carry; None: anyone who reaches the address may use the page.

    Raises:
        ValueError: the host is empty, there is no such port, or the token has no characters or some beyond ASCII.
    """

    host: str = "127.0.0.1"
    port: int | None = None
    token: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if not self.host.strip():  # which the system takes for every address
            raise ValueError("a host is an address or the name of a machine; 0.0.0.0 listens at every address")
        if self.port is not None and not 0 <= self.port <= _LAST_PORT:
            raise ValueError(f"a port is 0 to {_LAST_PORT}, not {self.port}")
        if self.token is not None and not (self.token.isascii() and self.token):
            raise ValueError("a token is one or more ASCII characters")

    @property
    def is_local(self) -> bool:
        """Whether only this machine reaches the address."""
        try:
            return self.host == "localhost" or ip_address(self.host).is_loopback
        except ValueError:  # the name of a machine
            return False


ARGUMENT_TYPES: Mapping[str, Any] = {
    "look": ViewOptions | None,
    "place": PageAddress | None,
    "ready": Callable[[str], None] | None,
    "told": Callable[..., None] | None,
    "steps": int,
    "progress": Callable[[int, int], None] | None,
}
"""Types of the arguments of functions that show scenes, which `scenecc.options.check_types` takes."""
