"""Rules for bodies, materials and contacts that SAPIEN does not enforce. `BODY_RULES` and `NUMBER_RULES` list the rules
of a body. Articulations, constraints, lights and cameras have separate modules, loaded only if a plan contains them.
"""

from __future__ import annotations

from operator import gt
from typing import TYPE_CHECKING, Any

from scenecc.checks.mass import DYNAMIC_TYPES, check_density_mass, check_explicit_mass, check_inertia
from scenecc.checks.value_queries import (
    Row,
    find_single_fault,
    find_wrong_pair,
    is_bounded,
    is_sampled,
    report_fault,
)
from scenecc.diagnostics.diagnostic import Origin
from scenecc.geometry.rotations import MAX_COORDINATE
from scenecc.plan import BodyStructure, Heightfield, Mesh, Plane, Ring, TriangleMesh, literal
from scenecc.plan.body import COLLISION_ID_BITS, DEFAULT_COLLISION_GROUPS, PhysicalMaterial, groups_collide
from scenecc.plan.material_counts import MATERIAL_LIMIT, count_materials
from scenecc.plan.properties import CONTACT_OFFSET, PROPERTIES, REST_OFFSET, property_fields, round_to_float32

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.plan import ArticulationStructure, CollisionShape, Entity, ScenePlan, Value
    from scenecc.plan.scene import Physics

    Found = tuple[Entity, BodyStructure, CollisionShape]

    NumberRule = Callable[[BodyStructure, str, Origin, Sink], None]
    """A rule about numbers of a body with a name. It reports faults."""


CollisionKey = tuple[tuple[int, ...], "tuple[int, ...] | None", "tuple[Value | None, ...]"]
"""The scenes of an entity, the scenes of its rows with a given structure (None: all), and the groups of its shapes."""


def may_collide(a: Entity, a_structure: BodyStructure, b: Entity, b_structure: BodyStructure) -> bool:
    """Returns whether two entities with these structures occur in one scene and their collision groups let them
    collide.
    """
    if not any(_varies_by_scene(*body) for body in ((a, a_structure), (b, b_structure))):
        # Bodies that are in every scene share one tuple.
        together = a.scene_idxs is b.scene_idxs or not set(a.scene_idxs).isdisjoint(b.scene_idxs)
        return together and _groups_collide(a_structure, 0, b_structure, 0)
    rows = {scene: row for row, scene in enumerate(b.scene_idxs)}
    for row_a, scene in enumerate(a.scene_idxs):
        row_b = rows.get(scene)
        if row_b is None or not (
            _may_have_structure(a, a_structure, row_a) and _may_have_structure(b, b_structure, row_b)
        ):
            continue
        if _groups_collide(a_structure, row_a, b_structure, row_b):
            return True
    return False


def collision_key(entity: Entity, structure: BodyStructure) -> CollisionKey:
    """Returns all inputs of `may_collide`: bodies with equal keys may collide with the same others."""
    rows = None
    if entity.pick is not None:
        rows = tuple(row for row in range(len(entity.scene_idxs)) if _may_have_structure(entity, structure, row))
    return entity.scene_idxs, rows, _distinct_groups(structure)


def _varies_by_scene(entity: Entity, structure: BodyStructure) -> bool:
    """Returns whether the entity's scenes differ in the inputs of `may_collide`."""
    return entity.pick is not None or any(groups is not None and groups.may_vary for groups in structure.shape_groups())


def _may_have_structure(entity: Entity, structure: BodyStructure, row: int) -> bool:
    """Returns whether an entity may have a structure in one of its scenes, for any draw."""
    if entity.pick is None or entity.pick.known:
        return _contains_body(entity.structure(row), structure)
    return any(_contains_body(entity.structures[int(index)], structure) for index in entity.pick.numbers())


def _contains_body(whole: BodyStructure | ArticulationStructure, body: BodyStructure) -> bool:
    return any(one is body for one in whole.bodies)


def _groups_collide(a: BodyStructure, row_a: int, b: BodyStructure, row_b: int) -> bool:
    """Returns whether the groups of any shape of one body and any shape of the other let them collide."""
    theirs = _collision_groups(b, row_b)
    return any(groups_collide(mine, other) for mine in _collision_groups(a, row_a) for other in theirs)


def _collision_groups(structure: BodyStructure, row: int) -> Sequence[Sequence[int]]:
    """Returns the distinct groups of the shapes of a body."""
    each = _distinct_groups(structure)
    return [DEFAULT_COLLISION_GROUPS if groups is None else [int(x) for x in groups.row(row)] for groups in each]


def _distinct_groups(structure: BodyStructure) -> tuple[Value | None, ...]:
    """Compares by identity, because comparing the values of many scenes is slow."""
    return tuple({id(groups): groups for groups in structure.shape_groups()}.values())


def check_physical_material(material: PhysicalMaterial, origin: Origin, sink: Sink) -> None:
    """Checks that dynamic friction is at most static friction, and restitution at most 1.

    Args:
        material: the material; its values may differ between scenes.
        origin: origin of the material.
        sink: collects diagnostics.
    """
    found = find_wrong_pair(material.dynamic_friction, material.static_friction, gt)
    if found is not None:
        (dynamic, static), sample = found
        message = f"dynamic friction {dynamic:g} is above static friction {static:g}"
        hint = f"write `dynamic_friction: {static:g}`, or less; missing values come from the default material"
        report_fault(sink, "SC504", message, origin, hint, sample)
    found = find_single_fault(material.restitution, lambda row: None if 0 <= row[0] <= 1 else row[0])
    if found is not None:
        report_fault(sink, "SC505", f"restitution {found.found:g} must be from 0 to 1", origin, "", found.sample)


def check_default_contacts(physics: Physics, origin: Origin, sink: Sink) -> None:
    """Checks the default material and the default offsets.

    Args:
        physics: settings of the document.
        origin: origin of `physics`.
        sink: collects diagnostics.
    """
    default = physics.default_material
    if default is not None:
        given = (default.static_friction, default.dynamic_friction, default.restitution)
        check_physical_material(PhysicalMaterial(*map(literal, given)), origin.child("default_material"), sink)
    contact, rest = _default_offsets(physics)
    if not _begins_before(contact, rest):
        key = "rest_offset" if physics.rest_offset is not None else "contact_offset"
        _report_offsets(contact, rest, origin.child(key), sink)


def check_contact_offsets(body: BodyStructure, physics: Physics, origin: Origin, sink: Sink) -> None:
    """Checks that contact offsets are above rest offsets.

    Args:
        body: the body whose shapes are checked.
        physics: settings of the document.
        origin: origin of the body.
        sink: collects diagnostics.
    """
    for shape in body.collisions:
        if shape.contact_offset is None and shape.rest_offset is None:
            continue
        default_contact, default_rest = map(literal, _default_offsets(physics))
        offsets = shape.rest_offset or default_rest, shape.contact_offset or default_contact
        found = find_wrong_pair(*offsets, lambda rest, contact: not _begins_before(contact, rest))
        if found is not None:
            (rest, contact), sample = found
            key = "rest_offset" if shape.rest_offset is not None else "contact_offset"
            _report_offsets(contact, rest, (shape.origin or origin).child(key), sink, sample)


def _default_offsets(physics: Physics) -> tuple[float, float]:
    contact = CONTACT_OFFSET if physics.contact_offset is None else physics.contact_offset
    return contact, REST_OFFSET if physics.rest_offset is None else physics.rest_offset


def _begins_before(contact: float, rest: float) -> bool:
    return round_to_float32(contact) > round_to_float32(rest)


def _report_offsets(
    contact: float, rest: float, origin: Origin, sink: Sink, sample: tuple[int, int | None] | None = None
) -> None:
    message = f"contact_offset {contact:g} must be above rest_offset {rest:g}"
    hint = "raise contact_offset or lower rest_offset"
    report_fault(sink, "SC507", message, origin, hint, sample)


LANGUAGE_KEYS = {row.field: row.key for row in PROPERTIES if row.field != row.key}
"""Fields of the plan that have a different key in scene files."""

DYNAMIC_FIELDS = (*property_fields("mass"), "inertial", *property_fields("body"))
"""Fields that only dynamic bodies use."""

VISUAL_FIELDS = property_fields("look")

_INITIAL_VELOCITIES = ("linear_velocity", "angular_velocity")

NO_EFFECT_REASONS = {
    "kinematic": "forces do not move it",
    "static": "it never moves",
    "none": "it has no physics body",
}


def check_physics(plan: ScenePlan, material_origins: Mapping[int, Origin], sink: Sink) -> None:
    """Applies every rule to every body and material.

    Args:
        plan: with or without lines for its origins.
        material_origins: where each physical material is written.
        sink: collects diagnostics.
    """
    for entity in plan.entities:
        for structure in entity.structures:
            if not isinstance(structure, BodyStructure):
                from scenecc.checks.joints import apply_joint_rules  # noqa: PLC0415 - needed only if there is one

                apply_joint_rules(structure, entity.name, structure_origin(structure, entity, plan), sink)
            for name, body, described in named_bodies(structure, entity.name):
                # For a robot file, its reader warns, because such inertias are common there and SAPIEN accepts them.
                rules = _ROBOT_FILE_RULES if described else NUMBER_RULES
                _check_body(body, name, structure_origin(body, entity, plan), plan, rules, sink)
    _check_optional_sections(plan, sink)
    for index, material in enumerate(plan.physical_materials):
        origin = material_origins.get(index) or plan_origin(plan).child("physical_materials", index)
        check_physical_material(material, origin, sink)
    check_default_contacts(plan.physics, physics_origin(plan), sink)
    if plan.num_scenes * len(plan.physical_materials) >= MATERIAL_LIMIT:
        _check_material_count(plan, sink)
    _check_sdf_on_planes(plan, sink)


def _check_material_count(plan: ScenePlan, sink: Sink) -> None:
    """Warns if all scenes together need more physical materials than a process can hold."""
    count, own, first = count_materials(plan)
    if count > MATERIAL_LIMIT:
        message = f"{plan.num_scenes} scenes need {count} physical materials, and a process can hold {MATERIAL_LIMIT}"
        hint = "build fewer scenes in one process (`--scene 0:2048`)"
        if own:
            hint = f"draw friction and restitution from few values (`choice`), which are shared, or {hint}"
        place = None if first is None else first.origin
        sink.report("SC586", message, place or plan_origin(plan), hint=hint)


def _check_optional_sections(plan: ScenePlan, sink: Sink) -> None:
    """Checks constraints, lights and cameras, whose rules are loaded only if there are any."""
    if plan.constraints:
        from scenecc.checks.chains import check_chains  # noqa: PLC0415 - as above
        from scenecc.checks.joints import check_constraints  # noqa: PLC0415 - as above

        check_constraints(plan, sink)
        check_chains(plan, sink)
    if plan.lights or plan.cameras:
        from scenecc.checks.render_objects import check_render_objects  # noqa: PLC0415 - as above

        check_render_objects(plan, sink)


def named_bodies(
    structure: BodyStructure | ArticulationStructure, name: str
) -> Iterator[tuple[str, BodyStructure, bool]]:
    """Yields the bodies of a structure, their names in messages, and whether they come from a robot file.

    Args:
        structure: structure of the entity.
        name: name of the entity.
    """
    if isinstance(structure, BodyStructure):
        yield name, structure, False
    else:
        for link in structure.links:
            yield f"{name}/{link.name}", link.body, not (structure.file is link.file is None)


def _check_body(
    body: BodyStructure,
    name: str,
    origin: Origin,
    plan: ScenePlan,
    number_rules: tuple[NumberRule, ...],
    sink: Sink,
) -> None:
    for number_rule in number_rules:
        number_rule(body, name, origin, sink)
    for rule in BODY_RULES:
        rule(body, name, origin, sink)
    check_contact_offsets(body, plan.physics, origin, sink)


def structure_origin(structure: BodyStructure | ArticulationStructure, entity: Entity, plan: ScenePlan) -> Origin:
    """Returns where a body or an articulation is written."""
    origin = structure.origin or entity.origin
    return origin if origin is not None else plan_origin(plan).child("entities", entity.name)


def plan_origin(plan: ScenePlan) -> Origin:
    """Returns the root of a plan."""
    return plan.origin or Origin(None)


def constrained_entities(plan: ScenePlan) -> set[str]:
    """Returns the names of entities that a constraint connects."""
    return {mount.entity for one in plan.constraints for mount in (one.child, one.parent) if mount is not None}


def physics_origin(plan: ScenePlan) -> Origin:
    """Returns where the physics section is, or would be."""
    return plan.physics.origin or plan_origin(plan).child("physics")


def _check_shapes(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type == "link":
        # A link may have no shapes, such as a tool centre point.
        return
    if not body.collisions and not body.visuals and not body.shapeless:
        sink.report(
            "SC501",
            f"`{name}` has no collision or visual shape",
            origin,
            at="key",
            hint="add `shapes`, `collisions` or `visuals`, or an empty list of `shapes`; for a mere pose, use a frame",
        )
    elif body.body_type == "dynamic" and not body.collisions and body.inertial is None:
        sink.report(
            "SC502",
            f"`{name}` is dynamic but has no collision shape: it would weigh a milligram and fall forever",
            origin,
            at="key",
            hint="use `shapes` instead of `visuals`, give `inertial`, or set `body_type: kinematic`",
        )


def _check_planes(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type not in DYNAMIC_TYPES:
        return
    is_link = body.body_type == "link"
    for shape in body.collisions:
        if isinstance(shape.geometry, Plane):
            sink.report(
                "SC503",
                f"`{name}` is {'a link' if is_link else 'dynamic'}, but a plane is infinite and cannot move",
                shape.origin or origin,
                hint="use a box" if is_link else "write `body_type: static`, or use a box",
            )


def _check_unused_fields(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Reports fields without an effect."""
    kind = body.body_type
    if kind not in DYNAMIC_TYPES:
        for field in DYNAMIC_FIELDS:
            if getattr(body, field) is not None:
                _report_unused_field(field, f"body of type {kind}: {NO_EFFECT_REASONS[kind]}", origin, sink)
    if not body.visuals:
        for field in VISUAL_FIELDS:
            if getattr(body, field) is not None:
                _report_unused_field(field, "body without a visual shape", origin, sink)
    if not body.collisions and body.collision_groups is not None:
        _report_unused_field("collision_groups", "body without a collision shape", origin, sink)
    if kind == "none" and body.collisions:
        sink.report(
            "SC115",
            f"`{name}` has no physics body, so its collision shapes do nothing",
            body.collisions[0].origin or origin,
            hint="write them under `visuals`, or set another body_type",
        )


def _report_unused_field(field: str, what: str, origin: Origin, sink: Sink) -> None:
    key = LANGUAGE_KEYS.get(field, field)
    hint = f"remove `{key}`"
    if field in _INITIAL_VELOCITIES and "kinematic" in what:
        hint += ", and move the body in your program by `set_kinematic_target`, or set `body_type: dynamic`"
    sink.report("SC115", f"`{key}` has no effect on a {what}", origin.child(key), at="key", hint=hint)


def _check_group_bits(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Checks the fourth integer, whose top 16 bits PhysX uses to separate scenes in one simulation."""
    given = [
        (body.collision_groups, origin),
        *((one.collision_groups, one.origin or origin) for one in body.collisions),
    ]
    for groups, place in given:
        if groups is not None and any(bits > COLLISION_ID_BITS for bits in groups.numbers()[3::4]):
            most = f"above {COLLISION_ID_BITS}, and its top 16 bits are reserved"
            message = f"the fourth of the collision bits of `{name}` is {most}"
            sink.report("SC104", message, place.child(LANGUAGE_KEYS["collision_groups"]))


def _check_moving_meshes(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type not in DYNAMIC_TYPES:
        return
    what = "a link" if body.body_type == "link" else "dynamic"
    for shape in body.collisions:
        if isinstance(shape.geometry, Heightfield):
            message = f"`{name}` is {what}, but PhysX cannot move a heightfield"
            hint = "use convex shapes" if body.body_type == "link" else "make the body static or kinematic"
            sink.report("SC508", message, shape.origin or origin, hint=hint)
        if isinstance(shape.geometry, TriangleMesh) and not shape.geometry.sdf:
            sink.report(
                "SC508",
                f"`{name}` is {what}, but PhysX cannot move a plain triangle mesh",
                shape.origin or origin,
                hint="write `type: convex_mesh` or `convex_parts`, or set `sdf: true`",
            )


def _check_mesh_scales(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    for shape in body.visuals:
        scale = shape.geometry.scale if isinstance(shape.geometry, Mesh) else None
        # An expression is checked where it is lowered.
        if scale is not None and not is_sampled(scale) and not all(scale.numbers()):
            place = (shape.origin or origin).child("scale")
            sink.report("SC104", f"a mesh of `{name}` has a scale of 0", place)


BODY_RULES: tuple[Callable[[BodyStructure, str, Origin, Sink], None], ...] = (
    _check_shapes,
    _check_planes,
    _check_unused_fields,
    _check_group_bits,
    _check_moving_meshes,
    _check_mesh_scales,
)

MAX_RADIUS_RATIO = 0.999
"""Maximum ratio of a ring's inner radius to its outer one: PhysX merges the corners of thinner parts."""

MIN_TERRAIN = 1e-6
"""Minimum extent of terrain along x and y [m]: PhysX drops smaller triangles."""


def check_geometries(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Applies the rule of each shape's type."""
    # A shape that is both collision and visual has one geometry.
    checked = {id(one.geometry): one for one in (*body.collisions, *body.visuals) if type(one.geometry) in SHAPE_RULES}
    for shape in checked.values():
        SHAPE_RULES[type(shape.geometry)](shape.geometry, name, shape.origin or origin, sink)


def _check_ring(ring: Ring, name: str, origin: Origin, sink: Sink) -> None:
    """Checks that a ring has a wall between its inner and outer radius."""
    radii = ring.inner_radius, ring.outer_radius
    found = find_wrong_pair(*radii, lambda inner, outer: inner > MAX_RADIUS_RATIO * outer)
    if found is not None:
        (inner, outer), sample = found
        message = f"a ring of `{name}` with an inner radius of {inner:g} m and an outer one of {outer:g} m"
        hint = f"`inner_radius` must be at most {MAX_RADIUS_RATIO} of `outer_radius`"
        place = origin.child("inner_radius")
        report_fault(sink, "SC528", f"{message} has too thin a wall", place, hint, sample)


def _check_terrain(terrain: Heightfield, name: str, origin: Origin, sink: Sink) -> None:
    """Checks that terrain is within the coordinate limit, and that PhysX keeps its triangles."""
    tallest = max(abs(height) for row in terrain.heights for height in row)

    def find_terrain_fault(size: Row) -> tuple[str, str] | None:
        """Returns the message and the hint for a wrong size, or None."""
        if not is_bounded(size):
            return None
        x, y, z = size
        reach = max(x / 2, y / 2, z * tallest)
        if reach > MAX_COORDINATE:
            message = f"the terrain of `{name}` reaches {reach:.3g} m; the maximum is {MAX_COORDINATE:.0e} m"
            return message, "a height is multiplied by the third number of `size`"
        if min(x, y) < MIN_TERRAIN:
            return f"the terrain of `{name}` is smaller than {MIN_TERRAIN:.0e} m along x or y", "lengths are in metres"
        return None

    found = find_single_fault(terrain.size, find_terrain_fault)
    if found is not None:
        message, hint = found.found
        report_fault(sink, "SC529", message, origin.child("size"), hint, found.sample)


SHAPE_RULES: Mapping[type, Callable[[Any, str, Origin, Sink], None]] = {
    Ring: _check_ring,
    Heightfield: _check_terrain,
}
"""Rules about numbers of one type of shape, by its geometry."""

NUMBER_RULES: tuple[NumberRule, ...] = (
    check_density_mass,
    check_explicit_mass,
    check_inertia,
    check_geometries,
)
"""Rules about numbers that may differ between scenes."""

_ROBOT_FILE_RULES: tuple[NumberRule, ...] = (check_density_mass, check_explicit_mass)


def _check_sdf_on_planes(plan: ScenePlan, sink: Sink) -> None:
    """Reports signed distance fields above planes: on the CPU, PhysX lets them fall through."""
    moving: list[Found] = []
    # Of planes that meet the same bodies, one is enough: a file may contain thousands of both.
    planes: dict[CollisionKey, Found] = {}
    for entity in plan.entities:
        for body in entity.bodies:
            for shape in body.collisions:
                match shape.geometry:
                    case TriangleMesh(sdf=True) if body.body_type in DYNAMIC_TYPES:
                        moving.append((entity, body, shape))
                    case Plane():
                        planes.setdefault(collision_key(entity, body), (entity, body, shape))
                    case _:
                        pass
    met: dict[CollisionKey, Found | None] = {}
    for entity, structure, shape in moving:
        key = collision_key(entity, structure)
        if key not in met:
            met[key] = next((plane for plane in planes.values() if may_collide(entity, structure, *plane[:2])), None)
        found = met[key]
        if found is None:
            continue
        other, other_structure, plane = found
        sink.report(
            "SC509",
            f"`{entity.name}` would fall through the plane of `{other.name}`",
            shape.origin or structure_origin(structure, entity, plan),
            hint="on the CPU a signed distance field collides with boxes, not planes: make the ground a box",
            related=[("the plane", plane.origin or structure_origin(other_structure, other, plan), "value")],
        )
