"""A scene file as it was compiled for a page, or what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Sink
from scenecc.emit.problems import tell_problem
from scenecc.meshes import Drawer
from scenecc.pipeline import compile_source, compiled_params
from scenecc.source.paths import Memory

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.expand.listing import ParamRow
    from scenecc.options import Options
    from scenecc.pipeline import Source
    from scenecc.plan import ScenePlan


@dataclass(frozen=True, slots=True)
class Loaded:
    """A scene that was compiled.

    Attributes:
        plan: of it.
        params: of the file, in order.
        given: values of parameters with which it was compiled.
        sink: what was said of it, warnings and notes; what is found later is reported there, too.
        drawer: of its bodies.
    """

    plan: ScenePlan
    params: tuple[ParamRow, ...]
    given: Mapping[str, Any]
    sink: Sink
    drawer: Drawer


@dataclass(frozen=True, slots=True)
class Loading:
    """What came of compiling a scene.

    Attributes:
        loaded: the scene; None: there is an error.
        diagnostics: all that was found.
        files: that it used or looked for.
    """

    loaded: Loaded | None
    diagnostics: list[Diagnostic]
    files: frozenset[Path]


def load(source: Source, options: Options, given: Mapping[str, Any]) -> Loading:
    """Compiles a scene. `given`: values of parameters, beside those of the options and before them."""
    sink, memory = Sink(), Memory()
    params = {**options.params, **given}
    found = compile_source(source, replace(options, params=params), sink, memory=memory)
    files = frozenset({*memory.named, *memory.missing})
    if found is None:
        return Loading(None, sink.diagnostics(), files)
    listed = tuple(compiled_params(found, options.limits))
    drawer = Drawer(found.plan, lambda problem, origin: tell_problem(problem, origin, sink))
    return Loading(Loaded(found.plan, listed, params, sink, drawer), sink.diagnostics(), files)
