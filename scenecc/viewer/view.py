"""Serves a scene on a live page, or exports it as a page."""

from __future__ import annotations

import os
import socket
from contextlib import closing, contextmanager, suppress
from io import BytesIO, StringIO
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from typing_extensions import Unpack

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.errors import SceneError
from scenecc.extras import EXTRAS, install_hint
from scenecc.options import CompileOptions, Options, check_types, integer
from scenecc.viewer.options import ARGUMENT_TYPES, PageAddress, ViewOptions

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from scenecc.diagnostics import Diagnostic
    from scenecc.pipeline import Source
    from scenecc.viewer.server import PageServer


def view_scene(
    source: Source,
    *,
    options: ViewOptions | None = None,
    address: PageAddress | None = None,
    on_ready: Callable[[str], None] | None = None,
    on_diagnostics: Callable[[Sequence[Diagnostic]], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
    **given: Unpack[CompileOptions],
) -> None:
    """Shows a scene on a page in the browser until interrupted, and reloads it whenever its file changes.

    A scene with errors is shown as error messages until they are fixed. Other arguments are those of `validate`.

    Args:
        source: as for `validate`; a path and all files that it uses are watched.
        options: what is shown initially.
        address: where the page is served.
        on_ready: called with the page's URL once it can be opened, before the engine builds.
        on_diagnostics: called with the diagnostics after each compilation or build.
        on_progress: called with (scenes done, total scenes) while the engine builds.
        given: fields of `CompileOptions`.

    Raises:
        SceneError: the page cannot be served: a package is missing, or the address is not available.
        ValueError: an argument is out of range.
    """
    _need_packages()
    from scenecc.viewer.session import Session

    options, address = options or ViewOptions(), address or PageAddress()
    compile_options = Options.of_call(view_scene, given)
    called = {"on_ready": on_ready, "on_diagnostics": on_diagnostics, "on_progress": on_progress}
    check_types(view_scene, {"options": options, "address": address, **called}, ARGUMENT_TYPES)
    path = Path(fspath(source)).absolute() if isinstance(source, str | PathLike) else None
    label = "scenecc" if path is None else f"scenecc: {path.stem}"
    writes = address.is_local or address.token is not None
    around: Any = {"path": path, "progress": on_progress, "links": address.is_local, "writes": writes}
    around["report"] = on_diagnostics or _ignore
    with (
        _serve(address, label) as server,
        closing(Session(server.viser, _again(source), compile_options, options, **around)) as session,
    ):
        session.serve(lambda: (on_ready or _ignore)(page_url(address, server.port)))


@frozen
class ScenePage:
    """A scene as one self-contained HTML page, which needs no network and no server.

    Attributes:
        html: the page.
        diagnostics: warnings and notes.
    """

    html: str
    diagnostics: list[Diagnostic]


def page_of_source(
    source: Source,
    *,
    options: ViewOptions | None = None,
    steps: int = 0,
    progress: Callable[[int, int], None] | None = None,
    **given: Unpack[CompileOptions],
) -> ScenePage:
    """Returns the page of `export_page` with its diagnostics.

    Args:
        source: as for `validate`.
        options: what is shown.
        steps: number of simulation steps that the page plays; 0: a still scene.
        progress: called with (scenes done, total scenes) while the engine builds, and with steps after that.
        given: fields of `CompileOptions`.

    Raises:
        SceneError: the scene has errors, the scene index does not exist, or the engine or machine failed.
        ValueError: an argument is out of range.
    """
    _need_packages()
    from scenecc.viewer.world import World, check_selected_scene, load, record_page

    shown = options or ViewOptions()
    steps = integer(steps, "steps", 0)
    compile_options = Options.of_call(page_of_source, given)
    loading = load(source, compile_options, {})
    if loading.loaded is None:
        raise SceneError(loading.diagnostics)
    check_selected_scene(shown, loading.loaded.plan)
    world = World(loading.loaded, shown, progress)
    try:
        # viser exports a page from a running server; this one is never announced.
        with _serve(PageAddress(port=0), loading.loaded.plan.name) as server:
            page = record_page(server.viser, world, shown, steps, progress)
    finally:
        world.close()
    return ScenePage(page, loading.loaded.sink.diagnostics())


@contextmanager
def _serve(place: PageAddress, label: str) -> Generator[PageServer]:
    from scenecc.interrupt import interrupts_wait

    server: PageServer | None = None
    try:
        # A half-started server cannot be stopped.
        with interrupts_wait():
            server = _open_server(place, label)
        yield server
    finally:
        if server is not None:
            server.close()


def _open_server(place: PageAddress, label: str) -> PageServer:
    """Opens a server. Raises SceneError if the address or port is not available."""
    from scenecc.viewer.server import PageServer

    try:
        return PageServer(place, label)
    except OSError as error:
        where = place.host if place.port is None else f"{place.host}, port {place.port}"
        # For an unknown host name, the error number is not a system error.
        known = error.errno is not None and error.errno > 0
        reason = os.strerror(error.errno) if known and error.errno else error.strerror or str(error)
        sink = Sink()
        hint = "choose another port, or omit it to use a free one"
        sink.report("SC815", f"no page can be served at {where}: {reason}", Location(None), hint=hint)
        raise SceneError(sink.diagnostics()) from error


def page_url(place: PageAddress, port: int) -> str:
    """Returns the address for a browser on this machine, or on others if they can reach it."""
    host = _own_address(place.host) if place.host in {"0.0.0.0", "::"} else place.host  # noqa: S104 - only compared
    token = "" if place.token is None else f"/?token={quote(place.token, safe='')}"
    return f"http://{f'[{host}]' if ':' in host else host}:{port}{token}"


def _own_address(anywhere: str) -> str:
    """Returns the network address of this machine."""
    family, far = (socket.AF_INET6, "2001:db8::1") if ":" in anywhere else (socket.AF_INET, "192.0.2.1")
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.connect((far, 9))  # sends nothing
        return str(probe.getsockname()[0])
    return "localhost"


def _again(source: Source) -> Callable[[], Source]:
    """Returns a function that returns the source repeatedly: a stream is read once."""
    if not hasattr(source, "read"):
        return lambda: source
    stream: Any = source
    content = stream.read()
    return lambda: BytesIO(content) if isinstance(content, bytes) else StringIO(content)


def _need_packages() -> None:
    if lacking := EXTRAS["view"].missing:
        sink = Sink()
        message = f"a page needs {' and '.join(lacking)}, not installed here"
        sink.report("SC816", message, Location(None), hint=install_hint("view"))
        raise SceneError(sink.diagnostics())


def _ignore(what: object) -> None:
    """Does nothing with its argument."""
    del what
