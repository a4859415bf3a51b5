"""The live scenes behind a page: the compiled scene file or its errors, its scenes, and their recording."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, pi
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import chain_of
from scenecc.diagnostics.frozen import frozen
from scenecc.errors import SceneError
from scenecc.geometry.rotations import to_pose
from scenecc.inspect.entities import entity_item
from scenecc.meshes.builder import MeshBuilder, build_scene_meshes
from scenecc.options import integer
from scenecc.pipeline import CompiledSource, build_batch, compile_source, list_result_params, select_scenes
from scenecc.plan import ArticulationStructure
from scenecc.selection_link import Place
from scenecc.source.paths import PathCache
from scenecc.viewer.cameras import camera_views, first_view
from scenecc.viewer.head import titled
from scenecc.viewer.lights import page_lights
from scenecc.viewer.nodes import page_content
from scenecc.viewer.page import Page, bounds
from scenecc.viewer.surfaces import SurfaceFiles

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping
    from pathlib import Path

    import viser
    from numpy.typing import NDArray

    from scenecc.diagnostics import Diagnostic
    from scenecc.expand.listing import ParamRow
    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.inspect import Item
    from scenecc.meshes.builder import BodyMeshes, SceneMeshes
    from scenecc.options import Options
    from scenecc.pipeline import CompileResult, Source
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import MeasuredEntity
    from scenecc.viewer.lights import PageLight
    from scenecc.viewer.nodes import Key, PageContent
    from scenecc.viewer.options import ViewOptions


_MOST_BODIES: Final = 5000
"""Maximum number of bodies in a grid: with more, a browser is slow."""


class World:
    """Built scenes of a file, at their start or some steps later.

    Attributes:
        loaded: the file.
        scene_idxs: the built scenes.
        left_out: number of scenes left out of the grid.
        keys: movable bodies, in the order of `poses`.
        steps: steps since the start.
    """

    def __init__(self, loaded: Loaded, look: ViewOptions, progress: Callable[[int, int], None] | None = None) -> None:
        """Builds the scenes to show. Raises SceneError if the engine or the machine failed."""
        self.loaded = loaded
        self.scene_idxs, self.left_out = _chosen(loaded, look)
        self._batch = build_batch(
            loaded.plan,
            loaded.sink.another(),
            scene_idxs=self.scene_idxs,
            render=False,
            audit=True,
            progress=progress,
        )
        # loads the engine, whose presence was checked
        from scenecc.backends.sapien.measure import PoseTracker, measure_bodies

        try:
            loaded.result.reset_replayed(self._batch, loaded.sink.another())
            self._measured = measure_bodies(self._batch)
            self._moving = PoseTracker(self._batch)
        except BaseException:
            self._batch.close()
            raise
        self.keys = self._moving.keys
        self.steps = 0

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.steps * self._batch.timestep

    @property
    def timestep(self) -> float:
        """Length of one step [s]."""
        return self._batch.timestep

    def step(self, n: int = 1, *, check: bool = False) -> None:
        """Simulates some steps in every scene. With `check`, raises SceneError if they have diverged."""
        self._batch.step(n, check=check)
        self.steps += n

    def reset(self, seed: int) -> None:
        """Resets all bodies to their start; draws of a reset use another seed.

        Raises:
            ValueError: a draw has no value, or one that the engine cannot hold.
        """
        self._batch.reset(seed)
        self.steps = 0

    def poses(self) -> NDArray[np.float32]:
        """(N, 7) p [m] then q (wxyz) of all movable bodies, in the world of their scene."""
        return self._moving.poses()

    def picture(self, look: ViewOptions, files: SurfaceFiles) -> PageContent:
        """Returns the content of a page, with all bodies at their start.

        Raises:
            SceneError: a file cannot be shown, or a package for it is missing.
        """
        found = page_content(self._visual, self._colliding_meshes if look.collision else None, look, files)
        views = camera_views(self.loaded.plan, self._measured.scenes, found.origins, bounds(found.corners)[0])
        lights = self._lights(found.origins[self.scene_idxs[0]]) if look.lights else ()
        return replace(found, views=tuple(views), lights=lights)

    @property
    def has_lights(self) -> bool:
        """Whether the file has lights that a page can show."""
        return bool(self._lights((0.0, 0.0, 0.0)))

    def _lights(self, origin: Vec3) -> tuple[PageLight, ...]:
        return page_lights(self.loaded.plan, self._measured.scenes[0], origin)

    def entities(self) -> dict[int, list[tuple[str, tuple[str, ...]]]]:
        """Returns the entities of each scene, each with the names of its links."""
        return {
            scene.index: [(one.entity.name, _links(one)) for one in scene.entities] for scene in self._measured.scenes
        }

    def facts(self, key: Key) -> Item | None:
        """Returns the properties of a body's entity; None if it is in none of these scenes."""
        index, name, _ = key
        for scene in self._measured.scenes:
            for made in scene.entities:
                if (scene.index, made.entity.name) == (index, name):
                    return entity_item(made.entity, self.loaded.plan, index, (index, made))
        return None

    def contacts(self) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
        """Returns the contacts of the last step: scenes (N,), points (N, 3) [m], and forces (N, 3) [N].

        The force is the one on the body that was built later. As in SAPIEN, it excludes friction.
        """
        found = self._batch.contacts()
        touching = (found.impulse != 0).any(axis=1)
        force = -found.impulse[touching] / np.float32(self.timestep)
        return found.scene[touching], found.point[touching], force

    def joints(self, key: Key) -> tuple[JointPosition, ...]:
        """Returns the movable joints of a body's articulation, in the engine's order; empty for other entities."""
        articulation = self._batch.articulations.get(key[1])
        if articulation is None or key[0] not in articulation.scene_idxs:
            return ()
        made = articulation.objs[articulation.scene_idxs.index(key[0])]
        positions = made.get_qpos().tolist()
        return tuple(
            JointPosition(
                joint.get_name(), "m" if joint.get_type() == "prismatic" else "rad", *_limits(joint), position
            )
            for joint, position in zip(made.get_active_joints(), positions, strict=True)
        )

    def set_joint(self, key: Key, number: int, position: float) -> None:
        """Moves a joint of `joints` at once, only in its scene, and stops it. `position`: [m] or [rad]."""
        articulation = self._batch.articulations[key[1]]
        row = articulation.scene_idxs.index(key[0])
        qpos, qvel = articulation.qpos[row].copy(), articulation.qvel[row].copy()
        dof = len(self.joints(key))
        qpos[number], qvel[number] = position, 0
        articulation.set_qpos(qpos[:dof], [key[0]])
        articulation.set_qvel(qvel[:dof], [key[0]])

    def pose(self, key: Key) -> tuple[str, Pose7] | None:
        """Returns the name and the current pose of a body, in its scene; None for a static body."""
        if key not in self.keys:
            return None
        body = _bodies_of(self._visual, key)[0].body
        return body.name or key[1], to_pose(self.poses()[self.keys.index(key)])

    def draws(self, scene: int) -> dict[str, NDArray[Any]]:
        """Returns what the last build or reset drew in a scene: name → (1, …)."""
        return self._batch.drawn([scene])

    def named(self, names: Collection[tuple[int, str]]) -> list[Key]:
        """Returns the bodies named ENTITY or ENTITY/LINK in scenes; `names`: (scene, name)."""
        return [
            (scene.index, one.entity.name, number)
            for scene in self._measured.scenes
            for one in scene.entities
            for number, body in enumerate(one.bodies)
            if {(scene.index, one.entity.name), (scene.index, f"{one.entity.name}/{body.name}")} & {*names}
        ]

    def written(self, key: Key) -> list[Place]:
        """Returns where the entity of a body is written, innermost first: in a prefab, then where that is used."""
        return self._find_places.get(key[1], [])

    def written_at(self, places: Collection[Place]) -> list[Key]:
        """Returns the first body of each entity that is written at one of some places."""
        return [
            (scene.index, one.entity.name, 0)
            for scene in self._measured.scenes
            for one in scene.entities
            if any(place in places for place in self._find_places[one.entity.name])
        ]

    def box(self, key: Key) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Returns the lower and upper corner of a body in its own frame, without planes [m]; None if it has no other
        shapes.
        """
        for scenes in (self._visual, self._colliding_meshes):
            for body in _bodies_of(scenes, key):
                if len(body.corners):
                    turn, place = body.place[:3, :3], body.place[:3, 3]
                    corners = (body.corners - place) @ turn
                    return corners.min(axis=0), corners.max(axis=0)
        return None

    def places(self, key: Key) -> dict[Key, Pose7]:
        """Returns the poses of all bodies of a body's entity in their scene; its root is first."""
        scene, name, _ = key
        found = {(scene, name, number): body.body for number, body in enumerate(_entity_bodies(self._visual, key))}
        now = {key: to_pose(pose) for key, pose in zip(self.keys, self.poses(), strict=True) if key in found}
        ordered = sorted(found.items(), key=lambda one: one[1].parent is not None)
        return {one: now.get(one, body.pose) for one, body in ordered}

    def close(self) -> None:
        """Frees the engine's objects."""
        self._batch.close()

    @cached_property
    def _find_places(self) -> dict[str, list[Place]]:
        """Places of each entity, by name."""
        files = {name: os.path.realpath(path) for name, path in self.loaded.files.items()}
        return {
            entity.name: [
                Place(files[each.file], each.path[:2])
                for each in chain_of(entity.origin and self.loaded.sink.trace(entity.origin))
                if each.file in files and each.path[:1] == ("entities",)
            ]
            for entity in self.loaded.plan.entities
        }

    @cached_property
    def _visual(self) -> tuple[SceneMeshes, ...]:
        return self._draw_scenes("visual")

    @cached_property
    def _colliding_meshes(self) -> tuple[SceneMeshes, ...]:
        return self._draw_scenes("collision")

    def _draw_scenes(self, show: Literal["visual", "collision"]) -> tuple[SceneMeshes, ...]:
        drawer = self.loaded.drawer
        try:
            return tuple(build_scene_meshes(drawer, scene, show) for scene in self._measured.scenes)
        except AssetError as problem:
            sink = self.loaded.sink.another()
            problem.report(sink, drawer.at)
            raise SceneError(sink.diagnostics()) from problem


@frozen
class JointPosition:
    """A joint and its position, [m] or [rad]. `low`, `high`: ends of its slider, also for a joint without limits."""

    name: str
    unit: str
    low: float
    high: float
    position: float


def _limits(joint: Any) -> tuple[float, float]:
    """Returns the ends of a joint's slider. An unlimited joint gets one turn, or one metre, each way."""
    reach = 1.0 if joint.get_type() == "prismatic" else pi
    low, high = map(float, joint.get_limits()[0])
    return low if isfinite(low) else -reach, high if isfinite(high) else reach


def _entity_bodies(scenes: tuple[SceneMeshes, ...], key: Key) -> tuple[BodyMeshes, ...]:
    """Returns the bodies of a body's entity; empty if it is in none of these scenes."""
    index, name, _ = key
    for scene in scenes:
        for entity in scene.entities:
            if (scene.scene.index, entity.measured.entity.name) == (index, name):
                return entity.bodies
    return ()


def _bodies_of(scenes: tuple[SceneMeshes, ...], key: Key) -> tuple[BodyMeshes, ...]:
    """Returns only the body itself."""
    return _entity_bodies(scenes, key)[key[2] : key[2] + 1]


def check_selected_scene(look: ViewOptions, plan: ScenePlan) -> None:
    """Raises SceneError if the plan lacks the requested scene, ValueError if no plan can have it."""
    sink = Sink()
    if select_scenes(str(integer(look.scene, "scene", 0)), plan.num_scenes, sink, "scene") is None or sink.failed:
        raise SceneError(sink.diagnostics())


def _links(one: MeasuredEntity) -> tuple[str, ...]:
    articulated = isinstance(one.structure, ArticulationStructure)
    return tuple(body.name for body in one.bodies) if articulated else ()


def _chosen(loaded: Loaded, look: ViewOptions) -> tuple[tuple[int, ...], int]:
    """Returns the scenes to build, and the number of scenes left out."""
    plan = loaded.plan
    if not look.grid:
        return (min(look.scene, plan.num_scenes - 1),), 0
    count = total = 0
    for here in count_bodies(plan):
        total += here
        if total > _MOST_BODIES and count:
            break
        count += 1
    return tuple(range(count)), plan.num_scenes - count


def count_bodies(plan: ScenePlan) -> list[int]:
    """Returns the number of bodies of each scene."""
    bodies = [0] * plan.num_scenes
    for entity in plan.entities:
        for row, index in enumerate(entity.scene_idxs):
            structure = entity.structure(row)
            bodies[index] += len(structure.links) if isinstance(structure, ArticulationStructure) else 1
    return bodies


@dataclass(frozen=True, slots=True)
class Loaded:
    """A compiled scene.

    Attributes:
        plan: its plan.
        params: parameters of the file, in order.
        given: parameter values used to compile it.
        sink: its warnings and notes; later findings are added.
        drawer: drawer of its bodies.
        result: result of the compilation.
        files: used files, by their names in origins.
    """

    plan: ScenePlan
    params: tuple[ParamRow, ...]
    given: Mapping[str, Any]
    sink: Sink
    drawer: MeshBuilder
    result: CompileResult
    files: Mapping[str, Path]

    @property
    def seed(self) -> int:
        """The seed of the initial start."""
        return self.plan.seed if self.result.replayed is None else self.result.replayed[1].seed


@dataclass(frozen=True, slots=True)
class Loading:
    """The result of compiling a scene.

    Attributes:
        loaded: the scene; None if there is an error.
        diagnostics: all diagnostics.
        files: files that it used or looked for.
    """

    loaded: Loaded | None
    diagnostics: list[Diagnostic]
    files: frozenset[Path]


def load(source: Source, options: Options, given: Mapping[str, Any]) -> Loading:
    """Compiles a scene. `given`: parameter values, which override those of the options."""
    sink, memory = Sink(), PathCache()
    params = {**options.params, **given}
    found = compile_source(source, replace(options, params=params), sink, memory=memory)
    files = frozenset({*memory.named, *memory.missing})
    if found is None:
        return Loading(None, sink.diagnostics(), files)
    # A compiled source accepts no other parameters.
    listed = () if isinstance(source, CompiledSource) else tuple(list_result_params(found, options.limits))
    drawer = MeshBuilder(found.plan, lambda problem, origin: problem.report(sink, origin))
    named = memory.files_by_name(found.document) if found.document is not None else {}
    return Loading(Loaded(found.plan, listed, params, sink, drawer, found, named), sink.diagnostics(), files)


_FRAMES_A_SECOND: Final = 30


def record_page(
    server: viser.ViserServer,
    world: World,
    look: ViewOptions,
    steps: int,
    progress: Callable[[int, int], None] | None = None,
) -> str:
    """Returns one HTML page with a scene and, with steps, its simulation in real time.

    Raises:
        SceneError: a file cannot be shown, a package for it is missing, or the simulation diverges.
    """
    files, page = SurfaceFiles(), Page(server)
    picture = world.picture(look, files)
    page.show(picture, files.contents)
    page.open_at(first_view(picture.views, picture.solids, grid=look.grid))
    recording = server.get_scene_serializer()
    stride = max(1, round(1 / (_FRAMES_A_SECOND * world.timestep)))
    for done in range(0, steps, stride):
        if progress is not None:
            progress(done, steps)
        taken = min(stride, steps - done)
        world.step(taken, check=True)
        recording.insert_sleep(taken * world.timestep)
        page.move(world.keys, world.poses())
    return titled(recording.as_html(), world.loaded.plan.name)
