"""Controls of a scene's parameters."""

from __future__ import annotations

import json
from functools import partial
from math import floor, isfinite, log10
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics import Sink
from scenecc.source import read_value

if TYPE_CHECKING:
    from collections.abc import Callable

    import viser

    from scenecc.expand.listing import ParamRow


_TEXTS: Final = frozenset({"string", "file"})
"""Types whose values are typed without quotes."""

_SMALLEST: Final = 1e-300
"""Minimum step: smaller numbers have no logarithm."""

_AS_IN_THE_FILE: Final = "(as in the file)"

_PARTS_OF_A_RANGE, _PARTS_OF_A_NUMBER = 100, 10000
"""Minimum number of parts of a slider's range and of a field's number: viser keeps only whole steps."""


class AsWritten:
    """Marks a parameter that is not set, so that the file's own value applies."""


AS_WRITTEN: Final = AsWritten()


def add_control(gui: viser.GuiApi, row: ParamRow, value: Any, changed: Callable[[Callable[[], Any]], None]) -> Any:
    """Adds the control of a parameter, and returns viser's handle of it.

    Args:
        gui: where to add it.
        row: the parameter.
        value: current value; None if there is none.
        changed: called with the new value from a viser thread: a value of the type if the text is one, or `AS_WRITTEN`.
    """
    hint = _hint(row)
    handle: Any
    read: Callable[[Any], Any]
    if row.type in {"boolean", "choice"}:
        handle, read = _add_choices(gui, row, value, hint)
    elif row.type in {"number", "integer"} and _is_number(value):
        handle, read = _number(gui, row, value, hint), partial(_read_number, whole=row.type == "integer")
    else:
        # An expression's text is not a value that can be set.
        unsaid = value is None or (value == row.value and row.type not in _TEXTS and _is_expression(value))
        handle = gui.add_text(row.name, initial_value="" if unsaid else _format_value(value), hint=hint)
        read = partial(read_param_text, kind=row.type)

    def update(event: Any) -> None:
        del event
        changed(lambda: read(handle.value))

    handle.on_update(update)
    return handle


def _add_choices(gui: viser.GuiApi, row: ParamRow, value: Any, hint: str) -> tuple[Any, Callable[[Any], Any]]:
    """Adds a dropdown list. A drawn or computed value of the file is not among its options, and comes first."""
    values = row.options or (True, False)
    words = [_format_value(option) for option in values]
    # A number and a text may look the same.
    labels = [json.dumps(option) if words.count(word) > 1 else word for option, word in zip(values, words, strict=True)]
    options: dict[str, Any] = {_AS_IN_THE_FILE: AS_WRITTEN, **dict(zip(labels, values, strict=True))}
    chosen = next((word for word, option in options.items() if _is_same(option, value)), _AS_IN_THE_FILE)
    handle = gui.add_dropdown(row.name, [*options], initial_value=chosen, hint=hint)
    # A browser may send any value.
    return handle, lambda word: options.get(word, AS_WRITTEN)


def read_param_text(text: str, kind: str) -> Any:
    """Parses typed text as a parameter value: YAML on one line, or the text itself for a string.

    Empty text is invalid, except for strings.
    """
    if not text.strip() and kind != "string":
        return AS_WRITTEN
    if kind in _TEXTS:
        return text
    sink = Sink()
    value = read_value(text, sink)
    return text if sink.failed else value


def _number(gui: viser.GuiApi, row: ParamRow, value: Any, hint: str) -> Any:
    whole = row.type == "integer"
    bounded = _is_number(row.low) and _is_number(row.high) and row.low < row.high and isfinite(row.high - row.low)
    if bounded:
        step = 1 if whole else _step((row.high - row.low) / _PARTS_OF_A_RANGE)
        inside = min(max(value, row.low), row.high)
        return gui.add_slider(row.name, min=row.low, max=row.high, step=step, initial_value=inside, hint=hint)
    ends = {"min": row.low, "max": row.high}
    step = 1 if whole else _step((value or 1) / _PARTS_OF_A_NUMBER)
    return gui.add_number(row.name, initial_value=value, step=step, hint=hint, **ends)


def _step(size: float) -> float:
    """Returns the next lower power of ten."""
    return 10.0 ** floor(log10(max(abs(size), _SMALLEST)))


def _read_number(value: float, *, whole: bool) -> Any:
    if not isfinite(value):
        return AS_WRITTEN
    return int(value) if whole else float(value)


def _hint(row: ParamRow) -> str:
    default = None if row.default is None else f"{row.default} in the file"
    words = (row.description, f"{row.type}, {row.range}" if row.range else row.type, default)
    return "\n".join(filter(None, words))


def _is_same(option: Any, value: Any) -> bool:
    return type(option) is type(value) and option == value


def _is_expression(value: Any) -> bool:
    return "${" in _format_value(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _format_value(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
