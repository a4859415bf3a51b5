"""Entities as written to those of the plan: where they stand, and what they are in each scene."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.lower.field_types import FieldType
from scenecc.lower.frames import FrameGraph
from scenecc.plan import BodyStructure, Entity
from scenecc.spec.body import BodySpec
from scenecc.spec.pose import PoseMapping
from scenecc.spec.references import qualified_name, resolve_scene_idxs

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.articulations.articulations import ArticulationLowerer, LoweredArticulation
    from scenecc.lower.bodies import BodyLowerer
    from scenecc.lower.fields import FieldLowerer, SamplingContext
    from scenecc.lower.names import NameScopes
    from scenecc.plan import ArticulationStructure, Value
    from scenecc.spec.document import SceneFile

_MOVING = frozenset(("dynamic", "kinematic"))
"""Bodies whose poses a running simulation can change."""


@frozen
class _UnplacedEntity:
    """An entity that is not placed yet. `fixed`: whether it stays where it is built."""

    name: str
    origin: Origin
    structures: tuple[BodyStructure | ArticulationStructure, ...]
    pick: Value | None
    fixed: bool
    hidden: bool
    linked: bool = False


class EntityLowerer:
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
        drawing: SamplingContext,
        names: NameScopes,
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
        self.places = FrameGraph(sections, self.leaves, names, origin, sink)

    def _select(self, narrowed: Mapping[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
        selections = dict(narrowed)
        for section in ("entities", "cameras", "constraints", "lights"):
            nodes: Mapping[str, Any] = getattr(self._scene, section)
            for name, node in nodes.items():
                known = qualified_name(section, name)
                if node.scene_idxs is not None and known not in narrowed:
                    place = self._origin.child(section, name, "scene_idxs")
                    selected = resolve_scene_idxs(node.scene_idxs, self._drawing.num_scenes, place, self._sink)
                    if selected is not None:
                        selections[known] = selected
        return selections

    def leaves(self, name: str) -> FieldLowerer:
        """The leaves of something, over its scenes. `name`: that it is known as."""
        return self._drawing.leaves(self.selections.get(name), self._names.scopes.get(name, ""))

    def lower(self, bodies: BodyLowerer, articulations: Callable[[], ArticulationLowerer]) -> tuple[Entity, ...]:
        """The entities, in order; what was reported is missing in them.

        Args:
            bodies: lowers those of the document.
            articulations: makes what lowers its articulations.
        """
        made = self._made(bodies, articulations)
        for name in self._scene.frames:
            self.places.world(name, self._origin.child("frames", name), fixed=False)
        entities: list[Entity] = []
        for one in made:
            pose = self.places.world(one.name, one.origin, fixed=one.fixed)
            scenes = self.selections.get(one.name, self._drawing.everywhere)
            entities.append(Entity(one.name, scenes, pose, one.structures, one.pick, one.hidden, one.origin))
            if one.linked:
                self.linked.append(entities[-1])
        return tuple(entities)

    def _made(self, bodies: BodyLowerer, articulations: Callable[[], ArticulationLowerer]) -> list[_UnplacedEntity]:
        """What the entities are, before any is placed: one may stand relative to a robot of another's file."""
        made: list[_UnplacedEntity] = []
        scopes, of_all = self._names.scopes, self._drawing.leaves()
        linked: ArticulationLowerer | None = None
        for name, entity in self._scene.entities.items():
            place = self._origin.child("entities", name)
            leaves = self.leaves(name) if name in self.selections or name in scopes else of_all
            pick = None
            structures: tuple[BodyStructure, ...]
            if entity.__class__ is BodySpec:
                structures = (bodies.lower(entity, place, leaves),)
            elif "variants" not in entity.__class__.model_fields:
                linked = linked or articulations()
                made += self._linked(name, linked.lower(entity, place, leaves), place, hidden=entity.hidden)
                continue
            else:
                # An expanded document has no others.
                structures, pick = self._variants(entity, place, leaves, bodies)
            fixed = not all(structure.body_type in _MOVING for structure in structures)
            made.append(_UnplacedEntity(name, place, structures, pick, fixed=fixed, hidden=entity.hidden))
        return made

    def _linked(
        self, name: str, built: list[LoweredArticulation], place: Origin, *, hidden: bool
    ) -> list[_UnplacedEntity]:
        """What a robot's file or a tree of links makes."""
        made: list[_UnplacedEntity] = []
        if not built:
            self.places.unread.add(name)
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
            made.append(_UnplacedEntity(full, place, one.structures, one.pick, fixed=still, hidden=hidden, linked=True))
        return made

    def _variants(
        self, entity: Any, origin: Origin, leaves: FieldLowerer, bodies: BodyLowerer
    ) -> tuple[tuple[BodyStructure, ...], Value]:
        """One structure a variant, picked or not, and which of them each scene has."""
        structures = tuple(
            bodies.variant((entity, origin), (variant, origin.child("variants", i)), leaves)
            for i, variant in enumerate(entity.variants)
        )
        last = len(structures) - 1
        pick = leaves.value(entity.pick, FieldType(dtype="int64", within=(0, last)), origin, "pick")
        # What holds an expression is judged as it is drawn.
        wrong = [index for index in pick.numbers() if index > last] if pick.known or pick.bounds.exact else []
        if wrong:
            message = f"there is no variant {wrong[0]:g}: " + (f"they are 0 to {last}" if last else "the only one is 0")
            self._sink.report("SC320", message, origin.child("pick"))
        return structures, pick
