"""The compiler's front: whatever a source is, to a plan that every check has seen. No engine."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Mapping
from dataclasses import dataclass
from operator import index
from os import PathLike, fspath
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TypeGuard, Union

from scenecc.diagnostics import Location, Origin, Sink
from scenecc.source import Document, Limits, make_limits, read_dict, read_text
from scenecc.source.collector import collector_paused
from scenecc.source.lines import Lines
from scenecc.source.paths import AssetScope, Refusal, asset_roots, resolve, resolve_named
from scenecc.source.text import decode, read_bytes, read_some

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.lower.tables import FileResolver
    from scenecc.plan import AssetFile, ScenePlan

Source = Union[str, "PathLike[str]", IO[str], IO[bytes], Mapping[str, Any], "ScenePlan"]
"""A path, an open stream, a mapping, a plan, or a plan's JSON."""

_PLAN_KEY = "scenecc_plan"
_PLAN_TEXT = re.compile(r'\s*\{\s*"scenecc_plan"\s*:')
_INDEX = re.compile(r"\s*[0-9]{1,18}\s*")


@dataclass(frozen=True, slots=True)
class Options:
    """What overrides a file, and what the file may use.

    Attributes:
        given: what was given that this version cannot use yet, in words.
    """

    num_scenes: int | None
    seed: int | None
    given: tuple[str, ...]
    asset_roots: tuple[Path, ...]
    allow_outside_assets: bool
    limits: Limits

    @classmethod
    def of(
        cls,
        num_scenes: int | None,
        seed: int | None,
        params: Mapping[str, Any] | None,
        draws: Mapping[str, Any] | None,
        roots: Iterable[str | PathLike[str]],
        allow_outside_assets: bool,  # noqa: FBT001 - the API's own keyword
        limits: Mapping[str, int] | None,
    ) -> Options:
        """The arguments of the API, checked.

        Raises:
            ValueError: one is out of its range.
            TypeError: a number is no integer.
        """
        num_scenes = None if num_scenes is None else integer(num_scenes, "num_scenes", 1)
        seed = None if seed is None else integer(seed, "seed", 0)
        given = tuple(what for what, value in (("parameters", params), ("shared draws", draws)) if value)
        return cls(
            num_scenes,
            seed,
            given,
            asset_roots([roots] if isinstance(roots, str | PathLike) else roots),
            allow_outside_assets,
            make_limits(limits),
        )


@dataclass(frozen=True, slots=True)
class Compiled:
    """A plan, and the seconds of each stage that led to it."""

    plan: ScenePlan
    timings: dict[str, float]


def integer(value: object, name: str, least: int) -> int:
    """An argument that is an integer, Python's or numpy's.

    Raises:
        TypeError: it is none; True and False are none either.
        ValueError: it is below `least`.
    """
    # By its name: numpy 1 and 2 call their flag otherwise, and numpy may not be loaded at all.
    flag = type(value).__name__ in {"bool", "bool_"}
    try:
        number = None if flag else index(value)  # pyright: ignore[reportArgumentType] - asked, not assumed
    except TypeError:
        number = None
    if number is None:
        raise TypeError(f"{name} must be an integer, not {value!r}")
    if number < least:
        raise ValueError(f"{name} must be at least {least}, not {number}")
    return number


def select_scenes(scenes: str, num_scenes: int, sink: Sink) -> tuple[int, ...] | None:
    """The scenes that a command line selects, in the notation of a file; None where that was reported."""
    from scenecc.lower.selection import select

    found = Sink()
    items = [int(item) if _INDEX.fullmatch(item) else item for item in scenes.split(",")]
    chosen = select(items, num_scenes, Origin(None), found)
    for diagnostic in found.diagnostics():
        sink.report("SC908", diagnostic.message, Location("--scenes"), hint=diagnostic.hint)
    return chosen


class _Clock:
    """The seconds of each stage."""

    def __init__(self) -> None:
        self.timings: dict[str, float] = {}
        self._since = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.timings[stage] = now - self._since
        self._since = now


@dataclass(frozen=True, slots=True)
class _Input:
    """What was read. `plan_text`: the text of a plan, where it is one and no scene."""

    document: Document
    plan_text: str | None = None


@collector_paused()  # a stage makes containers by the hundred thousand, and all of them stay
def compile_source(source: Source, options: Options, sink: Sink) -> Compiled | None:
    """The plan of a source; None where an error was reported.

    Raises:
        TypeError: the source is nothing that can hold a scene.
    """
    clock = _Clock()
    for what in options.given:
        sink.report("SC109", f"{what} are not supported yet", Location(None))
    plan = _as_plan(source)
    # A plan that comes as an object has found its files already.
    scope = AssetScope(None, options.asset_roots, allow_outside=True)
    origins: Origins = ({}, {})
    if plan is None:
        found = _read(source, options.limits, sink)
        clock.lap("read")
        if found is None or sink.failed:
            return None
        sink.locate = found.document.locate
        root = found.document.path.parent if found.document.path else None
        scope = AssetScope(root, options.asset_roots, options.allow_outside_assets)
        if found.plan_text is None:
            lowered = _lowered(found.document, options, scope, sink, clock)
            plan, origins = lowered or (None, origins)
        else:
            plan = _decoded(found, scope, options.limits, sink)
            clock.lap("decode")
    if plan is None or not _as_asked(plan, options, sink) or not _checked(plan, origins, scope, options.limits, sink):
        return None
    clock.lap("check")
    return Compiled(plan, clock.timings)


Origins = tuple[Mapping[int, Origin], Mapping[int, Origin]]
"""Where the files and the physical materials of a plan are written, by index."""


def _as_plan(source: Source) -> ScenePlan | None:
    if isinstance(source, str | bytes | Mapping):
        return None
    from scenecc.plan import ScenePlan

    return source if isinstance(source, ScenePlan) else None


def _is_stream(source: Source) -> TypeGuard[IO[str] | IO[bytes]]:
    return hasattr(source, "read")


def _read(source: Source, limits: Limits, sink: Sink) -> _Input | None:
    """Reads a source that is no plan yet."""
    path: Path | None = None
    if isinstance(source, Mapping):
        document = read_dict(source, sink, limits)
        return document and _input(document)
    if isinstance(source, str) and _is_plan_json(source):
        name, content = "<plan>", source
    elif isinstance(source, str | PathLike):
        name, path = fspath(source), Path(source).absolute()
        content = read_bytes(name, sink, limits)
    elif _is_stream(source):
        name = getattr(source, "name", None)
        name = name if isinstance(name, str) else "<stream>"
        content = read_some(source, name, sink, limits)
    else:  # pyright: ignore[reportUnreachable] - callers without a type checker
        raise TypeError(f"a scene is a path, a stream, a mapping or a plan, not {type(source).__name__}")
    text = None if content is None else decode(content, name, sink, limits)
    if text is None:
        return None
    if _is_plan_json(text):
        return _Input(Document(name, path, {}, Lines(name, text)), text)
    document = read_text(text, name, sink, limits, path)
    return document and _input(document)


def _input(document: Document) -> _Input:
    """A plan may have become YAML or Python data on its way."""
    is_plan = _PLAN_KEY in document.data
    return _Input(document, json.dumps(document.data, ensure_ascii=False) if is_plan else None)


def _is_plan_json(text: str) -> bool:
    """Whether JSON has the key of a plan at its top level. Text without that key anywhere is not parsed for it."""
    if _PLAN_TEXT.match(text):
        return True
    if f'"{_PLAN_KEY}"' not in text or text.lstrip()[:1] != "{":
        return False
    try:
        data: object = json.loads(text)
    except (ValueError, RecursionError):
        return False
    return isinstance(data, dict) and _PLAN_KEY in data


def _lowered(
    document: Document, options: Options, scope: AssetScope, sink: Sink, clock: _Clock
) -> tuple[ScenePlan, Origins] | None:
    """A document through the models of the language to a plan."""
    from scenecc.lower import Bounds, lower
    from scenecc.spec.parse import parse

    origin = Origin(document.name)
    scene = parse(document.data, origin, sink)
    clock.lap("validate")
    if scene is None or sink.failed:
        return None
    limits = options.limits
    lowered = lower(
        scene,
        name=document.path.stem if document.path else "scene",
        num_scenes=scene.num_scenes if options.num_scenes is None else options.num_scenes,
        seed=scene.seed if options.seed is None else options.seed,
        origin=origin,
        resolve=_resolver(scope, sink),
        bounds=Bounds(limits.scenes, limits.objects, limits.objects_times_scenes),
        sink=sink,
    )
    clock.lap("lower")
    return lowered and (lowered.plan, (lowered.file_origins, lowered.material_origins))


def _resolver(scope: AssetScope, sink: Sink) -> FileResolver:
    from scenecc.plan import AssetFile

    def find(uri: str, origin: Origin) -> AssetFile | None:
        found = resolve(uri, base=scope.root or Path.cwd(), scope=scope)
        if isinstance(found, Refusal):
            sink.report(found.code, found.message, origin, hint=found.hint)
            return None
        return AssetFile(found.uri, found.path)

    return find


def _named_resolver(scope: AssetScope):  # noqa: ANN202 - a `checks.assets.ResolveNamed`
    def find(reference: str, asset: AssetFile) -> Path | Refusal:
        found = resolve_named(reference, owner=asset.path, owner_uri=asset.uri, scope=scope)
        return found if isinstance(found, Refusal) else found.path

    return find


def _decoded(found: _Input, scope: AssetScope, limits: Limits, sink: Sink) -> ScenePlan | None:
    """A plan from its JSON. Its relative paths start at the JSON's own folder."""
    from scenecc.plan.from_json import PlanLimits, plan_from_json

    find = _resolver(scope, sink)

    def path_of(uri: str, origin: Origin) -> Path | None:
        file = find(uri, origin)
        return file and file.path

    return plan_from_json(
        found.plan_text or "",
        base=scope.root or Path.cwd(),
        sink=sink,
        resolve=path_of,
        file=found.document.name,
        limits=PlanLimits(limits.text_bytes, limits.scenes, limits.objects_times_scenes),
    )


def _as_asked(plan: ScenePlan, options: Options, sink: Sink) -> bool:
    """A plan is final: nothing about it can be overridden any more."""
    for name in ("num_scenes", "seed"):
        asked = getattr(options, name)
        if asked is not None and asked != getattr(plan, name):
            sink.report(
                "SC907",
                f"a plan has its own {name}, {getattr(plan, name)}: it cannot become {asked}",
                plan.origin or Location(None),
                hint="compile the scene file again",
            )
            return False
    return True


def _checked(plan: ScenePlan, origins: Origins, scope: AssetScope, limits: Limits, sink: Sink) -> bool:
    """Every rule over the plan and its files."""
    from scenecc.checks.physics import check_physics

    file_origins, material_origins = origins
    check_physics(plan, material_origins, sink)
    if plan.files and not sink.failed:
        from scenecc.checks.assets import check_assets

        check_assets(
            plan,
            sink,
            resolve_named=_named_resolver(scope),
            max_asset_bytes=limits.asset_bytes,
            file_origins=file_origins,
        )
    return not sink.failed
