"""The requests of editors. A function on a view of the workspace answers each."""

from __future__ import annotations

import asyncio
import logging
import os
import sys
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams

from scenecc.diagnostics.fixing import is_better, is_mended
from scenecc.lsp import edits, worker
from scenecc.lsp.completion import SUFFIXES, Offer, completions
from scenecc.lsp.findings import findings_in, to_client
from scenecc.lsp.hover import MOST_TOLD, hover_at, with_facts
from scenecc.lsp.language import load_language
from scenecc.lsp.names import Definition, Use, definition_of, mention_at, mention_span, uses_in, uses_of
from scenecc.lsp.process import FaultError, WorkerStopped
from scenecc.lsp.server import FindingFilter, SceneServer
from scenecc.lsp.symbols import Symbol, symbols_of
from scenecc.lsp.workspace import WorkspaceView

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.lsp.analysis import SceneText
    from scenecc.options import Options
    from scenecc.source.entry_edits import Splice

T = TypeVar("T")

At = Callable[[WorkspaceView, Path, int, int], T]
"""Answers a request about a 0-based position [characters]."""


def make_server(options: Options, finding_filter: FindingFilter) -> SceneServer:
    """Returns a server that answers all requests. Arguments as for `serve`."""
    server = SceneServer(options, finding_filter)
    server.feature(types.INITIALIZED)(_initialized)
    server.feature(types.SHUTDOWN)(_shutdown)
    server.feature(types.EXIT)(_exit)
    server.feature(types.TEXT_DOCUMENT_DID_OPEN)(_changed)
    server.feature(types.TEXT_DOCUMENT_DID_CHANGE)(_changed)
    server.feature(types.TEXT_DOCUMENT_DID_SAVE)(_saved)
    server.feature(types.TEXT_DOCUMENT_DID_CLOSE)(_closed)
    server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)(_files_changed)
    server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions([":", " ", "/", "{", "$", "-"]))(_completion)
    server.feature(types.TEXT_DOCUMENT_HOVER)(_hover)
    server.feature(types.TEXT_DOCUMENT_DEFINITION)(_definition)
    server.feature(types.TEXT_DOCUMENT_REFERENCES)(_references)
    server.feature(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)(_document_highlight)
    server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)(_prepare_rename)
    server.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))(_rename)
    quick_fixes = types.CodeActionOptions([types.CodeActionKind.QuickFix])
    server.feature(types.TEXT_DOCUMENT_CODE_ACTION, quick_fixes)(_code_action)
    server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)(_document_symbol)
    return server


def serve(options: Options, finding_filter: FindingFilter) -> None:
    """Serves an editor on standard input and output until it ends.

    Args:
        options: what scenes may use.
        finding_filter: selects findings by the scene's path, and sets their severity.
    """
    # Output of a library must not get into the messages.
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    log = logging.StreamHandler()
    log.addFilter(_is_fault)
    logging.basicConfig(handlers=[log], level=logging.WARNING)
    server = make_server(options, finding_filter)
    server.start_io(sys.stdin.buffer, output)
    server.stop()


def _is_fault(record: logging.LogRecord) -> bool:
    """Returns whether a log record reports an error, not a refused request."""
    refused = edits.RefusedError | JsonRpcInvalidParams | asyncio.CancelledError
    return record.exc_info is None or not isinstance(record.exc_info[1], refused)


async def _initialized(ls: SceneServer, params: types.InitializedParams) -> None:
    del params
    ls.link_pages()
    workspace = ls.client_capabilities.workspace
    watching = None if workspace is None else workspace.did_change_watched_files
    if watching is not None and watching.dynamic_registration:
        watchers = [types.FileSystemWatcher(f"**/*{{{','.join(_WATCHED)}}}")]
        method = types.WORKSPACE_DID_CHANGE_WATCHED_FILES
        options = types.DidChangeWatchedFilesRegistrationOptions(watchers)
        await ls.client_register_capability_async(
            types.RegistrationParams([types.Registration("files", method, options)])
        )
    await asyncio.to_thread(load_language)


_WATCHED: Final = sorted({*chain(*SUFFIXES.values()), ".mtl", ".toml"})
"""Suffixes of files whose changes may change findings."""


def _exit(ls: SceneServer, *params: Any) -> None:
    """Ends the process. Needed because a thread still waits for the next message."""
    del params
    ls.stop()
    os._exit(0 if ls.is_ending else 1)


def _shutdown(ls: SceneServer, *params: Any) -> None:
    del params
    ls.is_ending = True


def _changed(ls: SceneServer, params: types.DidOpenTextDocumentParams | types.DidChangeTextDocumentParams) -> None:
    ls.changed(params.text_document.uri)


def _saved(ls: SceneServer, params: types.DidSaveTextDocumentParams) -> None:
    path = ls.path(params.text_document.uri)
    if path is not None:
        ls.schedule(path)


def _closed(ls: SceneServer, params: types.DidCloseTextDocumentParams) -> None:
    ls.closed(params.text_document.uri)


def _files_changed(ls: SceneServer, params: types.DidChangeWatchedFilesParams) -> None:
    del params  # a missing file is not among the files of a scene
    ls.schedule_all()


class _AtPosition(Protocol):
    """The parameters of a request about a position in a text."""

    @property
    def text_document(self) -> types.TextDocumentIdentifier: ...

    @property
    def position(self) -> types.Position: ...


def _open_text(server: SceneServer, document: types.TextDocumentIdentifier) -> tuple[WorkspaceView, SceneText | None]:
    """Returns the current view, and the text of a document in it; None if it is not open."""
    view, path = server.scenes.view(), server.path(document.uri)
    return view, None if path is None else view.texts.get(path)


async def _ask(
    server: SceneServer, params: _AtPosition, function: At[T]
) -> tuple[WorkspaceView, SceneText | None, T | None]:
    """Returns the result of a function at a position, with the view and text that it used."""
    view, text = _open_text(server, params.text_document)
    if text is None:
        return view, None, None
    place = server.columns.place(text, params.position)
    return view, text, await asyncio.to_thread(function, view, text.path, *place)


_KINDS: Final = {
    "key": types.CompletionItemKind.Property,
    "word": types.CompletionItemKind.EnumMember,
    "name": types.CompletionItemKind.Reference,
    "link": types.CompletionItemKind.Field,
    "file": types.CompletionItemKind.File,
    "folder": types.CompletionItemKind.Folder,
    "variable": types.CompletionItemKind.Variable,
    "function": types.CompletionItemKind.Function,
}


async def _completion(ls: SceneServer, params: types.CompletionParams) -> types.CompletionList:
    _, text, offers = await _ask(ls, params, completions)
    if text is None or not offers:
        return types.CompletionList(is_incomplete=False, items=[])
    line, column = ls.columns.place(text, params.position)
    items = [_item(ls, text, line, column, number, offer) for number, offer in enumerate(offers[:_MOST_OFFERED])]
    return types.CompletionList(is_incomplete=len(offers) > _MOST_OFFERED, items=items)


_MOST_OFFERED: Final = 1000
"""Maximum number of completions. Beyond it, those that begin with the typed text are shown."""


def _item(
    server: SceneServer, text: SceneText, line: int, column: int, number: int, offer: Offer
) -> types.CompletionItem:
    return types.CompletionItem(
        label=offer.label or offer.text,
        kind=_KINDS[offer.kind],
        documentation=offer.description or None,
        sort_text=f"{number:05}",
        filter_text=offer.text,
        text_edit=types.TextEdit(server.columns.range(text, line, min(offer.start, column), column), offer.text),
    )


async def _hover(ls: SceneServer, params: types.HoverParams) -> types.Hover | None:
    view, text, told = await _ask(ls, params, hover_at)
    if told is None or text is None:
        return None
    asked = (ls.entity_facts(view, text.path, name) for name in told.entities[:MOST_TOLD])
    shown = with_facts(told, await asyncio.gather(*asked)) if told.entities else told.text
    place = ls.columns.range(text, told.line, told.start, told.end)
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, shown), place)


def _find_definition(view: WorkspaceView, path: Path, line: int, column: int) -> Definition | None:
    found = mention_at(view, path, line, column)
    return None if found is None else definition_of(view, *found)


def _find_uses(view: WorkspaceView, path: Path, line: int, column: int) -> list[Use]:
    wanted = _find_definition(view, path, line, column)
    return [] if wanted is None else list(uses_of(view, wanted))


async def _definition(ls: SceneServer, params: types.DefinitionParams) -> types.Location | None:
    view, _, found = await _ask(ls, params, _find_definition)
    if found is None:
        return None
    text = await asyncio.to_thread(view.text, found.file) if found.span[2] != 0 else None
    start = types.Position(found.span[0], found.span[1])
    place = types.Range(start, start) if text is None else ls.columns.range(text, *found.span)
    return types.Location(ls.uri(found.file), place)


async def _references(ls: SceneServer, params: types.ReferenceParams) -> list[types.Location]:
    _, _, uses = await _ask(ls, params, _find_uses)
    return [
        types.Location(ls.uri(use.text.path), _place_of_use(ls, use))
        for use in uses or ()
        if params.context.include_declaration or not use.is_definition
    ]


async def _document_highlight(ls: SceneServer, params: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
    """Editors send this request whenever the cursor moves, so it also informs pages."""

    def uses(view: WorkspaceView, path: Path, line: int, column: int) -> list[Use]:
        text = view.texts[path]
        ls.tell_pages(path, text.path_at(line, column))
        wanted = _find_definition(view, path, line, column)
        return [] if wanted is None else list(uses_in(view, text, wanted))

    _, _, found = await _ask(ls, params, uses)
    kinds = types.DocumentHighlightKind
    return [
        types.DocumentHighlight(_place_of_use(ls, use), kinds.Write if use.is_definition else kinds.Read)
        for use in found or ()
    ]


def _place_of_use(server: SceneServer, use: Use) -> types.Range:
    span = mention_span(use.text, use.leaf, use.definition.start, use.definition.end)
    return server.columns.range(use.text, *span)


async def _prepare_rename(ls: SceneServer, params: types.PrepareRenameParams) -> types.PrepareRenamePlaceholder:
    _, text, edit = await _ask(ls, params, edits.renamed_part)
    if text is None or edit is None:
        raise edits.RefusedError("this file is not open")
    place = ls.columns.range(text, edit.line, edit.start, edit.end)
    return types.PrepareRenamePlaceholder(place, edit.text)


async def _rename(ls: SceneServer, params: types.RenameParams) -> types.WorkspaceEdit:
    def changes(view: WorkspaceView, path: Path, line: int, column: int) -> list[edits.Edit]:
        return edits.rename(view, path, line, column, params.new_name)

    view, _, made = await _ask(ls, params, changes)
    await _prove(ls, view, made or [])
    return _workspace_edit(ls, view, made or [])


async def _prove(server: SceneServer, view: WorkspaceView, made: list[edits.Edit]) -> None:
    """Checks the result of edits. Raises RefusedError if it has an error."""
    changed = edits.applied(view, made)
    for user in dict.fromkeys(user for file in changed for user in view.judges(file)):
        try:
            checked: worker.CheckAnswer = await server.checker.ask(worker.CheckRequest(view.open_scene(user, changed)))
        except (WorkerStopped, FaultError):
            raise edits.RefusedError("the result could not be checked; try again") from None
        wrong = next((one for one in checked.diagnostics if one.severity == "error"), None)
        if wrong is not None:
            raise edits.RefusedError(f"it would cause an error in line {wrong.line} of {user.name}: {wrong.message}")


def _workspace_edit(server: SceneServer, view: WorkspaceView, made: list[edits.Edit]) -> types.WorkspaceEdit:
    changes: dict[str, list[types.TextEdit]] = {}
    for edit in made:
        text = view.text(edit.file)
        if text is not None:
            place = server.columns.range(text, edit.line, edit.start, edit.end)
            changes.setdefault(server.uri(edit.file), []).append(types.TextEdit(place, edit.text))
    return types.WorkspaceEdit(changes)


async def _code_action(ls: SceneServer, params: types.CodeActionParams) -> list[types.CodeAction]:
    view, text = _open_text(ls, params.text_document)
    only = params.context.only
    if text is None or (only is not None and types.CodeActionKind.QuickFix not in only):
        return []
    lines = range(params.range.start.line, params.range.end.line + 1)
    found = [one for one in findings_in(view, text.path) if (one.line or 1) - 1 in lines]
    actions: dict[tuple[Splice, ...], types.CodeAction] = {}
    tries, end = _MOST_TRIED, asyncio.get_running_loop().time() + _MOST_SECONDS
    for one in found:
        titles: set[str] = set()
        for edit in await asyncio.to_thread(edits.corrections, text, one):
            if edit.title in titles or edit.splices in actions:
                continue
            if not edit.is_guess:
                tries = 0 if asyncio.get_running_loop().time() > end else tries - 1
                if tries <= 0 or not await _mends(ls, view, text.path, one, edit.applied(text.text)):
                    continue
            titles.add(edit.title)
            actions[edit.splices] = types.CodeAction(
                edit.title,
                types.CodeActionKind.QuickFix,
                diagnostics=[to_client(view, text, one, ls.columns)],
                edit=types.WorkspaceEdit({ls.uri(text.path): [_splice_edit(ls, text, each) for each in edit.splices]}),
            )
    return list(actions.values())


_MOST_TRIED: Final = 12
"""Maximum number of edits that are checked for one line."""

_MOST_SECONDS: Final = 2.0
"""Time after which no further edit is checked [s]."""


def _splice_edit(server: SceneServer, text: SceneText, splice: Splice) -> types.TextEdit:
    ends = (text.place_of(at) for at in (splice.start, splice.end))
    start, end = (server.columns.range(text, line, column, column).start for line, column in ends)
    return types.TextEdit(types.Range(start, end), splice.text)


async def _mends(server: SceneServer, view: WorkspaceView, path: Path, found: Diagnostic, changed: str) -> bool:
    """Returns whether a text lacks a finding, and has no new one of the same stage.

    A part is checked with an open scene that uses it.
    """
    user = next(iter(view.judges(path)), path)
    project = view.projects.get(user)
    try:
        checked: worker.CheckAnswer = await server.checker.ask(
            worker.CheckRequest(view.open_scene(user, {path: changed}))
        )
    except (WorkerStopped, FaultError):
        return False
    now = await asyncio.to_thread(server.finding_filter, checked.diagnostics, str(user))
    then = [] if project is None else list(project.diagnostics)
    return found in then and (is_better if found.fix else is_mended)(now, then, found)


async def _document_symbol(ls: SceneServer, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    _, text = _open_text(ls, params.text_document)
    if text is None:
        return []
    return [_symbol(ls, text, one) for one in await asyncio.to_thread(symbols_of, text)]


_SYMBOL_KINDS: Final = {
    "params": types.SymbolKind.Variable,
    "draws": types.SymbolKind.Variable,
    "materials": types.SymbolKind.Constant,
    "collision_groups": types.SymbolKind.Constant,
}


def _symbol(server: SceneServer, text: SceneText, one: Symbol) -> types.DocumentSymbol:
    key = server.columns.range(text, *one.span)
    end = server.columns.range(text, one.last, 0, None).end
    kind = types.SymbolKind.Namespace if one.below else _SYMBOL_KINDS.get(one.section, types.SymbolKind.Object)
    whole = types.Range(types.Position(key.start.line, key.start.character), max(end, key.end))
    below = [_symbol(server, text, each) for each in one.below]
    return types.DocumentSymbol(one.name or '""', kind, whole, key, detail=one.detail or None, children=below)
