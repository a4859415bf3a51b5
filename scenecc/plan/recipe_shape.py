"""What shape of numbers a recipe gives in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.variation.nodes import (
    NODES,
    Chosen,
    Composed,
    Computed,
    Const,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromMatrix,
    FromRpy,
    Held,
    Looking,
    Normalized,
    Pointing,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    Shapes = Mapping[str, "Shape"]

Shape = tuple[int, ...] | None
"""None: only evaluating it could tell; with -1 in it: no numbers, or not of one shape."""

NO_NUMBERS: Final = (-1,)


class MisshapenError(Exception):
    """A part of a recipe is not of the shape that the rest needs."""


def shape_of(item: Any, draws: Shapes) -> Shape:
    """The shape of an item of a recipe, without the axis of the scenes. `draws`: those of the shared draws.

    Raises:
        MisshapenError: it could not be evaluated, by the shapes of its parts.
    """
    if isinstance(item, NODES):
        return _TABLE[type(item)](item, draws)
    if isinstance(item, tuple):
        return _listed(len(item), _common(item, draws))  # pyright: ignore[reportUnknownArgumentType]
    return () if type(item) in {int, float} else NO_NUMBERS


def _common(items: Sequence[Any], draws: Shapes) -> Shape:
    """The shape that all have."""
    return _one({shape_of(one, draws) for one in items})


def _one(shapes: set[Shape]) -> Shape:
    known = shapes - {None}
    if len(known) > 1:
        return NO_NUMBERS
    return None if None in shapes else next(iter(known), ())


def _listed(count: int, shape: Shape) -> Shape:
    return None if shape is None else NO_NUMBERS if -1 in shape else (count, *shape)


def _side_by_side(node: Stacked, draws: Shapes) -> Shape:
    # Asked once for each item: a stack of stacks would otherwise take twice as long for each that it is deep.
    shapes = {shape_of(one, draws) for one in node.items}
    if len(shapes - {None}) > 1:
        raise MisshapenError("the items of a stack differ in shape")
    return _listed(len(node.items), _one(shapes))


def _drawn(node: Drawn, draws: Shapes) -> Shape:
    for bound in node.operands:
        if shape_of(bound, draws) not in (None, (), node.shape):
            raise MisshapenError("a bound of a draw has another shape than the draw")
    return node.shape


def _held(node: Held, draws: Shapes) -> Shape:
    for bound in (node.low, node.high, node.factor, node.offset):
        if shape_of(bound, draws) not in (None, ()):
            raise MisshapenError("what holds or moves a number is not one number")
    gives = shape_of(node.of, draws)
    if gives is not None and (len(gives) != (node.index >= 0) or -1 in gives or node.index >= max(gives, default=0)):
        raise MisshapenError("there is no such number to be held")
    return ()


def _checked(**wanted: tuple[int, ...]) -> Callable[[Any, Shapes], None]:
    def check(node: Any, draws: Shapes) -> None:
        for name, shape in wanted.items():
            if shape_of(getattr(node, name), draws) not in (None, shape):
                count = " by ".join(map(str, shape)) + " numbers" if shape else "one number"
                raise MisshapenError(f"`{name}` is not {count}")

    return check


def _made(shape: tuple[int, ...], **parts: tuple[int, ...]) -> Callable[[Any, Shapes], Shape]:
    check = _checked(**parts)

    def made(node: Any, draws: Shapes) -> Shape:
        check(node, draws)
        return shape

    return made


_TABLE: Final[dict[type[Any], Callable[[Any, Shapes], Shape]]] = {
    Const: lambda node, draws: shape_of(node.data, draws),
    Rows: lambda node, draws: _common(node.items, draws),
    Cycled: lambda node, draws: _common(node.items, draws),
    Chosen: lambda node, draws: _common(node.items, draws),
    Drawn: _drawn,
    RandomRotated: _made((4,)),
    Stacked: _side_by_side,
    Computed: lambda node, _: node.shape,
    Shared: lambda node, draws: draws[node.name],
    Posed: _made((7,), p=(3,), q=(4,)),
    Normalized: _made((4,), q=(4,)),
    FromRpy: _made((4,), angles=(3,)),
    FromAxisAngle: _made((4,), axis=(3,), angle=()),
    FromMatrix: _made((7,), matrix=(4, 4)),
    Looking: _made((4,), target=(3,), p=(3,)),
    Pointing: _made((4,), direction=(3,)),
    Radians: lambda node, draws: shape_of(node.degrees, draws),
    Held: _held,
    Composed: _made((7,), outer=(7,), inner=(7,)),
}
