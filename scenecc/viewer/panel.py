"""The panel of the page: its controls and texts."""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

from scenecc.interrupt import interrupts_wait
from scenecc.viewer.controls import add_control
from scenecc.viewer.selected import SelectedPanel
from scenecc.viewer.texts import draws, findings, line, message
from scenecc.viewer.tree import ObjectTree

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import viser
    from numpy.typing import NDArray

    from scenecc.diagnostics import Diagnostic
    from scenecc.expand.listing import ParamRow
    from scenecc.viewer.nodes import Key
    from scenecc.viewer.options import ViewOptions
    from scenecc.viewer.page import Page
    from scenecc.viewer.session import Session
    from scenecc.viewer.tasks import TaskQueue


_RED = "#e03131"

_LARGEST = 2**53 - 1
"""Largest integer that a browser represents exactly."""

_MOST_SEED = 2**64 - 1

_WIDTH = 300

_MOST_CAMERAS: Final = 32
"""Maximum number of camera buttons: in a grid, every scene has its own cameras."""


class Panel:
    """Controls and texts. Ctrl-C waits for the end of each method, as in `Page`.

    Attributes:
        stop: set to end a recording.
        selected: controls of the selected body.
        tree: the objects.
    """

    @interrupts_wait()
    def __init__(
        self,
        server: viser.ViserServer,
        mail: TaskQueue,
        session: Session,
        page: Page,
        look: ViewOptions,
        *,
        links: bool = True,
    ) -> None:
        """`links`: whether places in files are links, for browsers on this machine."""
        self._links = links
        self.stop = threading.Event()
        self._gui = server.gui
        self._mail = mail
        self._session = session
        self._page = page
        self._look = look
        self._scenes = 0
        self._true_seed = 0
        self._params: tuple[ParamRow, ...] = ()
        self._made: dict[str, list[Any]] = {"scenes": [], "params": [], "cameras": []}
        self._problem = self._add_problem()
        self._add_simulation()
        self._scene_folder = self._gui.add_folder("Scenes", order=10, visible=False)
        self._draw_folder = self._gui.add_folder("Draws", order=15, visible=False)
        with self._draw_folder:
            self._draws = self._gui.add_html("")
        self._add_shown()
        self._cameras: tuple[str, ...] = ()
        self._camera_folder = self._gui.add_folder("Cameras", order=25, visible=False)
        self._param_folder = self._gui.add_folder("Parameters", order=30, visible=False)
        self._add_pictures()
        with self._gui.add_folder("Findings", order=40):
            check = self._gui.add_button("Check", hint="Run the start checks of `scenecc check`")
            check.on_click(lambda _: self._mail.post("check", self._session.check))
            self._findings = self._gui.add_html("", visible=False)
        self._add_tree()

    @interrupts_wait()
    def tell_fault(self, text: str) -> None:
        """Shows an error above all other content; "" removes it."""
        self._fault.content = message(text, color=_RED, links=self._links) if text else ""
        if self._problem.visible != bool(text):
            self._problem.visible = bool(text)

    @interrupts_wait()
    def tell_findings(self, diagnostics: Sequence[Diagnostic], *, none: str = "") -> None:
        """Shows warnings, notes and results of a check. `none`: text if there are none."""
        self._findings.content = findings(diagnostics, links=self._links) if diagnostics else line(none)
        self._findings.visible = bool(diagnostics) or bool(none)

    @interrupts_wait()
    def tell_draws(self, scene: int, seed: int, reset: int | None, values: Mapping[str, NDArray[Any]]) -> None:
        """Shows what a scene drew: when it was built, and since the last reset."""
        since = "" if reset is None else f", reset with seed {reset}"
        self._draws.content = draws(f"Scene {scene}, seed {seed}{since}", values)
        self._draw_folder.visible = bool(values)

    @interrupts_wait()
    def tell_recording(self, *, recording: bool) -> None:
        """Shows whether a video is being recorded."""
        self._record.label = "Stop recording" if recording else "Record"

    @interrupts_wait()
    def tell_time(self, seconds: float, steps: int) -> None:
        """Shows the simulated time."""
        self._time.content = line(_time_words(seconds, steps))

    @interrupts_wait()
    def tell_seed(self, seed: int) -> None:
        """Shows the seed of all draws."""
        self._true_seed = seed
        self._seed.value = min(seed, _LARGEST)

    @interrupts_wait()
    def tell_playing(self, *, playing: bool) -> None:
        """Shows whether the simulation is running."""
        self._play.label = "Pause" if playing else "Play"
        self._step.disabled = playing

    @interrupts_wait()
    def tell_marks(self, selected: Key | None, hidden: frozenset[str], locked: frozenset[str]) -> None:
        """Marks selected, hidden and locked objects in the tree."""
        self.tree.mark(selected, hidden, locked)
        self._show_all.visible = bool(hidden)

    @interrupts_wait()
    def set_scenes(self, count: int, left_out: int) -> None:
        """Sets the number of scenes, and how many of them the grid leaves out."""
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
        """Sets the parameters. Known controls keep their values, unless `afresh`: then they show `given`."""
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
                button = self._gui.add_button("As in the file", hint="Reset all parameters to the file's values")
                button.on_click(lambda _: self._mail.post("give nothing", self._session.give_nothing))
                self._made["params"].append(button)

    def _add_problem(self) -> Any:
        panel = self._gui.add_panel(visible=False)
        with panel.add_tab("Error"):
            self._fault = self._gui.add_html("")
        # viser's own notices are at the top.
        panel.float(x=15, y=-15, width=640)
        return panel

    def _add_tree(self) -> None:
        panel = self._gui.add_panel()
        tab = panel.add_tab("Objects")
        with tab:
            self._show_all = self._gui.add_button("Show all", visible=False, hint="Show all hidden entities")
            self._show_all.on_click(lambda _: self._mail.post("show all", self._session.show_all))
        self.tree = ObjectTree(
            self._gui,
            tab,
            lambda key: self._mail.post("select", lambda: self._session.select(key)),
            lambda: self._mail.post("search", self._session.search),
        )
        panel.dock_left()
        panel.set_width(_WIDTH)
        tabs = self._gui.add_panel()
        with tabs.add_tab("Selected"):
            self.selected = SelectedPanel(self._gui, self._mail, self._session)
        tabs.dock_below(panel)
        self._gui.main_panel.dock_right()
        self._gui.main_panel.set_width(_WIDTH)

    def _add_simulation(self) -> None:
        with self._gui.add_folder("Simulation", order=0):
            self._time = self._gui.add_html(line(_time_words(0, 0)))
            self._play = self._gui.add_button("Play")
            self._play.on_click(lambda _: self._mail.post(object(), self._session.play))
            self._step = self._gui.add_button("Step")
            self._step.on_click(lambda _: self._mail.post(object(), lambda: self._session.step(1)))
            self._seed = self._gui.add_number("Seed", initial_value=0, min=0, max=_LARGEST, step=1)
            again = self._gui.add_button("Reset", hint="Reset to the start; draws of a reset use this seed")
            again.on_click(lambda _: self._post_seed("reset", self._session.reset))
            rebuild = self._gui.add_button("Rebuild", hint="Rebuild the scene; all draws use this seed")
            rebuild.on_click(lambda _: self._post_seed("rebuild", self._session.rebuild))
            for label, by in (("Previous seed", -1), ("Next seed", 1)):
                button = self._gui.add_button(label, hint=f"Rebuild the scene with the {label.lower()}")
                button.on_click(partial(self._rebuild_beside, by))

    def _add_pictures(self) -> None:
        with self._gui.add_folder("Pictures", order=35):
            still = self._gui.add_button("Screenshot", hint="A PNG of this browser's view")
            still.on_click(self._screenshot)
            self._seconds = self._gui.add_number("Seconds", initial_value=3.0, min=0.1, max=600.0, step=0.1)
            self._record = self._gui.add_button("Record", hint="An MP4 of the simulation in this browser's view")
            self._record.on_click(self._record_video)

    def _screenshot(self, event: viser.GuiEvent[Any]) -> None:
        from scenecc.render.images import png
        from scenecc.viewer.recording import ShotError, shot

        if event.client is not None:
            with suppress(ShotError):
                event.client.send_file_download("scene.png", png(shot(event.client)), save_immediately=True)

    def _record_video(self, event: viser.GuiEvent[Any]) -> None:
        """Starts a recording. A second click ends it without waiting for it."""
        browser, seconds = event.client, self._seconds.value
        if self._record.label != "Record":
            self.stop.set()
        elif browser is not None and isfinite(seconds):
            self._mail.post("record", lambda: self._session.record(browser, min(max(seconds, 0.1), 600.0)))

    def _post_seed(self, key: str, action: Callable[[int], None]) -> None:
        self._mail.post(key, lambda: action(self._asked_seed()))

    def _asked_seed(self) -> int:
        """Returns the value in the field; an unedited field may show a rounded value, so the original is used."""
        shown = _whole(self._seed.value, _LARGEST)
        return self._true_seed if shown == min(self._true_seed, _LARGEST) else shown

    def _rebuild_beside(self, by: int, event: object) -> None:
        """Rebuilds with the seed before or after the one in the field."""
        del event
        self._mail.post(object(), lambda: self._session.rebuild(min(max(self._asked_seed() + by, 0), _MOST_SEED)))

    def _add_scenes(self, count: int) -> list[Any]:
        scene = min(self._look.scene, count - 1)
        slider = self._gui.add_slider("Scene", min=0, max=count - 1, step=1, initial_value=scene)
        slider.disabled = self._look.grid
        grid = self._gui.add_checkbox("Side by side", initial_value=self._look.grid)
        steps = [self._gui.add_button(label, disabled=self._look.grid) for label in ("Previous scene", "Next scene")]
        note = self._gui.add_html("")
        for button, by in zip(steps, (-1, 1), strict=True):
            button.on_click(partial(self._step_scene, slider, by))
        slider.on_update(self._change)
        grid.on_update(self._change)
        return [slider, grid, *steps, note]

    def _step_scene(self, slider: Any, by: int, event: object) -> None:
        """Moves the slider, which shows another scene."""
        del event
        slider.value = min(max(_whole(slider.value, self._scenes - 1) + by, 0), self._scenes - 1)

    def _add_shown(self) -> None:
        with self._gui.add_folder("Shown", order=20):
            self._boxes = {
                name: self._gui.add_checkbox(label, initial_value=getattr(self._look, name))
                for name, label in (
                    ("visual", "Visual shapes"),
                    ("collision", "Collision shapes"),
                    ("frames", "Frames"),
                    ("names", "Names"),
                    ("lights", "Lights of the file"),
                    ("shadows", "Shadows"),
                    ("contacts", "Contacts"),
                )
            }
            for box in self._boxes.values():
                box.on_update(self._change)
            everything = self._gui.add_button("See all", hint="Move the camera to see everything")
            everything.on_click(self._see_all)

    def _see_all(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            self._page.frame([event.client])

    @interrupts_wait()
    def set_lights(self, *, possible: bool) -> None:
        """Sets whether the file has lights that the page can show."""
        self._boxes["lights"].visible = possible

    @interrupts_wait()
    def set_cameras(self, names: tuple[str, ...]) -> None:
        """Adds a button for each camera of the file, which moves a browser's camera there."""
        if names == self._cameras:
            return
        self._cameras = names
        self._clear("cameras")
        self._camera_folder.visible = bool(names)
        with self._camera_folder:
            for name in names[:_MOST_CAMERAS]:
                button = self._gui.add_button(name)
                button.on_click(partial(self._look_through, name))
                self._made["cameras"].append(button)
            if len(names) > _MOST_CAMERAS:
                self._made["cameras"].append(self._gui.add_html(line(f"and {len(names) - _MOST_CAMERAS} more")))

    def _look_through(self, name: str, event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            self._page.frame([event.client], name)

    def _change(self, event: object) -> None:
        """Posts a task that reads the controls when it runs: several viser threads may get here at once."""
        del event
        self._mail.post("look", self._look_at)

    def _look_at(self) -> None:
        found: dict[str, Any] = {name: bool(box.value) for name, box in self._boxes.items()}
        if self._made["scenes"]:
            slider, grid, *steps, _ = self._made["scenes"]
            for control in (slider, *steps):
                control.disabled = grid.value
            found |= {"scene": _whole(slider.value, self._scenes - 1), "grid": bool(grid.value)}
        self._look = replace(self._look, **found)
        self._session.look_at(self._look)

    def _giver(self, name: str) -> Callable[[Callable[[], Any]], None]:
        return lambda read: self._mail.post(("give", name), lambda: self._session.give(name, read()))

    def _clear(self, part: str) -> None:
        for handle in self._made[part]:
            handle.remove()
        self._made[part] = []


def _whole(value: float, largest: int) -> int:
    """Returns a number from a browser, which may be anything, as an integer from 0 to the maximum."""
    return int(min(max(value, 0), largest)) if isfinite(value) else 0


def _time_words(seconds: float, steps: int) -> str:
    return f"{seconds:.3f} s, {steps} step{'' if steps == 1 else 's'}"
