"""The public functions over a scene: check, compile, build, compare, export, and list its parameters.

The stages below report into a sink and stop. These functions, and a diverging simulation, raise `SceneError`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.errors import SceneError
from scenecc.options import (
    CompileOptions,
    EnvironmentOptions,
    Options,
    check_keywords,
    check_types,
    path_argument,
    read_indices,
)
from scenecc.pipeline import (
    BUILD_TYPES,
    CHECK_TYPES,
    BuildChoices,
    CompiledSource,
    CompileResult,
    Source,
    as_plan,
    build_batch,
    compile_or_raise,
    compile_source,
    list_document_params,
    list_result_params,
    read_for_runs,
    read_input,
    run_seeds,
    select_scenes,
)

if TYPE_CHECKING:
    from scenecc.backends.maniskill import ManiSkillScene
    from scenecc.backends.maniskill.loaded_scene import LoadedScene
    from scenecc.backends.sapien import SceneBatch
    from scenecc.checks.house_rules import Rule
    from scenecc.drawn_values import SceneDraws
    from scenecc.expand.listing import ParamRow, PrefabRow
    from scenecc.export import EmitChoices, Emitted, ExportArguments, FileChoices
    from scenecc.inspect import Item
    from scenecc.inspect.entities import SummaryRow
    from scenecc.inspect.inspection import InspectArguments, InspectChoices, Inspection
    from scenecc.plan import ScenePlan
    from scenecc.plan.diff import Difference
    from scenecc.render import RenderChoices
    from scenecc.render.render import Rendering
    from scenecc.source.paths import PathCache
    from scenecc.viewer import PageAddress, ScenePage, ViewOptions

    Progress = Callable[[int, int], None]


def validate(
    source: Source,
    *,
    rules: Mapping[str, Rule] | None = None,
    **options: Unpack[CompileOptions],
) -> list[Diagnostic]:
    """Returns all diagnostics that need no engine; empty for a valid scene.

    Nothing is placed (except for `rules`), built or written. Errors in the source are returned, not raised.

    Args:
        source: a path, an open text or binary stream, a mapping (tuples, numpy values and paths are accepted), a
            `ScenePlan`, or the JSON of a plan (a path, a stream, or the text).
        rules: your own rules by id (`ACM001`); they get the plan with its draws. See `docs/how-to/settings.md`.
        options: fields of `CompileOptions`.

    Raises:
        ValueError: an argument is out of range.
        TypeError: the source is none of the above, or a number is not an integer of Python or numpy.
    """
    asked = Options.of_call(validate, options)
    check_types(validate, {"rules": rules}, CHECK_TYPES)
    return validate_source(source, asked, rules or {}, None)


def validate_source(
    source: Source, options: Options, rules: Mapping[str, Rule], memory: PathCache | None
) -> list[Diagnostic]:
    """Returns the diagnostics of `validate`. `memory`: records what is looked up."""
    sink = Sink()
    found = compile_source(source, options, sink, placed=bool(rules), memory=memory)
    if rules and found is not None:
        from scenecc.checks.house_rules import run_rules

        run_rules(found.plan, rules, found.document and found.document.name, sink)
    return sink.diagnostics()


def compile_scene(
    source: Source,
    **options: Unpack[CompileOptions],
) -> ScenePlan:
    """Returns the plan of a scene. No engine is started. Arguments are those of `validate`.

    Raises:
        SceneError: the scene has errors.
    """
    sink = Sink()
    asked = Options.of_call(compile_scene, options)
    return compile_or_raise(source, asked, sink).plan


@overload
def load_scene(
    source: Source,
    *,
    scene: None = None,
    scene_idxs: Iterable[int] | None = None,
    render: bool | None = None,
    audit: bool = True,
    **options: Unpack[CompileOptions],
) -> SceneBatch: ...


@overload
def load_scene(
    source: Source,
    *,
    scene: ManiSkillScene,
    audit: bool = True,
    **options: Unpack[EnvironmentOptions],
) -> LoadedScene: ...


def load_scene(
    source: Source,
    *,
    scene: ManiSkillScene | None = None,
    scene_idxs: Iterable[int] | None = None,
    render: bool | None = None,
    audit: bool = True,
    **options: Unpack[CompileOptions],
) -> SceneBatch | LoadedScene:
    """Builds a scene as parallel, live SAPIEN scenes. Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        scene: the scene of a ManiSkill environment to build into, one in each environment, as
            `scenecc.maniskill.load_into` does. The environment then controls the simulation.
        scene_idxs: indices of the scenes to build. A scene is the same as in the full batch. Default: all.
        render: build visual shapes too; None: if a render device exists.
        audit: compare what only the engine decides with the plan, and fail if it differs (SC802): counts and order of
            all objects, poses, masses, and volumes and part counts of cooked meshes.
        options: fields of `CompileOptions`.

    Raises:
        SceneError: the scene has errors, or the engine or machine failed (`SceneError.at_fault`).
        TypeError: `scene` is not a ManiSkill scene, or another argument has the wrong type.
        ValueError: an argument is out of range, or cannot be combined with `scene`.
    """
    asked = Options.of_call(load_scene, options)
    chosen = {"scene_idxs": scene_idxs, "render": render, "audit": audit}
    check_types(load_scene, chosen, BUILD_TYPES)
    if scene is not None:
        if (asked.num_scenes, scene_idxs, render) != (None, None, None):
            raise ValueError("num_scenes, scene_idxs and render cannot be combined with scene")
        return build_into(scene, source, asked, audit=audit)
    sink = Sink()
    scene_idxs = None if scene_idxs is None else read_indices(scene_idxs, "scene_idxs")
    found = compile_or_raise(source, asked, sink)
    batch = build_batch(found.plan, sink, scene_idxs=scene_idxs, render=render, audit=audit)
    batch.attach_provenance(found.provenance)
    return batch


def build_into(scene: ManiSkillScene, source: Source, options: Options, *, audit: bool) -> LoadedScene:
    """Builds a scene in a ManiSkill environment, which sets the number of scenes.

    Raises:
        SceneError: the scene has errors, or the engine or machine failed.
        TypeError: `scene` is not a ManiSkill scene.
    """
    from scenecc.backends.maniskill import instantiate

    _check_environments(scene)
    sink = Sink()
    found = compile_or_raise(source, replace(options, num_scenes=scene.num_envs), sink)
    if found.plan.starts:
        from scenecc.starts.apply import require_starts

        require_starts(found.plan, None, sink)
    if (loaded := instantiate(found.plan, scene, sink, audit=audit)) is None:
        raise SceneError(sink.diagnostics())
    loaded.attach_provenance(found.provenance)
    return loaded


def _check_environments(scene: object) -> None:
    """Raises TypeError for anything but the scene of a ManiSkill environment."""
    if not hasattr(scene, "sub_scenes"):
        what = "`scene` must be a ManiSkill environment's scene, `env.unwrapped.scene`"
        alone = "without `scene`, `load_scene` makes SAPIEN's scenes itself"
        raise TypeError(f"{what}, not {type(scene).__name__}; {alone}")


@dataclass(frozen=True, slots=True)
class Build:
    """A built scene, and how it was built.

    Attributes:
        plan: the plan.
        batch: the live scenes; None after a dry run.
        scene_idxs: indices of the selected scenes.
        diagnostics: warnings and notes.
        timings: stage → duration [s], in order.
        summary: one row per entity, in build order.
    """

    plan: ScenePlan
    batch: SceneBatch | None
    scene_idxs: tuple[int, ...]
    diagnostics: list[Diagnostic]
    timings: dict[str, float]
    summary: list[SummaryRow]


def build_scene(
    source: Source,
    *,
    scenes: str | None = None,
    dry_run: bool = False,
    render: bool | None = None,
    audit: bool = True,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> Build:
    """Builds like `load_scene`, and returns a summary; `scenecc build` prints it.

    Args:
        source: as for `validate`.
        scenes: scenes to build, in the notation of `scene_idxs` in a file: `0:4`, `::2`, `0,2`; default: all.
        dry_run: compile only; no engine is started.
        render: as for `load_scene`.
        audit: as for `load_scene`.
        progress: called with (scenes done, total scenes) while the engine builds.
        options: fields of `CompileOptions`.

    Raises:
        SceneError: the scene has errors, or the engine or machine failed.
    """
    from scenecc.inspect.entities import summarize

    sink = Sink()
    asked = Options.of_call(build_scene, options)
    chosen = {"scenes": scenes, "dry_run": dry_run, "render": render, "audit": audit}
    check_types(build_scene, {**chosen, "progress": progress}, BUILD_TYPES)
    found = compile_or_raise(source, asked, sink)
    scene_idxs = None if scenes is None else select_scenes(scenes, found.plan.num_scenes, sink)
    if sink.failed:
        raise SceneError(sink.diagnostics())
    timings = dict(found.timings)
    batch = None
    if not dry_run:
        started = time.perf_counter()
        batch = build_batch(found.plan, sink, scene_idxs=scene_idxs, render=render, audit=audit, progress=progress)
        batch.attach_provenance(found.provenance)
        timings["build"] = time.perf_counter() - started
    built = tuple(range(found.plan.num_scenes)) if scene_idxs is None else scene_idxs
    rows = summarize(found.plan, batch, scene_idxs)
    return Build(found.plan, batch, built, sink.diagnostics(), timings, rows)


def scene_draws(
    source: Source,
    *,
    seeds: Iterable[int] | None = None,
    scenes: str | None = None,
    progress: Progress | None = None,
    **options: Unpack[CompileOptions],
) -> list[SceneDraws]:
    """Returns what a build with each seed draws, in the order of the seeds. No engine is started.

    These are the shared draws (`INSTANCE/NAME` in an instance), and all fields that are drawn or differ between scenes,
    by their paths: `cube.mass`, `cube.shapes[0].half_size`, `arm/elbow.stiffness`, `lights/lamp.color`. A pose is 7
    numbers, p [m] then q (wxyz), in the world of the scene or, for a light or camera, in the frame of its mount.
    `cube.pick` is the index of the scene's variant. A file is its path as written. In scenes without the value, numbers
    are NaN and texts None; integers and flags are then floats.

    Args:
        source: as for `validate`.
        seeds: seeds of the draws; default: the file's own, or `seed` of the options.
        scenes: scenes to read, in the notation of `scene_idxs` in a file: `0:4`, `::2`, `0,2`; default: all.
        progress: called with (seeds done, total seeds).
        options: fields of `CompileOptions`.

    Raises:
        SceneError: the scene has errors, a scene does not exist, or a plan was made with another seed.
        ValueError: an argument is out of range, or `seed` is combined with `seeds`.
    """
    from scenecc.drawn_values import DrawnValues, SceneDraws

    asked = Options.of_call(scene_draws, options)
    check_types(scene_draws, {"seeds": seeds, "scenes": scenes, "progress": progress}, CHECK_TYPES)
    runs, sink = run_seeds(asked, seeds), Sink()
    readable = read_for_runs(source, len(runs), asked.limits, sink)
    if readable is None:
        raise SceneError(sink.diagnostics())
    found: list[SceneDraws] = []
    for number, run in enumerate(runs):
        sink = Sink()
        plan = compile_or_raise(readable, run, sink).plan
        chosen = range(plan.num_scenes) if scenes is None else select_scenes(scenes, plan.num_scenes, sink)
        if chosen is None or sink.failed:
            raise SceneError(sink.diagnostics())
        found.append(SceneDraws(plan.seed, tuple(chosen), DrawnValues(plan).read(chosen)))
        if progress is not None:
            progress(number + 1, len(runs))
    return found


@dataclass(frozen=True, slots=True)
class Comparison:
    """All differences between two scenes; false if they are equal.

    Attributes:
        differences: one per field.
        diagnostics: warnings and notes of both.
    """

    differences: list[Difference]
    diagnostics: list[Diagnostic]

    def __bool__(self) -> bool:
        return bool(self.differences)


def compare_scenes(a: Source, b: Source, **options: Unpack[CompileOptions]) -> list[Difference]:
    """Returns all differences between the plans of two scenes; empty if they are equal.

    A scene name that comes from the file name is not a difference. Arguments are those of `validate`, for both scenes.

    Raises:
        SceneError: one or both have errors.
    """
    check_keywords(compare_scenes, options)
    return open_scene(a, **options).diff(open_scene(b, **options)).differences


def _is_unnamed(compiled: CompiledSource) -> bool:
    """Whether a scene file has no `name`, so that the plan's name is the file's."""
    document = compiled.result and compiled.result.document

    return document is not None and bool(document.data) and "name" not in document.data


def list_params(
    source: Source,
    *,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> list[ParamRow]:
    """Returns the parameters of a scene and of what it includes, in order. Arguments are those of `validate`.

    Only scene files are read, not their assets. A plan has no parameters.

    Raises:
        SceneError: one of these files has errors.
    """
    if as_plan(source) is not None:
        return []
    sink = Sink()
    given = {"asset_roots": asset_roots, "allow_outside_assets": allow_outside_assets, "limits": limits}
    options = Options.of_call(list_params, given)
    found = read_input(source, options.limits, sink)
    if found is not None and found.plan_text is not None:
        return []
    params: list[ParamRow] | None = None
    if found is not None and not sink.failed:
        params = list_document_params(found.document, found.scope(options), options.limits, sink)
    if params is None:
        raise SceneError(sink.diagnostics())
    return params


def list_prefabs() -> list[PrefabRow]:
    """Returns the prefabs that ship with the package, by name."""
    from scenecc.expand.listing import list_prefabs as listed

    return listed()


def json_schema() -> dict[str, Any]:
    """Returns the JSON Schema of scene files, for editors."""
    from scenecc.spec.json_schema import json_schema as schema

    return schema()


def plan_text(plan: ScenePlan, *, base: Path | None = None) -> str:
    """Returns a compiled plan as JSON, without checking it or its files again. `base`: as for `emit_scene`."""
    from scenecc.plan import ScenePlan
    from scenecc.plan.json_codec import plan_to_json

    check_types(plan_text, {"plan": plan}, {"plan": ScenePlan})
    base = None if base is None else path_argument(plan_text, "base", base)
    return plan_to_json(plan, base=base)


def emit_scene(source: Source, target: str, *, base: Path | None = None, **options: Unpack[CompileOptions]) -> str:
    """Returns a scene as "python" or "json" text. Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        target: a key of `scenecc.emit.EMITTERS`.
        base: folder to which relative paths in the text refer; None: the folder of the scene.
        options: fields of `CompileOptions`.

    Raises:
        SceneError: the scene has errors, or the target cannot hold it.
        ValueError: unknown target.
    """
    from scenecc.emit import EMITTERS
    from scenecc.export import check_target, emit_source

    check_target(target, EMITTERS)
    check_keywords(emit_scene, options)
    base = None if base is None else path_argument(emit_scene, "base", base)
    return emit_source(source, target, base=base, copy=False, **options).text


def export_scene(source: Source, target: str, **given: Unpack[ExportArguments]) -> dict[str, bytes]:
    """Exports a scene as files of another program, keyed by path relative to the output folder.

    The first is the main file; the others, which it references, are in a folder beside it. `Scene.emit` also returns
    the warnings, including one for everything that the target does not support.

    Args:
        source: as for `validate`.
        target: a key of `scenecc.emit.EXPORTS`: "glb", "mjcf", "urdf" or "usd".
        given: fields of `EmitChoices` and `CompileOptions`.

    Raises:
        SceneError: the scene has errors, the target cannot hold it, or the engine or machine failed.
        ValueError: the target or the scene index does not exist, or the target does not accept an argument.
    """
    from scenecc.emit import EXPORTS
    from scenecc.export import ExportArguments, check_target, emit_source

    check_target(target, EXPORTS)
    check_keywords(export_scene, given, ExportArguments)
    return emit_source(source, target, **given).files


def inspect_scene(source: Source, **given: Unpack[InspectArguments]) -> Item:
    """Returns the contents of a scene as a tree. `Scene.inspect` also returns the warnings.

    Args:
        source: as for `validate`.
        given: fields of `InspectChoices` and `CompileOptions`.

    Raises:
        SceneError: the scene has errors, the scene index or entity does not exist, or the engine or machine failed.
        ValueError: an argument is out of range.
    """
    from scenecc.inspect.inspection import InspectArguments, inspect_source

    check_keywords(inspect_scene, given, InspectArguments)
    return inspect_source(source, **given).item


def export_page(
    source: Source,
    *,
    options: ViewOptions | None = None,
    steps: int = 0,
    progress: Progress | None = None,
    **given: Unpack[CompileOptions],
) -> str:
    """Returns a scene as one HTML page. Arguments and errors are those of `Scene.page` and `validate`."""
    from scenecc.viewer.options import ARGUMENT_TYPES

    check_types(export_page, {"options": options, "steps": steps, "progress": progress}, ARGUMENT_TYPES)
    return open_scene(source, **given).page(options=options, steps=steps, progress=progress).html


def open_scene(source: Source, **options: Unpack[CompileOptions]) -> Scene:
    """Opens a scene. It is compiled once, at its first use.

    Args:
        source: as for `validate`.
        options: fields of `CompileOptions`.

    Raises:
        ValueError: an argument is out of range. The first use raises it for a closed stream.
        TypeError: a number is not an integer, or `params` or `draws` is not a mapping.
    """
    return Scene(source, options)


class Scene:
    """A scene opened by `open_scene`.

    `diagnostics` never raises for a scene with errors; everything else raises `SceneError` then. Results of methods
    have `diagnostics` of their own, which include those of the scene.
    """

    def __init__(self, source: Source, options: CompileOptions) -> None:
        check_keywords(open_scene, options)
        self._source = source
        self._given: CompileOptions = {**options}
        roots = options.get("asset_roots", ())
        if not isinstance(roots, str | PathLike) and hasattr(roots, "__iter__"):
            self._given["asset_roots"] = tuple(roots)  # an iterator can be read only once
        self._options = Options.of(**self._given)

    @cached_property
    def _compile(self) -> CompiledSource:
        return CompiledSource(self._source, self._options)

    def _result(self) -> CompileResult:
        if self._compile.result is None:
            raise SceneError(self.diagnostics)
        return self._compile.result

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """All diagnostics that need no engine: errors, warnings and notes."""
        return self._compile.sink.diagnostics()

    @property
    def plan(self) -> ScenePlan:
        """The compiled plan."""
        return self._result().plan

    @property
    def params(self) -> list[ParamRow]:
        """The parameters of the scene and of what it includes, in order; a plan has none."""
        return list_result_params(self._result(), self._options.limits)

    def build(self, **choices: Unpack[BuildChoices]) -> SceneBatch:
        """Builds the live scenes. Arguments are those of `BuildChoices`, errors those of `load_scene`."""
        check_keywords(Scene.build, choices, BuildChoices)
        return load_scene(self._compile, **choices, **self._given)

    def emit(self, target: str, *, base: Path | None = None, **choices: Unpack[EmitChoices]) -> Emitted:
        """Exports the scene in memory.

        Numbers that only an engine knows (masses, hulls of meshes, poses of links) come from SAPIEN, in which the scene
        is built for this purpose, without visual shapes.

        Args:
            target: "python", "json", "glb", "mjcf", "urdf" or "usd".
            base: folder in which the files will be written (python, json): files outside it are copied to the folder
                `NAME.assets`. None: paths are relative to the folder of the scene, and nothing is copied.
            choices: fields of `EmitChoices`.

        Raises:
            SceneError: the scene has errors, the target cannot hold it, or the engine or machine failed.
            ValueError: the target or the scene index does not exist, or the target does not accept an argument.
        """
        from scenecc.export import EmitChoices, emit_source

        check_keywords(Scene.emit, choices, EmitChoices)
        base = None if base is None else path_argument(Scene.emit, "base", base)
        return emit_source(self._compile, target, base=base, **choices, **self._given)

    def export(
        self, path: str | PathLike[str], *, target: str | None = None, **choices: Unpack[FileChoices]
    ) -> Emitted:
        """Exports the scene to files, all or none. Files that the main file references are in a folder beside it.

        Args:
            path: the main file. Its suffix selects the target: `.py`, `.json`, `.glb`, `.xml` (MJCF), `.urdf`, `.usda`
                or `.usd`.
            target: as for `emit`, if the suffix means another target (`.xml` for a URDF).
            choices: fields of `FileChoices`.

        Raises:
            SceneError: as for `emit`.
            ValueError: as for `emit`, or no target has the suffix.
            OSError: a file cannot be written.
        """
        from scenecc.emit import EMITTERS
        from scenecc.export import BINARY_SUFFIXES, SUFFIXES, FileChoices, check_target, target_of, write_emitted

        check_keywords(Scene.export, choices, FileChoices)
        file = path_argument(Scene.export, "path", path)
        wanted = target_of(file) if target is None else target
        check_target(wanted, SUFFIXES)
        binary = wanted == "usd" and file.suffix.lower() in BINARY_SUFFIXES
        base = file.absolute().parent if wanted in EMITTERS else None
        return write_emitted(self.emit(wanted, base=base, name=file.stem, binary=binary, **choices), file)

    def render(self, path: str | PathLike[str] | None = None, **choices: Unpack[RenderChoices]) -> Rendering:
        """Renders pictures of the scene.

        Args:
            path: the file to write, if any. Its suffix selects the content: `.png` the picture or contact sheet, `.mp4`
                or `.gif` a video of the `steps`.
            choices: fields of `RenderChoices`.

        Raises:
            SceneError: as for `render_scene`.
            TypeError: a flag is neither True nor False, or a number is not an integer.
            ValueError: an argument is out of range, or the suffix is unknown or contradicts `video`.
            OSError: the file cannot be written.
        """
        from scenecc.files import replace_all
        from scenecc.render import RenderChoices, render_scene
        from scenecc.render.choices import written_video

        check_keywords(Scene.render, choices, RenderChoices)
        file = None if path is None else path_argument(Scene.render, "path", path)
        wanted = None if file is None else written_video(file, choices.get("video"))
        if wanted is not None:
            choices["video"] = wanted
        made = render_scene(self._compile, **choices, **self._given)
        if file is not None:
            replace_all({file: made.png() if wanted is None or made.video is None else made.video})
        return made

    def view(
        self,
        *,
        options: ViewOptions | None = None,
        address: PageAddress | None = None,
        on_ready: Callable[[str], None] | None = None,
    ) -> None:
        """Shows the scene on a page in the browser until it is interrupted. Other arguments are those of `view_scene`.

        Raises:
            ValueError: the scene was opened from a stream, which can be read only once; the page reads it again.
        """
        from scenecc.viewer import view_scene
        from scenecc.viewer.options import ARGUMENT_TYPES

        check_types(Scene.view, {"options": options, "address": address, "on_ready": on_ready}, ARGUMENT_TYPES)
        if hasattr(self._source, "read"):
            raise ValueError(
                "a scene that was opened from a stream cannot be viewed: a stream can be read only once. "
                "Open the scene by its path, or call `view_scene` with the stream"
            )
        view_scene(self._source, options=options, address=address, on_ready=on_ready, **self._given)

    def page(
        self, *, options: ViewOptions | None = None, steps: int = 0, progress: Progress | None = None
    ) -> ScenePage:
        """Returns the scene as one self-contained HTML page, which needs no network and no server.

        Args:
            options: what is shown.
            steps: number of simulation steps that the page plays; 0: a still scene.
            progress: called with (scenes done, total scenes) while the engine builds, and with steps after that.

        Raises:
            SceneError: the scene has errors, the scene index does not exist, or the engine or machine failed.
            ValueError: an argument is out of range.
        """
        from scenecc.viewer import page_of_source
        from scenecc.viewer.options import ARGUMENT_TYPES

        check_types(Scene.page, {"options": options, "steps": steps, "progress": progress}, ARGUMENT_TYPES)
        return page_of_source(self._compile, options=options, steps=steps, progress=progress, **self._given)

    def inspect(self, **choices: Unpack[InspectChoices]) -> Inspection:
        """Returns the contents of the scene as a tree.

        Args:
            choices: fields of `InspectChoices`.

        Raises:
            SceneError: the scene has errors, the scene index or entity does not exist, or the engine or machine failed.
            TypeError: `build` is neither True nor False, or a number is not an integer.
            ValueError: an argument is out of range.
        """
        from scenecc.inspect.inspection import InspectChoices, inspect_source

        check_keywords(Scene.inspect, choices, InspectChoices)
        return inspect_source(self._compile, **choices, **self._given)

    def diff(self, other: Scene) -> Comparison:
        """Returns all differences of another scene from this one, by their plans.

        A scene name that comes from the file name is not a difference.

        Raises:
            SceneError: one or both have errors.
        """
        from scenecc.plan.diff import diff_plans

        if not isinstance(other, Scene):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"`other` must be a scene from `open_scene`, not {type(other).__name__}")
        both = (self, other)
        diagnostics = [one for each in both for one in each.diagnostics]
        if any(each._compile.result is None for each in both):  # noqa: SLF001 - of this class
            raise SceneError(diagnostics)
        unnamed = all(_is_unnamed(each._compile) for each in both)  # noqa: SLF001 - of this class
        found = diff_plans(self.plan, other.plan)
        return Comparison([one for one in found if not (one.path == "name" and unnamed)], diagnostics)
