"""CoACD in a process of its own, its results in the user's cache folder and never beside the asset."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import json
import os
import sys
import tempfile
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from subprocess import DEVNULL, PIPE
from typing import TYPE_CHECKING, Any, NamedTuple

from scenecc.backends.sapien.failure import EngineFailure
from scenecc.files import open_regular, replace_all
from scenecc.interrupt import child

if TYPE_CHECKING:
    from scenecc.plan import AssetFile, CoacdParams

CODE = "SC806"


class _Content(NamedTuple):
    """What is cut.

    Attributes:
        mesh: path and hash of the mesh.
        buffers: path and hash of what a glTF names, by the names that it has for them.
    """

    mesh: tuple[str, str]
    buffers: dict[str, tuple[str, str]]

    @classmethod
    def of(cls, file: AssetFile) -> _Content:
        """That of a file. Raises OSError."""
        named = file.names if file.path.suffix.lower() in {".gltf", ".glb"} else ()
        with open_regular(file.path) as stream:
            digest = file.sha256 or hashlib.sha256(stream.read()).hexdigest()
        return cls((str(file.path.absolute()), digest), {one.uri: (str(one.path), one.sha256) for one in named})

    def key(self, arguments: dict[str, Any]) -> str:
        """The content, and what is done with it, without where it lies."""
        path, digest = self.mesh
        hashes = [digest, *sorted((uri, named) for uri, (_, named) in self.buffers.items())]
        how = [Path(path).suffix.lower(), version("coacd"), arguments]
        return hashlib.sha256(json.dumps([hashes, how], sort_keys=True).encode()).hexdigest()


def decompose(file: AssetFile, params: CoacdParams) -> Path:
    """A PLY file whose connected parts are the convex parts that CoACD finds in a mesh.

    The result is what `sapien.wrapper.coacd.do_coacd` gives for the same parameters. It is kept under
    `$XDG_CACHE_HOME/scenecc/coacd` (`~/.cache` without that variable) by the mesh's content, that of its buffers, the
    parameters and CoACD's version. Materials and images are not read.

    Raises:
        EngineFailure: CoACD is not installed or fails, or the cache folder cannot be written.
    """
    for module in ("coacd", "trimesh"):
        if importlib.util.find_spec(module) is None:
            raise EngineFailure(
                CODE,
                f"convex decomposition needs the package '{module}', which is not installed",
                hint="pip install 'scenecc[convex]'",
            )
    arguments = coacd_arguments(params)
    folder = cache_folder("coacd")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        content = _Content.of(file)
        result = folder / f"{content.key(arguments)}.ply"
        if not result.exists():
            _run(content, arguments, result)
    except OSError as error:
        raise EngineFailure(
            CODE,
            f"convex decomposition of '{file.path}': {error}",
            hint=f"results are kept in '{folder}'; XDG_CACHE_HOME names another place",
        ) from error
    return result


def cache_folder(kind: str) -> Path:
    """Where files of a kind are kept that are made of others."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "scenecc" / kind


def coacd_arguments(params: CoacdParams) -> dict[str, Any]:
    """Arguments of `coacd.run_coacd`: the plan's, and SAPIEN's own defaults for those left out."""
    do_coacd: Any = importlib.import_module("sapien.wrapper.coacd").do_coacd
    parameters = inspect.signature(do_coacd).parameters
    given = asdict(params)
    return {name: parameters[name].default if value is None else value for name, value in given.items()}


def _run(content: _Content, arguments: dict[str, Any], result: Path) -> None:
    """Writes `result` whole or not at all. CoACD's automatic preprocessing may fail where a forced one does not."""
    modes = [arguments["preprocess_mode"]]
    if modes[0] != "on":
        modes.append("on")
    complaint = ""
    for mode in modes:
        parts, complaint = _attempt(content, arguments | {"preprocess_mode": mode})
        if parts:
            replace_all({result: parts})
            return
    raise EngineFailure(CODE, f"CoACD failed on '{content.mesh[0]}': {complaint}")


def _attempt(content: _Content, arguments: dict[str, Any]) -> tuple[bytes, str]:
    """What CoACD makes of a mesh, and its last words. It runs beside this process: a crash of it ends only itself."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-m", "scenecc.backends.sapien.coacd_worker"]
    with tempfile.TemporaryFile() as file:
        output = file.fileno()
        request = {**content._asdict(), "arguments": arguments, "output": output, "parent": os.getpid()}
        # Our own module in this interpreter; the request goes in as data.
        with child(command, stdin=PIPE, stdout=DEVNULL, stderr=PIPE, env=environment, pass_fds=[output]) as process:
            _, errors = process.communicate(json.dumps(request).encode())
        file.seek(0)
        parts = file.read() if process.returncode == 0 else b""
    words = errors.decode(errors="replace").strip().splitlines()
    return parts, words[-1] if words else f"it ended with status {process.returncode}"
