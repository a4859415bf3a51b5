"""Pictures and films of a scene, as `scenecc render` writes them: build, simulate, look."""

from scenecc.rendering.render import render_scene
from scenecc.rendering.taken import LegendRow, Picture, Rendering

__all__ = ["LegendRow", "Picture", "Rendering", "render_scene"]
