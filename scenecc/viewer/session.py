"""Events of a page: one thread owns the engine, and handles requests of browsers and file changes."""

from __future__ import annotations

import time
from contextlib import closing
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.formats import render
from scenecc.errors import SceneError
from scenecc.geometry.rotations import compose, invert
from scenecc.selection_link import SelectionLink
from scenecc.source.edits import EditError
from scenecc.viewer.cameras import first_view
from scenecc.viewer.controls import AsWritten
from scenecc.viewer.editor import FileEditor
from scenecc.viewer.page import Page
from scenecc.viewer.panel import Panel
from scenecc.viewer.progress import BuildProgress
from scenecc.viewer.selected import Selected
from scenecc.viewer.surfaces import SurfaceFiles
from scenecc.viewer.tasks import FileWatcher, TaskQueue, interrupts_kept
from scenecc.viewer.world import World, check_selected_scene, count_bodies, load

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from pathlib import Path

    import viser

    from scenecc.diagnostics import Diagnostic
    from scenecc.geometry.rotations import Pose7
    from scenecc.options import Options
    from scenecc.pipeline import Source
    from scenecc.selection_link import Place
    from scenecc.viewer.nodes import Key
    from scenecc.viewer.options import ViewOptions
    from scenecc.viewer.world import Loaded, Loading

_FRAME: Final = 1 / 30
"""Display time of a frame of a running simulation [s]."""

_MANY: Final = 200
"""Number of bodies side by side from which one scene is shown first."""

_TELLING: Final = 0.2
"""Time between two texts of the pose of the selected body, while it moves [s]."""

_ROUNDING: Final = 1e-9
"""Rounding error of a sum of times, in steps."""

_BEHIND: Final = 0.25
"""Maximum lag of the simulation behind the clock [s]. Beyond it, the simulation runs slower instead of catching up."""


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
        report: Callable[[Sequence[Diagnostic]], None],
        progress: Callable[[int, int], None] | None = None,
        links: bool = True,
        writes: bool = True,
    ) -> None:
        """`path`: path of the source, if it is a file that may change. `report` is called with the diagnostics each
        time, and `progress` with (scenes done, total scenes).

        `links`: whether places in files are links for an editor on this machine. `writes`: whether dragging a body may
        change the file. `source` is called before each compilation, because a stream can be read only once.
        """
        self._source, self._options, self._path, self._report = source, options, path, report
        self._look = self._built = look
        self._given: dict[str, Any] = {}
        self._mail = TaskQueue()
        self._files = SurfaceFiles()
        self._page = Page(server, lambda key: self._mail.post("select", lambda: self.pick(key)), self._drag)
        self._progress = BuildProgress(server, progress)
        self._panel = Panel(server, self._mail, self, self._page, look, links=links)
        self._watch = FileWatcher(lambda: self._mail.post("reload", self.reload))
        self._watched: frozenset[Path] = frozenset()
        self._world: World | None = None
        self._editor = FileEditor(path, writes=writes)
        self._selected: Key | None = None
        self._locked: frozenset[str] = frozenset()
        self._moves = False
        self._broken = ""
        self._playing = False
        self._shown_at = self._owed = self._told_at = 0.0
        self._reset_seed: int | None = None
        self._poses = np.zeros((0, 7), np.float32)
        self._link: SelectionLink | None = None

    def serve(self, ready: Callable[[], None]) -> None:
        """Starts, and runs until the thread is interrupted. Raises SceneError, as `start`."""
        with interrupts_kept(self._mail), closing(SelectionLink("page", self._hear)) as self._link:
            self.start(ready)
            self.run()

    def start(self, ready: Callable[[], None] = lambda: None) -> None:
        """Shows the scene or its errors. Raises SceneError if the requested scene does not exist.

        `ready` is called before the engine builds, so that a browser loads the page meanwhile.
        """
        if self._path is not None:
            self._watch.see([self._path])
        loading = self._load({})
        if loading.loaded is None:
            self._break(loading.diagnostics)
            ready()
            return
        check_selected_scene(self._look, loading.loaded.plan)
        self._progress.tell_first()
        ready()
        self._try(lambda: self._take(loading))

    def run(self) -> None:
        """Runs posted tasks until the thread is interrupted."""
        while True:
            task = self._mail.take(self._shown_at + _FRAME - time.monotonic() if self._playing else None)
            if task is not None:
                self._try(task)
            elif self._playing:
                self._try(self._advance)

    def close(self) -> None:
        """Stops watching files, and frees the engine's objects."""
        self._watch.close()
        if self._world is not None:
            self._world.close()
            self._world = None

    def reload(self) -> None:
        """Compiles and builds the current file; on an error, the old scene stays."""
        loading = self._load(self._given)
        afresh = loading.loaded is None and bool(self._given)
        if afresh and (plain := self._load({})).loaded is not None:
            # Values set on the page no longer fit the file.
            self._given = self._fitting_values()
            loading = self._load(self._given) if self._given else plain
        self._take(loading, afresh=afresh)

    def give(self, name: str, value: Any) -> None:
        """Rebuilds the scene with another value of a parameter; `AS_WRITTEN`: the file's own."""
        kept = {known: given for known, given in self._given.items() if known != name}
        self._given = kept if isinstance(value, AsWritten) else {**kept, name: value}
        if isinstance(value, AsWritten):
            self._forget(name)
        self._take(self._load(self._given))

    def give_nothing(self) -> None:
        """Rebuilds the scene with the file's own values of all parameters."""
        self._given = {}
        self._forget(*self._options.params)
        self._take(self._load({}), afresh=True)

    def rebuild(self, seed: int) -> None:
        """Rebuilds the scene with another seed."""
        self._options = replace(self._options, seed=seed)
        self.reload()

    def reset(self, seed: int) -> None:
        """Resets all bodies to their start."""
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
        self._reset_seed = seed
        self._show_poses()
        self._touch(self._world)
        self._tell_time()
        self._tell_selected()
        self._tell_draws()

    def look_at(self, look: ViewOptions) -> None:
        """Changes what is shown; builds other scenes if needed."""
        self._look = look = replace(look, hidden=self._look.hidden)
        if self._world is None:
            return
        if (self._built.scene, self._built.grid) != (look.scene, look.grid):
            self._build(self._world.loaded, look)
        else:
            self._paint(self._world)
            self._panel.tell_fault(self._broken)

    def play(self) -> None:
        """Starts or stops the simulation."""
        self._playing = not self._playing and self._world is not None
        self._shown_at, self._owed = time.monotonic(), 0.0
        self._panel.tell_playing(playing=self._playing)
        if self._moves:
            self.move(on=False)

    def step(self, n: int) -> None:
        """Simulates some steps."""
        if self._world is not None:
            self._simulate_steps(self._world, n)

    def select(self, key: Key) -> None:
        """Selects a body: shows the properties of its entity, and sends editors the place where it is written."""
        self._select(key)
        if self._world is not None and self._link is not None:
            self._link.send(self._world.written(key))

    def select_written(self, places: Collection[Place]) -> None:
        """Selects what is written at an editor's cursor, without sending the selection back to editors."""
        found = [] if self._world is None else self._world.written_at(places)
        if found and not (self._selected and self._selected[:2] in {key[:2] for key in found}):
            self._select(found[0])

    def pick(self, key: Key) -> None:
        """Selects a clicked body, unless it is locked."""
        if key[1] not in self._locked:
            self.select(key)

    def search(self) -> None:
        """Lists the objects that match the search."""
        self._panel.tree.search()
        self._tell_marks()

    def hide(self, *, hidden: bool) -> None:
        """Hides or shows the entity of the selected body."""
        if self._selected is not None:
            self._show_but(_with_name(self._look.hidden, self._selected[1], inside=hidden))

    def show_all(self) -> None:
        """Shows all hidden entities."""
        self._show_but(frozenset())

    def lock(self, *, locked: bool) -> None:
        """Locks or unlocks the entity of the selected body against clicks and moves."""
        if self._selected is not None:
            self._locked = _with_name(self._locked, self._selected[1], inside=locked)
            self._moves = self._moves and not locked
            self._tell_selected()

    def move(self, *, on: bool) -> None:
        """Adds a gizmo to the selected body, or removes it."""
        self._moves = on and self._selected is not None and self._selected[1] not in self._locked
        self._tell_selected()

    def set_joint(self, number: int, position: float) -> None:
        """Moves a joint of the selected articulation; the file does not change."""
        world, key = self._world, self._selected
        if world is None or key is None:
            return
        joints = world.joints(key)
        if number < len(joints) and isfinite(position):
            joint = joints[number]
            world.set_joint(key, number, min(max(position, joint.low), joint.high))
            self._show_poses()

    def check(self) -> None:
        """Shows what `scenecc check` finds at the start of the scenes, with boxes around overlapping bodies."""
        world = self._world
        if world is None:
            return
        from scenecc.viewer.checking import check_start

        found = check_start(world.loaded, world.scene_idxs)
        boxes = {key: world.box(key) for key in world.named(found.overlapping)}
        self._page.warn({key: box for key, box in boxes.items() if box is not None})
        self._panel.tell_findings([*world.loaded.sink.diagnostics(), *found.diagnostics], none="No findings.")

    def record(self, browser: viser.ClientHandle, seconds: float) -> None:
        """Simulates for a time [s], and sends a browser a video of its view; a second click ends it early."""
        world = self._world
        if world is None:
            return
        from scenecc.viewer.recording import RATE, record_video

        if self._playing:
            self.play()
        self._panel.stop.clear()
        self._panel.tell_recording(recording=True)
        left, owed = round(seconds * RATE), 0.0

        def advance() -> bool:
            nonlocal left, owed
            left -= 1
            owed += 1 / RATE
            steps = int(owed / world.timestep + _ROUNDING)
            owed -= steps * world.timestep
            self._simulate_steps(world, steps)
            return left > 0 and not self._panel.stop.is_set()

        try:
            content = record_video(browser, advance)
        finally:
            self._panel.tell_recording(recording=False)
        browser.send_file_download("scene.mp4", content, save_immediately=True)

    def drag(self, key: Key, pose: Pose7) -> None:
        """Shows the entity of a body at another pose. `pose`: pose of its root, in its scene."""
        if self._world is None or not self._moves:
            return
        starts = self._world.places(key)
        if not starts:
            return  # dragged before a file change that removed it
        root = next(iter(starts.values()))
        poses = [compose(compose(pose, invert(root)), start) for start in starts.values()]
        self._page.move([*starts], np.array(poses, np.float32))

    def drop(self, key: Key, pose: Pose7) -> None:
        """Writes the pose of a dragged body to the file, which is then reloaded as usual."""
        world = self._world
        if world is None or not self._moves or not world.places(key):
            return
        entity = next(one for one in world.loaded.plan.entities if one.name == key[1])
        try:
            written = self._editor.write_pose(world.loaded, self._options, entity, key[0], pose)
        except EditError as error:
            self._paint(world)
            self._panel.selected.tell_refusal(f"Not moved: {error}.")
            return
        if not written:
            self._paint(world)
        self._panel.selected.tell_undo(possible=self._editor.can_undo)

    def undo(self) -> None:
        """Undoes the last move in the file."""
        try:
            self._editor.undo()
        except EditError as error:
            self._panel.selected.tell_refusal(f"Not undone: {error}.")
        self._panel.selected.tell_undo(possible=self._editor.can_undo)

    def _hear(self, places: list[Place]) -> None:
        self._mail.post("select written", lambda: self.select_written(places))

    def _drag(self, key: Key, pose: Pose7, done: bool) -> None:  # noqa: FBT001 - the page's callback signature
        if done:
            self._mail.post(("drop", key), lambda: self.drop(key, pose))
        else:
            self._mail.post("drag", lambda: self.drag(key, pose))

    def _show_but(self, hidden: frozenset[str]) -> None:
        self._look = replace(self._look, hidden=hidden)
        if self._world is not None:
            self._paint(self._world)
        self._tell_selected()

    def _select(self, key: Key) -> None:
        before, self._selected, self._moves = self._selected, key, self._moves and key == self._selected
        self._tell_selected()
        if before is None or before[0] != key[0]:
            self._tell_draws()

    def _tell_selected(self) -> None:
        """Shows the selection in the panel, the tree and the view."""
        world, key = self._world, self._selected
        item = None if world is None or key is None else world.facts(key)
        if world is None or key is None or item is None:
            self._selected, self._moves = None, False
            self._panel.selected.tell(None, moves=False)
            self._panel.selected.tell_pose("", None)
            self._page.outline(None, None)
            self._page.hold(None)
        else:
            reason = self._unmovable(world, key[1])
            self._moves = self._moves and not reason
            hidden, locked = key[1] in self._look.hidden, key[1] in self._locked
            self._panel.selected.tell(Selected(key, item, hidden, locked, reason, world.joints(key)), moves=self._moves)
            self._tell_pose(world, key)
            self._page.outline(None if hidden else key, world.box(key))
            self._page.hold(next(iter(world.places(key))) if self._moves else None)
        self._tell_marks()

    def _tell_marks(self) -> None:
        self._panel.tell_marks(self._selected, self._look.hidden, self._locked)

    def _unmovable(self, world: World, name: str) -> str:
        """Returns why the pose of an entity cannot be written to the file; "" if it can."""
        if world.steps or self._playing:
            return "the simulation has run; press Reset first"
        try:
            self._editor.check(world.loaded, name)
        except EditError as error:
            return str(error)
        return ""

    def _forget(self, *names: str) -> None:
        """Drops values that were set at the start."""
        params = {name: value for name, value in self._options.params.items() if name not in names}
        self._options = replace(self._options, params=params)

    def _fitting_values(self) -> dict[str, Any]:
        """Returns the values set on the page that the file accepts."""
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
        """Simulates for the display time of the last frame in whole steps, and carries over the rest."""
        assert self._world is not None
        now = time.monotonic()
        timestep = self._world.timestep
        self._owed = min(self._owed + now - self._shown_at, _BEHIND + timestep)
        self._shown_at = now
        until = now + _BEHIND
        while self._owed >= timestep and time.monotonic() < until:
            self._world.step()
            self._owed -= timestep
        self._simulate_steps(self._world)

    def _simulate_steps(self, world: World, n: int = 0) -> None:
        """Simulates some steps, and shows all poses. If the simulation diverges, it stops and the poses stay."""
        if self._moves:
            self.move(on=False)
        try:
            world.step(n, check=True)
        except SceneError:
            if self._playing:
                self.play()
            raise
        self._show_poses()
        self._touch(world)
        self._tell_time()

    def _load(self, given: Mapping[str, Any]) -> Loading:
        """Compiles the scene, and watches its files; after an error, also the old scene's files."""
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
        # Of many scenes, one is shown first.
        apart = self._world is None and self._look.grid and sum(count_bodies(loading.loaded.plan)) > _MANY
        self._broken = ""
        try:
            self._build(loading.loaded, replace(self._look, grid=False) if apart else self._look)
        except SceneError as error:
            self._break(error.diagnostics)
            return
        if apart:
            self._mail.post("side by side", lambda: self.look_at(self._look))
        self._panel.set_params(loading.loaded.params, loading.loaded.given, afresh=afresh)

    def _build(self, loaded: Loaded, look: ViewOptions) -> None:
        with self._progress:
            self._show(World(loaded, look, self._progress.tell), look)

    def _show(self, world: World, look: ViewOptions) -> None:
        """Replaces the displayed scenes, once nothing can fail any more."""
        before = self._world
        try:
            picture = world.picture(look, self._files)
        except BaseException:
            world.close()
            raise
        if before is not None:
            before.close()
        grid = self._built.grid
        self._world, self._built = world, look
        self._panel.tell_fault(self._broken)
        self._page.show(picture, self._files.contents)
        if before is None:
            self._page.open_at(first_view(picture.views, picture.solids, grid=look.grid))
        elif grid != look.grid:
            self._page.frame_all()
        self._panel.set_lights(possible=world.has_lights)
        self._panel.set_cameras(tuple(view.name for view in picture.views))
        self._files.keep(self._page.files)
        self._poses = world.poses()
        self._panel.set_scenes(world.loaded.plan.num_scenes, world.left_out)
        self._panel.tree.show(world.entities())
        if before is None or before.loaded is not world.loaded:
            diagnostics = world.loaded.sink.diagnostics()
            self._panel.tell_findings(diagnostics)
            self._page.warn({})
            self._report(diagnostics)
            self._panel.tell_seed(world.loaded.seed)
        self._reset_seed = None
        if self._selected is not None and self._selected[0] not in world.scene_idxs:
            self._selected = (world.scene_idxs[0], *self._selected[1:])
        self._touch(world)
        self._tell_time()
        self._tell_selected()
        self._tell_draws()

    def _paint(self, world: World) -> None:
        poses = world.poses()
        picture = world.picture(self._look, self._files).moved(world.keys, poses)
        self._page.show(picture, self._files.contents)
        self._files.keep(self._page.files)
        self._poses = poses
        self._touch(world)

    def _show_poses(self) -> None:
        """Sends the poses of moved bodies."""
        assert self._world is not None
        poses = self._world.poses()
        moved = np.flatnonzero((poses != self._poses).any(axis=1))
        if len(moved):
            self._page.move([self._world.keys[number] for number in moved], poses[moved])
        self._poses = poses
        if self._selected is not None:
            self._panel.selected.tell_joints(self._world.joints(self._selected))
            if not self._playing or time.monotonic() > self._told_at + _TELLING:
                self._tell_pose(self._world, self._selected)

    def _tell_pose(self, world: World, key: Key) -> None:
        self._told_at = time.monotonic()
        self._panel.selected.tell_pose(*(world.pose(key) or ("", None)))

    def _tell_draws(self) -> None:
        """Shows what was drawn in the scene of the selected body, or in the first scene shown."""
        world, key = self._world, self._selected
        if world is None:
            return
        scene = key[0] if key is not None and key[0] in world.scene_idxs else world.scene_idxs[0]
        self._panel.tell_draws(scene, world.loaded.seed, self._reset_seed, world.draws(scene))

    def _touch(self, world: World) -> None:
        """Shows contacts, if enabled."""
        none = np.zeros((0, 3), np.float32)
        self._page.touch(*(world.contacts() if self._look.contacts else (np.zeros(0, np.int64), none, none)))

    def _tell_time(self) -> None:
        assert self._world is not None
        self._panel.tell_time(self._world.time, self._world.steps)

    def _break(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Shows the errors of the file until they are fixed."""
        self._broken = render(diagnostics)
        self._fault(diagnostics)

    def _fault(self, diagnostics: Sequence[Diagnostic], before: str = "") -> None:
        """Shows diagnostics, after earlier text."""
        self._panel.tell_fault("\n".join(filter(None, (before, render(diagnostics)))))
        self._report(diagnostics)


def _with_name(names: frozenset[str], name: str, *, inside: bool) -> frozenset[str]:
    return names | {name} if inside else names - {name}
