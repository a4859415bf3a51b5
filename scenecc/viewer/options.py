"""Options of a page, and its address."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from ipaddress import ip_address
from secrets import token_urlsafe
from typing import Any, Final

_LAST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class ViewOptions:
    """What a page shows.

    Attributes:
        scene: index of the displayed scene.
        grid: show all scenes side by side.
        visual: show visual shapes.
        collision: show collision shapes.
        frames: show the axes of each body and link.
        names: show the names of bodies and links.
        lights: light the scenes with the lights of the file, not with neutral light.
        shadows: draw shadows; slow in a browser without a GPU.
        contacts: show contact points and forces.
        hidden: names of hidden entities.
    """

    scene: int = 0
    grid: bool = False
    visual: bool = True
    collision: bool = False
    frames: bool = False
    names: bool = False
    lights: bool = False
    shadows: bool = True
    contacts: bool = False
    hidden: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class PageAddress:
    """Where a page is served.

    Attributes:
        host: address to listen on. A loopback address accepts only pages from this machine.
        port: port to listen on; 0: any free port; None: 8080, or the next free port.
        token: token that the page's address must contain; None: anyone who can reach the address may use the page.
            "auto" becomes a random token if other machines can reach the address, and None if only this one can.

    Raises:
        ValueError: the host is empty, the port is out of range, or the token is empty or not ASCII.
    """

    host: str = "127.0.0.1"
    port: int | None = None
    token: str | None = field(default="auto", repr=False)

    def __post_init__(self) -> None:
        if not self.host.strip():  # the system would use every address
            raise ValueError("a host must be an address or host name; 0.0.0.0 listens on every address")
        if self.port is not None and not 0 <= self.port <= _LAST_PORT:
            raise ValueError(f"a port must be from 0 to {_LAST_PORT}, not {self.port}")
        if self.token is not None and not (self.token.isascii() and self.token):
            raise ValueError("a token must have one or more ASCII characters")
        if self.token == "auto":  # noqa: S105 - not a token
            object.__setattr__(self, "token", None if self.is_local else token_urlsafe())

    @property
    def is_local(self) -> bool:
        """Whether only this machine can reach the address."""
        try:
            return self.host == "localhost" or ip_address(self.host).is_loopback
        except ValueError:  # a host name
            return False


ARGUMENT_TYPES: Mapping[str, Any] = {
    "options": ViewOptions | None,
    "address": PageAddress | None,
    "on_ready": Callable[[str], None] | None,
    "on_diagnostics": Callable[..., None] | None,
    "on_progress": Callable[[int, int], None] | None,
    "steps": int,
    "progress": Callable[[int, int], None] | None,
}
"""Types of the arguments of functions that show scenes, for `scenecc.options.check_types`."""
