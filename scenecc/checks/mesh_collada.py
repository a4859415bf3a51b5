"""Reader for COLLADA (`.dae`) visual meshes: bounded XML, triangles as the engine places them, and image references.

Files that SAPIEN's reader misreads or crashes on are refused: cyclic nodes, scenes without geometry, and textures
without an image.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pyexpat import ExpatError, ParserCreate
from typing import TYPE_CHECKING
from urllib.parse import unquote

import numpy as np

from scenecc.checks.mesh_data import (
    EXPONENT_PATTERN,
    MAX_RUN_LINES,
    NUMBER_PATTERN,
    AssetBudget,
    AssetError,
    AssetReference,
    MeshBudget,
    MeshData,
    MeshFilePart,
    MeshReadContext,
    Precision,
    make_part,
    parse_floats,
    strip_triangles,
    transform_part,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray


DEPTH, ELEMENTS, EQUALS = 100, 100_000, 400_000
"""How many elements stand inside one another and in all, and signs `=` in the text, no fewer than the attributes."""

_PARSE_SIZE = 2**20

_TEXT_BREAK = "\0"
"""Stands in the text of an element where something else does. XML itself has no such character."""

_ELEMENT_BYTES = 1024
"""About what an element takes."""


@dataclass(frozen=True, slots=True, eq=False)
class ColladaElement:
    """An element: its name as written, its attributes, and the elements and pieces of text right inside."""

    tag: str
    attributes: dict[str, str]
    children: list[ColladaElement] = field(default_factory=list["ColladaElement"])
    characters: list[str] = field(default_factory=list[str])

    @property
    def text(self) -> str:
        """The text right inside, without blanks at its ends."""
        return "".join(self.characters).strip()

    def get(self, attribute: str) -> str:
        """An attribute; empty where there is none."""
        return self.attributes.get(attribute, "")

    def all(self, *path: str) -> Iterator[ColladaElement]:
        """The elements at a path of names from here, in order."""
        for child in self.children:
            if child.tag == path[0]:
                if len(path) == 1:
                    yield child
                else:
                    yield from child.all(*path[1:])

    def walk(self) -> Iterator[ColladaElement]:
        """This element and all inside it."""
        yield self
        for child in self.children:
            yield from child.walk()


def elements_by_id(root: ColladaElement, library: str, tag: str) -> dict[str, ColladaElement]:
    """The elements of a library by their id.

    Raises:
        ValueError: two have the same.
    """
    found: dict[str, ColladaElement] = {}
    for node in root.all(library, tag):
        name = node.get("id")
        if name and found.setdefault(name, node) is not node:
            raise ValueError(f"two elements have the id `{name[:60]}`")
    return found


def parse_collada_xml(data: bytes, budget: MeshBudget) -> ColladaElement:
    """The root element.

    Raises:
        AssetError: SC412, it is no well-formed UTF-8 XML or has a document type; SC607, it is too large.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    if data.count(b"=") > EQUALS:
        raise AssetError("SC607", f"it has more than {EQUALS} attributes", "simplify the mesh")
    budget.take(len(data))
    root: list[ColladaElement] = []
    opened: list[ColladaElement] = []
    count = 0
    parser = ParserCreate("utf-8")
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        """Opens an element, among the children of the one that is open; AssetError (SC607) where there are too many."""
        nonlocal count
        count += 1
        if count > ELEMENTS or len(opened) >= DEPTH:
            most = f"{ELEMENTS} elements" if count > ELEMENTS else f"{DEPTH} elements inside one another"
            raise AssetError("SC607", f"it has more than {most}", "simplify the mesh")
        budget.take(_ELEMENT_BYTES)
        node = ColladaElement(tag, attributes)
        (opened[-1].children if opened else root).append(node)
        opened.append(node)

    def end(_tag: str) -> None:
        _check_text(opened.pop())

    def broken(*_: object) -> None:
        if opened:
            opened[-1].characters.append(_TEXT_BREAK)

    def text(characters: str) -> None:
        opened[-1].characters.append(characters)

    def doctype(*_: object) -> None:
        raise ValueError("it has a document type, which may declare entities and name files")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CommentHandler = parser.ProcessingInstructionHandler = parser.StartCdataSectionHandler = broken
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = text, doctype
    try:
        for at in range(0, len(data) + 1, _PARSE_SIZE):
            parser.Parse(data[at : at + _PARSE_SIZE], at + _PARSE_SIZE > len(data))
    except (ExpatError, ValueError) as error:
        raise AssetError("SC412", f"the XML cannot be read: {error}", "export the mesh again") from error
    return root[0]


def _check_text(node: ColladaElement) -> None:
    """Joins the text of an element, which is in one piece: of several the engine's reader takes the first."""
    pieces = "".join(node.characters).split(_TEXT_BREAK)
    if sum(map(bool, map(str.strip, pieces))) > bool(not node.children):
        raise ValueError(f"the text of `{node.tag[:40]}` is interrupted by an element, a comment or a CDATA section")
    if len(pieces) > 1:
        node.characters[:] = ["".join(pieces)]


_INVALID_FILE_NAME = re.compile(r"[\x00-\x1f\x7f]|%(?![0-9A-Fa-f]{2}.)|^\s|\s$")
"""What SAPIEN's reader keeps or decodes otherwise: controls, blanks at the ends, an escape with nothing behind it."""


def collada_images(root: ColladaElement) -> tuple[AssetReference, ...]:
    """The files of all images, percent escapes decoded as SAPIEN's reader decodes those of a COLLADA.

    Raises:
        AssetError: an image is in the COLLADA itself.
        ValueError: a texture does not lead to an image: SAPIEN would open a file of the texture's own name.
    """
    newer = root.get("version").startswith("1.5")
    images = elements_by_id(root, "library_images", "image")
    for effect in root.all("library_effects", "effect"):
        leads = {
            node.get("sid"): _parameter_target(node, newer=newer) for node in effect.all("profile_COMMON", "newparam")
        }
        for texture in (node for node in effect.walk() if node.tag == "texture"):
            target, steps = texture.get("texture"), 0
            while target in leads and steps <= len(leads):
                target, steps = leads[target], steps + 1
            if target not in images or steps > len(leads):
                raise ValueError(f"the texture `{texture.get('texture')[:60]}` does not lead to an image")
    listed = list(root.all("library_images", "image"))
    if sum(node.tag == "image" for node in root.walk()) != len(listed):
        raise ValueError("an image is outside `library_images`")
    names = (_image_file(image, newer=newer) for image in listed)
    return tuple(AssetReference(name, "image") for name in dict.fromkeys(names))


def _parameter_target(parameter: ColladaElement, *, newer: bool) -> str:
    """What a parameter of an effect stands for: another one, or an image."""
    if newer:
        return next((one.get("url").removeprefix("#") for one in parameter.all("sampler2D", "instance_image")), "")
    leads = (*parameter.all("surface", "init_from"), *parameter.all("sampler2D", "source"))
    return leads[0].text if leads else ""


def _image_file(image: ColladaElement, *, newer: bool) -> str:
    named = [node for node in image.walk() if node.tag == ("ref" if newer else "init_from")]
    found = next(image.all("init_from", "ref") if newer else image.all("init_from"), None)
    if len(named) > 1:
        raise ValueError(f"the image `{image.get('id')[:60]}` names several files")
    if found is None or not found.text:
        raise AssetError(
            "SC410", "an image of the COLLADA is not in a file of its own", "save it as a PNG file and refer to that"
        )
    written = "".join(found.characters)
    name = unquote(written)
    if _INVALID_FILE_NAME.search(written) or _INVALID_FILE_NAME.search(name.replace("%", "")):
        raise ValueError(f"`{found.text[:60]!a}` is not a valid file name")
    return name


_REAL_PATTERN = rf"(?:{NUMBER_PATTERN.decode()}|[-+]?\.[0-9]+{EXPONENT_PATTERN.decode()}|[-+]?(?:NaN|INF))"

_REALS_PATTERN = re.compile(rf"(?:{_REAL_PATTERN}[ \t\r\n]+){{1,{MAX_RUN_LINES}}}")

_INDICES_PATTERN = re.compile(rf"(?:[0-9]{{1,9}}[ \t\r\n]+){{1,{MAX_RUN_LINES}}}")

_FACE_PRIMITIVES = ("triangles", "polylist", "polygons", "tristrips", "trifans")

_MAX_NODE_DEPTH = 200

_INSTANCE_COST = 2**16
"""What a node and a geometry count for each time that they are placed: a small file may place them very often."""


@dataclass(frozen=True, slots=True)
class _ColladaFile:
    root: ColladaElement
    budget: MeshBudget
    precision: Precision


def read_collada(data: bytes, reading: MeshReadContext) -> MeshData:
    """Reads a COLLADA of version 1.4 or 1.5. A part is a primitive of a geometry, placed by one node [m].

    Its unit is heeded, as SAPIEN heeds it, and its `up_axis` is not, as SAPIEN turns nothing.

    Args:
        data: the file.
        reading: how much its triangles may take; its images are read by no one here.

    Raises:
        AssetError: it is not what COLLADA says, or too large, or holds what is not read.
    """
    budget = MeshBudget(reading.max_bytes, reading.total)
    file = _ColladaFile(parse_collada_xml(data, budget), budget, reading.precision)
    try:
        _check_document(file.root)
        images = collada_images(file.root)
        return MeshData(_read_parts(file), images)
    except ValueError as error:
        raise AssetError("SC412", f"the COLLADA cannot be read: {error}", "export the mesh again") from error


def _check_document(root: ColladaElement) -> None:
    if root.tag != "COLLADA":
        raise ValueError(f"its first element is `{root.tag[:40]}`")
    if not root.get("version").startswith(("1.4", "1.5")):
        raise ValueError(f"its version is `{root.get('version')[:40]}`, and only 1.4 and 1.5 are supported")


def _read_parts(file: _ColladaFile) -> tuple[MeshFilePart, ...]:
    """Every primitive, once for each node that shows it."""
    root = file.root
    geometries = elements_by_id(root, "library_geometries", "geometry")
    library = elements_by_id(root, "library_nodes", "node")
    scenes = elements_by_id(root, "library_visual_scenes", "visual_scene")
    chosen = [_find_target(one, scenes) for one in root.all("scene", "instance_visual_scene")]
    if len(chosen) != 1:
        raise ValueError("it does not have exactly one visual scene")
    start = np.eye(4) * _read_unit(root)
    start[3, 3] = 1
    waiting = [(node, start, 0) for node in chosen[0].all("node")]
    shown: dict[str, list[MeshFilePart]] = {}
    parts: list[MeshFilePart] = []
    while waiting:
        node, above, depth = waiting.pop()
        file.budget.take(_INSTANCE_COST)
        if depth > _MAX_NODE_DEPTH:
            raise ValueError("its nodes are cyclic or nested too deeply")
        place = above @ _node_transform(node)
        inside = [*node.all("node"), *(_find_target(one, library) for one in node.all("instance_node"))]
        waiting.extend((child, place, depth + 1) for child in inside)
        if next(node.all("instance_controller"), None) is not None:
            raise AssetError("SC410", "the COLLADA has a skin or a morph", "export the mesh alone, as GLB")
        for instance in node.all("instance_geometry"):
            geometry = _find_target(instance, geometries)
            name = geometry.get("id")
            if name not in shown:
                shown[name] = _read_geometry(file, geometry)
            file.budget.take(_INSTANCE_COST + sum(one.vertices.nbytes + one.faces.nbytes for one in shown[name]))
            parts.extend(transform_part(one, place, file.precision) for one in shown[name])
    return tuple(parts)


def _find_target(instance: ColladaElement, known: dict[str, ColladaElement]) -> ColladaElement:
    url = instance.get("url")
    if not url.startswith("#") or url[1:] not in known:
        raise ValueError(f"`{instance.tag}` names `{url[:60]}`, which is not in the file's library")
    return known[url[1:]]


def _read_unit(root: ColladaElement) -> float:
    found = next(root.all("asset", "unit"), None)
    text = "1" if found is None else found.attributes.get("meter", "1")
    (size,) = _parse_vector(text, 1, "the unit")
    if not size > 0:
        raise ValueError(f"its unit is `{text[:40]}` metres")
    return float(size)


def _node_transform(node: ColladaElement) -> NDArray[np.float64]:
    """Where a node stands in the one above it: what its elements say, one after the other."""
    place = np.eye(4)
    for step in node.children:
        turn = np.eye(4)
        match step.tag:
            case "translate":
                turn[:3, 3] = _parse_vector(step.text, 3, step.tag)
            case "scale":
                turn[:3, :3] = np.diag(_parse_vector(step.text, 3, step.tag))
            case "matrix":
                turn = _parse_vector(step.text, 16, step.tag).reshape(4, 4)
            case "rotate":
                turn[:3, :3] = _rotation_matrix(_parse_vector(step.text, 4, step.tag))
            case "lookat" | "skew":
                raise AssetError("SC410", f"the COLLADA places a node by `{step.tag}`", "export the mesh as GLB")
            case _:
                continue
        place = place @ turn
    return place


def _rotation_matrix(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """A turn about an axis by an angle [degrees]."""
    length = float(np.linalg.norm(numbers[:3]))
    if length == 0:
        return np.eye(3)
    x, y, z = numbers[:3] / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.deg2rad(numbers[3])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _read_geometry(file: _ColladaFile, geometry: ColladaElement) -> list[MeshFilePart]:
    found: list[MeshFilePart] = []
    for mesh in geometry.all("mesh"):
        points: NDArray[np.float64] | None = None
        for primitive in (child for child in mesh.children if child.tag in _FACE_PRIMITIVES):
            faces = _read_faces(file, primitive)
            if points is None:
                points = _read_positions(file, mesh)
            if len(faces):
                found.append(make_part(points, faces, file.precision))
    return found


def _read_positions(file: _ColladaFile, mesh: ColladaElement) -> NDArray[np.float64]:
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
    numbers = _parse_numbers(array.text, _REALS_PATTERN, file.budget)
    if len(numbers) != _read_count(array) or len(numbers) != 3 * _read_count(accessor):
        raise ValueError("the number of positions of a mesh differs from its `count`")
    return numbers.reshape(-1, 3)


def _read_faces(file: _ColladaFile, primitive: ColladaElement) -> NDArray[np.int64]:
    """Triangles of a primitive, three indices of positions each; polygons as fans."""
    inputs = [(one.get("semantic"), _parse_count(one.attributes.get("offset", "0"))) for one in primitive.all("input")]
    corners = [offset for semantic, offset in inputs if semantic == "VERTEX"]
    stride = 1 + max((offset for _, offset in inputs), default=0)
    if len(corners) != 1 or stride > 100:
        raise ValueError(f"`{primitive.tag}` does not have exactly one VERTEX input")
    runs: list[NDArray[np.int64]] = []
    for each in primitive.all("p"):
        index = _parse_numbers(each.text, _INDICES_PATTERN, file.budget).astype(np.int64)
        if len(index) % stride:
            raise ValueError(f"`{primitive.tag}` has an incomplete last vertex")
        runs.append(index.reshape(-1, stride)[:, corners[0]])
    count = _read_count(primitive)
    if primitive.tag in {"triangles", "polylist"}:
        index = np.concatenate([np.zeros(0, np.int64), *runs])
        if primitive.tag == "triangles":
            sizes = np.full(min(count, len(index) + 1), 3)
        else:
            sizes = np.concatenate(
                [
                    np.zeros(0),
                    *(_parse_numbers(one.text, _INDICES_PATTERN, file.budget) for one in primitive.all("vcount")),
                ]
            ).astype(np.int64)
        if len(sizes) != count or int(sizes.sum()) != len(index):
            raise ValueError(f"`{primitive.tag}` has a different number of vertices than it declares")
        return _triangulate(file, index, sizes)
    if len(runs) != count:
        raise ValueError(f"`{primitive.tag}` has a different number of `p` elements than it declares")
    if primitive.tag == "tristrips":
        return np.concatenate([np.zeros((0, 3), np.int64), *map(strip_triangles, runs)])
    sizes = np.array([len(run) for run in runs], dtype=np.int64)
    return _triangulate(file, np.concatenate([np.zeros(0, np.int64), *runs]), sizes)


def _triangulate(file: _ColladaFile, index: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles of polygons that stand one after the other: `sizes` corners each; of fewer than three, none."""
    file.budget.take(8 * 3 * len(index))
    triangles = np.maximum(sizes - 2, 0)
    starts = np.repeat(np.cumsum(sizes) - sizes, triangles)
    within = np.arange(len(starts)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([index[starts], index[starts + within + 1], index[starts + within + 2]], axis=1)


def _parse_numbers(text: str, pattern: re.Pattern[str], budget: MeshBudget) -> NDArray[np.float64]:
    """The numbers of a text, thousands at once."""
    text += " "
    runs: list[NDArray[np.float64]] = [np.zeros(0)]
    at = 0
    while at < len(text) and not text.isspace():
        match = pattern.match(text, at)
        if match is None:
            raise ValueError(f"`{text[at : at + 40].split()[0]}` is not a valid number here")
        runs.append(parse_floats(match[0].encode()))
        budget.take(runs[-1].nbytes)
        at = match.end()
    return np.concatenate(runs)


def _parse_vector(text: str, count: int, what: str) -> NDArray[np.float64]:
    numbers = _parse_numbers(text[:2000], _REALS_PATTERN, MeshBudget(2**20, AssetBudget(2**22)))
    if len(numbers) != count:
        raise ValueError(f"`{what}` has {len(numbers)} numbers instead of {count}")
    if not np.isfinite(numbers).all():
        raise AssetError("SC414", f"`{what}` has numbers that are not finite", "export the mesh again")
    return numbers


def _read_count(node: ColladaElement) -> int:
    return _parse_count(node.get("count"))


def _parse_count(text: str) -> int:
    if re.fullmatch(r"[0-9]{1,9}", text) is None:
        raise ValueError(f"`{text[:40]}` is not a valid count")
    return int(text)
