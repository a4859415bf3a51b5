"""What this machine can do besides physics."""

from __future__ import annotations

from functools import cache
from typing import Any

from scenecc.backends.sapien.engine import render


def new_render_system() -> Any:
    """A `sapien.render.RenderSystem`. Raises RuntimeError where no device renders."""
    return render.RenderSystem()


@cache
def render_problem() -> str | None:
    """Why SAPIEN cannot render here, in its own words; None where it can. Asked once a process."""
    try:
        new_render_system()
    except RuntimeError as error:
        return str(error)
    return None
