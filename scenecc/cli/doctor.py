"""`scenecc doctor`."""

from __future__ import annotations

import json
import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Final, Literal

from scenecc.cli.options import TableFormatOption
from scenecc.cli.output import Status, end
from scenecc.extras import DRIVER_HINT, EXTRAS, install_hint
from scenecc.files import cache_folder
from scenecc.interrupt import child
from scenecc.version import VERSION

_PACKAGES: Final = ("sapien", "pydantic", "numpy", "trimesh", "pycollada", "pillow")

_ASK_ENGINE: Final = """
import json, warnings
warnings.simplefilter("ignore")
import sapien
print("{}")
found = {}
for name, ask in (("render", lambda: sapien.render.RenderSystem().device), ("cuda", lambda: sapien.Device("cuda"))):
    try:
        found[name] = ask().name
    except RuntimeError:
        found[name] = None
print(json.dumps(found))
"""
"""Runs in a separate process, which a faulty driver may crash. It prints a line once SAPIEN is loaded."""

_CUDA_HINT: Final = "needed only for simulation on a GPU: an NVIDIA driver, and PhysX's GPU library, which SAPIEN loads"
_ENGINE: Final = "SAPIEN"
_ENGINE_SECONDS: Final = 60
_ENGINE_HINT: Final = "without it, scenes can only be validated: install the library that the error names"

_NEXT: Final = "\nScenes can be checked and built without the missing items. To start: `scenecc init demo`\n"


@dataclass(frozen=True)
class DoctorCheck:
    """One line: what was checked, whether it exists, its name, and how to install or clear it."""

    name: str
    state: Literal["ok", "missing"]
    found: str
    hint: str | None = None


def doctor(*, form: TableFormatOption = "text") -> None:
    """Report what this machine supports and what is missing.

    It looks for SAPIEN, a render device, a GPU for simulation, the extras, ManiSkill's assets and scenecc's cache. A
    missing item is not an error, because scenes can be checked and built without it. Only if SAPIEN cannot be loaded,
    the exit status is 3.

    \b
    Examples:
      scenecc doctor
      scenecc doctor --format json
    """
    engine, *devices = _engine()
    checks = [*_versions(), engine, *devices, *_extras(), *_assets(), _cache()]
    end(
        [],
        form,
        data=lambda: {"checks": [asdict(check) for check in checks]},
        text=lambda: _text(checks),
        least=Status.machine if engine.state == "missing" else Status.fine,
    )


def _text(checks: Sequence[DoctorCheck]) -> str:
    width = max(len(check.name) for check in checks)
    lines: list[str] = []
    for check in checks:
        lines.append(f"{check.state:7}  {check.name:{width}}  {check.found}\n")
        lines += [f"{'':9}{'':{width}}  {line}\n" for line in (check.hint or "").splitlines()]
    if all(check.state == "ok" for check in checks if check.name == _ENGINE):
        lines.append(_NEXT)
    return "".join(lines)


def _versions() -> list[DoctorCheck]:
    packages = [f"{name} {_version(name)}" for name in _PACKAGES]
    return [
        DoctorCheck(
            "scenecc", "ok", f"{VERSION}, Python {platform.python_version()}, {platform.system()} {platform.machine()}"
        ),
        DoctorCheck("packages", "ok", ", ".join(packages)),
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "?"


def _engine() -> list[DoctorCheck]:
    """Returns whether SAPIEN can be loaded, and the devices that it finds."""
    lines: list[str] = []
    error = f"no answer in {_ENGINE_SECONDS} s"
    with suppress(subprocess.TimeoutExpired):
        with child([sys.executable, "-c", _ASK_ENGINE], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            output, errors = process.communicate(timeout=_ENGINE_SECONDS)
        lines = [line for line in output.decode(errors="replace").splitlines() if line.startswith("{")]
        error = (errors.decode(errors="replace").splitlines() or [f"exit status {process.returncode}"])[-1]
    found: dict[str, str | None] = json.loads(lines[-1]) if lines else {}
    loaded = DoctorCheck(_ENGINE, "ok", "loads") if lines else DoctorCheck(_ENGINE, "missing", error, _ENGINE_HINT)
    return [
        loaded,
        _device("pictures", found.get("render"), "no render device", DRIVER_HINT),
        _device("GPU", found.get("cuda"), "no CUDA device", _CUDA_HINT),
    ]


def _device(name: str, device: str | None, lacking: str, hint: str) -> DoctorCheck:
    return DoctorCheck(name, "missing", lacking, hint) if device is None else DoctorCheck(name, "ok", device)


def _extras() -> list[DoctorCheck]:
    checks: list[DoctorCheck] = []
    for name, extra in EXTRAS.items():
        lacking = extra.missing
        if lacking:
            found = f"{extra.purpose}: needs {', '.join(lacking)}"
            checks.append(DoctorCheck(f"[{name}]", "missing", found, install_hint(name)))
        else:
            checks.append(DoctorCheck(f"[{name}]", "ok", extra.purpose))
    return checks


def _assets() -> list[DoctorCheck]:
    """Returns what ManiSkill has downloaded to its assets folder."""
    if find_spec("mani_skill") is None:
        return []
    base = os.environ.get("MS_ASSET_DIR") or os.path.expanduser("~/.maniskill")  # noqa: PTH111 - fails without a home
    folder = Path(base) / "data"
    hint = "`python -m mani_skill.utils.download_asset NAME` downloads what a task or robot needs"
    try:
        names = sorted(f"{one.parent.name}/{one.name}" for one in folder.glob("*/*") if one.is_dir())
    except OSError:
        names = []
    if not names:
        return [DoctorCheck("ManiSkill's assets", "missing", f"nothing in {folder}", hint)]
    return [DoctorCheck("ManiSkill's assets", "ok", f"{folder}: {', '.join(names)}")]


def _cache() -> DoctorCheck:
    folder = cache_folder("")
    files: list[int] = []
    for file in folder.rglob("*"):
        with suppress(OSError):  # another process has removed it
            files += [file.stat().st_size] if file.is_file() else []
    found = f"{folder}: {len(files)} files, {sum(files) / 1e6:.1f} MB" if files else f"{folder}: empty"
    exists = next(one for one in (folder, *folder.parents) if one.exists())
    if not (exists.is_dir() and os.access(exists, os.W_OK)):
        hint = "set XDG_CACHE_HOME to a folder that can be written; without it, every command computes again"
        return DoctorCheck("cache", "missing", f"{folder} cannot be written", hint)
    hint = f"`rm -r {shlex.quote(str(folder))}` clears it; scenecc computes again what it needs" if files else None
    return DoctorCheck("cache", "ok", found, hint)
