"""Keys and forms of the language that this version refuses by name rather than as unknown."""

from __future__ import annotations

LEFT_OUT: dict[str, str] = {
    "tendons": "tendons",
    "stereo": "stereo depth sensors",
    "point_clouds": "point clouds",
    "point_cloud": "point clouds",
    "vertices": "vertices in the file",
    "triangles": "vertices in the file",
    "faces": "vertices in the file",
    "properties": "render properties by name",
    "cone": "cone limits (SAPIEN records them and never applies them)",
    "pyramid": "pyramid limits (SAPIEN records them and never applies them)",
    "is_trigger": "triggers (SAPIEN records `is_trigger` and never applies it)",
    "trigger": "triggers (SAPIEN records `is_trigger` and never applies it)",
}
"""Keys that version 1 of the language leaves out, and what they would be."""
