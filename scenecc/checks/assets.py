"""Checks of the files that a plan uses: their content, their hashes and the environment map.

Each file is read once, for all shapes that use it. An error is reported at the first affected shape.
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
from scenecc.checks.mesh_mass import check_mesh_mass
from scenecc.checks.mesh_rules import check_mesh_use
from scenecc.checks.value_queries import list_indices, rows
from scenecc.colors import srgb_to_linear
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import MeshGeometry
from scenecc.plan.body import NamedFile
from scenecc.plan.rendering import CubeMap, TexturedLight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.assets.meshes import MeshRecord
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import AssetFile, VisualShape
    from scenecc.plan.rendering import SkyMap


_DIGEST_CHARS = 12


def check_unchanged(known: AssetFile, found: AssetFile, origin: Origin, sink: Sink) -> None:
    """Reports a file that has changed (SC716).

    Args:
        known: the file in the plan; without a hash, any content is accepted.
        found: the file as read now.
        origin: where it is named.
        sink: collects diagnostics.
    """
    if known.sha256 is None:
        return
    before = {"": known.sha256} | {one.uri: one.sha256 for one in known.names}
    after = {"": found.sha256} | {one.uri: one.sha256 for one in found.names}
    for uri in dict.fromkeys([*before, *after]):
        if before.get(uri) != after.get(uri):
            name = f"{known.uri}: the file `{uri}`, which it references," if uri else f"{known.uri}: the file"
            was, now = (_short_digest(hashes.get(uri)) for hashes in (before, after))
            hint = "compile the scene again, or restore the file"
            sink.report("SC716", f"{name} has changed: {now} now, {was} in the plan", origin, hint=hint)


def _short_digest(digest: str | None) -> str:
    return "nothing" if digest is None else f"SHA-256 {digest[:_DIGEST_CHARS]}…"


def _check_environment_map(plan: ScenePlan, files: AssetFiles, sink: Sink) -> None:
    """Reports environment maps whose images, each valid, do not fit together."""
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
            message = f"a cube map side needs mip levels down to one pixel, or none; {plan.files[few].uri} has fewer"
            sink.report("SC553", message, origin)
            return
        first = numbers[0]
        other = next((index for index in numbers if sizes[index] != sizes[first]), None)
        if other is not None:
            a, b = (f"{plan.files[index].uri} ({sizes[index]})" for index in (first, other))
            sink.report("SC553", f"sides of a cube map need one size and format; {a} and {b} differ", origin)
            return


def _check_sky_map(plan: ScenePlan, surroundings: SkyMap, files: AssetFiles, origin: Origin, sink: Sink) -> None:
    """Checks that an image can be an equirectangular map: twice as wide as high."""
    for index in list_indices(surroundings.file):
        size = files.image(plan.files[index].path)
        if size.levels and not (size.sides == 6 and size.columns == size.rows and size.has_all_levels):
            what = "a KTX environment map needs six square sides, and mip levels down to one pixel"
            hint = "export it with mipmaps, or use one image in PNG, HDR or EXR"
            sink.report("SC554", f"{what}; {plan.files[index].uri} lacks them", origin, hint=hint)
            return
        if not size.levels and size.columns != 2 * size.rows:
            message = f"an environment map must be twice as wide as high; {plan.files[index].uri} is not"
            sink.report("SC554", f"{message} ({size})", origin, hint="write six images as {px: …, nx: …, …}")
            return


_LeftOut = tuple["Origin | None", str, bool]
"""The node that names a robot's file, the kind of file that its mesh references, and whether that file is missing."""


@dataclass(frozen=True, slots=True)
class _AssetChecker:
    """State of one check of all files.

    Attributes:
        textures: the error of each texture, if any, by path: several meshes may share one.
        left_out: messages about ignored files with their places, grouped by `_LeftOut`; a robot may have one per mesh.
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
    """Reports every file of a plan that SAPIEN cannot use as planned, or that has changed.

    Args:
        plan: its `files` are read from their `path`.
        sink: collects diagnostics.
        resolve_named: finds the files that an asset references (MTL, textures, buffers), inside what the scene may
            read.
        max_asset_bytes: the limit `asset_bytes`, of a file and of its unpacked content [bytes].

    Returns:
        The plan's files with their hashes and references.
    """
    checker = _AssetChecker(sink, AssetFiles(resolve_named, max_asset_bytes))
    meshes: dict[int, dict[MeshUse, Origin]] = {}
    for index, use, origin in _list_meshes(plan):
        meshes.setdefault(index, {}).setdefault(use, origin)
    bare = dict(reversed([*_list_bare_visuals(plan)]))
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
        if index in bare:
            _check_vertex_colors(checker, asset, bare[index])
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
        check_mesh_mass(plan, checker.files, sink)
        _check_environment_map(plan, checker.files, sink)
    return tuple(files)


def read_vertices(asset: AssetFile, origin: Origin, sink: Sink, files: AssetFiles) -> NDArray[np.float32] | None:
    """Returns the vertices (n, 3) [m] of a mesh as the engine loads them; None if it cannot be read, which is reported.

    Args:
        asset: the file.
        origin: where it is used.
        sink: collects diagnostics.
        files: the files of the scene.
    """
    try:
        return np.concatenate([vertices.astype(np.float32) for vertices, _ in files.triangles(asset)])
    except AssetError as fault:
        _report(sink, asset, origin, fault)
        return None


def read_bounds(asset: AssetFile, origin: Origin, sink: Sink, files: AssetFiles) -> list[list[float]] | None:
    """Returns the corners of a mesh's bounding box [m]; None if it cannot be read, which is reported.

    Arguments are those of `read_vertices`.
    """
    try:
        whole = check_measures(files.mesh(asset))
    except AssetError as fault:
        _report(sink, asset, origin, fault)
        return None
    return [list(whole.low), list(whole.high)]


def _list_meshes(plan: ScenePlan) -> Iterator[tuple[int, MeshUse, Origin]]:
    """Yields the uses of every mesh, and where it is named."""
    top = plan.origin or Origin(None)
    for structure in (body for entity in plan.entities for body in entity.bodies):
        for shape in (*structure.collisions, *structure.visuals):
            if isinstance(geometry := shape.geometry, MeshGeometry):
                for index in list_indices(geometry.file):
                    yield index, mesh_use(geometry), (shape.origin or structure.origin or top).child("file")


def _list_bare_visuals(plan: ScenePlan) -> Iterator[tuple[int, Origin]]:
    """Yields the meshes of visuals that get no colour from the scene or the robot's file, and where they are named."""
    top = plan.origin or Origin(None)
    for structure in (body for entity in plan.entities for body in entity.bodies):
        for shape in structure.visuals:
            if isinstance(geometry := shape.geometry, MeshGeometry):
                origin = shape.origin or structure.origin or top
                if shape.material is None or (_format(origin) == "mjcf" and _is_default_grey(plan, shape)):
                    for index in list_indices(geometry.file):
                        yield index, origin.child("file")


def _format(origin: Origin) -> object:
    """Returns the key of the scene that names a robot's file, for a shape in it."""
    return None if origin.parent is None else origin.parent.path[-1]


def _is_default_grey(plan: ScenePlan, shape: VisualShape) -> bool:
    """Returns whether a shape of an MJCF has no material and MuJoCo's default `rgba`."""
    assert shape.material is not None
    material = plan.visual_materials[list_indices(shape.material)[0]]
    color = material.base_color
    return (
        not any(material.textures()) and color is not None and [*color.numbers()] == [*[srgb_to_linear(0.5)] * 3, 1.0]
    )


def _check_vertex_colors(checker: _AssetChecker, asset: AssetFile, origin: Origin) -> None:
    try:
        colored = checker.files.mesh(asset).vertex_colors
    except AssetError:
        return  # it was reported
    if colored:
        message = f"{asset.uri} has colours at its vertices, which SAPIEN does not render: it is grey"
        one = {"urdf": "a `<material>`", "mjcf": "an `rgba`"}.get(str(_format(origin)), "a `color`")
        hint = f"give it {one}, or bake the colours to a texture"
        checker.sink.report("SC587", message, origin, hint=hint)


def _textures(plan: ScenePlan) -> Iterator[tuple[int, str, Origin]]:
    """Yields every image, the material field that names it ("" for lights and environments), and one place of use."""
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
    """Yields the files of lights and environments."""
    surroundings = plan.environment and plan.environment.map
    if surroundings is not None:
        for item in fields(surroundings):
            yield from list_indices(getattr(surroundings, item.name))
    for light in plan.lights:
        if isinstance(light.light, TexturedLight):
            yield from list_indices(light.light.texture.file)


def _check_mesh(checker: _AssetChecker, asset: AssetFile, by_use: dict[MeshUse, Origin]) -> dict[str, Path]:
    """Checks a mesh for all its uses. Returns the referenced files that a build opens, by name."""
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
    """Checks the files that an asset references. Those that a build opens are added to `named`."""
    visual = by_use.get("visual")
    origin = visual or next(iter(by_use.values()))
    references = [one for one in mesh.names if one.kind != "buffer"]
    images: dict[str, tuple[AssetReference, ...]] = {}  # by SHA-256: a mesh may name an MTL in many ways
    for reference in references:  # the list grows
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
                    with _add_image_name(reference):
                        _check_optional(checker, asset, reference, fault, visual)
                    continue
            elif reference.kind in {"material", "fallback"} and any(use != "decomposed" for use in by_use):
                # The engine also reads an MTL for a collision mesh, or whatever it takes for a missing one, and fails
                # if it cannot. It opens images only for visual meshes. A decomposition reads neither.
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
    """Raises the error of a referenced file, unless it is not rendered or `repair` allows it to be missing."""
    missing = isinstance(fault, MissingError)
    if visual is None:
        unused = missing or (fault.code == "SC418" and reference.kind == "image")
        if reference.kind == "buffer" or not unused:
            raise fault
        return
    # A build ignores images only in an OBJ. For other formats, SAPIEN opens them at the first picture.
    if reference.kind == "image" and Path(asset.path).suffix.lower() != ".obj":
        repaired = missing and asset.optional_names
        raise AssetError(fault.code, fault.message, _ONLY_OF_OBJ) if repaired else fault
    unread = reference.kind == "image" and fault.code in _UNREAD_IMAGE
    if reference.kind == "buffer" or not (missing or unread):
        raise fault
    if not asset.optional_names:
        raise _add_repair_hint(fault, visual)
    why = "is missing" if missing else f"cannot be used ({fault.message})"
    message = f"{asset.uri} references `{reference.uri[:60]}`, which {why}; it is ignored"
    checker.left_out.setdefault((visual.parent, reference.kind, missing), []).append((message, visual))


_ONLY_OF_OBJ = "`repair: [files]` ignores only images of OBJ meshes: add the image, or export the mesh as OBJ"

_UNREAD_IMAGE = {"SC410", "SC420"}
"""Codes of images that exist but cannot be read."""


def _add_repair_hint(fault: AssetError, origin: Origin) -> AssetError:
    """Adds a hint at `repair` to the error of a missing file, if a URDF names the mesh."""
    by = origin.parent.path[-1:] if origin.parent is not None else ()
    if by != ("urdf",):
        return fault
    repair = "add `repair: [files]` to ignore it"
    return AssetError(fault.code, fault.message, repair if fault.hint is None else f"{fault.hint}; {repair}")


@contextmanager
def _add_image_name(reference: AssetReference) -> Generator[None, None, None]:
    """Adds the image's name to an `AssetError` raised inside, which is reported for the mesh."""
    try:
        yield
    except AssetError as fault:
        raise AssetError(fault.code, f"its image `{reference.uri[:60]}`: {fault.message}", fault.hint) from fault


@contextmanager
def _report_asset_errors(checker: _AssetChecker, asset: AssetFile, origin: Origin) -> Generator[None, None, None]:
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
        raise AssetError("SC410", f"{kind} that SAPIEN reads", "save it as PNG or JPEG")
    checker.files.image(path)


_GREY_RESULTS = {
    "base_color_texture": "the shape is invisible",
    "emission_texture": "there is no emission",
    "normal_texture": "the normals are wrong",
}
"""What SAPIEN 3.0 renders if a three-channel texture has only one channel; other textures use only one."""


def _check_colors(checker: _AssetChecker, asset: AssetFile, slots: Mapping[str, Origin]) -> None:
    """Warns of a grey image where SAPIEN needs three channels. `slots`: the field → a place that uses it."""
    if not checker.files.image(asset.path).grey:
        return
    for slot, place in slots.items():
        if slot in _GREY_RESULTS:
            # Another slot may have used the file first.
            origin = asset.origin if asset.origin is not None and slot in asset.origin.path else place
            message = f"{asset.uri} is a grey image, which SAPIEN reads as red only: as {slot}, {_GREY_RESULTS[slot]}"
            checker.sink.report("SC424", message, origin, hint="save it in colour (RGB)")


def _report(sink: Sink, asset: AssetFile, origin: Origin, fault: AssetError) -> None:
    sink.report(fault.code, f"{asset.uri}: {fault.message}", origin, hint=fault.hint)
