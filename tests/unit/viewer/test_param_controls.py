"""Parameters as controls."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from scenecc import ParamRow
from scenecc.viewer.controls import AS_WRITTEN, add_control, read_param_text


class Gui:
    """Keeps what it is asked for."""

    def __init__(self) -> None:
        self.kind, self.label, self.arguments = "", "", dict[str, Any]()
        self.handle: Any = None

    def __getattr__(self, name: str) -> Any:
        def add(label: str, *options: Any, **arguments: Any) -> Any:
            self.kind, self.label = name.removeprefix("add_"), label
            self.arguments = arguments | ({"options": options[0]} if options else {})
            self.handle = SimpleNamespace(value=arguments["initial_value"])
            self.handle.on_update = lambda update: setattr(self.handle, "update", update)
            return self.handle

        return add


def row(kind: str, **given: Any) -> ParamRow:
    return ParamRow("size", kind, None, "", "how large", **given)


@pytest.mark.parametrize(
    ("param", "value", "kind", "shown", "typed", "becomes"),
    [
        (row("number", low=0, high=2), 0.5, "slider", 0.5, 1, 1.0),
        (row("number"), 0.5, "number", 0.5, 2.5, 2.5),
        (row("number", low=1, high=1), 1, "number", 1, 1, 1.0),
        (row("integer", low=1, high=9), 3, "slider", 3, 4.0, 4),
        (row("boolean"), True, "dropdown", "true", "false", False),
        (row("boolean"), {"choice": [True, False]}, "dropdown", "(as in the file)", "true", True),
        (row("boolean"), False, "dropdown", "false", "(as in the file)", AS_WRITTEN),
        (row("choice", options=("a", 2, True)), 2, "dropdown", "2", "true", True),
        (row("choice", options=("a", "b")), {"choice": ["a", "b"]}, "dropdown", "(as in the file)", "b", "b"),
        (row("choice", options=(1, "1")), 1, "dropdown", "1", '"1"', "1"),
        (row("choice", options=(1, True)), True, "dropdown", "true", "1", 1),
        (row("choice", options=("a", "b")), "a", "dropdown", "a", "nothing of it", AS_WRITTEN),
        (row("number", low=0, high=1), 0.5, "slider", 0.5, float("nan"), AS_WRITTEN),
        (row("integer"), 5, "number", 5, float("inf"), AS_WRITTEN),
        (row("number", low=-1e308, high=1e308), 0, "number", 0, 1, 1.0),
        (row("number"), 1e-320, "number", 1e-320, 1, 1.0),
        (row("string"), "text", "text", "text", "[1]", "[1]"),
        (row("vector"), [1, 2], "text", "[1, 2]", "[3, 4.5]", [3, 4.5]),
        (row("color"), "#ff0000", "text", "#ff0000", "'#00ff00'", "#00ff00"),
        (row("number"), None, "text", "", "0.25", 0.25),
        (row("number"), "${size / 20}", "text", "${size / 20}", "", AS_WRITTEN),
        (row("number", value="${size / 20}"), "${size / 20}", "text", "", "0.2", 0.2),
        (row("string", value="${name}_1"), "${name}_1", "text", "${name}_1", "", ""),
    ],
)
def test_a_parameter_control_shows_and_returns_values(
    param: ParamRow, value: Any, kind: str, shown: Any, typed: Any, becomes: Any
) -> None:
    gui, given = Gui(), list[Any]()
    handle = add_control(gui, param, value, lambda read: given.append(read()))  # pyright: ignore[reportArgumentType]
    assert (gui.kind, gui.label, gui.arguments["initial_value"]) == (kind, "size", shown)
    assert gui.arguments["hint"].startswith("how large\n" + param.type)
    handle.value = typed
    handle.update(None)
    assert given == [becomes]
    assert type(given[0]) is type(becomes)


def test_an_integer_slider_steps_by_one() -> None:
    gui = Gui()
    add_control(gui, row("integer", low=1, high=9), 3, print)  # pyright: ignore[reportArgumentType]
    assert gui.arguments["step"] == 1


def test_slider_steps_are_fine_enough_for_typed_numbers() -> None:
    for param, value, step in (
        (row("number", low=0.4, high=1.2), 0.7, 0.001),
        (row("number"), 0.7, 1e-5),
        (row("number"), 5, 1e-4),
        (row("number"), 0, 1e-4),
        (row("number"), -1e-4, 1e-8),
    ):
        gui = Gui()
        add_control(gui, param, value, print)  # pyright: ignore[reportArgumentType]
        assert gui.arguments["step"] == pytest.approx(step)


def test_typed_text_that_is_not_yaml_is_a_string() -> None:
    # The parameter then says what it takes.
    assert read_param_text("[1, 2", "vector") == "[1, 2"
    assert read_param_text("*x", "number") == "*x"
