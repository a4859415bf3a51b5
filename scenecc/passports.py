"""`replay`: rebuilds one scene from its passport, or reports what differs in files, parameters, versions and state."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path, PurePosixPath
from typing import IO, TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError
from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut, show
from scenecc.errors import SceneError
from scenecc.files import unique_keys
from scenecc.options import Options, check_keywords, check_types
from scenecc.pipeline import BUILD_TYPES, CompiledSource, CompileResult, Source, build_batch, read_input
from scenecc.source.paths import AssetScope, Refusal, check_uri, resolve_path
from scenecc.source.text import decode_text, read_bytes, read_from_stream
from scenecc.version import VERSION

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch
    from scenecc.source import Limits

PASSPORT: Final = "<passport>"
"""The file name in messages about a passport given as text."""

_MAX_FAULTS: Final = 20

Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{32}$")]
Index = Annotated[int, Field(ge=0)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class ResetContent(_Strict):
    """The arguments of a scene's last reset."""

    seed: Index
    draws: dict[str, Any] = {}


class PassportContent(_Strict):
    """The content of a passport; `docs/how-to/reproducing.md` explains its keys."""

    scenecc_passport: Literal[1]
    file: str | None = None
    sha256: Digest
    files: dict[str, Digest] = {}
    params: dict[str, Any] = {}
    defaults: dict[str, Any] = {}
    draws: dict[str, Any] = {}
    num_scenes: Annotated[int, Field(ge=1)]
    scene: Index
    seed: Index
    reset: ResetContent | None = None
    versions: dict[str, str]
    state: Digest


class ReplayOptions(TypedDict, total=False):
    """Where a replay finds files. The passport has the other compile options.

    Attributes:
        starts: as in `CompileOptions`, for a passport of a batch that was built with it.
        asset_roots: as in `CompileOptions`.
        allow_outside_assets: as in `CompileOptions`.
        limits: as in `CompileOptions`.
    """

    starts: str | PathLike[str] | None
    asset_roots: Iterable[str | PathLike[str]]
    allow_outside_assets: bool
    limits: Mapping[str, int] | None


def replay(
    passport: str | PathLike[str] | IO[str] | IO[bytes],
    *,
    file: Source | None = None,
    render: bool | None = None,
    any_version: bool = False,
    **options: Unpack[ReplayOptions],
) -> SceneBatch:
    """Rebuilds only the scene of a passport, in its initial state, bit for bit.

    Args:
        passport: the text that `SceneBatch.passport` returned, a path to it, or an open stream.
        file: the scene, as for `validate`; None: the file that the passport names, relative to the current folder.
        render: as for `load_scene`.
        any_version: accept versions of programs that differ from the passport's, with warnings.
        options: fields of `ReplayOptions`.

    Returns:
        A batch of only this scene, under its original index.

    Raises:
        SceneError: the passport is invalid; a file, a parameter, a version or the state differs from it; the scene has
            errors; or the engine or machine failed.
        TypeError: an argument has the wrong type.
        ValueError: an argument is out of range.
    """
    check_types(replay, {"render": render, "any_version": any_version}, {**BUILD_TYPES, "any_version": bool})
    known, compiled = open_passport(passport, file=file, any_version=any_version, **options)
    return build_replay(known, compiled, render=render)


def open_passport(
    passport: str | PathLike[str] | IO[str] | IO[bytes],
    *,
    file: Source | None = None,
    any_version: bool = False,
    **options: Unpack[ReplayOptions],
) -> tuple[PassportContent, CompiledSource]:
    """Compiles the scene of a passport, and compares everything but its state. Arguments and errors are those of
    `replay`.

    Scenes built from the result have the initial state of the passport's scene.
    """
    check_keywords(replay, options, ReplayOptions)
    checked, sink = Options.of(**options), Sink()
    known = _read_passport(passport, checked.limits, sink)
    source = None if known is None else _source(known, file, sink)
    if known is None or source is None:
        raise SceneError(sink.diagnostics())
    # All scenes get this scene's row, because only this scene counts.
    draws = {name: [row] * known.num_scenes for name, row in known.draws.items()}
    asked = replace(checked, num_scenes=known.num_scenes, seed=known.seed, params=known.params, draws=draws)
    compiled = CompiledSource(source, asked)
    found = compiled.result
    if found is None:
        _compare_named(known, source, asked, sink)
        raise SceneError([*sink.diagnostics(), *compiled.sink.diagnostics()])
    _compare(known, found, compiled.sink, any_version=any_version)
    if compiled.sink.failed:
        raise SceneError(compiled.sink.diagnostics())
    if known.reset is not None:
        from scenecc.backends.sapien.passport import Start  # noqa: PLC0415 - loads numpy

        start = Start(known.reset.seed, known.reset.draws)
        compiled.result = replace(found, replayed=(known.scene, start))
    return known, compiled


def build_replay(known: PassportContent, compiled: CompiledSource, *, render: bool | None) -> SceneBatch:
    """Builds the result of `open_passport`, and compares the initial state. Errors are those of `replay`."""
    found, sink = compiled.result, compiled.sink.another()
    assert found is not None
    batch = build_batch(found.plan, sink, scene_idxs=[known.scene], render=render, audit=True)
    batch.attach_provenance(found.provenance)
    good = False
    try:
        found.reset_replayed(batch, sink)
        state = json.loads(batch.passport(known.scene))["state"]
        good = state == known.state
    finally:
        if not good:
            batch.close()
    if not good:
        message = f"the initial state of scene {known.scene} has the hash {state}, but had {known.state}"
        hint = "files, parameters and seeds are the same: another version, processor or C library may round differently"
        sink.report("SC934", message, found.plan.origin or Location(None), hint=hint)
        raise SceneError([*compiled.sink.diagnostics(), *sink.diagnostics()])
    return batch


def _read_passport(
    passport: str | PathLike[str] | IO[str] | IO[bytes], limits: Limits, sink: Sink
) -> PassportContent | None:
    """Returns the content of a passport; None if an error was reported."""
    name, content = PASSPORT, None
    if isinstance(passport, str) and passport.lstrip()[:1] == "{":
        content = passport
    elif isinstance(passport, str | PathLike):
        name = fspath(passport)
        content = read_bytes(name, sink, limits)
    elif hasattr(passport, "read"):
        content = read_from_stream(passport, name, sink, limits)
    else:
        raise TypeError(f"a passport must be its text, a path or a stream, not {type(passport).__name__}")
    text = None if content is None else decode_text(content, name, sink, limits)
    if text is None:
        return None
    try:
        data: Any = json.loads(text, object_pairs_hook=unique_keys)
    except RecursionError:
        data, fault = None, "it is nested too deeply"
    except json.JSONDecodeError as error:
        data, fault = None, f"it is not JSON: {error}"
    except ValueError as error:
        data, fault = None, str(error)
    else:
        fault = None if isinstance(data, dict) and "scenecc_passport" in data else "it has no key `scenecc_passport`"
    if fault is None and data["scenecc_passport"] != 1:
        fault = f"it has version {show(data['scenecc_passport'])}, and scenecc {VERSION} reads version 1"
    if fault is not None:
        hint = "give the text that `batch.passport(k)` returned, one line of JSON"
        sink.report("SC930", f"invalid passport: {cut(fault, 200)}", Location(name), hint=hint)
        return None
    return _check_content(data, name, limits, sink)


def _check_content(data: Any, name: str, limits: Limits, sink: Sink) -> PassportContent | None:
    try:
        known = PassportContent.model_validate(data)
    except ValidationError as error:
        for one in error.errors(include_url=False, include_context=False, include_input=False)[:_MAX_FAULTS]:
            path = cut(".".join(map(str, one["loc"])))
            sink.report("SC930", f"`{path}`: {one['msg']}", Location(name), hint="do not edit a passport by hand")
        return None
    if not known.scene < known.num_scenes <= limits.scenes:
        message = f"scene {show(known.scene)} of {show(known.num_scenes)} does not exist, or there are too many scenes"
        sink.report("SC930", message, Location(name))
        return None
    file = known.file
    if file is not None and (check_uri(file) or PurePosixPath(file).is_absolute() or ".." in PurePosixPath(file).parts):
        sink.report("SC930", f"`file`: {show(file)} is not a path below the current folder", Location(name))
        return None
    return known


def _source(known: PassportContent, file: Source | None, sink: Sink) -> Source | None:
    """Returns the scene of a passport; None if there is none."""
    if file is not None:
        return file
    if known.file is None:
        hint = "give the scene with --file (or as `file`)"
        sink.report("SC931", "the scene of this passport was not a file", Location(PASSPORT), hint=hint)
        return None
    if not Path(known.file).is_file():
        hint = "name it with --file (or as `file`), or run in the folder in which the passport was made"
        sink.report("SC931", f"there is no file `{known.file}` here", Location(known.file), hint=hint)
        return None
    return known.file


_FILE_HINT: Final = "restore it, for example from version control, or give another scene with --file"


def _compare_named(known: PassportContent, source: Source, options: Options, sink: Sink) -> None:
    """Reports which files of the passport differ, for a scene that cannot be compiled."""
    from scenecc.source.provenance import content_hash, hash_document  # noqa: PLC0415 - needed only for this error

    found = None if hasattr(source, "read") else read_input(source, options.limits, Sink())
    if found is None:
        return
    document = found.document
    place, root = Location(document.name), Path.cwd() if document.path is None else document.path.parent
    _compare_digest("the scene file", known.sha256, hash_document(document), place, sink)
    scope = AssetScope(root, options.asset_roots, options.allow_outside_assets)
    for name, was in known.files.items():
        file = resolve_path(name, base=root, scope=scope)
        now = None if isinstance(file, Refusal) else content_hash(file.path)
        _compare_digest(f"`{cut(name, 200)}`", was, now, place, sink)


def _compare(known: PassportContent, found: CompileResult, sink: Sink, *, any_version: bool) -> None:
    """Reports every file, parameter default and version that differs."""
    from scenecc.backends.sapien.passport import build_versions  # noqa: PLC0415 - loads numpy

    now = found.provenance
    if now is None:
        raise TypeError("a passport belongs to a scene file or a dict, but `file` is a plan object")
    place = Location(now.document.name)
    _compare_digest("the scene file", known.sha256, now.source_hash, place, sink)
    try:
        files = now.file_hashes
    except OSError as error:
        sink.report("SC931", f"`{error.filename}`: {error.strerror}", place)
        return
    for name in sorted({*known.files, *files}):
        _compare_digest(f"`{cut(name, 200)}`", known.files.get(name), files.get(name), place, sink)
    for name in sorted({*known.defaults, *now.defaults}):
        was, here = (name in each and show(each[name]) for each in (known.defaults, now.defaults))
        if json.dumps([was, known.defaults.get(name)]) != json.dumps([here, now.defaults.get(name)]):
            message = f"the default of the parameter `{cut(name)}` {_format_change(was, here)}"
            sink.report("SC932", message, place, hint=_FILE_HINT)
    versions = build_versions(found.plan)
    for name in {**versions, **known.versions}:
        was, here = known.versions.get(name), versions.get(name)
        if was != here:
            hint = "install that version, or accept the difference with --any-version (any_version=True)"
            message = f"the version of {cut(name)} {_format_change(was and cut(was), here)}"
            severity = "warning" if any_version else "error"
            sink.report("SC933", message, Location(PASSPORT), hint=None if any_version else hint, severity=severity)


def _compare_digest(what: str, was: str | None, now: str | None, place: Location, sink: Sink) -> None:
    now = now and now[:32]
    if not was and now:
        message = f"{what} is new: its SHA-256 is {now}, and the passport does not have it"
    elif was and not now:
        message = f"{what} is missing, or the scene no longer uses it: its SHA-256 was {was}"
    else:
        message = f"{what} differs: its SHA-256 was {was}, but is {now}"
    if was != now:
        of_starts = ", or the starts with --starts" if not now and what.endswith(".json`") else ""
        sink.report("SC931", message, place, hint=_FILE_HINT + of_starts)


def _format_change(was: object, now: object) -> str:
    """Returns the words for an old and a new value. A false value means that it did not exist."""
    if not was:
        return f"is {now}, but did not exist"
    return f"was {was}, but is {now}" if now else f"was {was}, but no longer exists"
