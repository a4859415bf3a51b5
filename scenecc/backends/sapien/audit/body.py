"""Single bodies against the plan: everything that can be read of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.difference import same_local_pose, shown
from scenecc.backends.sapien.audit.mass import LOST, fault, misses, shapes_mass, stored
from scenecc.backends.sapien.audit.shapes import ShapeAudit
from scenecc.backends.sapien.audit.sweep import Place, Sweep
from scenecc.backends.sapien.audit.visuals import VisualAudit
from scenecc.backends.sapien.columns import plain_row, poses
from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.knobs import BODY_KNOBS
from scenecc.plan.properties import MAX_BODY_OFFSET

if TYPE_CHECKING:
    from scenecc.backends.sapien.audit.defaults import Defaults
    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.turn import Turn
    from scenecc.plan import BodyStructure, Inertial, ScenePlan

_TYPES = {
    "dynamic": physx.PhysxRigidDynamicComponent,
    "kinematic": physx.PhysxRigidDynamicComponent,
    "static": physx.PhysxRigidStaticComponent,
    "link": physx.PhysxArticulationLinkComponent,
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

    def look_at(self, turn: Turn, structure: BodyStructure, number: int) -> None:
        """The body that is number `number` of its entity; its name, scene and pose are looked at elsewhere."""
        place = Place(turn, number, structure.origin)
        self.components(turn.entity.name, structure, turn.objs[number].components, int(turn.rows[number]), place)

    def components(self, name: str, structure: BodyStructure, components: list[Any], row: int, place: Place) -> None:
        """What an entity has: a body of a name, in a row of the plan's values."""
        kinds = self._kinds(structure)
        if list(map(type, components)) != kinds:
            names = [[kind.__name__ for kind in some] for some in (kinds, map(type, components))]
            self._sweep.tell(place, "components", names[0], names[1])
            return
        for component in components:
            self._sweep.hold("component.name", name, component, place)
            if isinstance(component, render.RenderBodyComponent):
                self._visuals.look_at(structure, component, row, place)
            else:
                self._body(structure, component, row, place)

    def _kinds(self, structure: BodyStructure) -> list[Any]:
        seen: list[Any] = [render.RenderBodyComponent] if self._rendered and structure.visuals else []
        if structure.body_type == "none":
            return seen
        own = _TYPES[structure.body_type]
        # SAPIEN's builders make the look of an actor first, and that of a link last.
        return [own, *seen] if structure.body_type == "link" else [*seen, own]

    def _body(self, structure: BodyStructure, body: Any, row: int, place: Place) -> None:
        self._shapes.look_at(structure, body, row, place)
        if structure.body_type != "static":
            kinds = {"kinematic": self._defaults.kinematic, "link": self._defaults.link}
            defaults = kinds.get(structure.body_type, self._defaults.dynamic)
            own = {knob.get: plain_row(value, row) for knob, value in BODY_KNOBS.said(structure)}
            self._sweep.expect_but(defaults, own, body, place)
            if structure.inertial is not None:
                self._given_mass(structure.inertial, body, row, place)
            else:
                self._mass(structure, body, row, place)

    def _given_mass(self, inertial: Inertial, body: Any, row: int, place: Place) -> None:
        self._stored(inertial.mass.row(row), inertial.inertia.row(row), body, place)
        if not same_local_pose(inertial.com.row(row), body.cmass_local_pose):
            self._sweep.tell(place, "cmass_local_pose", shown(inertial.com.row(row)), shown(body.cmass_local_pose))

    def _mass(self, structure: BodyStructure, body: Any, row: int, place: Place) -> None:
        """The engine computes mass and inertia again, on a body of the shapes alone, and must weigh what these do."""
        reference = self._reference(structure, row)
        weight = shapes_mass(structure, np.array([row]), self._meshes)
        if misses(reference.mass, weight):
            self._sweep.tell(place, "mass", shown(weight[0]), shown(reference.mass), fault(weight[0]))
        centre = reference.cmass_local_pose.p
        if structure.body_type != "kinematic" and not np.abs(centre).max() <= MAX_BODY_OFFSET:
            self._sweep.tell(place, "cmass_local_pose.p", "a place within 10 km", shown(centre), LOST)
        if structure.mass is not None:
            mass = structure.mass.row(row)
            self._stored(mass, reference.inertia.astype(np.float64) * (mass / reference.mass), body, place)
        else:
            self._sweep.hold("mass", reference.mass, body, place)
            self._sweep.hold("inertia", reference.inertia, body, place)
        # To the bit, unlike poses of the plan: the engine has computed and normalised both.
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
