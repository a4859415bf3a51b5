"""Rules of physics over a plan: what SAPIEN would take without a word. One rule a function."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.checks.collide import Reach, meet, reach
from scenecc.checks.mass import inertia_is_real, mass_is_clear, single, weight_can_be_held
from scenecc.diagnostics import Origin
from scenecc.plan import Mesh, PhysicalMaterial, Plane, TriangleMesh, literal

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import BodyStructure, CollisionShape, Entity, ScenePlan

    Found = tuple[Entity, BodyStructure, CollisionShape]

CONTACT_OFFSET, REST_OFFSET = 0.01, 0.0
"""SAPIEN's own (`sapien.physx.get_shape_config()`)."""

LANGUAGE_KEYS = {
    "disable_gravity": "gravity",
    "locked_motion_axes": "locked_axes",
    "collision_groups": "collision_bits",
}
"""Fields of the plan whose key in a scene file has another name."""

MOVING = (
    "mass",
    "inertial",
    "disable_gravity",
    "linear_damping",
    "angular_damping",
    "linear_velocity",
    "angular_velocity",
    "locked_motion_axes",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
)
"""What only a dynamic body has: PhysX moves no other by forces."""

_ID_BITS = 0xFFFF

SEEN = ("visibility", "shading_mode")

WHY_NOTHING = {
    "kinematic": "PhysX does not move it by forces",
    "static": "it never moves",
    "none": "it is only seen",
}


def check_physics(plan: ScenePlan, material_origins: Mapping[int, Origin], sink: Sink) -> None:
    """Applies every rule to every body and material.

    Args:
        plan: with or without lines behind its origins.
        material_origins: for each physical material, where it is written.
        sink: takes the diagnostics.
    """
    for entity in plan.entities:
        for structure in entity.structures:
            origin = _origin(structure, entity, plan)
            for rule in BODY_RULES:
                rule(structure, entity.name, origin, sink)
    for index, material in enumerate(plan.physical_materials):
        origin = material_origins.get(index) or _plan_origin(plan).child("physical_materials", index)
        _surface(material, origin, sink)
    default = plan.physics.default_material
    if default is not None:
        given = (default.static_friction, default.dynamic_friction, default.restitution)
        place = _physics_origin(plan).child("default_material")
        _surface(PhysicalMaterial(*map(literal, given)), place, sink)
    _offsets(plan, sink)
    _sdf_on_planes(plan, sink)


def _origin(structure: BodyStructure, entity: Entity, plan: ScenePlan) -> Origin:
    origin = structure.origin or entity.origin
    return origin if origin is not None else _plan_origin(plan).child("entities", entity.name)


def _plan_origin(plan: ScenePlan) -> Origin:
    return plan.origin or Origin(None)


def _physics_origin(plan: ScenePlan) -> Origin:
    return plan.physics.origin or _plan_origin(plan).child("physics")


def _has_shapes(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if not body.collisions and not body.visuals:
        sink.report(
            "SC501",
            f"`{name}` has no shape: nothing to collide with and nothing to see",
            origin,
            at="key",
            hint="add `shapes`, `collisions` or `visuals`; a place with no body is a frame",
        )
    elif body.body_type == "dynamic" and not body.collisions and body.inertial is None:
        sink.report(
            "SC502",
            f"`{name}` is dynamic but nothing of it collides: it would weigh a milligram and fall for ever",
            origin,
            at="key",
            hint="use `shapes` instead of `visuals`, give `inertial`, or set body_type: kinematic",
        )


def _planes_stand_still(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type != "dynamic":
        return
    for shape in body.collisions:
        if isinstance(shape.geometry, Plane):
            sink.report(
                "SC503",
                f"`{name}` is dynamic, and a plane is endless: it cannot move",
                shape.origin or origin,
                hint="set body_type: static, or use a box",
            )


def _effective(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Nothing is given that would do nothing."""
    kind = body.body_type
    if kind != "dynamic":
        for field in MOVING:
            if getattr(body, field) is not None:
                _nothing(field, f"body of type {kind}: {WHY_NOTHING[kind]}", origin, sink)
    if not body.visuals:
        for field in SEEN:
            if getattr(body, field) is not None:
                _nothing(field, "body without a visible shape", origin, sink)
    if not body.collisions and body.collision_groups is not None:
        _nothing("collision_groups", "body without a colliding shape", origin, sink)
    if kind == "none" and body.collisions:
        sink.report(
            "SC115",
            f"`{name}` is only seen, so its colliding shapes do nothing",
            body.collisions[0].origin or origin,
            hint="write them under `visuals`, or set another body_type",
        )


def _nothing(field: str, what: str, origin: Origin, sink: Sink) -> None:
    key = LANGUAGE_KEYS.get(field, field)
    sink.report("SC115", f"`{key}` does nothing on a {what}", origin.child(key), at="key", hint=f"leave `{key}` out")


def _groups(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """PhysX tells scenes that share one simulation apart by the top 16 bits of the fourth integer."""
    if body.collision_groups is not None and any(bits > _ID_BITS for bits in body.collision_groups.numbers()[3::4]):
        message = f"the fourth of the collision bits of `{name}` is above {_ID_BITS}, and its top 16 bits are reserved"
        sink.report("SC104", message, origin.child(LANGUAGE_KEYS["collision_groups"]))


def _meshes_that_move(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type != "dynamic":
        return
    for shape in body.collisions:
        if isinstance(shape.geometry, TriangleMesh) and not shape.geometry.sdf:
            sink.report(
                "SC508",
                f"`{name}` is dynamic, and PhysX moves no plain triangle mesh",
                shape.origin or origin,
                hint="use convex_mesh or convex_parts, or set sdf: true",
            )


def _mirrored(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    for shape in body.visuals:
        if isinstance(shape.geometry, Mesh) and not all(shape.geometry.scale.numbers()):
            place = (shape.origin or origin).child("scale")
            sink.report("SC104", f"a scale of 0 leaves nothing of a mesh of `{name}`", place)


BODY_RULES: tuple[Callable[[BodyStructure, str, Origin, Sink], None], ...] = (
    _has_shapes,
    _planes_stand_still,
    _effective,
    mass_is_clear,
    weight_can_be_held,
    inertia_is_real,
    _groups,
    _meshes_that_move,
    _mirrored,
)


def _surface(material: PhysicalMaterial, origin: Origin, sink: Sink) -> None:
    slides_harder = _above(material.dynamic_friction.numbers(), material.static_friction.numbers())
    if slides_harder is not None:
        dynamic, static = slides_harder
        sink.report(
            "SC504",
            f"dynamic friction {dynamic:g} is above static friction {static:g}",
            origin,
            hint="what is left out is the default material's; sliding never rubs more than sticking",
        )
    bouncy = [number for number in material.restitution.numbers() if not 0 <= number <= 1]
    if bouncy:
        sink.report("SC505", f"restitution {bouncy[0]:g} is not in 0..1", origin)


def _above(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float] | None:
    """The first pair whose `a` is above its `b`; where they do not go row by row, the largest and the smallest."""
    pairs = zip(a, b, strict=True) if len(a) == len(b) else [(max(a), min(b))]
    return next((pair for pair in pairs if pair[0] > pair[1]), None)


def _offsets(plan: ScenePlan, sink: Sink) -> None:
    """Contacts are made before shapes rest on each other."""
    physics = plan.physics
    contact = CONTACT_OFFSET if physics.contact_offset is None else physics.contact_offset
    rest = REST_OFFSET if physics.rest_offset is None else physics.rest_offset
    if single(contact) <= single(rest):
        key = "rest_offset" if physics.rest_offset is not None else "contact_offset"
        _offset(contact, rest, _physics_origin(plan).child(key), sink)
    for entity in plan.entities:
        for structure in entity.structures:
            for shape in structure.collisions:
                if shape.contact_offset is None and shape.rest_offset is None:
                    continue
                contacts = (contact,) if shape.contact_offset is None else shape.contact_offset.numbers()
                rests = (rest,) if shape.rest_offset is None else shape.rest_offset.numbers()
                bad = next((pair for pair in _by_row(contacts, rests) if single(pair[0]) <= single(pair[1])), None)
                if bad is not None:
                    key = "rest_offset" if shape.rest_offset is not None else "contact_offset"
                    origin = shape.origin or _origin(structure, entity, plan)
                    _offset(*bad, origin.child(key), sink)


def _by_row(a: tuple[float, ...], b: tuple[float, ...]) -> Iterator[tuple[float, float]]:
    """Pairs of two columns, each of one number in all or of one a row."""
    rows = max(len(a), len(b))
    return zip(a * rows if len(a) == 1 else a, b * rows if len(b) == 1 else b, strict=True)


def _offset(contact: float, rest: float, origin: Origin, sink: Sink) -> None:
    sink.report(
        "SC507",
        f"contact_offset {contact:g} is not above rest_offset {rest:g}",
        origin,
        hint="contacts must begin before shapes rest: raise contact_offset or lower rest_offset",
    )


def _sdf_on_planes(plan: ScenePlan, sink: Sink) -> None:
    """On the CPU PhysX lets a signed distance field fall through a plane."""
    moving: list[Found] = []
    # Of planes that the same bodies meet one stands for all: a file may hold thousands of both.
    planes: dict[Reach, Found] = {}
    for entity in plan.entities:
        for structure in entity.structures:
            for shape in structure.collisions:
                match shape.geometry:
                    case TriangleMesh(sdf=True) if structure.body_type == "dynamic":
                        moving.append((entity, structure, shape))
                    case Plane():
                        planes.setdefault(reach(entity, structure), (entity, structure, shape))
                    case _:
                        pass
    met: dict[Reach, Found | None] = {}
    for entity, structure, shape in moving:
        key = reach(entity, structure)
        if key not in met:
            met[key] = next((plane for plane in planes.values() if meet(entity, structure, *plane[:2])), None)
        found = met[key]
        if found is None:
            continue
        other, other_structure, plane = found
        sink.report(
            "SC509",
            f"`{entity.name}` would fall through the plane of `{other.name}`",
            shape.origin or _origin(structure, entity, plan),
            hint="on the CPU a signed distance field meets boxes, not planes: make the ground a box",
            related=[("the plane", plane.origin or _origin(other_structure, other, plan), "value")],
        )
