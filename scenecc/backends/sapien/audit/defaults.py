"""What the engine gives fresh objects now: expected wherever the plan says nothing."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.engine import physx, render
from scenecc.backends.sapien.knobs import BODY_KNOBS, GROUPS, IDENTITY, RENDER_KNOBS, SHAPE_KNOBS, Knobs
from scenecc.plan import VisualMaterial

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.backends.sapien.audit.sweep import Expected

PHYSICAL = ("static_friction", "dynamic_friction", "restitution")
PAINT = tuple(f.name for f in fields(VisualMaterial) if not f.name.endswith("_texture"))


@dataclass(frozen=True, slots=True)
class Defaults:
    """Properties of fresh objects, by the engine's names.

    Attributes:
        material: the `PhysxMaterial` of shapes that name none, and `friction` its properties.
        shape, plane: of a collision shape of a body without collision groups of its own.
        pose: of a shape.
        dynamic, kinematic: of a rigid body.
        look, paint: of a render body and of a `RenderMaterial`; empty where nothing renders.
    """

    material: Any
    friction: Expected
    shape: Expected
    plane: Expected
    pose: Expected
    dynamic: Expected
    kinematic: Expected
    look: Expected
    paint: Expected


def fresh(default_material: Any, *, rendered: bool) -> Defaults:
    """Reads the defaults off objects that nothing else has touched."""
    shape = _table(SHAPE_KNOBS, physx.PhysxCollisionShapeSphere(1.0, default_material))
    shape[GROUPS.get] = list(GROUPS.default)
    body = _table(BODY_KNOBS, physx.PhysxRigidDynamicComponent())
    return Defaults(
        material=default_material,
        friction=_read(default_material, PHYSICAL),
        shape=shape,
        plane=shape | {"density": 0.0},
        pose={"local_pose": IDENTITY},
        dynamic=body | {"kinematic": False},
        kinematic=body | {"kinematic": True},
        look=_table(RENDER_KNOBS, render.RenderBodyComponent()) if rendered else {},
        paint=_read(render.RenderMaterial(), PAINT) if rendered else {},
    )


def _table(knobs: Knobs, engine: object) -> Expected:
    return _read(engine, [knob.get for knob in knobs.by_field.values()])


def _read(engine: object, names: Iterable[str]) -> Expected:
    return {name: getattr(engine, name) for name in names}
