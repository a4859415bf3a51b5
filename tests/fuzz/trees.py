"""File formats as plain trees and back: what a structural mutation works on. A tree is lists, dicts and scalars."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import yaml

Codec = tuple[Callable[[bytes], Any], Callable[[Any], bytes]]


def _lines(data: bytes) -> list[list[str]]:
    return [line.split(" ") for line in data.decode("latin-1").split("\n")]


def _of_lines(tree: Any) -> bytes:
    rows = tree if isinstance(tree, list) else [tree]
    return "\n".join(" ".join(map(str, row)) if isinstance(row, list) else str(row) for row in rows).encode(
        "latin-1", "replace"
    )


def _element(node: ET.Element) -> list[Any]:
    return [node.tag, dict(node.attrib), (node.text or "").strip(), *[_element(child) for child in node]]


def _of_element(tree: Any) -> str:
    match tree:
        case [tag, dict() as attributes, text, *children]:
            said = "".join(f' {key}="{_escaped(value)}"' for key, value in attributes.items())
            return f"<{tag}{said}>{_escaped(text)}{''.join(map(_of_element, children))}</{tag}>"
        case _:
            return _escaped(tree)


def _escaped(value: object) -> str:
    return str(value).replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def _glb(data: bytes) -> list[Any]:
    (size,) = struct.unpack_from("<I", data, 12)
    return [json.loads(data[20 : 20 + size]), data[28 + size :].hex()]


def _of_glb(tree: Any) -> bytes:
    document, body = tree
    text, held = json.dumps(document).encode(), bytes.fromhex(body)
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(held), b"BIN\0") + held
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def _png(data: bytes) -> list[Any]:
    """Chunks: the numbers of the header, hexadecimal digits of the others."""
    chunks: list[Any] = []
    at = 8
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + length]
        held = [*struct.unpack(">IIBBBBB", body)] if kind == b"IHDR" else base64.b64encode(body).decode()
        chunks.append([kind.decode("latin-1"), held])
        at += 12 + length
    return chunks


def _of_png(tree: Any) -> bytes:
    out = b"\x89PNG\r\n\x1a\n"
    for kind, held in tree:
        body = struct.pack(">IIBBBBB", *held) if isinstance(held, list) else base64.b64decode(held)
        named = kind.encode("latin-1") + body
        out += struct.pack(">I", len(body)) + named + struct.pack(">I", zlib.crc32(named))
    return out


def _jpeg(data: bytes) -> list[Any]:
    """Segments, and what follows the start of a scan in one piece."""
    segments: list[Any] = []
    at = 2
    while at + 4 <= len(data):
        (length,) = struct.unpack_from(">H", data, at + 2)
        kind = data[at + 1]
        if kind == 0xDA:
            segments.append([kind, list(data[at + 4 : at + 2 + length]), list(data[at + 2 + length :])])
            break
        segments.append([kind, list(data[at + 4 : at + 2 + length]), []])
        at += 2 + length
    return segments


def _of_jpeg(tree: Any) -> bytes:
    out = b"\xff\xd8"
    for kind, body, rest in tree:
        out += bytes([0xFF, kind]) + struct.pack(">H", len(body) + 2) + bytes(body) + bytes(rest)
    return out


_XML: Codec = (lambda data: _element(ET.fromstring(data)), lambda tree: _of_element(tree).encode())
_TEXT: Codec = (_lines, _of_lines)
_CODECS: dict[str, Codec] = {
    ".yaml": (yaml.safe_load, lambda tree: yaml.safe_dump(tree, sort_keys=False, default_flow_style=None).encode()),
    ".gltf": (json.loads, lambda tree: json.dumps(tree).encode()),
    ".glb": (_glb, _of_glb),
    ".png": (_png, _of_png),
    ".jpg": (_jpeg, _of_jpeg),
    **dict.fromkeys((".urdf", ".srdf", ".xml", ".dae", ".sdf"), _XML),
    **dict.fromkeys((".obj", ".mtl", ".ply", ".stl", ".usda"), _TEXT),
}


def codec_of(path: Path) -> Codec | None:
    """How a file's format becomes a tree and back; None for what has no structure but its bytes."""
    return _CODECS.get(path.suffix)
