"""The compiler's front: whatever a source is, to a plan that every check has seen. No engine."""

from scenecc.front.compile import Compiled, compile_source
from scenecc.front.inputs import Source, as_plan, read_input
from scenecc.front.options import Options, indices, select_scenes

__all__ = ["Compiled", "Options", "Source", "as_plan", "compile_source", "indices", "read_input", "select_scenes"]
