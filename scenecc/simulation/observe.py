"""Readings of a batch at a time: poses, speeds, joints, distances and contacts of bodies by name."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry.rotation_arrays import rotate
from scenecc.placing.bodies import body_parts, matrices
from scenecc.placing.pairs import part_distances
from scenecc.plan import BodyStructure
from scenecc.plan.scene import find_body

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.placing.bodies import Part
    from scenecc.plan.expect import Reading

    Floats = NDArray[np.float64]

_UP = np.array([[0.0, 0.0, 1.0]])


class Observer:
    """Reads the values that conditions name, as Python values by scene index.

    Args:
        batch: a batch that was not stepped yet.
    """

    def __init__(self, batch: SceneBatch) -> None:
        self._batch = batch
        self._entities = {entity.name: entity for entity in batch.plan.entities}
        self._parts: dict[str, list[Part]] = {}
        tilted = {
            name
            for one in batch.plan.expectations
            for reading in getattr(one, "readings", ())
            if reading.kind == "tilt"
            for name in reading.of
        }
        self._start = {name: self._poses(name) for name in tilted}

    def values(self, reading: Reading) -> Mapping[int, Any]:
        """Returns a reading in each scene that has it; contacts are read by `touching`.

        Raises:
            UnsupportedShapeError: the distance from a shape cannot be computed.
            AssetError: a file cannot be read.
        """
        return getattr(self, f"_{reading.kind}")(*reading.of)

    def touching(self, a: str, b: str) -> Mapping[int, bool]:
        """Returns whether two bodies pressed on each other in the last step, or overlap."""
        contacts = self._batch.contacts(a, b)
        pressed = (contacts.separation <= 0) | contacts.impulse.any(axis=1)
        there = set(self._bodies(a)) & set(self._bodies(b))
        found = set(contacts.scene[pressed].tolist())
        return {scene: scene in found for scene in there}

    def _bodies(self, name: str) -> dict[int, tuple[Any, Any]]:
        """Returns the `sapien.Entity` and component of a body in each scene that has it; for an articulation, its
        root's.
        """
        found = find_body(name, self._entities)
        assert found is not None, "names were looked up"
        entity, link = found
        if isinstance(entity.structures[0], BodyStructure):
            bodies = self._batch.entities[entity.name]
            pairs = [(scene, obj, _rigid(obj)) for scene, obj in zip(bodies.scene_idxs, bodies.objs, strict=True)]
            return {scene: (obj, component) for scene, obj, component in pairs}
        articulation = self._batch.articulations[entity.name]
        if link is None:
            components: list[Any] = [obj.root for obj in articulation.objs]
        else:
            components = articulation.links[link]
        return {
            scene: (component.get_entity(), component)
            for scene, component in zip(articulation.scene_idxs, components, strict=True)
            if component is not None
        }

    def _poses(self, name: str) -> dict[int, Floats]:
        """Returns the pose (7,) in the world of each scene, p [m] then q (wxyz)."""
        bodies = self._bodies(name).items()
        return {scene: np.array(obj.get_pose().__getstate__(), np.float64) for scene, (obj, _) in bodies}

    def _position(self, name: str) -> dict[int, list[float]]:
        return {scene: pose[:3].tolist() for scene, pose in self._poses(name).items()}

    def _speed(self, name: str) -> dict[int, float]:
        return {
            scene: float(np.linalg.norm(component.get_linear_velocity()))
            if hasattr(component, "get_linear_velocity")
            else 0.0
            for scene, (_, component) in self._bodies(name).items()
        }

    def _tilt(self, name: str) -> dict[int, float]:
        found: dict[int, float] = {}
        for scene, pose in self._poses(name).items():
            own = rotate(self._start[name][scene][None, 3:] * (1.0, -1.0, -1.0, -1.0), _UP)
            up = float(rotate(pose[None, 3:], own)[0, 2])
            found[scene] = math.acos(min(1.0, max(-1.0, up)))
        return found

    def _qpos(self, name: str, joint: str) -> dict[int, float]:
        found = find_body(name, self._entities)
        assert found is not None, "names were looked up"
        articulation = self._batch.articulations[found[0].name]
        qpos = articulation.qpos
        names = [[one.get_name() for one in obj.get_active_joints()] for obj in articulation.objs]
        return {
            scene: float(qpos[row, names[row].index(joint)])
            for row, scene in enumerate(articulation.scene_idxs)
            if joint in names[row]
        }

    def _distance(self, a: str, b: str) -> dict[int, float]:
        first, second = self._find_parts(a), self._find_parts(b)
        scenes = self._batch.scene_idxs
        least = np.full(len(scenes), np.inf)
        for one in first:
            for other in second:
                np.minimum(least, part_distances(one, other), out=least)
        return {scene: gap for scene, gap in zip(scenes, least.tolist(), strict=True) if gap < math.inf}

    def _find_parts(self, name: str) -> list[Part]:
        """Returns the collision parts of a body, or of all links of an articulation, in their current poses."""
        found = find_body(name, self._entities)
        assert found is not None, "names were looked up"
        entity, link = found
        scenes = self._batch.scene_idxs
        if entity.name not in self._parts:
            self._parts[entity.name] = body_parts(entity, self._batch.plan.files, np.array(scenes, np.int64))
        placed: list[Part] = []
        for part in self._parts[entity.name]:
            if link not in {None, part.link}:
                continue
            body = entity.name if part.link is None else f"{entity.name}/{part.link}"
            at = self._poses(body)
            pose = np.array([at.get(scene, (0, 0, 0, 1, 0, 0, 0)) for scene in scenes], np.float64)
            placed.append(part.moved(matrices(pose[:, 3:]), pose[:, :3]))
        return placed


def _rigid(obj: Any) -> Any:
    """Returns the component of a body that collides; None if there is none."""
    return next((one for one in obj.get_components() if hasattr(one, "get_collision_shapes")), None)
