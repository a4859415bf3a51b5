"""What ManiSkill's MJCF loader gives its builders, and what our description says, in the same words."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import sapien
from sapien.wrapper import actor_builder
from sapien.wrapper.articulation_builder import ArticulationBuilder

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.robots.description import (
    DescribedCollision,
    DescribedLink,
    DescribedMaterial,
    DescribedVisual,
    Geometry,
    MeshGeometry,
    RobotDescription,
    SolidGeometry,
)
from scenecc.robots.maniskill_mjcf import read_mjcf
from scenecc.source.paths import AssetScope, ResolvedFile


def read(path: Path, *, root: Path | None = None) -> tuple[RobotDescription | None, list[Diagnostic]]:
    """A file's description and what was told of it. `root`: of what may be read; None: the file's folder."""
    sink = Sink()
    found = read_mjcf(ResolvedFile(path, path.name), scope=AssetScope(root or path.parent), sink=sink)
    return found, sink.diagnostics()


class _Look:
    """Stands for SAPIEN's render material, which asks for a device."""

    def __init__(self, **given: Any) -> None:
        self.given = given
        self.base_color_texture: Any = None


@dataclass
class _Texture:
    filename: str


class _Scene:
    """Makes SAPIEN's own builders, which ManiSkill's only add names to."""

    def create_articulation_builder(self) -> Any:
        return ArticulationBuilder()

    def create_actor_builder(self) -> Any:
        return sapien.ActorBuilder()


def loaded(path: Path, monkeypatch: Any) -> tuple[list[Any], list[Any]]:
    """The articulation and actor builders of ManiSkill's loader."""
    from mani_skill.utils.building import _mjcf_loader as module

    monkeypatch.setattr(module, "RenderMaterial", _Look)
    monkeypatch.setattr(module, "RenderTexture2D", _Texture)
    monkeypatch.setattr(actor_builder.sapien.render, "RenderMaterial", _Look)
    monkeypatch.setattr(module, "DEFAULT_MJCF_OPTIONS", {"contact": True})
    loader = module.MJCFLoader()
    loader.set_scene(_Scene())
    with warnings.catch_warnings():
        # It warns by a method that Python deprecates, and reads numbers by a function that NumPy does.
        warnings.simplefilter("ignore", DeprecationWarning)
        articulations, actors, _ = loader.parse(str(path))
    return articulations, actors


def single(values: Any) -> tuple[float, ...]:
    """Numbers as the engine holds them, in a tuple that compares to the bit."""
    return tuple(float(value) for value in np.asarray(values, np.float64).astype(np.float32).flatten())


def pose(one: Any) -> tuple[float, ...]:
    return (*single(one.p), *single(one.q))


def their_shape(record: Any) -> tuple[Any, ...]:
    numbers: dict[str, Any] = {
        "box": lambda: single(record.scale),
        "sphere": lambda: single([record.radius]),
        "capsule": lambda: single([record.radius, record.length]),
        "cylinder": lambda: single([record.radius, record.length]),
    }
    kind = record.type
    if kind in numbers:
        return kind, *numbers[kind]()
    assert kind in {"convex_mesh", "file"}
    return "mesh", str(Path(record.filename).resolve()), *single(record.scale)


def our_shape(geometry: Geometry) -> tuple[Any, ...]:
    match geometry:
        case SolidGeometry(kind, sizes):
            return kind, *single(sizes)
        case MeshGeometry():
            return "mesh", str(geometry.path.resolve()), *single(geometry.scale)
        case _:
            raise AssertionError(geometry)


def their_look(look: _Look) -> dict[str, Any]:
    found: dict[str, Any] = {key: single(value) for key, value in look.given.items()}
    if look.base_color_texture is not None:
        found["texture"] = str(Path(look.base_color_texture.filename).resolve())
    return found


def our_look(look: DescribedMaterial | None) -> dict[str, Any]:
    assert look is not None
    names = ("base_color", "emission", "specular", "roughness", "metallic")
    found: dict[str, Any] = {name: single(getattr(look, name)) for name in names if getattr(look, name) is not None}
    if look.texture is not None:
        found["texture"] = str(look.texture.resolve())
    return found


def their_collision(record: Any) -> tuple[Any, ...]:
    material = record.material
    rubbing = single([material.static_friction, material.dynamic_friction, material.restitution])
    return their_shape(record), pose(record.pose), rubbing, single([record.density])


def our_collision(made: DescribedCollision) -> tuple[Any, ...]:
    # Where nothing is said, the builder takes the default material.
    default = sapien.physx.get_default_material()
    said = made.friction or (default.static_friction, default.dynamic_friction, default.restitution)
    rubbing = single(said)
    return our_shape(made.geometry), single(made.pose), rubbing, single([made.density])


def their_visual(record: Any) -> tuple[Any, ...]:
    return their_shape(record), pose(record.pose), record.name, their_look(record.material)


def our_visual(made: DescribedVisual) -> tuple[Any, ...]:
    return our_shape(made.geometry), single(made.pose), made.name, our_look(made.look)


def their_joint(record: Any) -> dict[str, Any]:
    moving = record.joint_type not in {"fixed", "undefined"}
    return {
        "name": record.name,
        "type": record.joint_type,
        "in_parent": pose(record.pose_in_parent),
        "in_child": pose(record.pose_in_child),
        "limits": single(record.limits) if moving else None,
        "friction": single([record.friction]) if moving else None,
        "damping": single([record.damping]) if moving else None,
    }


def their_links(builder: Any) -> list[dict[str, Any]]:
    return [
        {
            "name": link.name,
            "parent": None if link.parent is None else link.parent.index,
            "joint": None if link.parent is None else their_joint(link.joint_record),
            "bits": link.collision_groups[2],
            "collisions": [their_collision(record) for record in link.collision_records],
            "visuals": [their_visual(record) for record in link.visual_records],
        }
        for link in builder.link_builders
    ]


def our_joint(link: DescribedLink) -> dict[str, Any] | None:
    joint = link.joint
    if joint is None:
        return None
    return {
        "name": joint.name,
        "type": joint.type,
        "in_parent": single(joint.pose_in_parent),
        "in_child": single(joint.pose_in_child),
        "limits": None if joint.limits is None else single(joint.limits),
        "friction": single([joint.friction or 0.0]) if joint.limits else joint.friction,
        "damping": single([joint.damping]) if joint.limits else (None if joint.damping == 0 else joint.damping),
    }


def our_link(link: DescribedLink) -> dict[str, Any]:
    return {
        "name": link.name,
        "parent": link.parent,
        "joint": our_joint(link),
        "bits": link.ignore_bits,
        "collisions": [our_collision(made) for made in link.collisions],
        "visuals": [our_visual(made) for made in link.visuals],
    }


def their_body(builder: Any) -> dict[str, Any]:
    return {
        "type": builder.physx_body_type,
        "bits": builder.collision_groups[2],
        "collisions": [their_collision(record) for record in builder.collision_records],
        "visuals": [their_visual(record) for record in builder.visual_records],
    }


def our_body(link: DescribedLink, body_type: str | None) -> dict[str, Any]:
    whole = our_link(link)
    return {"type": body_type, "bits": whole["bits"], "collisions": whole["collisions"], "visuals": whole["visuals"]}


def assert_equal(ours: Any, theirs: Any, where: str = "") -> None:
    """Asserts that plain data are equal, and says where they are not."""
    if isinstance(ours, dict) and isinstance(theirs, dict) and ours.keys() == theirs.keys():
        for key in ours:
            assert_equal(ours[key], theirs[key], f"{where}.{key}")
    elif isinstance(ours, list) and isinstance(theirs, list) and len(ours) == len(theirs):
        for number, (one, other) in enumerate(zip(ours, theirs, strict=True)):
            assert_equal(one, other, f"{where}[{number}]")
    else:
        assert ours == theirs, f"{where}: {ours} is not {theirs}"


def assert_same(path: Path, monkeypatch: Any, *, root: Path | None = None) -> RobotDescription:
    """Asserts that a file's description says what ManiSkill's loader builds, to the bit, and nothing else."""
    description, told = read(path, root=root)
    assert description is not None, [str(one) for one in told]
    articulations, actors = loaded(path, monkeypatch)
    ours = [robot for robot in description.robots if robot.body_type is None]
    assert len(ours) == len(articulations)
    for robot, builder in zip(ours, articulations, strict=True):
        assert_equal([our_link(link) for link in robot.links], their_links(builder))
        assert robot.fixed == (builder.link_builders[0].joint_record.joint_type == "fixed")
        assert robot.pose == (0, 0, 0, 1, 0, 0, 0)
    # The loader makes empty bodies of the planes that it does not build; a scene may not hold any.
    filled = [actor for actor in actors if actor.collision_records or actor.visual_records]
    bodies = [robot for robot in description.robots if robot.body_type is not None]
    assert_equal([our_body(one.links[0], one.body_type) for one in bodies], [their_body(actor) for actor in filled])
    assert all(robot.pose == (0, 0, 0, 1, 0, 0, 0) for robot in bodies)
    return description
