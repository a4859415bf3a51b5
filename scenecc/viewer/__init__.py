"""Scenes in a browser: a page served by viser, the live objects behind it, and the watched files."""

from scenecc.viewer.options import PageAddress, ViewOptions
from scenecc.viewer.view import ScenePage, page_of_source, view_scene

__all__ = ["PageAddress", "ScenePage", "ViewOptions", "page_of_source", "view_scene"]
