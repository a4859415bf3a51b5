"""The panel of the page: its controls, and those of the scene's parameters."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from html import escape
from math import floor, isfinite, log10
from typing import TYPE_CHECKING, Any, Final, Protocol

from scenecc.diagnostics import Sink
from scenecc.interrupt import interrupts_wait
from scenecc.source import read_value

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    import viser

    from scenecc.expand.listing import ParamRow
    from scenecc.inspect import Item
    from scenecc.viewer.nodes import Key
    from scenecc.viewer.options import ViewOptions
    from scenecc.viewer.page import Page
    from scenecc.viewer.tasks import TaskQueue


_TEXTS: Final = frozenset({"string", "file"})
"""Types whose values are typed as they are."""

_SMALLEST: Final = 1e-300
"""Of a step: what is less has no logarithm any more."""

_AS_IN_THE_FILE: Final = "(as in the file)"

_PARTS_OF_A_RANGE, _PARTS_OF_A_NUMBER = 100, 10000
"""Into so many parts at least a slider divides its range, and a field its number: viser keeps whole steps alone."""


class AsWritten:
    """Stands for a value that is not given: the file's own counts."""


AS_WRITTEN: Final = AsWritten()


def add_control(gui: viser.GuiApi, row: ParamRow, value: Any, changed: Callable[[Callable[[], Any]], None]) -> Any:
    """Adds the control of a parameter, and returns viser's handle of it.

    Args:
        gui: where.
        row: the parameter.
        value: that it has; None where it has none yet.
        changed: called with the new value, in a thread of viser: a value of the type if the text is one, or
            `AS_WRITTEN`.
    """
    hint = _hint(row)
    handle: Any
    read: Callable[[Any], Any]
    if row.type in {"boolean", "choice"}:
        handle, read = _listed(gui, row, value, hint)
    elif row.type in {"number", "integer"} and _is_number(value):
        handle, read = _number(gui, row, value, hint), partial(_read_number, whole=row.type == "integer")
    else:
        # The text of an expression is no value that can be given.
        unsaid = value is None or (value == row.value and row.type not in _TEXTS and _is_expression(value))
        handle = gui.add_text(row.name, initial_value="" if unsaid else _written(value), hint=hint)
        read = partial(read_text, kind=row.type)

    def update(event: Any) -> None:
        del event
        changed(lambda: read(handle.value))

    handle.on_update(update)
    return handle


def _listed(gui: viser.GuiApi, row: ParamRow, value: Any, hint: str) -> tuple[Any, Callable[[Any], Any]]:
    """A list to choose from. What the file draws or computes is none of it, and stands first."""
    values = row.options or (True, False)
    words = [_written(option) for option in values]
    # A number and a text may be written the same.
    labels = [json.dumps(option) if words.count(word) > 1 else word for option, word in zip(values, words, strict=True)]
    options: dict[str, Any] = {_AS_IN_THE_FILE: AS_WRITTEN, **dict(zip(labels, values, strict=True))}
    chosen = next((word for word, option in options.items() if _is_same(option, value)), _AS_IN_THE_FILE)
    handle = gui.add_dropdown(row.name, [*options], initial_value=chosen, hint=hint)
    # A browser may send anything.
    return handle, lambda word: options.get(word, AS_WRITTEN)


def read_text(text: str, kind: str) -> Any:
    """The text that was typed as the value of a parameter: YAML on one line, or the text itself for a string.

    Nothing is no value, but where a text is wanted that may be empty.
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
    """The next lower power of ten."""
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
    return "${" in _written(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _written(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


_STYLE = "font-size:0.75rem;line-height:1.45;padding:0.2rem 0.6rem;overflow-wrap:anywhere;"

_CODE = "font-family:ui-monospace,monospace;white-space:pre;overflow:auto;max-height:60vh;user-select:text;"


def message(text: str, *, color: str) -> str:
    """What was said of a scene, line by line as on a terminal. `color`: of the bar beside it."""
    bar = f"border-left:3px solid {color};"
    return f'<div style="{_STYLE}{_CODE}{bar}" class="scenecc-message">{escape(text.rstrip())}</div>'


def line(text: str) -> str:
    """A short text."""
    return f'<div style="{_STYLE}" class="scenecc-line">{escape(text)}</div>'


def facts(item: Item) -> str:
    """What is said of a thing and of all that it is made of."""
    return f'<div style="{_STYLE}" class="scenecc-facts">{"".join(_item(item))}</div>'


def _item(item: Item, group: str = "") -> Iterator[str]:
    name, kind = escape(item.name or group), escape(item.type)
    yield f'<div><b>{name}</b> <span style="opacity:0.6">{kind}</span></div>'
    facts = [f"{_label(fact.label)}{escape(fact.words)}" for fact in item.facts if fact.words]
    if facts:
        yield f"<div>{'<br>'.join(facts)}</div>"
    for word, things in item.groups:
        listed = things if isinstance(things, tuple) else (things,)
        for one in listed:
            inner = "".join(_item(one, word))
            yield f'<div style="margin-left:0.7rem;border-left:1px solid #8884;padding-left:0.5rem">{inner}</div>'


def _label(text: str) -> str:
    return f'<span style="opacity:0.6">{escape(text)}</span> ' if text else ""


_RED, _AMBER = "#e03131", "#f08c00"

_LARGEST = 2**53 - 1
"""Of the numbers that a browser distinguishes."""

_UNSELECTED = "Click on a body, or on its name."

_WIDTH = 300

_MOST_LISTED = 64
"""Scenes whose objects are listed: a browser draws a button for each."""


class Actions(Protocol):
    """What can be asked for on a page."""

    def look_at(self, look: ViewOptions) -> None:
        """Shows something else."""
        ...

    def play(self) -> None:
        """Lets the simulation run, or stops it."""
        ...

    def step(self, n: int) -> None:
        """Simulates some steps."""
        ...

    def reset(self, seed: int) -> None:
        """Puts everything back to its start."""
        ...

    def rebuild(self, seed: int) -> None:
        """Builds everything anew."""
        ...

    def give(self, name: str, value: Any) -> None:
        """Gives a parameter a value; `AS_WRITTEN`: the file's own."""
        ...

    def give_nothing(self) -> None:
        """Gives all parameters the values that the file says."""
        ...

    def select(self, key: Key) -> None:
        """Tells what is known of a body."""
        ...


class Panel:
    """Controls, and texts beside them. Ctrl-C waits for the end of each function, as in `Page`."""

    @interrupts_wait()
    def __init__(
        self, server: viser.ViserServer, mail: TaskQueue, actions: Actions, page: Page, look: ViewOptions
    ) -> None:
        self._gui = server.gui
        self._mail = mail
        self._actions = actions
        self._page = page
        self._look = look
        self._scenes = 0
        self._true_seed = 0
        self._params: tuple[ParamRow, ...] = ()
        self._objects: Mapping[int, Sequence[tuple[str, tuple[str, ...]]]] = {}
        self._made: dict[str, list[Any]] = {"scenes": [], "params": [], "objects": []}
        self._problem = self._add_problem()
        self._add_simulation()
        self._scene_folder = self._gui.add_folder("Scenes", order=10, visible=False)
        self._add_shown()
        self._param_folder = self._gui.add_folder("Parameters", order=30, visible=False)
        self._warnings = self._gui.add_html("", order=40, visible=False)
        self._add_tree()

    @interrupts_wait()
    def tell_fault(self, text: str) -> None:
        """Shows an error over whatever else is shown; "" takes it away."""
        self._fault.content = message(text, color=_RED) if text else ""
        if self._problem.visible != bool(text):
            self._problem.visible = bool(text)

    @interrupts_wait()
    def tell_warnings(self, text: str) -> None:
        """Shows warnings and notes; "" takes them away."""
        self._warnings.content = message(text, color=_AMBER) if text else ""
        self._warnings.visible = bool(text)

    @interrupts_wait()
    def tell_time(self, seconds: float, steps: int) -> None:
        """Shows how long was simulated."""
        self._time.content = line(_time_words(seconds, steps))

    @interrupts_wait()
    def tell_seed(self, seed: int) -> None:
        """Shows the seed with which everything was drawn."""
        self._true_seed = seed
        self._seed.value = min(seed, _LARGEST)

    @interrupts_wait()
    def tell_playing(self, *, playing: bool) -> None:
        """Shows whether the simulation runs."""
        self._play.label = "Pause" if playing else "Play"
        self._step.disabled = playing

    @interrupts_wait()
    def tell_facts(self, item: Item | None) -> None:
        """Shows what is known of something; None: nothing is selected."""
        self._facts.content = line(_UNSELECTED) if item is None else facts(item)

    @interrupts_wait()
    def set_scenes(self, count: int, left_out: int) -> None:
        """How many scenes there are, and how many of them are not shown side by side."""
        if self._scenes != count:
            self._scenes = count
            self._clear("scenes")
            self._scene_folder.visible = count > 1
            if count > 1:
                with self._scene_folder:
                    self._made["scenes"] = self._add_scenes(count)
        if self._made["scenes"]:
            note = self._made["scenes"][-1]
            note.content = line(f"{left_out} more scenes have too many bodies for a browser") if left_out else ""

    @interrupts_wait()
    def set_params(self, rows: tuple[ParamRow, ...], given: Mapping[str, Any], *, afresh: bool = False) -> None:
        """The parameters. Controls of known parameters keep their values, unless `afresh`: then they show `given`."""
        if rows == self._params and not afresh:
            return
        self._params = rows
        self._clear("params")
        self._param_folder.visible = bool(rows)
        with self._param_folder:
            self._made["params"] = [
                add_control(self._gui, row, given.get(row.name, row.value), self._giver(row.name)) for row in rows
            ]
            if rows:
                button = self._gui.add_button("As in the file", hint="All parameters as the file says")
                button.on_click(lambda _: self._mail.post("give nothing", self._actions.give_nothing))
                self._made["params"].append(button)

    @interrupts_wait()
    def set_objects(self, scenes: Mapping[int, Sequence[tuple[str, tuple[str, ...]]]]) -> None:
        """The tree of objects: by scene, entities and the links of those that have some."""
        if self._objects == scenes:
            return
        self._objects = scenes
        self._clear("objects")
        made = self._made["objects"]
        for index, entities in [*scenes.items()][:_MOST_LISTED]:
            with self._tree:
                folder = self._gui.add_folder(f"Scene {index} ({len(entities)})", expand_by_default=len(scenes) == 1)
            made.append(folder)
            # What is in a folder goes with it.
            with folder:
                for name, links in entities:
                    self._add_object(index, name, links)
        if len(scenes) > _MOST_LISTED:
            with self._tree:
                made.append(self._gui.add_html(line(f"and {len(scenes) - _MOST_LISTED} more scenes")))

    def _add_object(self, index: int, name: str, links: tuple[str, ...]) -> None:
        if not links:
            self._add_button(name, (index, name, 0))
            return
        with self._gui.add_folder(name, expand_by_default=False):
            for number, link in enumerate(links):
                self._add_button(link, (index, name, number))

    def _add_button(self, label: str, key: Key) -> None:
        button = self._gui.add_button(label, color="gray")
        button.on_click(lambda _: self._mail.post("select", lambda: self._actions.select(key)))

    def _add_problem(self) -> Any:
        panel = self._gui.add_panel(visible=False)
        with panel.add_tab("Error"):
            self._fault = self._gui.add_html("")
        # viser's own notices stand at the top.
        panel.float(x=15, y=-15, width=640)
        return panel

    def _add_tree(self) -> None:
        panel = self._gui.add_panel()
        self._tree = panel.add_tab("Objects")
        panel.dock_left()
        panel.set_width(_WIDTH)
        tabs = self._gui.add_panel()
        with tabs.add_tab("Selected"):
            self._facts = self._gui.add_html(line(_UNSELECTED))
        tabs.dock_below(panel)
        self._gui.main_panel.dock_right()
        self._gui.main_panel.set_width(_WIDTH)

    def _add_simulation(self) -> None:
        with self._gui.add_folder("Simulation", order=0):
            self._time = self._gui.add_html(line(_time_words(0, 0)))
            self._play = self._gui.add_button("Play")
            self._play.on_click(lambda _: self._mail.post("play", self._actions.play))
            self._step = self._gui.add_button("Step")
            self._step.on_click(lambda _: self._mail.post(object(), lambda: self._actions.step(1)))
            self._seed = self._gui.add_number("Seed", initial_value=0, min=0, max=_LARGEST, step=1)
            again = self._gui.add_button("Reset", hint="Back to the start, drawn with this seed where a reset draws")
            again.on_click(lambda _: self._post_seed("reset", self._actions.reset))
            anew = self._gui.add_button("Rebuild", hint="Build the scene anew, everything drawn with this seed")
            anew.on_click(lambda _: self._post_seed("rebuild", self._actions.rebuild))

    def _post_seed(self, key: str, action: Callable[[int], None]) -> None:
        self._mail.post(key, lambda: action(self._asked_seed()))

    def _asked_seed(self) -> int:
        """The value in the field, as long as it is not edited; a browser cannot show every value."""
        shown = _whole(self._seed.value, _LARGEST)
        return self._true_seed if shown == min(self._true_seed, _LARGEST) else shown

    def _add_scenes(self, count: int) -> list[Any]:
        scene = min(self._look.scene, count - 1)
        slider = self._gui.add_slider("Scene", min=0, max=count - 1, step=1, initial_value=scene)
        slider.disabled = self._look.grid
        grid = self._gui.add_checkbox("Side by side", initial_value=self._look.grid)
        note = self._gui.add_html("")
        slider.on_update(self._change)
        grid.on_update(self._change)
        return [slider, grid, note]

    def _add_shown(self) -> None:
        with self._gui.add_folder("Shown", order=20):
            self._boxes = {
                name: self._gui.add_checkbox(label, initial_value=getattr(self._look, name))
                for name, label in (
                    ("visual", "Visual shapes"),
                    ("collision", "Collision shapes"),
                    ("frames", "Frames"),
                    ("names", "Names"),
                    ("shadows", "Shadows"),
                )
            }
            for box in self._boxes.values():
                box.on_update(self._change)
            everything = self._gui.add_button("See all", hint="Move the camera to where it sees everything")
            everything.on_click(self._see_all)

    def _see_all(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            self._page.frame(event.client)

    def _change(self, event: object) -> None:
        """Asks for what the controls say when it is their turn: several threads of viser's may come here at once."""
        del event
        self._mail.post("look", self._look_at)

    def _look_at(self) -> None:
        found: dict[str, Any] = {name: bool(box.value) for name, box in self._boxes.items()}
        if self._made["scenes"]:
            slider, grid, _ = self._made["scenes"]
            slider.disabled = grid.value
            found |= {"scene": _whole(slider.value, self._scenes - 1), "grid": bool(grid.value)}
        self._look = replace(self._look, **found)
        self._actions.look_at(self._look)

    def _giver(self, name: str) -> Callable[[Callable[[], Any]], None]:
        return lambda read: self._mail.post(("give", name), lambda: self._actions.give(name, read()))

    def _clear(self, part: str) -> None:
        for handle in self._made[part]:
            handle.remove()
        self._made[part] = []


def _whole(value: float, largest: int) -> int:
    """A number from a browser, which may send anything, as one from 0 to the largest."""
    return int(min(max(value, 0), largest)) if isfinite(value) else 0


def _time_words(seconds: float, steps: int) -> str:
    return f"{seconds:.3f} s, {steps} step{'' if steps == 1 else 's'}"
