"""What this machine can do besides physics."""

from __future__ import annotations

from functools import cache
from typing import Any

from scenecc.backends.sapien.engine import render


def new_render_system() -> Any:
    """A `sapien.render.RenderSystem`. Raises RuntimeError where no device renders."""
    return render.RenderSystem()


@cache
def traces_rays() -> bool:
    """Whether the device that SAPIEN renders with can trace rays. Asked once a process.

    SAPIEN tells its log where it cannot, and crashes with the first picture.

    Raises:
        RuntimeError: no device renders.
    """
    return can_trace(render.get_device_summary(), new_render_system().device.name)


def can_trace(summary: str, name: str) -> bool:
    """What SAPIEN's summary of devices says of those of a name; True where it names none of them."""
    devices = [device.splitlines() for device in summary.split("GPU: ")[1:]]
    said = [line for title, *lines in devices if title.strip() == name for line in lines if "rayTrace:" in line]
    return not said or any(line.split()[-1] == "1" for line in said)


@cache
def render_problem() -> str | None:
    """Why SAPIEN cannot render here, in its own words; None where it can. Asked once a process."""
    try:
        new_render_system()
    except RuntimeError as error:
        return str(error)
    return None
