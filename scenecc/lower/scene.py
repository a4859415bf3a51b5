"""A document's models to the plan of its scenes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenecc.lower.bodies import Bodies
from scenecc.lower.groups import allot
from scenecc.lower.materials import SAPIEN_DEFAULT, Materials
from scenecc.lower.places import WORLD, Places
from scenecc.lower.selection import count, select
from scenecc.lower.shapes import Shapes
from scenecc.lower.tables import FileResolver, Tables
from scenecc.plan import Entity, Friction, GpuMemory, Physics, ScenePlan, SdfConfig, literal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.spec.document import SceneFile
    from scenecc.spec.physics import Physics as PhysicsKeys


@dataclass(frozen=True, slots=True)
class Lowered:
    """A plan, and where its files and physical materials were asked for first."""

    plan: ScenePlan
    file_origins: Mapping[int, Origin]
    material_origins: Mapping[int, Origin]


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits on what a document may ask for (LANGUAGE, Limits)."""

    scenes: int
    objects: int
    objects_times_scenes: int


def lower(
    scene: SceneFile,
    *,
    name: str,
    num_scenes: int,
    seed: int,
    origin: Origin,
    resolve: FileResolver,
    bounds: Bounds,
    sink: Sink,
) -> Lowered | None:
    """The plan of a batch; None where anything was reported as an error.

    Args:
        scene: the document.
        name: of the plan, where the document gives none.
        num_scenes: how many scenes; the document's unless overridden.
        seed: of every draw; likewise.
        origin: of the document's root.
        resolve: finds the files that it names.
        bounds: limits.
        sink: takes the diagnostics.
    """
    if not _within(scene, num_scenes, bounds, origin, sink):
        return None
    _names(scene, origin, sink)
    physics = _physics(scene.physics, origin.child("physics"))
    tables = Tables(resolve)
    materials = Materials(
        scene.materials, tables, physics.default_material or SAPIEN_DEFAULT, origin.child("materials"), sink
    )
    groups = allot(scene.collision_groups, origin.child("collision_groups"), sink)
    entities = _entities(
        scene, num_scenes, origin, Bodies(Shapes(tables, materials, sink), materials, groups, sink), sink
    )
    if sink.failed:
        # A material may be unused only because its name was misspelt where it was meant.
        return None
    materials.report_unused()
    if sink.failed:
        return None
    plan = ScenePlan(
        name=scene.name or name,
        description=scene.description,
        num_scenes=num_scenes,
        seed=seed,
        entities=entities,
        physics=physics,
        files=tables.files.rows,
        physical_materials=tables.physical_materials.rows,
        visual_materials=tables.visual_materials.rows,
        origin=origin,
    )
    return Lowered(plan, tables.file_origins, tables.material_origins)


def _entities(scene: SceneFile, num_scenes: int, origin: Origin, bodies: Bodies, sink: Sink) -> tuple[Entity, ...]:
    everywhere = tuple(range(num_scenes))
    selections: dict[str, tuple[int, ...]] = {}
    for name, body in scene.entities.items():
        if body.scene_idxs is None:
            selections[name] = everywhere
            continue
        selected = select(body.scene_idxs, num_scenes, origin.child("entities", name, "scene_idxs"), sink)
        if selected is not None:
            selections[name] = selected
    places = Places(scene.frames, scene.entities, selections, origin, sink)
    for name in scene.frames:
        places.world(name, origin.child("frames", name))
    entities: list[Entity] = []
    for name, body in scene.entities.items():
        place = origin.child("entities", name)
        pose = literal(places.world(name, place))
        structures = (bodies.lower(body, place),)
        entities.append(Entity(name, selections.get(name, everywhere), pose, structures, None, place))
    return tuple(entities)


def _within(scene: SceneFile, num_scenes: int, bounds: Bounds, origin: Origin, sink: Sink) -> bool:
    if not _under("SC605", "scenes", num_scenes, bounds.scenes, origin.child("num_scenes"), sink):
        return False
    shapes = {
        name: max(1, len(body.shapes) + len(body.collisions) + len(body.visuals))
        for name, body in scene.entities.items()
    }
    if not _under("SC604", "objects", sum(shapes.values()), bounds.objects, origin.child("entities"), sink):
        return False
    built = sum(shapes[name] * count(body.scene_idxs, num_scenes) for name, body in scene.entities.items())
    place = origin.child("num_scenes")
    return _under("SC606", "objects times scenes", built, bounds.objects_times_scenes, place, sink)


def _under(code: str, what: str, number: int, limit: int, place: Origin, sink: Sink) -> bool:
    if number <= limit:
        return True
    name = what.replace(" ", "_")
    hint = f"raise it with --limit {name}={number} or limits={{'{name}': {number}}}"
    sink.report(code, f"{number} {what} are more than the limit of {limit}", place, hint=hint)
    return False


def _names(scene: SceneFile, origin: Origin, sink: Sink) -> None:
    """Frames and entities share one namespace, and neither is the world."""
    for section, names in (("frames", scene.frames), ("entities", scene.entities)):
        if WORLD in names:
            sink.report("SC306", "`world` is the world's own name", origin.child(section, WORLD), at="key")
    for name in scene.frames.keys() & scene.entities.keys():
        sink.report(
            "SC305",
            f"`{name}` names a frame and an entity",
            origin.child("entities", name),
            at="key",
            related=[("the frame", origin.child("frames", name), "key")],
        )


def _physics(given: PhysicsKeys, origin: Origin) -> Physics:
    """The same keys; those left out stay None."""
    values = {name: getattr(given, name) for name in type(given).model_fields}
    if given.default_material is not None:
        values["default_material"] = Friction(**given.default_material.model_dump())
    if given.sdf is not None:
        values["sdf"] = SdfConfig(**given.sdf.model_dump())
    if given.gpu_memory is not None:
        values["gpu_memory"] = GpuMemory(**given.gpu_memory.model_dump())
    return Physics(**values, origin=origin)
