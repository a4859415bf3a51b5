"""What can be asked about the language and about scenes, and written of them, without building one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.expand.listing import ParamRow, PrefabRow
    from scenecc.front import Source
    from scenecc.plan.compare import Difference

__all__ = [
    "check_limits",
    "compare_scenes",
    "emit_scene",
    "json_schema",
    "largest_picture",
    "list_params",
    "list_prefabs",
    "read_setting",
]


def json_schema() -> dict[str, Any]:
    """The JSON Schema of scene files, for editors."""
    from scenecc.spec.schema import json_schema as schema

    return schema()


def emit_scene(
    source: Source,
    target: str,
    *,
    base: Path | None = None,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    found: list[Diagnostic] | None = None,
) -> str:
    """A scene as the text of another program's input: "python" or "json". Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        target: a key of `scenecc.emit.EMITTERS`.
        base: folder that the text will lie in, from which its relative paths then start; None: the scene's own.
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: as for `validate`.
        draws: as for `validate`.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.
        found: takes the warnings and notes of a scene that was written.

    Raises:
        SceneError: the scene is at fault, or cannot be written so.
        ValueError: there is no such target.
    """
    from scenecc.diagnostics import SceneError, Sink
    from scenecc.emit import EMITTERS
    from scenecc.emit import emit as write
    from scenecc.front import Options, compiled

    if target not in EMITTERS:
        raise ValueError(f"there is no target {target!r}; there are {', '.join(EMITTERS)}")
    sink = Sink()
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    text = write(compiled(source, options, sink).plan, target, sink, base=base)
    if text is None:
        raise SceneError(sink.diagnostics())
    if found is not None:
        found += sink.diagnostics()
    return text


def check_limits(limits: Mapping[str, int] | None) -> None:
    """Whether `limits` can be given to the functions of the API.

    Raises:
        ValueError: a name is not that of a limit, or a value is not a positive integer.
    """
    from scenecc.source import make_limits

    make_limits(limits)


def largest_picture() -> int:
    """How many pixels wide and high a picture can be."""
    from scenecc.plan.fields import PIXELS

    return int(PIXELS.high)


def read_setting(text: str) -> tuple[str, Any]:
    """The name and the value of a parameter, from `name=value`. The value is YAML on one line.

    Raises:
        ValueError: it is not of that form.
    """
    from scenecc.diagnostics import Sink
    from scenecc.source import read_value

    name, equals, written = text.partition("=")
    if not equals or not name.strip():
        raise ValueError("it is not name=value, as in size=0.5")
    sink = Sink()
    value = read_value(written, sink)
    for diagnostic in sink.diagnostics():
        if diagnostic.code == "SC006":
            raise ValueError('it has no value (an empty text is "")')
        raise ValueError(f"{diagnostic.message}{f' ({diagnostic.hint})' if diagnostic.hint else ''}")
    return name.strip(), value


def list_params(
    source: Source,
    *,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> list[ParamRow]:
    """The parameters of a scene and of what it includes, in order. Arguments are those of `validate`.

    Nothing but the files of the language is looked at; a plan has no parameters any more.

    Raises:
        SceneError: one of these files is at fault.
    """
    from scenecc.diagnostics import SceneError, Sink
    from scenecc.expand.documents import scene_loader
    from scenecc.expand.listing import list_params as listed
    from scenecc.front import Options, as_plan, read_input
    from scenecc.source.paths import AssetScope

    if as_plan(source) is not None:
        return []
    sink = Sink()
    options = Options.of(None, None, None, None, asset_roots, allow_outside_assets, limits)
    found = read_input(source, options.limits, sink)
    if found is not None and found.plan_text is not None:
        return []
    params: list[ParamRow] | None = None
    if found is not None and not sink.failed:
        document = found.document
        root = document.path.parent if document.path else None
        scope = AssetScope(root, options.asset_roots, options.allow_outside_assets)
        load = scene_loader(scope, options.limits, sink)
        params = listed(document, load=load, limits=options.limits, sink=sink)
    if params is None:
        raise SceneError(sink.diagnostics())
    return params


def list_prefabs() -> list[PrefabRow]:
    """The prefabs that ship with the package, by name."""
    from scenecc.expand.listing import list_prefabs as listed

    return listed()


def compare_scenes(
    a: Source,
    b: Source,
    *,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    found: list[Diagnostic] | None = None,
) -> list[Difference]:
    """Everything in which two scenes differ, by their plans; empty where they are the same.

    A name that follows from a file's is no difference. Arguments are those of `validate`, for both scenes.

    Args:
        a: the first scene.
        b: the second one.
        num_scenes: in place of the files'.
        seed: in place of the files'.
        params: values of the files' parameters.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.
        found: takes the warnings and notes of both.

    Raises:
        SceneError: one of them, or each, is at fault.
    """
    from scenecc.diagnostics import SceneError, Sink
    from scenecc.front import Options, compile_source
    from scenecc.plan.compare import differences

    options = Options.of(num_scenes, seed, params, None, asset_roots, allow_outside_assets, limits)
    sinks = Sink(), Sink()
    compiled = [compile_source(source, options, sink) for source, sink in zip((a, b), sinks, strict=True)]
    diagnostics = [diagnostic for sink in sinks for diagnostic in sink.diagnostics()]
    first, second = compiled
    if first is None or second is None:
        raise SceneError(diagnostics)
    if found is not None:
        found += diagnostics
    unnamed = [_stem(source) == done.plan.name for source, done in ((a, first), (b, second))]
    return [one for one in differences(first.plan, second.plan) if not (one.path == "name" and all(unnamed))]


def _stem(source: Source) -> str:
    """The name of a scene that says none."""
    from os import PathLike
    from pathlib import Path

    return Path(source).stem if isinstance(source, str | PathLike) else "scene"
