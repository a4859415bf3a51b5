"""What is looked at, and where a page is shown."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Look:
    """What of a scene file is shown.

    Attributes:
        scene: index of the scene that is shown.
        grid: show all scenes, side by side.
        visual: show bodies as they are seen.
        collision: show what of them collides.
        frames: show the axes of each body and link.
        names: show their names.
        shadows: draw shadows: what a browser that draws without a GPU takes longest for.
    """

    scene: int = 0
    grid: bool = False
    visual: bool = True
    collision: bool = False
    frames: bool = False
    names: bool = False
    shadows: bool = True


@dataclass(frozen=True, slots=True)
class Place:
    """Where a page is served.

    Attributes:
        host: the address to listen at. At a loopback address, only pages of this machine's own may talk to it.
        port: to listen at; 0: any that is free; None: 8080, or the next one that is free.
    """

    host: str = "127.0.0.1"
    port: int | None = None
