"""Lowers fields of the language to values of the plan."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, show
from scenecc.lower.forms import VARYING, VariationLowerer, field_place
from scenecc.lower.sampling import FieldScope, SamplingContext
from scenecc.lower.value_checks import ValueCheck, check_rows, check_samples, report_draw_failure
from scenecc.lower.variation import ResettableValue
from scenecc.plan import Value, literal, per_scene, varying
from scenecc.variation.nodes import (
    NODE_TYPES,
    Node,
    holds_infinity,
)
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.field_types import FieldType
    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.evaluation import Batch

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


class FieldLowerer(FieldScope):
    """Makes values of an object's fields."""

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
            self.sampling.fix(variation)
        if item.__class__ not in NODE_TYPES:
            return literal(item, kind.dtype)
        if variation.broken:
            return literal(kind.fallback, kind.dtype)
        if not variation.is_random:
            return self._rows(item, variation, kind, origin)
        value = self.make_drawn(partial(self.rows, node=item, kind=kind), lambda: self.analysis.bounds(item))
        if variation.risky:
            value = self.check_value(value, item, kind, origin)
        if reset:
            self.sampling.resets[id(value)] = ResettableValue(value, item, variation, self.scenes)
        return value

    def make_drawn(self, rows: RowMaker, bounds: Callable[[], ValueBounds]) -> Value:
        """Makes a value that is drawn on first access.

        Args:
            rows: computes its rows in a batch.
            bounds: gives its possible values.
        """
        self.sampling.drawn = True
        return varying(lambda: rows(self.batch()), lambda: rows(self.analysis.samples), self.scenes, bounds=bounds)

    def check_value(self, value: Value, node: Node, kind: FieldType, origin: Origin) -> Value:
        """Draws a value and checks its rows and its samples.

        Returns:
            The value; a placeholder after an error; a value without samples after a warning, so that the rules do not
            find the same fault again.
        """
        if self.sampling.sampling_operations.exhausted:
            return literal(kind.fallback, kind.dtype)
        check = ValueCheck(value, node, kind, self.scenes, origin)
        if not check_rows(check, self.sampling):
            return literal(kind.fallback, kind.dtype)
        return value if check_samples(check, self.sampling) else value.without_samples()

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
        raise batch.error(f"this is not {_describe_type(kind)}", 0, node)

    def inside(self, scope: str) -> FieldLowerer:
        """The lowerer of a named object in another scope, over the same scenes. `per_scene` lists cover all scenes."""
        return FieldLowerer(self.sampling, self.scenes, self.sampling.all_scenes, scope)

    def keep_infinite(self, value: Value) -> None:
        """Fixes a value after the build if it may be infinite in some scene: the engine cannot change it later."""
        reset = self.sampling.resets.get(id(value))
        if reset is not None and holds_infinity(reset.node, self.sampling.draws):
            del self.sampling.resets[id(value)]
            self.sampling.fix(reset.variation)

    def _rows(self, node: Node, variation: VariationLowerer, kind: FieldType, origin: Origin) -> Value:
        """Makes a value with known rows from a node that depends only on the scene index."""
        rows = partial(self.rows, node=node, kind=kind)
        try:
            known = per_scene(rows(self.batch()), kind.dtype)
        except DrawError as error:
            report_draw_failure(error, origin, self.sampling)
            return literal(kind.fallback, kind.dtype)
        if variation.computed:
            check_rows(ValueCheck(known, node, kind, self.scenes, origin), self.sampling)
        if variation.cycled:
            # Also checks alternatives that no scene uses.
            found = self.analysis.bounds(node)
            if found.alternatives is None or len(found.alternatives) > len(known.bounds.alternatives or ()):
                return self.make_drawn(rows, lambda: found)
        return known


def _describe_type(kind: FieldType) -> str:
    one = _VALUE_TYPES[kind.dtype][1]
    return f"a list of {kind.shape[0]} numbers" if kind.shape else one


def fields_of(sampling: SamplingContext, scenes: tuple[int, ...] | None = None, scope: str = "") -> FieldLowerer:
    """The field lowerer of an object. `scenes`: of the object; None: all. `scope`: of its names."""
    scenes = sampling.all_scenes if scenes is None else scenes
    return FieldLowerer(sampling, scenes, scenes, scope)
