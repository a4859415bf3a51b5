"""What pictures need besides entities: environment, lights and cameras."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.lower.field_types import LIGHT_COLOR
from scenecc.lower.mounts import MountLookup
from scenecc.lower.variation import SELECTORS
from scenecc.plan import CubeMap, Environment, SkyMap
from scenecc.spec.references import qualified_name
from scenecc.variation.forms import SceneMap

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.entities import EntityLowerer
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.materials import MaterialLowerer
    from scenecc.lower.names import NameScopes
    from scenecc.lower.references import PlanTables
    from scenecc.plan import Camera, Entity, Light
    from scenecc.spec.document import SceneFile
    from scenecc.spec.light import EnvironmentSpec as EnvironmentKeys


@frozen
class RenderObjects:
    """What pictures of the scenes need besides the entities; fields as of `ScenePlan`."""

    environment: Environment | None = None
    lights: tuple[Light, ...] = ()
    cameras: tuple[Camera, ...] = ()


def lower_render_objects(
    scene: SceneFile,
    built: tuple[Entity, ...],
    entities: EntityLowerer,
    names: NameScopes,
    tables: PlanTables,
    materials: MaterialLowerer,
    of_all: FieldLowerer,
    origin: Origin,
    sink: Sink,
) -> RenderObjects:
    """The surroundings, lights and cameras of a document; what was reported is missing among them.

    Args:
        scene: the document.
        built: its entities, lowered.
        entities: what lowered them.
        names: of the document.
        tables: take its files.
        materials: of the document, for pictures.
        of_all: leaves over all scenes.
        origin: of the document's root.
        sink: takes the diagnostics.
    """
    environment: Environment | None = None
    lights: list[Light | None] = []
    cameras: list[Camera] = []
    if scene.environment is not None:
        environment = lower_environment(scene.environment, tables, of_all, origin.child("environment"))
    mounts = MountLookup(built, entities.places.unread, names, sink)
    if scene.lights:
        from scenecc.lower.lights import LightLowerer  # noqa: PLC0415 - loaded where there are any

        lowering = LightLowerer(mounts, entities.places, materials, sink)
        for name, light in scene.lights.items():
            leaves = entities.leaves(qualified_name("lights", name))
            lights.append(lowering.lower(name, light, leaves, origin.child("lights", name)))
    if scene.cameras:
        from scenecc.lower.cameras import CameraLowerer  # noqa: PLC0415 - likewise

        seeing = CameraLowerer(mounts, entities.places, sink)
        for name, camera in scene.cameras.items():
            cameras.append(seeing.lower(name, camera, entities.leaves(name), origin.child("cameras", name)))
    return RenderObjects(environment, tuple(light for light in lights if light is not None), tuple(cameras))


FACES = ("px", "nx", "py", "ny", "pz", "nz")


def lower_environment(given: EnvironmentKeys, tables: PlanTables, leaves: FieldLowerer, origin: Origin) -> Environment:
    """The surroundings of every scene; a map that was reported is missing.

    Args:
        given: as written.
        tables: take its files.
        leaves: over all scenes.
        origin: of it.
    """
    ambient = leaves.given(given.ambient_light, LIGHT_COLOR, origin, "ambient_light")
    return Environment(ambient, _map(given.map, tables, leaves, origin.child("map")), origin)


def _map(given: Any, tables: PlanTables, leaves: FieldLowerer, origin: Origin) -> SkyMap | CubeMap | None:
    if given is None:
        return None
    if _are_faces(given):
        faces = [tables.files_of(getattr(given, face), origin.child(face), leaves) for face in FACES]
        found = [face for face in faces if face is not None]
        return CubeMap(*found) if len(found) == len(FACES) else None
    if _holds_faces(given):
        message = "alternatives of a map are files: six pictures cannot stand for one"
        leaves.sink.report("SC321", message, origin, hint="write the form for each of px, nx, py, ny, pz and nz")
        return None
    file = tables.files_of(given, origin, leaves)
    return None if file is None else SkyMap(file)


def _are_faces(given: Any) -> bool:
    """Whether it is the six pictures of a cube map, and not a file or a form of one."""
    return hasattr(given, FACES[0])


def _holds_faces(given: Any) -> bool:
    if given.__class__ not in SELECTORS:
        return _are_faces(given)
    if isinstance(given, SceneMap):
        return any(_holds_faces(one) for _, one in given.items) or _holds_faces(given.default)
    return any(map(_holds_faces, given.items))
