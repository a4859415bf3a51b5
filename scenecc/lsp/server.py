"""The server: the editor's texts, their checks, and notifications.

One thread reads and writes messages, and only this thread changes state. Other threads answer requests from a view of
the state, and another process compiles scenes, so that nothing blocks.
"""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol

from scenecc.lsp import worker
from scenecc.lsp.findings import findings_in, to_client
from scenecc.lsp.positions import Columns, path_of
from scenecc.lsp.process import AnalysisProcess, FaultError, WorkerStopped
from scenecc.lsp.workspace import Workspace, WorkspaceView, editor_path
from scenecc.selection_link import Place, SelectionLink
from scenecc.version import VERSION

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.options import Options

FindingFilter = Callable[["list[Diagnostic]", str], "list[Diagnostic]"]
"""Selects findings by the scene's path, and sets their severity."""

_LOG: Final = logging.getLogger(__name__)
"""Logs to standard error, which editors keep."""

_DEBOUNCE: Final = 0.05
"""Idle time before a scene is checked [s]."""

_PATIENCE: Final = 10.0
"""Maximum time that a check of an outdated text may continue [s]. Ending the process loses its cached meshes."""

_ENGINE_SECONDS: Final = 3.0
"""Maximum wait for an entity's mass in a hover text [s]."""


_INVALID: Final = "scenecc/invalid"
"""The request that stands for one whose parameters are not of the protocol."""


class _Protocol(LanguageServerProtocol):
    """The protocol, with an answer to requests of the wrong form: pygls would only show a message."""

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Converts a message of a client."""
        try:
            return super().structure_message(data)
        except JsonRpcException:
            if "id" not in data or "method" not in data:
                raise
            return super().structure_message({"jsonrpc": "2.0", "id": data["id"], "method": _INVALID, "params": {}})


def _refuse_invalid(*params: Any) -> None:
    del params
    raise JsonRpcInvalidParams("the parameters are not those of the protocol")


class SceneServer(LanguageServer):
    """The language server of scene files.

    Args:
        options: what scenes may use.
        finding_filter: selects findings.

    Attributes:
        scenes: the editor's texts.
        finding_filter: selects findings.
        checker: the process that checks scenes.
        engine: the process that asks the engine about entities.
        is_ending: whether the editor has announced its end.
    """

    def __init__(self, options: Options, finding_filter: FindingFilter) -> None:
        full = types.TextDocumentSyncKind.Full  # the lines of a full text are counted only here
        super().__init__(  # pyright: ignore[reportUnknownMemberType]
            "scenecc", VERSION, text_document_sync_kind=full, protocol_cls=_Protocol
        )
        self.feature(_INVALID)(_refuse_invalid)
        self.is_ending = False
        self.scenes = Workspace(options)
        self.checker = AnalysisProcess()
        self.engine = AnalysisProcess()
        self.finding_filter = finding_filter
        self._uris: dict[Path, str] = {}
        self._due: dict[Path, None] = {}
        self._task: asyncio.Task[None] | None = None
        self._changed = 0.0
        self._link: SelectionLink | None = None
        self._described: dict[tuple[Path, str], tuple[WorkspaceView, asyncio.Task[worker.EntityFacts | None]]] = {}

    @property
    def columns(self) -> Columns:
        """The client's column units."""
        return Columns(str(getattr(self.workspace.position_encoding, "value", self.workspace.position_encoding)))

    def path(self, uri: str) -> Path | None:
        """Returns the file of a URI; None if it is not a file."""
        path = path_of(uri)
        return None if path is None or "\0" in path else editor_path(path)

    def uri(self, path: Path) -> str:
        """Returns the URI of a file, in the client's notation if the file is open."""
        return self._uris.get(path) or path.as_uri()

    def changed(self, uri: str) -> None:
        """Stores the text of an opened or changed file."""
        path = self.path(uri)
        if path is not None:
            self._uris[path] = uri
            self.scenes.put(path, self.workspace.get_text_document(uri).source)
            if path not in self.scenes.projects:
                self._publish_one(uri, [])
            self.schedule(path)

    def closed(self, uri: str) -> None:
        """Drops a closed file."""
        path = self.path(uri)
        if path is not None:
            parts = self.scenes.projects[path].files.values() if path in self.scenes.projects else ()
            self.scenes.drop(path)
            self._publish_one(uri, [])
            self._uris.pop(path, None)
            for each in (path, *parts):
                self.schedule(each)

    def schedule(self, path: Path) -> None:
        """Schedules checks of all open scenes that read a file."""
        self._schedule(self.scenes.view().users(path))

    def schedule_all(self) -> None:
        """Schedules checks of all open scenes, because files on the disk changed."""
        self._described.clear()
        self.engine.stop()
        self._schedule([*self.scenes.projects])

    def _schedule(self, due: list[Path]) -> None:
        if not due:
            return
        self._due |= dict.fromkeys(due)
        loop = asyncio.get_running_loop()
        self._changed = loop.time()
        self.checker.stop_older(_PATIENCE)
        if self._task is None or self._task.done():
            self._task = loop.create_task(self._check_due())

    async def _check_due(self) -> None:
        loop = asyncio.get_running_loop()
        while self._due:
            while (left := self._changed + _DEBOUNCE - loop.time()) > 0:
                await asyncio.sleep(left)
            path = next(iter(self._due), None)
            if path is None:
                return
            del self._due[path]
            try:
                await self._check(path)
            except WorkerStopped as end:
                if end.crashed:
                    self.tell("the check of this scene crashed; the scene is checked again when it changes")
                else:
                    self._due[path] = None
            except Exception:  # noqa: BLE001 - the next text must still be checked
                _LOG.exception("checking %s", path)
                self.tell(f"this is a bug in scenecc, not an error in {path.name}")

    async def _check(self, path: Path) -> None:
        view = self.scenes.view()
        if path not in view.projects or path not in await asyncio.to_thread(view.judges, path):
            return  # a part is checked with the scene that includes it
        checked: worker.CheckAnswer = await self.checker.ask(worker.CheckRequest(view.open_scene(path)))
        found = await asyncio.to_thread(self.finding_filter, checked.diagnostics, str(path))
        read = {path, *checked.files.values()}
        if any(self.scenes.texts.get(each) is not view.texts.get(each) for each in read):
            # The text changed during the check, so findings may be outdated.
            if path in self.scenes.projects:
                self._due[path] = None
            return
        if path in self.scenes.projects:
            before = self.scenes.projects[path]
            self.scenes.projects[path] = before.after(checked, found)
            affected = {*read, *before.files.values()}
            self._publish(self.scenes.view(), [each for each in self.scenes.texts if each in affected])

    def _publish(self, view: WorkspaceView, paths: list[Path]) -> None:
        for path in paths:
            text = view.texts.get(path)
            if text is not None:
                found = [to_client(view, text, one, self.columns) for one in findings_in(view, path)]
                self._publish_one(self.uri(path), found)

    def _publish_one(self, uri: str, found: list[types.Diagnostic]) -> None:
        version = self.workspace.text_documents[uri].version if uri in self.workspace.text_documents else None
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, found, version))

    def tell(self, message: str) -> None:
        """Shows a message to the user."""
        self.window_show_message(types.ShowMessageParams(types.MessageType.Error, f"scenecc: {message}"))

    def link_pages(self) -> None:
        """Links to pages of `scenecc view`: sends them the cursor's place, and shows their selection."""
        loop, window = asyncio.get_running_loop(), self.client_capabilities.window
        can_show = window is not None and window.show_document is not None and window.show_document.support

        def heard(places: list[Place]) -> None:
            with suppress(RuntimeError):  # the loop has ended
                if can_show:
                    loop.call_soon_threadsafe(self._show, places)

        self._link = self._link or SelectionLink("editor", heard)

    def tell_pages(self, path: Path, keys: KeyPath) -> None:
        """Sends pages the entity at the cursor. `keys`: path of a node."""
        if self._link is not None and keys[:1] == ("entities",) and len(keys) > 1:
            self._link.send([Place(os.path.realpath(path), keys[:2])])

    def _show(self, places: list[Place]) -> None:
        """Shows the selection of a page. `places`: places of one object, of which one is shown.

        The first in an open file counts, else the last in a file of an open scene; otherwise nothing is shown.
        """
        view = self.scenes.view()
        parts = (each for project in view.projects.values() for each in project.files.values())
        files = {os.path.realpath(each): each for each in (*parts, *view.texts)}
        known = [(files[place.file], place.path) for place in places if place.file in files]
        opened = [one for one in known if one[0] in view.texts]
        if not known:
            return
        file, keys = (opened or known[::-1])[0]
        text = view.text(file)
        span = None if text is None else text.key_span(keys)
        if text is not None and span is not None:
            place = self.columns.range(text, *span)
            self.window_show_document(types.ShowDocumentParams(self.uri(file), take_focus=False, selection=place))

    async def entity_facts(self, view: WorkspaceView, path: Path, entity: str) -> worker.EntityFacts | None:
        """Returns the facts of an entity from `scenecc inspect`; None if they are not available in time."""
        known_by = (each for each in view.judges(path) if entity in view.projects[each].objects)
        top = next((each for each in known_by if view.projects[each].is_current), None)
        if top is None:
            return None
        key = top, entity
        known = self._described.get(key)
        if known is None or known[0].texts != view.texts:
            if any(asked.texts != view.texts for asked, _ in self._described.values()):
                self._described.clear()
                self.engine.stop_older(0)
            task = asyncio.create_task(self._describe(worker.Describe(view.open_scene(top), entity)))
            known = self._described[key] = view, task
        try:
            # Results that take longer are available the next time.
            return await asyncio.wait_for(asyncio.shield(known[1]), _ENGINE_SECONDS)
        except asyncio.TimeoutError:
            return None

    async def _describe(self, request: worker.Describe) -> worker.EntityFacts | None:
        try:
            return await self.engine.ask(request)
        except WorkerStopped:
            return None
        except FaultError as fault:
            _LOG.error("%s", fault)
            return None

    def stop(self) -> None:
        """Stops the compile processes and the link to pages."""
        if self._link is not None:
            self._link.close()
        self.checker.stop()
        self.engine.stop()
