"""Geoms of a compiled model as shapes, and meshes without a file."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.colors import srgb_to_linear
from scenecc.files import keep_file
from scenecc.geometry.ply import encode_ply
from scenecc.geometry.rotations import Pose7, to_vector
from scenecc.geometry.surfaces import ellipsoid_surface
from scenecc.plan.geometry import MAX_HEIGHTS, MAX_TOTAL_HEIGHTS
from scenecc.robots.description import (
    DescribedCollision,
    DescribedMaterial,
    DescribedTexture,
    DescribedVisual,
    Geometry,
    HeightfieldGeometry,
    MeshGeometry,
    PlaneGeometry,
    SolidGeometry,
)
from scenecc.robots.mujoco.contacts import MAX_BITS
from scenecc.robots.mujoco.model import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HFIELD,
    MESH,
    PLANE,
    SDF,
    SPHERE,
    CompiledModel,
    invert_pose,
)
from scenecc.robots.poses import compose_poses, pose_numbers

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Location
    from scenecc.robots.mjcf_files import MjcfReport

MIN_EXTENT: Final = 1e-5
"""Half extent up to which a mesh counts as flat along an axis [m]."""


def numeric_mesh(
    name: str, vertices: NDArray[Any], triangles: NDArray[Any], normals: Any = None, uvs: Any = None
) -> MeshGeometry:
    """Returns a mesh from arrays. It collides as its convex hull, unless the scene decomposes meshes.

    It is stored as a PLY in the user's cache folder under its hash, so that equal meshes are cooked once, and is saved
    with the plan. Its axes are normalized to a length of 2, and the scale restores its size: PhysX merges hull vertices
    within 0.7 mm before scaling, so small and oblong meshes would lose half of their mass.

    Args:
        name: name for messages.
        vertices: (V, 3) [m].
        triangles: (T, 3) vertex indices, counterclockwise from outside.
        normals: (V, 3) unit vectors; None: each vertex gets that of one of its triangles.
        uvs: (V, 2) texture coordinates from the image's top left corner.

    Raises:
        OSError: the cache folder is not writable.
    """
    extent = np.ptp(vertices, axis=0) / 2
    scale = np.where(extent > MIN_EXTENT, extent, 1.0)
    if normals is not None:
        normals = normals * scale
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    data = encode_ply(vertices / scale, triangles, normals, uvs)
    uri = f"mesh://{re.sub(r'[^A-Za-z0-9_.-]', '_', name)[:80]}.ply"
    return MeshGeometry(uri, keep_file("meshes", data, ".ply"), to_vector(scale), data=data)


_X_TO_Z = pose_numbers((0.0, 0.0, 0.0), (0.7071067811865476, 0.0, -0.7071067811865476, 0.0))
"""From SAPIEN's planes and round solids (axis x) to MuJoCo's (axis z)."""

_SOLIDS = {BOX: ("box", 3), SPHERE: ("sphere", 1), CAPSULE: ("capsule", 2), CYLINDER: ("cylinder", 2)}
"""MuJoCo geom type → SAPIEN's name and number of sizes."""

_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default geom colour; the material's colour is used instead."""

VISUAL_GROUPS: Final = (0, 1, 2)
"""Groups of geoms that MuJoCo's viewer shows by default."""

_MESH_FILES = frozenset({".obj", ".stl"})
"""Formats that SAPIEN reads in the same way as MuJoCo."""

_FRICTIONLESS = 1
"""`condim` of frictionless contacts."""

_COLOR_ROLE = 1
"""`mjTEXROLE_RGB`."""


def _can_be_read(path: Path, data: bytes) -> bool:
    """Returns whether SAPIEN can read a mesh. MuJoCo makes the hull of an OBJ without faces."""
    return path.suffix.lower() in _MESH_FILES and (path.suffix.lower() != ".obj" or b"\nf" in data)


class MjcfShapeReader:
    """Reads the geoms of a compiled model.

    Args:
        model: the compiled model.
        report: receives the findings.
        visual_groups: visible geom groups.
    """

    def __init__(self, model: CompiledModel, report: MjcfReport, visual_groups: Collection[int]) -> None:
        self._model = model
        self._report = report
        self._visual_groups = visual_groups
        self._meshes: dict[int, MeshGeometry] = {}
        self._height_fields: dict[int, HeightfieldGeometry] = {}
        self._height_count = 0
        self._looks: dict[tuple[int, tuple[float, ...]], DescribedMaterial] = {}

    def of_geoms(
        self, geoms: Sequence[tuple[int, Pose7]]
    ) -> tuple[tuple[DescribedCollision, ...], tuple[DescribedVisual, ...]]:
        """Returns the collision and visual shapes of geoms, each given with the pose of its frame in the link."""
        model = self._model
        collisions: list[DescribedCollision] = []
        visuals: list[DescribedVisual] = []
        for geom, frame in geoms:
            collides = bool(model["geom_contype"][geom] or model["geom_conaffinity"][geom])
            seen = model["geom_group"][geom] in self._visual_groups
            if not (collides or seen):
                continue
            made = self._geometry(geom)
            if made is None:
                continue
            geometry, pose = made[0], compose_poses(frame, made[1])
            place = model.location("geom", geom)
            if collides:
                slide = max(0.0, float(model["geom_friction"][geom][0]))
                slide = slide if model["geom_condim"][geom] > _FRICTIONLESS else 0.0
                friction = (slide, slide, 0.0)
                collisions.append(DescribedCollision(geometry, pose, place, friction, 0.0, self._bits(geom)))
            look = self._look(geom)
            if seen and look is not None:
                visuals.append(DescribedVisual(geometry, pose, place, model.name("geom", geom), look))
        return tuple(collisions), tuple(visuals)

    def _bits(self, geom: int) -> tuple[int, int] | None:
        """Returns bits for MuJoCo's rule; the shapes collide with everything that has SAPIEN's default bits."""
        contype, conaffinity = (int(self._model[name][geom]) for name in ("geom_contype", "geom_conaffinity"))
        if not (0 <= contype < 1 << MAX_BITS and 0 <= conaffinity < 1 << MAX_BITS):
            message = f"`contype` {contype} or `conaffinity` {conaffinity} needs more than {MAX_BITS} bits"
            self._report.error("SC483", message, self._model.location("geom", geom))
            return None
        return contype << 1 | 1, conaffinity << 1

    def _geometry(self, geom: int) -> tuple[Geometry, Pose7] | None:
        """Returns shape and pose; None after an error."""
        model, place = self._model, self._model.location("geom", geom)
        kind, size = int(model["geom_type"][geom]), model["geom_size"][geom].tolist()
        pose: Pose7 = (*model["geom_pos"][geom].tolist(), *model["geom_quat"][geom].tolist())
        made: tuple[Geometry, Pose7] | None = None
        if kind in _SOLIDS:
            word, count = _SOLIDS[kind]
            upright = word in {"capsule", "cylinder"}
            made = SolidGeometry(word, tuple(size[:count])), compose_poses(pose, _X_TO_Z) if upright else pose
        elif kind == PLANE:
            half = (size[0], size[1]) if size[0] > 0 and size[1] > 0 else None
            made = PlaneGeometry(half), compose_poses(pose, _X_TO_Z)
        elif kind == MESH:
            made = self._mesh(geom, pose)
        elif kind == SDF:
            # Those of plugins are refused before, so this is the distance from the mesh itself.
            mesh, moved = self._mesh(geom, pose)
            made = replace(mesh, collision="sdf"), moved
        elif kind == HFIELD:
            field = self._height_field(int(model["geom_dataid"][geom]))
            made = None if field is None else (field, pose)
        elif kind == ELLIPSOID:
            words = "an ellipsoid becomes a convex mesh with 242 faces and the same volume"
            self._report.leave_out("ellipsoid", words, place)
            made = self._numeric_mesh("ellipsoid", place, *ellipsoid_surface(size)), pose
        else:
            self._report.error("SC483", f"a geom of type {kind} cannot be built", place)
        return made

    def _mesh(self, geom: int, pose: Pose7) -> tuple[MeshGeometry, Pose7]:
        """Returns a mesh in its file's frame. MuJoCo moves meshes to their centre of mass and principal axes."""
        model = self._model
        mesh = int(model["geom_dataid"][geom])
        file, scale, refpos, refquat = model.header["meshes"][mesh]
        found = model.source.files.get(file)
        is_moved = any(refpos) or refquat != [1, 0, 0, 0]
        if found is None or is_moved or not _can_be_read(found.path, model.source.assets[file]):
            return self._compiled_mesh(mesh), pose
        moved = (*model["mesh_pos"][mesh].tolist(), *model["mesh_quat"][mesh].tolist())
        # MuJoCo ignores materials in mesh files.
        geometry = MeshGeometry(found.uri, found.path, tuple(scale), collision="hull", optional_names=True)
        return geometry, compose_poses(pose, invert_pose(moved))

    def _compiled_mesh(self, mesh: int) -> MeshGeometry:
        """Returns a mesh that SAPIEN cannot read, from the model's arrays."""
        model = self._model
        if mesh not in self._meshes:
            first, count = int(model["mesh_vertadr"][mesh]), int(model["mesh_vertnum"][mesh])
            start, faces = int(model["mesh_faceadr"][mesh]), int(model["mesh_facenum"][mesh])
            vertices = model["mesh_vert"][first : first + count].astype(np.float64)
            triangles = model["mesh_face"][start : start + faces]
            name, place = model.name("mesh", mesh) or f"mesh_{mesh}", model.location("mesh", mesh)
            self._meshes[mesh] = self._numeric_mesh(name, place, vertices, triangles)
        return self._meshes[mesh]

    def _numeric_mesh(self, name: str, place: Location, vertices: Any, triangles: Any, *others: Any) -> MeshGeometry:
        try:
            return numeric_mesh(name, vertices, triangles, *others)
        except OSError as error:
            self._report.error("SC450", f"the cache folder cannot be written: {error.strerror or error}", place)
            return MeshGeometry(name, Path(name), (1.0, 1.0, 1.0))

    def _height_field(self, number: int) -> HeightfieldGeometry | None:
        """Converts MuJoCo's rows (from -y to +y, heights 0 to 1). None after an error: too many heights."""
        model = self._model
        if number not in self._height_fields:
            rows, columns, first = (int(model[f"hfield_{name}"][number]) for name in ("nrow", "ncol", "adr"))
            self._height_count += rows * columns
            if rows * columns > MAX_HEIGHTS or self._height_count > MAX_TOTAL_HEIGHTS:
                message = (
                    f"a height field has more than {MAX_HEIGHTS} heights, or all together more than {MAX_TOTAL_HEIGHTS}"
                )
                self._report.error("SC452", message, model.location("hfield", number))
                return None
            x, y, top, _ = model["hfield_size"][number].tolist()
            grid = model["hfield_data"][first : first + rows * columns].reshape(rows, columns)[::-1]
            heights: list[list[float]] = grid.astype(np.float64).tolist()
            self._height_fields[number] = HeightfieldGeometry((2 * x, 2 * y, top), tuple(map(tuple, heights)))
        return self._height_fields[number]

    def _look(self, geom: int) -> DescribedMaterial | None:
        model = self._model
        rgba, material = tuple(model["geom_rgba"][geom].tolist()), int(model["geom_matid"][geom])
        if material >= 0 and rgba == _DEFAULT_RGBA:
            rgba = tuple(model["mat_rgba"][material].tolist())
        rgba = tuple(min(max(part, 0.0), 1.0) for part in rgba)
        if rgba[3] <= 0:
            return None
        known = self._looks.get((material, rgba))
        if known is None:
            known = self._looks[material, rgba] = self._described_look(material, rgba)
        return known

    def _described_look(self, material: int, rgba: tuple[float, ...]) -> DescribedMaterial:
        """Returns a material from a colour and the index of a MuJoCo material, negative for none."""
        red, green, blue = map(srgb_to_linear, rgba[:3])  # MuJoCo shows them as they are
        color = (red, green, blue, rgba[3])
        if material < 0:
            return DescribedMaterial(base_color=color)
        model = self._model
        names = ("mat_emission", "mat_specular", "mat_shininess", "mat_metallic", "mat_roughness")
        emission, specular, shininess, metallic, roughness = (float(model[name][material]) for name in names)
        texture = int(model["mat_texid"][material][_COLOR_ROLE])
        file = model.texture(texture)
        if texture >= 0 and file is None:
            message = "procedural textures and cube textures are not shown"
            self._report.leave_out("texture", message, model.location("tex", texture), "save the texture to a file")
        return DescribedMaterial(
            base_color=color,
            base_color_texture=None if file is None else DescribedTexture(file.uri, file.path),
            emission=(color[0] * emission, color[1] * emission, color[2] * emission, 1.0) if emission else None,
            specular=specular,
            # Single precision would give 0.19999999.
            roughness=roughness if roughness >= 0 else round(1 - shininess, 6),
            metallic=max(metallic, 0.0),
            name=model.name("mat", material),
        )
