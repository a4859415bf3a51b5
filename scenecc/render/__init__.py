"""Pictures and films of a scene, as `scenecc render` writes them: build, simulate, look."""

from scenecc.render.render import LegendRow, Picture, RenderChoices, Rendering, render_scene

__all__ = ["LegendRow", "Picture", "RenderChoices", "Rendering", "render_scene"]
