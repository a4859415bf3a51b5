"""Entities as written to those of the plan: where they stand, and what they are in each scene."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from scenecc.lower.kinds import Kind
from scenecc.lower.placing.places import Places
from scenecc.plan import BodyStructure, Entity
from scenecc.spec.body import Body
from scenecc.spec.known import known_as
from scenecc.spec.pose import PoseMapping
from scenecc.spec.selection import select

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.articulations import Articulations, Built
    from scenecc.lower.bodies import Bodies
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.names import Names
    from scenecc.plan import Value
    from scenecc.spec.document import SceneFile

_MOVING = frozenset(("dynamic", "kinematic"))
"""Bodies whose poses a running simulation can change."""


class Entities:
    """Lowers the entities of a document.

    Attributes:
        selections: by what it is known as, the scenes of all that is not in every one: of what is fastened too.
        places: where what it has stands.
        linked: those of its entities, once lowered, that are articulations or come from robots' files.

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
        self.selections = self._select(narrowed)
        self.linked: list[Entity] = []
        free = {name: camera for name, camera in scene.cameras.items() if camera.mount is None}
        sections = {"frames": scene.frames, "entities": scene.entities, "cameras": free}
        self.places = Places(sections, self.leaves, names, origin, sink)

    def _select(self, narrowed: Mapping[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
        selections = dict(narrowed)
        for section in ("entities", "cameras", "constraints", "lights"):
            nodes: Mapping[str, Any] = getattr(self._scene, section)
            for name, node in nodes.items():
                known = known_as(section, name)
                if node.scene_idxs is not None and known not in narrowed:
                    place = self._origin.child(section, name, "scene_idxs")
                    selected = select(node.scene_idxs, self._drawing.num_scenes, place, self._sink)
                    if selected is not None:
                        selections[known] = selected
        return selections

    def leaves(self, name: str) -> Leaves:
        """The leaves of something, over its scenes. `name`: that it is known as."""
        return self._drawing.leaves(self.selections.get(name), self._names.scopes.get(name, ""))

    def lower(self, bodies: Bodies, articulations: Callable[[], Articulations]) -> tuple[Entity, ...]:
        """The entities, in order; what was reported is missing in them.

        Args:
            bodies: lowers those of the document.
            articulations: makes what lowers its articulations.
        """
        for name in self._scene.frames:
            self.places.world(name, self._origin.child("frames", name), fixed=False)
        everywhere, origin, selections = self._drawing.everywhere, self._origin, self.selections
        world = self.places.world
        scopes, of_all = self._names.scopes, self._drawing.leaves()
        entities: list[Entity] = []
        linked: Articulations | None = None
        for name, entity in self._scene.entities.items():
            place = origin.child("entities", name)
            leaves = self.leaves(name) if name in selections or name in scopes else of_all
            if entity.__class__ is Body:
                structure = bodies.lower(entity, place, leaves)
                structures, pick, fixed = (structure,), None, structure.body_type not in _MOVING
            elif "variants" not in entity.__class__.model_fields:
                linked = linked or articulations()
                entities += self._linked(name, linked.lower(entity, place, leaves), place, hidden=entity.hidden)
                continue
            else:
                # An expanded document has no others.
                structures, pick = self._variants(entity, place, leaves, bodies)
                fixed = not all(structure.body_type in _MOVING for structure in structures)
            pose: Value = world(name, place, fixed=fixed)
            entities.append(
                Entity(name, selections.get(name, everywhere), pose, structures, pick, entity.hidden, place)
            )
        return tuple(entities)

    def _linked(self, name: str, built: list[Built], place: Origin, *, hidden: bool) -> list[Entity]:
        """The entities that a robot's file or a tree of links makes."""
        scenes = self.selections.get(name, self._drawing.everywhere)
        made: list[Entity] = []
        for one in built:
            full = name
            if one.pose is not None:
                full = f"{name}/{one.suffix}"
                x, y, z, *q = one.pose
                pose = PoseMapping.model_construct(p=(x, y, z), q=tuple(q), relative_to=name)
                self.places.add(full, place, SimpleNamespace(pose=pose))
                if name in self.selections:
                    self.selections[full] = self.selections[name]
                if full in self._scene.entities:
                    message = f"`{full}` names an entity, and a robot of a file"
                    related = [("the entity", self._origin.child("entities", full), "key")]
                    self._sink.report("SC305", message, place, at="key", related=related)  # pyright: ignore[reportArgumentType]
            still = all(isinstance(body, BodyStructure) and body.body_type == "static" for body in one.structures)
            pose = self.places.world(full, place, fixed=still)
            made.append(Entity(full, scenes, pose, one.structures, one.pick, hidden, place))
        self.linked += made
        return made

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
