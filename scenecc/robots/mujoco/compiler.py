"""Compiles models with MuJoCo in a separate process."""

from __future__ import annotations

import importlib.metadata
import re
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.extras import install_hint
from scenecc.robots.mujoco import worker
from scenecc.robots.mujoco.model import CompiledModel
from scenecc.worker import Worker, WorkerError

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.mjcf_files import MjcfReport
    from scenecc.robots.mujoco.source import MujocoSource
    from scenecc.worker_process import Message

OLDEST, BEYOND = (3, 5), (5, 0)
"""Supported MuJoCo versions: from OLDEST, below BEYOND."""

INSTALL_HINT = install_hint("mjcf")

_MEMORY = 4 * 2**30
"""Address space of the process [bytes]."""

_SECONDS = 60.0
"""Time limit for one model [s]."""

MAX_NUMBER = 1e12
"""Largest number in a model: a product of three still fits in single precision."""

_MOST_KEPT = 8
"""Maximum number of cached models: a scene is often validated and then built."""

_MOST_KEPT_BYTES = 2**28
"""Maximum total size of the cached models, not counting the last [bytes]."""

_LINE = re.compile(r"line (\d+)")


class _CompilerProcess:
    """MuJoCo in a separate process, with a cache of the last compiled models."""

    def __init__(self) -> None:
        self._worker = Worker(worker.__name__, memory=_MEMORY, seconds=_SECONDS, name="MuJoCo's compiler")
        self._kept: dict[bytes, Message] = {}

    def compile(self, xml: bytes, assets: dict[str, bytes]) -> Message:
        """Returns the answer of `worker.compile_model`. Raises WorkerError."""
        key = _digest(xml, assets)
        if key not in self._kept:
            answer = self._worker.ask({"names": list(assets)}, [xml, *assets.values()])
            while self._kept and (len(self._kept) >= _MOST_KEPT or self._cached_bytes() > _MOST_KEPT_BYTES):
                del self._kept[next(iter(self._kept))]
            self._kept[key] = answer
        return self._kept[key]

    def _cached_bytes(self) -> int:
        return sum(len(part) for _, parts in self._kept.values() for part in parts)


_COMPILER = _CompilerProcess()


def _digest(xml: bytes, assets: dict[str, bytes]) -> bytes:
    import hashlib  # noqa: PLC0415 - loaded only for a model

    state = hashlib.sha256(f"{mujoco_version()} {len(xml)} ".encode() + xml)
    for name, data in assets.items():
        state.update(f" {name} {len(data)} ".encode() + data)
    return state.digest()


@lru_cache
def mujoco_version() -> str | None:
    """Returns the installed MuJoCo version; None if it is not installed."""
    # A folder `mujoco` beside a script can be imported too, but has no version.
    try:
        return importlib.metadata.version("mujoco")
    except importlib.metadata.PackageNotFoundError:
        return None


def check_mujoco(report: MjcfReport, location: Location) -> bool:
    """Returns whether MuJoCo can be used; reports SC457 if not."""
    version = mujoco_version()
    if version is None:
        report.error("SC457", "MJCF files need MuJoCo, which is not installed", location, INSTALL_HINT)
        return False
    numbers = tuple(int(part) for part in re.findall(r"\d+", version)[:2])
    if not OLDEST <= numbers < BEYOND:
        wanted = f"from {'.'.join(map(str, OLDEST))} and below {'.'.join(map(str, BEYOND))}"
        report.error("SC457", f"MuJoCo {version} is installed, but version {wanted} is needed", location, INSTALL_HINT)
        return False
    return True


def compile_mjcf(source: MujocoSource, report: MjcfReport) -> CompiledModel | None:
    """Returns the compiled model; None after an error: SC458 (too much time or memory), SC481 (refused by MuJoCo)."""
    root = source.elements[0].location
    try:
        header, parts = _COMPILER.compile(source.text.encode(), source.assets)
    except WorkerError as died:
        report.error("SC458", str(died), root)
        return None
    if "error" in header:
        message = str(header["error"])
        found = _LINE.search(message)
        element = source.element(int(found[1])) if found else None
        report.error("SC481", _clean_message(message, source), element.location if element else root)
        return None
    model = CompiledModel.of(header, parts, source)
    return model if _is_bounded(model, report) else None


def _is_bounded(model: CompiledModel, report: MjcfReport) -> bool:
    """Returns whether all numbers, and products of three, fit in single precision; reports SC481 if not."""
    import numpy as np  # noqa: PLC0415 - loaded only for a model

    for name, array in model.arrays.items():
        kind, _, rest = name.partition("_")
        if array.dtype.kind != "f" or not array.size:
            continue
        # A range may be infinite.
        wrong = np.isnan(array) if rest.endswith("range") else ~(np.abs(array) <= MAX_NUMBER)
        if wrong.any():
            row = int(np.argwhere(wrong)[0][0])
            kind = {"cam": "camera"}.get(kind, kind)
            place = model.location(kind, row) if kind in worker.NAMED else model.source.elements[0].location
            number = float(array[wrong][0])
            report.error("SC481", f"`{name}` becomes {number:g}, and the limit is {MAX_NUMBER:g}", place)
            return False
    return True


def _clean_message(message: str, source: MujocoSource) -> str:
    """Returns MuJoCo's message in one line, with the original file names and without line numbers."""
    for name, file in source.files.items():
        message = message.replace(name, Path(file.uri).name)
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    words = _LINE.sub("", " ".join(line for line in lines if not line.startswith("Element name"))).strip(" ,'")
    return f"MuJoCo refuses the file: {words.removeprefix('XML Error:').removeprefix('Error:').strip()}"
