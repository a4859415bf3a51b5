"""Single bodies against the plan: everything that can be read of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.difference import same_local_pose, shown
from scenecc.backends.sapien.audit.mass import stored
from scenecc.backends.sapien.audit.shapes import ShapeAudit
from scenecc.backends.sapien.audit.sweep import Expected, Place, Sweep, given
from scenecc.backends.sapien.audit.visuals import VisualAudit
from scenecc.backends.sapien.columns import poses
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.knobs import BODY_KNOBS

if TYPE_CHECKING:
    from scenecc.backends.sapien.audit.defaults import Defaults
    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.turn import Turn
    from scenecc.plan import BodyStructure, Inertial, ScenePlan

_TYPES = {
    "dynamic": physx.PhysxRigidDynamicComponent,
    "kinematic": physx.PhysxRigidDynamicComponent,
    "static": physx.PhysxRigidStaticComponent,
}


class BodyAudit:
    """Looks at bodies; what differs is in the sweep afterwards."""

    def __init__(self, plan: ScenePlan, defaults: Defaults, meshes: Meshes, sweep: Sweep, *, rendered: bool) -> None:
        self._meshes = meshes
        self._defaults = defaults
        self._sweep = sweep
        self._rendered = rendered
        self._shapes = ShapeAudit(plan, defaults, meshes, sweep)
        self._visuals = VisualAudit(plan, defaults, sweep)

    def look_at(self, turn: Turn, structure: BodyStructure, number: int, scene: Any) -> None:
        """The body that is number `number` of its entity, in `scene`; its pose is looked at elsewhere."""
        entity, row = turn.objs[number], int(turn.rows[number])
        place = Place(turn, number, structure.origin)
        name = turn.entity.name
        if entity.name != name:
            self._sweep.tell(place, "name", repr(name), repr(entity.name))
        if entity.scene is not scene:
            self._sweep.tell(place, "scene", "the one that it was built in", "another")
        components = entity.components
        bodies = [part for part in components if isinstance(part, physx.PhysxRigidBaseComponent)]
        looks = [part for part in components if isinstance(part, render.RenderBodyComponent)]
        expected = [int(structure.body_type != "none"), int(self._rendered and bool(structure.visuals))]
        if [len(bodies), len(looks)] != expected:
            self._sweep.tell(place, "components (physics, render)", expected, [len(bodies), len(looks)])
            return
        for component in (*bodies, *looks):
            if component.name != name:
                self._sweep.tell(place, "component.name", repr(name), repr(component.name))
        for body in bodies:
            self._body(structure, body, row, place)
        for look in looks:
            self._visuals.look_at(structure, look, row, place)

    def _body(self, structure: BodyStructure, body: Any, row: int, place: Place) -> None:
        kind = _TYPES[structure.body_type]
        if type(body) is not kind:
            self._sweep.tell(place, "type", kind.__name__, type(body).__name__)
            return
        self._shapes.look_at(structure, body, row, place)
        if structure.body_type != "static":
            self._sweep.expect(self._knobs(structure, row), body, place)
            if structure.inertial is not None:
                self._given_mass(structure.inertial, body, row, place)
            else:
                self._mass(structure, body, row, place)

    def _knobs(self, structure: BodyStructure, row: int) -> Expected:
        defaults = self._defaults.kinematic if structure.body_type == "kinematic" else self._defaults.dynamic
        said = {knob.get: given(value.row(row)) for knob, value in BODY_KNOBS.said(structure)}
        return defaults | said if said else defaults

    def _given_mass(self, inertial: Inertial, body: Any, row: int, place: Place) -> None:
        self._stored(inertial.mass.row(row), inertial.inertia.row(row), body, place)
        if not same_local_pose(inertial.com.row(row), body.cmass_local_pose):
            self._sweep.tell(place, "cmass_local_pose", shown(inertial.com.row(row)), shown(body.cmass_local_pose))

    def _mass(self, structure: BodyStructure, body: Any, row: int, place: Place) -> None:
        """The engine computes mass and inertia again, on a body that has nothing but the shapes."""
        reference = self._reference(structure, row)
        if structure.mass is not None:
            mass = structure.mass.row(row)
            self._stored(mass, reference.inertia.astype(np.float64) * (mass / reference.mass), body, place)
        elif body.mass != reference.mass:
            self._sweep.tell(place, "mass", shown(reference.mass), shown(body.mass))
        elif body.inertia.tobytes() != reference.inertia.tobytes():
            self._sweep.tell(place, "inertia", shown(reference.inertia), shown(body.inertia))
        found, wanted = body.cmass_local_pose, reference.cmass_local_pose
        if found.__getstate__() != wanted.__getstate__():
            self._sweep.tell(place, "cmass_local_pose", shown(wanted), shown(found))

    def _stored(self, mass: Any, inertia: Any, body: Any, place: Place) -> None:
        if body.mass != stored(mass):
            self._sweep.tell(place, "mass", shown(mass), shown(body.mass))
        if (body.inertia != stored(inertia)).any():
            self._sweep.tell(place, "inertia", shown(inertia), shown(body.inertia))

    def _reference(self, structure: BodyStructure, row: int) -> Any:
        body = physx.PhysxRigidDynamicComponent()
        for shape in structure.collisions:
            for part in self._meshes.fresh(shape.geometry, row):
                if shape.pose is not None:
                    part.set_local_pose(poses(shape.pose.row(row)[None])[0])
                if shape.density is not None:
                    part.set_density(float(shape.density.row(row)))
                body.attach(part)
        return body
