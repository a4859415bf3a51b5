"""Pictures and films of a scene, as `scenecc render` writes them: build, simulate, look."""

from scenecc.render.render import RenderChoices, render_scene
from scenecc.render.results import LegendRow, Picture, Rendering

__all__ = ["LegendRow", "Picture", "RenderChoices", "Rendering", "render_scene"]
