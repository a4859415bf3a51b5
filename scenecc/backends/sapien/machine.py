"""What this machine can do besides physics."""

from __future__ import annotations

from functools import cache

from scenecc.backends.sapien.engine import render


@cache
def render_problem() -> str | None:
    """Why SAPIEN cannot render here, in its own words; None where it can. Asked once a process."""
    try:
        render.RenderSystem()
    except RuntimeError as error:
        return str(error)
    return None
