"""Checks of the files that a plan uses: what SAPIEN would drop, build wrongly or fail on.

Each file is read once, however many shapes use it, and reported at the first shape that its fault concerns.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from urllib.parse import unquote

from scenecc.checks.asset_image import IMAGE_SUFFIXES, check_image, image_size
from scenecc.checks.judged import rows
from scenecc.checks.mesh_data import AssetError, MeshData, Reading, Reference
from scenecc.checks.mesh_mtl import mtl_images
from scenecc.checks.mesh_read import MESH_SUFFIXES, SEEN_SUFFIXES, read_mesh
from scenecc.checks.mesh_rules import check_use
from scenecc.diagnostics import Origin
from scenecc.plan import ConvexMesh, ConvexParts, CubeMap, Mesh, MeshGeometry, SkyMap, TexturedLight, TriangleMesh

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import AssetFile, ScenePlan, Value, VisualMaterial

Use = Literal["hull", "parts", "triangles", "seen", "decomposed", "texture"]
"""What a file is for: a hull, the hulls of its parts, its triangles, a picture, a decomposition, a texture."""

ResolveNamed = Callable[[str, "AssetFile"], "Path | tuple[str, str, str | None]"]
"""Finds a file that an asset names: its path, or why it may not be read (code, message, hint)."""

_USD = (".usd", ".usda", ".usdc", ".usdz")


@dataclass(frozen=True, slots=True)
class _Checker:
    sink: Sink
    resolve_named: ResolveNamed
    max_bytes: int


def check_assets(
    plan: ScenePlan,
    sink: Sink,
    *,
    resolve_named: ResolveNamed,
    max_asset_bytes: int = 256 * 2**20,
    file_origins: Mapping[int, Origin] | None = None,
) -> None:
    """Reports every file of a plan that SAPIEN could not use as the plan says.

    Args:
        plan: its `files` are read from their `path`.
        sink: where faults go.
        resolve_named: finds the files that an asset names (MTL, textures, buffers), inside what the scene may read.
        max_asset_bytes: the limit `asset_bytes`, of a file and of what it unpacks to [bytes].
        file_origins: the node that names a file, by its index in `plan.files`. Textures are reported there; without
            it, at the first shape that uses the material.
    """
    checker = _Checker(sink, resolve_named, max_asset_bytes)
    uses: dict[int, dict[Use, Origin]] = {}
    for index, use, origin in _uses(plan, file_origins or {}):
        uses.setdefault(index, {}).setdefault(use, origin)
    for index, by_use in uses.items():
        asset = plan.files[index]
        if "texture" in by_use:
            with _reporting(checker, asset, by_use["texture"]):
                _check_texture(checker, Path(asset.path))
        by_use.pop("texture", None)
        if by_use:
            _check_mesh(checker, asset, by_use)
    if plan.environment is not None and plan.environment.map is not None and not sink.failed:
        place = plan.environment.origin or plan.origin or Origin(None)
        if isinstance(plan.environment.map, CubeMap):
            _check_faces(plan, plan.environment.map, place.child("map"), sink)
        else:
            _check_sky(plan, plan.environment.map, place.child("map"), sink)


def _uses(plan: ScenePlan, origins: Mapping[int, Origin]) -> Iterator[tuple[int, Use, Origin]]:
    """What every file is for, and where it is named."""
    top = plan.origin or Origin(None)
    for file in _of_pictures(plan):
        yield file, "texture", origins.get(file, top)
    for structure in (body for entity in plan.entities for body in entity.bodies):
        for shape in (*structure.collisions, *structure.visuals):
            geometry = shape.geometry
            if isinstance(geometry, MeshGeometry):
                for index in _indices(geometry.file):
                    yield index, _use(geometry), (shape.origin or structure.origin or top).child("file")
        for shape in structure.visuals:
            for index in _indices(shape.material) if shape.material is not None else ():
                place = (shape.origin or structure.origin or top).child("material")
                for file in _textures(plan.visual_materials[index]):
                    yield file, "texture", origins.get(file, place)


def _of_pictures(plan: ScenePlan) -> Iterator[int]:
    """The files of lights and of what surrounds the scenes."""
    surroundings = plan.environment and plan.environment.map
    if surroundings is not None:
        for field in fields(surroundings):
            yield from _indices(getattr(surroundings, field.name))
    for light in plan.lights:
        if isinstance(light.light, TexturedLight):
            yield from _indices(light.light.texture.file)


def _check_faces(plan: ScenePlan, surroundings: CubeMap, origin: Origin, sink: Sink) -> None:
    """That six pictures make a cube in every scene: they have one size, and one kind of pixels."""
    faces = [getattr(surroundings, field.name) for field in fields(surroundings)]
    found = rows(faces)
    # Of what is drawn any may meet any.
    sides = [[index for face in faces for index in _indices(face)]] if found is None else found
    for side in sides:
        indices = [int(index[0]) if isinstance(index, tuple) else index for index in side]
        sizes = {index: image_size(Path(plan.files[index].path)) for index in dict.fromkeys(indices)}
        few = next((index for index in indices if not sizes[index].has_all_levels), None)
        if few is not None:
            message = f"a side of a cube has levels down to one pixel, or none, and {plan.files[few].uri} has fewer"
            sink.report("SC553", message, origin)
            return
        first = indices[0]
        other = next((index for index in indices if sizes[index] != sizes[first]), None)
        if other is not None:
            a, b = (f"{plan.files[index].uri} ({sizes[index]})" for index in (first, other))
            sink.report("SC553", f"the sides of a cube are alike, and {a} and {b} are not", origin)
            return


def _check_sky(plan: ScenePlan, surroundings: SkyMap, origin: Origin, sink: Sink) -> None:
    """That one picture holds the whole sphere: a turn from left to right, and half a one from top to bottom."""
    for index in _indices(surroundings.file):
        size = image_size(Path(plan.files[index].path))
        if size.levels and not (size.sides == 6 and size.columns == size.rows and size.has_all_levels):
            what = "a KTX of all directions has six square sides, and levels down to one pixel"
            hint = "make it with its mipmaps, or take one picture in PNG, HDR or EXR"
            sink.report("SC554", f"{what}; {plan.files[index].uri} has not", origin, hint=hint)
            return
        if not size.levels and size.columns != 2 * size.rows:
            message = f"a map of all directions is twice as wide as it is high, and {plan.files[index].uri} is not"
            sink.report("SC554", f"{message} ({size})", origin, hint="six pictures are written {px: …, nx: …, …}")
            return


def _indices(value: Value) -> list[int]:
    """Every alternative of a table index, by first use."""
    return list(dict.fromkeys(map(int, value.numbers())))


def _use(geometry: MeshGeometry) -> Use:
    match geometry:
        case ConvexMesh():
            return "hull"
        case ConvexParts():
            return "parts" if geometry.coacd is None else "decomposed"
        case TriangleMesh():
            return "triangles"
        case Mesh():
            return "seen"


def _textures(material: VisualMaterial) -> Iterator[int]:
    for texture in material.textures().values():
        yield from _indices(texture.file)


def _check_mesh(checker: _Checker, asset: AssetFile, by_use: dict[Use, Origin]) -> None:
    first = next(iter(by_use.values()))
    seen = by_use.get("seen")
    try:
        mesh = _read(checker, asset)
    except AssetError as fault:
        _report(checker, asset, first, fault)
        return
    _check_named(checker, asset, mesh, seen, first)
    suffix = Path(asset.path).suffix.lower()
    told: set[str] = set()
    for use, origin in by_use.items():
        if suffix in SEEN_SUFFIXES and use != "seen":
            hint = f"convert it to one of {', '.join(MESH_SUFFIXES)}, or give a shape that collides a mesh of its own"
            _report(
                checker, asset, origin, AssetError("SC410", f"a `{suffix}` is only seen, and does not collide", hint)
            )
            continue
        for fault in check_use(mesh, use, suffix):
            if fault.code not in told:
                told.add(fault.code)
                _report(checker, asset, origin, fault)


def _read(checker: _Checker, asset: AssetFile) -> MeshData:
    suffix = Path(asset.path).suffix.lower()
    if suffix in _USD:
        raise AssetError(
            "SC411",
            "SAPIEN converts USD and writes the result beside the file",
            "convert it to GLB once, and name that",
        )
    if suffix not in (*MESH_SUFFIXES, *SEEN_SUFFIXES):
        kind = f"`{suffix}` is no mesh format" if suffix else "a file without a suffix is no mesh"
        raise AssetError("SC410", f"{kind} that is read", f"convert it to one of {', '.join(MESH_SUFFIXES)}")
    reading = Reading(
        open_named=lambda reference: _bytes(checker, _named(checker, asset, reference)),
        max_bytes=checker.max_bytes,
    )
    return read_mesh(_bytes(checker, Path(asset.path)), suffix, reading)


def _check_named(checker: _Checker, asset: AssetFile, mesh: MeshData, seen: Origin | None, first: Origin) -> None:
    """The files that an asset names. The engine opens them whether it is seen or not, so none may be outside."""
    origin = seen or first
    waiting = list(mesh.references)
    while waiting:
        reference = waiting.pop(0)
        with _reporting(checker, asset, origin, skip="SC418" if seen is None and reference.kind != "buffer" else None):
            path = _named(checker, asset, reference)
            if reference.kind == "material":
                # The engine reads it for what collides, too, and gives up where it cannot.
                waiting.extend(mtl_images(_bytes(checker, path)))
            if reference.kind == "image" and seen is not None:
                _check_texture(checker, path)
    for image in mesh.images if seen is not None else ():
        with _reporting(checker, asset, origin):
            check_image(io.BytesIO(image), checker.max_bytes)


@contextmanager
def _reporting(
    checker: _Checker, asset: AssetFile, origin: Origin, *, skip: str | None = None
) -> Generator[None, None, None]:
    """Reports the fault that is raised inside, but for one code (what is not there is not missed by a collision)."""
    try:
        yield
    except AssetError as fault:
        if fault.code != skip:
            _report(checker, asset, origin, fault)


def _named(checker: _Checker, asset: AssetFile, reference: Reference) -> Path:
    """The path of a file that an asset names."""
    found = checker.resolve_named(unquote(reference.uri) if reference.escaped else reference.uri, asset)
    if not isinstance(found, Path) and found[0] in {"SC402", "SC403"}:
        raise AssetError("SC419", f"it names a file that cannot be used: {found[1]}", found[2])
    if reference.escaped:
        raise AssetError(
            "SC418",
            f"it names `{reference.uri[:60]}`, and SAPIEN does not decode percent escapes",
            "rename the file so that its name needs none, and export the asset again",
        )
    if not isinstance(found, Path):
        raise AssetError("SC418", f"it names a file that cannot be used: {found[1]}", found[2])
    return found


def _check_texture(checker: _Checker, path: Path) -> None:
    suffix = path.suffix.lower()
    if suffix not in IMAGE_SUFFIXES:
        kind = f"`{suffix}` is no image format" if suffix else "a file without a suffix is no image"
        raise AssetError("SC410", f"{kind} that is read, in {path.name}", "save it as PNG or JPEG")
    _check_size(checker, path)
    try:
        with path.open("rb") as file:
            check_image(file, checker.max_bytes, path.suffix)
    except OSError as error:
        raise AssetError("SC407", f"{path.name} may not be read: {error.strerror}") from error


def _bytes(checker: _Checker, path: Path) -> bytes:
    _check_size(checker, path)
    try:
        with path.open("rb") as file:
            return file.read(checker.max_bytes + 1)
    except OSError as error:
        raise AssetError("SC407", f"{path.name} may not be read: {error.strerror}") from error


def _check_size(checker: _Checker, path: Path) -> None:
    try:
        size = path.stat().st_size
    except OSError as error:
        raise AssetError("SC407", f"{path.name} may not be read: {error.strerror}") from error
    if size > checker.max_bytes:
        raise AssetError(
            "SC607",
            f"{path.name} has {size} bytes, and the limit asset_bytes is {checker.max_bytes}",
            "make it smaller, or raise the limit with --limit asset_bytes=N",
        )


def _report(checker: _Checker, asset: AssetFile, origin: Origin, fault: AssetError) -> None:
    checker.sink.report(fault.code, f"{asset.uri}: {fault.message}", origin, hint=fault.hint)
