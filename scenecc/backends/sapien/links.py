"""Links of an articulation as prepared calls: a body as of an actor, without what only an actor has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.failure import REFUSED, EngineFailure
from scenecc.backends.sapien.joints import JointSteps
from scenecc.backends.sapien.knobs import BODY_KNOBS, RENDER_KNOBS
from scenecc.backends.sapien.mass import mass_step
from scenecc.backends.sapien.shapes import apply, attach, collision_steps, cook, render_component, split, visual_steps

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import BodyStructure, Link

_Link = physx.PhysxArticulationLinkComponent

LINK_FIELDS = tuple(field for field in BODY_KNOBS.by_field if hasattr(_Link, f"set_{field}"))
"""Fields of `BodyStructure` that a link has as a dynamic body has them; the others do not exist on SAPIEN's links."""


class LinkSteps:
    """How one link of the plan is made, row by row.

    Attributes:
        parent: number of the link that it hangs on; None: it is the root.
    """

    __slots__ = (
        "_collisions",
        "_joint",
        "_knobs",
        "_look",
        "_mass",
        "_name",
        "_origin",
        "_visuals",
        "parent",
    )

    def __init__(self, link: Link, rows: NDArray[np.intp], resources: Resources, *, rendered: bool) -> None:
        body = link.body
        _refuse_what_cannot_be(body)
        self.parent = link.parent
        self._name = link.name
        self._origin = body.origin
        self._collisions = collision_steps(body, rows, resources)
        self._visuals = visual_steps(body, rows, resources) if rendered else ()
        self._mass = mass_step(body, rows)
        self._knobs = split(BODY_KNOBS.steps(body, rows))
        self._look = split(RENDER_KNOBS.steps(body, rows) if self._visuals else [])
        self._joint = None if link.joint is None else JointSteps(link.joint, rows)

    def cook(self) -> list[EngineFailure]:
        """Cooks every mesh once; what the engine refuses."""
        return cook((*self._collisions, *self._visuals))

    def make(self, parent: Any, row: int) -> tuple[Any, Any]:
        """A new entity, not yet in a scene, and its link, which hangs on `parent`.

        Raises:
            EngineFailure: the engine cannot make one of its shapes, or refuses a value.
        """
        try:
            return self._make(parent, row)
        except (RuntimeError, TypeError, ValueError) as error:
            words = str(error).partition("\n")[0]
            raise EngineFailure(
                REFUSED, f"the engine refuses the link '{self._name}': {words}", origin=self._origin
            ) from error

    def _make(self, parent: Any, row: int) -> tuple[Any, Any]:
        link = _Link(parent)
        for shape in self._collisions:
            attach(link, shape, row)
        if self._mass is not None:
            self._mass(link, row)
        apply(self._knobs, link, row)
        link.set_name(self._name)
        entity = sapien.Entity()
        entity.add_component(link)
        if self._visuals:
            entity.add_component(render_component(self._visuals, self._look, self._name, row))
        entity.set_name(self._name)
        if self._joint is not None:
            self._joint.apply(link.get_joint(), row)
        return entity, link


def _refuse_what_cannot_be(body: BodyStructure) -> None:
    """SAPIEN's links have no such property, and nothing is dropped unheard."""
    said = [knob.get for knob, _ in BODY_KNOBS.said(body) if knob.get not in LINK_FIELDS]
    if said:
        raise EngineFailure(REFUSED, f"a link has no {said[0]}", origin=body.origin)
