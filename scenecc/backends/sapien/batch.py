"""`SceneBatch`: the scenes that were built, stepped and reset together, and the check for states that diverge."""

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
from scenecc.errors import SceneError
from scenecc.interrupt import interrupts_wait
from scenecc.options import check_scene_idxs, check_seeds, integer

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
    from scenecc.plan.framing import Subject
    from scenecc.plan.light_rigs import Preset
    from scenecc.plan.rendering import ShaderName
    from scenecc.source.provenance import Provenance

DIVERGENCE_LIMIT: Final = 1e6
"""[m, m/s, rad, rad/s] Single precision resolves 0.06 m there, so no scene is meant to reach it."""

_DIVERGENCE_HINT: Final = "a smaller `physics.timestep`, weaker drives, or masses that differ less may help"

CHECK_INTERVAL: Final = 10
"""Steps from one check to the next: a check costs as much as some steps."""


class _Divergence(NamedTuple):
    """A body, or a link of an articulation, that is not finite or beyond `DIVERGENCE_LIMIT`."""

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
    """Checks that all that moves is finite and within `DIVERGENCE_LIMIT`.

    Args:
        plan: gives the origins of the entities.
        present: the objects that are in the scenes now.
        steps: scene index → how many steps were simulated.
        sink: takes the diagnostic.

    Raises:
        SceneError: something diverged.
    """
    found: list[_Divergence] = []
    for objects in present:
        found += _diverged_links(objects) if isinstance(objects, ArticulationObjects) else _diverged_bodies(objects)
    if not found:
        return
    first = min(found, key=lambda one: one.scene)
    others = len({one.scene for one in found}) - 1
    too = f", and others are in {others} more scene{'s' * (others > 1)}" if others else ""
    place = next(entity.origin for entity in plan.entities if entity.name == first.entity)
    sink.report("SC820", f"{first} by step {steps[first.scene]}{too}", place or Location(None), hint=_DIVERGENCE_HINT)
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
    """(N, 13) poses and velocities."""
    velocities = [v for c in components for v in (c.get_linear_velocity(), c.get_angular_velocity())]
    pose = np.array([entity.get_pose().__getstate__() for entity in entities], np.float32).reshape(-1, 7)
    return np.hstack((pose, np.array(velocities, np.float32).reshape(-1, 6)))


def _joint_motion(objs: Sequence[Any]) -> NDArray[np.float32]:
    """(N, 2) positions and velocities of all joints that move."""
    numbers = [np.stack((obj.get_qpos(), obj.get_qvel()), axis=1) for obj in objs]
    return np.concatenate(numbers) if numbers else np.empty((0, 2), np.float32)


def _rows_beyond_limit(numbers: NDArray[np.float32]) -> list[tuple[int, bool]]:
    """The rows that hold a number which is not finite or too large, and whether all of their numbers are finite."""
    fine = (np.abs(numbers) <= DIVERGENCE_LIMIT).all(axis=1)  # no comparison holds for a number that is none
    return [(row, bool(np.isfinite(numbers[row]).all())) for row in np.flatnonzero(~fine).tolist()]


class ObjectRegistry:
    """The bodies and articulations of a batch.

    Attributes:
        objects: all that were built, by name.
        entities, articulations: those that are in the scenes now, by name, in build order.
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
        """Takes one out of every scene. `scene_at`: from the plan's index to the scene.

        Raises:
            KeyError: there is none of this name.
            ValueError: it is removed already.
        """
        if name in self._removed:
            raise ValueError(f"'{name}' is removed already")
        self._removed[name] = self._present(name)
        objects = self.objects[name]
        if isinstance(objects, ArticulationObjects):
            self._removed_articulations[name] = RemovedArticulation(read_articulations(objects, objects.scene_idxs))
        for index, entity in iterate_entities(objects):
            scene_at(index).remove_entity(entity)
        self.entities.pop(name, None)
        self.articulations.pop(name, None)
        self._order.remove(name)

    def add(self, name: str, scene_at: Callable[[int], Any]) -> None:
        """Puts a removed one back, as the last in build order. `scene_at`: as for `remove`.

        Raises:
            KeyError: there is none of this name.
            ValueError: it is there.
        """
        if name not in self._removed:
            self._present(name)
            raise ValueError(f"'{name}' is there; only what was removed can be added")
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
        """Those that are in the scenes now."""
        return (self.objects[name] for name in self._order)

    def state(self, scene_idxs: tuple[int, ...], drawn: dict[str, DrawnFieldState]) -> SceneState:
        """The state of all in these scenes, and of those that are removed from them. `drawn`: what it also holds."""
        found = {
            name: read_state(objects, self._removed_articulations.get(name), scene_idxs)
            for name, objects in self.objects.items()
        }
        return SceneState.of(scene_idxs, found, drawn)

    def placements(self, states: Mapping[str, AnyState]) -> list[StateWriter]:
        """What puts each where its state says, in build order; removed articulations have theirs when they are added.

        Args:
            states: by name, of some or all.
        """
        for name in self._removed_articulations.keys() & states.keys():
            self._removed_articulations[name].change(states[name])
        names = [name for name in (*self._order, *self._removed) if name in states]
        return [make_state_writer(self.objects[name], states[name]) for name in names]

    def close(self) -> None:
        """Lets go of everything, and has what a user holds of it say so."""
        for each in (*self.entities.values(), *self.articulations.values(), *self._removed.values()):
            each._close()  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        self.objects = {}
        self.entities.clear()
        self.articulations.clear()
        self._order, self._removed, self._removed_articulations = [], {}, {}

    def _present(self, name: str) -> EntityBatch | ArticulationBatch:
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
        """The plan from which it was built."""
        return self._plan

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """Indices of the plan's scenes that were built, ascending; `scenes` has the same order."""
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
        """Bodies that are in the scenes now, by name, in build order. Raises RuntimeError once closed."""
        self._check_open()
        return self._members.entities

    @property
    def articulations(self) -> dict[str, ArticulationBatch]:
        """Articulations that are in the scenes now, by name, in build order. Raises RuntimeError once closed."""
        self._check_open()
        return self._members.articulations

    @property
    def lights(self) -> dict[str, LightBatch]:
        """Lights by name; those of the default rig where the plan has none. Raises RuntimeError once closed."""
        self._check_open()
        return NamedObjects({} if self._rendering is None else self._rendering.lights, "light")

    @property
    def cameras(self) -> dict[str, CameraBatch]:
        """Cameras by name; if the plan has none, `default`, which sees the whole scene.

        They exist without a render device, too; `capture` then raises RuntimeError. Raises RuntimeError once closed.
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
        shader: ShaderName | None = None,
    ) -> CameraBatch:
        """A new camera that frames each scene at its first picture and then does not move.

        Args:
            width: of its pictures [px].
            height: of its pictures [px].
            focus: frame this entity, or link (ENTITY/LINK), instead of what moves.
            eye: (3,) where it stands [m]; None: where it sees all that it frames from the front, left and above.
            look_at: (3,) the point in the middle of the picture [m]; None: the middle of what it frames.
            shader: SAPIEN's shader pack; None: its default.

        Raises:
            ValueError: no renderer makes pictures of this size, or `eye` is `look_at`.
            RuntimeError: the batch is closed, or the render device cannot trace rays.
        """
        self._check_open()
        assert self._rendering is not None
        if eye is not None and look_at is not None and list(eye) == list(look_at):
            raise ValueError("a camera cannot look at the point where it stands")
        return self._rendering.framed(width, height, focus=focus, eye=eye, look_at=look_at, shader=shader)

    def subject(self, scene_idx: int, focus: str | None = None) -> Subject:
        """What a framing camera frames of a scene as it stands now. Raises KeyError if nothing is seen of `focus`.

        Raises RuntimeError if the batch was built without rendering, or is closed.
        """
        self._check_open()
        assert self._rendering is not None
        return self._rendering.subject(scene_idx, focus)

    def body_poses(self, scene_idx: int) -> dict[str, NDArray[np.float64]]:
        """The poses (7,) of all bodies in a scene by name, of links as ENTITY/LINK. Raises RuntimeError once closed."""
        self._check_open()
        assert self._rendering is not None
        return self._rendering.poses(scene_idx)

    def set_light_preset(self, preset: Preset) -> None:
        """Says which rig lights a scene that has no lights at its first picture. Raises RuntimeError once closed."""
        self._check_open()
        assert self._rendering is not None
        self._rendering.preset = preset

    def show_collision(self) -> None:
        """Draws collision shapes in place of visuals from now on, coloured by type of body.

        Dynamic ones are blue, kinematic ones orange, static ones grey and links green. Meshes are drawn as the engine
        has cooked them. Raises RuntimeError if the batch was built without rendering, or is closed.
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
        """Registers the constraints that were built in these scenes. Called by the builders of a batch."""
        self._constraints = constraints

    def attach_rendering(self, rendering: LightsAndCameras) -> None:
        """Registers the lights and cameras that were built in these scenes. Called by the builders of a batch."""
        self._rendering = rendering

    @property
    def timestep(self) -> float:
        """Length of one step [s], as the engine holds it. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._scenes[0].timestep

    def step(self, n: int = 1, *, check: bool = False) -> None:
        """Simulates `n` time steps in every scene. Raises ValueError if negative, RuntimeError once closed.

        With `check` it looks after every ten steps and after the last, or at once if `n` is 0, whether all that moves
        is finite and within 1e6 m, m/s, rad and rad/s. Where it is not, it stops and raises SceneError (SC820); only a
        reset helps. Many steps take 1.1 to 1.7 times as long with it, single ones up to 3 times, in tiny scenes more.
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
        """The contacts of the last `step`; a scene that was not stepped since its start or a reset has none.

        Args:
            a: only those of this body or articulation, or of one link: ENTITY/LINK. Normals and impulses are on it.
            b: only those with this one.
            scene_idxs: only those of these scenes; None: of all.

        Raises:
            KeyError: there is no such entity or link.
            RuntimeError: the batch is closed.
        """
        stepped = (one for one in self._stepped_scenes() if scene_idxs is None or one[0] in scene_idxs)
        return self._contact_reader.read(stepped, a, b)

    def net_contact_force(self, name: str) -> NDArray[np.float32]:
        """(B, 3) [N] sum of the contact forces on a body, articulation or link in the last step, in the world frame.

        Means over the step, without friction, which SAPIEN does not give. Rows are the scenes that have the entity, as
        of its `pose`. Forces between links of an articulation cancel out. Errors as of `contacts`.
        """
        return self._contact_reader.net_force(self._stepped_scenes(), name, self.timestep)

    def remove(self, name: str) -> None:
        """Takes an entity out of every scene; `add` puts it back.

        Raises:
            KeyError: the plan has no such entity here.
            ValueError: it is removed already.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        self._members.remove(name, self._scene_at)

    def add(self, name: str) -> None:
        """Puts a removed entity back as it was when it was removed: same objects, poses and velocities.

        It is the last in the build order from then on, in the engine and in `entities`.

        Raises:
            KeyError: the plan has no such entity here.
            ValueError: it is there.
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
        """Draws what a running simulation can change anew, and puts every object back to its start.

        Where the plan draws them, anew are poses of dynamic and kinematic bodies, velocities, joints and targets of
        drives; masses, damping and gravity of bodies; friction and restitution; limits, gains and friction of joints;
        colours and numbers of visual materials; lights, cameras and the ambient light. Everything else (sizes,
        densities, textures, poses of static bodies) stays as it was built. Every object of the plan gets its pose, its
        velocities and its sleep state at the start; targets of kinematic bodies and forces that wait for the next step
        are forgotten. Removed entities stay removed and are at their start when they are added again. What the plan
        does not draw and was changed by hand (a mass, a damping) stays, and so does what was added to the scenes by
        hand.

        Args:
            seed: of the draws, for all of these scenes or one for each; None: the one that each scene had last, which
                is the plan's at first.
            scene_idxs: which of the scenes; the others are not touched. All by default.
            draws: values of shared draws, this once, in place of drawing: name → one row for each of these scenes. A
                draw that anything built reads cannot be given here.
            exact: simulate from here on to the bit as a batch that was just built with this start. Without it the
                engine keeps its numbering of earlier contacts, and a heap of bodies may move on otherwise in the last
                bit, which grows. The price: these scenes are new `sapien.Scene` objects, in `scenes`. They hold
                everything that the old ones held, cameras, lights and what was added by hand too; the old ones are
                empty. Entities and components stay the same objects. Takes two to three times as long.

        Raises:
            ValueError: something is drawn that has no value or that the engine cannot hold (the entity, the field and
                the scene are named), a draw cannot be changed, or an argument does not fit. Nothing is changed then.
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = self._chosen(scene_idxs)
        seeds = check_seeds(seed, [self._passports.start(index).seed for index in chosen])
        drawing = self._start.batch(chosen, seeds, draws or {})
        states = self._start.drawn(drawing)
        drawn = self._drawn_fields.draw(drawing)
        again: TargetCalls = []
        if self._constraints is not None and self._constraints.pulls:
            again = self._constraints.again(drawing)
        self._drawn_fields.apply(drawn)
        self._place(chosen, states, exact=exact)
        for component, setter, arguments in again:
            getattr(component, setter)(*arguments)
        self._passports.note_reset(chosen, seeds, draws, Sampled(states, drawn))

    def state(self, scene_idxs: Sequence[int] | None = None) -> SceneState:
        """Poses and velocities of all bodies in these scenes, to the bit, who is asleep, and where kinematic bodies go.

        Of the rest it holds what a reset draws anew: masses, gains, materials, lights, cameras.

        It can be set in every batch of the same scenes. What SAPIEN lets nobody read is not in it: the engine's memory
        of contacts, how long a body has been slow, forces that wait for the next step, and the velocity of a
        kinematic body, which follows from its next target. Targets of constraints' drives are not in it either: the
        engine rounds a rotation anew whenever it is set.

        Args:
            scene_idxs: which of the scenes, all by default.

        Raises:
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = tuple(sorted(self._chosen(scene_idxs)))
        return self._members.state(chosen, self._drawn_fields.state(chosen))

    def set_state(self, state: SceneState, scene_idxs: Sequence[int] | None = None, *, exact: bool = False) -> None:
        """Puts all bodies where a state says: `state` gives the same again.

        The simulation goes on as from a new start with these poses and velocities, not as it went on when the state was
        taken: what the engine remembers of contacts cannot be saved. With `exact` it goes on to the bit the same after
        every restoring, whatever was before.

        Args:
            state: from `state`, of this batch or of another of the same scenes.
            scene_idxs: which scenes of the state; the others are not touched. All of them by default.
            exact: as for `reset`, and new `sapien.Scene` objects too.

        Raises:
            ValueError: the state is of other entities, bodies or scenes, or holds what the engine cannot. Nothing is
                changed then.
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        self._check_open()
        chosen = self._chosen(state.scene_idxs if scene_idxs is None else scene_idxs)
        states = validate_state(state, self._members.objects, chosen)
        drawn = self._drawn_fields.saved(state.drawn, chosen)
        self._drawn_fields.apply(drawn)
        self._place(chosen, states, exact=exact)

    def passport(self, scene: int) -> str:
        """A line of JSON from which `scenecc replay` builds a scene again as it was at its last start.

        It has hashes of all files, parameters, seeds, versions and a hash of the state at the start: what the last
        `reset`, or the build, gave. What was set by hand is not in it, nor what `set_state` restored. See
        `docs/how-to/reproducing.md`.

        Args:
            scene: its index, one of `scene_idxs`.

        Raises:
            ValueError: the batch was built from a plan as an object.
            OSError: a file of the scene cannot be read, or changed since it was compiled.
            KeyError: this batch has no such scene.
            RuntimeError: the batch is closed.
        """
        return str(self.passports([scene])[0])

    def passports(self, scene_idxs: Sequence[int] | None = None) -> list[Passport]:
        """The passports of some scenes at their last starts, all by default. Each is written when its `str` is taken.

        Writing one raises as `passport` does.
        """
        self._check_open()
        chosen = self._chosen(scene_idxs)
        return [Passport(partial(self._write_passport, index, self._passports.start(index))) for index in chosen]

    def _write_passport(self, index: int, start: Start) -> str:
        self._check_open()
        return self._passports.text(index, start, self._start, self._drawn_fields)

    def attach_provenance(self, provenance: Provenance | None) -> None:
        """Registers what the batch was built from. Called by the functions that build."""
        self._passports.provenance = provenance

    def close(self) -> None:
        """Empties every scene and lets go of it. Closing twice is allowed."""
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
        """The scenes whose contacts are of a step: after a reset the engine still gives the old ones."""
        self._check_open()
        return ((i, scene) for i, scene in zip(self._scene_idxs, self._scenes, strict=True) if self._steps[i])

    @cached_property
    def _start(self) -> ResetSampler:
        return ResetSampler(self._plan, self._scene_idxs, self._members.objects)

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
                    if self._rendering is not None:
                        self._rendering.enter_new_scene(index)
                else:
                    with nullcontext() if self._constraints is None else self._constraints.apart(index):
                        restore_scene(placements, index)

    def _chosen(self, scene_idxs: Sequence[int] | None) -> tuple[int, ...]:
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
