"""A document's models to the plan of its scenes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.lower.bodies import Bodies
from scenecc.lower.bounds import Bounds, within
from scenecc.lower.draws import lower_draws
from scenecc.lower.draws import report_unused as report_unused_draws
from scenecc.lower.entities import Entities
from scenecc.lower.groups import allot
from scenecc.lower.leaves import Drawing
from scenecc.lower.materials import SAPIEN_DEFAULT, Materials
from scenecc.lower.names import WORLD, Names
from scenecc.lower.shapes import Shapes
from scenecc.lower.tables import FileResolver, Tables
from scenecc.plan import Friction, GpuMemory, Physics, ScenePlan, SdfConfig

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.places import Places
    from scenecc.spec.document import SceneFile
    from scenecc.spec.physics import Physics as PhysicsKeys


@dataclass(frozen=True, slots=True)
class Lowered:
    """A plan, and what its draw stage and its checks have to know.

    Attributes:
        plan: whose values are not drawn yet, and have no recipes.
        file_origins: for each file, the first place that names it.
        material_origins: for each physical material, the first place that asks for it.
        drawing: the draws, and the values that only their rows can be judged by.
        places: where its entities stand.
    """

    plan: ScenePlan
    file_origins: Mapping[int, Origin]
    material_origins: Mapping[int, Origin]
    drawing: Drawing
    places: Places


_AS_WRITTEN = Names()


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
    names: Names = _AS_WRITTEN,
    selections: Mapping[str, tuple[int, ...]] | None = None,
    draws: Mapping[str, Any] | None = None,
) -> Lowered | None:
    """The plan of a batch; None where anything was reported as an error. Nothing is drawn: that is `draw`'s.

    Args:
        scene: the document, expanded where it has anything to expand.
        name: of the plan, where the document gives none.
        num_scenes: how many scenes; the document's unless overridden.
        seed: of every draw; likewise.
        origin: of the document's root.
        resolve: finds the files that it names.
        bounds: limits.
        sink: takes the diagnostics.
        names: what its names mean, where it has instances.
        selections: the scenes of the entities and frames that instances narrow.
        draws: arrays, (num_scenes,) or (num_scenes, k), that take the place of shared draws.
    """
    narrowed = selections or {}
    if not within(scene, num_scenes, narrowed, bounds, origin, sink):
        return None
    _names(scene, origin, sink)
    drawing = Drawing(seed, num_scenes, sink)
    lower_draws(scene.draws, draws or {}, drawing, names, narrowed, origin.child("draws"))
    physics = _physics(scene.physics, origin.child("physics"))
    tables = Tables(resolve)
    default = physics.default_material or SAPIEN_DEFAULT
    materials = Materials(scene.materials, tables, default, origin.child("materials"), sink)
    groups = allot(scene.collision_groups, origin.child("collision_groups"), sink)
    entities = Entities(scene, narrowed, drawing, names, origin, sink)
    built = entities.lower(Bodies(Shapes(tables, materials, sink), materials, groups, sink))
    if sink.failed:
        # A material may be unused only because its name was misspelt where it was meant.
        return None
    materials.report_unused(frozenset(names.used_materials), drawing.leaves())
    report_unused_draws(scene.draws, drawing, names, origin.child("draws"))
    if sink.failed:
        return None
    plan = ScenePlan(
        name=scene.name or name,
        description=scene.description,
        num_scenes=num_scenes,
        seed=seed,
        entities=built,
        physics=physics,
        files=tables.files.rows,
        physical_materials=tables.physical_materials.rows,
        visual_materials=tables.visual_materials.rows,
        origin=origin,
    )
    return Lowered(plan, tables.file_origins, tables.material_origins, drawing, entities.places)


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


def _physics(given: PhysicsKeys | None, origin: Origin) -> Physics:
    """The same keys; those left out stay None."""
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
