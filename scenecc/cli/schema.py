"""`scenecc schema`."""

from __future__ import annotations

import json

from scenecc.cli.output import print_out


def schema() -> None:
    """Print the JSON Schema of scene files.

    \b
    Examples:
      scenecc schema > scene.schema.json
      # and as the first line of a scene file:
      # yaml-language-server: $schema=scene.schema.json
    """
    import scenecc

    print_out(json.dumps(scenecc.json_schema(), indent=2, ensure_ascii=False) + "\n")
