"""Imports USD stages. usd-core, a C++ library, reads untrusted files in a separate process with limits."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final, cast

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut
from scenecc.importers.imported_scene import Asset, ImportContext, ImportedScene, Loss, ReferencePose
from scenecc.interrupt import ask_module
from scenecc.source import Limits
from scenecc.source.paths import AssetScope

_SECONDS: Final = 300

_MEMORY: Final = 6 * 2**30
"""Address space of the process [bytes]: libraries need 2 GiB, and a stage several times its size."""

_FILE: Final = "\0file"
"""Key of an asset in the process's answer; no document contains it."""


def import_usd(path: Path, context: ImportContext) -> ImportedScene | None:
    """Reads a stage; returns None after an error, which is reported in the context's sink."""
    scope = context.scope
    request = {
        "path": str(path),
        "root": None if scope.root is None else str(scope.root),
        "asset_roots": [str(root) for root in scope.asset_roots],
        "allow_outside": scope.allow_outside,
        "limits": asdict(context.limits),
    }
    # usd-core loads plugins and searches folders that these variables name.
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PXR_", "USD", "TF_", "AR_"))}
    environment = {**kept, "PXR_WORK_THREAD_LIMIT": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = ask_module("scenecc.importers.usd", request, seconds=_SECONDS, environment=environment)
    except subprocess.TimeoutExpired:
        context.sink.report("SC430", f"reading the stage takes more than {_SECONDS} s", Location(str(path)))
        return None
    if done.returncode > 0:
        *_, reason = ["no reason", *done.stderr.decode(errors="replace").split("\n")[:-1]]
        message = f"scenecc's USD reader failed:  {cut(reason)}"
        hint = "if other programs open the stage, this is a bug in scenecc"
        context.sink.report("SC430", message, Location(str(path)), hint=hint)
        return None
    if done.returncode:
        message = f"usd-core cannot read the stage: its process ended by signal {-done.returncode}"
        context.sink.report("SC430", message, Location(str(path)))
        return None
    return _decode(json.loads(done.stdout), path, context)


def _decode(answer: dict[str, Any], path: Path, context: ImportContext) -> ImportedScene | None:
    """Decodes the process's answer, and reports its diagnostics."""
    for code, message, place, hint in answer["diagnostics"]:
        context.sink.report(code, message, Location(*place), hint=hint)
    if answer["document"] is None:
        return None
    place = Location(str(path))
    return ImportedScene(
        _assets(answer["document"]),
        tuple(Loss(kind, message, place, where) for kind, message, where in answer["losses"]),
        answer["bodies"],
        {name: ReferencePose(tuple(pose), mass) for name, (pose, mass) in answer["reference"].items()},
        engine="UsdPhysics",
    )


def _assets(node: Any) -> Any:
    """Replaces encoded assets in plain data by `Asset`s."""
    if isinstance(node, list):
        return [_assets(each) for each in cast("list[Any]", node)]
    if not isinstance(node, dict):
        return node
    content = cast("dict[str, Any]", node)
    if _FILE in content:
        name, path, text = content[_FILE]
        return Asset(name, Path(path) if text is None else text.encode("latin-1"))
    return {key: _assets(each) for key, each in content.items()}


def _encode_asset(asset: Any) -> Any:
    source = asset.source
    made = isinstance(source, bytes)
    return {_FILE: [asset.name, None if made else str(source), source.decode("latin-1") if made else None]}


def main() -> None:
    """Reads the stage that standard input names, and writes the scene to standard output."""
    from scenecc.importers.usd_scene import read_stage  # noqa: PLC0415 - loads usd-core

    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS))
    request = json.load(sys.stdin)
    root, roots = request["root"], tuple(map(Path, request["asset_roots"]))
    scope = AssetScope(None if root is None else Path(root), roots, request["allow_outside"])
    sink = Sink()
    try:
        found = read_stage(Path(request["path"]), ImportContext(sink, scope, Limits(**request["limits"])))
    except MemoryError:
        found = None
        sink.report("SC430", "reading the stage takes too much memory", Location(request["path"]))
    answer: dict[str, Any] = {"document": None}
    if found is not None:
        answer = {
            "document": found.document,
            "losses": [(loss.kind, loss.message, loss.path) for loss in found.losses],
            "bodies": dict(found.bodies),
            "reference": {name: (row.pose, row.mass) for name, row in found.reference.items()},
        }
    answer["diagnostics"] = [
        (each.code, each.message, (each.location.file, each.location.line, each.location.column), each.hint)
        for each in sink.diagnostics()
    ]
    json.dump(answer, sys.stdout, default=_encode_asset)


if __name__ == "__main__":
    main()
