"""Rules of physics over a plan: what SAPIEN would take without a word. One rule a function."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from scenecc.checks.collide import Reach, meet, reach
from scenecc.checks.contact import default_contacts, offsets_of, surface_is_real
from scenecc.checks.judged import waits
from scenecc.checks.mass import MOVED, inertia_is_real, mass_is_clear, mass_is_held, weight_can_be_held
from scenecc.diagnostics import Origin
from scenecc.plan import BodyStructure, Mesh, Plane, TriangleMesh
from scenecc.plan.body import COLLISION_ID_BITS
from scenecc.plan.properties import PROPERTIES, property_fields

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import ArticulationStructure, CollisionShape, Entity, ScenePlan

    Found = tuple[Entity, BodyStructure, CollisionShape]


class NumberRule(Protocol):
    """A rule about numbers of a body."""

    def __call__(self, body: BodyStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
        """Reports what is wrong; `drawn`: of what waits for its rows."""


LANGUAGE_KEYS = {knob.field: knob.key for knob in PROPERTIES if knob.field != knob.key}
"""Fields of the plan whose key in a scene file has another name."""

MOVING = (*property_fields("mass"), "inertial", *property_fields("body"))
"""What only a dynamic body has: PhysX moves no other by forces."""

SEEN = property_fields("look")

WHY_NOTHING = {
    "kinematic": "PhysX does not move it by forces",
    "static": "it never moves",
    "none": "it is only seen",
}


def check_physics(plan: ScenePlan, material_origins: Mapping[int, Origin], sink: Sink, *, drawn: bool = False) -> None:
    """Applies every rule to every body and material. Draws nothing, unless `drawn`.

    Args:
        plan: with or without lines behind its origins.
        material_origins: for each physical material, where it is written.
        sink: takes the diagnostics.
        drawn: judge what waits for its rows, and nothing else: rules that an expression is part of.
    """
    for entity in plan.entities:
        for structure in entity.structures:
            if not isinstance(structure, BodyStructure):
                from scenecc.checks.articulations import check_articulation  # noqa: PLC0415 - loaded where there is one

                check_articulation(structure, entity.name, _origin(structure, entity, plan), sink, drawn=drawn)
            # Of a robot's file its reader warns, since such inertias are common there and SAPIEN takes them.
            rules = _RULES_OF_FILES if getattr(structure, "file", None) is not None else NUMBER_RULES
            for name, body in _named_bodies(structure, entity.name):
                _check_body(body, name, _origin(body, entity, plan), plan, rules, sink, drawn=drawn)
    _check_others(plan, sink, drawn=drawn)
    for index, material in enumerate(plan.physical_materials):
        origin = material_origins.get(index) or _plan_origin(plan).child("physical_materials", index)
        surface_is_real(material, origin, sink, drawn=drawn)
    if not drawn:
        default_contacts(plan.physics, _physics_origin(plan), sink)
        _sdf_on_planes(plan, sink)


def _check_others(plan: ScenePlan, sink: Sink, *, drawn: bool) -> None:
    """Constraints, lights and cameras, whose rules are loaded where there are any."""
    if plan.constraints:
        from scenecc.checks.constraints import check_constraints  # noqa: PLC0415 - likewise

        check_constraints(plan, sink, drawn=drawn)
    if plan.lights or plan.cameras:
        from scenecc.checks.pictures import check_pictures  # noqa: PLC0415 - likewise

        check_pictures(plan, sink, drawn=drawn)


def _named_bodies(structure: BodyStructure | ArticulationStructure, name: str) -> Iterator[tuple[str, BodyStructure]]:
    """The bodies of a structure with what messages call them. `name`: the entity's."""
    if isinstance(structure, BodyStructure):
        yield name, structure
    else:
        for link in structure.links:
            yield f"{name}/{link.name}", link.body


def _check_body(
    body: BodyStructure,
    name: str,
    origin: Origin,
    plan: ScenePlan,
    number_rules: tuple[NumberRule, ...],
    sink: Sink,
    *,
    drawn: bool,
) -> None:
    for number_rule in number_rules:
        number_rule(body, name, origin, sink, drawn=drawn)
    if not drawn:
        for rule in BODY_RULES:
            rule(body, name, origin, sink)
    offsets_of(body, plan.physics, origin, sink, drawn=drawn)


def _origin(structure: BodyStructure | ArticulationStructure, entity: Entity, plan: ScenePlan) -> Origin:
    origin = structure.origin or entity.origin
    return origin if origin is not None else _plan_origin(plan).child("entities", entity.name)


def _plan_origin(plan: ScenePlan) -> Origin:
    return plan.origin or Origin(None)


def _physics_origin(plan: ScenePlan) -> Origin:
    return plan.physics.origin or _plan_origin(plan).child("physics")


def _has_shapes(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type == "link":
        # It may be a place alone: a tool's tip.
        return
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
    if body.body_type not in MOVED:
        return
    is_link = body.body_type == "link"
    for shape in body.collisions:
        if isinstance(shape.geometry, Plane):
            sink.report(
                "SC503",
                f"`{name}` is {'a link' if is_link else 'dynamic'}, and a plane is endless: it cannot move",
                shape.origin or origin,
                hint="use a box" if is_link else "set body_type: static, or use a box",
            )


def _effective(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    """Nothing is given that would do nothing."""
    kind = body.body_type
    if kind not in MOVED:
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
    if body.collision_groups is not None and any(
        bits > COLLISION_ID_BITS for bits in body.collision_groups.numbers()[3::4]
    ):
        most = f"above {COLLISION_ID_BITS}, and its top 16 bits are reserved"
        message = f"the fourth of the collision bits of `{name}` is {most}"
        sink.report("SC104", message, origin.child(LANGUAGE_KEYS["collision_groups"]))


def _meshes_that_move(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    if body.body_type not in MOVED:
        return
    what = "a link" if body.body_type == "link" else "dynamic"
    for shape in body.collisions:
        if isinstance(shape.geometry, TriangleMesh) and not shape.geometry.sdf:
            sink.report(
                "SC508",
                f"`{name}` is {what}, and PhysX moves no plain triangle mesh",
                shape.origin or origin,
                hint="use convex_mesh or convex_parts, or set sdf: true",
            )


def _mirrored(body: BodyStructure, name: str, origin: Origin, sink: Sink) -> None:
    for shape in body.visuals:
        scale = shape.geometry.scale if isinstance(shape.geometry, Mesh) else None
        # What an expression gives is held to the same in the draw stage.
        if scale is not None and not waits([scale], drawn=False) and not all(scale.numbers()):
            place = (shape.origin or origin).child("scale")
            sink.report("SC104", f"a scale of 0 leaves nothing of a mesh of `{name}`", place)


BODY_RULES: tuple[Callable[[BodyStructure, str, Origin, Sink], None], ...] = (
    _has_shapes,
    _planes_stand_still,
    _effective,
    mass_is_clear,
    _groups,
    _meshes_that_move,
    _mirrored,
)


NUMBER_RULES: tuple[NumberRule, ...] = (weight_can_be_held, mass_is_held, inertia_is_real)
"""Rules about numbers that may differ from scene to scene."""

_RULES_OF_FILES: tuple[NumberRule, ...] = (weight_can_be_held, mass_is_held)


def _sdf_on_planes(plan: ScenePlan, sink: Sink) -> None:
    """On the CPU PhysX lets a signed distance field fall through a plane."""
    moving: list[Found] = []
    # Of planes that the same bodies meet one stands for all: a file may hold thousands of both.
    planes: dict[Reach, Found] = {}
    for entity in plan.entities:
        for body in entity.bodies:
            for shape in body.collisions:
                match shape.geometry:
                    case TriangleMesh(sdf=True) if body.body_type in MOVED:
                        moving.append((entity, body, shape))
                    case Plane():
                        planes.setdefault(reach(entity, body), (entity, body, shape))
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
