"""COLLADA (`.dae`), for what is only seen: its triangles as the engine places them, and the images that it names.

What SAPIEN's reader meets without a word, and worse, is refused here: nodes in a circle end its process, a file that
shows no geometry becomes a heap of points, and a texture that leads to no image makes it open a file of that name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenecc.checks.mesh_dae_images import dae_images
from scenecc.checks.mesh_data import AssetError, MeshData, Part, Reading, Total, part
from scenecc.checks.mesh_text import EXPONENT, LONGEST_RUN, NUMBER, Budget, floats
from scenecc.checks.mesh_xml import Node, by_id, parse_mesh_xml

if TYPE_CHECKING:
    from numpy.typing import NDArray

_REAL = rf"(?:{NUMBER.decode()}|[-+]?\.[0-9]+{EXPONENT.decode()}|[-+]?(?:NaN|INF))"
_REALS = re.compile(rf"(?:{_REAL}[ \t\r\n]+){{1,{LONGEST_RUN}}}")
_INDICES = re.compile(rf"(?:[0-9]{{1,9}}[ \t\r\n]+){{1,{LONGEST_RUN}}}")
_FACED = ("triangles", "polylist", "polygons", "tristrips", "trifans")
_DEEPEST = 200
_PLACED_BYTES = 2**16
"""What a node and a geometry count for each time that they are placed: a small file may place them very often."""


@dataclass(frozen=True, slots=True)
class _File:
    root: Node
    budget: Budget


def read_dae(data: bytes, reading: Reading) -> MeshData:
    """Reads a COLLADA of version 1.4 or 1.5. A part is a primitive of a geometry, placed by one node [m].

    Its unit is heeded, as SAPIEN heeds it, and its `up_axis` is not, as SAPIEN turns nothing.

    Args:
        data: the file.
        reading: how much its triangles may take; its images are read by no one here.

    Raises:
        AssetError: it is not what COLLADA says, or too large, or holds what is not read.
    """
    budget = Budget(reading.max_bytes, reading.total)
    file = _File(parse_mesh_xml(data, budget), budget)
    try:
        _check_kind(file.root)
        images = dae_images(file.root)
        return MeshData(_parts(file), images)
    except ValueError as error:
        raise AssetError("SC412", f"the COLLADA cannot be read: {error}", "export the mesh again") from error


def _check_kind(root: Node) -> None:
    if root.tag != "COLLADA":
        raise ValueError(f"its first element is `{root.tag[:40]}`")
    if not root.get("version").startswith(("1.4", "1.5")):
        raise ValueError(f"it says version `{root.get('version')[:40]}`, and 1.4 and 1.5 are read")


def _parts(file: _File) -> tuple[Part, ...]:
    """Every primitive, once for each node that shows it."""
    root = file.root
    geometries = by_id(root, "library_geometries", "geometry")
    library = by_id(root, "library_nodes", "node")
    scenes = by_id(root, "library_visual_scenes", "visual_scene")
    chosen = [_target(one, scenes) for one in root.all("scene", "instance_visual_scene")]
    if len(chosen) != 1:
        raise ValueError("it shows no scene, or several")
    start = np.eye(4) * _unit(root)
    start[3, 3] = 1
    waiting = [(node, start, 0) for node in chosen[0].all("node")]
    shown: dict[str, list[Part]] = {}
    parts: list[Part] = []
    while waiting:
        node, above, depth = waiting.pop()
        file.budget.take(_PLACED_BYTES)
        if depth > _DEEPEST:
            raise ValueError("its nodes stand in a circle, or in one another to a great depth")
        place = above @ _place(node)
        inside = [*node.all("node"), *(_target(one, library) for one in node.all("instance_node"))]
        waiting.extend((child, place, depth + 1) for child in inside)
        if next(node.all("instance_controller"), None) is not None:
            raise AssetError("SC410", "the COLLADA has a skin or a morph", "export the mesh alone, as GLB")
        for instance in node.all("instance_geometry"):
            geometry = _target(instance, geometries)
            name = geometry.get("id")
            if name not in shown:
                shown[name] = _geometry(file, geometry)
            file.budget.take(_PLACED_BYTES + sum(one.vertices.nbytes + one.faces.nbytes for one in shown[name]))
            parts.extend(_moved(one, place) for one in shown[name])
    return tuple(parts)


def _target(instance: Node, known: dict[str, Node]) -> Node:
    url = instance.get("url")
    if not url.startswith("#") or url[1:] not in known:
        raise ValueError(f"`{instance.tag}` names `{url[:60]}`, which is not in the file's library")
    return known[url[1:]]


def _unit(root: Node) -> float:
    found = next(root.all("asset", "unit"), None)
    text = "1" if found is None else found.attributes.get("meter", "1")
    (size,) = _exactly(text, 1, "the unit")
    if not size > 0:
        raise ValueError(f"its unit is `{text[:40]}` metres")
    return float(size)


def _place(node: Node) -> NDArray[np.float64]:
    """Where a node stands in the one above it: what its elements say, one after the other."""
    place = np.eye(4)
    for step in node.children:
        turn = np.eye(4)
        match step.tag:
            case "translate":
                turn[:3, 3] = _exactly(step.text, 3, step.tag)
            case "scale":
                turn[:3, :3] = np.diag(_exactly(step.text, 3, step.tag))
            case "matrix":
                turn = _exactly(step.text, 16, step.tag).reshape(4, 4)
            case "rotate":
                turn[:3, :3] = _turn(_exactly(step.text, 4, step.tag))
            case "lookat" | "skew":
                raise AssetError("SC410", f"the COLLADA places a node by `{step.tag}`", "export the mesh as GLB")
            case _:
                continue
        place = place @ turn
    return place


def _turn(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """A turn about an axis by an angle [degrees]."""
    length = float(np.linalg.norm(numbers[:3]))
    if length == 0:
        return np.eye(3)
    x, y, z = numbers[:3] / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.deg2rad(numbers[3])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _geometry(file: _File, geometry: Node) -> list[Part]:
    found: list[Part] = []
    for mesh in geometry.all("mesh"):
        points: NDArray[np.float64] | None = None
        for primitive in (child for child in mesh.children if child.tag in _FACED):
            faces = _faces(file, primitive)
            if points is None:
                points = _points(file, mesh)
            if len(faces):
                found.append(part(points, faces))
    return found


def _points(file: _File, mesh: Node) -> NDArray[np.float64]:
    """The positions of a mesh."""
    sources = {source.get("id"): source for source in mesh.all("source")}
    named = [one.get("source") for one in mesh.all("vertices", "input") if one.get("semantic") == "POSITION"]
    source = sources.get(named[0].removeprefix("#")) if len(named) == 1 else None
    array = None if source is None else next(source.all("float_array"), None)
    accessor = None if source is None else next(source.all("technique_common", "accessor"), None)
    if array is None or accessor is None or accessor.get("source") != f"#{array.get('id')}":
        raise ValueError("a mesh has no positions of its own")
    names = [one.get("name") for one in accessor.all("param")]
    if names != ["X", "Y", "Z"] or accessor.get("stride") != "3" or accessor.get("offset") not in {"", "0"}:
        raise ValueError("positions do not have three coordinates, X, Y and Z")
    numbers = _numbers(array.text, _REALS, file.budget)
    if len(numbers) != _count(array) or len(numbers) != 3 * _count(accessor):
        raise ValueError("a mesh has not as many positions as it says")
    return numbers.reshape(-1, 3)


def _faces(file: _File, primitive: Node) -> NDArray[np.int64]:
    """Triangles of a primitive, three indices of positions each; polygons as fans."""
    inputs = [(one.get("semantic"), _whole(one.attributes.get("offset", "0"))) for one in primitive.all("input")]
    corners = [offset for semantic, offset in inputs if semantic == "VERTEX"]
    stride = 1 + max((offset for _, offset in inputs), default=0)
    if len(corners) != 1 or stride > 100:
        raise ValueError(f"`{primitive.tag}` has not one input of vertices")
    runs: list[NDArray[np.int64]] = []
    for each in primitive.all("p"):
        index = _numbers(each.text, _INDICES, file.budget).astype(np.int64)
        if len(index) % stride:
            raise ValueError(f"`{primitive.tag}` ends within a corner")
        runs.append(index.reshape(-1, stride)[:, corners[0]])
    count = _count(primitive)
    if primitive.tag in {"triangles", "polylist"}:
        index = np.concatenate([np.zeros(0, np.int64), *runs])
        if primitive.tag == "triangles":
            sizes = np.full(min(count, len(index) + 1), 3)
        else:
            sizes = np.concatenate(
                [np.zeros(0), *(_numbers(one.text, _INDICES, file.budget) for one in primitive.all("vcount"))]
            ).astype(np.int64)
        if len(sizes) != count or int(sizes.sum()) != len(index):
            raise ValueError(f"`{primitive.tag}` has not as many corners as it says")
        return _fans(file, index, sizes)
    if len(runs) != count:
        raise ValueError(f"`{primitive.tag}` has not as many rows as it says")
    if primitive.tag == "tristrips":
        strips = [np.stack([run[:-2], run[1:-1], run[2:]], axis=1) for run in runs if len(run) > 2]
        return np.concatenate([np.zeros((0, 3), np.int64), *strips])
    sizes = np.array([len(run) for run in runs], dtype=np.int64)
    return _fans(file, np.concatenate([np.zeros(0, np.int64), *runs]), sizes)


def _fans(file: _File, index: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles of polygons that stand one after the other: `sizes` corners each; of fewer than three, none."""
    file.budget.take(8 * 3 * len(index))
    triangles = np.maximum(sizes - 2, 0)
    starts = np.repeat(np.cumsum(sizes) - sizes, triangles)
    within = np.arange(len(starts)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([index[starts], index[starts + within + 1], index[starts + within + 2]], axis=1)


def _numbers(text: str, pattern: re.Pattern[str], budget: Budget) -> NDArray[np.float64]:
    """The numbers of a text, thousands at once."""
    text += " "
    runs: list[NDArray[np.float64]] = [np.zeros(0)]
    at = 0
    while at < len(text) and not text.isspace():
        match = pattern.match(text, at)
        if match is None:
            raise ValueError(f"`{text[at : at + 40].split()[0]}` is no number that belongs there")
        runs.append(floats(match[0].encode()))
        budget.take(runs[-1].nbytes)
        at = match.end()
    return np.concatenate(runs)


def _exactly(text: str, count: int, what: str) -> NDArray[np.float64]:
    numbers = _numbers(text[:2000], _REALS, Budget(2**20, Total(2**22)))
    if len(numbers) != count:
        raise ValueError(f"`{what}` has {len(numbers)} numbers, and {count} belong there")
    if not np.isfinite(numbers).all():
        raise AssetError("SC414", f"`{what}` has numbers that are not finite", "export the mesh again")
    return numbers


def _count(node: Node) -> int:
    return _whole(node.get("count"))


def _whole(text: str) -> int:
    if re.fullmatch(r"[0-9]{1,9}", text) is None:
        raise ValueError(f"`{text[:40]}` is no count")
    return int(text)


def _moved(one: Part, place: NDArray[np.float64]) -> Part:
    with np.errstate(all="ignore"):
        return Part((one.vertices @ place[:3, :3].T + place[:3, 3]).astype(np.float32), one.faces)
