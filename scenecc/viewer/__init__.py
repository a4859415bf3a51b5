"""Looking at scenes in a browser: a page that viser serves, live objects behind it, and files that are watched."""

from scenecc.viewer.options import PageAddress, ViewOptions
from scenecc.viewer.view import ScenePage, page_of_source, view_scene

__all__ = ["PageAddress", "ScenePage", "ViewOptions", "page_of_source", "view_scene"]
