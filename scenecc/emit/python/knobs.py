"""Knobs that `ActorBuilder` lacks, set on a body's components once they are there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.columns import Columns, number, numbers, pose
from scenecc.emit.python.layout import Node, Source, call
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from scenecc.plan import BodyStructure, CollisionShape, Inertial

BODY_KNOBS = property_fields("body")
"""Properties of a dynamic component by the plan's names."""

LOOK_KNOBS = property_fields("look")
"""Properties of a render component by the plan's names."""

OFFSETS = ("contact_offset", "rest_offset")
"""Properties of a collision shape that no `add_*_collision` takes."""

ARGUMENTS = tuple(name for name in property_fields("shape") if name not in OFFSETS)
"""Properties of a collision shape that all of them take."""


def given(holder: object, names: tuple[str, ...]) -> list[str]:
    """The names of the fields that the plan gives."""
    return [name for name in names if getattr(holder, name) is not None]


def write_body_knobs(source: Source, structure: BodyStructure, columns: Columns) -> None:
    """Assignments to `body`."""
    for name in given(structure, BODY_KNOBS):
        write_body_knob(source, structure, name, columns)


def write_body_knob(source: Source, structure: BodyStructure, name: str, columns: Columns) -> None:
    """One of them, which is given."""
    node = columns.value(getattr(structure, name), name)
    if name == "locked_motion_axes":
        source.statement(call("body.set_locked_motion_axes", node))
    else:
        source.statement(node, assign=f"body.{name}")


def write_mass(source: Source, structure: BodyStructure, columns: Columns) -> None:
    """The mass that is given in place of what follows from the densities, to `body`."""
    if structure.mass is not None:
        mass = columns.value(structure.mass, "mass", lambda row: number(float(row)))
        source.line(f"body.inertia = body.inertia.astype(float) * ({mass} / body.mass)")
        source.line(f"body.mass = {mass}")


def inertial_nodes(inertial: Inertial, columns: Columns) -> tuple[Node, Node, Node]:
    """Mass, centre of mass and inertia, as `ActorBuilder.set_mass_and_inertia` takes them."""
    return (
        columns.value(inertial.mass, "mass"),
        columns.value(inertial.com, "com", pose),
        columns.value(inertial.inertia, "inertia"),
    )


def write_inertial(source: Source, inertial: Inertial, columns: Columns) -> None:
    """The same three, to `body`."""
    mass, com, inertia = inertial_nodes(inertial, columns)
    source.statement(mass, assign="body.mass")
    source.statement(com, assign="body.cmass_local_pose")
    source.statement(inertia, assign="body.inertia")


def write_offsets(source: Source, shapes: tuple[CollisionShape, ...], columns: Columns) -> None:
    """Offsets of the shapes of `body`; one loop where all shapes have the same."""
    wanted = [
        [(name, columns.value(getattr(shape, name), name, numbers)) for name in given(shape, OFFSETS)]
        for shape in shapes
    ]
    if len(wanted) > 1 and wanted[0] and all(one == wanted[0] for one in wanted):
        with source.block("for shape in body.collision_shapes:"):
            for name, node in wanted[0]:
                source.statement(node, assign=f"shape.{name}")
        return
    for index, one in enumerate(wanted):
        for name, node in one:
            source.statement(node, assign=f"body.collision_shapes[{index}].{name}")
