"""The stages from a source to a checked plan, in order, and from a plan to live scenes."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TypeGuard, Union

from typing_extensions import TypedDict

from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import CODES, is_of_check
from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.diagnostic import STAGES, Location, Origin, report_invalid, report_unused
from scenecc.diagnostics.frozen import frozen
from scenecc.errors import SceneError
from scenecc.files import PACK_SUFFIX
from scenecc.named_files import RobotReads, mesh_measurer, mesh_reader, named_resolver, resolver
from scenecc.options import integer
from scenecc.source import Document, Limits, read_dict, read_text
from scenecc.source.paths import AssetScope, PathCache, ResolvedFile
from scenecc.source.provenance import Provenance, portable_path
from scenecc.source.text import TextLines, decode_text, read_bytes, read_from_stream
from scenecc.variation.chosen import DrawRecord

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch
    from scenecc.backends.sapien.passport import Start
    from scenecc.expand.documents import SceneDocument
    from scenecc.expand.expansion import Expansion
    from scenecc.expand.listing import ParamRow
    from scenecc.lower import Lowered
    from scenecc.lower.references import RobotReader, RobotRequest
    from scenecc.options import Options
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import AssetFile
    from scenecc.robots.description import RobotDescription
    from scenecc.source.pack import Pack
    from scenecc.spec.document import SceneFile
    from scenecc.starts.apply import KnownStarts

Source = Union[str, "PathLike[str]", IO[str], IO[bytes], Mapping[str, Any], Document, "ScenePlan", "CompiledSource"]
"""A path (also of a pack), an open stream, a mapping, a read document, a plan, the JSON of a plan, or a compiled
source."""

_PLAN_KEY = "scenecc_plan"
_PLAN_TEXT = re.compile(r'\s*\{\s*"scenecc_plan"\s*:')


@frozen
class Input:
    """A source that was read.

    Attributes:
        document: the scene.
        plan_text: the text of a plan; None for a scene.
        pack: the pack that contains it, if any.
    """

    document: Document
    plan_text: str | None = None
    pack: Pack | None = None

    def scope(self, options: Options, memory: PathCache | None = None) -> AssetScope:
        """Returns what the scene may read. `memory`: records what is looked up."""
        memory = memory or PathCache()
        if self.pack is not None:
            return self.pack.scope(memory)
        root = self.document.path.parent if self.document.path else None
        return AssetScope(root, options.asset_roots, options.allow_outside_assets, memory)


def run_seeds(options: Options, seeds: Iterable[int] | None) -> list[Options]:
    """Returns the options of each of some seeds; None: only the given options.

    Raises:
        ValueError: the options have a seed too, or a seed is negative.
        TypeError: a seed is not an integer.
    """
    if seeds is not None and options.seed is not None:
        raise ValueError("seed cannot be combined with seeds")
    return [options] if seeds is None else [replace(options, seed=integer(seed, "seeds", 0)) for seed in seeds]


def read_for_runs(source: Source, count: int, limits: Limits, sink: Sink) -> Source | None:
    """Returns a source that can be compiled `count` times: a stream is read. None if an error was reported."""
    if count <= 1 or not hasattr(source, "read") or as_plan(source) is not None:
        return source
    found = read_input(source, limits, sink)
    return None if found is None or sink.failed else found.plan_text or found.document


def as_plan(source: Source) -> ScenePlan | None:
    """Returns the source if it is a plan, else None."""
    if isinstance(source, str | bytes | Mapping):
        return None
    from scenecc.plan import ScenePlan

    return source if isinstance(source, ScenePlan) else None


def read_input(source: Source, limits: Limits, sink: Sink) -> Input | None:
    """Reads a source that is not a plan object; None if an error was reported.

    Raises:
        TypeError: the source cannot hold a scene.
    """
    path, pack = None, None
    if isinstance(source, Document):
        return Input(source)
    if isinstance(source, Mapping):
        document = read_dict(source, sink, limits)
        return document and _input(document, None)
    if isinstance(source, str) and is_plan_json(source):
        name, content = "<plan>", source
    elif isinstance(source, str | PathLike):
        name, path = fspath(source), Path(source).absolute()
        if path.suffix.lower() == PACK_SUFFIX:
            from scenecc.source.pack import is_pack, open_pack

            if is_pack(name):
                pack = open_pack(name, sink)
                if pack is None:
                    return None
                name, path = f"{name}!/{pack.manifest.entry}", pack.entry
        content = read_bytes(name if pack is None else str(path), sink, limits)
    elif _is_stream(source):
        name = getattr(source, "name", None)
        name = name if isinstance(name, str) else "<stream>"
        content = read_from_stream(source, name, sink, limits)
    else:  # pyright: ignore[reportUnreachable] - callers without a type checker
        raise TypeError(f"a scene must be a path, a stream, a mapping or a plan, not {type(source).__name__}")
    text = None if content is None else decode_text(content, name, sink, limits)
    if text is None:
        return None
    if is_plan_json(text):
        return Input(Document(name, path, {}, TextLines(name, text)), text, pack)
    document = read_text(text, name, sink, limits, path)
    return document and _input(document, pack)


def _is_stream(source: Source) -> TypeGuard[IO[str] | IO[bytes]]:
    return hasattr(source, "read")


def _input(document: Document, pack: Pack | None) -> Input:
    """Returns the input for a document, which may be a plan in YAML or Python data."""
    is_plan = _PLAN_KEY in document.data
    return Input(document, json.dumps(document.data, ensure_ascii=False) if is_plan else None, pack)


def is_plan_json(text: str) -> bool:
    """Returns whether JSON has the key of a plan at its top level. Text without that key is not parsed."""
    if _PLAN_TEXT.match(text):
        return True
    if f'"{_PLAN_KEY}"' not in text or text.lstrip()[:1] != "{":
        return False
    try:
        data: object = json.loads(text)
    except (ValueError, RecursionError):
        return False
    return isinstance(data, dict) and _PLAN_KEY in data


_INDEX = re.compile(r"\s*[0-9]{1,18}\s*")

_LATER_BANDS = frozenset("78")
"""First digits of codes that only exports or builds report."""


BUILD_TYPES: Mapping[str, Any] = {
    "scene_idxs": Iterable[int] | None,
    "scenes": str | None,
    "dry_run": bool,
    "render": bool | None,
    "audit": bool,
    "progress": Callable[[int, int], None] | None,
}
"""Types of the arguments of functions that build, for `check_types`."""

CHECK_TYPES: Mapping[str, Any] = {
    "settle": float,
    "seeds": Iterable[int] | None,
    "progress": Callable[[int, int], None] | None,
    "rules": Mapping[str, Any] | None,
    "scenes": str | None,
    "permute": bool,
}
"""Types of the arguments of functions that check, for `check_types`."""


class BuildChoices(TypedDict, total=False):
    """Which scenes are built, and how. `load_scene` has the other arguments.

    Attributes:
        scene_idxs: indices of the scenes to build; None: all.
        render: build visual shapes too; None: if a render device exists.
        audit: compare what only the engine decides with the plan.
    """

    scene_idxs: Iterable[int] | None
    render: bool | None
    audit: bool


@frozen
class CompileResult:
    """A plan, and how it was made.

    Attributes:
        timings: duration of each stage [s].
        scope: records what was read.
        document: the source, without data if it is a plan; None for a plan object.
        material_origins: where each physical material is written; None for a plan.
        provenance: for passports; None for a plan object.
        replayed: the scene of a passport, and its reset, if it had one.
        expansion: meaning of the source's names; None if nothing is expanded.
    """

    plan: ScenePlan
    timings: dict[str, float]
    scope: AssetScope
    document: Document | None = None
    material_origins: Mapping[int, Origin] | None = None
    provenance: Provenance | None = None
    replayed: tuple[int, Start] | None = None
    expansion: Expansion | None = None

    def reset_replayed(self, batch: SceneBatch, sink: Sink) -> None:
        """Sets the `replayed` scene to its initial state, right after the build.

        Raises:
            SceneError: one of its draws has no value (SC817), or the engine does not hold it.
        """
        if self.replayed is None or self.replayed[0] not in batch.scene_idxs:
            return
        index, start = self.replayed
        draws = {name: [row] for name, row in start.draws.items()}
        try:
            batch.reset(start.seed, [index], draws=draws, exact=True)
        except ValueError as error:
            sink.report("SC817", str(error), self.plan.origin or Location(None))
            raise SceneError(sink.diagnostics()) from None


class CompiledSource:
    """A compiled source, which can be used as a source without being compiled again.

    Args:
        source: any source of a scene.
        options: overrides of the scene, and what it may use.
        memory: records what is looked up.

    Attributes:
        result: the plan, and how it was made; None if the scene has errors.
        sink: the diagnostics.

    Raises:
        TypeError: the source cannot hold a scene.
    """

    def __init__(self, source: Source, options: Options, memory: PathCache | None = None) -> None:
        self.sink = Sink()
        self.result = compile_source(source, options, self.sink, memory=memory)


class _Clock:
    """Measures the duration of each stage [s]."""

    def __init__(self) -> None:
        self.timings: dict[str, float] = {}
        self._since = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.timings[stage] = now - self._since
        self._since = now


@collector_paused()  # a stage makes hundreds of thousands of containers, which all stay
def compile_source(
    source: Source, options: Options, sink: Sink, *, placed: bool = True, memory: PathCache | None = None
) -> CompileResult | None:
    """Compiles a source; None if an error was reported.

    Args:
        source: any source of a scene.
        options: overrides of the scene, and what it may use; ignored for a `CompiledSource`, which has its own.
        sink: collects diagnostics; must be empty for a `CompiledSource`.
        placed: place what is placed, and add the recipes of resets.
        memory: records what is looked up, also if the source has errors.

    Raises:
        TypeError: the source cannot hold a scene.
        RuntimeError: there is neither a plan nor an error, which is a bug in scenecc.
    """
    if isinstance(source, CompiledSource):
        sink.take_over(source.sink)
        return source.result
    result = _run_stages(source, options, sink, placed=placed, memory=memory)
    if result is None and not sink.failed:
        raise RuntimeError("scenecc made no plan of this scene and found no error in it")
    return result


def _run_stages(
    source: Source, options: Options, sink: Sink, *, placed: bool, memory: PathCache | None
) -> CompileResult | None:
    clock, memory = _Clock(), memory or PathCache()
    plan = as_plan(source)
    if plan is not None:
        # A plan object has already found its files.
        scope = AssetScope(None, options.asset_roots, allow_outside=True, memory=memory)
        return _check_given_plan(plan, options, scope, sink, clock)
    yaml, keys, *_ = STAGES
    sink.stage = yaml
    found = read_input(source, options.limits, sink)
    clock.lap("read")
    if found is None or sink.failed:
        return None
    sink.locate, sink.stage = found.document.locate, keys
    try:
        return _compile_input(source, found, options, sink, clock, placed=placed, memory=memory)
    except RecursionError:
        # With a raised limit, files are read deeper than later stages can recurse.
        message = "files, prefabs or values are nested deeper than Python's stack allows"
        hint = "use fewer levels: each takes frames of the stack"
        sink.report("SC602", message, Location(found.document.name), hint=hint)
        return None


def _compile_input(
    source: Source, found: Input, options: Options, sink: Sink, clock: _Clock, *, placed: bool, memory: PathCache
) -> CompileResult | None:
    """Runs the stages after reading."""
    from scenecc.checks.written_values import check_written_angles

    *_, names, physics = STAGES
    if sink.silencings:
        report_invalid(sink.silencings, found.document.name, sink)
    scope = found.scope(options, memory)
    if found.plan_text is not None:
        sink.stage = ""
        plan = _decode_plan(found, scope, options.limits, sink)
        clock.lap("decode")
        result = plan and _check_given_plan(plan, options, scope, sink, clock, found.document)
        return result and replace(result, provenance=_provenance(source, found.document, scope))
    whole = _parse_and_expand(found.document, options, scope, sink, clock)
    sink.stage = names if whole else sink.stage
    starts = _read_chosen(whole[0], found.document, scope, options) if whole else None
    if starts is not None and options.record is None:
        options = replace(options, record=DrawRecord(starts.content.chosen()))
    lowered = whole and _lower(found.document, *whole, options, scope, sink)
    clock.lap("lower")
    if lowered is None:
        return None
    sink.stage = physics
    plan = _check_plan(lowered.plan, lowered.material_origins, scope, options.limits, sink)
    if plan is None:
        return None
    check_written_angles(found.document, plan, sink)
    clock.lap("check")
    sink.stage = ""
    if placed:
        from scenecc.lower import complete

        plan = complete(replace(lowered, plan=plan), sink)
        clock.lap("place")
    if plan is not None and whole is not None and options.at_starts and (options.starts or whole[0].starts):
        plan = _begin_at_starts(plan, *whole, found.document, scope, options, sink, placed=placed)
        clock.lap("starts")
    if sink.silencings and plan is not None and (placed or not plan.placements):
        report_unused(sink, found.document.name, _is_of_compilation)
    provenance = _provenance(source, found.document, scope, whole and whole[1], options.draws)
    return plan and CompileResult(
        plan,
        clock.timings,
        scope,
        found.document,
        lowered.material_origins,
        provenance,
        expansion=whole and whole[1],
    )


def _read_chosen(scene: SceneFile, document: Document, scope: AssetScope, options: Options) -> KnownStarts | None:
    """Returns the starts, whose chosen values lowering needs; None if there are none. Faults are reported later."""
    if not options.at_starts or not (options.starts or scene.starts) or options.draws:
        return None
    from scenecc.starts.apply import find_starts

    origin = Origin(document.name, ("starts",))
    found = find_starts(scene.starts, options.starts, origin, scope, options.limits.asset_bytes, Sink())
    num_scenes = scene.num_scenes if options.num_scenes is None else options.num_scenes
    return found if found is not None and found.content.num_scenes == num_scenes else None


def _begin_at_starts(
    plan: ScenePlan,
    scene: SceneFile,
    expansion: Expansion | None,
    document: Document,
    scope: AssetScope,
    options: Options,
    sink: Sink,
    *,
    placed: bool,
) -> ScenePlan | None:
    """Returns a plan that begins at its starts; None after an error. If not `placed`, the file is only checked."""
    from scenecc.starts.apply import apply_starts, compare_starts, find_starts
    from scenecc.starts.fingerprint import fingerprint

    origin = Origin(document.name, ("starts",))
    if options.draws:
        hint = "leave one of them out: the draws of a start are those that it was settled with"
        sink.report("SC937", "`draws` cannot be given for scenes that begin at starts", origin, hint=hint)
        return None
    starts = find_starts(scene.starts, options.starts, origin, scope, options.limits.asset_bytes, sink)
    if starts is None:
        return None
    compare_starts(starts, fingerprint(document, expansion, scope, plan), plan.num_scenes, plan.name, sink)
    if sink.failed or not placed:
        return None if sink.failed else plan
    return apply_starts(plan, starts, sink)


def _provenance(
    source: Source,
    document: Document,
    scope: AssetScope,
    expansion: Expansion | None = None,
    draws: Mapping[str, Any] | None = None,
) -> Provenance:
    path = document.path
    if path is not None and isinstance(source, str | PathLike):
        path = Path(source)
    params: Mapping[str, Any] = {} if expansion is None else expansion.params
    defaults: Mapping[str, Any] = {} if expansion is None else expansion.defaults
    return Provenance(path and portable_path(path), document, scope, params, defaults, draws or {})


def _is_of_compilation(code: str) -> bool:
    return code in CODES and code[2] not in _LATER_BANDS and not is_of_check(code)


def _parse_and_expand(
    document: Document, options: Options, scope: AssetScope, sink: Sink, clock: _Clock
) -> tuple[SceneFile, Expansion | None] | None:
    """Parses a document and expands everything it uses; None if it has errors."""
    from scenecc.expand.documents import is_within_object_limit, needs_expansion
    from scenecc.spec.parse import parse

    if not is_within_object_limit(document, options.limits, sink):
        return None
    scene = parse(document.data, Origin(document.name), sink)
    clock.lap("validate")
    if scene is None or sink.failed:
        return None
    if not (options.params or options.draws or needs_expansion(document.data, document.text)):
        return scene, None
    from scenecc.expand.arguments import find_argument_origins
    from scenecc.expand.documents import scene_loader
    from scenecc.expand.expand import expand
    from scenecc.expand.params import report_unread_names

    limits = options.limits
    documents: dict[str | None, Document] = {document.name: document}
    sharing: dict[str | None, Document] = {document.name: document}
    find = scene_loader(scope, limits, sink)

    def load(reference: str, owner: SceneDocument, place: Origin) -> SceneDocument | None:
        """Finds a file or prefab, and records its document and its user."""
        found = find(reference, owner, place)
        if found is not None:
            documents[found.name] = found.document
            included = _is_included(place)
            if included:
                sharing[found.name] = found.document
            if found.document.path is not None:
                file = ResolvedFile(found.document.path, found.shown)
                scope.memory.note(file, owner.shown, "include" if included else "prefab")
        return found

    sink.given, sink.stage = partial(find_argument_origins, documents), STAGES[2]
    expansion = expand(
        document,
        params=options.params,
        num_scenes=options.num_scenes,
        seed=options.seed,
        draws=tuple(options.draws),
        load=load,
        measure=mesh_measurer(scope, limits, sink),
        limits=limits,
        sink=sink,
    )
    clock.lap("expand")
    if expansion is None or sink.failed:
        return None
    report_unread_names([*sharing.values()], expansion.data.get("draws", {}), sink)
    sink.trace, sink.overridden = expansion.trace, expansion.overridden
    scene = parse(expansion.data, Origin(document.name), sink, expanded=True)
    clock.lap("validate again")
    return None if scene is None or sink.failed else (scene, expansion)


def _is_included(place: Origin) -> bool:
    """Returns whether a file named at a place becomes part of the top document."""
    above: Origin | None = place
    while above is not None and above.path[:1] == ("include",):
        above = above.parent
    return above is None


def _lower(
    document: Document, scene: SceneFile, expansion: Expansion | None, options: Options, scope: AssetScope, sink: Sink
) -> Lowered | None:
    from scenecc.lower import lower
    from scenecc.spec.references import NameScopes

    limits = options.limits
    return lower(
        scene,
        name=document.path.stem if document.path else "scene",
        num_scenes=scene.num_scenes if options.num_scenes is None else options.num_scenes,
        seed=scene.seed if options.seed is None else options.seed,
        origin=Origin(document.name),
        resolve=resolver(scope, sink, expansion),
        robots=_robots(scope, limits, sink, expansion),
        vertices=mesh_reader(scope, limits, sink),
        bounds=limits,
        sink=sink,
        names=NameScopes() if expansion is None else expansion.names,
        selections={} if expansion is None else expansion.selections,
        draws=options.draws or {},
        record=options.record,
    )


def _robots(scope: AssetScope, limits: Limits, sink: Sink, expansion: Expansion | None) -> RobotReader:
    """Returns the reader of robot files, which is loaded only if there are any."""
    reader: RobotReader | None = None

    def read(request: RobotRequest, places: Mapping[str, Origin]) -> tuple[AssetFile, RobotDescription] | None:
        nonlocal reader
        if reader is None:
            reader = RobotReads(scope, limits, sink, expansion).read
        return reader(request, places)

    return read


def _check_given_plan(
    plan: ScenePlan,
    options: Options,
    scope: AssetScope,
    sink: Sink,
    clock: _Clock,
    document: Document | None = None,
) -> CompileResult | None:
    """Checks a plan that was compiled earlier."""
    checked = _check_plan(plan, {}, scope, options.limits, sink) if _matches_options(plan, options, sink) else None
    clock.lap("check")
    if checked is not None and document is not None:
        _warn_unknown_content(plan, checked, sink)
    return checked and CompileResult(checked, clock.timings, scope, document)


def _warn_unknown_content(plan: ScenePlan, checked: ScenePlan, sink: Sink) -> None:
    """Reports files whose hashes are missing in a plan's JSON."""
    for index, (file, now) in enumerate(zip(plan.files, checked.files, strict=True)):
        if file.sha256 is None and now.sha256 is not None:
            place = (plan.origin or Origin(None)).child("files").child(index)
            hint = "compile the scene again: its plan then has the hashes"
            message = f"the plan has no hash of {file.uri}: the build uses its current content"
            sink.report("SC717", message, place, hint=hint)


def _decode_plan(found: Input, scope: AssetScope, limits: Limits, sink: Sink) -> ScenePlan | None:
    """Returns a plan from its JSON. Relative paths refer to the folder of the JSON."""
    from scenecc.plan.json_codec import plan_from_json

    find = resolver(scope, sink)

    def path_of(uri: str, origin: Origin) -> Path | None:
        file = find(uri, origin)
        return file and file.path

    return plan_from_json(
        found.plan_text or "",
        base=scope.root or Path.cwd(),
        sink=sink,
        resolve=path_of,
        file=found.document.name,
        limits=limits,
    )


def _matches_options(plan: ScenePlan, options: Options, sink: Sink) -> bool:
    """Checks that no option overrides a plan, which is final."""
    for name in ("params", "draws", "starts"):
        if getattr(options, name):
            message = f"a plan does not accept {name}: its values are final"
            sink.report("SC907", message, plan.origin or Location(None), hint="compile the scene file again")
            return False
    for name in ("num_scenes", "seed"):
        asked = getattr(options, name)
        if asked is not None and asked != getattr(plan, name):
            sink.report(
                "SC907",
                f"{name} of a plan is fixed at {getattr(plan, name)}; it cannot become {asked}",
                plan.origin or Location(None),
                hint="compile the scene file again",
            )
            return False
    return True


def _check_plan(
    plan: ScenePlan, material_origins: Mapping[int, Origin], scope: AssetScope, limits: Limits, sink: Sink
) -> ScenePlan | None:
    """Checks the plan and its files. Returns the plan with file hashes; None after an error."""
    from scenecc.checks.physics import check_physics

    check_physics(plan, material_origins, sink)
    if plan.files and not sink.failed:
        from scenecc.checks.assets import check_assets

        files = check_assets(plan, sink, resolve_named=named_resolver(scope), max_asset_bytes=limits.asset_bytes)
        plan = replace(plan, files=files)
    return None if sink.failed else plan


def compile_or_raise(source: Source, options: Options, sink: Sink) -> CompileResult:
    """Returns a compiled scene with the duration of each stage. Raises SceneError."""
    found = compile_source(source, options, sink)
    if found is None:
        raise SceneError(sink.diagnostics())
    return found


def build_batch(
    plan: ScenePlan,
    sink: Sink,
    *,
    scene_idxs: Sequence[int] | None,
    render: bool | None,
    audit: bool,
    progress: Callable[[int, int], None] | None = None,
) -> SceneBatch:
    """Builds the live scenes of a plan. Arguments are those of `load_scene`.

    Raises:
        SceneError: the engine or the machine failed.
        ValueError: an argument is out of range.
    """
    from scenecc.backends.sapien import instantiate

    if plan.starts:
        from scenecc.starts.apply import require_starts

        require_starts(plan, scene_idxs, sink)
    batch = instantiate(plan, sink, scene_idxs=scene_idxs, render=render, audit=audit, progress=progress)
    if batch is None:
        raise SceneError(sink.diagnostics())
    return batch


def list_result_params(done: CompileResult, limits: Limits) -> list[ParamRow]:
    """Returns the parameters of a compiled scene, in order; a plan has none."""
    if done.document is None or not done.document.data:
        return []
    found = list_document_params(done.document, done.scope, limits, Sink())
    assert found is not None, "the parameters of a compiled scene can be listed"
    return found


def list_document_params(document: Document, scope: AssetScope, limits: Limits, sink: Sink) -> list[ParamRow] | None:
    """Returns the parameters of a document and of what it includes, in order; None if an error was reported."""
    from scenecc.expand.documents import scene_loader
    from scenecc.expand.listing import list_params

    return list_params(document, load=scene_loader(scope, limits, sink), limits=limits, sink=sink)


def select_scenes(scenes: str, num_scenes: int, sink: Sink, argument: str = "scenes") -> tuple[int, ...] | None:
    """Returns the scenes that an argument selects, in a scene file's notation; None if an error was reported."""
    from scenecc.spec.references import resolve_scene_idxs

    found = Sink()
    items = [int(item) if _INDEX.fullmatch(item) else item for item in scenes.split(",")]
    chosen = resolve_scene_idxs(items, num_scenes, Origin(None), found)
    for diagnostic in found.diagnostics():
        sink.report("SC908", diagnostic.message, Location(None), hint=diagnostic.hint, path=(argument,))
    return chosen
