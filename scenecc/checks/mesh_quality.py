"""Checks for doubtful meshes, which the engine accepts but which do not suit their use in the scene.

Only `scenecc check` applies these rules. A purely visual mesh need not be watertight, and winding does not matter for a
convex hull, so a rule checks only the relevant uses. Robot files are not checked.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.meshes import checked_content, read_hulls
from scenecc.assets.surface_measures import SurfaceMeasures, measure_surface
from scenecc.checks.boxes import bounding_box, corners, local_box, shape_box
from scenecc.checks.mass import DYNAMIC_TYPES
from scenecc.checks.physics import plan_origin
from scenecc.checks.plausibility import MAX_SIZE, Body, scene_bodies
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.plan import BodyStructure, ConvexMesh, ConvexParts, Mesh, MeshGeometry, TriangleMesh
from scenecc.plan.geometry import Primitive, Solid
from scenecc.plan.properties import DEFAULT_DENSITY

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.checks.boxes import Box
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import AssetFile, CollisionShape, ScenePlan, VisualShape

MAX_FREE_SIZE: Final = 5.0
"""[m] Length of a mesh on a free body: a car."""

SAME: Final = 0.03
"""Relative tolerance of extents that are meant to be equal."""

MOVED: Final = 0.1
"""Minimum distance of a visual from its collision shape, relative to their size."""

TURNED: Final = 0.01
"""Minimum distance of a visual's corners from those of its collision shape, of the same file and scale, relative to
their size."""

SCALED: Final = 1.4
"""Minimum ratio of a visual and its collision shape that is equal along all axes."""

MIN_SIZE: Final = 1e-3
"""[m] A mesh below a millimetre was probably modelled in another unit."""

FAR: Final = 10.0
"""Maximum distance of a mesh from its body's origin, in diagonals of its box."""

HULL_RATIO: Final = 2.5
"""Volume of a hull relative to its mesh: 3 and more for a mug, 5 for a chair."""

LEAST_MOMENT: Final = 1e-6
"""[kg·m²] SAPIEN's minimum moment of inertia for masses from densities (measured). Reported from ten times the possible
moment: cubes of 15 mm in ManiSkill's tasks have four times theirs."""

BARE: Final = 0.1
"""Minimum size of a visual part without collision, and its minimum distance from the rest, in sizes of its body."""

DEGENERATE: Final = 0.1
"""Share of triangles without area from which it is reported."""


def check_meshes(plan: ScenePlan, sink: Sink) -> None:
    """Applies every rule of this module.

    Args:
        plan: a plan with its draws, whose files were checked.
        sink: collects diagnostics.
    """
    _check_file_names(plan, sink)
    for body in scene_bodies(plan):
        try:
            for shape in (*body.structure.collisions, *body.structure.visuals):
                if isinstance(shape.geometry, MeshGeometry):
                    _check_mesh(body, shape, plan, sink)
            _check_overlap(body, plan, sink)
            _check_least_moment(body, plan, sink)
        except AssetError as fault:  # noqa: PERF203 - the file changed since it was checked
            sink.report(fault.code, fault.message, body.origin, hint=fault.hint)


def _check_file_names(plan: ScenePlan, sink: Sink) -> None:
    first: dict[str, str] = {}
    for index, file in enumerate(plan.files):
        for name in dict.fromkeys([str(file.path), *(str(one.path) for one in file.names)]):
            other = first.setdefault(name.casefold(), name)
            if other != name:
                place = _file_origin(plan, index)
                message = f"{cut(file.uri)} and `{cut(other)}` differ only in case"
                sink.report("SC443", message, place, hint="on Windows and macOS both are one file: rename one")


def _file_origin(plan: ScenePlan, index: int) -> Origin:
    """Returns the origin of the first shape that uses a file."""
    for entity in plan.entities:
        for body in entity.bodies:
            for shape in (*body.collisions, *body.visuals):
                named = shape.geometry.file.data if isinstance(shape.geometry, MeshGeometry) else ()
                if index in named and shape.origin is not None:
                    return shape.origin.child("file")
    return plan_origin(plan)


def _check_mesh(body: Body, shape: CollisionShape | VisualShape, plan: ScenePlan, sink: Sink) -> None:
    """Checks one mesh in one use, with each file and scale that it has in a scene."""
    geometry: Any = shape.geometry
    place = (shape.origin or body.origin).child("file")
    for index in np.unique(geometry.file.data):
        file = plan.files[int(index)]
        measures = measure_surface(file)
        for code, message, hint in (
            *_surface_faults(geometry, file.path.suffix.lower(), measures, body),
            *_hull_faults(geometry, file, measures),
            *_size_faults(shape, measures, body),
        ):
            sink.report(code, f"{cut(file.uri)} {message}", place, hint=hint)


_Fault = tuple[str, str, str]
"""Code, message without the file, and hint."""


def _surface_faults(geometry: MeshGeometry, suffix: str, measures: SurfaceMeasures, body: Body) -> Iterator[_Fault]:
    solid = isinstance(geometry, TriangleMesh) and geometry.sdf
    raw = isinstance(geometry, ConvexParts) and geometry.coacd is not None and geometry.coacd.preprocess_mode == "off"
    if (solid or raw) and not measures.is_watertight:
        edges = f"{measures.open_edges} open edges and {measures.crowded_edges} with three or more triangles"
        what = "a signed distance field" if solid else "CoACD without preprocessing"
        hint = "close it in your modelling program, or use `convex_parts` with `coacd`"
        yield "SC434", f"is not watertight ({edges}), and {what} needs an inside", hint
    # The faces of a visual room point inwards.
    sided = isinstance(geometry, Mesh) and body.structure.body_type in DYNAMIC_TYPES
    if isinstance(geometry, TriangleMesh) and not measures.consistent:
        yield "SC435", "has neighbouring triangles with opposite winding", "recompute its normals"
    elif (sided or isinstance(geometry, TriangleMesh)) and measures.is_watertight and measures.volume < 0:
        yield "SC435", "is inside out: its triangles face inwards", "flip its normals"
    if isinstance(geometry, TriangleMesh) and measures.degenerate > DEGENERATE * measures.faces:
        message = f"has {measures.degenerate} triangles without area, of {measures.faces}"
        yield "SC436", message, "merge its vertices by distance, and remove degenerate triangles"
    if isinstance(geometry, ConvexMesh | ConvexParts) and suffix == ".ply" and measures.beyond > 0:
        # Measured with one file per format: SAPIEN keeps unused vertices only of a PLY.
        message = f"has {measures.unused} vertices that no triangle uses, up to {measures.beyond:.3g} m outside of it"
        yield "SC440", f"{message}, and the hull includes them", "remove loose vertices in your modelling program"


def _hull_faults(geometry: MeshGeometry, file: AssetFile, measures: SurfaceMeasures) -> Iterator[_Fault]:
    """Yields faults of hulls that fill cavities."""
    whole, parts = isinstance(geometry, ConvexMesh), isinstance(geometry, ConvexParts) and geometry.coacd is None
    # Closed parts that share edges still have a volume.
    if not (whole or parts) or measures.open_edges or measures.volume <= 0:
        return
    hulls = [measures.hull_volume]
    if parts:
        hulls = [hull.hull_volume or 0 for hull in read_hulls(checked_content(file), parts=True)]
    ratio = sum(hulls) / measures.volume
    if ratio > HULL_RATIO:
        has = "has a hull" if whole else f"has {len(hulls)} convex part{'s' * (len(hulls) > 1)}"
        what = "`decomposition: coacd`" if parts else "`convex_parts` with `decomposition: coacd`"
        yield (
            "SC439",
            f"{has} with {ratio:.1f} times its volume, which is used for collision",
            f"use {what} to keep its cavities",
        )


def _size_faults(shape: CollisionShape | VisualShape, measures: SurfaceMeasures, body: Body) -> Iterator[_Fault]:
    geometry: Any = shape.geometry
    scales = np.abs(geometry.scale.data)
    extents = (np.array(measures.high) - measures.low) * scales
    longest = extents.max(axis=1)
    if longest.min() < MIN_SIZE:
        yield "SC437", f"is {longest.min() * 1e6:.3g} µm long here", "lengths are in metres: change `scale`"
    if body.structure.body_type not in DYNAMIC_TYPES:
        return
    if longest.max() > (MAX_FREE_SIZE if body.structure.body_type == "dynamic" else MAX_SIZE):
        hint = "lengths are in metres: for millimetres write `scale: [0.001, 0.001, 0.001]`"
        yield "SC437", f"is {longest.max():.4g} m long here, on a moving body", hint
        return
    centre = (np.array(measures.high) + measures.low) / 2 * geometry.scale.data
    away, diagonal = np.linalg.norm(centre, axis=1), np.linalg.norm(extents, axis=1)
    if body.structure.body_type == "dynamic" and shape.pose is None and (away > np.maximum(FAR * diagonal, 1)).any():
        message = f"is {away.max():.3g} m from the origin of its body, but only {diagonal.max():.2g} m large"
        yield "SC438", message, "export it around its own centre, or move it back with the `pose` of the shape"


def _check_overlap(body: Body, plan: ScenePlan, sink: Sink) -> None:
    """Checks that the visual and collision shapes of a body are in the same place in each scene, by their boxes."""
    structure = body.structure
    if not (structure.collisions and structure.visuals):
        return
    shapes = [*structure.collisions, *structure.visuals]
    has_mesh = any(isinstance(shape.geometry, MeshGeometry) for shape in shapes)
    written = {shape.origin for shape in structure.collisions} - {None}
    if not has_mesh and {shape.origin for shape in structure.visuals} <= written:
        return  # each is under `shapes`, which does both
    varies = any(value.varies for shape in shapes for value in _values(shape))
    for row in range(len(body.entity.scene_idxs) if varies else 1):
        boxes = [
            [local_box(shape, row, plan) for shape in group] for group in (structure.collisions, structure.visuals)
        ]
        if any(box is None for group in boxes for box in group):
            return  # terrain and planes reach far
        solid, seen = ([box for box in group if box is not None] for group in boxes)
        gap = _gap(bounding_box(solid), bounding_box(seen))
        if gap > 0:
            message = f"the visuals of `{cut(body.name)}` are {gap:.3g} m away from its collision shapes"
            sink.report("SC441", message, body.origin, at="key", hint=_SAME_PLACE)
            return
        fault = _misfit(structure, bounding_box(solid), bounding_box(seen), row, plan)
        if fault is not None:
            message = f"the visual of `{cut(body.name)}` is {fault} its collision shape"
            sink.report("SC441", message, body.origin, at="key", hint=_SAME_PLACE)
            return
        if not has_mesh:
            continue  # bodies made of boxes and spheres often have decorations
        size = np.linalg.norm(np.ptp(bounding_box([*solid, *seen]), axis=0))
        for shape, box in zip(structure.visuals, seen, strict=True):
            apart = min(_gap(one, box) for one in solid)
            if apart > BARE * size and np.linalg.norm(np.ptp(box, axis=0)) > BARE * size:
                message = f"this visual of `{cut(body.name)}` is {apart:.3g} m from all its collision shapes"
                hint = "add a collision shape for it if objects may touch it"
                sink.report("SC442", message, shape.origin or body.origin, hint=hint)
                return


_SAME_PLACE: Final = "check that both have the same `scale` and `pose`"


def _misfit(structure: BodyStructure, solid: Box, seen: Box, row: int, plan: ScenePlan) -> str | None:
    """Returns how a visual differs from the collision shape that it shows; None if it is in the same place.

    Compares a visual and a collision shape of the same file, or the boxes around all shapes if there is one visual or
    one collision shape.
    """
    pairs = list(_same_files(structure))
    for pair in pairs:
        one, other = (_corners(shape, row, plan) for shape in pair)
        size = float(np.linalg.norm(one[-1] - one[0]))
        ratio = float(np.linalg.norm(other[-1] - other[0])) / size
        if abs(ratio - 1) > SAME:
            if len(pairs) == len(structure.collisions) == len(structure.visuals) == 1:
                return f"{ratio:.3g} times as large as"
        elif np.linalg.norm(one - other, axis=1).max() > (TURNED if abs(ratio - 1) < 1e-6 else MOVED / 2) * size:
            return "turned or moved against"
    if pairs or min(len(structure.collisions), len(structure.visuals)) > 1:
        return None
    return _box_misfit(solid, seen)


def _same_files(structure: BodyStructure) -> Iterator[tuple[CollisionShape, VisualShape]]:
    """Yields the collision shape and the visual of each mesh that has one of both."""
    solid = [shape for shape in structure.collisions if isinstance(shape.geometry, MeshGeometry)]
    seen = [shape for shape in structure.visuals if isinstance(shape.geometry, MeshGeometry)]
    uses = Counter(map(_file, solid)), Counter(map(_file, seen))
    for one in solid:
        if uses[0][_file(one)] == uses[1][_file(one)] == 1:
            yield one, next(other for other in seen if _file(other) == _file(one))


def _box_misfit(solid: Box, seen: Box) -> str | None:
    """As `_misfit`, of the boxes around all shapes."""
    extents = np.maximum([solid[1] - solid[0], seen[1] - seen[0]], 1e-9)
    ratios, ordered = extents[1] / extents[0], np.sort(extents, axis=1)
    if (np.abs(ratios - 1) < SAME).all():
        apart = float(np.linalg.norm((solid[0] + solid[1] - seen[0] - seen[1]) / 2))
        return f"{apart:.3g} m away from" if apart > MOVED * np.linalg.norm(extents[0]) else None
    if (np.abs(ordered[1] / ordered[0] - 1) < SAME).all():
        return "turned against"
    ratio, same = float(ratios.mean()), ratios.max() < ratios.min() * (1 + SAME)
    return f"{ratio:.3g} times as large as" if same and not 1 / SCALED < ratio < SCALED else None


def _file(shape: CollisionShape | VisualShape) -> int:
    geometry: Any = shape.geometry
    return int(geometry.file.row(0))


def _corners(shape: CollisionShape | VisualShape, row: int, plan: ScenePlan) -> NDArray[np.float64]:
    """Returns the corners (8, 3) of a mesh's box in the frame of its body, in a fixed order."""
    box = shape_box(shape.geometry, row, plan)
    assert box is not None
    matrix = np.eye(4) if shape.pose is None else pose_matrix(shape.pose.row(row).tolist())
    return corners(box) @ matrix[:3, :3].T + matrix[:3, 3]


def _check_least_moment(body: Body, plan: ScenePlan, sink: Sink) -> None:
    """Reports bodies so small or thin that the engine's minimum moment of inertia exceeds what their mass allows.

    A steel pin, 100 mm long and 1 mm thick, would rotate about its axis 10 000 times too slowly.
    """
    structure = body.structure
    if structure.body_type not in DYNAMIC_TYPES or structure.inertial is not None or not structure.collisions:
        return
    boxes = [local_box(shape, 0, plan) for shape in structure.collisions]
    volumes = [_volume(shape, plan) for shape in structure.collisions]
    solid = [box for box in boxes if box is not None]
    if len(solid) < len(boxes) or None in volumes:
        return
    weights = [
        (volume or 0.0) * (DEFAULT_DENSITY if shape.density is None else float(shape.density.row(0)))
        for shape, volume in zip(structure.collisions, volumes, strict=True)
    ]
    mass, half = sum(weights), np.ptp(bounding_box(solid), axis=0) / 2
    # The moment is largest with all mass at the corners of the bounding box.
    least = mass * float((half @ half - half**2).min())
    if 0 < least < LEAST_MOMENT / 10:
        message = (
            f"`{cut(body.name)}` weighs {mass * 1000:.3g} g by its shapes, but SAPIEN sets its moments of inertia to "
            f"at least 1e-06 kg·m²; about one of its axes, at most {least:.2g} is possible"
        )
        hint = "set its moments under `inertial`, which are used unchanged"
        sink.report("SC572", message, body.origin, at="key", hint=hint)


def _volume(shape: CollisionShape, plan: ScenePlan) -> float | None:
    """Returns the volume of a shape in its first scene [m³]; None if unknown."""
    geometry: Any = shape.geometry
    if isinstance(geometry, ConvexMesh):
        file = plan.files[int(geometry.file.row(0))]
        return measure_surface(file).hull_volume * float(np.abs(geometry.scale.row(0)).prod())
    return float(geometry.volume(*geometry.sizes(0))) if isinstance(geometry, Solid) else None


def _gap(one: Box, other: Box) -> float:
    """Returns the gap between two boxes along the axis where it is largest [m]; negative if they overlap."""
    return float(np.maximum(one[0] - other[1], other[0] - one[1]).max())


def _values(shape: CollisionShape | VisualShape) -> Iterator[Any]:
    geometry: Any = shape.geometry
    yield from () if shape.pose is None else (shape.pose,)
    if isinstance(geometry, MeshGeometry):
        yield from (geometry.file, geometry.scale)
    elif isinstance(geometry, Primitive):
        yield from geometry.values
