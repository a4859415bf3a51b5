"""Reads the forms of a field as nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin, PathKey, dotted
from scenecc.diagnostics.frozen import frozen
from scenecc.lower.field_types import COMPONENT_TYPES, FieldType, drawn_shape
from scenecc.lower.variation import Variation
from scenecc.variation.chosen import key_text
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import (
    MISSING,
    ONCE,
    SELECTORS,
    Cycle,
    DrawForm,
    Once,
    PerScene,
    RandomRotation,
    SceneMap,
    Shuffle,
    Template,
    Vector,
)
from scenecc.variation.nodes import (
    NODE_TYPES,
    Chosen,
    Computed,
    Converted,
    Cycled,
    Drawn,
    Key,
    RandomRotated,
    Rows,
    Shared,
    Shuffled,
    Stacked,
)
from scenecc.variation.operations import expression_cost, form_cost

if TYPE_CHECKING:
    from scenecc.lower.sampling import FieldScope
    from scenecc.variation.node_bounds import BoundsAnalysis


VARYING = SELECTORS | {DrawForm, RandomRotation, Shuffle, Vector, Template}
"""All types that can replace a plain value."""

FormStep = tuple["PathKey", ...]


@frozen
class FieldPlace:
    """Location of a varying value.

    Attributes:
        origin: its node.
        path: of the field in its object, used as the key of draws.
        word: number of the component, if several share the path.
    """

    origin: Origin
    path: str
    word: int = 0

    def inside(self, step: FormStep) -> FieldPlace:
        """The place of an item of a form."""
        steps = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in step)
        # The path of a shared draw is empty.
        return FieldPlace(self.origin.child(*step), (self.path + steps).removeprefix("."), self.word)

    def key(self, name: str) -> FieldPlace:
        """The place of a key in the mapping."""
        return FieldPlace(self.origin.child(name), f"{self.path}.{name}")


def field_place(origin: Origin) -> FieldPlace:
    """The place of a field of a named object. In a document every field belongs to one."""
    return FieldPlace(origin, _path(origin.path[2:]))


# Copies have the same fields, and few fields have forms.
_path = lru_cache(maxsize=1024)(dotted)


LeafReader = Callable[[Any, FieldPlace, FormStep], Any]
"""Reads a value that is not a selector: (given, place of the enclosing form, steps from there) to an item."""


class VariationLowerer(Variation):
    """Reads the forms of one field.

    Args:
        fields: the scenes and names of its object.
        origin: of the field.
    """

    def __init__(self, fields: FieldScope, origin: Origin) -> None:
        super().__init__()
        fields.sampling.read += 1
        self._fields = fields
        self._section: Any = origin.path[0]
        self._name = str(origin.path[1])

    @property
    def is_random(self) -> bool:
        """Whether its values depend on the seed, directly or through shared draws."""
        return self.drawn or self.seeded or not self._fields.sampling.random.isdisjoint(self.reads)

    def risk(self, node: Any, origin: Origin) -> Any:
        """Gives its origin to a node that may have no value."""
        self.risky = True
        return replace(node, origin=origin)

    @property
    def analysis(self) -> BoundsAnalysis:
        """The bounds analysis for the scenes of the object."""
        return self._fields.analysis

    def item(self, given: Any, kind: FieldType, place: FieldPlace) -> Any:
        """Reads a value as an item: a node, or a plain row."""

        def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
            return self._lower_leaf(one, kind, around, step)

        return self.select(given, place, leaf)

    def select(self, given: Any, place: FieldPlace, leaf: LeafReader, step: FormStep = ()) -> Any:
        """Same as `item`, but `leaf` reads the values inside selectors."""
        if given.__class__ not in SELECTORS:
            return leaf(given, place, step)
        place = place.inside(step) if step else place
        match given:
            case PerScene(items):
                return self._lower_per_scene(items, place, leaf)
            case SceneMap():
                return self._lower_scene_map(given, place, leaf)
            case Once(form):
                return self._lower_once(form, place, leaf)
            case Cycle(items):
                self.cycled = True
                return self._record(Cycled(self._select_each(items, "cycle", place, leaf)), place, items)
            case _:
                self.drawn = True
                items = self._select_each(given.items, "choice", place, leaf)
                node = Chosen(items, given.weights, self._draw_key(place), place.word)
                return self._record(node, place, given.items)

    def _lower_once(self, form: Any, place: FieldPlace, leaf: LeafReader) -> Any:
        """Reads a `once`: drawn like the form inside it, as a shared draw that resets keep."""
        drawn, reads = self.drawn, self.reads
        self.drawn, self.reads = False, set()
        item = self.select(form, replace(place, origin=place.origin.child(ONCE)), leaf)
        if self.drawn or not self._fields.sampling.random.isdisjoint(self.reads):
            item = Shared(self._fields.keep(item, place.origin, self.reads))
            self.reads = {item.name}
        self.drawn, self.reads = drawn, reads | self.reads
        return item

    def _select_each(self, items: tuple[Any, ...], name: str, place: FieldPlace, leaf: LeafReader) -> tuple[Any, ...]:
        return tuple(self.select(one, place, leaf, (name, i)) for i, one in enumerate(items))

    def _lower_per_scene(self, items: tuple[Any, ...], place: FieldPlace, leaf: LeafReader) -> Any:
        scenes = self._fields.listed
        if len(items) != len(scenes):
            self.broken = True
            message = f"{_count(len(items), 'value')} for {_count(len(scenes), 'scene')}"
            hint = "one for each scene that the object is in, by ascending index; or {per_scene: {0: …, default: …}}"
            self._fields.sink.report("SC314", message, place.origin.child("per_scene"), hint=hint)
            return self.select(items[0], place, leaf, ("per_scene", 0)) if items else 0.0
        return Rows(scenes, self._select_each(items, "per_scene", place, leaf))

    def _lower_scene_map(self, given: SceneMap, place: FieldPlace, leaf: LeafReader) -> Any:
        scenes = self._fields.listed
        origin = place.origin.child("per_scene")
        read: dict[int, Any] = {
            scene: self.select(one, place, leaf, ("per_scene", str(scene))) for scene, one in given.items
        }
        default = given.default
        if self._fields.partial and default is MISSING:
            known = tuple(sorted(read))
            return Rows(known, tuple(read[scene] for scene in known))
        if default is not MISSING:
            default = self.select(default, place, leaf, ("per_scene", "default"))
        elif missing := set(scenes) - read.keys():
            self.broken = True
            message = f"there is no value for scene {min(missing)}"
            self._fields.sink.report("SC315", message, origin, hint="add it, or a `default`")
            default = next(iter(read.values()), 0.0)
        # A prefab does not know the scenes of its instances.
        if not self._fields.scope and (extra := read.keys() - set(scenes)):
            scene = min(extra)
            message = f"the object is not in scene {scene}"
            self._fields.sink.report("SC315", message, origin.child(str(scene)), at="key", hint="leave it out")
        return Rows(scenes, tuple(read.get(scene, default) for scene in scenes))

    def _lower_leaf(self, given: Any, kind: FieldType, around: FieldPlace, step: FormStep) -> Any:
        if given.__class__ not in VARYING:
            return self.plain(given, kind, around, step)
        place = around.inside(step) if step else around
        match given:
            case Template():
                return self._lower_expression(given, kind, place)
            case Vector(items):
                return self._lower_vector(items, kind, place)
            case RandomRotation():
                self.drawn = True
                return self._record(RandomRotated(self._draw_key(place)), place)
            case Shuffle(items):
                self.drawn = True
                count, row = len(items), self.plain(items, kind, around, step)
                key = self._draw_key(place, count)
                return self._record(Shuffled(tuple(row[:count]), key, place.word * count, tuple(row[count:])), place)
            case _:
                return self._lower_draw(given, kind, place)

    def plain(self, given: Any, kind: FieldType, around: FieldPlace, step: FormStep) -> Any:
        """Converts a plain value to a row; the kind's fallback after an error."""
        if kind.convert is None:
            return given
        made = kind.convert(given)
        if made is not None:
            return made
        self.broken = True
        if kind.complain is not None:
            kind.complain(given, around.origin.child(*step), self._fields.sink)
        return kind.fallback

    def _lower_expression(self, given: Template, kind: FieldType, place: FieldPlace) -> Any:
        names = self._fields.draw_names(given, place.origin)
        if names is None:
            self.broken = True
            return kind.fallback
        self.computed = True
        self.reads |= set(names.values())
        self.broken |= not self._fields.sampling.rejected.isdisjoint(names.values())
        reads = tuple(sorted((name, draw) for name, draw in names.items() if name != draw))
        shape = None if kind.convert is not None else kind.shape
        record = self._fields.sampling.record
        if record is not None and place.path == "pick" and given.text[2:-1].strip() in names:
            record.picks[self._name] = names[given.text[2:-1].strip()]
        self._fields.sampling.count_operations(expression_cost(given.text, len(self._fields.scenes)), place.origin)
        node = self.risk(Computed(given if given.scope is None else given.within(None), shape, reads), place.origin)
        return node if kind.conversion is None else Converted(node, kind.conversion)

    def _lower_vector(self, items: tuple[Any, ...], kind: FieldType, place: FieldPlace) -> Any:
        one = component(kind)
        # Each row of a matrix has its own words.
        first = place.word * len(items)
        places = (FieldPlace(place.origin.child(j), place.path, first + j) for j in range(len(items)))
        parts = [self.item(item, one, at) for item, at in zip(items, places, strict=True)]
        if kind.pad is not None and len(parts) < kind.shape[0]:
            parts.append(kind.pad)
        return Stacked(tuple(parts))

    def _lower_draw(self, given: DrawForm, kind: FieldType, place: FieldPlace) -> Any:
        self.drawn = True
        drawn = DISTRIBUTIONS[given.kind]
        if kind.free:
            kind = replace(kind, shape=drawn_shape(given.operands))
        single = not kind.shape or (kind.wide and not any(_is_vector(bound) for bound in given.operands))
        one = component(kind) if single else kind
        steps = drawn.steps(len(given.operands))
        items = [self._lower_bound(bound, one, place, step) for bound, step in zip(given.operands, steps, strict=True)]
        for i, role in enumerate(drawn.roles):
            if role == "deviation" and one.pad is not None and _is_vector(items[i]):
                # An omitted component does not vary.
                items[i] = (*items[i][:3], 0.0) if len(given.operands[i]) < len(items[i]) else items[i]
        node = Drawn(given.kind, tuple(items), one.shape, self._draw_key(place, drawn.cost), place.word)
        if not NODE_TYPES.isdisjoint(map(type, items)):
            # Varying bounds may cross in some scene.
            node = self.risk(node, place.origin)
        self._record(node, place)
        return Stacked((node,) * kind.shape[0]) if single and kind.shape else node

    def _lower_bound(self, given: Any, kind: FieldType, place: FieldPlace, step: FormStep) -> Any:
        if given.__class__ in VARYING:
            return self.item(given, replace(kind, conversion=None), place.inside(step))
        if kind.complain is not None and kind.convert is not None:
            # A bound may be an invalid value: 0 is not a direction, but a valid deviation or end of a range.
            made = kind.convert(given)
            return tuple(given) if made is None else made
        return given if kind.convert is None else self.plain(given, kind, place, step)

    def _draw_key(self, place: FieldPlace, cost: int = 1) -> Key:
        sampling = self._fields.sampling
        sampling.count_operations(form_cost(cost * len(self._fields.scenes)), place.origin)
        chosen = None if sampling.record is None else sampling.record.chosen
        found = chosen.get(key_text(self._section, self._name, place.path), ()) if chosen else ()
        return Key(self._section, self._name, place.path, found)

    def _record(self, node: Any, place: FieldPlace, written: tuple[Any, ...] = ()) -> Any:
        """Records what a node draws, if asked for, and returns the node. `written`: items of a choice, as written."""
        record = self._fields.sampling.record
        if record is not None:
            from scenecc.lower.draw_sources import add_sources  # noqa: PLC0415 - only to cover what a file draws

            add_sources(record, node, (self._section, self._name, place.path), self._fields.scenes, place, written)
        return node


def component(kind: FieldType) -> FieldType:
    """The type of one component of a vector, or of one row of a matrix."""
    return COMPONENT_TYPES[kind.dtype] if len(kind.shape) < 2 else replace(kind, shape=kind.shape[1:])


def _is_vector(item: Any) -> bool:
    return isinstance(item, tuple | list | Vector)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
