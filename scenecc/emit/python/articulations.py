"""Writes an articulation: its links, joints, drives, initial state and the tendons of mimic joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.output import optional_fields
from scenecc.emit.python.bodies import (
    BODY_PROPERTIES,
    BodyScript,
    needs_components,
    write_body_component,
    write_late_fields,
    write_mass,
    write_render_component,
    write_render_properties,
    write_shapes,
)
from scenecc.emit.python.context import (
    MountTargets,
    frame_expression,
    numbers_literal,
    pose_call,
    present_fields,
    write_properties,
)
from scenecc.emit.python.source import Group, SourceNode, SourceWriter, call, list_of, string
from scenecc.plan import ArticulationStructure, constant
from scenecc.plan.articulation import (
    VELOCITY_FIELDS,
    breadth_first_order,
    friction_force,
    tendon_coefficients,
    tendon_links,
    tendon_pull,
)
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.emit.python.context import SceneValues, ScriptContext
    from scenecc.plan import BodyStructure, Entity, Joint, Link


def needs_soft_tendons(structure: BodyStructure | ArticulationStructure) -> bool:
    """Whether a tendon depends on the masses of the links."""
    return isinstance(structure, ArticulationStructure) and bool(structure.mimics)


def write_tendons(source: SourceWriter, structure: ArticulationStructure, columns: SceneValues) -> None:
    """Writes one tendon call per mimic joint, on `articulation` and its `links`."""
    for mimic in structure.mimics:
        over = tendon_links(structure, mimic)
        pairs = np.stack([columns.of_rows(mimic.multiplier), columns.of_rows(mimic.offset)], axis=1)
        pulls = [tendon_pull(*pair) for pair in pairs.tolist()]
        coefficients = np.array([tendon_coefficients(structure, mimic, over, ends) for ends in pulls])
        shares = columns.of_block(coefficients, "coefficients", numbers_literal)
        rest = columns.of_block(np.array([ends.rest_length for ends in pulls]), "rest_length", numbers_literal)
        source.comment(f"{mimic.joint} follows {mimic.source}: SAPIEN's own mimic joints pull with wrong forces.")
        source.statement(shares, assign="coefficients")
        path, temporal = list_of([str(index) for index in over]), "physx.get_scene_config().enable_tgs"
        soft = call("soft_tendon", "links", path, "coefficients", "scene.timestep", temporal=temporal)
        source.statement(soft, assign="shares, stiffness")
        source.statement(
            call(
                "articulation.create_fixed_tendon",
                list_of([f"links[{index}]" for index in over]),
                "coefficients",
                "shares",
                rest_length=rest,
                stiffness="stiffness",
            )
        )


_DRIVE_FIELDS = tuple(name for name in (*property_fields("drive"), "drive_mode") if name != "damping")
"""Drive fields that a link builder does not take. It only takes the damping."""

_NO_LIMITS = constant([-np.inf, np.inf])


def write_joint_properties(source: SourceWriter, joint: Joint, columns: SceneValues, builder: str) -> None:
    """Writes the joint properties that a link builder takes."""
    if joint.name:
        source.statement(call(f"{builder}.set_joint_name", string(joint.name)))
    only_damping = joint.damping is not None and not present_fields(joint, _DRIVE_FIELDS)
    damping = {"damping": columns.value(joint.damping, "damping")} if only_damping and joint.damping is not None else {}
    limits: SourceNode = "[]" if joint.type == "fixed" else columns.value(joint.limits or _NO_LIMITS, "limits")
    properties = call(
        f"{builder}.set_joint_properties",
        type=string(joint.type),
        limits=limits,
        pose_in_parent=frame_expression(joint.pose_in_parent, "pose_in_parent", columns),
        pose_in_child=frame_expression(joint.pose_in_child, "pose_in_child", columns),
        **damping,
    )
    source.statement(properties)


def write_joint_component(source: SourceWriter, joint: Joint, columns: SceneValues) -> None:
    """Writes the same properties to the joint of `body`."""
    source.line("joint = body.joint")
    if joint.name:
        source.statement(string(joint.name), assign="joint.name")
    source.statement(string(joint.type), assign="joint.type")
    for name in ("pose_in_child", "pose_in_parent"):
        # Also if the plan has none, as the builder does: shapes have moved the frames by a rounding error.
        source.statement(frame_expression(getattr(joint, name), name, columns), assign=f"joint.{name}")
    if joint.type == "fixed":
        return
    source.statement(columns.value(joint.limits or _NO_LIMITS, "limits"), assign="joint.limit")
    if not present_fields(joint, _DRIVE_FIELDS):
        # The builder does so for every joint.
        source.statement(_drive_call(joint, columns))


def write_articulation_joints(source: SourceWriter, structure: ArticulationStructure, columns: SceneValues) -> None:
    """Writes the joint properties of `articulation` that no builder takes."""
    for link, joint in _active_joints(structure):
        inner = SourceWriter(depth=source.depth)
        if friction_force(joint) is not None:
            inner.comment("Friction that does not depend on the load: a drive that brakes with its force limit.")
        if present_fields(joint, _DRIVE_FIELDS):
            inner.statement(_drive_call(joint, columns))
        write_properties(inner, joint, property_fields("joint"), columns, "joint")
        if not inner.is_empty:
            source.line(f"joint = {_joint_expression(link, joint)}")
            source.append(inner)


def _active_joints(structure: ArticulationStructure) -> list[tuple[Link, Joint]]:
    """Returns the active joints, with their links."""
    return [(link, link.joint) for link in structure.links if link.joint is not None and link.joint.type != "fixed"]


def _joint_expression(link: Link, joint: Joint) -> str:
    """Returns an expression that finds a joint by its name, or by its link if it has none."""
    if joint.name:
        return f"articulation.find_joint_by_name({string(joint.name)})"
    return f"articulation.find_link_by_name({string(link.name)}).joint"


def _drive_call(joint: Joint, columns: SceneValues) -> SourceNode:
    arguments: dict[str, SourceNode] = {
        name: "0" if value is None else columns.value(value, name)
        for name, value in (("stiffness", joint.stiffness), ("damping", joint.damping))
    }
    if joint.force_limit is not None:
        arguments["force_limit"] = columns.value(joint.force_limit, "force_limit")
    if joint.drive_mode is not None:
        arguments["mode"] = string(joint.drive_mode)
    return call("joint.set_drive_properties", **arguments)


def engine_order(structure: ArticulationStructure) -> list[Link]:
    """Returns the links with active joints, in the order of SAPIEN's `active_joints`: breadth first."""
    links = [structure.links[number] for number in breadth_first_order(link.parent for link in structure.links)]
    return [link for link in links if link.joint is not None and link.joint.type != "fixed"]


def write_positions(source: SourceWriter, structure: ArticulationStructure, columns: SceneValues) -> None:
    """Writes initial joint positions and velocities, and drive targets."""
    joints = [link.joint for link in engine_order(structure) if link.joint is not None]
    if not joints:
        # SAPIEN places the entities of links other than the root only when the root pose or `qpos` is set.
        source.line("articulation.root_pose = articulation.root_pose")
        return
    for name in ("qpos", "qvel"):
        if name == "qpos" or any(joint.qvel is not None for joint in joints):
            values = columns.of_block(_stack_joint_values(joints, name, columns), name, numbers_literal)
            source.statement(values, assign=f"articulation.{name}")
    for link, joint in _active_joints(structure):
        targets = present_fields(joint, ("drive_target", "drive_velocity_target"))
        if targets:
            source.line(f"joint = {_joint_expression(link, joint)}")
        for name in targets:
            source.statement(call(f"joint.set_{name}", columns.value(getattr(joint, name), name)))


def _stack_joint_values(joints: list[Joint], name: str, columns: SceneValues) -> NDArray[Any]:
    """Returns the values of a field of all joints, (B, dof); 0 for None."""
    values = [getattr(joint, name) for joint in joints]
    nothing = np.zeros(len(columns.rows))
    return np.stack([nothing if value is None else columns.of_rows(value) for value in values], axis=1)


_LINK_COMPONENT = "physx.PhysxArticulationLinkComponent"

ARTICULATION_PROPERTIES = optional_fields(ArticulationStructure, "file", *VELOCITY_FIELDS)
"""Properties of an articulation, by their names in the plan."""


@dataclass(frozen=True, slots=True)
class ArticulationScript:
    """One structure of an articulation in some of its scenes.

    Attributes:
        name: an expression for the entity's name.
        source: receives the statements; the loop over scenes, if any, is open.
        columns: the entity's quantities in these scenes.
        mounted_links: names of links that are mount targets.
    """

    entity: Entity
    name: str
    structure: ArticulationStructure
    source: SourceWriter
    columns: SceneValues
    tables: ScriptContext
    mounted_links: Sequence[str] = ()

    def body(self, link: Link) -> BodyScript:
        """Returns a link as a body."""
        files, materials = self.tables.files, self.tables.materials
        return BodyScript(self.entity, string(link.name), link.body, self.source, self.columns, files, materials)


def write_articulation(robot: ArticulationScript) -> None:
    """Builds the articulation in `scene`, row `i` of the block."""
    source, columns, structure = robot.source, robot.columns, robot.structure
    robot.tables.materials.write_own(source, structure.bodies, columns, robot.tables.files)
    if any(map(needs_components, structure.bodies)):
        _write_components(robot)
    else:
        _write_builder(robot)
    source.statement(robot.name, assign="articulation.name")
    if not needs_soft_tendons(structure):
        _write_properties(robot)
    for name in present_fields(structure, VELOCITY_FIELDS):
        source.statement(columns.value(getattr(structure, name), name), assign=f"articulation.root_{name}")
    write_positions(source, structure, columns)
    for link in robot.mounted_links:
        found = Group("articulation.find_link_by_name(", (string(link),), ").entity")
        MountTargets.write_link(source, robot.name, link, found)


def _write_properties(robot: ArticulationScript) -> None:
    """Writes the properties of links, articulation and joints that no builder takes."""
    if not any(map(needs_components, robot.structure.bodies)):
        _write_link_properties(robot)
    write_properties(robot.source, robot.structure, ARTICULATION_PROPERTIES, robot.columns, "articulation")
    write_articulation_joints(robot.source, robot.structure, robot.columns)


def _write_builder(robot: ArticulationScript) -> None:
    source, columns, structure = robot.source, robot.columns, robot.structure
    source.line("builder = scene.create_articulation_builder()")
    source.statement(columns.value(robot.entity.pose, "pose", pose_call), assign="builder.initial_pose")
    variables = [robot.tables.names.local(link.name) for link in structure.links]
    for link, variable in zip(structure.links, variables, strict=True):
        parent = () if link.parent is None else (variables[link.parent],)
        source.statement(call("builder.create_link_builder", *parent), assign=variable)
        source.statement(call(f"{variable}.set_name", string(link.name)))
        if link.joint is not None:
            write_joint_properties(source, link.joint, columns, variable)
        write_shapes(robot.body(link), variable)
    fixed = {"fix_root_link": "True"} if structure.fix_root_link else {}
    if not structure.mimics:
        source.statement(call("builder.build", **fixed), assign="articulation")
        return
    source.statement(call("builder.build_entities", **fixed), assign="entities")
    source.line(f"component = {_LINK_COMPONENT}")
    source.line("links = [entity.find_component_by_type(component) for entity in entities]")
    _add_to_scene(robot)


def _add_to_scene(robot: ArticulationScript) -> None:
    """Adds `entities` and their `links` to the scene, after the tendons: SAPIEN rejects tendons later."""
    robot.source.line("articulation = links[0].articulation")
    if needs_soft_tendons(robot.structure):
        _write_properties(robot)
    write_tendons(robot.source, robot.structure, robot.columns)
    with robot.source.block("for entity in entities:"):
        robot.source.line("scene.add_entity(entity)")


def _write_components(robot: ArticulationScript) -> None:
    source, columns, structure = robot.source, robot.columns, robot.structure
    source.line("entities, links = [], []")
    for link in structure.links:
        body = robot.body(link)
        source.line("entity = sapien.Entity()")
        source.line(f"body = {_LINK_COMPONENT}({'' if link.parent is None else f'links[{link.parent}]'})")
        source.statement(string(link.name), assign="body.name")
        write_body_component(body)
        write_render_component(body)
        source.statement(string(link.name), assign="entity.name")
        if link.joint is not None:
            write_joint_component(source, link.joint, columns)
        source.line("entities.append(entity)")
        source.line("links.append(body)")
    if structure.fix_root_link:
        source.line('links[0].joint.type = "fixed"')
    source.statement(columns.value(robot.entity.pose, "pose", pose_call), assign="entities[0].pose")
    _add_to_scene(robot)


def _write_link_properties(robot: ArticulationScript) -> None:
    """Writes the link properties that a link builder does not take."""
    for link in robot.structure.links:
        inner, body = SourceWriter(depth=robot.source.depth), link.body
        write_mass(inner, body, robot.columns)
        write_late_fields(inner, body.collisions, robot.columns)
        write_properties(inner, body, BODY_PROPERTIES, robot.columns, "body")
        write_render_properties(replace(robot.body(link), source=inner), "body.entity")
        if not inner.is_empty:
            robot.source.line(f"body = articulation.find_link_by_name({string(link.name)})")
            robot.source.append(inner)
