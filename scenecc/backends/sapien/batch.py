"""`SceneBatch`: live scenes that are stepped and reset together, and the check for divergence."""

from __future__ import annotations

from contextlib import nullcontext
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.backends.sapien.contacts import ContactReader, Contacts
from scenecc.backends.sapien.drawn_fields import DrawnFieldSet, plan_holders
from scenecc.backends.sapien.entity_batch import ArticulationBatch, EntityBatch
from scenecc.backends.sapien.objects import (
    ArticulationObjects,
    BodyObjects,
    ComponentBatch,
    DrawnObjects,
    NamedObjects,
    is_dynamic,
    iterate_entities,
)
from scenecc.backends.sapien.passport import Passport, PassportWriter, Sampled, Start
from scenecc.backends.sapien.reset import ResetSampler
from scenecc.backends.sapien.state import (
    AnyState,
    DrawnFieldState,
    RemovedArticulation,
    SceneState,
    StateWriter,
    make_state_writer,
    read_articulations,
    read_state,
    restore_in_new_scene,
    restore_scene,
    validate_state,
)
from scenecc.diagnostics.diagnostic import Location
from scenecc.drawn_values import DrawnRow, DrawnValues
from scenecc.errors import SceneError
from scenecc.interrupt import interrupts_wait
from scenecc.options import check_scene_idxs, check_seeds, integer
from scenecc.plan import ArticulationStructure
from scenecc.plan.mimics import inexact_mimics, list_mimics

if TYPE_CHECKING:
    from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
    from types import TracebackType

    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Self

    from scenecc.backends.sapien.cameras import CameraBatch
    from scenecc.backends.sapien.constraints import ConstraintBatch, ConstraintSet, TargetCalls
    from scenecc.backends.sapien.engine import sapien
    from scenecc.backends.sapien.rendering import LightBatch, LightsAndCameras
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.framing import Subject, View
    from scenecc.plan.light_rigs import Preset
    from scenecc.plan.rendering import ShaderName
    from scenecc.source.provenance import Provenance

DIVERGENCE_LIMIT: Final = 1e6
"""[m, m/s, rad, rad/s] Float32 resolves only 0.06 m there, so no useful scene reaches it."""

_DIVERGENCE_HINT: Final = "a smaller `physics.timestep`, weaker drives, or masses that differ less may help"

CHECK_INTERVAL: Final = 10
"""Steps between two checks. A check costs as much as a few steps."""


class _Divergence(NamedTuple):
    """A body or link whose state is not finite or is beyond `DIVERGENCE_LIMIT`."""

    scene: int
    entity: str
    link: str
    finite: bool

    def __str__(self) -> str:
        what = f"link `{self.link}` of `{self.entity}`" if self.link else f"`{self.entity}`"
        return (
            f"{what} {'is beyond 1e6 m, m/s, rad or rad/s' if self.finite else 'is not finite'} in scene {self.scene}"
        )


def check_divergence(
    plan: ScenePlan, present: Iterable[BodyObjects | ArticulationObjects], steps: Mapping[int, int], sink: Sink
) -> None:
    """Raises SceneError if a body is not finite or is beyond `DIVERGENCE_LIMIT`. `steps`: number of steps by scene."""
    found: list[_Divergence] = []
    for objects in present:
        found += _diverged_links(objects) if isinstance(objects, ArticulationObjects) else _diverged_bodies(objects)
    if not found:
        return
    first = min(found, key=lambda one: one.scene)
    others = len({one.scene for one in found}) - 1
    too = f", and others are in {others} more scene{'s' * (others > 1)}" if others else ""
    entity = next(entity for entity in plan.entities if entity.name == first.entity)
    structure = entity.structure(entity.scene_idxs.index(first.scene))
    mimics = inexact_mimics(structure) if isinstance(structure, ArticulationStructure) else []
    coupled = f"; PhysX couples {list_mimics(mimics)} inexactly (SC578)" if mimics else ""
    hint = "remove `mimic`, and drive both joints" if mimics else _DIVERGENCE_HINT
    message = f"{first} by step {steps[first.scene]}{too}{coupled}"
    sink.report("SC820", message, entity.origin or Location(None), hint=hint)
    raise SceneError(sink.diagnostics())


def _diverged_bodies(bodies: BodyObjects) -> list[_Divergence]:
    rows = [row for row, component in enumerate(bodies.components) if is_dynamic(component)]
    numbers = _body_motion([bodies.objs[row] for row in rows], [bodies.components[row] for row in rows])
    return [
        _Divergence(bodies.scene_idxs[rows[number]], bodies.name, "", fine)
        for number, fine in _rows_beyond_limit(numbers)
    ]


def _diverged_links(objects: ArticulationObjects) -> list[_Divergence]:
    found: list[_Divergence] = []
    rows = [row for row in range(len(objects.objs)) if objects.in_scene(row)]
    links = [(row, link) for row in rows for link in objects.links[row]]
    numbers = _body_motion([entity for row in rows for entity in objects.entities[row]], [link for _, link in links])
    found += [_link_divergence(objects, *links[number], finite=fine) for number, fine in _rows_beyond_limit(numbers)]
    joints = [(row, joint) for row in rows for joint in objects.joints[row]]
    there = {one.scene for one in found}
    for number, fine in _rows_beyond_limit(_joint_motion([objects.objs[row] for row in rows])):
        row, joint = joints[number]
        one = _link_divergence(objects, row, joint.get_child_link(), finite=fine)
        if one.scene not in there:
            found.append(one)
    return found


def _link_divergence(objects: ArticulationObjects, row: int, link: Any, *, finite: bool) -> _Divergence:
    return _Divergence(objects.scene_idxs[row], objects.name, link.get_name(), finite)


def _body_motion(entities: Sequence[Any], components: Sequence[Any]) -> NDArray[np.float32]:
    """Returns poses and velocities, (N, 13)."""
    velocities = [v for c in components for v in (c.get_linear_velocity(), c.get_angular_velocity())]
    pose = np.array([entity.get_pose().__getstate__() for entity in entities], np.float32).reshape(-1, 7)
    return np.hstack((pose, np.array(velocities, np.float32).reshape(-1, 6)))


def _joint_motion(objs: Sequence[Any]) -> NDArray[np.float32]:
    """Returns positions and velocities of all active joints, (N, 2)."""
    numbers = [np.stack((obj.get_qpos(), obj.get_qvel()), axis=1) for obj in objs]
    return np.concatenate(numbers) if numbers else np.empty((0, 2), np.float32)


def _rows_beyond_limit(numbers: NDArray[np.float32]) -> list[tuple[int, bool]]:
    """Returns each row that holds a non-finite or too large number, and whether the row is finite."""
    fine = (np.abs(numbers) <= DIVERGENCE_LIMIT).all(axis=1)  # comparisons with NaN are false
    return [(row, bool(np.isfinite(numbers[row]).all())) for row in np.flatnonzero(~fine).tolist()]


class ObjectRegistry:
    """The bodies and articulations of a batch.

    Attributes:
        objects: everything that was built, by name.
        entities, articulations: those in the scenes now, by name, in build order.
    """

    def __init__(self, objects: Sequence[BodyObjects | ArticulationObjects]) -> None:
        self.objects = {each.name: each for each in objects}
        bodies = {each.name: EntityBatch(each) for each in objects if isinstance(each, BodyObjects)}
        self.entities = NamedObjects(bodies, "body")
        articulations = {one.name: ArticulationBatch(one) for one in objects if isinstance(one, ArticulationObjects)}
        self.articulations = NamedObjects(articulations, "articulation")
        self._order = list(self.objects)
        self._removed: dict[str, EntityBatch | ArticulationBatch] = {}
        self._removed_articulations: dict[str, RemovedArticulation] = {}

    def remove(self, name: str, scene_at: Callable[[int], Any]) -> None:
        """Removes an entity from every scene. `scene_at` returns the scene for an index of the plan.

        Raises:
            KeyError: no entity has this name.
            ValueError: it is already removed.
        """
        if name in self._removed:
            raise ValueError(f"'{name}' is already removed")
        self._removed[name] = self._find_present(name)
        objects = self.objects[name]
        if isinstance(objects, ArticulationObjects):
            self._removed_articulations[name] = RemovedArticulation(read_articulations(objects, objects.scene_idxs))
        for index, entity in iterate_entities(objects):
            scene_at(index).remove_entity(entity)
        self.entities.pop(name, None)
        self.articulations.pop(name, None)
        self._order.remove(name)

    def add(self, name: str, scene_at: Callable[[int], Any]) -> None:
        """Adds a removed entity again, as the last in build order. `scene_at`: as for `remove`.

        Raises:
            KeyError: no entity has this name.
            ValueError: it is not removed.
        """
        if name not in self._removed:
            self._find_present(name)
            raise ValueError(f"'{name}' is in the scenes; only a removed entity can be added")
        objects, batch = self.objects[name], self._removed.pop(name)
        for index, entity in iterate_entities(objects):
            scene_at(index).add_entity(entity)
        self._order.append(name)
        if isinstance(batch, EntityBatch):
            self.entities[name] = batch
        else:
            self.articulations[name] = batch
        if isinstance(objects, ArticulationObjects):
            self._removed_articulations.pop(name).put_back(objects)

    def present(self) -> Iterator[BodyObjects | ArticulationObjects]:
        """Yields the objects that are in the scenes now."""
        return (self.objects[name] for name in self._order)

    def state(self, scene_idxs: tuple[int, ...], drawn: dict[str, DrawnFieldState]) -> SceneState:
        """Returns the state of all entities in these scenes, removed ones included, together with `drawn`."""
        found = {
            name: read_state(objects, self._removed_articulations.get(name), scene_idxs)
            for name, objects in self.objects.items()
        }
        return SceneState.of(scene_idxs, found, drawn)

    def placements(self, states: Mapping[str, AnyState]) -> list[StateWriter]:
        """Returns writers that restore the given entities, in build order.

        A removed articulation gets its state when it is added again.
        """
        for name in self._removed_articulations.keys() & states.keys():
            self._removed_articulations[name].change(states[name])
        names = [name for name in (*self._order, *self._removed) if name in states]
        return [make_state_writer(self.objects[name], states[name]) for name in names]

    def close(self) -> None:
        """Releases all objects. Later use of a handle raises RuntimeError."""
        for each in (*self.entities.values(), *self.articulations.values(), *self._removed.values()):
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.objects = {}
        self.entities.clear()
        self.articulations.clear()
        self._order, self._removed, self._removed_articulations = [], {}, {}

    def _find_present(self, name: str) -> EntityBatch | ArticulationBatch:
        return NamedObjects({**self.entities, **self.articulations}, "entity")[name]


class SceneBatch:
    """Parallel scenes, built from one plan.

    Use it as a context manager, or call `close`, to free the engine's objects at a known time.
    """

    def __init__(
        self,
        plan: ScenePlan,
        scene_idxs: tuple[int, ...],
        scenes: list[Any],
        bodies: Sequence[BodyObjects | ArticulationObjects],
        drawn: DrawnObjects,
        *,
        render: bool,
        sink: Sink,
    ) -> None:
        self._plan = plan
        self._scene_idxs = scene_idxs
        self._scenes = scenes
        self._members = ObjectRegistry(bodies)
        self._drawn_objects = drawn
        self._render = render
        self._number_of = {index: number for number, index in enumerate(scene_idxs)}
        self._constraints: ConstraintSet | None = None
        self._rendering: LightsAndCameras | None = None
        self._sink = sink
        self._steps = dict.fromkeys(scene_idxs, 0)
        self._passports = PassportWriter(plan)
        self._closed = False

    def __len__(self) -> int:
        return len(self._scene_idxs)

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{len(self._members.entities)} entities"
        return f"SceneBatch({self._plan.name!r}, {len(self)} scenes, {state})"

    def __enter__(self) -> Self:
        self._check_open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def plan(self) -> ScenePlan:
        """The plan that the batch was built from."""
        return self._plan

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Indices of the plan's scenes that were built, ascending, in the order of `scenes`."""
        return self._scene_idxs

    @property
    def render(self) -> bool:
        """Whether visuals were built."""
        return self._render

    @property
    def scenes(self) -> list[sapien.Scene]:
        """The scenes. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._scenes

    @property
    def entities(self) -> dict[str, EntityBatch]:
        """Bodies in the scenes now, by name, in build order. Raises RuntimeError once closed."""
        self._check_open()
        return self._members.entities

    @property
    def articulations(self) -> dict[str, ArticulationBatch]:
        """Articulations in the scenes now, by name, in build order. Raises RuntimeError once closed."""
        self._check_open()
        return self._members.articulations

    @property
    def lights(self) -> dict[str, LightBatch]:
        """Lights by name. If the plan has none, those of the default rig. Raises RuntimeError once closed."""
        self._check_open()
        return NamedObjects({} if self._rendering is None else self._rendering.lights, "light")

    @property
    def cameras(self) -> dict[str, CameraBatch]:
        """Cameras by name. If the plan has none, `default`, which frames the whole scene.

        They also exist without a render device, but then `capture` raises RuntimeError. Raises RuntimeError once
        closed.
        """
        self._check_open()
        return NamedObjects({} if self._rendering is None else self._rendering.cameras, "camera")

    def framed(
        self,
        width: int = 640,
        height: int = 480,
        *,
        focus: str | None = None,
        eye: Sequence[float] | None = None,
        look_at: Sequence[float] | None = None,
        view: View | None = None,
        zoom: float = 1.0,
        shader: ShaderName | None = None,
    ) -> CameraBatch:
        """Returns a new camera that frames each scene at its first picture and then does not move.

        Args:
            width: of its pictures [px].
            height: of its pictures [px].
            focus: an entity or link (ENTITY/LINK) to frame instead of everything that moves.
            eye: (3,) position [m]. None: in front of, left of and above the subject, where all of it is in view.
            look_at: (3,) point in the middle of the picture [m]. None: the middle of the subject.
            view: the side to look from instead of `eye`: "iso", "front" (from +x), "back", "left" (from +y), "right",
                "top", "bottom".
            zoom: magnification about the middle of the picture.
            shader: SAPIEN's shader pack. None: its default.

        Raises:
            ValueError: the renderer does not support this size, `eye` equals `look_at`, or there is a `view` as well.
            RuntimeError: the batch is closed, or the render device does not support ray tracing.
        """
        self._check_open()
        assert self._rendering is not None
        if eye is not None and look_at is not None and list(eye) == list(look_at):
            raise ValueError("a camera cannot look at its own position")
        if eye is not None and view is not None:
            raise ValueError("a camera has an eye or a view, not both")
        return self._rendering.framed(
            width, height, focus=focus, eye=eye, look_at=look_at, view=view, zoom=zoom, shader=shader
        )

    def subject(self, scene_idx: int, focus: str | None = None) -> Subject:
        """Returns what a framing camera frames in the current scene. Raises KeyError if `focus` has no visuals.

        Raises RuntimeError if the batch was built without rendering, or is closed.
        """
        self._check_open()
        assert self._rendering is not None
        return self._rendering.subject(scene_idx, focus)

    def body_poses(self, scene_idx: int) -> dict[str, NDArray[np.float64]]:
        """Returns poses (7,) of all bodies in a scene by name (links: ENTITY/LINK). Raises RuntimeError once closed."""
        self._check_open()
        assert self._rendering is not None
        return self._rendering.poses(scene_idx)

    def set_light_preset(self, preset: Preset) -> None:
        """Chooses the rig that lights a scene without lights at its first picture. Raises RuntimeError once closed."""
        self._check_open()
        assert self._rendering is not None
        self._rendering.preset = preset

    def show_collision(self) -> None:
        """Shows collision shapes instead of visuals from now on, coloured by body type.

        Dynamic bodies are blue, kinematic orange, static grey and links green. Meshes are shown as PhysX cooked them.
        Raises RuntimeError if the batch was built without rendering, or is closed.
        """
        self._check_open()
        assert self._rendering is not None
        self._rendering.show_collision()

    @property
    def constraints(self) -> dict[str, ConstraintBatch]:
        """Constraints by name, in build order. Raises RuntimeError once closed."""
        self._check_open()
        return NamedObjects({} if self._constraints is None else self._constraints.batches, "constraint")

    def attach_constraints(self, constraints: ConstraintSet) -> None:
        """Registers the constraints of these scenes. Called by the functions that build a batch."""
        self._constraints = constraints

    def attach_rendering(self, rendering: LightsAndCameras) -> None:
        """Registers the lights and cameras of these scenes. Called by the functions that build a batch."""
        self._rendering = rendering

    @property
    def timestep(self) -> float:
        """Time step [s], as the engine holds it. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._scenes[0].timestep

    def step(self, n: int = 1, *, check: bool = False) -> None:
        """Simulates `n` time steps in every scene. Raises ValueError if negative, RuntimeError once closed.

        With `check`, it checks every ten steps and at the end that all states are finite and within 1e6 m, m/s, rad and
        rad/s. If not, it stops and raises SceneError (SC820); only a reset recovers the scene. Many steps then take 1.1
        to 1.7 times as long, single steps up to 3 times, and more in tiny scenes.
        """
        self._check_open()
        if n.__class__ is not int:
            n = integer(n, "n", 0)
        if n < 0:
            raise ValueError(f"n must not be negative, not {n}")
        stride = CHECK_INTERVAL if check else max(n, 1)
        for done in range(0, max(n, 1), stride):
            count = min(stride, n - done)
            for index, scene in zip(self._scene_idxs, self._scenes, strict=True):
                step = scene.physx_system.step
                for _ in range(count):
                    step()
                self._steps[index] += count
            if check:
                check_divergence(self._plan, self._members.present(), self._steps, self._sink.another())

    def contacts(
        self, a: str | None = None, b: str | None = None, *, scene_idxs: Container[int] | None = None
    ) -> Contacts:
        """Returns the contacts of the last `step`. A scene has none until its first step after the start or a reset.

        Args:
            a: only contacts of this body, articulation or link (ENTITY/LINK). Normals and impulses then act on it.
            b: only contacts with this one.
            scene_idxs: only contacts in these scenes. None: in all.

        Raises:
            KeyError: there is no such entity or link.
            RuntimeError: the batch is closed.
        """
        stepped = (one for one in self._stepped_scenes() if scene_idxs is None or one[0] in scene_idxs)
        return self._contact_reader.read(stepped, a, b)

    def net_contact_force(self, name: str) -> NDArray[np.float32]:
        """Returns the total contact force (B, 3) [N] on a body, articulation or link in the last step, in the world
        frame.

        It is the mean over the step. SAPIEN does not report friction, so it is not included. Rows are the scenes that
        have the entity, as in its `pose`. Forces between links of one articulation cancel out. Raises the errors of
        `contacts`.
        """
        return self._contact_reader.net_force(self._stepped_scenes(), name, self.timestep)

    def remove(self, name: str) -> None:
        """Removes an entity from every scene. `add` puts it back.

        Raises:
            KeyError: this batch has no such entity.
            ValueError: it is already removed.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        self._members.remove(name, self._scene_at)

    def add(self, name: str) -> None:
        """Adds a removed entity again with the objects, poses and velocities that it had when it was removed.

        From then on it is the last in build order, in the engine and in `entities`.

        Raises:
            KeyError: this batch has no such entity.
            ValueError: it is not removed.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        self._members.add(name, self._scene_at)

    def reset(
        self,
        seed: int | Sequence[int] | None = None,
        scene_idxs: Sequence[int] | None = None,
        *,
        draws: Mapping[str, ArrayLike] | None = None,
        exact: bool = False,
    ) -> None:
        """Resets every object to its initial state, and redraws the values that a running simulation can change.

        Redrawn, where the plan draws them: poses of dynamic and kinematic bodies, velocities, joint positions and
        drive targets; masses, damping and gravity of bodies; friction and restitution; limits, gains and friction of
        joints; colours and numbers of visual materials; lights, cameras and the ambient light. Everything else (sizes,
        densities, textures, poses of static bodies) stays as built.

        Every object of the plan gets its initial pose, velocities and sleep state. Targets of kinematic bodies and
        pending forces are cleared. Removed entities stay removed; they get their initial state when they are added
        again. Objects that were added by hand stay, and so do values that were changed by hand and are not drawn.

        Args:
            seed: seed of the draws, for all of these scenes or one for each. None: the last seed of each scene, at
                first that of the plan.
            scene_idxs: scenes to reset; the others are not touched. Default: all.
            draws: values to use once instead of drawing shared draws: name → one row for each of these scenes. Draws
                of built values, such as sizes, cannot be given.
            exact: simulate bit-identically to a newly built batch with this initial state. Otherwise the engine keeps
                its numbering of earlier contacts, so a heap of bodies may differ in the last bit, and the difference
                grows. `exact` moves all content, including objects added by hand, to new `sapien.Scene` objects in
                `scenes`. Entities and components stay the same objects. Takes two to three times as long.

        Raises:
            ValueError: a drawn value is undefined or out of range (the message names entity, field and scene), a
                draw cannot be changed, or an argument is invalid. No scene has changed then.
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = self._select_scenes(scene_idxs)
        seeds = check_seeds(seed, [self._passports.start(index).seed for index in chosen])
        drawing = self._start.batch(chosen, seeds, draws or {})
        states = self._start.drawn(drawing)
        drawn = self._drawn_fields.draw(drawing)
        targets: TargetCalls = []
        if self._constraints is not None and self._constraints.has_targets:
            targets = self._constraints.sample_targets(drawing)
        self._drawn_fields.apply(drawn)
        self._place(chosen, states, exact=exact)
        for component, setter, arguments in targets:
            getattr(component, setter)(*arguments)
        self._passports.note_reset(chosen, seeds, draws, Sampled(states, drawn, drawing))

    def state(self, scene_idxs: Sequence[int] | None = None) -> SceneState:
        """Returns the exact poses, velocities, sleep states and kinematic targets of all bodies in these scenes.

        It also holds what a reset redraws: masses, gains, materials, lights, cameras.

        It can be set in every batch of the same scenes. It lacks what SAPIEN does not expose: the engine's contact
        cache, sleep timers, pending forces, and the velocity of a kinematic body, which follows from its next target.
        It also lacks drive targets of constraints, because the engine rounds a rotation each time it is set.

        Args:
            scene_idxs: scenes to read. Default: all.

        Raises:
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = tuple(sorted(self._select_scenes(scene_idxs)))
        return self._members.state(chosen, self._drawn_fields.state(chosen))

    def set_state(self, state: SceneState, scene_idxs: Sequence[int] | None = None, *, exact: bool = False) -> None:
        """Restores a state of all bodies. `state` then returns the same state.

        The simulation continues as after a reset to these poses and velocities, because the engine's contact cache
        cannot be saved. With `exact`, it continues bit-identically after every restore.

        Args:
            state: a result of `state`, of this batch or of another batch of the same scenes.
            scene_idxs: scenes of the state to restore; the others are not touched. Default: all of them.
            exact: as for `reset`; also creates new `sapien.Scene` objects.

        Raises:
            ValueError: the state has other entities, bodies or scenes, or values that the engine cannot hold. Nothing
                has changed then.
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = self._select_scenes(state.scene_idxs if scene_idxs is None else scene_idxs)
        states = validate_state(state, self._members.objects, chosen)
        drawn = self._drawn_fields.saved(state.drawn, chosen)
        self._drawn_fields.apply(drawn)
        self._place(chosen, states, exact=exact)

    def drawn(self, scene_idxs: Sequence[int] | None = None) -> dict[str, NDArray[Any]]:
        """Returns what the last build or reset drew: name → (B, …), a row for each of these scenes.

        Names and values are those of `scenecc.scene_draws`. Values that were set by hand or by `set_state` are not in
        it. Visual materials, lights and cameras are in it even if the batch does not render.

        Args:
            scene_idxs: scenes to read. Default: all.

        Raises:
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = self._select_scenes(scene_idxs)
        return self._drawn_values.read(chosen, self._passports.drawings(chosen))

    def drawn_rows(self, scene_idxs: Sequence[int] | None = None) -> list[DrawnRow]:
        """Returns the same for each of these scenes: name → value. It is read when it is first used."""
        self._check_open()
        chosen = self._select_scenes(scene_idxs)
        drawings = self._passports.drawings(chosen)
        read = self._drawn_values.read
        return [DrawnRow(partial(read, [one], [drawing])) for one, drawing in zip(chosen, drawings, strict=True)]

    def passport(self, scene: int) -> str:
        """Returns a line of JSON from which `scenecc replay` rebuilds a scene as after its last build or reset.

        It holds hashes of all files, parameters, seeds, versions and a hash of the initial state after the build or
        the last `reset`, without values set by hand or by `set_state`. See `docs/how-to/reproducing.md`.

        Args:
            scene: index of the scene, one of `scene_idxs`.

        Raises:
            ValueError: the batch was built from a plan object.
            OSError: a file of the scene cannot be read, or has changed since it was compiled.
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        return str(self.passports([scene])[0])

    def passports(self, scene_idxs: Sequence[int] | None = None) -> list[Passport]:
        """Returns the passports of some scenes (default: all) for their last build or reset.

        Each is written when its `str` is first taken, which raises the errors of `passport`.
        """
        self._check_open()
        chosen = self._select_scenes(scene_idxs)
        return [Passport(partial(self._write_passport, index, self._passports.start(index))) for index in chosen]

    def _write_passport(self, index: int, start: Start) -> str:
        self._check_open()
        return self._passports.text(index, start, self._start, self._drawn_fields)

    def attach_provenance(self, provenance: Provenance | None) -> None:
        """Registers what the batch was built from. Called by the functions that build a batch."""
        self._passports.provenance = provenance

    def close(self) -> None:
        """Empties and releases every scene. May be called twice."""
        if self._closed:
            return
        self._closed = True
        self._members.close()
        for part in (self._constraints, self._rendering):
            if part is not None:
                part.close()
        for scene in self._scenes:
            scene.clear()
        self._scenes = []
        self._drawn_objects = DrawnObjects()
        self.__dict__.pop("_drawn_fields", None)

    @cached_property
    def _contact_reader(self) -> ContactReader:
        return ContactReader(self._members.objects)

    def _stepped_scenes(self) -> Iterator[tuple[int, sapien.Scene]]:
        """Yields scenes stepped since their last reset. In others the engine still reports old contacts."""
        self._check_open()
        return ((i, scene) for i, scene in zip(self._scene_idxs, self._scenes, strict=True) if self._steps[i])

    @cached_property
    def _start(self) -> ResetSampler:
        return ResetSampler(self._plan, self._scene_idxs, self._members.objects)

    @cached_property
    def _drawn_values(self) -> DrawnValues:
        return DrawnValues(self._plan)

    @cached_property
    def _drawn_fields(self) -> DrawnFieldSet:
        components: dict[str, ComponentBatch] = {}
        systems: dict[int, Any] = {}
        if self._constraints is not None:
            components = {f"constraints/{name}": one for name, one in self._constraints.batches.items()}
        if self._render and self._rendering is not None:
            components |= {f"lights/{name}": one for name, one in self._rendering.lights.items()}
            components |= {f"cameras/{name}": one for name, one in self._rendering.cameras.items()}
            systems = self._rendering.render_systems
        objects = self._members.objects
        holders = plan_holders(self._plan, self._scene_idxs, objects, self._drawn_objects, components, systems)
        return DrawnFieldSet(holders, self._drawn_objects, rendered=self._render)

    def _place(self, scene_idxs: Sequence[int], states: Mapping[str, AnyState], *, exact: bool) -> None:
        placements = self._members.placements(states)
        with interrupts_wait():
            for index in scene_idxs:
                self._steps[index] = 0
                if exact:
                    number = self._number_of[index]
                    self._scenes[number] = restore_in_new_scene(placements, index, self._scenes[number])
                    if self._constraints is not None:
                        self._constraints.allow_collisions(index)
                    if self._rendering is not None:
                        self._rendering.enter_new_scene(index)
                else:
                    with nullcontext() if self._constraints is None else self._constraints.suspend(index):
                        restore_scene(placements, index)

    def _select_scenes(self, scene_idxs: Sequence[int] | None) -> tuple[int, ...]:
        if scene_idxs is None:
            return self._scene_idxs
        chosen = check_scene_idxs(scene_idxs)
        for index in chosen:
            if index not in self._number_of:
                raise KeyError(f"no scene {index} in this batch; it has {list(self._scene_idxs)}")
        return chosen

    def _scene_at(self, index: int) -> sapien.Scene:
        return self._scenes[self._number_of[index]]

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError("the batch is closed")
