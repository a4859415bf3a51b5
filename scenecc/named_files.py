"""Finds and reads the files that a scene, a plan or an asset names, within what the scene may read."""

from __future__ import annotations

import posixpath
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from scenecc.plan.body import AssetFile
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, resolve_asset_reference, resolve_path

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.assets.files import AssetFiles
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.expand.documents import SceneDocument
    from scenecc.expand.expansion import Expansion, MeshMeasurer
    from scenecc.lower.references import FileResolver, MeshReader, RobotRequest
    from scenecc.robots.description import RobotDescription
    from scenecc.robots.files import ReadBudget
    from scenecc.source import Limits


DICT = "<dict>"
"""Name of a scene that was given as a dict."""


def resolver(scope: AssetScope, sink: Sink, expansion: Expansion | None = None) -> FileResolver:
    """Returns a function that finds the files a scene names.

    Args:
        scope: what may be read.
        sink: collects diagnostics.
        expansion: maps a path to its document; None: everything is in the top document.
    """
    top = scope.root or Path.cwd()

    def find(uri: str, origin: Origin) -> AssetFile | None:
        """Returns the file of a URI as written; None, reported, if it cannot be used."""
        if sink.full:
            return None
        base, by = top, origin.file
        if expansion is not None:
            uri, document = expansion.reference(uri, origin)
            base, by = document.folder, document.name
        found = resolve_path(uri, base=base, scope=scope)
        if isinstance(found, Refusal):
            sink.report(found.code, found.message, origin, hint=found.hint)
            return None
        scope.memory.note(found, by or DICT)
        return AssetFile(found.uri, found.path)

    return find


def named_resolver(scope: AssetScope) -> Callable[[str, AssetFile], Path | Refusal]:
    """Returns an `assets.files.ResolveNamed`, which finds the files an asset names."""

    def find(reference: str, asset: AssetFile) -> Path | Refusal:
        """Returns the file of a reference inside an asset, or why it cannot be used."""
        found = resolve_asset_reference(reference, owner=asset.path, owner_uri=asset.uri, scope=scope)
        if isinstance(found, Refusal):
            return found
        scope.memory.note(found, asset.uri)
        return found.path

    return find


def asset_files(scope: AssetScope, limits: Limits) -> AssetFiles:
    """Returns the files of one compilation."""
    from scenecc.assets.files import AssetFiles

    return AssetFiles(named_resolver(scope), limits.asset_bytes)


def mesh_reader(scope: AssetScope, limits: Limits, sink: Sink) -> MeshReader:
    """Returns a function that reads the vertices of meshes, each file once."""
    known: dict[Path, Any] = {}

    def read(asset: AssetFile, origin: Origin) -> Any:
        """Implements `MeshReader`."""
        from scenecc.checks.assets import read_vertices

        if asset.path not in known:
            known[asset.path] = read_vertices(asset, origin, sink, asset_files(scope, limits))
        return known[asset.path]

    return read


def mesh_measurer(scope: AssetScope, limits: Limits, sink: Sink) -> MeshMeasurer:
    """Returns a function that computes the bounds of meshes, each file once."""
    known: dict[Path, list[list[float]] | None] = {}

    def measure(document: SceneDocument, uri: str, origin: Origin) -> list[list[float]] | None:
        """Implements `MeshMeasurer`."""
        if sink.full:
            return None
        found = resolve_path(document.reference(uri), base=document.folder, scope=scope)
        if isinstance(found, Refusal):
            sink.report(found.code, found.message, origin, hint=found.hint)
            return None
        scope.memory.note(found, document.shown, "mesh")
        from scenecc.checks.assets import read_bounds

        if found.path not in known:
            asset = AssetFile(found.uri, found.path)
            known[found.path] = read_bounds(asset, origin, sink, asset_files(scope, limits))
        return known[found.path]

    return measure


Srdf = ResolvedFile | Literal["sibling"] | None


class RobotReads:
    """Reads the robots of one compilation, each once.

    Args:
        scope: what may be read.
        limits: limits of file sizes.
        sink: collects diagnostics.
        expansion: maps a path to its document; None: everything is in the top document.
    """

    def __init__(self, scope: AssetScope, limits: Limits, sink: Sink, expansion: Expansion | None) -> None:
        self._scope = scope
        self._limits = limits
        self._sink = sink
        self._expansion = expansion
        self._known: dict[Any, tuple[RobotDescription | None, Origin, Origin]] = {}
        self._budget: ReadBudget | None = None

    def read(self, request: RobotRequest, places: Mapping[str, Origin]) -> tuple[AssetFile, RobotDescription] | None:
        """Implements `RobotReader`."""
        if self._sink.full or (self._budget is not None and self._budget.left < 0):
            # Already reported.
            return None
        origin = places[request.format]
        file = self._resolve(request.uri, origin)
        srdf: Srdf = "sibling"
        pairing = origin
        if request.srdf is not None:
            pairing = places["srdf"]
            srdf = None if request.srdf == "none" else self._resolve(request.srdf, pairing)
        folder = None
        if request.package_dir is not None:
            folder = self._folder(request.package_dir, places["package_dir"])
        if file is None or (srdf is None and request.srdf != "none"):
            return None
        if request.package_dir is not None and folder is None:
            return None
        # Everything that determines the result, with resolved files.
        key = (replace(request, uri="", srdf=None, package_dir=None), file.path, srdf, folder)
        if key not in self._known:
            described = self._describe_robot(request, file, srdf, folder, places)
            self._known[key] = described, origin, pairing
        found, first, first_pairing = self._known[key]
        # An error of the file is reported once, at the entity that uses it.
        self._sink.note_user(first, origin)
        self._sink.note_user(first_pairing, pairing)
        return None if found is None else (AssetFile(file.uri, file.path, read_by=found.read_by), found)

    def _describe_robot(
        self,
        request: RobotRequest,
        file: ResolvedFile,
        srdf: Srdf,
        folder: tuple[str, Path] | None,
        places: Mapping[str, Origin],
    ) -> RobotDescription | None:
        """Reads a robot file. `places`: where the keys are written."""
        origin = places[request.format]
        from scenecc.robots.files import ReadBudget

        self._budget = budget = self._budget or ReadBudget()
        common: Any = {"scope": self._scope, "sink": self._sink, "origin": origin, "budget": budget}
        if request.format == "mjcf":
            from scenecc.robots.mujoco.reader import VISUAL_GROUPS, read_mjcf

            keyframe = None if request.keyframe is None else (request.keyframe, places["keyframe"])
            groups = VISUAL_GROUPS if request.visual_groups is None else request.visual_groups
            return read_mjcf(file, limits=self._limits, keyframe=keyframe, visual_groups=groups, **common)
        from scenecc.robots.urdf import read_urdf

        return read_urdf(
            file,
            scale=request.scale,
            collision_is_visual=request.collision_is_visual,
            repair=request.repair,
            srdf=srdf,
            srdf_origin=places.get("srdf", origin),
            package=None if folder is None else self._inside(folder),
            **common,
        )

    def _inside(self, folder: tuple[str, Path]) -> Callable[[str], ResolvedFile | Refusal]:
        uri, base = folder

        def find(inner: str) -> ResolvedFile | Refusal:
            """Resolves the part after `package://` in the folder."""
            return resolve_path(posixpath.join(uri, inner), base=base, scope=self._scope)

        return find

    def _resolve(self, uri: str, origin: Origin) -> ResolvedFile | None:
        uri, base = self._reference(uri, origin)
        found = resolve_path(uri, base=base, scope=self._scope)
        if isinstance(found, Refusal):
            return self._report_refusal(found, origin)
        self._scope.memory.note(found, self._file(origin))
        return found

    def _folder(self, uri: str, origin: Origin) -> tuple[str, Path] | None:
        """Returns a folder and the base of its path; None if it does not exist."""
        uri, base = self._reference(uri, origin)
        found = resolve_path(uri.rstrip("/") or uri, base=base, scope=self._scope)
        # A folder is rejected as a file, which shows that it exists.
        if isinstance(found, Refusal) and found.code == "SC404":
            return uri, base
        if isinstance(found, Refusal):
            return self._report_refusal(found, origin)
        self._sink.report("SC404", f"`{uri}` is a file", origin, hint="name the folder that holds the packages")
        return None

    def _report_refusal(self, refusal: Refusal, origin: Origin) -> None:
        self._sink.report(refusal.code, refusal.message, origin, hint=refusal.hint)

    def _file(self, origin: Origin) -> str:
        """Returns the name of the document at an origin."""
        return (origin if self._expansion is None else self._expansion.trace(origin)).file or DICT

    def _reference(self, uri: str, origin: Origin) -> tuple[str, Path]:
        """Returns a path as its document means it, and the folder it is relative to."""
        if self._expansion is None:
            return uri, self._scope.root or Path.cwd()
        uri, document = self._expansion.reference(uri, origin)
        return uri, document.folder
