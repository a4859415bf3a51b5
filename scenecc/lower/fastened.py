"""What is built after the entities and may hold on to them, and what surrounds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.spec.known import known_as

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.entities import Entities
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.materials import Materials
    from scenecc.lower.names import Names
    from scenecc.lower.tables import Tables
    from scenecc.plan import Camera, Entity, Environment, Light
    from scenecc.spec.document import SceneFile


@frozen
class Seen:
    """What pictures of the scenes need besides the entities; fields as of `ScenePlan`."""

    environment: Environment | None = None
    lights: tuple[Light, ...] = ()
    cameras: tuple[Camera, ...] = ()


def lower_seen(
    scene: SceneFile,
    built: tuple[Entity, ...],
    entities: Entities,
    names: Names,
    tables: Tables,
    materials: Materials,
    of_all: Leaves,
    origin: Origin,
    sink: Sink,
) -> Seen:
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
    if scene.environment is None and not scene.lights and not scene.cameras:
        return Seen()
    from scenecc.lower.mounts import Mounts  # noqa: PLC0415 - loaded where anything is seen

    environment: Environment | None = None
    lights: list[Light | None] = []
    cameras: list[Camera] = []
    if scene.environment is not None:
        from scenecc.lower.environment import lower_environment  # noqa: PLC0415 - likewise

        environment = lower_environment(scene.environment, tables, of_all, origin.child("environment"))
    mounts = Mounts(built, entities.places.unread, names, sink)
    if scene.lights:
        from scenecc.lower.lights import Lights  # noqa: PLC0415 - likewise

        lowering = Lights(mounts, entities.places, materials, sink)
        for name, light in scene.lights.items():
            leaves = entities.leaves(known_as("lights", name))
            lights.append(lowering.lower(name, light, leaves, origin.child("lights", name)))
    if scene.cameras:
        from scenecc.lower.cameras import Cameras  # noqa: PLC0415 - likewise

        seeing = Cameras(mounts, entities.places, sink)
        for name, camera in scene.cameras.items():
            cameras.append(seeing.lower(name, camera, entities.leaves(name), origin.child("cameras", name)))
    return Seen(environment, tuple(light for light in lights if light is not None), tuple(cameras))
