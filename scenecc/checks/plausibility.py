"""Checks for valid but implausible values: wrong units, and masses that do not fit the body.

Only `scenecc check` applies these rules. They need a plan with its draws, and check all its scenes. Bodies of robot
files are not checked, because the author of a scene cannot change them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.checks.mass import DYNAMIC_TYPES
from scenecc.checks.physics import named_bodies, physics_origin, plan_origin, structure_origin
from scenecc.checks.value_queries import Row, find_single_fault, is_bounded, report_fault
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotation_arrays import rotate
from scenecc.plan import ArticulationStructure
from scenecc.plan.geometry import Solid
from scenecc.plan.properties import DEFAULT_DENSITY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import BodyStructure, Entity, ScenePlan

MAX_GRAVITY: Final = 30.0
"""[m/s²] Jupiter has 25."""

MIN_GRAVITY: Final = 1.5
"""[m/s²] The Moon has 1.6."""

MAX_TIMESTEP: Final = 0.03
"""[s] A frame of a film takes longer, and PhysX then misses contacts."""

MIN_TIMESTEP: Final = 1e-6
"""[s]"""

DENSITIES: Final = (12.0, 25_000.0)
"""[kg/m³] Packing foam has 15 and more, osmium 22 600. In g/cm³ steel has 7.8 and lead 11.3."""

MEAN_DENSITIES: Final = (2.0, 50_000.0)
"""[kg/m³] For a body with a given mass: it may be hollow, and larger than its collision shapes."""

MAX_SIZE: Final = 20.0
"""[m] Length of a shape on a moving body. Shapes that are too small weigh less than a milligram, which is an error."""

THIN: Final = 2.0
"""[m] A fixed shape may be longer than `MAX_SIZE` if it is this thin: a wall or a floor."""

MAX_WEIGHT: Final = 50_000.0
"""[kg] For a moving body whose mass follows from its sizes: a loaded lorry has 40 000."""

MAX_UNSAID_WEIGHT: Final = 4000.0
"""[kg] For a moving body whose density is not written either: a cube of water of 1.6 m."""

MAX_SPEED: Final = 45.0
"""[m/s] A ball that is thrown as fast as possible."""

MAX_TURNING: Final = 100.0
"""[rad/s] PhysX's limit for all bodies, unless `max_angular_velocity` changes it."""

MAX_DISTANCE: Final = 5000.0
"""[m] From here on, float32 resolves half a millimetre."""

MAX_OFFSET: Final = 0.1
"""[m] Contact offset; SAPIEN's is 0.01."""

MAX_SLIDE: Final = 10.0
"""Range of a prismatic joint, and its distance from its parent, in sizes of the largest link; at least `MIN_SLIDE`."""

MIN_SLIDE: Final = 3.0
"""[m]"""

MAX_FRICTION: Final = 20.0
"""Rubber on rubber has 2, and a gripper's pads often have 5."""

MAX_JOINT_FRICTION: Final = 1.0
"""PhysX's friction of a joint, as a ratio of its load. SAPIEN's default is 0.05."""

MAX_MOMENT: Final = 4.0
"""Maximum moment of inertia, relative to all mass at the farthest point. Not all parts of a body need to collide."""

MIN_MOMENT: Final = 1e-3
"""Minimum of the largest moment of a body, relative to all mass at the farthest point: a rod has 0.3."""


_CONJUGATE: Final = np.array((1.0, -1.0, -1.0, -1.0))


class Body(NamedTuple):
    """A body or link that the scene itself describes.

    Attributes:
        name: ENTITY or ENTITY/LINK.
        structure: its structure.
        origin: where it is written.
        entity: its entity.
    """

    name: str
    structure: BodyStructure
    origin: Origin
    entity: Entity


def check_values(plan: ScenePlan, material_origins: Mapping[int, Origin], sink: Sink) -> None:
    """Applies every rule of this module.

    Args:
        plan: a plan with its draws.
        material_origins: where each physical material is written.
        sink: collects diagnostics.
    """
    _check_gravity(plan, sink)
    _check_timestep(plan, sink)
    _check_offset(plan, sink)
    _check_friction(plan, material_origins, sink)
    for entity in plan.entities:
        _check_position(entity, plan, sink)
        for structure in entity.structures:
            _check_speeds(entity, structure, plan, sink)
            if isinstance(structure, ArticulationStructure):
                _check_joints(entity, structure, plan, sink)
                _check_joint_friction(entity, structure, plan, sink)
    for body in scene_bodies(plan):
        for rule in BODY_RULES:
            rule(body, sink)


def scene_bodies(plan: ScenePlan) -> Iterator[Body]:
    """Yields the bodies and links of a plan that do not come from a robot file."""
    for entity in plan.entities:
        for structure in entity.structures:
            for name, body, described in named_bodies(structure, entity.name):
                if not described:
                    yield Body(name, body, structure_origin(body, entity, plan), entity)


def _check_gravity(plan: ScenePlan, sink: Sink) -> None:
    x, y, z = plan.physics.gravity or (0.0, 0.0, -9.81)
    place = physics_origin(plan).child("gravity")
    size = float(np.linalg.norm((x, y, z)))
    if size > MAX_GRAVITY:
        hint = "it is in m/s²: on Earth [0, 0, -9.81]"
        sink.report("SC530", f"gravity is {size:.4g} m/s²; even Jupiter has only 25", place, hint=hint)
    elif z > 0:
        hint = "the world is z-up: write [0, 0, -9.81]"
        sink.report("SC530", f"gravity points up: its z is {z:g} m/s²", place, hint=hint)
    elif 0 < size < MIN_GRAVITY:
        hint = "it is in m/s², not in multiples of g: on Earth [0, 0, -9.81]"
        sink.report("SC530", f"gravity is {size:.4g} m/s²; the Moon has 1.6", place, hint=hint)
    elif size > 0 and abs(z) < size / 1000:
        hint = "the world is z-up: write [0, 0, -9.81]"
        sink.report("SC530", "gravity points sideways: its z is 0", place, hint=hint)


def _check_timestep(plan: ScenePlan, sink: Sink) -> None:
    step = plan.physics.timestep
    if step is None or MIN_TIMESTEP <= step <= MAX_TIMESTEP:
        return
    place = physics_origin(plan).child("timestep")
    as_hz = f"for {step:g} Hz write {1 / step:.4g}" if step >= 30 else f"for {step:g} ms write {step / 1000:g}"
    hint = f"it is in seconds: {as_hz}" if step > MAX_TIMESTEP else "it is in seconds"
    sink.report("SC531", f"a time step of {step:g} s is implausible for a simulation", place, hint=hint)


def _check_offset(plan: ScenePlan, sink: Sink) -> None:
    offset = plan.physics.contact_offset
    if offset is not None and offset > MAX_OFFSET:
        place = physics_origin(plan).child("contact_offset")
        message = f"a contact offset of {offset:g} m: SAPIEN's is 0.01"
        sink.report("SC534", message, place, hint=f"it is in metres: for {offset:g} mm write {offset / 1000:g}")


def _check_friction(plan: ScenePlan, material_origins: Mapping[int, Origin], sink: Sink) -> None:
    for index, material in enumerate(plan.physical_materials):
        for key in ("static_friction", "dynamic_friction"):
            most = float(getattr(material, key).data.max())
            if most > MAX_FRICTION:
                place = material_origins.get(index) or plan_origin(plan).child("physical_materials", index)
                message = f"`{key}` is {most:g}: rubber on rubber has about 2"
                sink.report("SC535", message, place.child(key), hint="it is a ratio of forces, without a unit")
                break


def _check_position(entity: Entity, plan: ScenePlan, sink: Sink) -> None:
    far = float(np.abs(entity.pose.data[:, :3]).max())
    if far > MAX_DISTANCE:
        message = (
            f"`{cut(entity.name)}` is {far:.4g} m from the origin, where positions are rounded to half a millimetre"
        )
        place = structure_origin(entity.structures[0], entity, plan).child("pose")
        sink.report("SC534", message, place, hint="lengths are in metres; put the scene around the origin")


def _check_speeds(
    entity: Entity, structure: BodyStructure | ArticulationStructure, plan: ScenePlan, sink: Sink
) -> None:
    """Reports initial velocities that look like millimetres or degrees."""
    place = structure_origin(structure, entity, plan)
    speed, turning = (
        0.0 if value is None else float(np.linalg.norm(value.data, axis=1).max())
        for value in (structure.linear_velocity, structure.angular_velocity)
    )
    if speed > MAX_SPEED:
        message = f"`{cut(entity.name)}` starts at {speed:.4g} m/s, faster than any throw"
        hint = f"velocities are in m/s: for {speed:.4g} mm/s write {speed / 1000:.4g}"
        sink.report("SC534", message, place.child("linear_velocity"), hint=hint)
    if turning > MAX_TURNING and getattr(structure, "max_angular_velocity", None) is None:
        message = f"`{cut(entity.name)}` starts with {turning:.4g} rad/s, but PhysX limits rotation to 100 rad/s"
        hint = f"it is in rad/s: for {turning:.4g}°/s write {np.radians(turning):.4g}; or raise `max_angular_velocity`"
        sink.report("SC534", message, place.child("angular_velocity"), hint=hint)


def _check_joints(entity: Entity, structure: ArticulationStructure, plan: ScenePlan, sink: Sink) -> None:
    """Reports implausible numbers of joints that the scene itself describes."""
    place = structure_origin(structure, entity, plan)
    size = _largest_link(structure)
    for link in structure.links:
        joint = link.joint
        if joint is None or joint.type == "fixed":
            continue
        around = structure_origin(link.body, entity, plan).child("joint")
        if joint.type != "prismatic":
            for key, value in (("qvel", joint.qvel), ("drives", joint.drive_velocity_target)):
                fastest = 0.0 if value is None else float(np.abs(value.data).max())
                if fastest > MAX_TURNING:
                    message = f"joint `{cut(joint.name)}` turns at {fastest:.4g} rad/s, {fastest / np.pi * 30:.3g} rpm"
                    hint = f"it is in rad/s: for {fastest:.4g}°/s write {np.radians(fastest):.4g}"
                    sink.report("SC534", message, place.child(key), at="key", hint=hint)
        if not (structure.file is link.file is None):
            continue  # the author of the scene cannot change it
        most = max(MIN_SLIDE, MAX_SLIDE * size)
        if joint.type == "prismatic" and joint.limits is not None:
            ends = np.where(np.isfinite(joint.limits.data), np.abs(joint.limits.data), 0.0)
            if ends.max() > min(MAX_SIZE, most):
                message = f"joint `{cut(joint.name)}` slides up to {float(ends.max()):.4g} m"
                sink.report("SC534", message, joint.limits_origin or around.child("limits"), hint=METRES)
        far = 0.0 if joint.pose_in_parent is None else float(np.abs(joint.pose_in_parent.data[:, :3]).max())
        if far > most:
            message = f"joint `{cut(joint.name)}` is {far:.4g} m from its parent; the largest link has {size:.2g} m"
            sink.report("SC534", message, around, at="key", hint=METRES)


def _check_joint_friction(entity: Entity, structure: ArticulationStructure, plan: ScenePlan, sink: Sink) -> None:
    """Reports the first joint whose `friction`, a ratio of the load, looks like a force."""

    def find_fault(row: Row) -> float | None:
        return row[0] if is_bounded(row) and row[0] > MAX_JOINT_FRICTION else None

    for link in structure.links:
        joint = link.joint
        found = joint and joint.friction and find_single_fault(joint.friction, find_fault)
        if joint is not None and found:
            ratio = found.found
            of_file = structure.file is not None or link.file is not None
            place = structure_origin(structure if of_file else link.body, entity, plan)
            message = f"the `friction` of joint `{cut(joint.name)}` is {ratio:.4g} times the load that it carries"
            unit = "N" if joint.type == "prismatic" else "N·m"
            hint = f"it is a ratio: for {ratio:.4g} {unit} write `friction_force`"
            key = "joints" if of_file else "joint"
            report_fault(sink, "SC535", message, place.child(key), hint, found.sample, at="key")
            return


METRES: Final = "lengths are in metres, not in millimetres or centimetres"


def _largest_link(structure: ArticulationStructure) -> float:
    """Returns the size of the largest solid of an articulation [m]; infinity if it has shapes of another kind."""
    shapes = [shape for link in structure.links for shape in link.body.collisions]
    solids = [shape.geometry for shape in shapes if isinstance(shape.geometry, Solid)]
    if len(solids) < len(shapes):
        return np.inf
    sizes = [one.extent(np.eye(3), *(float(size.max()) for size in solid_sizes(one))) for one in solids]
    return max((2 * float(size.max()) for size in sizes), default=np.inf)


def _check_densities(body: Body, sink: Sink) -> None:
    structure = body.structure
    if structure.body_type not in DYNAMIC_TYPES or structure.inertial is not None or structure.mass is not None:
        return
    low, high = DENSITIES
    for shape in structure.collisions:
        if shape.density is None:
            continue
        densities = shape.density.data
        odd = densities[((densities < low) & (densities > 0)) | (densities > high)]
        if odd.size:
            number = float(odd.flat[0])
            unit = f"for {number:g} g/cm³ write {number * 1000:g}" if number < low else "osmium has 22 600"
            place = (shape.origin or body.origin).child("density")
            message = f"the density {number:g} kg/m³ in `{cut(body.name)}` is implausible for a solid"
            sink.report("SC532", message, place, hint=f"densities are in kg/m³, water has 1000; {unit}")


def _check_mass(body: Body, sink: Sink) -> None:
    structure = body.structure
    inertial = structure.inertial
    mass = structure.mass if inertial is None else inertial.mass
    solids = [shape.geometry for shape in structure.collisions if isinstance(shape.geometry, Solid)]
    if mass is None or structure.body_type not in DYNAMIC_TYPES or not solids:
        return
    if len(solids) < len(structure.collisions):
        return  # a mesh has its own volume
    volume: Any = sum(solid.volume(*solid_sizes(solid)) for solid in solids)
    density = mass.data / volume
    low, high = MEAN_DENSITIES
    odd = np.flatnonzero((density < low) | (density > high))
    if odd.size:
        row = int(odd[0])
        kilograms, found = float(np.broadcast_to(mass.data, density.shape)[row]), float(density[row])
        place = body.origin.child("mass") if inertial is None else body.origin.child("inertial", "mass")
        message = f"`{cut(body.name)}` has a mass of {kilograms:.4g} kg, which means {found:.3g} kg/m³ on average"
        hint = (
            f"masses are in kg: for {kilograms:.4g} g write {kilograms / 1000:.4g}"
            if found > high
            else "masses are in kg"
        )
        sink.report("SC533", message, place, hint=hint)


def _check_sizes(body: Body, sink: Sink) -> None:
    moves = body.structure.body_type in DYNAMIC_TYPES
    weight = 0.0
    place = body.origin
    for shape in body.structure.collisions:
        if not isinstance(shape.geometry, Solid):
            continue
        sizes = [float(column.max()) for column in solid_sizes(shape.geometry)]
        half = shape.geometry.extent(np.eye(3), *sizes)
        length, place = 2 * float(half.max()), (shape.origin or body.origin).child(_size_key(shape.geometry))
        top = _top(body, half)
        # A ground may be this large if it is flat, or if its top is at the world's origin. There is space below a table
        # top.
        is_table = half.argmin() == 2 and top - 2 * half[2] > MAX_SIZE
        if length > MAX_SIZE and (moves or is_table or (half.min() > THIN / 2 and top > 0)):
            message = f"a shape of `{cut(body.name)}` is {length:.4g} m long"
            sink.report("SC534", message, place, hint=METRES)
            return
        density = DEFAULT_DENSITY if shape.density is None else float(shape.density.data.max())
        weight += float(shape.geometry.volume(*sizes)) * density
    given = body.structure.mass is not None or body.structure.inertial is not None
    unsaid = all(shape.density is None for shape in body.structure.collisions)
    if moves and not given and weight > (MAX_UNSAID_WEIGHT if unsaid else MAX_WEIGHT):
        message = f"the shapes of `{cut(body.name)}` weigh {weight / 1000:.4g} t, on a moving body"
        hint = "lengths are in metres, not in centimetres; if the size is right, give it a `mass`"
        sink.report("SC534", message, place, hint=hint)


def _top(body: Body, half: Any) -> float:
    """Returns the maximum height of a body's shape in the world [m], without its rotations."""
    return float(body.entity.pose.data[:, 2].max() + half[2])


def solid_sizes(solid: Solid) -> tuple[NDArray[Any], ...]:
    """Returns the numbers of a solid as arrays, each with one row per scene or a single row."""
    return tuple(column for value in solid.values for column in value.data.reshape(len(value.data), -1).T)


def _size_key(solid: Solid) -> str:
    """Returns the name of the largest size."""
    return max(solid.__slots__, key=lambda name: float(getattr(solid, name).data.max()))


def _check_inertial(body: Body, sink: Sink) -> None:
    """Reports a centre of mass or moments that do not fit the collision shapes."""
    structure = body.structure
    solids = [shape for shape in structure.collisions if isinstance(shape.geometry, Solid)]
    given, inertial = structure.com, structure.inertial
    if inertial is not None and given is None:
        given = inertial.com
    if given is None or not solids or len(solids) < len(structure.collisions):
        return
    com = given.data[:, :3]
    reach = outside = np.zeros(())
    for shape in solids:
        assert isinstance(shape.geometry, Solid)
        half = shape.geometry.extent(np.eye(3), *(float(column.max()) for column in solid_sizes(shape.geometry)))
        pose = np.array([[0.0, 0, 0, 1, 0, 0, 0]]) if shape.pose is None else shape.pose.data
        rows = max(len(com), len(pose))
        offset = np.broadcast_to(com - pose[:, :3], (rows, 3))
        local = rotate(np.broadcast_to(pose[:, 3:] * _CONJUGATE, (rows, 4)), offset)
        beyond = (np.abs(local) - half).max(axis=1)
        outside = beyond if outside.shape == () else np.minimum(outside, beyond)
        reach = np.maximum(reach, np.linalg.norm(np.abs(local) + half, axis=1))
    name = cut(body.name)
    if (outside > reach / 2).any():
        message = f"the centre of mass of `{name}` is {float(outside.max()):.3g} m outside its collision shapes"
        hint = "it is in the frame of the body, in metres"
        place = body.origin.child("com") if structure.com is not None else body.origin.child("inertial", "com")
        sink.report("SC536", message, place, hint=hint)
        return
    if inertial is None:
        return
    most = inertial.mass.data * reach**2 * MAX_MOMENT
    moment = inertial.inertia.data.max(axis=1)
    if (moment > most).any():
        found, limit = float(moment.max()), float(most.max())
        message = f"`{name}` has a moment of inertia of {found:.3g} kg·m²; shapes and mass allow at most {limit:.2g}"
        hint = "moments are in kg·m², about the centre of mass"
        sink.report("SC536", message, body.origin.child("inertial", "inertia"), hint=hint)
    elif (moment < most * (MIN_MOMENT / MAX_MOMENT)).all():
        found, least = float(moment.max()), float(most.min()) * MIN_MOMENT / MAX_MOMENT
        message = f"`{name}` has moments of inertia of at most {found:.3g} kg·m²; shapes and mass need {least:.2g}"
        hint = "moments are in kg·m², about the centre of mass"
        sink.report("SC536", message, body.origin.child("inertial", "inertia"), hint=hint)


BODY_RULES: Final[tuple[Callable[[Body, Sink], None], ...]] = (
    _check_densities,
    _check_mass,
    _check_sizes,
    _check_inertial,
)
