"""What stands between a source and a checked plan: its reading, and the stages one after the other."""

from scenecc.front.compile import Audit, Backend, Compiled, compile_source, compiled, instantiated
from scenecc.front.inputs import Source, as_plan, read_input
from scenecc.front.options import Options, indices, select_scenes

__all__ = [
    "Audit",
    "Backend",
    "Compiled",
    "Options",
    "Source",
    "as_plan",
    "compile_source",
    "compiled",
    "indices",
    "instantiated",
    "read_input",
    "select_scenes",
]
