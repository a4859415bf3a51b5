"""Pictures and videos of a scene for `scenecc render`: build, simulate, take pictures."""

from scenecc.render.choices import RenderChoices
from scenecc.render.recorder import Picture
from scenecc.render.render import LegendRow, Rendering, render_scene

__all__ = ["LegendRow", "Picture", "RenderChoices", "Rendering", "render_scene"]
