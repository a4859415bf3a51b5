"""The stage: a document and all that it uses, to the data of one scene file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Location, Origin, Sink
from scenecc.diagnostics.messages import cut, suggest
from scenecc.expand.arguments import ParamArgument, bind_params
from scenecc.expand.documents import Load, SceneDocument, top_document
from scenecc.expand.expansion import BudgetExhausted, ExpansionFrame, ExpansionWriter, ObjectBudget
from scenecc.expand.module_compiler import CompiledModule, PrefabLibrary, compile_module
from scenecc.expand.module_expander import ModuleExpander, ModuleScope, SceneSelections
from scenecc.expand.modules import ModuleLibrary
from scenecc.expand.patterns import PatternCompiler
from scenecc.source.plain_data import copy_mapping

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from scenecc.expand.expansion import Expansion
    from scenecc.expand.patterns import NameMeaning
    from scenecc.source import Document, Limits

PARAMS = "params"
"""What diagnostics about arguments of the API or the command line name as their file."""

DRAWS = "draws"
"""Likewise about draws that are given."""

_HEAD = ("scenecc", "name", "description", "num_scenes", "seed")


def expand(
    document: Document,
    *,
    params: Mapping[str, Any],
    num_scenes: int | None,
    seed: int | None,
    draws: Collection[str],
    load: Load,
    limits: Limits,
    sink: Sink,
) -> Expansion | None:
    """Expands a document; None where anything was reported as an error.

    From here on `sink.locate` finds places in all documents. The caller sets `sink.trace` to the expansion's `trace`.

    Args:
        document: the top one, whose data was found to be sound as it is written.
        params: name → value; paths among them are relative to the document's folder.
        num_scenes: in place of the document's.
        seed: in place of the document's.
        draws: names of the shared draws that are given from outside.
        load: reads the files that it uses; see `scenecc.expand.documents.scene_loader`.
        limits: on what it may ask for.
        sink: takes the diagnostics.
    """
    given = copy_mapping(params, sink, limits)
    if given is None:
        return None
    top = top_document(document)
    library = ModuleLibrary(load, limits.includes, sink)
    library.add(top)
    sink.locate = library.locate
    module = library.module(top, None)
    if not module.good:
        return None
    compiled = compile_module(module, None, sink)
    arguments = {name: ParamArgument(value, Location(PARAMS), top, "") for name, value in given.items()}
    head = _expand_head(compiled, arguments, limits, sink)
    output = ExpansionWriter(top.name, sink)
    objects = ObjectBudget("SC604", "objects", "objects", limits.objects)
    instances = ObjectBudget("SC604", "instances", "objects", limits.objects)
    scenes = SceneSelections(_scene_count(head, num_scenes, limits), limits.objects_times_scenes, sink)
    builder = ModuleExpander(output, PrefabLibrary(library, sink), scenes, draws, objects, instances, sink)
    if not _expand_top(builder, compiled, arguments, top, objects, sink):
        return None
    _check_draws(draws, compiled, output, sink)
    if sink.failed:
        return None
    if num_scenes is not None:
        head["num_scenes"] = num_scenes
    if seed is not None:
        head["seed"] = seed
    return output.expansion(head, library.documents)


def _expand_head(
    compiled: CompiledModule, arguments: Mapping[str, ParamArgument], limits: Limits, sink: Sink
) -> dict[str, Any]:
    """What stands before the sections of the top document: it may read parameters, and no number of scenes yet."""
    document = compiled.module.main.document
    data = document.document.data
    head = {key: data[key] for key in _HEAD if key in data}
    if not any(isinstance(item, str) and "${" in item for item in head.values()):
        return head
    few = ObjectBudget("SC604", "objects", "objects", limits.objects)
    try:
        early = bind_params(
            compiled,
            arguments,
            {},
            scope="",
            use=None,
            material=lambda _, argument: argument.value,
            objects=few,
            sink=Sink(),  # all this is told when the parameters are bound for good
        )
    except BudgetExhausted:
        return head
    frame = ExpansionFrame(document.name, None, early.values, few, sink)
    names: dict[str, NameMeaning] = dict.fromkeys(compiled.params, "parameter")
    for key, item in head.items():
        pattern = PatternCompiler(names, frame, f"`{key}`").pattern(item, (key,))
        if pattern is not None:
            head[key] = pattern.make(frame)
    return head


def _scene_count(head: Mapping[str, Any], num_scenes: int | None, limits: Limits) -> int:
    """How many scenes there are. `num_scenes`: in place of what the head says."""
    count = head.get("num_scenes", 1) if num_scenes is None else num_scenes
    # For a number that cannot be nothing is made, and the stages after this one tell it.
    return count if type(count) is int and 1 <= count <= limits.scenes else 1


def _expand_top(
    builder: ModuleExpander,
    compiled: CompiledModule,
    arguments: Mapping[str, ParamArgument],
    top: SceneDocument,
    objects: ObjectBudget,
    sink: Sink,
) -> bool:
    """Writes all that the top module makes; False, reported, where that is too much."""
    try:
        objects.take(compiled.weight, ExpansionFrame(top.name, None, {}, objects, sink), ())
        bound = builder.bind(compiled, arguments, scope="", use=Location(PARAMS))
        builder.expand(ModuleScope(compiled, "", "", None, None, dict(bound.values), bound.failed, (top,)), bound)
    except BudgetExhausted:
        return False
    except RecursionError:
        # With the limit raised: a use takes several calls.
        sink.report("SC608", "prefabs are deeper within one another than Python's stack allows", Origin(top.name))
        return False
    return True


def _check_draws(draws: Collection[str], compiled: CompiledModule, output: ExpansionWriter, sink: Sink) -> None:
    """Reports draws that are given and that nothing has."""
    known = dict.fromkeys((*compiled.draws, *output.sections["draws"]))
    for name in map(str, draws):
        if name not in known:
            message = f"there is no shared draw `{cut(name)}`"
            sink.report("SC250", message, Location(DRAWS), hint=suggest(name, known))
