"""Files and materials of a plan in the engine: file caches, convex decomposition, mirrored meshes, shared resources.

PhysX and the renderer cache files by path for the life of the process, so a cache is emptied when a file has changed.
CoACD runs in its own process. Its results and mirrored convex meshes are kept in the user's cache folder.
"""

from __future__ import annotations

import gc
import hashlib
import importlib
import importlib.util
import inspect
import json
import logging
import os
import tempfile
import time
from dataclasses import asdict, astuple
from importlib.metadata import version
from pathlib import Path
from subprocess import DEVNULL
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from weakref import WeakSet

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.measures import weld
from scenecc.assets.meshes import checked_content, read_mesh, read_triangles
from scenecc.assets.obj_materials import keep_named_images, with_materials
from scenecc.backends.sapien.engine import (
    DROPPED_PART,
    EngineFailure,
    capture_engine_log,
    physx,
    render,
)
from scenecc.backends.sapien.objects import DrawnObjects
from scenecc.backends.sapien.properties import Column, select_rows
from scenecc.backends.sapien.shared_materials import Friction3, SharedMaterial
from scenecc.extras import install_hint
from scenecc.files import State, cache_folder, keep_file, open_regular, read_checked, replace_all, state_now
from scenecc.geometry.ply import encode_parts
from scenecc.geometry.rotations import to_vector
from scenecc.interrupt import ask_module
from scenecc.plan import MeshGeometry
from scenecc.plan.material_counts import MATERIAL_LIMIT, drawn_combinations
from scenecc.plan.scene import DEFAULT_TIMESTEP
from scenecc.variation.node_bounds import BoundsAnalysis

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan import CoacdParams, ScenePlan, Value
    from scenecc.plan.body import AssetFile, Texture, VisualMaterial

_LOGGER = logging.getLogger(__name__)

Signature = tuple[State, ...]
"""The states of a file and of the files that it names."""

_START_MARGIN = 2_000_000_000
"""Error of the process start time [ns]: the kernel reports its boot time in whole seconds."""


class FileCache:
    """The files in one of the engine's caches, with their states when they were read."""

    def __init__(self, clear: Callable[[], None]) -> None:
        self._clear = clear
        self._signatures: dict[str, Signature] = {}

    def refresh(self, files: Iterable[AssetFile]) -> None:
        """Empties the cache if a file that is about to be read may differ from its cached content.

        Other code in this process may have read a file before its first use here. That content is still valid if the
        file has not changed since the process started.
        """
        present = {str(file.path): file_signature(file) for file in files}
        known = self._signatures
        if any(
            known[p] != s if p in known else _latest_change(s) > _process_start() - _START_MARGIN
            for p, s in present.items()
        ):
            self.forget()
        known.update(present)

    def forget(self) -> None:
        """Empties the cache."""
        self._clear()
        self._signatures.clear()


MESH_CACHE = FileCache(physx.clear_cache)
"""Meshes that PhysX has cooked."""

RENDER_CACHE = FileCache(lambda: render.clear_cache(models=True, images=True))
"""Files that the renderer has loaded."""


def load_all_parts(load: Callable[[], Any]) -> Any:
    """Returns what `load` returns for the parts of a mesh.

    Raises:
        ValueError: the engine cannot cook some parts. SAPIEN skips these and reports it only in its log.
    """
    with capture_engine_log() as log:
        made = load()
    if (dropped := log.text.count(DROPPED_PART)) > 0:
        # Otherwise the next call would silently get the remaining parts from the cache.
        MESH_CACHE.forget()
        raise ValueError(f"{dropped} of the mesh's parts cannot be cooked")
    return made


def refresh_caches(plan: ScenePlan, *, rendered: bool) -> None:
    """Drops changed files from the caches. Call it before the plan's files are read."""
    if not plan.files:
        return
    bodies = [body for entity in plan.entities for body in entity.bodies]
    used: set[int] = set()
    for geometry in (shape.geometry for body in bodies for shape in body.collisions):
        if isinstance(geometry, MeshGeometry):
            used.update(geometry.file.data.tolist())
    MESH_CACHE.refresh(plan.files[index] for index in sorted(used))
    if rendered:
        RENDER_CACHE.refresh(plan.files)


def file_signature(file: AssetFile) -> Signature:
    """Returns a signature of the state of a file and of the files that it names; empty for a missing file."""
    states = [state_now(path) for path in (file.path, *(one.path for one in file.names)) if path is not None]
    return tuple(state for state in states if state is not None)


def check_files_unchanged(files: Iterable[AssetFile]) -> None:
    """Checks that files have not changed since they were checked, because the engine opens them by name.

    Raises:
        EngineFailure: a file has changed.
    """
    for file in files:
        for one in (file, *file.names):
            if one.state is not None and one.path is not None and state_now(one.path) != one.state:
                hint = "wait until all files are written, then build again"
                raise EngineFailure("SC422", f"'{one.path}' changed while the scene was built", hint=hint)


def _latest_change(state: Signature) -> int:
    return max((max(times) for _, _, _, *times in state), default=0)


def _process_start() -> int:
    """Returns when this process started [ns since the epoch]. If that is unknown, 0, so that no file is trusted."""
    try:
        ticks = int(Path("/proc/self/stat").read_text().rsplit(")", 1)[1].split()[19])
        running = time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError, ValueError, IndexError):
        return 0
    return time.time_ns() - int(running * 1e9)


COACD_CODE = "SC806"


class _CoacdInput(NamedTuple):
    """The mesh to decompose: path and hash of the file, and of each buffer of a glTF by its name."""

    mesh: tuple[str, str]
    buffers: dict[str, tuple[str, str]]

    @classmethod
    def of(cls, file: AssetFile) -> _CoacdInput:
        """Reads the input from a file. Raises OSError."""
        named = file.names if file.path.suffix.lower() in {".gltf", ".glb"} else ()
        path = collision_file(file)
        with open_regular(path) as stream:
            digest = (path == file.path and file.sha256) or hashlib.sha256(stream.read()).hexdigest()
        return cls((str(path.absolute()), digest), {one.uri: (str(one.path), one.sha256) for one in named})

    def key(self, arguments: dict[str, Any]) -> str:
        """Returns a cache key of content and arguments, independent of the path."""
        path, digest = self.mesh
        hashes = [digest, *sorted((uri, named) for uri, (_, named) in self.buffers.items())]
        how = [Path(path).suffix.lower(), version("coacd"), version("trimesh"), arguments]
        return hashlib.sha256(json.dumps([hashes, how], sort_keys=True).encode()).hexdigest()


def decompose(file: AssetFile, params: CoacdParams) -> Path:
    """Returns a PLY file whose connected parts are the convex parts that CoACD finds in a mesh.

    The result equals that of `sapien.wrapper.coacd.do_coacd` with the same parameters. It is kept in
    `$XDG_CACHE_HOME/scenecc/coacd` (`~/.cache` without that variable). The key is the content of the mesh and its
    buffers, the parameters, and the versions of CoACD and trimesh, which reads the mesh. Materials and images are not
    read.

    Raises:
        EngineFailure: CoACD is not installed or fails, or the cache folder cannot be written.
    """
    if importlib.util.find_spec("coacd") is None:
        message = "convex decomposition needs the package 'coacd', which is not installed"
        raise EngineFailure(COACD_CODE, message, hint=install_hint("convex"))
    arguments = coacd_arguments(params)
    folder = cache_folder("coacd")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        content = _CoacdInput.of(file)
        result = folder / f"{content.key(arguments)}.ply"
        if not result.exists():
            _run_coacd(content, arguments, result)
    except OSError as error:
        raise EngineFailure(
            COACD_CODE,
            f"convex decomposition of '{file.path}': {error}",
            hint=f"results are kept in '{folder}'; set XDG_CACHE_HOME to move it",
        ) from error
    return result


def collision_file(file: AssetFile) -> Path:
    """Returns a mesh that PhysX can read. A COLLADA (`.dae`), which SAPIEN only renders, is converted to a PLY.

    The PLY is kept in the user's cache folder, by the key of the COLLADA's record.

    Raises:
        EngineFailure: the mesh cannot be read, or the cache folder cannot be written.
    """
    if file.path.suffix.lower() != ".dae":
        return file.path
    folder = cache_folder("collada")
    try:
        content = checked_content(file)
        result = folder / f"{read_mesh(content).key}.ply"
        if not result.exists():
            parts = [weld(*part) for part in read_triangles(content)]
            folder.mkdir(parents=True, exist_ok=True)
            replace_all({result: encode_parts([(points.astype(np.float32), faces) for points, faces in parts])})
    except AssetError as error:
        raise EngineFailure(error.code, error.message, hint=error.hint) from error
    except OSError as error:
        hint = f"its triangles are kept in '{folder}'; set XDG_CACHE_HOME to move it"
        raise EngineFailure("SC801", f"the COLLADA '{file.path}' cannot be converted: {error}", hint=hint) from error
    return result


def visual_file(file: AssetFile) -> Path:
    """Returns a mesh that the renderer can read. For an OBJ with missing optional images, a copy that does not name
    them.

    The copy is kept in the user's cache folder, by its content.

    Raises:
        EngineFailure: the copy cannot be written.
    """
    if not file.optional_names or file.path.suffix.lower() != ".obj":
        return file.path
    named = {one.uri: one.path for one in file.names if one.path is not None}
    try:
        mesh = read_checked(file.path, file.sha256)
        materials = keep_named_images(mesh, file.path, named, lambda path: read_checked(path, None))
        if materials is None:
            return file.path
        return keep_file("obj", with_materials(mesh, keep_file("obj", materials, ".mtl").name), ".obj")
    except (OSError, ValueError) as error:
        hint = f"copies are kept in '{cache_folder('obj')}'; set XDG_CACHE_HOME to move it"
        raise EngineFailure("SC807", f"a copy of '{file.path}' cannot be written: {error}", hint=hint) from error


def coacd_arguments(params: CoacdParams) -> dict[str, Any]:
    """Returns the arguments of `coacd.run_coacd`: those of the plan, and SAPIEN's defaults for the rest."""
    do_coacd: Any = importlib.import_module("sapien.wrapper.coacd").do_coacd
    parameters = inspect.signature(do_coacd).parameters
    given = asdict(params)
    return {name: parameters[name].default if value is None else value for name, value in given.items()}


def _run_coacd(content: _CoacdInput, arguments: dict[str, Any], result: Path) -> None:
    """Writes `result` atomically. If CoACD's automatic preprocessing fails, forces it."""
    name = Path(content.mesh[0]).name
    _LOGGER.info("CoACD decomposes %s, which may take minutes; the result is cached", name)
    modes = [arguments["preprocess_mode"]]
    if modes[0] != "on":
        modes.append("on")
    complaint = ""
    for mode in modes:
        parts, complaint = _run_worker(content, arguments | {"preprocess_mode": mode})
        if parts:
            replace_all({result: parts})
            _LOGGER.info("CoACD has decomposed %s", name)
            return
    raise EngineFailure(COACD_CODE, f"CoACD failed on '{content.mesh[0]}': {complaint}")


def _run_worker(content: _CoacdInput, arguments: dict[str, Any]) -> tuple[bytes, str]:
    """Runs CoACD in its own process, so that a crash ends only that, and returns its output and its last log line."""
    with tempfile.TemporaryFile() as file:
        output = file.fileno()
        request = {**content._asdict(), "arguments": arguments, "output": output, "parent": os.getpid()}
        done = ask_module("scenecc.backends.sapien.coacd_worker", request, stdout=DEVNULL, pass_fds=[output])
        file.seek(0)
        parts = file.read() if done.returncode == 0 else b""
    words = done.stderr.decode(errors="replace").strip().splitlines()
    return parts, words[-1] if words else f"its process ended with status {done.returncode}"


AxisSigns = tuple[float, float, float]
"""1 or -1 for each axis of a mesh."""

UNMIRRORED: AxisSigns = (1.0, 1.0, 1.0)


def mirror_meshes(meshes: Column, scale: NDArray[np.float64], *, parts: bool) -> Column:
    """Applies `mirror_mesh` to each row; returns one path if all rows have the same."""
    if (scale > 0).all():
        return meshes
    signs: list[AxisSigns] = list(map(tuple, np.sign(scale).tolist()))
    count = max(len(meshes), len(signs))
    pairs = list(zip(meshes * (count // len(meshes)), signs * (count // len(signs)), strict=True))
    found = {pair: mirror_mesh(*pair, parts=parts) for pair in dict.fromkeys(pairs)}
    return [found[pair] for pair in pairs]


def mirror_mesh(mesh: str, signs: AxisSigns, *, parts: bool) -> str:
    """Returns the path of the mirrored convex hull of a mesh, or of the mirrored hulls of its connected parts.

    Without a mirrored axis, returns the mesh. PhysX does not support a negative scale of a convex mesh: its faces would
    point inwards, its mass would be 0, and the process would crash at the first contact. The file is kept in the user's
    cache folder, named by its content.

    Raises:
        EngineFailure: the engine cannot read the mesh, or the cache folder cannot be written.
    """
    if min(signs) > 0:
        return mesh
    try:
        shapes = _load_hulls(mesh, parts=parts)
    except (RuntimeError, ValueError) as error:
        raise EngineFailure("SC801", f"the engine cannot make this shape: {error}") from error
    turned = -1 if np.prod(signs) < 0 else 1
    content = encode_parts([(shape.vertices * np.array(signs), shape.triangles[:, ::turned]) for shape in shapes])
    try:
        return str(keep_file("mirrored", content, ".ply"))
    except OSError as error:
        hint = f"mirrored meshes are kept in '{cache_folder('mirrored')}'; set XDG_CACHE_HOME to move it"
        raise EngineFailure("SC801", f"the mirrored '{mesh}' cannot be written: {error}", hint=hint) from error


def _load_hulls(mesh: str, *, parts: bool) -> list[Any]:
    hull = physx.PhysxCollisionShapeConvexMesh
    material: Any = physx.get_default_material()
    if parts:
        return load_all_parts(lambda: hull.load_multiple(mesh, UNMIRRORED, material))
    return [hull(mesh, UNMIRRORED, material)]


_live_materials: Final[WeakSet[Any]] = WeakSet()
"""Materials of all open batches. A batch keeps its materials alive."""


class Resources:
    """The tables of a plan as engine objects. `drawn` receives the materials that a reset redraws.

    All shapes that name a material share it, in all scenes where its numbers are the same, as in a script that makes
    each material once: a later change of its friction applies to all of them. A material that a reset redraws is
    shared only within a scene, or, if it has few values, by all shapes that have the same one.
    """

    def __init__(self, plan: ScenePlan, drawn: DrawnObjects | None = None) -> None:
        self._plan = plan
        self.timestep = float(np.float32(plan.physics.timestep or DEFAULT_TIMESTEP))
        self.drawn = DrawnObjects() if drawn is None else drawn
        default = plan.physics.default_material
        self._physical: dict[tuple[object, ...], Any] = {}
        self._few: dict[int, bool] = {}
        self._lacking = 0
        self.default_material: Any = (
            physx.get_default_material() if default is None else self._physical_material((-1, *astuple(default)))
        )
        self._same: dict[int, Column | None] = {}
        self._visual: dict[tuple[object, ...], Any] = {}
        self._textures: dict[tuple[object, ...], Any] = {}

    def physical(self, material: Value | None, rows: NDArray[np.intp], scene_idxs: Sequence[int]) -> Column:
        """Returns a `PhysxMaterial` for each row, or one for all. `scene_idxs`: by row of the plan."""
        if material is None:
            return [self.default_material]
        if not material.varies and (fixed := self._shared_material(int(material.as_drawn()[0]))) is not None:
            return fixed
        indices = np.broadcast_to(select_rows(material, rows), len(rows))
        numbers = np.empty((len(rows), 3))
        for index in np.unique(indices).tolist():
            where = indices == index
            numbers[where] = self._numbers(index, rows[where])
        order: list[int] = indices.tolist()
        table = self._plan.physical_materials
        drawn = {index for index in dict.fromkeys(order) if _is_redrawn(table[index].values())}
        if not drawn:
            return list(map(self._physical_material, zip(order, *numbers.T.tolist(), strict=True)))
        made: Column = []
        places: list[int] = rows.tolist()
        for index, row, own in zip(order, places, numbers.tolist(), strict=True):
            if index not in drawn:
                made.append(self._physical_material((index, *own)))
                continue
            scene, of_index = scene_idxs[row], self.drawn.physical.setdefault(index, {})
            if scene not in of_index:
                of_index[scene] = self._drawn_material(index, scene, to_vector(own))
            made.append(of_index[scene])
        return made

    def _drawn_material(self, index: int, scene: int, numbers: Friction3) -> Any:
        """Returns a `PhysxMaterial` of one scene, or a `SharedMaterial` if it has few values."""
        if index not in self._few:
            analysis = BoundsAnalysis(dict(self._plan.draws), self._plan.num_scenes)
            few = not physx.is_gpu_enabled() and drawn_combinations(self._plan.physical_materials[index], analysis)
            self._few[index] = bool(few)
        if not self._few[index]:
            self._physical["drawn", index, scene] = made = self._new_material(*numbers)
            return made
        key = ("shared", *numbers)
        if key not in self._physical:
            self._physical[key] = self.drawn.pool.take(numbers, self._new_material)
        return SharedMaterial(self.drawn.pool, numbers, _material_at_reset)

    def limit_failure(self) -> EngineFailure | None:
        """Returns a failure if a process cannot hold all physical materials that were requested."""
        if not self._lacking:
            return None
        count = len(self._physical)
        others = MATERIAL_LIMIT - (count - self._lacking)
        return EngineFailure(
            "SC821",
            f"these scenes need {count} physical materials{f' besides {others} of other batches' * (others > 0)},"
            f" and a process can hold {MATERIAL_LIMIT}",
            hint="build fewer scenes in one process (`--scene 0:2048`), or draw friction and restitution from few"
            " values (`choice`), which are shared",
        )

    def _shared_material(self, index: int) -> Column | None:
        """Returns the shared column of a physical material that is the same in every scene."""
        if index not in self._same:
            values = self._plan.physical_materials[index].values()
            numbers = [value.as_drawn()[0] for value in values]
            differs = any(value.varies or value.recipe is not None for value in values)
            self._same[index] = None if differs else [self._physical_material((index, *numbers))]
        return self._same[index]

    def _numbers(self, index: int, rows: NDArray[np.intp]) -> NDArray[np.float64]:
        """Returns the numbers of a physical material, (B, 3)."""
        columns = [select_rows(value, rows) for value in self._plan.physical_materials[index].values()]
        return np.stack(np.broadcast_arrays(*columns), axis=1)

    def _physical_material(self, key: tuple[float, ...]) -> Any:
        if key not in self._physical:
            self._physical[key] = self._new_material(*key[1:])
        return self._physical[key]

    def _new_material(self, *numbers: float) -> Any:
        made = None if self._lacking else _make_physical_material(*numbers)
        if made is None:
            # Further materials are only counted, for `limit_failure`.
            self._lacking += 1
            return physx.get_default_material()
        return made

    def visual(self, material: Value, rows: NDArray[np.intp], scene_idxs: Sequence[int]) -> Column:
        """Returns a `RenderMaterial` for each row, or one for all. `scene_idxs`: by row of the plan."""
        table = self._plan.visual_materials
        indices: list[int] = select_rows(material, rows).tolist()
        varying = {i: [value for value in table[i].values() if value.varies] for i in dict.fromkeys(indices)}
        drawn = {i for i in varying if _is_redrawn(table[i].values())}
        if len(indices) == 1 and (varying[indices[0]] or drawn):
            indices *= len(rows)
        column: Column = []
        places: list[int] = rows.tolist()
        for index, row in zip(indices, places, strict=False):
            key: Any = (index, *(value.data[row].tobytes() for value in varying[index]))
            made: dict[Any, Any] = self._visual
            if index in drawn:
                key, made = scene_idxs[row], self.drawn.visual.setdefault(index, {})
            if key not in made:
                made[key] = self._make_visual(table[index], row)
            column.append(made[key])
        return column

    def collision_meshes(self, indices: NDArray[np.int64]) -> Column:
        """Returns the path of a mesh for each row, as PhysX can read it. Raises EngineFailure."""
        paths = {i: str(collision_file(file)) for i, file in self._files(indices, "SC801")}
        return [paths[i] for i in indices.tolist()]

    def visual_meshes(self, indices: NDArray[np.int64]) -> Column:
        """Returns the path of a mesh for each row, as the renderer can read it. Raises EngineFailure."""
        paths = {i: str(visual_file(file)) for i, file in self._files(indices, "SC807")}
        return [paths[i] for i in indices.tolist()]

    def _files(self, indices: NDArray[np.int64], code: str) -> Iterator[tuple[int, AssetFile]]:
        """Yields files by index. Raises EngineFailure with `code` if one is missing."""
        for i in dict.fromkeys(map(int, indices)):
            file = self._plan.files[i]
            check_files_unchanged([file])
            if not file.path.is_file():
                raise EngineFailure(code, f"there is no file '{file.path}'")
            yield i, file

    def parts(self, indices: NDArray[np.int64], params: CoacdParams | None) -> Column:
        """Returns, for each row, the path of a mesh with convex connected parts. With `params`, CoACD decomposes it."""
        whole = self.collision_meshes(indices)
        if params is None:
            return whole
        order: list[int] = indices.tolist()
        cut = {i: str(decompose(self._plan.files[i], params)) for i in dict.fromkeys(order)}
        return [cut[i] for i in order]

    def path(self, index: int) -> str:
        """Returns the path of the plan's file number `index` on this machine."""
        check_files_unchanged([self._plan.files[index]])
        return str(self._plan.files[index].path)

    def _make_visual(self, material: VisualMaterial, row: int) -> Any:
        made = render.RenderMaterial(**material.row(row))
        for name, texture in material.textures().items():
            setattr(made, name, self.texture(texture, row))
        return made

    def texture(self, texture: Texture, row: int) -> Any:
        """Returns the `RenderTexture2D` of a row, shared between textures with the same file and sampling.

        Raises:
            EngineFailure: the renderer cannot load the file.
        """
        index, sampling = int(texture.file.row(row)), texture.sampling()
        key = (self.path(index), *sampling.items())
        if key not in self._textures:
            self._textures[key] = self.image(index, **sampling)
        return self._textures[key]

    def image(self, index: int, **sampling: Any) -> Any:
        """Returns a new `RenderTexture2D` of the plan's file number `index`.

        Raises:
            EngineFailure: the renderer cannot load the file; located at the node that names it.
        """
        path = self.path(index)
        try:
            return render.RenderTexture2D(path, **sampling)
        except (RuntimeError, ValueError) as error:  # ValueError if the renderer's message is not UTF-8
            message = f"the renderer cannot load the image '{path}': {error}"
            hint = "SAPIEN supports few image formats: save it as PNG or JPEG"
            raise EngineFailure("SC807", message, origin=self._plan.files[index].origin, hint=hint) from error


def _is_redrawn(values: Iterable[Value]) -> bool:
    """Returns whether a reset changes a material, so that each scene needs its own."""
    return any(value.recipe is not None for value in values)


def _material_at_reset(*numbers: float) -> Any:
    made = _make_physical_material(*numbers)
    if made is None:
        raise ValueError(f"a process can hold {MATERIAL_LIMIT} physical materials, and this reset needs more")
    return made


def _make_physical_material(static_friction: float, dynamic_friction: float, restitution: float) -> Any:
    """Returns a new `PhysxMaterial`; None if the process can hold no more. SAPIEN crashes on one beyond the limit."""
    if len(_live_materials) == MATERIAL_LIMIT:
        gc.collect()  # a batch that was dropped without closing may still hold some
    if len(_live_materials) == MATERIAL_LIMIT:
        return None
    made = physx.PhysxMaterial(static_friction, dynamic_friction, restitution)
    _live_materials.add(made)
    return made


def report_changed_files(plan: ScenePlan, sink: Sink) -> bool:
    """Returns whether files are unchanged since they were checked; reports the first that changed."""
    try:
        check_files_unchanged(plan.files)
    except EngineFailure as failure:
        failure.report(sink, plan.origin)
        return False
    return True
