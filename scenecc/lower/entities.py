"""Lowers entities and their bodies: poses and structures."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.lower.collision_groups import GroupBits, find_group
from scenecc.lower.field_types import BODY_FIELDS, COLOR, FieldType, report_unused_key
from scenecc.lower.fields import fields_of
from scenecc.lower.frames import FrameGraph
from scenecc.lower.local_poses import lower_inertial
from scenecc.lower.materials import DENSITY, LoweredMaterial, MaterialChoice, MaterialLowerer
from scenecc.lower.shapes import ShapeDefaults, ShapeLowerer
from scenecc.plan import BodyStructure, Entity, Inertial, literal
from scenecc.plan.properties import Bounds
from scenecc.spec.body import BodySpec
from scenecc.spec.pose import PoseMapping
from scenecc.spec.references import NameScopes, qualified_name, resolve_scene_idxs
from scenecc.variation.forms import Template

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.articulations.articulations import ArticulationLowerer, LoweredArticulation
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan import ArticulationStructure, Value
    from scenecc.robots.description import DescribedConstraint
    from scenecc.spec.document import SceneFile

_MOVING = frozenset(("dynamic", "kinematic"))
"""Bodies whose poses a running simulation can change."""


@frozen
class _UnplacedEntity:
    """An entity without a pose yet.

    Attributes:
        fixed: whether it is fixed after the build.
        frame: name of its frame; "": its own.
    """

    name: str
    origin: Origin
    structures: tuple[BodyStructure | ArticulationStructure, ...]
    pick: Value | None
    fixed: bool
    hidden: bool
    linked: bool = False
    frame: str = ""


class EntityLowerer:
    """Lowers the entities of a document.

    Attributes:
        selections: by name, the scenes of each object that is not in all of them, including constraints, lights and
            cameras.
        frames: poses of entities and frames.
        linked: entities that are articulations or come from robot files, once lowered.

    Args:
        scene: the document.
        narrowed: the scenes of entities and frames in instances with fewer scenes.
        sampling: of the document.
        names: of the document.
        origin: of its root.
        sink: receives the diagnostics.
    """

    def __init__(
        self,
        scene: SceneFile,
        narrowed: Mapping[str, tuple[int, ...]],
        sampling: SamplingContext,
        names: NameScopes,
        origin: Origin,
        sink: Sink,
    ) -> None:
        self._scene = scene
        self._sampling = sampling
        self._names = names
        self._origin = origin
        self._sink = sink
        self.selections = self._select(narrowed)
        self.linked: list[Entity] = []
        # By name: constraints of robot files, the entities of their roots, and the written entity's origin.
        self.constraints: dict[str, tuple[DescribedConstraint, dict[str, str], Origin]] = {}
        free = {name: camera for name, camera in scene.cameras.items() if camera.mount is None}
        sections = {"frames": scene.frames, "entities": scene.entities, "cameras": free}
        self.frames = FrameGraph(sections, self.fields, names, origin, sink)

    def _select(self, narrowed: Mapping[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
        selections = dict(narrowed)
        for section in ("entities", "cameras", "constraints", "lights"):
            nodes: Mapping[str, Any] = getattr(self._scene, section)
            for name, node in nodes.items():
                known = qualified_name(section, name)
                if node.scene_idxs is not None and known not in narrowed:
                    place = self._origin.child(section, name, "scene_idxs")
                    selected = resolve_scene_idxs(node.scene_idxs, self._sampling.num_scenes, place, self._sink)
                    if selected is not None:
                        selections[known] = selected
        return selections

    def fields(self, name: str) -> FieldLowerer:
        """The field lowerer of an object, over its scenes. `name`: its full name."""
        return fields_of(self._sampling, self.selections.get(name), self._names.scopes.get(name, ""))

    def lower(self, bodies: BodyLowerer, articulations: Callable[[], ArticulationLowerer]) -> tuple[Entity, ...]:
        """Lowers the entities in order; invalid parts are left out.

        Args:
            bodies: lowers those of the document.
            articulations: makes the lowerer of its articulations.
        """
        made = self._lower_structures(bodies, articulations)
        for one in made:
            self.frames.structures[one.name] = one.structures, one.pick
            linked = tuple(each for each in one.structures if not isinstance(each, BodyStructure))
            if linked:
                self.frames.articulations[one.name] = linked, one.pick
        for name in self._scene.frames:
            self.frames.world(name, self._origin.child("frames", name), fixed=False)
        entities: list[Entity] = []
        for one in made:
            pose = self.frames.world(one.frame or one.name, one.origin, fixed=one.fixed)
            scenes = self.selections.get(one.name, self._sampling.all_scenes)
            entities.append(Entity(one.name, scenes, pose, one.structures, one.pick, one.hidden, one.origin))
            if one.linked:
                self.linked.append(entities[-1])
        return tuple(entities)

    def _lower_structures(
        self, bodies: BodyLowerer, articulations: Callable[[], ArticulationLowerer]
    ) -> list[_UnplacedEntity]:
        """Lowers the structures of all entities before any pose, which may be relative to another entity's link."""
        made: list[_UnplacedEntity] = []
        scopes, of_all = self._names.scopes, fields_of(self._sampling)
        linked: ArticulationLowerer | None = None
        for name, entity in self._scene.entities.items():
            place = self._origin.child("entities", name)
            fields = self.fields(name) if name in self.selections or name in scopes else of_all
            pick = None
            structures: tuple[BodyStructure, ...]
            if entity.__class__ is BodySpec:
                structures = (bodies.lower(entity, place, fields),)
            elif "variants" not in entity.__class__.model_fields:
                linked = linked or articulations()
                made += self._lower_linked(name, linked.lower(entity, place, fields), place, hidden=entity.hidden)
                continue
            else:
                # The other entities of an expanded document are bodies.
                structures, pick = self._variants(entity, place, fields, bodies)
            fixed = not all(structure.body_type in _MOVING for structure in structures)
            made.append(_UnplacedEntity(name, place, structures, pick, fixed=fixed, hidden=entity.hidden))
        return made

    def _lower_linked(
        self, name: str, built: list[LoweredArticulation], place: Origin, *, hidden: bool
    ) -> list[_UnplacedEntity]:
        """Lowers a robot file or a link tree."""
        made: list[_UnplacedEntity] = []
        if not built:
            self.frames.unread.add(name)
        full_names = {one.root: name if len(built) == 1 else f"{name}/{one.suffix}" for one in built}
        for constraint in built[0].constraints if built else ():
            self.constraints[f"{name}/{constraint.name}"] = constraint, full_names, place
        for one in built:
            frame = name
            if one.pose is not None:
                frame = f"{name}/{one.suffix}"
                x, y, z, *q = one.pose
                pose = PoseMapping.model_construct(p=(x, y, z), q=tuple(q), relative_to=name)
                self.frames.add(frame, place, SimpleNamespace(pose=pose))
                if name in self.selections:
                    self.selections[frame] = self.selections[name]
                if frame in self._scene.entities:
                    message = f"`{frame}` names both an entity and a robot of a file"
                    related = [("the entity", self._origin.child("entities", frame), "key")]
                    self._sink.report("SC305", message, place, at="key", related=related)  # pyright: ignore[reportArgumentType]
            still = all(isinstance(body, BodyStructure) and body.body_type == "static" for body in one.structures)
            full = name if len(built) == 1 else frame
            made.append(
                _UnplacedEntity(
                    full, place, one.structures, one.pick, fixed=still, hidden=hidden, linked=True, frame=frame
                )
            )
        return made

    def _variants(
        self, entity: Any, origin: Origin, fields: FieldLowerer, bodies: BodyLowerer
    ) -> tuple[tuple[BodyStructure, ...], Value]:
        """One structure per variant, used or not, and the pick of each scene."""
        structures = tuple(
            bodies.variant((entity, origin), (variant, origin.child("variants", i)), fields)
            for i, variant in enumerate(entity.variants)
        )
        last = len(structures) - 1
        pick = fields.value(entity.pick, FieldType(dtype="int64", within=Bounds(0, last)), origin, "pick")
        # The field type checks the rows and samples of expressions.
        is_checked = entity.pick.__class__ is Template or not (pick.known or pick.bounds.exact)
        wrong = [] if is_checked else [index for index in pick.numbers() if index > last]
        if wrong:
            message = f"there is no variant {wrong[0]:g}: " + (f"they are 0 to {last}" if last else "the only one is 0")
            self._sink.report("SC320", message, origin.child("pick"))
        return structures, pick


Layer = tuple[Any, "Origin"]
"""Keys of a body and their node. Later layers have precedence."""

LayerDefaults = tuple["LoweredMaterial | MaterialChoice | None", "Value | None", "Value | None"]
"""Material, colour and density of a layer; None if not given."""


_BODY_KEYS = frozenset(BODY_FIELDS)

_NUMBERS = frozenset((int, float))

_NO_DEFAULTS = ShapeDefaults()

_SHAPE_DEFAULTS = (
    ("color", "visible", ("shapes", "visuals")),
    ("density", "collision", ("shapes", "collisions")),
    ("collision_group", "collision", ("shapes", "collisions")),
)
"""Keys of a body that are defaults for shapes, their kind, and the lists that they apply to."""


class BodyLowerer:
    """Lowers the bodies of a document."""

    def __init__(
        self, shapes: ShapeLowerer, materials: MaterialLowerer, groups: dict[str, GroupBits], sink: Sink
    ) -> None:
        self._shapes = shapes
        self._materials = materials
        self._groups = groups
        self._sink = sink
        self._by_surface: dict[int, ShapeDefaults] = {}
        self._last: tuple[Origin, LayerDefaults] | None = None

    def lower(self, body: Any, origin: Origin, fields: FieldLowerer) -> BodyStructure:
        """Lowers a body. Shapes with errors are left out."""
        if body.color is not None or body.density is not None or body.collision_group is not None:
            self._does_something(body, body, origin)
        return self._structure(body.body_type, ((body, origin),), fields)

    def variant(self, common: Layer, own: Layer, fields: FieldLowerer) -> BodyStructure:
        """Lowers one variant: shape lists are appended to the common ones, other keys replace them."""
        self._does_something(own[0], common[0], own[1])
        typed = next((body for body, _ in (own, common) if "body_type" in body.model_fields_set), common[0])
        return self._structure(typed.body_type, (common, own), fields)

    def _structure(self, body_type: Any, layers: tuple[Layer, ...], fields: FieldLowerer) -> BodyStructure:
        default = self._defaults(layers, fields)
        collisions, visuals = self._shapes.shapes(layers, default, fields)
        properties: dict[str, Value] = {}
        for body, origin in layers:
            self._lower_properties(body, origin, fields, properties)
        # An empty `shapes` is intended; without the key, shapes were forgotten.
        meant = not (collisions or visuals) and any("shapes" in body.model_fields_set for body, _ in layers)
        return BodyStructure(
            body_type=body_type,
            collisions=tuple(collisions),
            visuals=tuple(visuals),
            inertial=self._inertial(layers, fields),
            shapeless=meant or None,
            origin=layers[-1][1],
            **properties,
        )

    def _does_something(self, body: Any, common: Any, origin: Origin) -> None:
        for key, kind, lists in _SHAPE_DEFAULTS:
            if getattr(body, key) is not None and not any(getattr(one, key) for one in (body, common) for key in lists):
                report_unused_key(key, f"on a body without a {kind} shape", origin, self._sink)

    def _defaults(self, layers: tuple[Layer, ...], fields: FieldLowerer) -> ShapeDefaults:
        found = _NO_DEFAULTS
        if len(layers) == 1 and layers[0][0].color is None and layers[0][0].density is None:
            # Shortcut: many bodies have a material and nothing else.
            surface = self._materials.surface(layers[0][0].material, layers[0][1], fields)
            return found if surface is None else self._surface_defaults(surface)
        for layer in layers:
            body = layer[0]
            if body.material is None and body.color is None and body.density is None:
                continue
            surface, color, density = self._lower_defaults(layer, fields)
            found = ShapeDefaults(
                found.surface if surface is None else surface,
                found.color if color is None else color,
                found.density if density is None else density,
            )
        return found

    def _lower_defaults(self, layer: Layer, fields: FieldLowerer) -> LayerDefaults:
        """The shape defaults of a layer. The variants of an entity share a layer, which is lowered once."""
        body, origin = layer
        if self._last is None or self._last[0] is not origin:
            surface = self._materials.surface(body.material, origin, fields)
            color = fields.optional(body.color, COLOR, origin, "color")
            density = fields.optional(body.density, DENSITY, origin, "density")
            self._last = origin, (surface, color, density)
        return self._last[1]

    def _surface_defaults(self, surface: LoweredMaterial | MaterialChoice) -> ShapeDefaults:
        known = self._by_surface.get(id(surface))
        if known is None:
            known = self._by_surface[id(surface)] = ShapeDefaults(surface)
        return known

    def _lower_properties(self, body: Any, origin: Origin, fields: FieldLowerer, properties: dict[str, Value]) -> None:
        given = body.model_fields_set
        for name in _BODY_KEYS & given:
            field, kind = BODY_FIELDS[name]
            item = getattr(body, name)
            if item.__class__ in _NUMBERS and kind.convert is None:
                properties[field] = literal(item, kind.dtype)
            else:
                properties[field] = fields.value(item, kind, origin, name)
        if body.collision_group is None:
            return
        place = origin.child("collision_group")
        bits = find_group(self._groups, body.collision_group, place, fields.scope, self._sink)
        if bits is not None:
            properties["collision_groups"] = literal(bits, "int64")

    def _inertial(self, layers: tuple[Layer, ...], fields: FieldLowerer) -> Inertial | None:
        for body, origin in reversed(layers):
            if body.inertial is not None:
                return lower_inertial(body.inertial, origin, fields)
        return None
