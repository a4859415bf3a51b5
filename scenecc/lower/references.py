"""Resolves references by name: full names, files and materials.

Each possible reference is looked up and has an entry in a table of the plan.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

from scenecc.diagnostics.messages import show
from scenecc.lower.field_types import FieldType
from scenecc.lower.forms import VARYING, FieldPlace, FormStep, VariationLowerer, field_place
from scenecc.lower.value_checks import report_draw_failure, warn_of_missing_sample
from scenecc.plan import Value, derived, literal, per_scene
from scenecc.plan.body import AssetFile, PhysicalMaterial, Texture, VisualMaterial
from scenecc.variation.forms import SELECTORS
from scenecc.variation.nodes import NODES, Computed, Node
from scenecc.variation.operations import ComputeLimitError, DrawError, is_number

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.plan import ScenePlan
    from scenecc.robots.description import RobotDescription
    from scenecc.variation.evaluation import Batch


def name_prefixes(name: str, shortest: int = 0) -> Iterator[str]:
    """The prefixes of a name at its slashes, longest first. `shortest`: minimum length."""
    end = len(name)
    while end > shortest:
        yield name[:end]
        end = name.rfind("/", 0, end)


def scope_of(name: str) -> str:
    """The scope of a material, group or draw in an expanded document."""
    return name.rpartition("/")[0]


def qualified(name: str, scope: str) -> str:
    """The full name of a material, group or draw in a scope. A name after `/` is relative to the document."""
    if name.startswith("/"):
        return name[1:]
    return f"{scope}/{name}" if scope else name


def select_per_scene(values: Sequence[Value], pick: Value, scenes: tuple[int, ...]) -> Value:
    """Selects one of several values in each scene.

    Args:
        values: of one dtype and shape.
        pick: (·,) index into them.
        scenes: scenes of the rows.
    """
    first = values[0]
    if all(value is first or _same_constant(value, first) for value in values):
        return first
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.bounds import union_bounds  # noqa: PLC0415 - see above

    def select(which: NDArray[Any], *rows_of: NDArray[Any]) -> NDArray[Any]:
        count = max(len(which), *map(len, rows_of))
        which = np.broadcast_to(which, (count,))
        selected = np.empty((count, *rows_of[0].shape[1:]), dtype=rows_of[0].dtype)
        for number, rows in enumerate(rows_of):
            mine = which == number
            selected[mine] = np.broadcast_to(rows, selected.shape)[mine]
        return selected

    return derived(select, [pick, *values], scenes, bounds=lambda: union_bounds([value.bounds for value in values]))


def _same_constant(a: Value, b: Value) -> bool:
    return a.is_constant and b.is_constant and a.numbers() == b.numbers()


Found = TypeVar("Found")

_INDEX_TYPE = FieldType(dtype="int64", fallback=0)


@dataclass(slots=True)
class References(Generic[Found]):
    """The possible references of a leaf, and which one each scene has.

    Attributes:
        found: by the number that `node` gives; None after an error.
        value: (·,) the number in each scene.
    """

    found: list[Found | None]
    value: Value

    def indices(self, fields: FieldLowerer) -> Value:
        """Indices of the referenced objects in each scene, if these are indices of a table."""
        values = [literal(index, "int64") for index in self.found]  # pyright: ignore[reportArgumentType]
        return select_per_scene(values, self.value, fields.scenes)


@dataclass(slots=True)
class _ReferenceLookup(Generic[Found]):
    """Numbers the names and resolves each once."""

    fields: FieldLowerer
    find: Callable[[Any, Origin], Found | None]
    numbers: dict[Any, int] = field(default_factory=dict[Any, int])
    found: list[Any] = field(default_factory=list[Any])

    def number(self, name: Any, origin: Origin) -> int:
        # Each inline object is distinct; a name always means the same object.
        key = name if isinstance(name, str) else id(name)
        number = self.numbers.get(key)
        if number is None:
            number = self.numbers[key] = len(self.found)
            self.found.append(self.find(name, origin))
        return number


Unwrap = Callable[[Any, FieldPlace], tuple[Any, FieldPlace]]


def plain_reference(given: Any, place: FieldPlace) -> tuple[Any, FieldPlace]:
    """Returns a name unchanged."""
    return given, place


def read_references(
    given: Any,
    place: FieldPlace,
    fields: FieldLowerer,
    find: Callable[[Any, Origin], Found | None],
    unwrap: Unwrap = plain_reference,
) -> References[Found]:
    """Resolves a leaf with references.

    Args:
        given: from the model: a name, an inline mapping, a form of these, or an expression.
        place: of the leaf.
        fields: of its object.
        find: resolves a name; reports an error and returns None if it fails.
        unwrap: gets the reference from an alternative that is a mapping.
    """
    lookup = _ReferenceLookup(fields, find)
    written = given
    if given.__class__ not in SELECTORS:
        given, place = unwrap(given, place)
    if given.__class__ not in VARYING:
        lookup.number(given, place.origin)
        return References(lookup.found, literal(0, "int64"))
    variation = VariationLowerer(fields, place.origin)
    computed: list[tuple[Computed, Origin]] = []

    def bare(one: Any, around: FieldPlace, step: FormStep) -> Any:
        inside = around.inside(step) if step else around
        if one.__class__ not in VARYING:
            return lookup.number(one, inside.origin)
        node = variation.item(one, _TEXT_TYPE, inside)
        if isinstance(node, Computed):
            computed.append((node, inside.origin))
        return node

    def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
        return variation.select(*unwrap(one, around.inside(step) if step else around), bare)

    node = variation.select(given, place, leaf if given is written else bare)
    for one, origin in computed:
        _look_up_every_name(one, origin, lookup, node, is_random=variation.is_random)
    fields.sampling.fix(variation)
    if variation.broken or None in lookup.found or node.__class__ not in NODES:
        return References(lookup.found, literal(0, "int64"))
    return References(lookup.found, _reference_numbers(node, variation, lookup, place, fields))


_TEXT_TYPE = FieldType(convert=str, fallback="")


def _look_up_every_name(
    node: Computed, origin: Origin, lookup: _ReferenceLookup[Any], within: Node, *, is_random: bool
) -> None:
    """Looks up every text that an expression gives in the scenes and in the samples."""
    sink = lookup.fields.sink
    with sink.merge_repeats():
        found = values_given(node, origin, lookup.fields, is_random=is_random, within=within)
        if found is None:
            lookup.found.append(None)
        for name in found or ():
            if isinstance(name, str):
                lookup.number(name, origin)
            else:
                sink.report("SC317", f"this expression gives {show(name)}, but a name is needed", origin)
                lookup.found.append(None)
                return


def values_given(
    node: Node, origin: Origin, fields: FieldLowerer, *, is_random: bool, within: Node | None = None
) -> list[Any] | None:
    """The distinct values of a node in the scenes and in the samples; None after an error.

    Args:
        node: an expression, or a draw.
        origin: of the node.
        fields: of its object.
        is_random: whether its values depend on the seed.
        within: the node that contains it, and may read it only in some scenes; None: all scenes count.
    """
    try:
        found = _values_where_read(node, within, fields.batch(), is_random=is_random)
    except DrawError as error:
        report_draw_failure(error, origin, fields.sampling)
        return None
    if is_random:
        samples = fields.analysis.samples
        try:
            found += _values_where_read(node, within, samples, is_random=True)
        except DrawError as error:
            warn_of_missing_sample(error, origin, fields.sampling)
            found += _values_of_single_rows(samples, node)
    distinct = {(one.__class__.__name__, repr(one)): one for one in found}
    return sorted(distinct.values(), key=lambda one: (one.__class__.__name__, one if is_number(one) else repr(one)))


def _values_where_read(node: Node, within: Node | None, batch: Batch, *, is_random: bool) -> list[Any]:
    """The values of a node in the rows of a batch that read it. Raises a DrawError if one of these has none."""
    try:
        return batch.evaluate(node).tolist()
    except DrawError as error:
        if within is None or isinstance(error, ComputeLimitError):
            raise
        from scenecc.variation.samples import nodes_read  # noqa: PLC0415 - loads numpy

        part = next((part for one, part in nodes_read(within, batch) if one is node), None)
        if part is not None:
            return part.evaluate(node).tolist()
        if is_random:
            return []
        # No scene uses this item of a cycle, and none will.
        raise


def _values_of_single_rows(batch: Batch, node: Node) -> Iterator[Any]:
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    for row in range(len(batch.scenes)):
        with suppress(DrawError):
            yield from batch.only(np.array([row])).evaluate(node).tolist()


def _reference_numbers(
    node: Any, variation: VariationLowerer, lookup: _ReferenceLookup[Any], place: FieldPlace, fields: FieldLowerer
) -> Value:
    """The number of each scene's reference."""
    if not variation.computed:
        return fields.finish(node, variation, _INDEX_TYPE, place.origin)
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.bounds import ValueBounds  # noqa: PLC0415 - see above

    def rows(batch: Batch) -> NDArray[Any]:
        found = batch.evaluate(node).tolist()
        return np.array([one if isinstance(one, int) else lookup.numbers[one] for one in found], dtype=np.int64)

    if not variation.is_random:
        return per_scene(rows(fields.batch()), "int64")
    value = fields.make_drawn(rows, lambda: ValueBounds.of(range(len(lookup.found)), exact=False))
    return fields.check_value(value, node, _INDEX_TYPE, place.origin)


FileResolver = Callable[[str, "Origin"], AssetFile | None]
"""Finds a file of a document. Reports an error and returns None if there is none."""

Row = TypeVar("Row")


class RowTable(Generic[Row]):
    """Distinct rows, in order of first use."""

    def __init__(self, key: Callable[[Row], Hashable]) -> None:
        """`key`: equal for equal rows."""
        self._key = key
        self._rows: list[Row] = []
        self._indices: dict[Hashable, Value] = {}
        self._known: dict[int, tuple[Row, Value]] = {}

    def value(self, row: Row) -> Value:
        """The row's index as a constant value. Adds a new row."""
        known = self._known.get(id(row))
        if known is None:
            # By identity, since computing a material's key dominates the time. Keeping the row keeps its id unique.
            key = self._key(row)
            value = self._indices.get(key)
            if value is None:
                value = self._indices[key] = literal(len(self._rows), "int64")
                self._rows.append(row)
            known = self._known[id(row)] = (row, value)
        return known[1]

    def index(self, row: Row) -> int:
        """The row's index."""
        return int(self.value(row).numbers()[0])

    @property
    def rows(self) -> tuple[Row, ...]:
        """All rows, by index."""
        return tuple(self._rows)


def _content(row: Any) -> Hashable:
    """The content of a material. A varying value is compared by identity, since comparing its rows would draw it."""
    if isinstance(row, Value):
        return row.numbers() if row.is_constant else ("value", id(row))
    members = _MEMBERS.get(row.__class__)
    return row if members is None else tuple([None if part is None else _content(part) for part in members(row)])


_MEMBERS: dict[type[Any], Callable[[Any], tuple[Any, ...]]] = {
    kind: attrgetter(*(field.name for field in dataclasses.fields(kind)))
    for kind in (PhysicalMaterial, VisualMaterial, Texture)
}


class PlanTables:
    """The files and materials that the shapes of a plan refer to.

    Attributes:
        file_origins: for each file, the first place that references it.
        material_origins: for each physical material, the first place that uses it.
        heights: of each terrain picture.
        height_count: heights of all terrain so far, counted once per use.
    """

    def __init__(self, resolve: FileResolver) -> None:
        self.files: RowTable[AssetFile] = RowTable(lambda file: file)
        self.physical_materials: RowTable[PhysicalMaterial] = RowTable(_content)
        self.visual_materials: RowTable[VisualMaterial] = RowTable(_content)
        self.file_origins: dict[int, Origin] = {}
        self.material_origins: dict[int, Origin] = {}
        self._resolve = resolve
        self._sizes: dict[tuple[float, ...] | float, Value] = {}
        self.heights: dict[Path, tuple[tuple[float, ...], ...]] = {}
        self.height_count = 0

    def resolve(self, uri: str, origin: Origin) -> AssetFile | None:
        """Finds a file that is read now and does not become part of the plan; None after an error."""
        return self._resolve(uri, origin)

    def file(self, uri: str, origin: Origin) -> int | None:
        """The index of a file in `files`; None after an error."""
        found = self._resolve(uri, origin)
        if found is None:
            return None
        index = self.files.index(found)
        self.file_origins.setdefault(index, origin)
        return index

    def files_of(
        self, given: Any, origin: Origin, fields: FieldLowerer, unwrap: Unwrap = plain_reference
    ) -> Value | None:
        """Lowers a leaf with a file to indices into `files`; None after an error in an alternative.

        Args:
            given: from the model.
            origin: of the leaf.
            fields: of the object.
            unwrap: gets the file from an alternative that is a mapping.
        """
        if given.__class__ is str:
            index = self.file(given, origin)
            return None if index is None else literal(index, "int64")
        named = read_references(given, field_place(origin), fields, self.file, unwrap)
        return None if None in named.found else named.indices(fields)

    def physical(self, row: PhysicalMaterial, origin: Origin) -> Value:
        """A physical material's index as a value."""
        value = self.physical_materials.value(row)
        self.material_origins.setdefault(int(value.numbers()[0]), origin)
        return value

    def fill(self, plan: ScenePlan) -> ScenePlan:
        """Adds these files and materials to a plan."""
        origins = self.file_origins
        files = tuple(dataclasses.replace(file, origin=origins.get(i)) for i, file in enumerate(self.files.rows))
        physical, visual = self.physical_materials.rows, self.visual_materials.rows
        return dataclasses.replace(plan, files=files, physical_materials=physical, visual_materials=visual)

    def size(self, size: tuple[float, ...] | float) -> Value:
        """A positive size as a value, shared by equal sizes. (0.0 and -0.0 would share a key.)"""
        found = self._sizes.get(size)
        if found is None:
            found = self._sizes[size] = literal(size)
        return found


@dataclass(frozen=True, slots=True)
class RobotRequest:
    """How to read a robot file.

    Attributes:
        format: of the file.
        uri: as written.
        srdf: as written; "none": no SRDF; None: the one beside the file.
        package_dir: as written; None: not given.
        scale: of all lengths.
        collision_is_visual: whether collision shapes are also visual shapes.
        repair: repairs to apply to a URDF.
        keyframe: of an MJCF, for initial positions.
        visual_groups: visual geom groups of an MJCF; None: MuJoCo's default.
    """

    format: Literal["urdf", "mjcf"]
    uri: str
    srdf: str | None = None
    package_dir: str | None = None
    scale: float = 1.0
    collision_is_visual: bool = False
    repair: frozenset[str] = frozenset()
    keyframe: str | None = None
    visual_groups: tuple[int, ...] | None = None


RobotReader = Callable[[RobotRequest, Mapping[str, "Origin"]], "tuple[AssetFile, RobotDescription] | None"]
"""Reads a robot file and its description; None after an error. Takes the origins of the given keys: the
format's key, `srdf` and `package_dir`.
"""

MeshReader = Callable[["AssetFile", "Origin"], "NDArray[Any] | None"]
"""The vertices (n, 3) [m] of a mesh file; None after an error, which is reported at the origin."""
