"""Mutations of a file: of its bytes, of its tokens, and of its structure."""

from __future__ import annotations

import copy
import random
import re
import struct
from pathlib import Path
from typing import Any

from fuzz.trees import codec_of

HOSTILE: tuple[Any, ...] = (
    *(0, -1, 1, 2, 3, 255, 256, 65535, 2**31 - 1, 2**31, 2**32, -(2**31), 2**63, 2**64, 10**30),
    *(0.0, -0.0, 0.5, 1e-45, 1e-9, 1e9, 1e38, 1e39, 1e308, -1e308, float("inf"), float("-inf"), float("nan")),
    *("", " ", "0", "-1", "1e400", "nan", "inf", "-inf", ".5", "1.", "0x10", "1_0", "1e", "1/", "1//x", "1 2"),
    *("../../etc/passwd", "/dev/zero", "http://localhost/x", "%2e%2e", "a" * 300, "${1/0}", "{}", "~", "\t"),
    *("\u0130", "\ud7ff"),
    *(True, False, None, [], {}, [[]], [0], {"": 0}),
)
_TOKEN = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|\w+|\s+|.", re.DOTALL)
_INTEGERS = (0, 1, 2, 3, 4, 127, 128, 255, 256, 32767, 65535, 2**24, 2**31 - 1, 2**31, 2**32 - 1)


def mutated(path: Path, data: bytes, other: bytes, how: random.Random) -> bytes:
    """A file after one to three mutations.

    Args:
        path: its name, which tells its format.
        data: what it holds.
        other: a file of the same target, to take pieces from.
        how: decides everything.
    """
    for _ in range(how.choice((1, 1, 1, 2, 3))):
        data = how.choice((_bytes, _tokens, _structure, _structure))(path, data, other, how)
    return data


def _bytes(_path: Path, data: bytes, other: bytes, how: random.Random) -> bytes:
    out = bytearray(data or b"\0")
    at = how.randrange(len(out))
    piece = how.randrange(1, 1 + how.choice((4, 64, len(out))))
    match how.randrange(7):
        case 0:
            return bytes(out[:at])
        case 1:
            out[at] ^= 1 << how.randrange(8)
        case 2:
            out[at] = how.randrange(256)
        case 3:
            del out[at : at + piece]
        case 4:
            out[at:at] = out[at : at + piece]
        case 5:
            form = how.choice(("<B", "<H", ">H", "<I", ">I"))
            size = struct.calcsize(form)
            out[at : at + size] = struct.pack(form, how.choice(_INTEGERS) & ((1 << 8 * size) - 1))
        case _:
            start = how.randrange(len(other) or 1)
            out[at : at + piece] = other[start : start + piece]
    return bytes(out)


def _tokens(_path: Path, data: bytes, other: bytes, how: random.Random) -> bytes:
    tokens: list[bytes] = _TOKEN.findall(data) or [b""]
    at, to = how.randrange(len(tokens)), how.randrange(len(tokens))
    match how.randrange(6):
        case 0:
            del tokens[at]
        case 1:
            tokens.insert(at, tokens[to])
        case 2:
            tokens[at], tokens[to] = tokens[to], tokens[at]
        case 3:
            tokens[at] = how.choice(_TOKEN.findall(other) or [b""])
        case 4:
            numbers = [i for i, token in enumerate(tokens) if token[-1:].isdigit()]
            tokens[how.choice(numbers or [at])] = str(how.choice(HOSTILE)).encode("utf-8", "replace")
        case _:
            tokens[at] = str(how.choice(HOSTILE)).encode("utf-8", "replace")
    return b"".join(tokens)


def _structure(path: Path, data: bytes, other: bytes, how: random.Random) -> bytes:
    codec = codec_of(path)
    try:
        if codec is None:
            raise ValueError("it has no structure")
        tree = codec[0](data)
        _mutate_tree(tree, how)
        return codec[1](tree)
    except Exception:  # noqa: BLE001 - broken by a mutation before, or beyond what the format can say
        return _bytes(path, data, other, how)


def _mutate_tree(tree: Any, how: random.Random) -> None:
    places = list(_places(tree))
    parent, key = how.choice(places)
    other, its = how.choice(places)
    match how.randrange(5):
        case 0:
            del parent[key]
        case 1 if isinstance(parent, list):
            parent.insert(key, copy.deepcopy(parent[key]))
        case 1:
            new = how.choice((f"{key}2", *HOSTILE, *[its for _, its in places]))
            if isinstance(new, str):
                parent[new] = parent[key] if how.random() < 0.5 else parent.pop(key)
        case 2:
            parent[key], other[its] = copy.deepcopy(other[its]), copy.deepcopy(parent[key])
        case 3:
            parent[key] = copy.deepcopy(other[its])
        case _:
            parent[key] = how.choice(HOSTILE)


def _places(tree: Any) -> Any:
    """Every place of a tree: what holds it, and its key or index there."""
    keys = tree if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ()
    for key in list(keys):
        yield tree, key
        yield from _places(tree[key])
