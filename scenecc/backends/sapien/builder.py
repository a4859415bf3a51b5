"""A strict, table-driven `ActorBuilder` for batches: parse and cook once, instantiate in every scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.columns import position_and_rotation, taken
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.failure import REFUSED, EngineFailure
from scenecc.backends.sapien.knobs import BODY_KNOBS, RENDER_KNOBS
from scenecc.backends.sapien.mass import mass_step
from scenecc.backends.sapien.shapes import apply, attach, collision_steps, cook, render_component, split, visual_steps

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import BodyStructure, Entity

_COMPONENTS: dict[str, Any] = {
    "dynamic": physx.PhysxRigidDynamicComponent,
    "kinematic": physx.PhysxRigidDynamicComponent,
    "static": physx.PhysxRigidStaticComponent,
    "none": None,
}


class BatchActorBuilder(sapien.ActorBuilder):
    """Builds one structure of an entity, once for each of its rows.

    What SAPIEN's builder leaves out without a word (a shape that cannot be cooked) ends the build
    with an `EngineFailure` here, and the body type none is an entity with a render component only.

    Attributes:
        row: which row the methods of SAPIEN's builder (`build`, `build_entity`, …) make.
    """

    def __init__(
        self,
        entity: Entity,
        structure: BodyStructure,
        rows: NDArray[np.intp],
        resources: Resources,
        *,
        rendered: bool,
    ) -> None:
        super().__init__()
        if structure.body_type in ("static", "none"):
            _refuse_what_cannot_be(structure)
        # Shapes come from the plan alone: SAPIEN's add_* methods append to these, and must not do so unheard.
        self.collision_records = self.visual_records = ()  # pyright: ignore[reportAttributeAccessIssue]
        self.name = entity.name
        self.physx_body_type = structure.body_type
        self.row = 0
        self._origin = structure.origin
        self._component = _COMPONENTS[structure.body_type]
        self._collisions = collision_steps(structure, rows, resources)
        self._visuals = visual_steps(structure, rows, resources) if rendered else ()
        self._mass_step = mass_step(structure, rows)
        self._knobs = split(BODY_KNOBS.steps(structure, rows))
        self._look = split(RENDER_KNOBS.steps(structure, rows) if self._visuals else [])
        self._only_pose: Any = None
        if entity.pose.varies:
            # One by one, when their turn comes: they are still in the processor's cache then.
            self._p, self._q = position_and_rotation(taken(entity.pose, rows))
        else:
            numbers = entity.pose.as_drawn()
            self._only_pose = sapien.Pose(numbers[:3], numbers[3:])

    def cook(self) -> list[EngineFailure]:
        """Cooks every mesh once; what the engine refuses."""
        return cook((*self._collisions, *self._visuals))

    def make(self, row: int) -> tuple[Any, Any]:
        """A new entity, not yet in a scene, and its physical component (None where it has none).

        Raises:
            EngineFailure: the engine cannot make one of its shapes, or refuses a value.
        """
        try:
            return self._make(row)
        except (RuntimeError, TypeError, ValueError) as error:
            words = str(error).partition("\n")[0]
            raise EngineFailure(REFUSED, f"the engine refuses this body: {words}", origin=self._origin) from error

    def _make(self, row: int) -> tuple[Any, Any]:
        entity = sapien.Entity()
        component = None
        if self._visuals:
            entity.add_component(render_component(self._visuals, self._look, self.name, row))
        if self._component is not None:
            component = self._make_physx_component(row)
            entity.add_component(component)
        entity.set_name(self.name)
        pose = self._only_pose
        entity.set_pose(sapien.Pose(self._p[row], self._q[row]) if pose is None else pose)
        return entity, component

    def build_entity(self) -> Any:
        """The entity of `row`, at its pose."""
        entity, _ = self.make(self.row)
        self.initial_pose = entity.pose
        return entity

    def build_physx_component(self, link_parent: None = None) -> Any:
        """The physical component of `row`; None for the body type none."""
        del link_parent
        return None if self._component is None else self._make_physx_component(self.row)

    def build_render_component(self) -> Any:
        """The render component of `row`."""
        return render_component(self._visuals, self._look, self.name, self.row)

    def _make_physx_component(self, row: int) -> Any:
        component = self._component()
        if self.physx_body_type == "kinematic":
            component.set_kinematic(True)
        for shape in self._collisions:
            attach(component, shape, row)
        if self._mass_step is not None:
            self._mass_step(component, row)
        apply(self._knobs, component, row)
        component.set_name(self.name)
        return component


def _refuse_what_cannot_be(structure: BodyStructure) -> None:
    """These types have no component that could hold it, and nothing is dropped unheard."""
    said = [knob.get for knob, _ in BODY_KNOBS.said(structure)]
    said += [name for name in ("mass", "inertial") if getattr(structure, name) is not None]
    if structure.body_type == "none":
        said += [name for name in ("collisions", "collision_groups") if getattr(structure, name)]
    if said:
        raise EngineFailure(REFUSED, f"a body of type {structure.body_type} has no {said[0]}", origin=structure.origin)
