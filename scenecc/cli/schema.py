"""`scenecc schema`."""

from __future__ import annotations

from scenecc.cli.output import print_json


def schema() -> None:
    """Print the JSON Schema of scene files.

    \b
    Examples:
      scenecc schema > scene.schema.json
      # and as the first line of a scene file:
      # yaml-language-server: $schema=scene.schema.json
    """
    import scenecc

    print_json(scenecc.json_schema())
