"""Audit of a whole batch: entities by order, name and pose, and the objects that render.

Says which bodies are read how closely, and gives differences as diagnostics.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from scenecc.backends.sapien.audit.articulations import ArticulationAudit, center_of_mass_reach, link_poses
from scenecc.backends.sapien.audit.bodies import BodyAudit, compare_bodies, expected_texture
from scenecc.backends.sapien.audit.comparison import (
    AUDIT_CODE,
    BatchComparison,
    BodyLocation,
    DifferenceGroups,
    EngineDifference,
    format_value,
    is_same,
)
from scenecc.backends.sapien.audit.reference import ReferenceMeshes, cooking_differences, scene_differences
from scenecc.backends.sapien.cameras import camera_values, rows_by_scene
from scenecc.backends.sapien.engine import render, sapien
from scenecc.backends.sapien.live_properties import ANGLE_TOLERANCE
from scenecc.backends.sapien.preparation import PreparedArticulation
from scenecc.backends.sapien.properties import select_rows
from scenecc.backends.sapien.rendering import LIGHT_CLASSES, light_values
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.rendering import Camera, Orthographic, Perspective, TexturedLight

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.reference import EngineDefaults
    from scenecc.backends.sapien.batch import SceneBatch
    from scenecc.backends.sapien.cameras import RenderComponentBatch
    from scenecc.backends.sapien.preparation import EntityLookup, PreparedEntity
    from scenecc.backends.sapien.rendering import LightsAndCameras
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.rendering import Light


def audit_rendering(plan: ScenePlan, rendering: LightsAndCameras, lookup: EntityLookup, sink: Sink) -> bool:
    """Compares what pictures need with the plan, reports every difference, and says whether there is none.

    To be called before the first picture, which may bring lights and a camera of its own.
    """
    groups = DifferenceGroups(sink)
    for number, index in enumerate(lookup.scene_idxs):
        for each in _environment_differences(plan, lookup.scenes[number], index):
            groups.add("the scene", each.words, index, plan.environment and plan.environment.origin, key=each.what)
    for held in (*plan.lights, *plan.cameras):
        found: RenderComponentBatch = (rendering.cameras if isinstance(held, Camera) else rendering.lights)[held.name]
        for (number, row), component in zip(rows_by_scene(held, lookup), found.objs, strict=True):
            index = lookup.scene_idxs[number]
            placement = _placement_differences(held, component, row, lookup, number)
            for each in chain(placement, _component_differences(plan, held, component, row)):
                groups.add(f"'{held.name}'", each.words, index, held.origin, key=each.what)
    return groups.report()


def _environment_differences(plan: ScenePlan, scene: Any, index: int) -> Iterator[EngineDifference]:
    """What differs in a scene as a whole, of an index among all of the plan."""
    system, environment = scene.render_system, plan.environment
    ambient: Any = (0.0, 0.0, 0.0)
    if environment is not None and environment.ambient_light is not None:
        ambient = environment.ambient_light.row(index)
    map_ = environment is not None and environment.map is not None
    return _property_differences(
        ("ambient_light", ambient, system.ambient_light),
        ("cubemap", _map_presence(there=map_), _map_presence(there=system.cubemap is not None)),
        ("lights", sum(index in light.scene_idxs for light in plan.lights), len(system.lights)),
        ("cameras", sum(index in camera.scene_idxs for camera in plan.cameras), len(system.cameras)),
    )


def _placement_differences(
    held: Light | Camera, component: Any, row: int, lookup: EntityLookup, number: int
) -> Iterator[EngineDifference]:
    """What differs in where a component is: in which entity and at which pose."""
    entity = component.get_entity()
    yield from _property_differences(("name", held.name, component.name))
    if held.mount is not None:
        yield from _property_differences(("local_pose", held.pose.row(row), component.local_pose))
        if entity != lookup.entity(held.mount, number):
            yield EngineDifference("entity", f"that of '{held.mount.entity}'", "another")
        return
    if entity is None or entity.get_scene() != lookup.scenes[number]:
        yield EngineDifference("scene", "its own", "another" if entity and entity.get_scene() else "none")
        return
    yield from _property_differences(
        ("entity.name", held.name, entity.name),
        ("entity.pose", held.pose.row(row), entity.get_pose()),
        ("local_pose", IDENTITY_POSE, component.local_pose),
    )


def _component_differences(
    plan: ScenePlan, held: Light | Camera, component: Any, row: int
) -> Iterator[EngineDifference]:
    if isinstance(held, Camera):
        yield from _camera_differences(held, component, row)
    else:
        yield from _light_differences(plan, held, component, row)


def _light_differences(plan: ScenePlan, light: Light, component: Any, row: int) -> Iterator[EngineDifference]:
    kind = getattr(render, LIGHT_CLASSES[type(light.light)])
    if type(component) is not kind:
        yield EngineDifference("type", kind.__name__, type(component).__name__)
        return
    for name, value in light_values(light).items():
        yield from _property_differences((name, value.row(row), getattr(component, name)))
    if isinstance(light.light, TexturedLight):
        image = component.texture
        if image is None:
            yield EngineDifference("texture", "an image", "none")
            return
        for name, wanted in expected_texture(plan, light.light.texture, row).items():
            yield from _property_differences((f"texture.{name}", wanted, getattr(image, name)))


def _camera_differences(camera: Camera, component: Any, row: int) -> Iterator[EngineDifference]:
    mode = "orthographic" if isinstance(camera.lens, Orthographic) else "perspective"
    yield from _property_differences(
        ("width", camera.width, component.width), ("height", camera.height, component.height)
    )
    if component.mode != mode:
        yield EngineDifference("mode", format_value(mode), format_value(component.mode))
        return
    values = camera_values(camera, row)
    angles = {name: values.pop(name) for name in ("fovx", "fovy") if name in values}
    yield from _property_differences(*((name, wanted, getattr(component, name)) for name, wanted in values.items()))
    for name, wanted in angles.items():
        found = getattr(component, name)
        if not abs(found - wanted) <= ANGLE_TOLERANCE * wanted:
            yield EngineDifference(name, format_value(np.float32(wanted)), format_value(np.float32(found)))
    if len(angles) == 1:
        yield from _property_differences(("fx / fy", 1.0, component.fx / component.fy))
    if isinstance(camera.lens, Perspective):
        middle = (("cx", camera.width / 2, component.cx), ("cy", camera.height / 2, component.cy))
        yield from _property_differences(*middle, ("skew", 0.0, component.skew))


def _property_differences(*triples: tuple[str, Any, Any]) -> Iterator[EngineDifference]:
    """Of names, what the plan asks for, and what the engine holds."""
    for name, wanted, found in triples:
        if not is_same(wanted, found):
            yield EngineDifference(name, format_value(wanted), format_value(found))


def _map_presence(*, there: bool) -> str:
    return "a map" if there else "none"


_get_name = sapien.Entity.get_name

LINK_TOLERANCE = 1e-5
"""How far a link may be from where it belongs, by its distance from the world's origin where that is beyond 1 m: the
engine goes from link to link in float32."""


class EntityColumn(NamedTuple):
    """What stands at one place of the build order, once for each scene that has it.

    Attributes:
        numbers: which bodies or articulations of the entity.
        objs: the `sapien.Entity` of each.
        poses: (·, 7) float32 of each; None: those of all bodies of the entity, which are read at once.
        tolerance: of poses; 0: to the bit.
        link: its name; None: a body.
    """

    prepared: PreparedEntity
    numbers: Sequence[int]
    name: str
    objs: list[Any]
    poses: NDArray[np.float32] | None = None
    tolerance: float = 0.0
    link: str | None = None

    def place(self, body: int) -> BodyLocation:
        """Of one of `numbers`."""
        return BodyLocation(self.prepared, self.numbers[body], self.prepared.entity.origin, self.link)


def compare_entities(
    prepared_entities: Sequence[PreparedEntity],
    scenes: Sequence[Any],
    scene_idxs: Sequence[int],
    comparison: BatchComparison,
    *,
    every_name: bool,
) -> None:
    """That each scene holds the plan's entities and no others, in the plan's order, with their names and poses.

    `every_name`: in all scenes, not only in the first and the last (order and identity are looked at in all).
    """
    columns = [column for prepared in prepared_entities for column in _entity_columns(prepared)]
    number_of = {index: number for number, index in enumerate(scene_idxs)}
    scene = np.array(
        [number_of[column.prepared.scene_idxs[number]] for column in columns for number in column.numbers],
        dtype=np.intp,
    )
    entities: list[list[Any]] = [each.entities for each in scenes]
    if np.bincount(scene, minlength=len(scenes)).tolist() != list(map(len, entities)):
        _compare_counts(columns, entities, number_of, comparison)
        return
    # Entities come column by column here and scene by scene there; a stable sort by scene keeps the columns' order.
    order = np.argsort(scene, kind="stable")
    starts = np.cumsum([0, *(len(column.numbers) for column in columns)])

    def place(body: int) -> BodyLocation:
        which = int(np.searchsorted(starts, body, side="right")) - 1
        return columns[which].place(body - int(starts[which]))

    present = list(chain.from_iterable(entities))
    ordered = order.tolist()
    ends = (
        range(len(present)) if every_name else sorted({*range(len(entities[0])), *_last_scene(present, entities[-1])})
    )
    _compare_names(columns, present, ordered, ends, place, comparison)
    _compare_order(columns, present, ordered, place, comparison)
    # SAPIEN packs q, then p, of each entity of a scene in the order in which they were added.
    packed = np.concatenate([np.frombuffer(each.pack_poses(), dtype=np.float32).reshape(-1, 7) for each in scenes])
    found, wanted = packed[:, [4, 5, 6, 0, 1, 2, 3]], _expected_poses(columns)[order]
    tolerances = np.repeat([column.tolerance for column in columns], [len(column.numbers) for column in columns])[order]
    for i in _wrong_poses(found, wanted, tolerances).tolist():
        comparison.tell(place(int(order[i])), "pose", format_value(wanted[i]), format_value(found[i]))


def _entity_columns(prepared: PreparedEntity) -> Iterator[EntityColumn]:
    if not isinstance(prepared, PreparedArticulation):
        yield EntityColumn(prepared, range(len(prepared.rows)), prepared.entity.name, prepared.objs)
        return
    for part in prepared.parts:
        numbers: list[int] = part.numbers.tolist()
        poses = link_poses(prepared.entity, part.structure, part.rows)
        tolerance = LINK_TOLERANCE * center_of_mass_reach(prepared.links[numbers[0]])
        for which, (link, pose) in enumerate(zip(part.structure.links, poses, strict=True)):
            objs = [prepared.entities[number][which] for number in numbers]
            yield EntityColumn(prepared, numbers, link.name, objs, pose, tolerance, link.name)


def _wrong_poses(
    found: NDArray[np.float32], wanted: NDArray[np.float32], tolerances: NDArray[np.float64]
) -> NDArray[np.intp]:
    wrong = (found != wanted).any(axis=1)
    if tolerances.any():
        # A rotation has two quaternions, and the engine may hold either.
        sign = np.where((found[:, 3:] * wanted[:, 3:]).sum(axis=1) < 0, -1.0, 1.0)
        far = np.maximum(1.0, np.abs(wanted[:, :3]).max(axis=1))
        apart = np.maximum(
            np.abs(found[:, :3] - wanted[:, :3]).max(axis=1),
            np.abs(found[:, 3:] - sign[:, None] * wanted[:, 3:]).max(axis=1),
        )
        wrong &= (tolerances == 0) | ~(apart <= tolerances * far)
    return np.flatnonzero(wrong)


def _last_scene(present: list[Any], last: list[Any]) -> range:
    return range(len(present) - len(last), len(present))


def _compare_names(
    columns: Sequence[EntityColumn],
    present: list[Any],
    order: list[int],
    which: Sequence[int],
    place: Callable[[int], BodyLocation],
    comparison: BatchComparison,
) -> None:
    names = [name for column in columns for name in [column.name] * len(column.numbers)]
    for i in which:
        wanted, name = names[order[i]], _get_name(present[i])
        if wanted != name:
            comparison.tell(place(order[i]), "name at its place in the build order", repr(wanted), repr(name))


def _compare_order(
    columns: Sequence[EntityColumn],
    present: list[Any],
    order: list[int],
    place: Callable[[int], BodyLocation],
    comparison: BatchComparison,
) -> None:
    objs = list(chain.from_iterable(column.objs for column in columns))
    handed_out = [objs[body] for body in order]
    # Comparing lists looks at identity first, and needs no loop in Python for the usual case.
    if handed_out != present:
        for body, ours, entity in zip(order, handed_out, present, strict=True):
            if ours is not entity:
                comparison.tell(place(body), "entity", "the one of the batch", "another")


def _expected_poses(columns: Sequence[EntityColumn]) -> NDArray[np.float32]:
    """Of all entities, column by column; rounded at once for all that have one pose."""
    fixed = [
        (0.0,) * 7 if column.prepared.entity.pose.varies else column.prepared.entity.pose.as_drawn()
        for column in columns
    ]
    counts = [len(column.numbers) for column in columns]
    poses = np.repeat(np.array(fixed).astype(np.float32), counts, axis=0)
    for column, end in zip(columns, np.cumsum(counts).tolist(), strict=True):
        if column.poses is not None:
            poses[end - len(column.numbers) : end] = column.poses
        elif column.prepared.entity.pose.varies:
            poses[end - len(column.numbers) : end] = select_rows(column.prepared.entity.pose, column.prepared.rows)
    return poses


def _compare_counts(
    columns: Sequence[EntityColumn], entities: list[list[Any]], number_of: dict[int, int], comparison: BatchComparison
) -> None:
    counted: dict[int, list[tuple[PreparedEntity, int]]] = {}
    for column in columns:
        for number in column.numbers:
            counted.setdefault(column.prepared.scene_idxs[number], []).append((column.prepared, number))
    for index, bodies in counted.items():
        found = len(entities[number_of[index]])
        if found != len(bodies):
            prepared, body = bodies[0]
            comparison.tell(BodyLocation(prepared, body, None), "entities in the scene", len(bodies), found)


def audit_batch(
    batch: SceneBatch,
    prepared_entities: list[PreparedEntity],
    present: EngineDefaults,
    sink: Sink,
    level: Literal["full", "fast"],
) -> bool:
    """Compares what the engine holds with the plan, reports every difference, and says whether there is none.

    To be called before anything is stepped, and while the process-wide defaults are those of the build;
    `present` are the engine's as they were before the build set any.
    """
    plan, scenes = batch.plan, batch.scenes
    defaults = present.with_settings(plan.physics)
    groups = DifferenceGroups(sink)
    settings = [(batch.scene_idxs[0], difference) for difference in cooking_differences(defaults)]
    for index, scene in zip(batch.scene_idxs, scenes if level == "full" else scenes[:1], strict=False):
        settings += [(index, difference) for difference in scene_differences(defaults, scene)]
    for index, difference in settings:
        origin = plan.physics.origin or plan.origin
        groups.add("the scene", difference.words, index, origin, key=(difference.what, index))
    comparison = BatchComparison()
    if prepared_entities:
        _compare_objects(batch, prepared_entities, defaults, comparison, level)
    found: dict[str, list[tuple[BodyLocation, EngineDifference]]] = {}
    for place, difference in comparison.differences():
        found.setdefault(place.prepared.entity.name, []).append((place, difference))
    for prepared in prepared_entities:
        _tell_entity(groups, prepared, found.get(prepared.entity.name, []))
    return groups.report()


def _compare_objects(
    batch: SceneBatch,
    prepared_entities: list[PreparedEntity],
    defaults: EngineDefaults,
    comparison: BatchComparison,
    level: Literal["full", "fast"],
) -> None:
    meshes = ReferenceMeshes(batch.plan, defaults.material)
    bodies = BodyAudit(batch.plan, defaults, meshes, comparison, rendered=batch.render)
    compare_entities(prepared_entities, batch.scenes, batch.scene_idxs, comparison, every_name=level == "full")
    articulations = ArticulationAudit(bodies, defaults, meshes, comparison)
    for prepared in prepared_entities:
        if isinstance(prepared, PreparedArticulation):
            articulations.look_at(prepared, every=level == "full")
            continue
        for part in prepared.parts:
            closely = part.numbers if level == "full" else part.numbers[:1]
            for number in closely.tolist():
                bodies.look_at(prepared, part.structure, number)
            if len(closely) < len(part.numbers) and part.structure.body_type != "none":
                components: list[Any] = [prepared.components[number] for number in part.numbers]
                compare_bodies(prepared, part, components, meshes, comparison)


def _tell_entity(
    groups: DifferenceGroups, prepared: PreparedEntity, found: list[tuple[BodyLocation, EngineDifference]]
) -> None:
    """One group a property and place."""
    # What follows from a mistake of the scene is not told beside it.
    causes = [(place, difference) for place, difference in found if difference.code != AUDIT_CODE]
    for place, difference in causes or found:
        who = f"'{prepared.entity.name}'" if place.link is None else f"link '{place.link}' of '{prepared.entity.name}'"
        groups.add(
            who,
            difference.words,
            prepared.scene_idxs[place.number],
            difference.origin or prepared.entity.origin,
            key=(difference.what, difference.origin),
            code=difference.code,
        )
