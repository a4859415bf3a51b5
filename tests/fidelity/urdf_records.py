"""What SAPIEN's `URDFLoader` records in its builders, beside what the reader describes. Nothing is built."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import sapien
from sapien.wrapper import actor_builder, urdf_loader
from sapien.wrapper.actor_builder import ActorBuilder
from sapien.wrapper.articulation_builder import ArticulationBuilder

from scenecc.robots.description import (
    DescribedCollision,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
    MeshGeometry,
    SolidGeometry,
)

if TYPE_CHECKING:
    from pathlib import Path

    import pytest


class _Scene:
    """As much of a scene as the loader asks."""

    create_articulation_builder = staticmethod(ArticulationBuilder)
    create_actor_builder = staticmethod(ActorBuilder)


@dataclass
class _Material:
    """In place of a render material, which wants a renderer."""

    base_color: Any = None
    diffuse_texture: str | None = None


class Loader:
    """SAPIEN's loader without a scene and a renderer."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        patch.setattr(urdf_loader, "RenderMaterial", _Material)
        patch.setattr(urdf_loader, "RenderTexture2D", str)
        # The builder's own, where the loader gives none.
        patch.setattr(actor_builder.sapien.render, "RenderMaterial", object)

    def parse(
        self, file: Path, scale: float = 1.0, *, collision_is_visual: bool = False
    ) -> tuple[list[Any], list[Any]]:
        """Its builders of articulations and of actors."""
        loader = urdf_loader.URDFLoader()
        loader.scale = scale
        loader.collision_is_visual = collision_is_visual
        loader.set_scene(_Scene())
        articulations, actors, _ = loader.parse(str(file))
        return articulations, actors


def robot_facts(robot: DescribedRobot) -> dict[str, Any]:
    """Everything that a description says of a robot which the loader records too."""
    return {
        "links": [_link_facts(link, is_root=link.parent is None) for link in robot.links],
        "mimics": [
            (joint.name, joint.mimic.source, joint.mimic.multiplier, joint.mimic.offset)
            for link in robot.links
            if (joint := link.joint) is not None and joint.mimic is not None
        ],
        "pose": _bits(robot.pose),
    }


def articulation_facts(builder: Any, *, fixed: bool) -> dict[str, Any]:
    """The same of a builder of articulations."""
    root = builder.link_builders[0].joint_record
    assert root.joint_type == ("fixed" if fixed else "undefined")
    return {
        "links": [_builder_facts(link) for link in builder.link_builders],
        "mimics": [(m.joint, m.mimic, m.multiplier, m.offset) for m in builder.mimic_joint_records],
        "pose": _pose_bits(builder.initial_pose),
    }


def actor_facts(builder: Any) -> dict[str, Any]:
    """The same of a builder of actors."""
    return {
        "links": [{**_shape_facts(builder), "name": builder.name, "parent": None, "joint": None}],
        "mimics": [],
        "pose": _pose_bits(builder.initial_pose),
    }


def _builder_facts(link: Any) -> dict[str, Any]:
    parent = None if link.parent is None else link.parent.index
    record = link.joint_record
    joint = None
    if parent is not None:
        joint = (
            record.name,
            record.joint_type,
            _pose_bits(record.pose_in_parent),
            _pose_bits(record.pose_in_child),
            tuple(_double(x) for x in np.array(record.limits, float).flatten()),
            record.friction or 0,
            record.damping or 0,
        )
    return {**_shape_facts(link), "name": link.name, "parent": parent, "joint": joint}


def _shape_facts(builder: Any) -> dict[str, Any]:
    inertial = None
    if not builder._auto_inertial:
        inertial = (
            _double(builder._mass),
            _pose_bits(builder._cmass_local_pose),
            tuple(_double(x) for x in builder._inertia),
        )
    return {
        "collisions": [_record_facts(record) for record in builder.collision_records],
        "visuals": [(*_record_facts(r), r.name, _material_facts(r.material)) for r in builder.visual_records],
        "inertial": inertial,
        "groups": tuple(builder.collision_groups),
    }


_SIZES = {
    "box": lambda r: r.scale,
    "sphere": lambda r: [r.radius],
    "capsule": lambda r: [r.radius, r.length],
    "cylinder": lambda r: [r.radius, r.length],
    "convex_mesh": lambda r: r.scale,
    "file": lambda r: r.scale,
}


def _record_facts(record: Any) -> tuple[Any, ...]:
    kind = "mesh" if record.type in {"convex_mesh", "file"} else record.type
    sizes = tuple(_double(x) for x in _SIZES[record.type](record))
    return kind, record.filename and os.path.normpath(record.filename), sizes, _pose_bits(record.pose)


def _material_facts(material: Any) -> Any:
    if not isinstance(material, _Material):
        return None
    color = None if material.base_color is None else tuple(float(x) for x in material.base_color)
    return color, material.diffuse_texture


def _link_facts(link: DescribedLink, *, is_root: bool) -> dict[str, Any]:
    inertial = link.inertial
    return {
        "collisions": [_shape(shape) for shape in link.collisions],
        "visuals": [(*_shape(shape), shape.name, _look(shape)) for shape in link.visuals],
        "inertial": None
        if inertial is None
        else (_double(inertial.mass), _bits(inertial.com), tuple(_double(x) for x in (inertial.inertia or ()))),
        "groups": (1, 1, link.ignore_bits, 0),
        "name": link.name,
        "parent": link.parent,
        "joint": None if is_root or link.joint is None else _joint(link.joint),
    }


def _joint(joint: DescribedJoint) -> tuple[Any, ...]:
    return (
        joint.name,
        joint.type,
        _bits(joint.pose_in_parent),
        _bits(joint.pose_in_child),
        tuple(_double(x) for x in joint.limits or ()),
        joint.friction_force or 0,  # the loader takes the force for a ratio
        joint.damping,
    )


def _shape(shape: DescribedCollision | DescribedVisual) -> tuple[Any, ...]:
    match shape.geometry:
        case SolidGeometry(kind=kind, sizes=sizes):
            file = ""
        case MeshGeometry(path=path, scale=sizes):
            kind, file = "mesh", str(path)
        case other:
            raise AssertionError(other)
    return kind, file, tuple(_double(x) for x in sizes), _bits(shape.pose)


def _look(shape: DescribedVisual) -> Any:
    if shape.look is None:
        return None
    return shape.look.base_color, None if (image := shape.look.base_color_texture) is None else str(image.path)


def _pose_bits(pose: sapien.Pose) -> tuple[int, ...]:
    return _bits((*pose.p, *pose.q))


def _bits(values: Any) -> tuple[int, ...]:
    return tuple(np.asarray(values, np.float32).view(np.uint32).tolist())


def _double(value: float) -> int:
    """The bits of a double."""
    return int(np.float64(value).view(np.uint64))
