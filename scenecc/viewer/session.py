"""Events of a page: one thread owns the engine, and executes the requests of browsers and watched files."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.formats import render
from scenecc.errors import SceneError
from scenecc.viewer.nodes import Files
from scenecc.viewer.page import Page
from scenecc.viewer.panel import AsWritten, Panel
from scenecc.viewer.tasks import FileWatcher, TaskQueue, interrupts_kept
from scenecc.viewer.world import World, check_scene, load

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    import viser

    from scenecc.diagnostics import Diagnostic
    from scenecc.options import Options
    from scenecc.pipeline import Source
    from scenecc.viewer.nodes import Key
    from scenecc.viewer.options import ViewOptions
    from scenecc.viewer.world import Loading

_FRAME: Final = 1 / 30
"""How long a picture of a running simulation is shown [s]."""

_BEHIND: Final = 0.25
"""A simulation that is further behind the clock [s] runs slower than it: it does not catch up."""


class Session:
    """A file on a page, until it is closed."""

    def __init__(
        self,
        server: viser.ViserServer,
        source: Callable[[], Source],
        options: Options,
        look: ViewOptions,
        *,
        path: Path | None,
        told: Callable[[Sequence[Diagnostic]], None],
    ) -> None:
        """`path`: of the source, where it is a file that may change. `told` is called with the diagnostics each time.

        `source` is asked for before each compilation: a stream can be read once only.
        """
        self._source, self._options, self._path, self._told = source, options, path, told
        self._look = self._built = look
        self._given: dict[str, Any] = {}
        self._mail = TaskQueue()
        self._files = Files()
        self._page = Page(server, lambda key: self._mail.post("select", lambda: self.select(key)))
        self._panel = Panel(server, self._mail, self, self._page, look)
        self._watch = FileWatcher(lambda: self._mail.post("reload", self.reload))
        self._watched: frozenset[Path] = frozenset()
        self._world: World | None = None
        self._selected: Key | None = None
        self._broken = ""
        self._playing = False
        self._shown_at = self._owed = 0.0
        self._poses = np.zeros((0, 7), np.float32)

    def serve(self, ready: Callable[[], None]) -> None:
        """Starts, says that it is ready, and runs until the thread is interrupted. Raises SceneError, as `start`."""
        with interrupts_kept(self._mail):
            self.start()
            ready()
            self.run()

    def start(self) -> None:
        """Shows the scene, or what is wrong with it. Raises SceneError if it has no such scene as is to be shown."""
        if self._path is not None:
            self._watch.see([self._path])
        loading = self._load({})
        if loading.loaded is not None:
            check_scene(self._look, loading.loaded.plan)
        self._try(lambda: self._take(loading))

    def run(self) -> None:
        """Does what is asked for, until the thread is interrupted."""
        while True:
            task = self._mail.take(self._shown_at + _FRAME - time.monotonic() if self._playing else None)
            if task is not None:
                self._try(task)
            elif self._playing:
                self._try(self._advance)

    def close(self) -> None:
        """Ends the watch, and frees the engine's objects."""
        self._watch.close()
        if self._world is not None:
            self._world.close()
            self._world = None

    def reload(self) -> None:
        """Compiles and builds the file as it is now; on an error, the scene before stays."""
        loading = self._load(self._given)
        afresh = loading.loaded is None and bool(self._given)
        if afresh and (plain := self._load({})).loaded is not None:
            # What was given by hand no longer fits to the file.
            self._given = self._fitting()
            loading = self._load(self._given) if self._given else plain
        self._take(loading, afresh=afresh)

    def give(self, name: str, value: Any) -> None:
        """Builds the scene with another value of a parameter; `AS_WRITTEN`: the file's own."""
        kept = {known: given for known, given in self._given.items() if known != name}
        self._given = kept if isinstance(value, AsWritten) else {**kept, name: value}
        if isinstance(value, AsWritten):
            self._forget(name)
        self._take(self._load(self._given))

    def give_nothing(self) -> None:
        """Builds the scene with the file's own values of all parameters."""
        self._given = {}
        self._forget(*self._options.params)
        self._take(self._load({}), afresh=True)

    def rebuild(self, seed: int) -> None:
        """Builds the scene with another seed."""
        self._options = replace(self._options, seed=seed)
        self.reload()

    def reset(self, seed: int) -> None:
        """Puts all bodies back to their start."""
        if self._world is None:
            return
        try:
            self._world.reset(seed)
        except ValueError as error:
            loaded = self._world.loaded
            sink = loaded.sink.another()
            sink.report("SC817", str(error), loaded.plan.origin or Location(None))
            raise SceneError(sink.diagnostics()) from error
        self._panel.tell_fault(self._broken)
        self._show_poses()
        self._tell_time()

    def look_at(self, look: ViewOptions) -> None:
        """Shows something else of the scene; other scenes are built for it."""
        self._look = look
        if self._world is None:
            return
        if (self._built.scene, self._built.grid) != (look.scene, look.grid):
            self._show(World(self._world.loaded, look))
        else:
            self._paint(self._world)
            self._panel.tell_fault(self._broken)

    def play(self) -> None:
        """Lets the simulation run, or stops it."""
        self._playing = not self._playing and self._world is not None
        self._shown_at, self._owed = time.monotonic(), 0.0
        self._panel.tell_playing(playing=self._playing)

    def step(self, n: int) -> None:
        """Simulates some steps."""
        if self._world is not None:
            self._simulated(self._world, n)

    def select(self, key: Key) -> None:
        """Tells what is known of a body and of what it belongs to."""
        item = self._world and self._world.facts(key)
        self._selected = None if item is None else key
        self._panel.tell_facts(item)

    def _forget(self, *names: str) -> None:
        """Lets go of values that were given at the start."""
        params = {name: value for name, value in self._options.params.items() if name not in names}
        self._options = replace(self._options, params=params)

    def _fitting(self) -> dict[str, Any]:
        """Those of the values that were given by hand that the file takes."""
        kept: dict[str, Any] = {}
        for name, value in self._given.items():
            if self._load({**kept, name: value}).loaded is not None:
                kept[name] = value
        return kept

    def _try(self, task: Callable[[], None]) -> None:
        try:
            task()
        except SceneError as error:
            self._fault(error.diagnostics, self._broken)

    def _advance(self) -> None:
        """Simulates as long as the last picture was shown, in whole steps: what is left over counts for the next."""
        assert self._world is not None
        now = time.monotonic()
        timestep = self._world.timestep
        self._owed = min(self._owed + now - self._shown_at, _BEHIND + timestep)
        self._shown_at = now
        until = now + _BEHIND
        while self._owed >= timestep and time.monotonic() < until:
            self._world.step()
            self._owed -= timestep
        self._simulated(self._world)

    def _simulated(self, world: World, n: int = 0) -> None:
        """Simulates some more steps, and shows where everything is; one that diverges stops, and its poses stay."""
        try:
            world.step(n, check=True)
        except SceneError:
            if self._playing:
                self.play()
            raise
        self._show_poses()
        self._tell_time()

    def _load(self, given: Mapping[str, Any]) -> Loading:
        """Compiles the scene, and watches what it used; of one that is at fault, what the one before used, too."""
        since = time.time_ns()
        loading = load(self._source(), self._options, given)
        if self._path is not None:
            files = loading.files | {self._path}
            self._watched = files if loading.loaded is not None else files | self._watched
            self._watch.see(self._watched, since)
        return loading

    def _take(self, loading: Loading, *, afresh: bool = False) -> None:
        if loading.loaded is None:
            self._break(loading.diagnostics)
            return
        try:
            world = World(loading.loaded, self._look)
            self._broken = ""
            self._show(world)
        except SceneError as error:
            self._break(error.diagnostics)
            return
        self._panel.set_params(loading.loaded.params, loading.loaded.given, afresh=afresh)

    def _show(self, world: World) -> None:
        """Shows scenes in place of those before, once nothing can go wrong any more."""
        before = self._world
        try:
            picture = world.picture(self._look, self._files)
        except BaseException:
            world.close()
            raise
        if before is not None:
            before.close()
        self._world, self._built = world, self._look
        self._panel.tell_fault(self._broken)
        self._page.show(picture, self._files.contents)
        if before is None:
            self._page.frame()
        self._files.keep(self._page.digests)
        self._poses = world.poses()
        self._panel.set_scenes(world.loaded.plan.num_scenes, world.left_out)
        self._panel.set_objects(world.entities())
        if before is None or before.loaded is not world.loaded:
            diagnostics = world.loaded.sink.diagnostics()
            self._panel.tell_warnings(render(diagnostics))
            self._told(diagnostics)
            self._panel.tell_seed(world.loaded.plan.seed)
        self._tell_time()
        if self._selected is not None:
            self.select(self._selected)

    def _paint(self, world: World) -> None:
        poses = world.poses()
        picture = world.picture(self._look, self._files).moved(world.keys, poses)
        self._page.show(picture, self._files.contents)
        self._files.keep(self._page.digests)
        self._poses = poses

    def _show_poses(self) -> None:
        """Sends the poses of bodies that have moved."""
        assert self._world is not None
        poses = self._world.poses()
        moved = np.flatnonzero((poses != self._poses).any(axis=1))
        if len(moved):
            self._page.move([self._world.keys[number] for number in moved], poses[moved])
        self._poses = poses

    def _tell_time(self) -> None:
        assert self._world is not None
        self._panel.tell_time(self._world.time, self._world.steps)

    def _break(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Tells what is wrong with the file, from now on until it is mended."""
        self._broken = render(diagnostics)
        self._fault(diagnostics)

    def _fault(self, diagnostics: Sequence[Diagnostic], before: str = "") -> None:
        """Tells what is wrong, after what was wrong before."""
        self._panel.tell_fault("\n".join(filter(None, (before, render(diagnostics)))))
        self._told(diagnostics)
