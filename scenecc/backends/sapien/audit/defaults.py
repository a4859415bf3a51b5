"""What an untouched engine gives fresh objects, and what the plan's settings change of it.

Read before a build sets anything: what objects are given meanwhile is what is to be audited.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.audit.difference import pose_state, single
from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.backends.sapien.joints import JOINT_KNOBS
from scenecc.backends.sapien.knobs import (
    ARTICULATION_KNOBS,
    BODY_KNOBS,
    GROUPS,
    RENDER_KNOBS,
    SHAPE_KNOBS,
    Knobs,
)
from scenecc.backends.sapien.links import LINK_FIELDS
from scenecc.plan import VisualMaterial

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.backends.sapien.audit.sweep import Expected
    from scenecc.plan import Friction, Physics

PHYSICAL = ("static_friction", "dynamic_friction", "restitution")
PAINT = tuple(f.name for f in fields(VisualMaterial) if not f.name.endswith("_texture"))

TIMESTEP = 0.01
"""SAPIEN's [s]."""

_PLAN_NAMES = {"subgridSize": "subgrid_size"}
"""SAPIEN's names of settings to the plan's, where they differ."""


@dataclass(frozen=True, slots=True)
class Defaults:
    """Properties of fresh objects, by the engine's names.

    Attributes:
        material: the process-wide `PhysxMaterial`.
        friction: properties of the material of shapes that name none.
        shape, plane: of a collision shape of a body without collision groups of its own.
        pose: of a shape.
        dynamic, kinematic: of a rigid body.
        link, joint, articulation: of these.
        look, paint: of a render body and of a `RenderMaterial`; empty where nothing renders.
        scene, sdf: the settings of a scene's system, and those by which distance fields are cooked.
        timestep: of a scene [s].
    """

    material: Any
    friction: Expected
    shape: Expected
    plane: Expected
    pose: Expected
    dynamic: Expected
    kinematic: Expected
    link: Expected
    joint: Expected
    articulation: Expected
    look: Expected
    paint: Expected
    scene: Expected
    sdf: Expected
    timestep: float = TIMESTEP

    def asked(self, physics: Physics) -> Defaults:
        """These where the plan's settings say nothing, and what they say where they do."""
        friction = self.friction if physics.default_material is None else frictions(physics.default_material)
        return replace(
            self,
            friction=friction,
            shape=_overlaid(self.shape, physics),
            plane=_overlaid(self.plane, physics),
            dynamic=_overlaid(self.dynamic, physics),
            kinematic=_overlaid(self.kinematic, physics),
            articulation=_overlaid(self.articulation, physics),
            scene=_overlaid(self.scene, physics),
            sdf=self.sdf if physics.sdf is None else _overlaid(self.sdf, physics.sdf),
            timestep=self.timestep if physics.timestep is None else single(physics.timestep),
        )


def present_defaults(*, rendered: bool) -> Defaults:
    """Reads them off objects that nothing else has touched, under the settings that the process has now."""
    material = physx.get_default_material()
    fresh = physx.PhysxCollisionShapeSphere(1.0, material)
    shape = _table(SHAPE_KNOBS, fresh) | _read(fresh, [GROUPS.get])
    body = _table(BODY_KNOBS, physx.PhysxRigidDynamicComponent())
    link, joint, articulation = _articulation()
    scene, sdf = physx.get_scene_config(), physx.get_sdf_config()
    return Defaults(
        material=material,
        friction=_read(material, PHYSICAL),
        shape=shape,
        plane=shape | {"density": 0.0},
        pose={"local_pose": pose_state(fresh.local_pose)},
        dynamic=body | {"kinematic": False},
        kinematic=body | {"kinematic": True},
        link=link,
        joint=joint,
        articulation=articulation,
        look=_table(RENDER_KNOBS, render.RenderBodyComponent()) if rendered else {},
        paint=_read(render.RenderMaterial(), PAINT) if rendered else {},
        scene=_read(scene, settings_of(scene)),
        sdf=_read(sdf, settings_of(sdf)),
    )


def _articulation() -> tuple[Expected, Expected, Expected]:
    """Of links, of joints and of a whole, off two links, one of which hangs on the other."""
    links = [physx.PhysxArticulationLinkComponent(None)]
    links.append(physx.PhysxArticulationLinkComponent(links[0]))
    entities = [sapien.Entity() for _ in links]
    for entity, link in zip(entities, links, strict=True):
        entity.add_component(link)
    joint = links[1].get_joint()
    joint.set_type("revolute")
    articulation = links[0].get_articulation()
    return _read(links[0], LINK_FIELDS), _table(JOINT_KNOBS, joint), _table(ARTICULATION_KNOBS, articulation)


def frictions(material: Friction) -> Expected:
    """What the engine must hold of a material of the plan."""
    return {name: single(getattr(material, name)) for name in PHYSICAL}


def settings_of(config: object) -> list[str]:
    """The names of everything that can be read of one of SAPIEN's configuration objects."""
    return [name for name, kind in vars(type(config)).items() if isinstance(kind, property)]


def _overlaid(present: Expected, asked: object) -> Expected:
    found = {name: getattr(asked, _PLAN_NAMES.get(name, name), None) for name in present}
    return present | {
        name: single(value) if isinstance(value, float) else value for name, value in found.items() if value is not None
    }


def _table(knobs: Knobs, engine: object) -> Expected:
    return _read(engine, [knob.get for knob in knobs.by_field.values()])


def _read(engine: object, names: Iterable[str]) -> Expected:
    return {name: getattr(engine, name) for name in names}
