"""The command line: one file a command, and no logic that the API does not have.

Importing it loads Typer and nothing heavier; a command loads what it needs when it runs.
"""

from scenecc.cli.app import main

__all__ = ["main"]
