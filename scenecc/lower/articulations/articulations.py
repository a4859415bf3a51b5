"""Lowers articulations from the scene file to the plan."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.lower.articulations.attachments import ArticulationAssembler, Assembly
from scenecc.lower.articulations.colliding_pairs import shape_bits_origin, warn_ignored_pairs_collide
from scenecc.lower.articulations.drafts import (
    Alternative,
    Alternatives,
    ArticulationDraft,
    DraftJoint,
    Layer,
    LinkTreeDrafter,
    read_alternatives,
)
from scenecc.lower.articulations.fused_links import fuse_links
from scenecc.lower.articulations.initial_state import InitialStateLowerer, JointNumbers, JointValue
from scenecc.lower.articulations.links import (
    DriveTargetCheck,
    LinkLowerer,
    LostForce,
    lower_joint,
    with_counted_turns,
    with_friction_force,
    with_overrides,
)
from scenecc.lower.articulations.overrides import OverrideValues, PatternMatcher, PatternOverrides, nearest_override
from scenecc.lower.articulations.robots import RobotDrafter
from scenecc.lower.articulations.unused_keys import report_unused_keys
from scenecc.lower.field_types import FieldType, field_type, report_unused_key
from scenecc.lower.references import PlanTables, RobotReader, RobotRequest
from scenecc.plan.articulation import UNLIMITED_VELOCITY, ArticulationStructure, Link, Mimic, soft_mimics
from scenecc.plan.body import COLLISION_ID_BITS, AssetFile, BodyType
from scenecc.plan.value import constant

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.collision_groups import GroupBits
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.materials import MaterialLowerer
    from scenecc.lower.shapes import ShapeLowerer
    from scenecc.plan import BodyStructure, Value
    from scenecc.robots.description import DescribedConstraint, DescribedRobot, RobotDescription


def warn_free_body(firsts: Iterable[tuple[DescribedRobot, ArticulationDraft]], sink: Sink) -> None:
    """Warns of files whose first robot is a free body, if `fix_root_link` is left out."""
    for robot, draft in firsts:
        if robot.body_type == "dynamic" and robot.fixed is None:
            message = f"`{cut(draft.links[0].name)}` has no joint: it is a free body without a fixed root"
            hint = "write `fix_root_link: false`; a constraint of `type: weld` fastens it to the world"
            sink.report("SC525", message, draft.origin, hint=hint)


_IGNORE_ALL_BIT = 1 << 29
"""The bit of the third collision integer that all links of an articulation share to ignore one another."""

_SOLVER: dict[str, FieldType] = {
    "solver_position_iterations": field_type("ArticulationStructure.solver_position_iterations"),
    "solver_velocity_iterations": field_type("ArticulationStructure.solver_velocity_iterations"),
    "sleep_threshold": field_type("ArticulationStructure.sleep_threshold"),
}
_VELOCITIES = {key: field_type(f"ArticulationStructure.{key}") for key in ("linear_velocity", "angular_velocity")}


@dataclass(frozen=True, slots=True)
class LoweredArticulation:
    """An entity of the plan, made from an articulation in the scene file.

    Attributes:
        suffix: follows the written entity's name and a slash; "": the same name.
        pose: in the frame of the written entity, p then q; None: identity.
        structures: see `Entity`.
        pick: see `Entity`.
        root: name of its root in the file.
        constraints: of the whole file, at the first of its robots.
    """

    suffix: str
    pose: Pose7 | None
    structures: tuple[BodyStructure | ArticulationStructure, ...]
    pick: Value | None = None
    root: str = ""
    constraints: tuple[DescribedConstraint, ...] = ()


@dataclass(frozen=True, slots=True)
class _PartContext:
    """The overrides of a part, and the part's own names of its moving joints."""

    overrides: PatternOverrides
    joints: frozenset[str]


@dataclass(frozen=True, slots=True)
class _ArticulationContext:
    """One articulation from the scene file.

    Attributes:
        entity, origin, fields: the model, its node, and its field lowerer.
        still: the model for static bodies, without keys that have no effect on them.
        parts: contexts of attached parts, by id of the model.
        joints: names of all its moving joints.
        one_id: whether all its structures share one id among articulations with ignored pairs.
    """

    entity: Any
    still: Any
    origin: Origin
    fields: FieldLowerer
    maps: PatternOverrides
    parts: Mapping[int, _PartContext]
    values: OverrideValues
    targets: DriveTargetCheck
    joints: frozenset[str]
    one_id: bool

    def layers(self, section: str, name: str, link: int, draft: ArticulationDraft) -> tuple[Layer, ...]:
        """The overrides of a link or its joint, in ascending precedence. Those of parts come first.

        Args:
            section: `links`, `joints` or `drives`.
            name: of the link or the joint.
            link: number of the link.
            draft: of the articulation.
        """
        found: list[Layer] = []
        for part in reversed(draft.parts):
            if link in part:
                found += self.parts[id(part.keys)].overrides.layers(section, name[len(part.prefix) :])
        return (*found, *self.maps.layers(section, name))


class ArticulationLowerer:
    """Lowers the articulations of a document, in build order.

    Args:
        entities: of the document, by name.
        tables: receive the files and materials of robots.
        shapes: lowers shapes.
        materials: of the document.
        groups: the bits of its collision groups.
        read: reads robot files.
        sink: receives the diagnostics.
    """

    def __init__(
        self,
        entities: Mapping[str, Any],
        tables: PlanTables,
        shapes: ShapeLowerer,
        materials: MaterialLowerer,
        groups: dict[str, GroupBits],
        read: RobotReader,
        sink: Sink,
    ) -> None:
        self._trees = LinkTreeDrafter(shapes, sink)
        self._robots = RobotDrafter(tables, materials)
        self._links = LinkLowerer(groups, sink)
        self._tables = tables
        self._materials = materials
        self._read = read
        self._sink = sink
        self._matching = PatternMatcher()
        # By entity. Robots and bodies of one MJCF share an id, since its flag `contact` applies between them.
        # Alternatives share one too, since each scene has only one of them.
        self._shared: dict[int, int] = {}
        # SAPIEN's loader gives the id 0 to all.
        self._next_id = int(any(getattr(entity, "sapien_bits", None) for entity in entities.values()))

    def lower(self, entity: Any, origin: Origin, fields: FieldLowerer) -> list[LoweredArticulation]:
        """Lowers an articulation to entities of the plan; empty after an error in its file."""
        built = self._built(entity, origin, fields)
        if built:
            report_unused_keys(entity, [structure for one in built for structure in one.structures], origin, self._sink)
        return built

    def _built(self, entity: Any, origin: Origin, fields: FieldLowerer) -> list[LoweredArticulation]:
        found = read_alternatives(entity, origin, fields)
        if found is None:
            return []
        if entity.attach:
            return self._lower_assembly(entity, origin, found, fields)
        if "root" in entity.model_fields_set:
            draft = self._trees.draft(entity.root, origin.child("root"), fields)
            work = self._make_context(entity, origin, fields, [draft], one_id=True)
            each = [replace(draft, fixed=one.values.get("fix_root_link")) for one in found.each]
            return [LoweredArticulation("", None, tuple(self._structure(one, work) for one in each), found.pick)]
        self._report_unused_decomposition(entity, origin)
        key = "urdf" if "urdf" in entity.model_fields_set else "mjcf"
        files = [self._file(key, entity, one) for one in found.each]
        drafts = [
            [(robot, self._draft(robot, file[0], entity, one, key, fields)) for robot in file[1].robots]
            for file, one in zip(files, found.each, strict=True)
            if file is not None
        ]
        if len(drafts) < len(files):
            return []
        every = [draft for robots in drafts for _, draft in robots]
        work = self._make_context(entity, origin, fields, every, one_id=key == "mjcf" or found.pick is not None)
        if found.pick is not None:
            return self._alternatives(drafts, found.pick, work, origin.child(key))
        self._warn_of_free_root(drafts, entity)
        ((alone, *others),) = drafts
        if not others and alone[0].pose == IDENTITY_POSE:
            root = alone[1].links[0].name
            made = [LoweredArticulation("", None, (self._make_structure(*alone, work),), root=root)]
        else:
            made = [
                LoweredArticulation(
                    root := draft.links[0].name, robot.pose, (self._make_structure(robot, draft, work),), root=root
                )
                for robot, draft in drafts[0]
            ]
        constraints = files[0][1].constraints if files[0] is not None else ()
        if constraints and entity.body_type is not None:
            message = f"the file connects its bodies, which has no effect: all of them are {entity.body_type}"
            self._sink.report("SC333", message, origin.child(key))
            constraints = ()
        return [replace(made[0], constraints=constraints), *made[1:]]

    def _lower_assembly(
        self, entity: Any, origin: Origin, found: Alternatives, fields: FieldLowerer
    ) -> list[LoweredArticulation]:
        """Lowers an entity with parts to one articulation."""

        def draft(keys: Any, place: Origin, one: Alternative) -> Assembly | None:
            return self._single_assembly(keys, place, one, fields)

        assembler = ArticulationAssembler(self._trees, draft, fields, self._sink)
        made = [assembler.assemble(entity, origin, one) for one in found.each]
        whole = [one for one in made if one is not None]
        if len(whole) < len(made):
            return []
        if found.pick is not None and any(one.constraints or one.pose != IDENTITY_POSE for one in whole):
            message = "files that differ from scene to scene cannot have welds, connections or a pose of the root"
            hint = "declare an entity for each file, with `scene_idxs` of its own"
            self._sink.report("SC327", message, origin, at="key", hint=hint)
            return []
        fixed = "root" not in entity.model_fields_set
        drafts = [
            replace(
                made.draft,
                fixed=bool(one.values.get("fix_root_link", fixed if made.draft.fixed is None else made.draft.fixed)),
            )
            for made, one in zip(whole, found.each, strict=True)
        ]
        work = self._make_context(entity, origin, fields, drafts, one_id=True)
        structures = tuple(self._structure(draft, work) for draft in drafts)
        pose = None if whole[0].pose == IDENTITY_POSE else whole[0].pose
        root = drafts[0].links[0].name
        return [LoweredArticulation(root, pose, structures, found.pick, constraints=whole[0].constraints)]

    def _single_assembly(self, keys: Any, origin: Origin, one: Alternative, fields: FieldLowerer) -> Assembly | None:
        """The only articulation in the file of an articulation or a part; None after an error."""
        self._report_unused_decomposition(keys, origin)
        key = "urdf" if "urdf" in keys.model_fields_set else "mjcf"
        file = self._file(key, keys, one)
        if file is None:
            return None
        robot, *others = file[1].robots
        place = one.places[key]
        if others or robot.body_type in {"static", "kinematic"}:
            what = f"{len(others) + 1} robots or bodies" if others else "a body that does not move"
            hint = "write the part into a file of its own, with a joint or a `<freejoint/>`"
            self._sink.report(
                "SC336", f"this file contains {what}, but `attach` needs one articulation", place, hint=hint
            )
            return None
        if "to" in keys.model_fields_set:
            self._drop_root_motion(robot, place)
        constraints = tuple(
            replace(one, parent=("", one.parent[1]), child=("", one.child[1])) for one in file[1].constraints
        )
        return Assembly(self._draft(robot, file[0], keys, one, key, fields), constraints, robot.pose)

    def _drop_root_motion(self, robot: DescribedRobot, place: Origin) -> None:
        """Reports root settings in a part's file, which are ignored."""
        where = place if robot.location is None else place.into(robot.location)
        if robot.fixed is False:
            message = "the free joint of this root is ignored: the root is attached to `to`"
            self._sink.report("SC337", message, where)
        if robot.pose != IDENTITY_POSE:
            message = "the pose of this root is ignored: `pose` or `joint` of the part replaces it"
            self._sink.report("SC337", message, where)

    def _file(
        self, key: Literal["urdf", "mjcf"], entity: Any, one: Alternative
    ) -> tuple[AssetFile, RobotDescription] | None:
        """Reads a robot file; None after an error."""
        values = one.values
        groups = getattr(entity, "visual_groups", None)
        request = RobotRequest(
            key,
            values[key],
            srdf=values.get("srdf"),
            package_dir=values.get("package_dir"),
            scale=values.get("scale", 1.0),
            collision_is_visual=bool(getattr(entity, "collision_is_visual", None)),
            repair=frozenset(getattr(entity, "repair", None) or ()),
            keyframe=values.get("keyframe"),
            visual_groups=None if groups is None else tuple(groups),
        )
        return self._read(request, one.places)

    def _alternatives(
        self,
        drafts: list[list[tuple[DescribedRobot, ArticulationDraft]]],
        pick: Value,
        work: _ArticulationContext,
        origin: Origin,
    ) -> list[LoweredArticulation]:
        """Makes one structure per alternative of the file."""
        kinds = {work.entity.body_type is None and robots[0][0].body_type is None for robots in drafts}
        if len(kinds) > 1 or any(len(robots) > 1 or robots[0][0].pose != IDENTITY_POSE for robots in drafts):
            message = "if files differ from scene to scene, each must contain one articulation, or each one body"
            message += f"; {_misfit_of(drafts)}"
            hint = "declare the robots of such a file as separate entities"
            self._sink.report("SC327", message, origin, hint=hint)
            return []
        self._warn_of_free_root(drafts, work.entity)
        return [LoweredArticulation("", None, tuple(self._make_structure(*robots[0], work) for robots in drafts), pick)]

    def _warn_of_free_root(self, drafts: list[list[tuple[DescribedRobot, ArticulationDraft]]], entity: Any) -> None:
        """Warns of a free root of a URDF, which has no key for it: only its joints show whether it is fixed."""
        if "urdf" in entity.model_fields_set and entity.fix_root_link is None and entity.body_type is None:
            warn_free_body([robots[0] for robots in drafts], self._sink)

    def _draft(
        self, robot: DescribedRobot, file: AssetFile, entity: Any, one: Alternative, key: str, fields: FieldLowerer
    ) -> ArticulationDraft:
        index, origin = self._tables.files.value(file), one.places[key]
        self._tables.file_origins.setdefault(int(index.numbers()[0]), origin)
        draft = self._robots.draft(robot, entity, index, origin, fields)
        pairing = one.places.get("srdf", origin)
        fixed = one.values.get("fix_root_link", draft.fixed)
        return replace(draft, fixed=fixed is None or fixed, ignored=dict(enumerate(map(pairing.into, robot.ignored))))

    def _make_context(
        self, entity: Any, origin: Origin, fields: FieldLowerer, drafts: list[ArticulationDraft], *, one_id: bool
    ) -> _ArticulationContext:
        maps = PatternOverrides(entity, origin, self._matching, self._sink)
        maps.check(drafts)
        parts: dict[int, _PartContext] = {}
        for part in (part for draft in drafts for part in draft.parts):
            if id(part.keys) not in parts:
                alone = [other.draft for draft in drafts for other in draft.parts if other.keys is part.keys]
                overrides = PatternOverrides(part.keys, part.origin, self._matching, self._sink)
                overrides.check(alone)
                parts[id(part.keys)] = _PartContext(overrides, _list_moving_names(alone))
        targets = DriveTargetCheck(fields, self._sink, beyond_limits=bool(entity.beyond_limits))
        # Copied once, since values are cached by model.
        still = entity.model_copy(update={"gravity": None})
        return _ArticulationContext(
            entity,
            still,
            origin,
            fields,
            maps,
            parts,
            OverrideValues(self._materials, fields),
            targets,
            _list_moving_names(drafts),
            one_id,
        )

    def _report_unused_decomposition(self, entity: Any, origin: Origin) -> None:
        """Reports decomposition keys that have no effect."""
        decomposes = getattr(entity, "decomposition", None) == "coacd"
        for key, does_nothing, without in (
            ("decomposition", decomposes and not entity.load_multiple_collisions, "load_multiple_collisions: true"),
            ("decomposition_params", not decomposes, "decomposition: coacd"),
        ):
            if does_nothing and getattr(entity, key, None) is not None:
                report_unused_key(key, f"without `{without}`", origin, self._sink, hint=f"add `{without}`")

    def _make_structure(
        self, robot: DescribedRobot, draft: ArticulationDraft, work: _ArticulationContext
    ) -> BodyStructure | ArticulationStructure:
        if robot.ignores_alone:
            # It gets an id of its own.
            self._shared.pop(id(work.entity), None)
        if robot.body_type is None:
            return self._structure(draft, work)
        return self._body(work.entity.body_type or robot.body_type, draft, work)

    def _body(self, body_type: BodyType, draft: ArticulationDraft, work: _ArticulationContext) -> BodyStructure:
        """Lowers a robot with a single body."""
        values, (link,) = work.values, draft.links
        moves = body_type == "dynamic"
        # Keys for the whole file apply only to articulations on which they have an effect.
        layers = ((work.entity if moves else work.still, work.origin), *work.maps.layers("links", link.name))
        ignored = link.ignore_bits
        body = self._links.body(link, layers, self._id(work) if ignored else 0, 0, values)
        # A robot file may have a mass without shapes, and a mocap body that only holds another.
        is_empty = not body.collisions and not body.visuals
        if not moves:
            shapeless = (is_empty and body_type == "kinematic") or None
            inertial = None if body.inertial is link.inertial else body.inertial
            return replace(body, body_type=body_type, inertial=inertial, shapeless=shapeless)
        shapeless = (is_empty and body.inertial is not None) or None
        return replace(body, body_type=body_type, shapeless=shapeless, **self._solver_values(work, fixed=False))

    def _structure(self, draft: ArticulationDraft, work: _ArticulationContext) -> BodyStructure | ArticulationStructure:
        """Lowers a robot: an articulation, or one body of all its links if the entity has a `body_type`."""
        made, body_type = self._articulation(draft, work), work.entity.body_type
        return made if body_type is None else fuse_links(made, body_type, work.fields, self._sink)

    def _articulation(self, draft: ArticulationDraft, work: _ArticulationContext) -> ArticulationStructure:
        entity, origin, values = work.entity, work.origin, work.values
        joints: list[DraftJoint | None] = [
            link.joint and with_overrides(link.joint, work.layers("joints", link.joint.name, number, draft), values)
            for number, link in enumerate(draft.links)
        ]
        starts = self._starts(draft, joints, work)
        whole = (entity, origin)
        ignored = _IGNORE_ALL_BIT if entity.disable_self_collisions else 0
        own = self._id(work) if ignored or any(link.ignore_bits for link in draft.links) else 0
        mimics = _mimics(joints)
        coupled = {name for mimic in mimics for name in (mimic.joint, mimic.source)}
        links: list[Link] = []
        lost: list[LostForce] = []
        bits: dict[int, Origin] = {}
        for index, (link, joint) in enumerate(zip(draft.links, joints, strict=True)):
            patterns = work.layers("links", link.name, index, draft)
            layers = (whole, *patterns, *(() if link.own is None else (link.own,)))
            body = self._links.body(link, layers, own, ignored, values)
            grouped = nearest_override(layers, "collision_bits", "collision_group")
            if grouped is not None and getattr(grouped[0], "collision_bits", None) is not None:
                bits[index] = grouped[1].child("collision_bits")
            elif link.own is not None and (place := shape_bits_origin(body)) is not None:
                bits[index] = place
            made = None
            if joint is not None:
                drives = work.layers("drives", joint.name, index, draft) if joint.moves else ()
                made = lower_joint(joint, drives, starts.get(index, (None, None)), values, work.targets)
                made, without = with_friction_force(made, joint, drives)
                # A body of all links has no joints.
                lost += [] if without is None or entity.body_type is not None else [without]
                made = with_counted_turns(made, is_coupled=joint.name in coupled)
            links.append(Link(link.name, body, link.parent, made, link.file))
        _report_lost_forces(lost, self._sink)
        if bits:
            alike = origin.child("disable_self_collisions") if ignored else None
            warn_ignored_pairs_collide(draft, [link.body for link in links], bits, alike, self._sink)
        structure = ArticulationStructure(
            links=tuple(links),
            fix_root_link=bool(draft.fixed),
            mimics=mimics,
            file=draft.file,
            origin=origin,
            **self._solver_values(work, fixed=bool(draft.fixed)),
        )
        return self._lift_velocity_limits(structure, draft, work) if structure.mimics else structure

    def _lift_velocity_limits(
        self, structure: ArticulationStructure, draft: ArticulationDraft, work: _ArticulationContext
    ) -> ArticulationStructure:
        """Lifts velocity limits from the joints of soft tendons, with a warning where the scene sets them.

        PhysX clamps one joint after the other, within the solver's iterations. What it takes from the first then
        differs from what the tendon gave it, so two light links diverge.
        """
        soft = {name for mimic in soft_mimics(structure) for name in (mimic.joint, mimic.source)}
        links = list(structure.links)
        for number, (link, own) in enumerate(zip(structure.links, draft.links, strict=True)):
            joint = link.joint
            if joint is None or own.joint is None or joint.name not in soft:
                continue
            written = nearest_override(work.layers("joints", joint.name, number, draft), "max_velocity")
            from_file = draft.file is not None or own.file is not None
            if written is not None or (not from_file and joint.max_velocity is not None):
                place = own.joint.origin if written is None else written[1]
                name = cut(joint.name)
                message = f"PhysX limits the speed of `{name}` against the spring of a mimic joint, and may diverge"
                hint = "remove `max_velocity`, or limit the force of the source's drive"
                self._sink.report("SC579", message, place.child("max_velocity"), hint=hint)
                continue
            links[number] = replace(link, joint=replace(joint, max_velocity=constant(UNLIMITED_VELOCITY)))
        return replace(structure, links=tuple(links))

    def _starts(
        self, draft: ArticulationDraft, joints: list[DraftJoint | None], work: _ArticulationContext
    ) -> dict[int, tuple[Value | None, Value | None]]:
        """The initial position and velocity of each moving joint, by number of its link."""
        entity, origin, fields = work.entity, work.origin, work.fields
        order = draft.moving()
        moving = [joint for i in order if (joint := joints[i]) is not None]
        numbers = JointNumbers([joint.name for joint in moving], work.joints, origin, fields, self._sink)
        starts = InitialStateLowerer(moving, fields, origin, self._sink, beyond_limits=bool(entity.beyond_limits))
        found = self._starts_of_parts(draft, order, work) | numbers.of(entity.qpos, "qpos")
        written = [entity, *(part.keys for part in draft.parts)]
        quiet = not found and any(keys.qpos is not None for keys in written)
        positions = starts.positions(found, all_of_them=any(keys.drives for keys in written), quiet=quiet)
        velocities = starts.velocities(numbers.of(entity.qvel, "qvel"))
        return dict(zip(order, zip(positions, velocities, strict=True), strict=True))

    def _starts_of_parts(
        self, draft: ArticulationDraft, order: list[int], work: _ArticulationContext
    ) -> dict[int, JointValue]:
        """The initial joint positions from the keys of parts, by number of the joint in the whole."""
        found: dict[int, JointValue] = {}
        places = {link: number for number, link in enumerate(order)}
        for part in reversed(draft.parts):
            own = part.draft.moving()
            names = [joint.name for link in own if (joint := part.draft.links[link].joint) is not None]
            others = work.parts[id(part.keys)].joints
            given = JointNumbers(names, others, part.origin, work.fields, self._sink).of(part.keys.qpos, "qpos")
            found |= {places[part.start + own[number]]: value for number, value in given.items()}
        return found

    @staticmethod
    def _solver_values(work: _ArticulationContext, *, fixed: bool) -> dict[str, Value | None]:
        found = {
            key: work.fields.optional(getattr(work.entity, key), kind, work.origin, key, reset=key in _VELOCITIES)
            for key, kind in (*_SOLVER.items(), *_VELOCITIES.items())
        }
        # A root that is fixed in some scenes has no velocity there.
        return {**found, **dict.fromkeys(_VELOCITIES)} if fixed else found

    def _id(self, work: _ArticulationContext) -> int:
        """The fourth collision integer, which separates the ignored pairs of different articulations."""
        entity = work.entity
        if entity.sapien_bits:
            return 0
        if work.one_id and id(entity) in self._shared:
            return self._shared[id(entity)]
        number = self._next_id
        self._next_id += 1
        if number == COLLISION_ID_BITS + 1:
            message = (
                f"PhysX can distinguish {number} articulations whose links ignore one another, and this is one more"
            )
            hint = "remove `disable_self_collisions` or the SRDF of some of them"
            self._sink.report("SC519", message, work.origin, at="key", hint=hint)
        # With too many articulations, building the scene is an error anyway.
        self._shared[id(entity)] = number if number <= COLLISION_ID_BITS else 0
        return self._shared[id(entity)]


def _list_moving_names(drafts: Iterable[ArticulationDraft]) -> frozenset[str]:
    joints = (link.joint for draft in drafts for link in draft.links)
    return frozenset(joint.name for joint in joints if joint is not None and joint.moves)


def _mimics(joints: list[DraftJoint | None]) -> tuple[Mimic, ...]:
    return tuple(
        Mimic(joint.name, mimic.source, mimic.multiplier, mimic.offset, mimic.origin)
        for joint in joints
        if joint is not None and (mimic := joint.mimic) is not None
    )


def _report_lost_forces(lost: Sequence[LostForce], sink: Sink) -> None:
    """Reports frictions and dampings that are not built, one finding for each code."""
    for code in dict.fromkeys(code for code, _, _ in lost):
        (message, place), *others = [(message, place) for other, message, place in lost if other == code]
        more = f" (and those of {len(others)} other joint{'s' if len(others) > 1 else ''})" if others else ""
        hint = "PhysX has one drive for each joint: a spring, a damper, an actuator or a friction; keep one"
        sink.report(code, message + more, place, hint=hint)


def _misfit_of(drafts: list[list[tuple[DescribedRobot, ArticulationDraft]]]) -> str:
    """Returns which of several files cannot be one entity with the others, and why."""
    for robots in drafts:
        robot, file = robots[0][0], cut(robots[0][0].links[0].location.file or "")
        if len(robots) > 1:
            return f"`{file}` contains {len(robots)}"
        if robot.pose != IDENTITY_POSE:
            return f"`{file}` gives its root a pose"
    body = next(robots[0][0] for robots in drafts if robots[0][0].body_type is not None)
    return f"`{cut(body.links[0].location.file or '')}` contains one body"
