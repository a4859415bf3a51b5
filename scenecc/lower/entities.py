"""Entities as written to those of the plan: where they stand, and what they are in each scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.lower.kinds import Kind
from scenecc.lower.places import Places
from scenecc.plan import Entity
from scenecc.spec.body import Body
from scenecc.spec.selection import select

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.bodies import Bodies
    from scenecc.lower.leaves import Drawing, Leaves
    from scenecc.lower.names import Names
    from scenecc.plan import BodyStructure, Value
    from scenecc.spec.document import SceneFile

_MOVING = frozenset(("dynamic", "kinematic"))
"""Bodies whose poses a running simulation can change."""


class Entities:
    """Lowers the entities of a document.

    Args:
        scene: the document.
        narrowed: the scenes of the entities and frames that instances narrow.
        drawing: of the document.
        names: likewise.
        origin: of its root.
        sink: takes the diagnostics.
    """

    def __init__(
        self,
        scene: SceneFile,
        narrowed: Mapping[str, tuple[int, ...]],
        drawing: Drawing,
        names: Names,
        origin: Origin,
        sink: Sink,
    ) -> None:
        self._scene = scene
        self._drawing = drawing
        self._names = names
        self._origin = origin
        self._sink = sink
        self._selections = self._select(narrowed)
        placed = {**scene.frames, **scene.entities}
        self.places = Places(placed, scene.frames, self._leaves, names, origin, sink)

    def _select(self, narrowed: Mapping[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
        selections = dict(narrowed)
        for name, entity in self._scene.entities.items():
            if entity.scene_idxs is not None and name not in narrowed:
                place = self._origin.child("entities", name, "scene_idxs")
                selected = select(entity.scene_idxs, self._drawing.num_scenes, place, self._sink)
                if selected is not None:
                    selections[name] = selected
        return selections

    def _leaves(self, name: str) -> Leaves:
        return self._drawing.leaves(self._selections.get(name), self._names.scopes.get(name, ""))

    def lower(self, bodies: Bodies) -> tuple[Entity, ...]:
        """The entities, in order; what was reported is missing in them."""
        for name in self._scene.frames:
            self.places.world(name, self._origin.child("frames", name), fixed=False)
        everywhere, origin, selections = self._drawing.everywhere, self._origin, self._selections
        world = self.places.world
        scopes, of_all = self._names.scopes, self._drawing.leaves()
        entities: list[Entity] = []
        for name, entity in self._scene.entities.items():
            place = origin.child("entities", name)
            leaves = self._leaves(name) if name in selections or name in scopes else of_all
            if entity.__class__ is Body:
                structure = bodies.lower(entity, place, leaves)
                structures, pick, fixed = (structure,), None, structure.body_type not in _MOVING
            else:
                # An expanded document has no others.
                structures, pick = self._variants(entity, place, leaves, bodies)
                fixed = not all(structure.body_type in _MOVING for structure in structures)
            pose: Value = world(name, place, fixed=fixed)
            entities.append(Entity(name, selections.get(name, everywhere), pose, structures, pick, place))
        return tuple(entities)

    def _variants(
        self, entity: Any, origin: Origin, leaves: Leaves, bodies: Bodies
    ) -> tuple[tuple[BodyStructure, ...], Value]:
        """One structure a variant, picked or not, and which of them each scene has."""
        structures = tuple(
            bodies.variant((entity, origin), (variant, origin.child("variants", i)), leaves)
            for i, variant in enumerate(entity.variants)
        )
        last = len(structures) - 1
        pick = leaves.value(entity.pick, Kind(dtype="int64", within=(0, last)), origin, "pick")
        # What holds an expression is judged as it is drawn.
        wrong = [index for index in pick.numbers() if index > last] if pick.known or pick.support.exact else []
        if wrong:
            message = f"there is no variant {wrong[0]:g}: " + (f"they are 0 to {last}" if last else "the only one is 0")
            self._sink.report("SC320", message, origin.child("pick"))
        return structures, pick
