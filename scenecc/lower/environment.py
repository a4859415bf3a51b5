"""What surrounds the scenes, as written, to that of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.lower.forms import SELECTORS
from scenecc.lower.kinds import LIGHT_COLOR
from scenecc.plan import CubeMap, Environment, SkyMap
from scenecc.spec.environment import CubeMap as Faces
from scenecc.variation.forms import SceneMap

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.tables import Tables
    from scenecc.spec.environment import Environment as EnvironmentKeys

FACES = ("px", "nx", "py", "ny", "pz", "nz")


def lower_environment(given: EnvironmentKeys, tables: Tables, leaves: Leaves, origin: Origin) -> Environment:
    """The surroundings of every scene; a map that was reported is missing.

    Args:
        given: as written.
        tables: take its files.
        leaves: over all scenes.
        origin: of it.
    """
    ambient = leaves.given(given.ambient_light, LIGHT_COLOR, origin, "ambient_light")
    return Environment(ambient, _map(given.map, tables, leaves, origin.child("map")), origin)


def _map(given: Any, tables: Tables, leaves: Leaves, origin: Origin) -> SkyMap | CubeMap | None:
    if given is None:
        return None
    if isinstance(given, Faces):
        faces = [tables.files_of(getattr(given, face), origin.child(face), leaves) for face in FACES]
        found = [face for face in faces if face is not None]
        return CubeMap(*found) if len(found) == len(FACES) else None
    if _holds_faces(given):
        message = "alternatives of a map are files: six pictures cannot stand for one"
        leaves.sink.report("SC321", message, origin, hint="write the form for each of px, nx, py, ny, pz and nz")
        return None
    file = tables.files_of(given, origin, leaves)
    return None if file is None else SkyMap(file)


def _holds_faces(given: Any) -> bool:
    if given.__class__ not in SELECTORS:
        return isinstance(given, Faces)
    if isinstance(given, SceneMap):
        return any(_holds_faces(one) for _, one in given.items) or _holds_faces(given.default)
    return any(map(_holds_faces, given.items))
