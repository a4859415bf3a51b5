"""One articulation of a plan as statements: `ArticulationBuilder` where it can, the links themselves where it cannot.

In SAPIEN's order: links with their shapes and joints, tendons, the entities into the scene; then what no builder is
told, of links, of the whole, of joints; where the joints are and move to, the root's velocity, targets of drives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from scenecc.emit.python.alike import Among, Unit, write_alike
from scenecc.emit.python.bodies import (
    Body,
    needs_components,
    write_body_component,
    write_look,
    write_look_component,
    write_shapes,
)
from scenecc.emit.python.columns import pose
from scenecc.emit.python.held import Held
from scenecc.emit.python.joints import write_joint_component, write_joint_properties, write_joints, write_positions
from scenecc.emit.python.knobs import (
    BODY_KNOBS,
    LOOK_KNOBS,
    OFFSETS,
    given,
    write_body_knob,
    write_mass,
    write_offsets,
)
from scenecc.emit.python.layout import call, string
from scenecc.emit.python.tendons import write_tendons

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.layout import Source
    from scenecc.emit.python.tables import Tables
    from scenecc.plan import ArticulationStructure, Entity, Link

_LINK = "physx.PhysxArticulationLinkComponent"
WHOLE_KNOBS = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")
"""Properties of an articulation by the plan's names."""

ROOT_KNOBS = ("linear_velocity", "angular_velocity")
"""Properties of its root, which SAPIEN calls `root_…`."""


@dataclass(frozen=True, slots=True)
class Robot:
    """One structure of an articulation in some of its scenes.

    Attributes:
        name: an expression for the entity's.
        source: where statements go; the loop over scenes, if any, is open.
        columns: the entity's quantities in these scenes.
        held: names of links that something holds on to.
    """

    entity: Entity
    name: str
    structure: ArticulationStructure
    source: Source
    columns: Columns
    tables: Tables
    held: Sequence[str] = ()

    def body(self, link: Link) -> Body:
        """A link as a body."""
        files, materials = self.tables.files, self.tables.materials
        return Body(self.entity, string(link.name), link.body, self.source, self.columns, files, materials)


def write_articulation(robot: Robot) -> None:
    """Builds the articulation in `scene`, row `i` of the block."""
    source, columns, structure = robot.source, robot.columns, robot.structure
    robot.tables.materials.write_own(source, structure.bodies, columns, robot.tables.files)
    if any(map(needs_components, structure.bodies)):
        _write_components(robot)
    else:
        _write_builder(robot)
    source.statement(robot.name, assign="articulation.name")
    if not any(map(needs_components, structure.bodies)):
        _write_link_knobs(robot)
    for name in given(structure, WHOLE_KNOBS):
        source.statement(columns.value(getattr(structure, name), name), assign=f"articulation.{name}")
    write_joints(source, structure, columns)
    for name in given(structure, ROOT_KNOBS):
        source.statement(columns.value(getattr(structure, name), name), assign=f"articulation.root_{name}")
    write_positions(source, structure, columns)
    for link in robot.held:
        Held.write_link(source, robot.name, link, f"articulation.find_link_by_name({string(link)}).entity")


def _write_builder(robot: Robot) -> None:
    source, columns, structure = robot.source, robot.columns, robot.structure
    source.line("builder = scene.create_articulation_builder()")
    source.statement(columns.value(robot.entity.pose, "pose", pose), assign="builder.initial_pose")
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
    source.line(f"component = {_LINK}")
    source.line("links = [entity.find_component_by_type(component) for entity in entities]")
    _write_into_scene(robot)


def _write_into_scene(robot: Robot) -> None:
    """From `entities` and their `links`, of which SAPIEN takes tendons only ahead of the scene."""
    robot.source.line("articulation = links[0].articulation")
    write_tendons(robot.source, robot.structure, robot.columns)
    with robot.source.block("for entity in entities:"):
        robot.source.line("scene.add_entity(entity)")


def _write_components(robot: Robot) -> None:
    source, columns, structure = robot.source, robot.columns, robot.structure
    source.line("entities, links = [], []")
    for link in structure.links:
        body = robot.body(link)
        source.line("entity = sapien.Entity()")
        source.line(f"body = {_LINK}({'' if link.parent is None else f'links[{link.parent}]'})")
        source.statement(string(link.name), assign="body.name")
        write_body_component(body)
        write_look_component(body)
        source.statement(string(link.name), assign="entity.name")
        if link.joint is not None:
            write_joint_component(source, link.joint, columns)
        source.line("entities.append(entity)")
        source.line("links.append(body)")
    if structure.fix_root_link:
        source.line('links[0].joint.type = "fixed"')
    source.statement(columns.value(robot.entity.pose, "pose", pose), assign="entities[0].pose")
    _write_into_scene(robot)


def _write_link_knobs(robot: Robot) -> None:
    """What the builder of a link is not told."""
    links = robot.structure.links
    named = "articulation.find_link_by_name"
    among: Among[Link] = Among("body", "articulation.links", named, lambda link: link.name, len(links))
    write_alike(robot.source, [(link, _units(robot, link)) for link in links], among)


def _units(robot: Robot, link: Link) -> list[Unit]:
    body, columns = link.body, robot.columns
    units: list[Unit] = []
    if body.mass is not None:
        units.append(lambda source: write_mass(source, body, columns))
    if any(given(shape, OFFSETS) for shape in body.collisions):
        units.append(lambda source: write_offsets(source, body.collisions, columns))
    units += [partial(write_body_knob, structure=body, name=name, columns=columns) for name in given(body, BODY_KNOBS)]
    if given(body, LOOK_KNOBS):
        units.append(lambda source: write_look(replace(robot.body(link), source=source), "body.entity"))
    return units
