"""Fields of the language to values of the plan, and what the values of one document have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin, PathKey, dotted
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show, suggest_name
from scenecc.lower.deferred_checks import (
    DeferredCheck,
    ResettableValue,
    VaryingArgument,
    check_rows,
    check_samples,
    report_draw_failure,
)
from scenecc.lower.field_types import COMPONENT_TYPES, FieldType, drawn_shape
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
"""Kinds of arrays that become a field's."""

_VALUE_TYPES = {
    "float64": (frozenset((int, float)), "a number"),
    "int64": (frozenset((int,)), "an integer"),
    "bool": (frozenset((bool,)), "true or false"),
}
"""The types of the values of a field, and their name."""

RowMaker = Callable[["Batch"], "NDArray[Any]"]
"""Gives the rows (B, …) of a value in a batch."""


class FieldLowerer:
    """Makes values over some scenes, reading names in one scope.

    Attributes:
        scenes: that the rows of the values follow.
        listed: that the items of `per_scene` lists follow.
        scope: the name of the instance that the names belong to; "" for the document.
        partial: whether maps by scene may leave out scenes, whose values are never read.
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
        """A leaf as a value.

        Args:
            given: as the models have it.
            kind: of the field.
            owner: of the node that has the field.
            at: the field's keys there.
            reset: whether a reset may change it; None: the type of the field says so.
        """
        if given.__class__ not in VARYING:
            return literal(given if kind.convert is None else kind.convert(given), kind.dtype)
        place = field_place(owner.child(*at))
        variation = VariationLowerer(self, place.origin)
        return self.finish(variation.item(given, kind, place), variation, kind, place.origin, reset=reset)

    def optional(self, given: Any, kind: FieldType, owner: Origin, *at: str, reset: bool | None = None) -> Value | None:
        """As `value`; None where the key was left out."""
        return None if given is None else self.value(given, kind, owner, *at, reset=reset)

    def finish(
        self, item: Any, variation: VariationLowerer, kind: FieldType, origin: Origin, *, reset: bool | None = None
    ) -> Value:
        """An item that was read as a value: of what is known by scene the rows, of the rest how they are drawn."""
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
            self.defer(value, item, partial(self.rows, node=item, kind=kind), kind, origin, variation)
        if reset:
            self.sampling.resets[id(value)] = ResettableValue(value, item, variation, self)
        return value

    def drawn(self, rows: RowMaker, bounds: Callable[[], ValueBounds] | None = None) -> Value:
        """A value that is drawn when it is first asked for.

        Args:
            rows: gives its rows in a batch.
            bounds: gives the values that it can have; None: those of the samples.
        """
        return varying(lambda: rows(self.batch()), lambda: rows(self.analysis.samples), self.scenes, bounds=bounds)

    def defer(
        self,
        value: Value,
        node: Node,
        rows: RowMaker,
        kind: FieldType,
        origin: Origin,
        variation: VariationLowerer,
    ) -> None:
        """Checks the samples of a value that is drawn, and defers the check of its rows until then."""
        deferred = DeferredCheck(value, node, rows, kind, self.scenes, origin, variation.origins)
        check_samples(deferred, self)
        self.sampling.deferred.append(deferred)

    def rows(self, batch: Batch, *, node: Node, kind: FieldType) -> NDArray[Any]:
        """The rows (B, …) of a node in a batch, as a field has them.

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
        """The lowerer of a named object in another scope, over the same scenes; `per_scene` lists cover all scenes."""
        return self.sampling.fields(self.scenes, scope, self.sampling.all_scenes)

    def fix(self, variation: VariationLowerer) -> None:
        """Notes that a field stays as it is built, and with it all shared draws that it reads."""
        self.sampling.fixed |= variation.reads

    def keep(self, node: Node, origin: Origin, reads: Iterable[str]) -> str:
        """Makes a value a shared draw that stays as it is built, and returns its name.

        Args:
            node: of the value, which a seed decides.
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
        """Has a value stay as it is built if it may be infinite in some scene: the engine cannot change that later."""
        reset = self.sampling.resets.get(id(value))
        if reset is not None and holds_infinity(reset.node, self.sampling.draws):
            del self.sampling.resets[id(value)]
            self.fix(reset.variation)

    def _rows(self, node: Node, variation: VariationLowerer, kind: FieldType, origin: Origin) -> Value:
        """A node that the scene's index decides as a value whose rows are known."""
        rows = partial(self.rows, node=node, kind=kind)
        try:
            known = per_scene(rows(self.batch()), kind.dtype)
        except DrawError as error:
            report_draw_failure(error, {**self.sampling.draw_origins, **variation.origins}, origin, self.sink)
            return literal(kind.fallback, kind.dtype)
        if variation.computed:
            check_rows(DeferredCheck(known, node, rows, kind, self.scenes, origin, {}), self.sampling, self.sink)
        if variation.cycled:
            # Values that no scene has are checked too.
            found = self.analysis.bounds(node)
            if found.alternatives is None or len(found.alternatives) > len(known.bounds.alternatives or ()):
                return self.drawn(rows, lambda: found)
        return known

    def evaluate(self, node: Node) -> NDArray[Any]:
        """A node's rows in the scenes, as a field takes them.

        Raises:
            DrawError: it has none in some scene.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        return to_field_rows(self.batch().evaluate(node))

    @property
    def analysis(self) -> BoundsAnalysis:
        """The analysis of the bounds of nodes in the scenes."""
        return self.sampling.analysis(self.scenes)

    def batch(self) -> Batch:
        """The scenes, as draws are made for them."""
        if self._batch is None:
            import numpy as np  # noqa: PLC0415 - checking a scene in which nothing varies needs none

            from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - likewise

            scenes = np.array(self.scenes, dtype=np.int64)
            sampling = self.sampling
            self._batch = Batch(scenes, sampling.seed, sampling.num_scenes, sampling.draws, {}, sampling.computed)
            self._batch.placed = sampling.placed
        return self._batch

    def draw_names(self, template: Template, origin: Origin) -> dict[str, str] | None:
        """The shared draws that an expression reads, by the names that it has for them; None where one is unknown."""
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
"""How often what is computed may be computed again."""


@dataclass(slots=True)
class SamplingContext:
    """What the values of one document have in common.

    Attributes:
        seed, num_scenes: of the batch.
        sink: takes the diagnostics.
        most: operations that its values may take.
        draws: the shared draws by their full names; filled before anything reads them.
        deferred: the values that the draw stage judges.
        arguments: what parameters are given that it judges.
        used: the shared draws that anything reads.
        fixed: those that something reads which stays as it is built.
        reads: for each shared draw, those that it reads.
        scenes_of: for each shared draw, the scenes that it has a value in.
        random: the shared draws that a seed decides, by themselves or through others.
        draw_origins: of the nodes in shared draws that can have no value, by identity.
        failed: nodes that have no value in a sample and were reported, by identity.
        drawn: whether any value is to be drawn.
        read: how many fields with forms or expressions were read.
        resets: what a reset may change: its value by identity, its node, and what was read of it.
        sampling_operations: operations of sampling, and of the analysis of its bounds.
        placed: poses (num_scenes, 7) of what is placed, once it is.
        computed: operations of the draw stage as they are done; some do again what others have done.
    """

    seed: int
    num_scenes: int
    sink: Sink
    most: int
    draws: dict[str, Node] = field(default_factory=dict[str, "Node"])
    deferred: list[DeferredCheck] = field(default_factory=list["DeferredCheck"])
    arguments: list[VaryingArgument] = field(default_factory=list["VaryingArgument"])
    used: set[str] = field(default_factory=set[str])
    fixed: set[str] = field(default_factory=set[str])
    reads: dict[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    scenes_of: dict[str, tuple[int, ...]] = field(default_factory=dict[str, "tuple[int, ...]"])
    random: set[str] = field(default_factory=set[str])
    draw_origins: dict[int, tuple[Any, Origin]] = field(default_factory=dict[int, "tuple[Any, Origin]"])
    failed: dict[int, Any] = field(default_factory=dict[int, Any])
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
        """Counts what the draw stage will do; once that is too much, it is reported."""
        within = not self.sampling_operations.exhausted
        self.sampling_operations.done += operations
        if within and self.sampling_operations.exhausted:
            self.sink.report("SC604", self.sampling_operations.message, origin, hint=COMPUTE_LIMIT_HINT)

    def analysis(self, scenes: tuple[int, ...] | None = None) -> BoundsAnalysis:
        """The analysis of bounds in some scenes; None: in all."""
        scenes = self.all_scenes if scenes is None else scenes
        # By identity, since objects share the tuples of their scenes; the analyses keep them.
        found = self._analyses.get(id(scenes))
        if found is None:
            from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - loaded where something varies

            found = BoundsAnalysis(self.draws, {}, self.num_scenes, scenes, self.sampling_operations)
            self._analyses[id(scenes)] = found
        return found

    @property
    def varies(self) -> bool:
        """Whether anything is to be drawn or checked by its rows."""
        return bool(self.draws or self.deferred or self.drawn)

    def add(self, name: str, node: Node, reads: frozenset[str]) -> None:
        """Adds a shared draw. `reads`: those that it reads, all of which are there."""
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
            scenes: that it is in; None: all.
            scope: in which its names are looked up.
            listed: the scenes of its `per_scene` lists, where these are not `scenes`.
        """
        scenes = self.all_scenes if scenes is None else scenes
        listed = scenes if listed is None else listed
        # By identity, since objects share the tuples of their scenes; the lowerers keep them.
        key = (id(scenes), id(listed), scope)
        found = self._fields.get(key)
        if found is None:
            found = self._fields[key] = FieldLowerer(self, scenes, listed, scope)
        return found


VARYING = SELECTORS | {DrawForm, RandomRotation, Shuffle, Vector, Template}
"""All that may stand in place of a plain value, by type."""

FormStep = tuple["PathKey", ...]


@frozen
class FieldPlace:
    """Where a varying value stands.

    Attributes:
        origin: its node.
        path: of the field within its object, as draws are keyed by it.
        word: the component's number, where it is one of several that share the path.
    """

    origin: Origin
    path: str
    word: int = 0

    def inside(self, step: FormStep) -> FieldPlace:
        """The place of an item of a form."""
        steps = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in step)
        # A shared draw's own path is empty.
        return FieldPlace(self.origin.child(*step), (self.path + steps).removeprefix("."), self.word)

    def key(self, name: str) -> FieldPlace:
        """The place of a key of the mapping here."""
        return FieldPlace(self.origin.child(name), f"{self.path}.{name}")


def field_place(origin: Origin) -> FieldPlace:
    """The place of a field of a named object; in a document every field is one."""
    return FieldPlace(origin, _path(origin.path[2:]))


# Copies have the same fields, and few fields have forms.
_path = lru_cache(maxsize=1024)(dotted)


LeafReader = Callable[[Any, FieldPlace, FormStep], Any]
"""Reads what is no selector: (given, place of the form around it, steps from there) to an item."""


class VariationLowerer:
    """Reads the forms of one field.

    Attributes:
        drawn: whether it has draws of its own.
        computed: whether it has expressions.
        seeded: whether it holds rows that were drawn and that a reset does not change.
        broken: whether something of it was reported, so that its placeholder means nothing.
        reads: the shared draws that its expressions read, and those that its `once` stand for.
        cycled: whether it has alternatives that no scene may have.
        risky: whether it can have no value in some scene, or one out of its range.
        origins: of the nodes that can have no value, by identity; the nodes are kept with them.
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
        self.origins: dict[int, tuple[Any, Origin]] = {}

    @property
    def is_random(self) -> bool:
        """Whether a seed decides its values, by its own draws or by those that it reads."""
        return self.drawn or self.seeded or not self._fields.sampling.random.isdisjoint(self.reads)

    def join(self, other: VariationLowerer) -> None:
        """Takes in what is known of another field that this one's value is made of."""
        self.drawn |= other.drawn
        self.computed |= other.computed
        self.seeded |= other.seeded
        self.cycled |= other.cycled
        self.risky |= other.risky
        self.broken |= other.broken
        self.reads |= other.reads
        self.origins |= other.origins

    def risk(self, node: Any, origin: Origin) -> Any:
        """Remembers the origin of a node that may have no value."""
        self.risky = True
        self.origins[id(node)] = (node, origin)
        return node

    def item(self, given: Any, kind: FieldType, place: FieldPlace) -> Any:
        """What is written as an item of a node: a node, or a plain row."""

        def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
            return self._leaf(one, kind, around, step)

        return self.select(given, place, leaf)

    def select(self, given: Any, place: FieldPlace, leaf: LeafReader, step: FormStep = ()) -> Any:
        """As `item`, where `leaf` reads what no selector holds."""
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
        """What stays as it is built: drawn as the form alone would be, as a shared draw that no reset draws anew."""
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
        # A prefab does not know in which scenes it is used.
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
        """A plain value as a row; the kind's own where it was reported."""
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
        # Of a matrix each row has words of its own.
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
                # What is left out does not vary.
                items[i] = (*items[i][:3], 0.0) if len(given.operands[i]) < len(items[i]) else items[i]
        node = Drawn(given.kind, tuple(items), one.shape, self._key(place, drawn.cost), place.word)
        if not NODE_TYPES.isdisjoint(map(type, items)):
            # Bounds that vary may change places in some scene.
            self.risk(node, place.origin)
        return Stacked((node,) * kind.shape[0]) if single and kind.shape else node

    def _bound(self, given: Any, kind: FieldType, place: FieldPlace, step: FormStep) -> Any:
        if given.__class__ in VARYING:
            return self.item(given, replace(kind, conversion=None), place.inside(step))
        if kind.complain is not None and kind.convert is not None:
            # What no value may be, a bound may: 0 points nowhere, and is a deviation, or the end of a range.
            made = kind.convert(given)
            return tuple(given) if made is None else made
        return given if kind.convert is None else self.plain(given, kind, place, step)

    def _key(self, place: FieldPlace, cost: int = 1) -> Key:
        self._fields.sampling.count_operations(form_cost(cost * len(self._fields.scenes)), place.origin)
        return Key(self._section, self._name, place.path)


def component(kind: FieldType) -> FieldType:
    """The kind of one number of a vector, or of one row of a matrix."""
    return COMPONENT_TYPES[kind.dtype] if len(kind.shape) < 2 else replace(kind, shape=kind.shape[1:])


def _is_vector(item: Any) -> bool:
    return isinstance(item, tuple | list | Vector)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
