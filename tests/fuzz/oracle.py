"""What must hold of every scene, whatever is in its files."""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import traceback
import zipfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

import scenecc
from scenecc import plan_text
from scenecc.diagnostics import Diagnostic
from scenecc.importers import usd
from scenecc.importers.import_scene import import_scene
from scenecc.importers.imported_scene import LOSSES
from scenecc.plan import ConvexParts, ScenePlan

SCENE = "scene.yaml"
PACK = "scene.scn"
UNPACKED = "pack"
"""The folder of files of which a pack is made."""

PASSPORT = "passport.json"
IMPORTED = "source"
"""The name, without its suffix, of a file that is imported."""

LIMITS = {"asset_bytes": 2**24, "objects": 200, "scenes": 256}
"""Small: a case that is within them takes no second."""

_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")


_DRAWN = {"SC202", "SC513", "SC515"}
"""Codes of what only drawn values tell."""


def judge(folder: Path, *, render: bool | None) -> str | None:
    """What is wrong with how the folder's passport, pack, `scene.yaml` or `source.*` is taken; None: nothing.

    1. Nothing but a `SceneError` is raised, and none without an error in it.
    2. Diagnostics stand inside the files that they name.
    3. What `validate` finds no error in compiles.
    4. What compiles is built, has finite masses, and moves finitely unless its numbers are extreme. An image or a mesh
       that a library reads and SAPIEN does not, or reads otherwise, is refused by the build, at the key that names it.
    5. What is imported is written, valid and built, or nothing is written.

    Args:
        folder: becomes the working directory.
        render: build what is seen, too; None: build nothing.
    """
    os.chdir(folder)
    if (folder / PASSPORT).exists():
        return guarded(_replayed)
    if (folder / UNPACKED).exists():
        _pack(folder / UNPACKED)
    for scene in (PACK, SCENE):
        if (folder / scene).exists():
            os.environ["XDG_CACHE_HOME"] = str(folder)
            return guarded(lambda scene=scene: _judged(scene, render=render))
    return guarded(lambda: _imported(next(folder.glob(f"{IMPORTED}.*")), render=render))


def guarded(function: Callable[[], str | None]) -> str | None:
    """What a function says is wrong, or what it raises."""
    try:
        return function()
    except AssertionError as error:
        return str(error)
    except Exception as error:  # noqa: BLE001 - any at all is a failure
        frame = next((f for f in reversed(traceback.extract_tb(error.__traceback__)) if "scenecc" in f.filename), None)
        where = f"{Path(frame.filename).name}:{frame.name}" if frame else "?"
        return f"{type(error).__name__} in {where}: {error}"


def _pack(folder: Path) -> None:
    """Makes an archive of a folder, as a stranger's program may."""
    with zipfile.ZipFile(PACK, "w") as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                archive.write(path, path.relative_to(folder))


def _replayed() -> str | None:
    try:
        batch = scenecc.replay(Path(PASSPORT).read_bytes().decode("utf-8", "replace"), render=False, limits=LIMITS)
    except scenecc.SceneError as error:
        return None if any(one.severity == "error" for one in error.diagnostics) else "it is refused without an error"
    with batch:
        batch.step(1)
    return None


def _judged(scene: str, *, render: bool | None) -> str | None:
    found = scenecc.validate(scene, limits=LIMITS)
    for diagnostic in found:
        _in_its_file(diagnostic)
    faulty = any(one.severity == "error" for one in found)
    try:
        plan = scenecc.compile_scene(scene, limits=LIMITS)
    except scenecc.SceneError as error:
        told = any(one.severity == "error" for one in error.diagnostics)
        right = told and (faulty or _foretold(found, error))
        return None if right else f"validate is clean, compile is not: {_said(error)}"
    if faulty:
        return f"validate is not clean, compile is: {found[0]}"
    return None if render is None else _built(plan, render=render)


def _foretold(found: list[Diagnostic], error: scenecc.SceneError) -> bool:
    """Whether warnings said of all that has no value, or a wrong one, that it may: `validate` draws nothing.

    What a body weighs is told at the body, or at an expression in it that may give anything. Whether something fits
    where it is placed only the draws tell.
    """
    drawn = [one for one in error.diagnostics if one.severity == "error" and one.code not in {"SC354", "SC356"}]
    may = {one.path for one in found if one.code in {"SC514", "SC516"}}
    bodies = {one.path for one in drawn if one.code in {"SC510", "SC511", "SC512"}}
    weighed = {path for path in bodies if any(place == path or place.startswith(f"{path}.") for place in may)}
    return all(one.path in weighed or (one.path in may and one.code in _DRAWN) for one in drawn)


def _said(error: scenecc.SceneError) -> str:
    return "; ".join(map(str, error.diagnostics))[:300] or "nothing is said"


def _in_its_file(diagnostic: Diagnostic) -> None:
    for location in (diagnostic.location, *(one.location for one in diagnostic.related)):
        if location.file is None or location.line is None or not Path(location.file).is_file():
            continue
        lines = re.split(r"\r\n|[\r\n\x85\u2028\u2029]", Path(location.file).read_bytes().decode("utf-8", "replace"))
        assert 1 <= location.line <= len(lines), f"{diagnostic.code} is told of a line that is not there: {diagnostic}"
        length = len(lines[location.line - 1])
        column = location.column or 1
        assert 1 <= column <= length + 1, f"{diagnostic.code} is told of a column that is not there: {diagnostic}"


def _built(plan: ScenePlan, *, render: bool) -> str | None:
    from sapien import physx

    structures = [body for entity in plan.entities for body in entity.bodies]
    geometries = [shape.geometry for body in structures for shape in body.collisions]
    if any(isinstance(one, ConvexParts) and one.coacd is not None for one in geometries):
        return None  # takes seconds, and writes where others read
    physx.clear_cache()
    try:
        batch = scenecc.load_scene(plan, render=render)
    except scenecc.SceneError as error:
        errors = [one for one in error.diagnostics if one.severity == "error"]
        read = errors and all(map(_engine_reads_otherwise, errors))
        return None if read else f"validate is clean, build is not: {_said(error)}"
    with batch:
        _finite(batch, "built")
        batch.step(3)
        if not _extreme(plan):
            _finite(batch, "moved")
    return None


def _engine_reads_otherwise(error: Diagnostic) -> bool:
    """Whether a file is refused because SAPIEN cannot read it, or makes another hull of it."""
    named = error.path.rpartition(".")[2] == "file" or "texture" in error.path
    unread = error.message.startswith(("SAPIEN cannot", "the renderer cannot load"))
    return named and (error.code == "SC423" or (error.code in {"SC801", "SC807"} and unread))


def _extreme(plan: ScenePlan) -> bool:
    """Whether a number of a plan is so large that steps may not compute with it, which is SC820's to tell."""
    numbers = [abs(float(one)) for one in _NUMBER.findall(plan_text(plan))]
    return max(numbers, default=0) > 1e6


def _finite(batch: Any, when: str) -> None:
    from sapien import physx

    for scene in batch.scenes:
        for entity in scene.entities:
            for body in entity.components:
                if not isinstance(body, physx.PhysxRigidBaseComponent):
                    continue
                numbers = [*entity.pose.p, *entity.pose.q]
                if isinstance(body, physx.PhysxRigidBodyComponent):
                    numbers += [body.mass, *body.inertia, *body.linear_velocity, *body.angular_velocity]
                assert np.isfinite(numbers).all(), f"{type(body).__name__} has numbers that are not finite when {when}"


def _imported(source: Path, *, render: bool | None) -> str | None:
    usd.ask_module = _ask_fork
    if render is None:
        _load_importers()
        return None
    before = set(Path().rglob("*"))
    try:
        import_scene(source, "out.yaml", allow=LOSSES, limits=LIMITS)
    except scenecc.SceneError as error:
        if not any(one.severity == "error" for one in error.diagnostics):
            return f"it is refused without an error: {_said(error)}"
        engine = [one for one in error.diagnostics if one.code.startswith("SC80")]
        built = [one for one in engine if not _engine_reads_otherwise(one)]
        left = set(Path().rglob("*")) - before
        return (
            f"{left} is left: {_said(error)}"
            if left
            else f"it is only refused when it is built: {built[0]}"
            if built
            else None
        )
    found = scenecc.validate("out.yaml", limits=LIMITS)
    wrong = [one for one in found if one.severity == "error"]
    return f"what is imported is not valid: {wrong[0]}" if wrong else None


def _load_importers() -> None:
    for name in ("mjcf", "sdf", "urdf", "usd_scene", "certificate"):
        import_module(f"scenecc.importers.{name}")


def _ask_fork(module: str, request: Any, **_: object) -> subprocess.CompletedProcess[bytes]:
    """As `ask_module`, in a fork of this process: loading usd-core takes longer than reading a small stage."""
    with TemporaryFile("w+") as asked, TemporaryFile("w+") as answer, TemporaryFile("w+") as errors:
        json.dump(request, asked)
        asked.seek(0)
        pid = os.fork()
        if not pid:
            sys.stdin, sys.stdout, sys.stderr = asked, answer, errors
            resource.setrlimit = lambda *_: None  # this process has limits
            status = 1
            try:
                import_module(module).main()
                status = 0
            except BaseException:  # noqa: BLE001 - as the interpreter tells it
                errors.write(traceback.format_exc()[-500:])
            finally:
                answer.flush()
                errors.flush()
                os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        answer.seek(0)
        errors.seek(0)
        return subprocess.CompletedProcess([module], status, answer.read().encode(), errors.read().encode())
