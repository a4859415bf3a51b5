"""Looking at scenes in a browser: a page that viser serves, live objects behind it, and files that are watched."""

from scenecc.viewing.look import Look, Place
from scenecc.viewing.view import export_page, view_scene

__all__ = ["Look", "Place", "export_page", "view_scene"]
