"""Lowers a document's models to the plan of its scenes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.frozen import frozen
from scenecc.lower.collision_groups import GroupBits, assign_group_bits
from scenecc.lower.draws import lower_draws, report_unused_draws
from scenecc.lower.entities import BodyLowerer, EntityLowerer
from scenecc.lower.fields import fields_of
from scenecc.lower.materials import SAPIEN_DEFAULT, MaterialLowerer
from scenecc.lower.references import FileResolver, MeshReader, PlanTables, RobotReader, RobotRequest
from scenecc.lower.sampling import SamplingContext
from scenecc.lower.shapes import ShapeLowerer
from scenecc.lower.value_checks import report_draw_failure
from scenecc.plan import ScenePlan
from scenecc.plan.body import AssetFile, Friction
from scenecc.plan.scene import GpuMemory, Physics, SdfConfig
from scenecc.spec.body import BodySpec
from scenecc.spec.references import SHARED_NAMESPACE, WORLD, NameScopes, count_scene_idxs, qualified_name
from scenecc.variation.operations import ComputeLimitError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.lower.articulations.articulations import ArticulationLowerer
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.rendering import RenderObjects
    from scenecc.plan import Constraint, Entity, Placement
    from scenecc.plan.expect import Expectation
    from scenecc.robots.description import RobotDescription
    from scenecc.source import Limits
    from scenecc.spec.document import SceneFile
    from scenecc.spec.physics import PhysicsSpec as PhysicsKeys
    from scenecc.variation.chosen import DrawRecord


def check_limits(
    scene: SceneFile,
    num_scenes: int,
    selections: Mapping[str, tuple[int, ...]],
    bounds: Limits,
    origin: Origin,
    sink: Sink,
) -> bool:
    """Whether a document is within the limits; otherwise reports it."""
    if not _check_limit("SC605", "scenes", num_scenes, bounds.scenes, origin.child("num_scenes"), sink):
        return False
    if not all(
        _check_parts(entity, origin.child("entities", name), sink)
        for name, entity in scene.entities.items()
        if getattr(entity, "attach", None)
    ):
        return False
    shapes = {name: _entity_size(entity) for name, entity in scene.entities.items()}
    others = [*scene.constraints.values(), *scene.lights.values(), *scene.cameras.values()]
    built = sum(
        shapes[name]
        * (len(selections[name]) if name in selections else count_scene_idxs(entity.scene_idxs, num_scenes))
        for name, entity in scene.entities.items()
    )
    # Constraints, lights and cameras of an instance with fewer scenes count as if they were in all scenes.
    built += sum(count_scene_idxs(other.scene_idxs, num_scenes) for other in others)
    return _check_objects(sum(shapes.values()) + len(others), built, bounds, origin, sink)


def check_built_limits(entities: Sequence[Entity], bounds: Limits, origin: Origin, sink: Sink) -> bool:
    """Whether the built objects, including those of robot files, are within the limits; otherwise reports it."""
    counts = [
        max(sum(1 + len(body.collisions) + len(body.visuals) for body in one.bodies) for one in entity.structures)
        for entity in entities
    ]
    built = sum(count * len(entity.scene_idxs) for count, entity in zip(counts, entities, strict=True))
    return _check_objects(sum(counts), built, bounds, origin, sink)


def _check_objects(objects: int, built: int, bounds: Limits, origin: Origin, sink: Sink) -> bool:
    """Whether the number of objects, and their number in all scenes together, are within the limits."""
    if not _check_limit("SC604", "objects", objects, bounds.objects, origin.child("entities"), sink):
        return False
    most = bounds.objects_in_all_scenes
    if built > most:
        message = f"{built} objects in all scenes are more than {most}"
        hint = f"build fewer scenes; --limit objects=N allows {most // bounds.objects} times N in all scenes"
        sink.report("SC604", message, origin.child("num_scenes"), hint=hint)
    return built <= most


class LimitedRobotReader:
    """Reads robot files until their objects, counted once per use, exceed a limit.

    The exact count comes after lowering, too late for a small file that requests billions of objects.

    Attributes:
        exhausted: whether the limit was exceeded and reported (SC604). No more files are read.

    Args:
        read: reads them.
        most: limit of objects.
        sink: receives the diagnostic.
    """

    def __init__(self, read: RobotReader, most: int, sink: Sink) -> None:
        self._read = read
        self._most = most
        self._sink = sink
        self._count = 0
        # Keeping the description keeps its id unique.
        self._sizes: dict[int, tuple[RobotDescription, int]] = {}
        self.exhausted = False

    def read(self, request: RobotRequest, places: Mapping[str, Origin]) -> tuple[AssetFile, RobotDescription] | None:
        """Reads a robot file. Implements `RobotReader`."""
        if self.exhausted:
            return None
        found = self._read(request, places)
        if found is None:
            return None
        description = found[1]
        if id(description) not in self._sizes:
            self._sizes[id(description)] = description, _description_size(description)
        self._count += self._sizes[id(description)][1]
        if self._count <= self._most:
            return found
        self.exhausted = True
        message = f"at least {self._count} objects are more than the limit of {self._most}"
        hint = "raise it with --limit objects=N or limits={'objects': N}"
        self._sink.report("SC604", message, places[request.format], hint=hint)
        return None


def _description_size(description: RobotDescription) -> int:
    """Number of links and shapes in a robot file."""
    links = (link for robot in description.robots for link in robot.links)
    return sum(1 + len(link.collisions) + len(link.visuals) for link in links)


def _entity_size(entity: Any) -> int:
    if entity.__class__ is BodySpec:
        return max(1, _shape_count(entity))
    if "variants" in entity.__class__.model_fields:
        # The worst case: the largest variant is in every scene.
        return max(1, *(_shape_count(entity) + _shape_count(variant) for variant in entity.variants))
    found, waiting = 0, [entity]
    while waiting:
        keys = waiting.pop()
        root = getattr(keys, "root", None)
        # The size of a robot file is known only after reading it.
        found += 1 if root is None else _tree_size(root)
        waiting += getattr(keys, "attach", {}).values()
    return found


def _check_parts(entity: Any, origin: Origin, sink: Sink) -> bool:
    """Whether the parts of an articulation are within the limit; otherwise reports it."""
    from scenecc.plan.articulation import MAX_LINKS  # noqa: PLC0415 - loaded where there are articulations

    waiting = [entity]
    for keys in waiting:
        if len(waiting) > MAX_LINKS:
            message = f"at least {len(waiting)} parts are more than the {MAX_LINKS} links of an articulation"
            sink.report("SC519", message, origin, at="key", hint="merge parts, or remove some")
            return False
        waiting += keys.attach.values()
    return True


def _tree_size(root: Any) -> int:
    """Number of links and shapes in a tree."""
    found, waiting = 0, [root]
    while waiting:
        link = waiting.pop()
        found += 1 + _shape_count(link)
        waiting += link.children
    return found


def _shape_count(body: Any) -> int:
    return len(body.shapes) + len(body.collisions) + len(body.visuals)


def _check_limit(code: str, what: str, number: int, limit: int, place: Origin, sink: Sink) -> bool:
    if number <= limit:
        return True
    hint = f"raise it with --limit {what}={number} or limits={{'{what}': {number}}}"
    sink.report(code, f"{number} {what} are more than the limit of {limit}", place, hint=hint)
    return False


@frozen
class Lowered:
    """A plan, with the data for its placements, recipes and checks.

    Attributes:
        plan: without recipes, and without the poses of placements.
        material_origins: for each physical material, the first place that uses it.
        sampling: the draws, and the checks that wait for placements.
        frames: poses of its entities.
    """

    plan: ScenePlan
    material_origins: Mapping[int, Origin]
    sampling: SamplingContext
    frames: FrameGraph


def lower(
    scene: SceneFile,
    *,
    name: str,
    num_scenes: int,
    seed: int,
    origin: Origin,
    resolve: FileResolver,
    robots: RobotReader,
    bounds: Limits,
    sink: Sink,
    vertices: MeshReader,
    names: NameScopes,
    selections: Mapping[str, tuple[int, ...]],
    draws: Mapping[str, Any],
    record: DrawRecord | None = None,
) -> Lowered | None:
    """Lowers a document to a plan, and draws its values; None after an error. Placing is left to `complete`.

    Args:
        scene: the expanded document.
        name: of the plan, if the document has none.
        num_scenes: number of scenes; the document's unless overridden.
        seed: of every draw; the document's unless overridden.
        origin: of the document's root.
        resolve: finds its files.
        robots: reads robot files.
        bounds: limits.
        sink: receives the diagnostics.
        vertices: reads the vertices of meshes, for anchors.
        names: resolves names, if it has instances.
        selections: the scenes of entities and frames in instances with fewer scenes.
        draws: arrays, (num_scenes,) or (num_scenes, k), that replace shared draws.
        record: numbers that replace random ones; receives what is drawn.
    """
    if not check_limits(scene, num_scenes, selections, bounds, origin, sink):
        return None
    _check_names(scene, origin, sink)
    sampling = SamplingContext(seed, num_scenes, sink, bounds.objects_in_all_scenes, record)
    lower_draws(scene.draws, draws, sampling, names, selections, origin.child("draws"))
    physics = _lower_physics(scene.physics, origin.child("physics"))
    tables = PlanTables(resolve)
    default = physics.default_material or SAPIEN_DEFAULT
    materials = MaterialLowerer(scene.materials, tables, default, origin.child("materials"), sink)
    groups = assign_group_bits(scene.collision_groups, origin.child("collision_groups"), sink)
    shapes = ShapeLowerer(tables, materials, sink)
    bounded = LimitedRobotReader(robots, bounds.objects, sink)
    articulations = partial(_articulation_lowerer, scene, tables, shapes, materials, groups, bounded.read, sink)
    entities = EntityLowerer(scene, selections, sampling, names, origin, sink)
    entities.frames.vertices = lambda index, place: vertices(tables.files.rows[index], place)
    built = entities.lower(BodyLowerer(shapes, materials, groups, sink), articulations)
    if bounded.exhausted or not check_built_limits(entities.linked, bounds, origin, sink):
        return None
    sections = _SectionLowerer(scene, origin, names, selections, sampling, tables, materials, entities, built)
    plan = sections.plan(name, physics)
    if _is_exhausted(sampling, origin):
        return None
    _report_unused(scene, materials, sampling, names, origin)
    if sink.failed:
        return None
    return Lowered(tables.fill(plan), tables.material_origins, sampling, entities.frames)


def _report_unused(
    scene: SceneFile, materials: MaterialLowerer, sampling: SamplingContext, names: NameScopes, origin: Origin
) -> None:
    # A material may be unused only because of a misspelt reference.
    if not sampling.sink.failed:
        materials.report_unused(frozenset(names.used_materials), fields_of(sampling))
    # Last, since an unused material may read a draw.
    report_unused_draws(scene.draws, sampling, names, origin.child("draws"))


def _is_exhausted(sampling: SamplingContext, origin: Origin) -> bool:
    """Whether computing the varying values exceeds the limit, which is reported."""
    if sampling.sampling_operations.exhausted:
        sampling.report_limit(sampling.sampling_operations.message, origin)
    return sampling.sampling_operations.exhausted


def complete(lowered: Lowered, sink: Sink) -> ScenePlan | None:
    """Places what is placed, and adds the recipes of what a reset redraws; None after an error.

    Args:
        lowered: result of `lower` without errors.
        sink: receives the diagnostics; each names the scene.
    """
    if not lowered.sampling.varies:
        return lowered.plan
    try:
        return _place_and_add_recipes(lowered, sink)
    except ComputeLimitError as error:
        report_draw_failure(error, lowered.plan.origin or Origin(None), lowered.sampling)
        return None


def _place_and_add_recipes(lowered: Lowered, sink: Sink) -> ScenePlan | None:
    from scenecc.lower.resets import RecipeBuilder  # noqa: PLC0415 - loaded where something varies

    plan, sampling = lowered.plan, lowered.sampling
    recipes = RecipeBuilder(sampling, lowered.frames)
    recipes.keep_draws(plan.expectations)
    if plan.placements:
        from scenecc.lower.placements import place_as_built  # noqa: PLC0415 - loaded where there are any

        plan = replace(plan, placements=tuple(map(recipes.placement, plan.placements)))
        place_as_built(plan, sampling, lowered.frames, sink)
        if sink.failed:
            return None
    for check in sampling.unplaced:
        check()
    if sink.failed:
        return None
    entities = tuple(map(recipes.entity, plan.entities))
    return replace(
        plan,
        entities=entities,
        constraints=tuple(map(recipes.holder, plan.constraints)),
        environment=recipes.holder(plan.environment),
        lights=tuple(recipes.follower(qualified_name("lights", one.name), one) for one in plan.lights),
        cameras=tuple(recipes.follower(one.name, one) for one in plan.cameras),
        physical_materials=tuple(map(recipes.holder, plan.physical_materials)),
        visual_materials=tuple(map(recipes.holder, plan.visual_materials)),
        # Last, since these are the draws that the others read.
        draws=recipes.draws(),
    )


def _articulation_lowerer(
    scene: SceneFile,
    tables: PlanTables,
    shapes: ShapeLowerer,
    materials: MaterialLowerer,
    groups: dict[str, GroupBits],
    robots: RobotReader,
    sink: Sink,
) -> ArticulationLowerer:
    from scenecc.lower.articulations.articulations import ArticulationLowerer  # noqa: PLC0415 - loaded where there are any

    return ArticulationLowerer(scene.entities, tables, shapes, materials, groups, robots, sink)


@frozen
class _SectionLowerer:
    """Lowers the sections of a document that refer to its lowered entities.

    Attributes:
        scene, origin, names, selections: see `lower`.
        sampling, tables, materials: of the plan.
        entities: has lowered `built`.
        built: entities of the plan.
    """

    scene: SceneFile
    origin: Origin
    names: NameScopes
    selections: Mapping[str, tuple[int, ...]]
    sampling: SamplingContext
    tables: PlanTables
    materials: MaterialLowerer
    entities: EntityLowerer
    built: tuple[Entity, ...]

    def plan(self, name: str, physics: Physics) -> ScenePlan:
        """The plan without files and materials, which are added last. `name`: if the document has none."""
        seen = self._lower_rendering()
        return ScenePlan(
            name=self.scene.name or name,
            description=self.scene.description,
            num_scenes=self.sampling.num_scenes,
            seed=self.sampling.seed,
            entities=self.built,
            constraints=self._constraints(),
            placements=self._placements(),
            expectations=self._expectations(),
            environment=None if seen is None else seen.environment,
            lights=() if seen is None else seen.lights,
            cameras=() if seen is None else seen.cameras,
            physics=physics,
            origin=self.origin,
        )

    def _lower_rendering(self) -> RenderObjects | None:
        scene = self.scene
        if scene.environment is None and not scene.lights and not scene.cameras:
            return None
        from scenecc.lower.rendering import lower_render_objects  # noqa: PLC0415 - loaded where there are any

        fields = fields_of(self.sampling)
        return lower_render_objects(
            scene, self.built, self.entities, self.names, self.tables, self.materials, fields, self.origin, fields.sink
        )

    def _constraints(self) -> tuple[Constraint, ...]:
        if not self.scene.constraints and not self.entities.constraints:
            return ()
        from scenecc.lower.constraints import ConstraintLowerer  # noqa: PLC0415 - loaded where there are any
        from scenecc.lower.mounts import MountLookup  # noqa: PLC0415 - see above

        sink = self.sampling.sink
        mounts = MountLookup(self.built, self.entities.frames.unread, self.names, sink)
        lowering = ConstraintLowerer(self.built, self.entities, mounts, self.sampling, self.names, sink)
        return lowering.lower(self.scene.constraints, self.origin.child("constraints")) + lowering.describe()

    def _placements(self) -> tuple[Placement, ...]:
        nodes = (*self.scene.entities.values(), *self.scene.frames.values())
        if all(getattr(node, "place", None) is None for node in nodes):
            return ()
        from scenecc.lower.placements import PlacementLowerer  # noqa: PLC0415 - loaded where there are any

        return PlacementLowerer(self.scene, self.built, self.entities, self.names, self.origin).lower()

    def _expectations(self) -> tuple[Expectation, ...]:
        if self.scene.expect is None:
            return ()
        from scenecc.lower.expect import lower_expectations  # noqa: PLC0415 - loaded where there are any

        place, unread = self.origin.child("expect"), self.entities.frames.unread
        return lower_expectations(
            self.scene.expect, self.built, unread, self.sampling, self.names, self.selections, place
        )


def _check_names(scene: SceneFile, origin: Origin, sink: Sink) -> None:
    """Checks that frames, entities and cameras have unique names, and none is called like the world."""
    sections: dict[str, Mapping[str, Any]] = {section: getattr(scene, section) for section in _SECTION_WORDS}
    for section, names in sections.items():
        if WORLD in names:
            sink.report("SC306", "`world` is reserved for the world frame", origin.child(section, WORLD), at="key")
    for first, second in combinations(SHARED_NAMESPACE, 2):
        for name in sections[first].keys() & sections[second].keys():
            sink.report(
                "SC305",
                f"`{name}` names {_SECTION_WORDS[first]} and {_SECTION_WORDS[second]}",
                origin.child(second, name),
                at="key",
                related=[(f"the {_SECTION_WORDS[first].partition(' ')[2]}", origin.child(first, name), "key")],
            )


_SECTION_WORDS = {
    "frames": "a frame",
    "entities": "an entity",
    "cameras": "a camera",
    "constraints": "a constraint",
    "lights": "a light",
}
"""Word for an object of each section."""


def _lower_physics(given: PhysicsKeys | None, origin: Origin) -> Physics:
    """Copies the physics keys to the plan. Omitted keys stay None."""
    if given is None:
        return Physics(origin=origin)
    values = {name: getattr(given, name) for name in type(given).model_fields}
    if given.default_material is not None:
        values["default_material"] = Friction(**given.default_material.model_dump())
    if given.sdf is not None:
        values["sdf"] = SdfConfig(**given.sdf.model_dump())
    if given.gpu_memory is not None:
        values["gpu_memory"] = GpuMemory(**given.gpu_memory.model_dump())
    return Physics(**values, origin=origin)
