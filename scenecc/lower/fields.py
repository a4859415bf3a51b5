"""Lowers fields of the language to values of the plan; the shared state of one document's values."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin, PathKey, dotted
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show, suggest_name
from scenecc.lower.field_types import COMPONENT_TYPES, FieldType, drawn_shape
from scenecc.lower.resettable import ResettableValue
from scenecc.lower.value_checks import ValueCheck, check_rows, check_samples, report_draw_failure
from scenecc.plan import Value, literal, per_scene, varying
from scenecc.plan.scene import is_unnamed_draw, kept_draw_name
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
    BUILTIN_NAMES,
    NODE_TYPES,
    Chosen,
    Computed,
    Converted,
    Cycled,
    Drawn,
    Key,
    Node,
    RandomRotated,
    Rows,
    Shared,
    Shuffled,
    Stacked,
    holds_infinity,
)
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, DrawError, OperationCounter, expression_cost, form_cost

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.node_bounds import BoundsAnalysis

_ARRAY_KINDS = {"float64": "fi", "int64": "i", "bool": "b"}
"""NumPy dtype kinds accepted for a field's dtype."""

_VALUE_TYPES = {
    "float64": (frozenset((int, float)), "a number"),
    "int64": (frozenset((int,)), "an integer"),
    "bool": (frozenset((bool,)), "true or false"),
}
"""Accepted value types of a field, and their name."""

RowMaker = Callable[["Batch"], "NDArray[Any]"]
"""Computes the rows (B, …) of a value in a batch."""


class FieldLowerer:
    """Makes values over some scenes and resolves names in one scope.

    Attributes:
        scenes: scenes of the rows.
        listed: scenes of the items of `per_scene` lists.
        scope: name of the instance that the names belong to; "" for the document.
        partial: whether maps by scene may omit scenes, whose values are never read.
    """

    def __init__(
        self,
        sampling: SamplingContext,
        scenes: tuple[int, ...],
        listed: tuple[int, ...],
        scope: str,
        *,
        partial: bool = False,
    ) -> None:
        self.sampling = sampling
        self.partial = partial
        self.scenes = scenes
        self.listed = listed
        self.scope = scope
        self.sink = sampling.sink
        self._batch: Batch | None = None

    def value(self, given: Any, kind: FieldType, owner: Origin, *at: str, reset: bool | None = None) -> Value:
        """Lowers a leaf to a value.

        Args:
            given: from the model.
            kind: of the field.
            owner: of the node that has the field.
            at: keys of the field in the node.
            reset: whether a reset may change it; None: decided by the field's type.
        """
        if given.__class__ not in VARYING:
            return literal(given if kind.convert is None else kind.convert(given), kind.dtype)
        place = field_place(owner.child(*at))
        variation = VariationLowerer(self, place.origin)
        return self.finish(variation.item(given, kind, place), variation, kind, place.origin, reset=reset)

    def optional(self, given: Any, kind: FieldType, owner: Origin, *at: str, reset: bool | None = None) -> Value | None:
        """Same as `value`; None if the key was left out."""
        return None if given is None else self.value(given, kind, owner, *at, reset=reset)

    def finish(
        self, item: Any, variation: VariationLowerer, kind: FieldType, origin: Origin, *, reset: bool | None = None
    ) -> Value:
        """Makes a value from a parsed item: known rows, or a drawn value."""
        reset = kind.reset if reset is None else reset
        if not reset:
            self.fix(variation)
        if item.__class__ not in NODE_TYPES:
            return literal(item, kind.dtype)
        if variation.broken:
            return literal(kind.fallback, kind.dtype)
        if not variation.is_random:
            return self._rows(item, variation, kind, origin)
        self.sampling.drawn = True
        value = self.drawn(partial(self.rows, node=item, kind=kind), lambda: self.analysis.bounds(item))
        if variation.risky:
            value = self.checked(value, item, kind, origin)
        if reset:
            self.sampling.resets[id(value)] = ResettableValue(value, item, variation, self)
        return value

    def drawn(self, rows: RowMaker, bounds: Callable[[], ValueBounds] | None = None) -> Value:
        """Makes a value that is drawn on first access.

        Args:
            rows: computes its rows in a batch.
            bounds: gives its possible values; None: those of the samples.
        """
        return varying(lambda: rows(self.batch()), lambda: rows(self.analysis.samples), self.scenes, bounds=bounds)

    def checked(self, value: Value, node: Node, kind: FieldType, origin: Origin) -> Value:
        """Draws a value and checks its rows and its samples.

        Returns:
            The value; a placeholder after an error; a value without samples after a warning, so that the rules do not
            find the same fault again.
        """
        self.sampling.drawn = True
        if self.sampling.sampling_operations.exhausted:
            return literal(kind.fallback, kind.dtype)
        check = ValueCheck(value, node, kind, self.scenes, origin)
        if not check_rows(check, self):
            return literal(kind.fallback, kind.dtype)
        return value if check_samples(check, self) else value.without_samples()

    def rows(self, batch: Batch, *, node: Node, kind: FieldType) -> NDArray[Any]:
        """The rows (B, …) of a node in a batch, in the format of the field.

        Raises:
            DrawError: it has no value in a scene, or one of another type.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        found = to_field_rows(batch.evaluate(node))
        if found.dtype.kind in _ARRAY_KINDS[kind.dtype] and found.shape[1:] == kind.shape:
            return found.astype(kind.dtype)
        types, words = _VALUE_TYPES[kind.dtype]
        for row, one in enumerate(found.tolist()):
            if not kind.shape and type(one) not in types:
                raise batch.error(f"this expression gives {cut(show(one))}, but {words} is needed", row, node)
        raise batch.error(f"this is not {_described_type(kind)}", 0, node)

    def inside(self, scope: str) -> FieldLowerer:
        """The lowerer of a named object in another scope, over the same scenes. `per_scene` lists cover all scenes."""
        return self.sampling.fields(self.scenes, scope, self.sampling.all_scenes)

    def fix(self, variation: VariationLowerer) -> None:
        """Marks a field, and all shared draws that it reads, as fixed after the build."""
        self.sampling.fixed |= variation.reads

    def keep(self, node: Node, origin: Origin, reads: Iterable[str]) -> str:
        """Adds a shared draw that is fixed after the build, and returns its name.

        Args:
            node: of the value, which depends on the seed.
            origin: of its `once`.
            reads: the shared draws that it reads.
        """
        sampling = self.sampling
        name = kept_draw_name(dotted(origin.path))
        scenes = {*self.scenes, *sampling.scenes_of.get(name, ())}
        sampling.add(name, node, frozenset(reads))
        sampling.scenes_of[name] = tuple(sorted(scenes))
        sampling.fixed.add(name)
        sampling.random.add(name)
        return name

    def keep_infinite(self, value: Value) -> None:
        """Fixes a value after the build if it may be infinite in some scene: the engine cannot change it later."""
        reset = self.sampling.resets.get(id(value))
        if reset is not None and holds_infinity(reset.node, self.sampling.draws):
            del self.sampling.resets[id(value)]
            self.fix(reset.variation)

    def _rows(self, node: Node, variation: VariationLowerer, kind: FieldType, origin: Origin) -> Value:
        """Makes a value with known rows from a node that depends only on the scene index."""
        rows = partial(self.rows, node=node, kind=kind)
        try:
            known = per_scene(rows(self.batch()), kind.dtype)
        except DrawError as error:
            report_draw_failure(error, origin, self.sampling)
            return literal(kind.fallback, kind.dtype)
        if variation.computed:
            check_rows(ValueCheck(known, node, kind, self.scenes, origin), self)
        if variation.cycled:
            # Also checks alternatives that no scene uses.
            found = self.analysis.bounds(node)
            if found.alternatives is None or len(found.alternatives) > len(known.bounds.alternatives or ()):
                return self.drawn(rows, lambda: found)
        return known

    def evaluate(self, node: Node) -> NDArray[Any]:
        """A node's rows in the scenes, in the format of the field.

        Raises:
            DrawError: it has no value in some scene.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        return to_field_rows(self.batch().evaluate(node))

    @property
    def analysis(self) -> BoundsAnalysis:
        """The bounds analysis for the scenes."""
        return self.sampling.analysis(self.scenes)

    def batch(self) -> Batch:
        """A batch of the scenes."""
        if self._batch is None:
            import numpy as np  # noqa: PLC0415 - checking a scene in which nothing varies needs none

            from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - see above

            scenes = np.array(self.scenes, dtype=np.int64)
            sampling = self.sampling
            self._batch = Batch(scenes, sampling.seed, sampling.num_scenes, sampling.draws, {}, sampling.computed)
            self._batch.placed = sampling.placed
        return self._batch

    def draw_names(self, template: Template, origin: Origin) -> dict[str, str] | None:
        """The shared draws that an expression reads, by name in the expression; None if one is unknown."""
        scope = self.scope if template.scope is None else template.scope
        prefix = f"{scope}/" if scope else ""
        draws = self.sampling.draws
        names = {name: prefix + name for name in template.names - BUILTIN_NAMES}
        for name, full in names.items():
            if full not in draws:
                known = (draw[len(prefix) :] for draw in draws if draw.startswith(prefix) and not is_unnamed_draw(draw))
                hint = suggest_name(name, known, self.sink)
                message = f"there is no parameter, loop variable or draw `{cut(name)}` here"
                self.sink.report("SC201", message, origin, hint=hint)
                return None
        self.sampling.used |= set(names.values())
        return names


def _described_type(kind: FieldType) -> str:
    one = _VALUE_TYPES[kind.dtype][1]
    return f"a list of {kind.shape[0]} numbers" if kind.shape else one


_RECOMPUTATIONS = 4
"""How often a computed value may be recomputed."""


@dataclass(slots=True)
class SamplingContext:
    """The shared state of one document's values.

    Attributes:
        seed, num_scenes: of the batch.
        sink: receives the diagnostics.
        most: limit of operations.
        draws: the shared draws by full name; filled before anything reads them.
        unplaced: checks of values that depend on placements, with the lowerers of their objects.
        used: shared draws with at least one reader.
        fixed: shared draws with a reader that is fixed after the build.
        reads: shared draw → shared draws that it reads.
        scenes_of: shared draw → scenes in which it has a value.
        random: shared draws that depend on the seed, directly or through others.
        failed, warned: origins of the nodes without a value that were reported: in a scene, in a sample.
        drawn: whether any value must be drawn.
        read: number of fields with forms or expressions.
        resets: values that a reset may change, by identity: node and variation.
        sampling_operations: operations of sampling and bounds analysis.
        placed: poses (num_scenes, 7) of placements, once they are made.
        computed: operations of the draw stage so far, including recomputations.
    """

    seed: int
    num_scenes: int
    sink: Sink
    most: int
    draws: dict[str, Node] = field(default_factory=dict[str, "Node"])
    unplaced: list[tuple[ValueCheck, FieldLowerer]] = field(default_factory=list[tuple[ValueCheck, FieldLowerer]])
    used: set[str] = field(default_factory=set[str])
    fixed: set[str] = field(default_factory=set[str])
    reads: dict[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    scenes_of: dict[str, tuple[int, ...]] = field(default_factory=dict[str, "tuple[int, ...]"])
    random: set[str] = field(default_factory=set[str])
    failed: set[Origin] = field(default_factory=set["Origin"])
    warned: set[Origin] = field(default_factory=set["Origin"])
    drawn: bool = False
    read: int = 0
    resets: dict[int, ResettableValue] = field(default_factory=dict[int, "ResettableValue"])
    all_scenes: tuple[int, ...] = ()
    placed: dict[str, NDArray[Any]] = field(default_factory=dict[str, "NDArray[Any]"])
    sampling_operations: OperationCounter = field(init=False)
    computed: OperationCounter = field(init=False)
    _analyses: dict[int, BoundsAnalysis] = field(default_factory=dict[int, "BoundsAnalysis"])
    _fields: dict[tuple[int, int, str], FieldLowerer] = field(default_factory=dict[tuple[int, int, str], FieldLowerer])

    def __post_init__(self) -> None:
        self.all_scenes = tuple(range(self.num_scenes))
        self.sampling_operations = OperationCounter(self.most)
        self.computed = OperationCounter(_RECOMPUTATIONS * self.most)

    def count_operations(self, operations: int, origin: Origin) -> None:
        """Counts operations of the draw stage, and reports when they exceed the limit."""
        within = not self.sampling_operations.exhausted
        self.sampling_operations.done += operations
        if within and self.sampling_operations.exhausted:
            self.sink.report("SC604", self.sampling_operations.message, origin, hint=COMPUTE_LIMIT_HINT)

    def analysis(self, scenes: tuple[int, ...] | None = None) -> BoundsAnalysis:
        """The bounds analysis for some scenes; None: all."""
        scenes = self.all_scenes if scenes is None else scenes
        # By identity, since objects share the tuples of their scenes. The analyses keep the tuples alive.
        found = self._analyses.get(id(scenes))
        if found is None:
            from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - loaded where something varies

            found = BoundsAnalysis(self.draws, {}, self.num_scenes, scenes, self.sampling_operations)
            self._analyses[id(scenes)] = found
        return found

    @property
    def varies(self) -> bool:
        """Whether any value is drawn."""
        return bool(self.draws or self.drawn)

    def add(self, name: str, node: Node, reads: frozenset[str]) -> None:
        """Adds a shared draw. `reads`: the draws that it reads, which must already be added."""
        self.draws[name] = node
        self.reads[name] = reads
        found = node.scene_idxs if isinstance(node, Rows) else self.all_scenes
        for other in reads:
            limits = self.scenes_of[other]
            if limits is not self.all_scenes:
                found = limits if found is self.all_scenes else tuple(sorted(set(found).intersection(limits)))
        self.scenes_of[name] = found

    def fields(
        self, scenes: tuple[int, ...] | None = None, scope: str = "", listed: tuple[int, ...] | None = None
    ) -> FieldLowerer:
        """The field lowerer of an object.

        Args:
            scenes: of the object; None: all.
            scope: for its names.
            listed: the scenes of its `per_scene` lists, if not `scenes`.
        """
        scenes = self.all_scenes if scenes is None else scenes
        listed = scenes if listed is None else listed
        # By identity, since objects share the tuples of their scenes. The lowerers keep the tuples alive.
        key = (id(scenes), id(listed), scope)
        found = self._fields.get(key)
        if found is None:
            found = self._fields[key] = FieldLowerer(self, scenes, listed, scope)
        return found


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


class VariationLowerer:
    """Reads the forms of one field.

    Attributes:
        drawn: whether it has draws of its own.
        computed: whether it has expressions.
        seeded: whether it contains drawn rows that a reset keeps.
        broken: whether an error was reported, so that it holds a placeholder.
        reads: shared draws that it reads by expressions or through `once`.
        cycled: whether it has alternatives that no scene may use.
        risky: whether it may have no value or an out-of-range value in some scene.
    """

    def __init__(self, fields: FieldLowerer, origin: Origin) -> None:
        fields.sampling.read += 1
        self._fields = fields
        self._section: Any = origin.path[0]
        self._name = str(origin.path[1])
        self.drawn = False
        self.computed = False
        self.seeded = False
        self.cycled = False
        self.risky = False
        self.broken = False
        self.reads: set[str] = set()

    @property
    def is_random(self) -> bool:
        """Whether its values depend on the seed, directly or through shared draws."""
        return self.drawn or self.seeded or not self._fields.sampling.random.isdisjoint(self.reads)

    def join(self, other: VariationLowerer) -> None:
        """Merges the variation of another field that this value is computed from."""
        self.drawn |= other.drawn
        self.computed |= other.computed
        self.seeded |= other.seeded
        self.cycled |= other.cycled
        self.risky |= other.risky
        self.broken |= other.broken
        self.reads |= other.reads

    def risk(self, node: Any, origin: Origin) -> Any:
        """Gives its origin to a node that may have no value."""
        self.risky = True
        return replace(node, origin=origin)

    def item(self, given: Any, kind: FieldType, place: FieldPlace) -> Any:
        """Reads a value as an item: a node, or a plain row."""

        def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
            return self._leaf(one, kind, around, step)

        return self.select(given, place, leaf)

    def select(self, given: Any, place: FieldPlace, leaf: LeafReader, step: FormStep = ()) -> Any:
        """Same as `item`, but `leaf` reads the values inside selectors."""
        if given.__class__ not in SELECTORS:
            return leaf(given, place, step)
        place = place.inside(step) if step else place
        match given:
            case PerScene(items):
                return self._per_scene(items, place, leaf)
            case SceneMap():
                return self._by_scene(given, place, leaf)
            case Once(form):
                return self._kept(form, place, leaf)
            case Cycle(items):
                self.cycled = True
                return Cycled(self._each(items, "cycle", place, leaf))
            case _:
                self.drawn = True
                items = self._each(given.items, "choice", place, leaf)
                return Chosen(items, given.weights, self._key(place), place.word)

    def _kept(self, form: Any, place: FieldPlace, leaf: LeafReader) -> Any:
        """Reads a `once`: drawn like the form inside it, as a shared draw that resets keep."""
        drawn, reads = self.drawn, self.reads
        self.drawn, self.reads = False, set()
        item = self.select(form, replace(place, origin=place.origin.child(ONCE)), leaf)
        if self.drawn or not self._fields.sampling.random.isdisjoint(self.reads):
            item = Shared(self._fields.keep(item, place.origin, self.reads))
            self.reads = {item.name}
        self.drawn, self.reads = drawn, reads | self.reads
        return item

    def _each(self, items: tuple[Any, ...], name: str, place: FieldPlace, leaf: LeafReader) -> tuple[Any, ...]:
        return tuple(self.select(one, place, leaf, (name, i)) for i, one in enumerate(items))

    def _per_scene(self, items: tuple[Any, ...], place: FieldPlace, leaf: LeafReader) -> Any:
        scenes = self._fields.listed
        if len(items) != len(scenes):
            self.broken = True
            message = f"{_count(len(items), 'value')} for {_count(len(scenes), 'scene')}"
            hint = "one for each scene that the object is in, by ascending index; or {per_scene: {0: …, default: …}}"
            self._fields.sink.report("SC314", message, place.origin.child("per_scene"), hint=hint)
            return self.select(items[0], place, leaf, ("per_scene", 0)) if items else 0.0
        return Rows(scenes, self._each(items, "per_scene", place, leaf))

    def _by_scene(self, given: SceneMap, place: FieldPlace, leaf: LeafReader) -> Any:
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

    def _leaf(self, given: Any, kind: FieldType, around: FieldPlace, step: FormStep) -> Any:
        if given.__class__ not in VARYING:
            return self.plain(given, kind, around, step)
        place = around.inside(step) if step else around
        match given:
            case Template():
                return self._computed(given, kind, place)
            case Vector(items):
                return self._stacked(items, kind, place)
            case RandomRotation():
                self.drawn = True
                return RandomRotated(self._key(place))
            case Shuffle(items):
                self.drawn = True
                count, row = len(items), self.plain(items, kind, around, step)
                return Shuffled(tuple(row[:count]), self._key(place, count), place.word * count, tuple(row[count:]))
            case _:
                return self._drawn(given, kind, place)

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

    def _computed(self, given: Template, kind: FieldType, place: FieldPlace) -> Any:
        names = self._fields.draw_names(given, place.origin)
        if names is None:
            self.broken = True
            return kind.fallback
        self.computed = True
        self.reads |= set(names.values())
        reads = tuple(sorted((name, draw) for name, draw in names.items() if name != draw))
        shape = None if kind.convert is not None else kind.shape
        self._fields.sampling.count_operations(expression_cost(given.text, len(self._fields.scenes)), place.origin)
        node = self.risk(Computed(given if given.scope is None else given.within(None), shape, reads), place.origin)
        return node if kind.conversion is None else Converted(node, kind.conversion)

    def _stacked(self, items: tuple[Any, ...], kind: FieldType, place: FieldPlace) -> Any:
        one = component(kind)
        # Each row of a matrix has its own words.
        first = place.word * len(items)
        places = (FieldPlace(place.origin.child(j), place.path, first + j) for j in range(len(items)))
        parts = [self.item(item, one, at) for item, at in zip(items, places, strict=True)]
        if kind.pad is not None and len(parts) < kind.shape[0]:
            parts.append(kind.pad)
        return Stacked(tuple(parts))

    def _drawn(self, given: DrawForm, kind: FieldType, place: FieldPlace) -> Any:
        self.drawn = True
        drawn = DISTRIBUTIONS[given.kind]
        if kind.free:
            kind = replace(kind, shape=drawn_shape(given.operands))
        single = not kind.shape or (kind.wide and not any(_is_vector(bound) for bound in given.operands))
        one = component(kind) if single else kind
        steps = drawn.steps(len(given.operands))
        items = [self._bound(bound, one, place, step) for bound, step in zip(given.operands, steps, strict=True)]
        for i, role in enumerate(drawn.roles):
            if role == "deviation" and one.pad is not None and _is_vector(items[i]):
                # An omitted component does not vary.
                items[i] = (*items[i][:3], 0.0) if len(given.operands[i]) < len(items[i]) else items[i]
        node = Drawn(given.kind, tuple(items), one.shape, self._key(place, drawn.cost), place.word)
        if not NODE_TYPES.isdisjoint(map(type, items)):
            # Varying bounds may cross in some scene.
            node = self.risk(node, place.origin)
        return Stacked((node,) * kind.shape[0]) if single and kind.shape else node

    def _bound(self, given: Any, kind: FieldType, place: FieldPlace, step: FormStep) -> Any:
        if given.__class__ in VARYING:
            return self.item(given, replace(kind, conversion=None), place.inside(step))
        if kind.complain is not None and kind.convert is not None:
            # A bound may be an invalid value: 0 is not a direction, but a valid deviation or end of a range.
            made = kind.convert(given)
            return tuple(given) if made is None else made
        return given if kind.convert is None else self.plain(given, kind, place, step)

    def _key(self, place: FieldPlace, cost: int = 1) -> Key:
        self._fields.sampling.count_operations(form_cost(cost * len(self._fields.scenes)), place.origin)
        return Key(self._section, self._name, place.path)


def component(kind: FieldType) -> FieldType:
    """The type of one component of a vector, or of one row of a matrix."""
    return COMPONENT_TYPES[kind.dtype] if len(kind.shape) < 2 else replace(kind, shape=kind.shape[1:])


def _is_vector(item: Any) -> bool:
    return isinstance(item, tuple | list | Vector)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
