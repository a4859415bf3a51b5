"""`scenecc doctor`."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Final, Literal

from scenecc.cli.options import TableFormat, TableFormatOption
from scenecc.cli.output import end
from scenecc.extras import DRIVER_HINT, EXTRAS, install_hint
from scenecc.interrupt import child
from scenecc.version import VERSION

_PACKAGES: Final = ("sapien", "pydantic", "numpy", "trimesh", "pycollada", "pillow")

_ASK_ENGINE: Final = """
import json, warnings
warnings.simplefilter("ignore")
import sapien
found = {}
for name, ask in (("render", lambda: sapien.render.RenderSystem().device), ("cuda", lambda: sapien.Device("cuda"))):
    try:
        found[name] = ask().name
    except RuntimeError:
        found[name] = None
print(json.dumps(found))
"""
"""Runs in a separate process, which a faulty driver may crash."""

_CUDA_HINT: Final = "needed only for simulation on a GPU: an NVIDIA driver, and PhysX's GPU library, which SAPIEN loads"
_ENGINE_SECONDS: Final = 60

_NEXT: Final = "\nScenes can be checked and built without the missing items. To start: `scenecc init demo`\n"


@dataclass(frozen=True)
class DoctorCheck:
    """One line: what was checked, whether it exists, its name, and how to install it."""

    name: str
    state: Literal["ok", "missing"]
    found: str
    hint: str | None = None


def doctor(*, form: TableFormatOption = TableFormat.text) -> None:
    """Report what this machine supports and what is missing.

    It looks for a render device, a GPU for simulation, the extras, and ManiSkill's assets. A missing item is not an
    error: scenes can be checked and built without any of them.

    \b
    Examples:
      scenecc doctor
      scenecc doctor --format json
    """
    checks = [*_versions(), *_devices(), *_extras(), *_assets()]
    end([], form, data=lambda: {"checks": [asdict(check) for check in checks]}, text=lambda: _text(checks))


def _text(checks: list[DoctorCheck]) -> str:
    width = max(len(check.name) for check in checks)
    lines: list[str] = []
    for check in checks:
        lines.append(f"{check.state:7}  {check.name:{width}}  {check.found}\n")
        lines += [f"{'':9}{'':{width}}  {line}\n" for line in (check.hint or "").splitlines()]
    return "".join([*lines, _NEXT])


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


def _devices() -> list[DoctorCheck]:
    try:
        command = [sys.executable, "-c", _ASK_ENGINE]
        with child(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
            output, _ = process.communicate(timeout=_ENGINE_SECONDS)
        found = json.loads(output.splitlines()[-1])
    except (subprocess.SubprocessError, ValueError, IndexError):
        found = {"render": None, "cuda": None}
    return [
        _device("pictures", found["render"], "no render device", DRIVER_HINT),
        _device("GPU", found["cuda"], "no CUDA device", _CUDA_HINT),
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
    folder = Path(os.environ.get("MS_ASSET_DIR", Path.home() / ".maniskill")) / "data"
    hint = "`python -m mani_skill.utils.download_asset NAME` downloads what a task or robot needs"
    try:
        names = sorted(f"{one.parent.name}/{one.name}" for one in folder.glob("*/*") if one.is_dir())
    except OSError:
        names = []
    if not names:
        return [DoctorCheck("ManiSkill's assets", "missing", f"nothing in {folder}", hint)]
    return [DoctorCheck("ManiSkill's assets", "ok", f"{folder}: {', '.join(names)}")]
