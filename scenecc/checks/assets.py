"""Checks of the files that a plan uses: their content, their hashes and the environment map.

Each file is read once, however many shapes use it. An error is reported at the first shape it concerns.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scenecc.assets.errors import AssetError, AssetReference
from scenecc.assets.files import AssetFiles, MissingError, ResolveNamed, check_measures
from scenecc.assets.images import IMAGE_SUFFIXES
from scenecc.assets.mesh_uses import MeshUse, mesh_use
from scenecc.assets.names import check_count, material_images
from scenecc.assets.obj_materials import fallback_materials
from scenecc.checks.mesh_rules import check_mesh_use
from scenecc.checks.value_queries import list_indices, rows
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import MeshGeometry
from scenecc.plan.body import NamedFile
from scenecc.plan.rendering import CubeMap, TexturedLight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.assets.meshes import MeshRecord
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import AssetFile
    from scenecc.plan.rendering import SkyMap


_DIGEST_CHARS = 12


def check_unchanged(known: AssetFile, found: AssetFile, origin: Origin, sink: Sink) -> None:
    """Reports a file that changed (SC716).

    Args:
        known: the file as the plan has it; without a hash it is taken as it is.
        found: the same as it was read now.
        origin: where it is named.
        sink: takes the fault.
    """
    if known.sha256 is None:
        return
    before = {"": known.sha256} | {one.uri: one.sha256 for one in known.names}
    after = {"": found.sha256} | {one.uri: one.sha256 for one in found.names}
    for uri in dict.fromkeys([*before, *after]):
        if before.get(uri) != after.get(uri):
            name = f"{known.uri}: the file `{uri}`, which it names," if uri else f"{known.uri}: the file"
            was, now = (_short_digest(hashes.get(uri)) for hashes in (before, after))
            hint = "compile the scene again, or put the file back"
            sink.report("SC716", f"{name} is not what it was: {now} now, {was} in the plan", origin, hint=hint)


def _short_digest(digest: str | None) -> str:
    return "nothing" if digest is None else f"SHA-256 {digest[:_DIGEST_CHARS]}…"


def _check_environment_map(plan: ScenePlan, files: AssetFiles, sink: Sink) -> None:
    """Reports environment maps whose images do not fit together; each image alone is valid."""
    if plan.environment is None or plan.environment.map is None:
        return
    place = (plan.environment.origin or plan.origin or Origin(None)).child("map")
    if isinstance(plan.environment.map, CubeMap):
        _check_cube_map(plan, plan.environment.map, files, place, sink)
    else:
        _check_sky_map(plan, plan.environment.map, files, place, sink)


def _check_cube_map(plan: ScenePlan, surroundings: CubeMap, files: AssetFiles, origin: Origin, sink: Sink) -> None:
    """Checks that the six images of a cube map have the same size and pixel format in every scene."""
    faces = [getattr(surroundings, item.name) for item in fields(surroundings)]
    found = rows(faces)
    # Drawn values may occur in any combination.
    sides = [[index for face in faces for index in list_indices(face)]] if found is None else found
    for side in sides:
        numbers = [int(index[0]) if isinstance(index, tuple) else index for index in side]
        sizes = {index: files.image(plan.files[index].path) for index in dict.fromkeys(numbers)}
        few = next((index for index in numbers if not sizes[index].has_all_levels), None)
        if few is not None:
            message = f"a side of a cube has levels down to one pixel, or none, and {plan.files[few].uri} has fewer"
            sink.report("SC553", message, origin)
            return
        first = numbers[0]
        other = next((index for index in numbers if sizes[index] != sizes[first]), None)
        if other is not None:
            a, b = (f"{plan.files[index].uri} ({sizes[index]})" for index in (first, other))
            sink.report("SC553", f"the sides of a cube are alike, and {a} and {b} are not", origin)
            return


def _check_sky_map(plan: ScenePlan, surroundings: SkyMap, files: AssetFiles, origin: Origin, sink: Sink) -> None:
    """Checks that an image can be an equirectangular map: twice as wide as high."""
    for index in list_indices(surroundings.file):
        size = files.image(plan.files[index].path)
        if size.levels and not (size.sides == 6 and size.columns == size.rows and size.has_all_levels):
            what = "a KTX of all directions has six square sides, and levels down to one pixel"
            hint = "make it with its mipmaps, or take one picture in PNG, HDR or EXR"
            sink.report("SC554", f"{what}; {plan.files[index].uri} has not", origin, hint=hint)
            return
        if not size.levels and size.columns != 2 * size.rows:
            message = f"a map of all directions is twice as wide as it is high, and {plan.files[index].uri} is not"
            sink.report("SC554", f"{message} ({size})", origin, hint="six pictures are written {px: …, nx: …, …}")
            return


_LeftOut = tuple["Origin | None", str, bool]
"""The node that names a robot's file, the kind of what a mesh of it names, and whether that is missing."""


@dataclass(frozen=True, slots=True)
class _AssetChecker:
    """State of one check of all files.

    Attributes:
        textures: the fault of each texture, if any, by its path: several meshes may share one.
        left_out: what is said, and where, of files that are left out, by who names the meshes, the kind of the file
            and why; a robot may have one a mesh.
    """

    sink: Sink
    files: AssetFiles
    textures: dict[Path, AssetError | None] = field(default_factory=dict["Path", "AssetError | None"])
    left_out: dict[_LeftOut, list[tuple[str, Origin]]] = field(
        default_factory=dict["_LeftOut", "list[tuple[str, Origin]]"]
    )


def check_assets(
    plan: ScenePlan,
    sink: Sink,
    *,
    resolve_named: ResolveNamed,
    max_asset_bytes: int,
) -> tuple[AssetFile, ...]:
    """Reports every file of a plan that SAPIEN could not use as planned, or that changed since.

    Args:
        plan: its `files` are read from their `path`.
        sink: where faults go.
        resolve_named: finds the files that an asset names (MTL, textures, buffers), inside what the scene may read.
        max_asset_bytes: the limit `asset_bytes`, of a file and of what it unpacks to [bytes].

    Returns:
        The plan's files with what was read of them: hashes, and those that they name in turn.
    """
    checker = _AssetChecker(sink, AssetFiles(resolve_named, max_asset_bytes))
    meshes: dict[int, dict[MeshUse, Origin]] = {}
    for index, use, origin in _list_meshes(plan):
        meshes.setdefault(index, {}).setdefault(use, origin)
    textures: dict[int, dict[str, Origin]] = {}
    for index, slot, origin in _textures(plan):
        textures.setdefault(index, {}).setdefault(slot, origin)
    files = list(plan.files)
    for index in dict.fromkeys([*textures, *meshes]):
        asset, by_use = files[index], meshes.get(index, {})
        first = next(iter(textures.get(index, by_use).values()))
        if index in textures:
            first = asset.origin or first
            with _report_asset_errors(checker, asset, first):
                _check_texture(checker, asset.path)
                _check_colors(checker, asset, textures[index])
        named = sorted(_check_mesh(checker, asset, by_use).items()) if by_use else []
        if asset.path in checker.files.opened:
            digest, state = checker.files.opened[asset.path]
            names = tuple(
                NamedFile(uri, known, path, then)
                for uri, path in named
                for known, then in (checker.files.opened[path],)
            )
            files[index] = replace(asset, sha256=digest, names=names, state=state)
            check_unchanged(asset, files[index], first, sink)
    for (message, origin), *others in checker.left_out.values():
        count = f" (and {len(others)} other{'s' if len(others) > 1 else ''} like it)" if others else ""
        sink.report("SC488", message + count, origin)
    if not sink.failed:
        _check_environment_map(plan, checker.files, sink)
    return tuple(files)


def read_vertices(asset: AssetFile, origin: Origin, sink: Sink, files: AssetFiles) -> NDArray[np.float32] | None:
    """The vertices (n, 3) [m] of a mesh as the engine has them; None if it cannot be read, which is reported.

    Args:
        asset: the file.
        origin: where it is asked for.
        sink: takes the fault.
        files: the files of the scene.
    """
    try:
        return np.concatenate([vertices.astype(np.float32) for vertices, _ in files.triangles(asset)])
    except AssetError as fault:
        _report(sink, asset, origin, fault)
        return None


def read_bounds(asset: AssetFile, origin: Origin, sink: Sink, files: AssetFiles) -> list[list[float]] | None:
    """The corners of the bounding box of a mesh [m]; None if it cannot be read, which is reported.

    Args: those of `read_vertices`.
    """
    try:
        whole = check_measures(files.mesh(asset))
    except AssetError as fault:
        _report(sink, asset, origin, fault)
        return None
    return [list(whole.low), list(whole.high)]


def _list_meshes(plan: ScenePlan) -> Iterator[tuple[int, MeshUse, Origin]]:
    """The uses of every mesh, and where it is named."""
    top = plan.origin or Origin(None)
    for structure in (body for entity in plan.entities for body in entity.bodies):
        for shape in (*structure.collisions, *structure.visuals):
            if isinstance(geometry := shape.geometry, MeshGeometry):
                for index in list_indices(geometry.file):
                    yield index, mesh_use(geometry), (shape.origin or structure.origin or top).child("file")


def _textures(plan: ScenePlan) -> Iterator[tuple[int, str, Origin]]:
    """Every image, the field of a material that names it ("" for lights and environments), and a place that uses it."""
    top = plan.origin or Origin(None)
    for file in _light_and_environment_files(plan):
        yield file, "", top
    for structure in (body for entity in plan.entities for body in entity.bodies):
        for shape in structure.visuals:
            for index in list_indices(shape.material) if shape.material is not None else ():
                place = (shape.origin or structure.origin or top).child("material")
                for name, texture in plan.visual_materials[index].textures().items():
                    for file in list_indices(texture.file):
                        yield file, name, place


def _light_and_environment_files(plan: ScenePlan) -> Iterator[int]:
    """The files of lights and of what surrounds the scenes."""
    surroundings = plan.environment and plan.environment.map
    if surroundings is not None:
        for item in fields(surroundings):
            yield from list_indices(getattr(surroundings, item.name))
    for light in plan.lights:
        if isinstance(light.light, TexturedLight):
            yield from list_indices(light.light.texture.file)


def _check_mesh(checker: _AssetChecker, asset: AssetFile, by_use: dict[MeshUse, Origin]) -> dict[str, Path]:
    """Checks a mesh for all its uses. Returns the files that it names and a build opens, by name."""
    first = next(iter(by_use.values()))
    try:
        mesh = checker.files.mesh(asset)
        named = {one.uri: checker.files.resolve(asset, one) for one in mesh.names if one.kind == "buffer"}
    except AssetError as fault:
        _report(checker.sink, asset, first, fault)
        return {}
    _check_references(checker, asset, mesh, by_use, named)
    suffix = Path(asset.path).suffix.lower()
    reported: set[str] = set()
    for use, origin in by_use.items():
        with _report_asset_errors(checker, asset, origin):
            for fault in check_mesh_use(mesh, use, suffix, partial(checker.files.hull_parts, asset)):
                if fault.code not in reported:
                    reported.add(fault.code)
                    _report(checker.sink, asset, origin, fault)
    return named


def _check_references(
    checker: _AssetChecker,
    asset: AssetFile,
    mesh: MeshRecord,
    by_use: Mapping[MeshUse, Origin],
    named: dict[str, Path],
) -> None:
    """Checks the files that an asset names. Those that a build opens are added to `named`."""
    visual = by_use.get("visual")
    origin = visual or next(iter(by_use.values()))
    references = [one for one in mesh.names if one.kind != "buffer"]
    images: dict[str, tuple[AssetReference, ...]] = {}  # of each MTL, by its SHA-256: a mesh may name one in many ways
    for reference in references:  # which grows
        with _report_asset_errors(checker, asset, origin):
            try:
                path = checker.files.resolve(asset, reference)
            except AssetError as fault:
                _check_optional(checker, asset, reference, fault, visual)
                if reference.kind == "material":
                    references.extend(
                        AssetReference(uri, "fallback") for uri in fallback_materials(reference.uri, asset.path)
                    )
                continue
            if visual is not None and reference.kind == "image":
                try:
                    _check_texture(checker, path)
                except AssetError as fault:
                    with _naming_image(reference):
                        _check_optional(checker, asset, reference, fault, visual)
                    continue
            elif reference.kind in {"material", "fallback"} and any(use != "decomposed" for use in by_use):
                # The engine reads it for what collides, too (and whatever it takes for one that is missing), and gives
                # up where it cannot; images it opens only for what is visible. A decomposition reads none of them.
                digest = checker.files.digest(path)
                if digest not in images:
                    images[digest] = material_images(checker.files.content(path))
                    check_count([*references, *images[digest]])
                    references.extend(images[digest] if visual is not None else ())
            else:
                continue  # an image of a mesh that only collides
            named[reference.uri] = path


def _check_optional(
    checker: _AssetChecker, asset: AssetFile, reference: AssetReference, fault: AssetError, visual: Origin | None
) -> None:
    """Raises the fault of a file that an asset names, unless it may be missing: not rendered, or by `repair`.

    Args:
        checker: takes the note of a repair.
        asset: what names the file.
        reference: by which it does.
        fault: why the file cannot be used.
        visual: where the asset is rendered; None: it only collides.
    """
    missing = isinstance(fault, MissingError)
    if visual is None:
        unused = missing or (fault.code == "SC418" and reference.kind == "image")
        if reference.kind == "buffer" or not unused:
            raise fault
        return
    # A build takes images out of an OBJ only: of others SAPIEN opens them at the first picture.
    if reference.kind == "image" and Path(asset.path).suffix.lower() != ".obj":
        repaired = missing and asset.optional_names
        raise AssetError(fault.code, fault.message, _ONLY_OF_OBJ) if repaired else fault
    unread = reference.kind == "image" and fault.code in _UNREAD_IMAGE
    if reference.kind == "buffer" or not (missing or unread):
        raise fault
    if not asset.optional_names:
        raise _with_repair(fault, visual)
    why = "is missing" if missing else f"cannot be used ({fault.message})"
    message = f"{asset.uri} names `{reference.uri[:60]}`, which {why}: it is left out"
    checker.left_out.setdefault((visual.parent, reference.kind, missing), []).append((message, visual))


_ONLY_OF_OBJ = "`repair: [files]` leaves images out of OBJ meshes only: put the image there, or export the mesh as OBJ"

_UNREAD_IMAGE = {"SC410", "SC420"}
"""Codes of images that are there and that cannot be read."""


def _with_repair(fault: AssetError, origin: Origin) -> AssetError:
    """A missing file, with a hint at the repair that leaves it out, if a URDF names the mesh."""
    by = origin.parent.path[-1:] if origin.parent is not None else ()
    if by != ("urdf",):
        return fault
    repair = "with `repair: [files]` in the scene it is left out"
    return AssetError(fault.code, fault.message, repair if fault.hint is None else f"{fault.hint}; {repair}")


@contextmanager
def _naming_image(reference: AssetReference) -> Generator[None, None, None]:
    """Names the image in an `AssetError` raised inside, which is reported for the mesh."""
    try:
        yield
    except AssetError as fault:
        raise AssetError(fault.code, f"its image `{reference.uri[:60]}`: {fault.message}", fault.hint) from fault


@contextmanager
def _report_asset_errors(checker: _AssetChecker, asset: AssetFile, origin: Origin) -> Generator[None, None, None]:
    """Reports an `AssetError` raised inside."""
    try:
        yield
    except AssetError as fault:
        _report(checker.sink, asset, origin, fault)


def _check_texture(checker: _AssetChecker, path: Path) -> None:
    if path not in checker.textures:
        checker.textures[path] = None
        try:
            _check_uncached_texture(checker, path)
        except AssetError as fault:
            checker.textures[path] = fault
    if (fault := checker.textures[path]) is not None:
        raise fault


def _check_uncached_texture(checker: _AssetChecker, path: Path) -> None:
    suffix = path.suffix.lower()
    if suffix not in IMAGE_SUFFIXES:
        kind = f"`{suffix}` is not an image format" if suffix else "a file without a suffix is not an image"
        raise AssetError("SC410", f"{kind} that is read", "save it as PNG or JPEG")
    checker.files.image(path)


_GREY_RESULTS = {
    "base_color_texture": "the shape is invisible",
    "emission_texture": "nothing glows",
    "normal_texture": "the normals point elsewhere",
}
"""What a picture of SAPIEN 3.0 shows where a texture of three channels has one; the others are read from one."""


def _check_colors(checker: _AssetChecker, asset: AssetFile, slots: Mapping[str, Origin]) -> None:
    """Warns of a grey image where SAPIEN needs three channels. `slots`: a place that uses it, by field."""
    if not checker.files.image(asset.path).grey:
        return
    for slot, place in slots.items():
        if slot in _GREY_RESULTS:
            # Another slot may have named the file first.
            origin = asset.origin if asset.origin is not None and slot in asset.origin.path else place
            message = f"{asset.uri} is a grey image, which SAPIEN reads as red only: as {slot}, {_GREY_RESULTS[slot]}"
            checker.sink.report("SC424", message, origin, hint="save it in colour (RGB)")


def _report(sink: Sink, asset: AssetFile, origin: Origin, fault: AssetError) -> None:
    sink.report(fault.code, f"{asset.uri}: {fault.message}", origin, hint=fault.hint)
