"""Rules of physics over a plan: what SAPIEN would take without a word. One rule a function."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from scenecc.checks.collide import Reach, meet, reach
from scenecc.checks.contact import default_contacts, offsets_of, surface_is_real
from scenecc.checks.judged import waits
from scenecc.checks.mass import inertia_is_real, mass_is_clear, weight_can_be_held
from scenecc.diagnostics import Origin
from scenecc.plan import Mesh, Plane, TriangleMesh
from scenecc.plan.knobs import KNOBS, fields_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.plan import BodyStructure, CollisionShape, Entity, ScenePlan

    Found = tuple[Entity, BodyStructure, CollisionShape]


class NumberRule(Protocol):
    """A rule about numbers of a body."""

    def __call__(self, body: BodyStructure, name: str, origin: Origin, sink: Sink, *, drawn: bool) -> None:
        """Reports what is wrong; `drawn`: of what waits for its rows."""


LANGUAGE_KEYS = {knob.field: knob.key for knob in KNOBS if knob.field != knob.key}
"""Fields of the plan whose key in a scene file has another name."""

MOVING = (*fields_of("mass"), "inertial", *fields_of("body"))
"""What only a dynamic body has: PhysX moves no other by forces."""

_ID_BITS = 0xFFFF

SEEN = fields_of("look")

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
            origin = _origin(structure, entity, plan)
            for number_rule in NUMBER_RULES:
                number_rule(structure, entity.name, origin, sink, drawn=drawn)
            if not drawn:
                for rule in BODY_RULES:
                    rule(structure, entity.name, origin, sink)
            offsets_of(structure, plan.physics, origin, sink, drawn=drawn)
    for index, material in enumerate(plan.physical_materials):
        origin = material_origins.get(index) or _plan_origin(plan).child("physical_materials", index)
        surface_is_real(material, origin, sink, drawn=drawn)
    if not drawn:
        default_contacts(plan.physics, _physics_origin(plan), sink)
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


NUMBER_RULES: tuple[NumberRule, ...] = (weight_can_be_held, inertia_is_real)
"""Rules about numbers that may differ from scene to scene."""


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
