"""File names in mesh files: a strict scan that finds every file that SAPIEN's readers would open.

It rejects a file that SAPIEN could read differently. It does not read geometry.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
import struct
from collections.abc import Iterator, Sized
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, cast
from urllib.parse import unquote
from xml.etree import ElementTree as ET

from scenecc.assets.errors import AssetError, AssetReference
from scenecc.assets.obj_materials import MATERIAL_LINE, image_of_line

MOST_NAMES = 4096
"""Largest number of files that a mesh may name. Each is looked up, and each error is reported."""


def check_count(names: Sized) -> None:
    """Raises AssetError if a mesh names too many files."""
    if len(names) > MOST_NAMES:
        raise AssetError("SC607", f"the mesh names more than {MOST_NAMES} files", "split the mesh")


@dataclass(frozen=True, slots=True)
class MeshNames:
    """Names and embedded images in a mesh file.

    Attributes:
        references: the files that it names.
        images: content of its embedded images.
        visual_fault: why it cannot be rendered, though it can still collide.
    """

    references: tuple[AssetReference, ...] = ()
    images: tuple[bytes, ...] = ()
    visual_fault: AssetError | None = None


def scan_names(data: bytes, suffix: str) -> MeshNames:
    """Returns the files that a mesh file names. `suffix`: in lower case.

    Raises:
        AssetError: the file is broken (SC412), has content that SAPIEN does not read (SC410), or names too many
            (SC607).
    """
    _check_content(data, suffix)
    names = MeshNames()
    try:
        match suffix:
            case ".obj":
                names = MeshNames(tuple(_obj_names(data)))
            case ".gltf" | ".glb":
                names = _gltf_names(data)
            case ".dae":
                names = MeshNames(tuple(AssetReference(name, "image") for name in _collada_names(data)))
            case ".ply":
                _check_ply_data(data)
                names = MeshNames(visual_fault=_ply_fault(data))
            case _:
                pass
    except _RepeatedKeyError as error:
        message = f"the key {error} occurs twice in one object"
        raise AssetError("SC412", f"the mesh cannot be read: {message}", "export the mesh again") from error
    except (ValueError, TypeError, AttributeError, RecursionError, struct.error, ET.ParseError) as error:
        message = _plain_words(error)
        raise AssetError("SC412", f"the mesh cannot be read: {message}", "export the mesh again") from error
    check_count(names.references)
    return names


def _plain_words(error: Exception) -> str:
    """Returns an error's text. Python's own errors about text are reworded for users."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    if isinstance(error, UnicodeDecodeError):
        return "its text is not in UTF-8"
    if isinstance(error, json.JSONDecodeError):
        return f"its JSON is damaged in line {error.lineno}, column {error.colno}"
    return str(error)


_OTHER_CONTENTS = (
    (re.compile(rb"\s*\Z"), (".obj",), "empty", "download or export it again"),
    (re.compile(rb"version https://git-lfs"), (), "a pointer of Git LFS", "run `git lfs pull`"),
    (re.compile(rb"\s*<(?:!DOCTYPE html|html)\b", re.IGNORECASE), (), "an HTML page", "download the file itself"),
    (re.compile(rb"glTF"), (".glb", ".gltf"), "a GLB", "give it the suffix .glb"),
    (re.compile(rb"ply\r?\n"), (".ply",), "a PLY", "give it the suffix .ply"),
    (re.compile(rb"\s*(?:<\?xml\b[^>]*>\s*)?<COLLADA\b"), (".dae",), "a COLLADA", "give it the suffix .dae"),
    (re.compile(rb"\s*(?:#[^\n]*\n\s*)*(?:mtllib|o|g|v)[ \t]"), (".obj", ".stl"), "an OBJ", "give it the suffix .obj"),
    (re.compile(rb"\s*solid\s[^\0]*?\bfacet\b"), (".stl",), "an STL", "give it the suffix .stl"),
)
"""Beginnings of files, their valid suffixes, the format, and a hint. A binary STL may begin with any words."""


def _check_content(data: bytes, suffix: str) -> None:
    """Raises AssetError if a file begins like one of another format."""
    for beginning, suffixes, what, hint in _OTHER_CONTENTS:
        if suffix not in suffixes and beginning.match(data) is not None:
            raise AssetError("SC412", f"the mesh cannot be read: it is {what}", hint)


_CONTROL_CHARACTER = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")

_LONE_RETURN = re.compile(rb"\r(?![\r\n])")


def _check_text(data: bytes) -> None:
    """Raises ValueError if SAPIEN could split the lines differently from this scan."""
    if _CONTROL_CHARACTER.search(data) is not None:
        raise ValueError("it contains control characters, so it is not text")
    if b"\r" in data and _LONE_RETURN.search(data) is not None:
        raise ValueError("it has a carriage return without a line feed, which only SAPIEN treats as a line end")


_LINE_GOES_ON = re.compile(rb"\\\r*\n")


def _obj_names(data: bytes) -> Iterator[AssetReference]:
    """Yields the material files of an OBJ."""
    _check_text(data)
    found: list[tuple[bytes, bytes]] = MATERIAL_LINE.findall(data)
    # SAPIEN joins a line that ends in a backslash with the next, and then finds different names.
    if b"\\" in data and found != MATERIAL_LINE.findall(_LINE_GOES_ON.sub(b"", data)):
        raise ValueError("a line of `mtllib` ends in a backslash, which continues it on the next line")
    if any(blank for blank, _ in found):
        raise ValueError("`mtllib` follows a blank, and SAPIEN's reader skips these lines")
    for name in dict.fromkeys(name for _, name in found):
        yield AssetReference(name.decode("utf-8", "replace"), "material")


def material_images(data: bytes) -> tuple[AssetReference, ...]:
    """Returns the images that an MTL names. SAPIEN looks for them next to the OBJ.

    Raises:
        AssetError: it is not text, SAPIEN misreads a line, or there are too many.
    """
    names: dict[str, None] = {}
    try:
        _check_text(data)
        for line in data.decode("utf-8", "replace").split("\n"):
            names[image_of_line(line.lstrip(" \t").rstrip("\r"))] = None
            check_count(names)
    except ValueError as error:
        message = f"the MTL cannot be read: {error}"
        raise AssetError("SC412", message, "export the mesh again") from error
    return tuple(AssetReference(name, "image") for name in names if name)


_COMPRESSIONS = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}


class _RepeatedKeyError(ValueError):
    """A key occurs twice in one object. The error's text is the key."""


def _reject_repeated_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _RepeatedKeyError(next(repr(key[:80]) for key in found if keys.count(key) > 1))
    return found


def _gltf_names(data: bytes) -> MeshNames:
    """Returns every `uri` of a glTF: buffers and images, including those of extensions."""
    text, chunk = _split_chunks(data)
    # If a key occurs twice, SAPIEN's reader takes the first value and Python the last.
    document: Any = json.loads(text.decode(), object_pairs_hook=_reject_repeated_keys, parse_constant=_reject_constant)
    if not isinstance(document, dict):
        raise ValueError("it is not a JSON object")  # noqa: TRY004 - of the file, not of an argument
    whole = cast("dict[str, Any]", document)
    version = whole.get("asset", {}).get("version")
    if not isinstance(version, str) or not version.startswith("2."):
        raise ValueError(f"its glTF version is `{version!s:.40}`, but only 2 is supported")
    packed = _COMPRESSIONS & set(map(str, _list(whole, "extensionsUsed")))
    if packed:
        raise AssetError("SC410", f"the glTF is compressed with {min(packed)}", "export it without mesh compression")
    _check_primitives(whole)
    _check_nodes(whole)
    buffers = [uri for buffer in _list(whole, "buffers") for uri in _uris(buffer)]
    if data[:4] == b"glTF" and any(_uris(_list(whole, "buffers")[:1])):
        raise ValueError("its first buffer refers to a file, but is the binary chunk")
    others = [uri for key, value in whole.items() if key != "buffers" for uri in _uris(value)]
    references = [_reference(uri, "buffer") for uri in buffers if not uri.startswith("data:")]
    references += [_reference(uri, "image") for uri in others if not uri.startswith("data:")]
    embedded = [_decode_data_uri(uri) for uri in others if uri.startswith("data:")]
    embedded += [_view(whole, image["bufferView"], chunk) for image in _list(whole, "images") if "bufferView" in image]
    return MeshNames(tuple(dict.fromkeys(references)), tuple(image for image in embedded if image is not None))


def _reject_constant(word: str) -> NoReturn:
    raise ValueError(f"`{word}` is not JSON")


_TRIANGLE_FAN = 6


def _check_primitives(document: dict[str, Any]) -> None:
    """Raises AssetError for triangle fans and sparse positions, which trimesh skips."""
    accessors = _list(document, "accessors")
    for primitive in (one for mesh in _list(document, "meshes") for one in _list(mesh, "primitives")):
        if primitive.get("mode") == _TRIANGLE_FAN:
            raise AssetError("SC410", "the glTF has a triangle fan", "export it with plain triangles")
        number = primitive.get("attributes", {}).get("POSITION")
        if isinstance(number, int) and 0 <= number < len(accessors) and "sparse" in accessors[number]:
            raise AssetError("SC410", "the glTF has sparse positions", "export it without sparse accessors")


def _check_nodes(document: dict[str, Any]) -> None:
    """Raises ValueError if a node has two parents: 40 of them could show a mesh a billion times."""
    seen: set[int] = set()
    for child in (child for node in _list(document, "nodes") for child in _list(node, "children")):
        if child in seen:
            raise ValueError(f"its node {child} has two parents")
        seen.add(child)


def _split_chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """Returns the JSON of a glTF, and the binary chunk of a GLB."""
    if data[:4] != b"glTF":
        if not data.lstrip().startswith(b"{"):
            raise ValueError("it is neither a GLB nor the JSON of a glTF")
        return data, None
    _, version, length, size, kind = struct.unpack_from("<4sIII4s", data)
    if version != 2 or length > len(data) or kind != b"JSON" or 20 + size > length:
        raise ValueError(f"its header declares version {version} and {length} bytes, but it has {len(data)} bytes")
    start = 20 + size
    if start + 8 > length:
        return data[20:start], None
    count, kind = struct.unpack_from("<I4s", data, start)
    if kind != b"BIN\0" or start + 8 + count > length:
        raise ValueError("its second chunk is not binary, or truncated")
    return data[20:start], data[start + 8 : start + 8 + count]


def _list(node: dict[str, Any], key: str) -> list[Any]:
    found = node.get(key, [])
    if not isinstance(found, list):
        raise ValueError(f"`{key}` is not a list")  # noqa: TRY004
    return cast("list[Any]", found)


def _uris(value: object) -> Iterator[str]:
    """Yields the values of all keys `uri`, at any depth."""
    if isinstance(value, list):
        for one in cast("list[object]", value):
            yield from _uris(one)
    elif isinstance(value, dict):
        for key, one in cast("dict[str, object]", value).items():
            if key == "uri" and isinstance(one, str):
                yield one
            else:
                yield from _uris(one)


def _reference(uri: str, kind: Literal["image", "buffer"]) -> AssetReference:
    if _CONTROL.search(uri) is not None:
        raise ValueError(f"`{uri[:60]!a}` is not a valid file name")
    return AssetReference(uri, kind, escaped=unquote(uri) != uri)


def _view(document: dict[str, Any], number: object, chunk: bytes | None) -> bytes | None:
    """Returns the content of a buffer view; None: it is in another file or a `data:` URI."""
    views = _list(document, "bufferViews")
    if not isinstance(number, int) or not 0 <= number < len(views):
        raise ValueError("an image refers to a missing buffer view")
    view = views[number]
    start, size = view.get("byteOffset", 0), view.get("byteLength")
    if view.get("buffer") != 0 or chunk is None:
        return None
    if not isinstance(start, int) or not isinstance(size, int) or not 0 <= start <= start + size <= len(chunk):
        raise ValueError("a buffer view reaches past the end of its buffer")
    return chunk[start : start + size]


def _decode_data_uri(uri: str) -> bytes:
    head, comma, body = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise ValueError("a data: URI is not base64")
    try:
        return base64.b64decode(body, validate=True)
    except binascii.Error as error:
        raise ValueError(f"a data: URI is not base64: {error}") from error


_LINE_BREAK_FIRST = re.compile(rb"end_header\r?\n[\r\n]")


def _check_ply_data(data: bytes) -> None:
    """Raises ValueError if it is not a PLY, or if its binary data begins with the byte of a line break.

    SAPIEN skips that byte, and may crash.
    """
    if not data.startswith(b"ply"):
        raise ValueError("it does not begin with `ply`")
    # Two searches, because the time of one combined pattern grows with the square of the file size.
    start = data.find(b"format binary_")
    if start >= 0 and _LINE_BREAK_FIRST.search(data, start) is not None:
        raise ValueError("the first byte of its data equals a line break, which SAPIEN takes as part of the header")


def _ply_fault(data: bytes) -> AssetError | None:
    # SAPIEN and other readers disagree on where a header ends.
    if b"texturefile" not in data.lower():
        return None
    what = "its header names a texture, which SAPIEN does not read reliably"
    return AssetError("SC410", what, "export it as GLB, or remove the comment")


_CONTROL = re.compile(r"[\x00-\x1f\x7f]")

_INVALID_FILE_NAME = re.compile(r"[\x00-\x1f\x7f]|%(?![0-9A-Fa-f]{2}.)|^\s|\s$")
"""Characters that SAPIEN's reader keeps or decodes differently: controls, outer blanks, an incomplete escape."""


_XML_ENCODING = re.compile(rb"""<\?xml\b[^>]*?\bencoding\s*=\s*["']([^"']*)""")

_PREFIXED = re.compile(
    rb"</?[^\s<>/:]+:(?:newparam|surface|sampler2D|source|init_from|instance_image|image|ref|effect|texture|"
    rb"profile_COMMON|technique|library_images|library_effects|COLLADA|node|geometry|asset|unit)[\s/>]"
)


def _collada_names(data: bytes) -> list[str]:
    """Returns the images of a COLLADA, with percent escapes decoded as in SAPIEN's reader."""
    if b"<!" in data.replace(b"<!--", b""):
        raise ValueError("it has a document type or CDATA sections")
    declared = _XML_ENCODING.match(data)
    if declared is not None and declared[1].lower() not in {b"utf-8", b"utf8"} and not data.isascii():
        raise ValueError("its encoding is not UTF-8, but SAPIEN's reader assumes UTF-8")
    if _PREFIXED.search(data) is not None:
        raise ValueError("its elements have a namespace prefix, which SAPIEN's reader does not support")
    builder = ET.TreeBuilder(insert_comments=True, insert_pis=True)
    parser = ET.XMLParser(target=builder, encoding="utf-8")  # noqa: S314 - no document type, so no entities
    parser.feed(data)
    root = parser.close()
    for node in root.iter():
        tag: Any = node.tag
        if isinstance(tag, str):  # tags of comments and instructions are functions
            node.tag = tag.rpartition("}")[2]
    unit = root.find("asset/unit")
    if unit is not None and not float(unit.get("meter", "1")) > 0:
        raise ValueError(f"its unit is `{unit.get('meter'):.40}` metres")
    instances = {node.get("url", "")[1:] for node in root.iter("instance_node")}
    for tag in ("geometry", "node", "visual_scene", "image"):
        ids = [node.get("id") for node in root.iter(tag) if node.get("id")]
        # Nodes with one id are distinct unless one of them is instanced.
        if len(set(ids)) < len(ids) and (tag != "node" or any(ids.count(one) > 1 for one in instances)):
            raise ValueError(f"two of its elements `{tag}` have the same id")
    version = root.get("version", "")
    newer = version.startswith("1.5")
    if not newer and not version.startswith(("1.3", "1.4")):
        raise ValueError(f"its version is `{version[:20]}`, but only 1.4 and 1.5 are supported")
    listed = root.findall("library_images/image")
    if sum(1 for _ in root.iter("image")) != len(listed):
        raise ValueError("an image is outside `library_images`")
    images = {image.get("id", ""): image for image in listed}
    for effect in root.findall("library_effects/effect"):
        _check_textures(effect, images, newer=newer)
    return list(dict.fromkeys(_image_file(image, newer=newer) for image in listed))


def _check_textures(effect: Any, images: dict[str, Any], *, newer: bool) -> None:
    """Raises ValueError if a texture does not lead to an image: SAPIEN would open a file of the texture's name."""
    parameters = effect.findall("profile_COMMON/newparam")
    leads = {node.get("sid", ""): _parameter_target(node, newer=newer) for node in parameters}
    if len(leads) < sum(1 for _ in effect.iter("newparam")):
        raise ValueError("an effect has two parameters of one name, or one outside of its profile")
    for texture in effect.iter("texture"):
        target, steps = texture.get("texture", ""), 0
        while target in leads and steps <= len(leads):
            target, steps = leads[target], steps + 1
        if target not in images or steps > len(leads):
            raise ValueError(f"the texture `{texture.get('texture', '')[:60]}` does not lead to an image")


def _parameter_target(parameter: Any, *, newer: bool) -> str:
    """Returns what a parameter of an effect refers to: another parameter, or an image."""
    places = ("sampler2D/instance_image",) if newer else ("surface/init_from", "sampler2D/source")
    leads = [node for place in places for node in parameter.findall(place)]
    others = sum(1 for node in parameter.iter() if node.tag in {"init_from", "source", "instance_image"})
    if len(leads) != others or others > 1:
        raise ValueError("a parameter of an effect refers to several images, or to one of another version of COLLADA")
    if not leads:
        return ""
    if newer:
        return leads[0].get("url", "").removeprefix("#")
    name = _whole_text(leads[0])
    if name != name.strip():
        raise ValueError("a parameter's reference begins or ends with a blank")
    return name


def _image_file(image: Any, *, newer: bool) -> str:
    named = list(image.iter("ref" if newer else "init_from"))
    found = next(iter(image.findall("init_from/ref" if newer else "init_from")), None)
    if len(named) > 1:
        raise ValueError(f"the image `{image.get('id', '')[:60]}` names several files")
    if found is None or not _whole_text(found).strip():
        raise AssetError("SC410", "an image of the COLLADA is embedded", "save it as a PNG file and refer to that")
    written = _whole_text(found)
    name = unquote(written)
    if _INVALID_FILE_NAME.search(written) or _INVALID_FILE_NAME.search(name.replace("%", "")):
        raise ValueError(f"`{written[:60]!a}` is not a valid file name")
    return name


def _whole_text(node: Any) -> str:
    """Returns the text of an element in one piece, since SAPIEN's reader takes only the first of several."""
    if len(node):
        raise ValueError(f"the text of `{node.tag[:40]}` is interrupted by an element or a comment")
    return node.text or ""
