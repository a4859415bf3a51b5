"""Limits on what a document may ask for (docs/language.md, Limits)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.spec.body import BodySpec
from scenecc.spec.references import count_scene_idxs

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.references import RobotReader, RobotRequest
    from scenecc.plan import AssetFile, Entity
    from scenecc.robots.description import RobotDescription
    from scenecc.spec.document import SceneFile


@frozen
class LoweringLimits:
    """The most that there may be."""

    scenes: int
    objects: int
    objects_times_scenes: int
    computed: int


def check_limits(
    scene: SceneFile,
    num_scenes: int,
    selections: Mapping[str, tuple[int, ...]],
    bounds: LoweringLimits,
    origin: Origin,
    sink: Sink,
) -> bool:
    """Whether a document asks for no more than it may; otherwise that is reported."""
    if not _check_limit("SC605", "scenes", num_scenes, bounds.scenes, origin.child("num_scenes"), sink):
        return False
    shapes = {name: _entity_size(entity) for name, entity in scene.entities.items()}
    others = [*scene.constraints.values(), *scene.lights.values(), *scene.cameras.values()]
    built = sum(
        shapes[name]
        * (len(selections[name]) if name in selections else count_scene_idxs(entity.scene_idxs, num_scenes))
        for name, entity in scene.entities.items()
    )
    # Of an instance that is in some scenes only, what is fastened counts as if it were in all.
    built += sum(count_scene_idxs(other.scene_idxs, num_scenes) for other in others)
    return _check_objects(sum(shapes.values()) + len(others), built, bounds, origin, sink)


def check_built_limits(entities: Sequence[Entity], bounds: LoweringLimits, origin: Origin, sink: Sink) -> bool:
    """Whether what was built is no more than it may be, with what robots' files hold; otherwise that is reported."""
    counts = [
        max(sum(1 + len(body.collisions) + len(body.visuals) for body in one.bodies) for one in entity.structures)
        for entity in entities
    ]
    built = sum(count * len(entity.scene_idxs) for count, entity in zip(counts, entities, strict=True))
    return _check_objects(sum(counts), built, bounds, origin, sink)


def _check_objects(objects: int, built: int, bounds: LoweringLimits, origin: Origin, sink: Sink) -> bool:
    """The same of so many objects, of which so many are built in all scenes together."""
    if not _check_limit("SC604", "objects", objects, bounds.objects, origin.child("entities"), sink):
        return False
    place = origin.child("num_scenes")
    return _check_limit("SC606", "objects times scenes", built, bounds.objects_times_scenes, place, sink)


class LimitedRobotReader:
    """Reads robots' files until all that they hold, each counted as often as it is asked for, is too much.

    What is built of them is counted exactly once they are lowered: late for a small file that asks for billions.

    Attributes:
        exhausted: whether there was more than there may be, which was reported (SC604): nothing is read any more.

    Args:
        read: reads them.
        most: objects that there may be.
        sink: takes the diagnostic.
    """

    def __init__(self, read: RobotReader, most: int, sink: Sink) -> None:
        self._read = read
        self._most = most
        self._sink = sink
        self._held = 0
        # With each its description, so that its id stays its own.
        self._sizes: dict[int, tuple[RobotDescription, int]] = {}
        self.exhausted = False

    def read(self, request: RobotRequest, places: Mapping[str, Origin]) -> tuple[AssetFile, RobotDescription] | None:
        """A `RobotReader`."""
        if self.exhausted:
            return None
        found = self._read(request, places)
        if found is None:
            return None
        description = found[1]
        if id(description) not in self._sizes:
            self._sizes[id(description)] = description, _description_size(description)
        self._held += self._sizes[id(description)][1]
        if self._held <= self._most:
            return found
        self.exhausted = True
        message = f"at least {self._held} objects are more than the limit of {self._most}"
        hint = "raise it with --limit objects=N or limits={'objects': N}"
        self._sink.report("SC604", message, places[request.format], hint=hint)
        return None


def _description_size(description: RobotDescription) -> int:
    """How many links and shapes a robot's file holds."""
    links = (link for robot in description.robots for link in robot.links)
    return sum(1 + len(link.collisions) + len(link.visuals) for link in links)


def _entity_size(entity: Any) -> int:
    if entity.__class__ is BodySpec:
        return max(1, _shape_count(entity))
    if "variants" in entity.__class__.model_fields:
        # The largest is in every scene at worst.
        return max(1, *(_shape_count(entity) + _shape_count(variant) for variant in entity.variants))
    root = getattr(entity, "root", None)
    # How much a robot's file holds is seen once it is read.
    return 1 if root is None else _tree_size(root)


def _tree_size(root: Any) -> int:
    """How many links and shapes there are in a tree."""
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
    name = what.replace(" ", "_")
    hint = f"raise it with --limit {name}={number} or limits={{'{name}': {number}}}"
    sink.report(code, f"{number} {what} are more than the limit of {limit}", place, hint=hint)
    return False
