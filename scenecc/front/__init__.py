"""The compiler's front: whatever a source is, to a plan that every check has seen. No engine."""

from scenecc.front.compile import Compiled, compile_source
from scenecc.front.inputs import Source
from scenecc.front.options import Options, integer, select_scenes

__all__ = ["Compiled", "Options", "Source", "compile_source", "integer", "select_scenes"]
