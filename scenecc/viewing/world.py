"""Live scenes that are looked at."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics import Sink
from scenecc.emit.problems import tell_problem
from scenecc.errors import SceneError
from scenecc.meshes import MeshProblem
from scenecc.meshes.layout import draw_scene
from scenecc.options import integer
from scenecc.pipeline import instantiated, select_scenes
from scenecc.plan import ArticulationStructure
from scenecc.summary.bodies import entity_item
from scenecc.viewing.nodes import picture

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from scenecc.meshes.layout import DrawnScene
    from scenecc.plan import ScenePlan
    from scenecc.plan.measured import MeasuredEntity
    from scenecc.summary import Item
    from scenecc.viewing.loading import Loaded
    from scenecc.viewing.look import Look
    from scenecc.viewing.nodes import Files, Key, Picture

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

    def __init__(self, loaded: Loaded, look: Look, progress: Callable[[int, int], None] | None = None) -> None:
        """Builds the scenes of a look. Raises SceneError if the engine or the machine is at fault."""
        self.loaded = loaded
        self.scene_idxs, self.left_out = _chosen(loaded, look)
        self._batch = instantiated(
            loaded.plan,
            loaded.sink.another(),
            backend="cpu",
            scene_idxs=self.scene_idxs,
            render=False,
            audit="fast",
            progress=progress,
        )
        # With the engine, which is known to be there now.
        from scenecc.backends.sapien.measure import measure
        from scenecc.backends.sapien.moving import Moving

        try:
            self._measured = measure(self._batch)
            self._moving = Moving(self._batch)
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

    def picture(self, look: Look, files: Files) -> Picture:
        """All that is shown of it, as it stood at the start.

        Raises:
            SceneError: a file cannot be shown, or a package for it is missing.
        """
        return picture(self._seen, self._colliding if look.collision else None, look, files)

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
    def _seen(self) -> tuple[DrawnScene, ...]:
        return self._drawn("visual")

    @cached_property
    def _colliding(self) -> tuple[DrawnScene, ...]:
        return self._drawn("collision")

    def _drawn(self, show: Literal["visual", "collision"]) -> tuple[DrawnScene, ...]:
        drawer = self.loaded.drawer
        try:
            return tuple(draw_scene(drawer, scene, show) for scene in self._measured.scenes)
        except MeshProblem as problem:
            sink = self.loaded.sink.another()
            tell_problem(problem, drawer.at, sink)
            raise SceneError(sink.diagnostics()) from problem


def check_scene(look: Look, plan: ScenePlan) -> None:
    """Raises SceneError if the plan has no such scene as is looked at, ValueError if none can have it."""
    sink = Sink()
    if select_scenes(str(integer(look.scene, "scene", 0)), plan.num_scenes, sink, "--scene") is None or sink.failed:
        raise SceneError(sink.diagnostics())


def _links(one: MeasuredEntity) -> tuple[str, ...]:
    articulated = isinstance(one.structure, ArticulationStructure)
    return tuple(body.name for body in one.bodies) if articulated else ()


def _chosen(loaded: Loaded, look: Look) -> tuple[tuple[int, ...], int]:
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
