"""Files of a plan in a script: constants at its top, and the functions that find them."""

from __future__ import annotations

import base64
import zlib
from dataclasses import fields, is_dataclass
from inspect import getsource
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from scenecc.emit.python.source import (
    WIDTH,
    Identifiers,
    SourceNode,
    SourceWriter,
    call,
    list_of,
    number_literal,
    string,
)
from scenecc.files import read_checked
from scenecc.geometry import ply, surfaces
from scenecc.geometry.surfaces import heightfield_surface
from scenecc.geometry.triangles import join_parts
from scenecc.plan import ArticulationStructure, CoacdParams, Value
from scenecc.plan.properties import Quantity
from scenecc.plan.schema import FieldKind, ListKind, ObjectKind, UnionKind, plan_fields

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.plan import ScenePlan
    from scenecc.plan.body import AssetFile

_PACKAGE_FILE = '''\
def package_file(package: str, path: str) -> Path:
    """Returns a file of an installed package, without importing the package."""
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise FileNotFoundError(f"the package {package} is not installed")
    return Path(spec.origin).parent / path
'''

_ASSET_FILE = '''\
def asset_file(path: str) -> Path:
    """Returns a file in one of the folders of the environment variable SCENECC_ASSET_PATH."""
    folders = os.environ.get("SCENECC_ASSET_PATH", "").split(os.pathsep)
    for folder in filter(None, folders):
        if (Path(folder) / path).is_file():
            return Path(folder) / path
    raise FileNotFoundError(f"{path} is not in a folder of SCENECC_ASSET_PATH: {folders}")
'''

_CONVEX_PARTS = '''\
@functools.cache
def convex_parts(mesh: Path, **parameters: object) -> str:
    """Returns a file with CoACD's convex parts of a mesh, which is deleted at exit."""
    coacd.set_log_level("error")
    whole = trimesh.load(mesh, force="mesh")
    parts = coacd.run_coacd(coacd.Mesh(whole.vertices, whole.faces), **parameters)
    joined = trimesh.util.concatenate([trimesh.Trimesh(*part) for part in parts])
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    file = Path(folder) / "parts.ply"
    joined.export(file)
    return str(file)
'''

_PLY_FILE = '''\
def ply_file(parts: list[tuple[Any, Any]]) -> Path:
    """Returns a PLY file of vertices and triangles, which is deleted at exit."""
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    file = Path(folder) / "mesh.ply"
    file.write_bytes(encode_parts(parts))
    return file
'''

_MIRRORED = '''\
@functools.cache
def mirrored(mesh: str, signs: tuple[int, ...], *, parts: bool) -> str:
    """Returns a file with the mirrored hull of a mesh, or of each of its parts."""
    hull = physx.PhysxCollisionShapeConvexMesh
    given = (mesh, [1, 1, 1], physx.get_default_material())
    shapes = hull.load_multiple(*given) if parts else [hull(*given)]
    turned = -1 if np.prod(signs) < 0 else 1
    sign = np.array(signs)
    return str(ply_file([(one.vertices * sign, one.triangles[:, ::turned]) for one in shapes]))
'''

_COLLADA_MESH = '''\
@functools.cache
def collada_mesh(mesh: Path) -> Path:
    """Converts a COLLADA, which PhysX cannot read, to a PLY [m] without lamps, with trimesh and pycollada."""
    lamps = rb"<instance_(light|camera)\\b[^>]*?(/>|>.*?</instance_\\1>)"
    data = re.sub(lamps, b"", mesh.read_bytes(), flags=re.DOTALL)
    scene = trimesh.load_scene(io.BytesIO(data), "dae", process=False, ignore_broken=False)
    parts: list[tuple[Any, Any]] = []
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        part = scene.geometry[name].copy()
        part.apply_transform(place)
        unit, times, _ = str(part.metadata.get("units", "")).partition(" * meters")
        part.apply_scale(float(unit) if times else 1.0)
        vertices, index = np.unique(part.vertices.astype(np.float32), axis=0, return_inverse=True)
        parts.append((vertices, index.reshape(-1)[part.faces]))
    return ply_file(parts)
'''

_PACKED_FILE = '''\
def packed_file(name: str, lines: list[str]) -> Path:
    """Returns a file that is embedded in this script and deleted at exit."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / name).write_bytes(zlib.decompress(base64.b64decode("".join(lines))))
    return folder / name
'''

_REVOLVED_SHAPES = '''\
def revolved_shapes(profile: Any, scale: Any, material: physx.PhysxMaterial) -> list[Any]:
    """Returns convex shapes of a profile (x, radius) revolved about x, and scaled."""
    make = physx.PhysxCollisionShapeConvexMesh
    return [make(part, scale, material) for part in revolved_parts(profile)]
'''

_REVOLVED_VISUAL = '''\
def revolved_visual(profile: Any, material: sapien.render.RenderMaterial) -> Any:
    """Returns a visual shape of a profile (x, radius) revolved about x."""
    return sapien.render.RenderShapeTriangleMesh(*revolved_surface(profile), material)
'''

_HEIGHTFIELD_SHAPE = '''\
def heightfield_shape(size: Any, heights: Any, material: physx.PhysxMaterial) -> Any:
    """Returns a collision shape of terrain."""
    vertices, triangles, *_ = heightfield_surface(size, heights)
    return physx.PhysxCollisionShapeTriangleMesh(vertices, triangles, np.ones(3), material)
'''

_HEIGHTFIELD_VISUAL = '''\
def heightfield_visual(size: Any, heights: Any, material: sapien.render.RenderMaterial) -> Any:
    """Returns a visual shape of terrain."""
    return sapien.render.RenderShapeTriangleMesh(*heightfield_surface(size, heights), material)
'''

_PACKED_LINE_WIDTH = 80
"""Characters of an embedded file per line."""

_PACKAGE_PREFIX = "pkg://scenecc/"
"""Files that are shipped with scenecc. A script embeds them, since it must run without scenecc."""

COACD_DEFAULTS = CoacdParams(
    threshold=0.05,
    max_convex_hull=-1,
    preprocess_mode="auto",
    preprocess_resolution=30,
    resolution=2000,
    mcts_nodes=20,
    mcts_iterations=150,
    mcts_max_depth=3,
    pca=False,
    merge=True,
    seed=0,
)
"""Defaults of `sapien.wrapper.coacd.do_coacd`. The script does not call it, because it writes next to the mesh."""


class ScriptFiles:
    """The files of a script, and the helper functions that find or make them.

    Attributes:
        is_bound: whether the script finds files relative to its own folder.
    """

    def __init__(self, files: tuple[AssetFile, ...], names: Identifiers, unread: frozenset[int] = frozenset()) -> None:
        self._all = files
        self._read = [index for index in range(len(files)) if index not in unread]
        files = tuple(files[index] for index in self._read)
        self._files = files
        self._names = [names.take(PurePosixPath(file.uri).stem.upper()) for file in files]
        self._packed = any(map(_is_packed, files))
        others = [file.uri for file in files if "://" in file.uri and not _is_packed(file)]
        self._schemes = {uri.partition("://")[0] for uri in others}
        self.is_bound = any("://" not in file.uri and not Path(file.uri).is_absolute() for file in files)
        self._cut = self._mirrored = self._converted = False
        self._made: set[str] = set()
        self._heights: dict[tuple[tuple[float, ...], ...], str] = {}
        self._identifiers = names

    def name(self, index: int) -> str:
        """Returns the constant of a file of the plan."""
        return self._names[self._read.index(index)]

    def uri(self, index: int) -> str:
        """Returns the URI of a file in the plan."""
        return self._all[index].uri

    def parts(self, file: SourceNode, params: CoacdParams) -> SourceNode:
        """Returns an expression for the path of CoACD's parts of a file."""
        self._cut = True
        parameters: dict[str, SourceNode] = {}
        for item in fields(params):
            given = getattr(params, item.name)
            value = given if given is not None else getattr(COACD_DEFAULTS, item.name)
            parameters[item.name] = string(value) if isinstance(value, str) else number_literal(value)
        return call("convex_parts", file, **parameters)

    def mirrored(self, file: SourceNode, signs: SourceNode, *, parts: bool) -> SourceNode:
        """Returns an expression for the path of a mirrored convex mesh. PhysX does not support a negative scale."""
        self._mirrored = True
        return call("mirrored", file, signs, parts=str(parts))

    def collision_path(self, index: int) -> SourceNode:
        """Returns an expression for the path of a mesh that PhysX can read."""
        name = self.name(index)
        if self._all[index].path.suffix.lower() != ".dae":
            return name
        self._converted = True
        return call("collada_mesh", name)

    def use_helper(self, helper: str) -> None:
        """Requests a function that makes a shape: `revolved_shapes`, `revolved_visual`, `heightfield_shape`, …"""
        self._made.add(helper)

    def heights(self, heights: tuple[tuple[float, ...], ...]) -> str:
        """Returns the constant of the heights of terrain."""
        if heights not in self._heights:
            self._heights[heights] = self._identifiers.take("HEIGHTS")
        return self._heights[heights]

    @property
    def computes(self) -> bool:
        """Whether shapes are made from computed triangles."""
        return bool(self._made)

    def imports(self) -> list[str]:
        """Returns import statements of the standard library, sorted. Call it once all bodies are written."""
        wanted = {
            "import atexit": self._writes_files,
            "import base64": self._packed,
            "import functools": self._cut or self.writes_meshes,
            "import importlib.util": "pkg" in self._schemes,
            "import io": self._converted,
            "import os": "asset" in self._schemes,
            "import re": self._converted,
            "import shutil": self._writes_files,
            "import tempfile": self._writes_files,
            "import zlib": self._packed,
            "from pathlib import Path": bool(self._files),
            "from typing import Any": self.computes or self.writes_meshes,
        }
        return [text for text, needed in wanted.items() if needed]

    @property
    def _writes_files(self) -> bool:
        return self._cut or self._packed or self.writes_meshes

    @property
    def writes_meshes(self) -> bool:
        """Whether meshes are written for PhysX: mirrored ones, or those of a COLLADA."""
        return self._mirrored or self._converted

    @property
    def cut(self) -> bool:
        """Whether CoACD is run."""
        return self._cut

    @property
    def reads_meshes(self) -> bool:
        """Whether trimesh is needed."""
        return self._cut or self._converted

    def write_head(self, source: SourceWriter) -> None:
        """Writes the functions that find files, and the constants."""
        helpers = (
            (_PACKAGE_FILE, "pkg" in self._schemes),
            (_ASSET_FILE, "asset" in self._schemes),
            (_PACKED_FILE, self._packed),
        )
        shapes, visual = ("revolved_shapes" in self._made, "revolved_visual" in self._made)
        terrain, seen = ("heightfield_shape" in self._made, "heightfield_visual" in self._made)
        made = (
            (_CONVEX_PARTS, self._cut),
            (getsource(join_parts), self.writes_meshes),
            (getsource(ply.encode_ply), self.writes_meshes),
            (getsource(ply.encode_parts), self.writes_meshes),
            (_PLY_FILE, self.writes_meshes),
            (_MIRRORED, self._mirrored),
            (_COLLADA_MESH, self._converted),
            (getsource(surfaces.revolved_points), shapes or visual),
            (getsource(surfaces.revolved_parts), shapes),
            (_REVOLVED_SHAPES, shapes),
            (getsource(surfaces.revolved_surface), visual),
            (_REVOLVED_VISUAL, visual),
            (getsource(heightfield_surface), terrain or seen),
            (_HEIGHTFIELD_SHAPE, terrain),
            (_HEIGHTFIELD_VISUAL, seen),
        )
        for text in (text for text, needed in (*helpers, *made) if needed):
            source.line()
            source.line()
            source.lines(text)
        if self._heights:
            source.line()
        for heights, name in self._heights.items():
            source.line()
            rows = [list_of([number_literal(height) for height in row]) for row in heights]
            source.statement(list_of(rows), assign=name)
        if not self._files:
            return
        if any(needed for _, needed in (*helpers, *made)):
            source.line()
        source.line()
        if self.is_bound:
            source.line("HERE = Path(__file__).resolve().parent")
        for file, name in zip(self._files, self._names, strict=True):
            expression = _packed_file_call(file) if _is_packed(file) else _path_expression(file.uri, WIDTH - len(name))
            source.statement(expression, assign=name)
        source.statement(list_of(self._names), assign="FILES")

    def write_check(self, source: SourceWriter) -> None:
        """Writes a check that all files exist: SAPIEN ignores a missing mesh."""
        if self._files:
            with source.block("for file in FILES:"), source.block("if not file.is_file():"):
                source.line("raise FileNotFoundError(file)")


def unused_files(plan: ScenePlan) -> frozenset[int]:
    """Returns files that a script does not read: those of articulations, whose content is in the plan."""
    structures = [structure for entity in plan.entities for structure in entity.structures]
    robots = [structure for structure in structures if isinstance(structure, ArticulationStructure)]
    described = {index for robot in robots if robot.file is not None for index in robot.file.data.tolist()}
    return frozenset(described - set(_file_indices(plan))) if described else frozenset()


def _file_indices(plan: ScenePlan) -> Iterator[int]:
    """Yields indices of the files of shapes, materials and lights."""
    for holder, kind, value in plan_values(plan):
        if isinstance(kind, Quantity) and kind.table == "files" and not isinstance(holder, ArticulationStructure):
            yield from value.data.tolist()


def plan_values(node: object) -> Iterator[tuple[object, FieldKind, Value]]:
    """Yields all values below a dataclass of the plan, each with its dataclass and the kind of its field."""
    for slot in plan_fields(type(node)):
        item = getattr(node, slot.name)
        for one in (item or ()) if isinstance(slot.kind, ListKind) else (item,):
            if isinstance(one, Value):
                yield node, slot.kind, one
            elif isinstance(slot.kind, ObjectKind | UnionKind | ListKind) and is_dataclass(one):
                yield from plan_values(one)


def _is_packed(file: AssetFile) -> bool:
    return file.data is not None or (file.uri.startswith(_PACKAGE_PREFIX) and file.path.is_file())


def _packed_file_call(file: AssetFile) -> SourceNode:
    data = read_checked(file.path, file.sha256) if file.data is None else file.data
    text = base64.b64encode(zlib.compress(data, 9)).decode("ascii")
    lines = [string(text[start : start + _PACKED_LINE_WIDTH]) for start in range(0, len(text), _PACKED_LINE_WIDTH)]
    return call("packed_file", string(file.path.name), list_of(lines))


def _path_expression(uri: str, width: int) -> SourceNode:
    scheme, separator, path = uri.partition("://")
    if not separator and Path(uri).is_absolute():
        return call("Path", string(uri))
    if not separator:
        relative = f"HERE / {string(uri)}"
        return relative if len(relative) + len(" = ") <= width else call("HERE.joinpath", string(uri))
    if scheme == "pkg":
        package, _, inner = path.partition("/")
        return call("package_file", string(package), string(inner))
    return call("asset_file", string(path))
