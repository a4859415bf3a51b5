"""Builds and simulates a scene for `scenecc render`, and takes pictures and films."""

from scenecc.render.choices import RenderChoices
from scenecc.render.recorder import Picture
from scenecc.render.render import LegendRow, Rendering, render_scene

__all__ = ["LegendRow", "Picture", "RenderChoices", "Rendering", "render_scene"]
