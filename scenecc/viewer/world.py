"""The live scenes behind a page: the compiled scene file or its errors, its scenes, and their recording."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Final, Literal

from scenecc.diagnostics import Sink
from scenecc.errors import SceneError
from scenecc.inspect.entities import entity_item
from scenecc.meshes.builder import MeshBuilder, build_scene_meshes
from scenecc.meshes.surface import MeshError, report_mesh_error
from scenecc.options import integer
from scenecc.pipeline import build_batch, compile_source, list_result_params, select_scenes
from scenecc.plan import ArticulationStructure
from scenecc.source.paths import PathCache
from scenecc.viewer.nodes import Files, page_content
from scenecc.viewer.page import Page

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    import numpy as np
    import viser
    from numpy.typing import NDArray

    from scenecc.diagnostics import Diagnostic
    from scenecc.expand.listing import ParamRow
    from scenecc.inspect import Item
    from scenecc.meshes.builder import SceneMeshes
    from scenecc.options import Options
    from scenecc.pipeline import Source
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import MeasuredEntity
    from scenecc.viewer.nodes import Key, PageContent
    from scenecc.viewer.options import ViewOptions


_MOST_BODIES: Final = 5000
"""Beyond so many, a browser is no longer quick: scenes that have more are not put side by side."""


class World:
    """Scenes of a file that were built, at their start or some steps later.

    Attributes:
        loaded: the file.
        scene_idxs: the scenes that were built.
        left_out: how many others would be beside them.
        keys: the bodies that can move, in the order of `poses`.
        steps: that were simulated since the start.
    """

    def __init__(self, loaded: Loaded, look: ViewOptions, progress: Callable[[int, int], None] | None = None) -> None:
        """Builds the scenes of a look. Raises SceneError if the engine or the machine is at fault."""
        self.loaded = loaded
        self.scene_idxs, self.left_out = _chosen(loaded, look)
        self._batch = build_batch(
            loaded.plan,
            loaded.sink.another(),
            backend="cpu",
            scene_idxs=self.scene_idxs,
            render=False,
            audit="fast",
            progress=progress,
        )
        # With the engine, which is known to be there now.
        from scenecc.backends.sapien.measure import PoseTracker, measure

        try:
            self._measured = measure(self._batch)
            self._moving = PoseTracker(self._batch)
        except BaseException:
            self._batch.close()
            raise
        self.keys = self._moving.keys
        self.steps = 0

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self.steps * self._batch.timestep

    @property
    def timestep(self) -> float:
        """Length of one step [s]."""
        return self._batch.timestep

    def step(self, n: int = 1, *, check: bool = False) -> None:
        """Simulates some steps in every scene. With `check`, raises SceneError once they have diverged."""
        self._batch.step(n, check=check)
        self.steps += n

    def reset(self, seed: int) -> None:
        """Puts all bodies back to their start, drawn with another seed where a reset draws it.

        Raises:
            ValueError: something is drawn that has no value or that the engine cannot hold.
        """
        self._batch.reset(seed)
        self.steps = 0

    def poses(self) -> NDArray[np.float32]:
        """(N, 7) p [m] then q (wxyz) of all bodies that can move, in the world of their scene."""
        return self._moving.poses()

    def picture(self, look: ViewOptions, files: Files) -> PageContent:
        """All that is shown of it, as it stood at the start.

        Raises:
            SceneError: a file cannot be shown, or a package for it is missing.
        """
        return page_content(self._visual, self._colliding if look.collision else None, look, files)

    def entities(self) -> dict[int, list[tuple[str, tuple[str, ...]]]]:
        """What is in each scene: names of entities, and of the links of those that have some."""
        return {
            scene.index: [(one.entity.name, _links(one)) for one in scene.entities] for scene in self._measured.scenes
        }

    def facts(self, key: Key) -> Item | None:
        """What is said of the entity of a body; None where it is in none of these scenes."""
        index, name, _ = key
        for scene in self._measured.scenes:
            for made in scene.entities:
                if (scene.index, made.entity.name) == (index, name):
                    return entity_item(made.entity, self.loaded.plan, index, (index, made))
        return None

    def close(self) -> None:
        """Frees the engine's objects."""
        self._batch.close()

    @cached_property
    def _visual(self) -> tuple[SceneMeshes, ...]:
        return self._drawn("visual")

    @cached_property
    def _colliding(self) -> tuple[SceneMeshes, ...]:
        return self._drawn("collision")

    def _drawn(self, show: Literal["visual", "collision"]) -> tuple[SceneMeshes, ...]:
        drawer = self.loaded.drawer
        try:
            return tuple(build_scene_meshes(drawer, scene, show) for scene in self._measured.scenes)
        except MeshError as problem:
            sink = self.loaded.sink.another()
            report_mesh_error(problem, drawer.at, sink)
            raise SceneError(sink.diagnostics()) from problem


def check_scene(look: ViewOptions, plan: ScenePlan) -> None:
    """Raises SceneError if the plan has no such scene as is looked at, ValueError if none can have it."""
    sink = Sink()
    if select_scenes(str(integer(look.scene, "scene", 0)), plan.num_scenes, sink, "--scene") is None or sink.failed:
        raise SceneError(sink.diagnostics())


def _links(one: MeasuredEntity) -> tuple[str, ...]:
    articulated = isinstance(one.structure, ArticulationStructure)
    return tuple(body.name for body in one.bodies) if articulated else ()


def _chosen(loaded: Loaded, look: ViewOptions) -> tuple[tuple[int, ...], int]:
    """The scenes that are built, and how many there would be besides."""
    plan = loaded.plan
    if not look.grid:
        return (min(look.scene, plan.num_scenes - 1),), 0
    bodies = [0] * plan.num_scenes
    for entity in plan.entities:
        for row, index in enumerate(entity.scene_idxs):
            structure = entity.structure(row)
            bodies[index] += len(structure.links) if isinstance(structure, ArticulationStructure) else 1
    count = total = 0
    for here in bodies:
        total += here
        if total > _MOST_BODIES and count:
            break
        count += 1
    return tuple(range(count)), plan.num_scenes - count


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
    drawer: MeshBuilder


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
    sink, memory = Sink(), PathCache()
    params = {**options.params, **given}
    found = compile_source(source, replace(options, params=params), sink, memory=memory)
    files = frozenset({*memory.named, *memory.missing})
    if found is None:
        return Loading(None, sink.diagnostics(), files)
    listed = tuple(list_result_params(found, options.limits))
    drawer = MeshBuilder(found.plan, lambda problem, origin: report_mesh_error(problem, origin, sink))
    return Loading(Loaded(found.plan, listed, params, sink, drawer), sink.diagnostics(), files)


_FRAMES_A_SECOND: Final = 30


def record(
    server: viser.ViserServer,
    world: World,
    look: ViewOptions,
    steps: int,
    progress: Callable[[int, int], None] | None = None,
) -> str:
    """One page of HTML with a scene and, if there are steps, its simulation, as fast as its time goes.

    Raises:
        SceneError: a file cannot be shown, a package for it is missing, or the simulation diverges.
    """
    files, page = Files(), Page(server)
    picture = world.picture(look, files)
    page.show(picture, files.contents)
    page.frame()
    recording = server.get_scene_serializer()
    stride = max(1, round(1 / (_FRAMES_A_SECOND * world.timestep)))
    for done in range(0, steps, stride):
        if progress is not None:
            progress(done, steps)
        taken = min(stride, steps - done)
        world.step(taken, check=True)
        recording.insert_sleep(taken * world.timestep)
        page.move(world.keys, world.poses())
    title = f"<title>{escape(world.loaded.plan.name)}</title>"
    return recording.as_html().replace("<title>Viser</title>", title, 1)
