"""Shell completion: scenes, prefabs, codes, and names that the scene on the command line declares.

Scenes are read as plain data, and their errors are ignored.
"""

# `os.path` returns False where `pathlib` raises: for a name that is too long, or in a folder without access.
# ruff: noqa: PTH112, PTH113, PTH118, PTH120, PTH202, PTH208

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, cast

_SUFFIXES: Final = (".yaml", ".yml", ".scn")
_PACKAGE: Final = Path(__file__).parents[1]
_PREFABS: Final = _PACKAGE / "prefabs"
_SHIPPED: Final = "scenecc:"

_DEEPEST: Final = 4
"""Maximum depth of files that use one another."""

_MOST_BYTES: Final = 2**19
"""Bytes of all scenes that are read for one word; a shell waits meanwhile."""

_PLAIN: Final = r"(?a)[\w.+-]+"
"""A value that needs no quotes. Shells execute `$()`, also in a file name."""

_PLAIN_PATH: Final = r"(?a)[\w./+-]+"
"""A name in the scene that needs no quotes."""

_PLAIN_NAME: Final = r"[\w.+,@%-]+"
"""A file name that needs no quotes. Others are left to the shell, which quotes them."""

_CODE: Final = r"(?m)^(SC\d+):\n(?:  (?!title:).*\n)*  title: '?(.*?)'?$"


def command_words() -> list[str]:
    """Returns the words of the command line that a shell completes; empty if there is none."""
    return (os.environ.get("COMP_WORDS") or os.environ.get("_TYPER_COMPLETE_ARGS") or "").split()


def complete_scene(incomplete: str) -> list[str]:
    """Completes scene files and folders. A single folder is entered, because a shell ends the word after a single
    match.
    """
    found = list(_paths(incomplete))
    while len(found) == 1 and found[0].endswith("/"):
        inside = list(_paths(found[0]))
        if not inside:
            break
        found = inside
    return found


def _paths(start: str) -> Iterator[str]:
    head, slash, tail = start.rpartition("/")
    try:
        names = sorted(os.listdir(head + slash or "."))
    except OSError:
        return
    for name in names:
        hidden = name.startswith(".") and not tail.startswith(".")
        if not name.startswith(tail) or hidden or not re.fullmatch(_PLAIN_NAME, name):
            continue
        path = head + slash + name
        if os.path.isdir(path):
            yield f"{path}/"
        elif path.lower().endswith(_SUFFIXES):
            yield path


def complete_prefab(incomplete: str) -> list[str]:
    """Completes the prefabs that ship with scenecc. An edition for a package has the package's name after a point."""
    prefix = _SHIPPED if incomplete.startswith(_SHIPPED) else ""
    return [prefix + file.stem for file in sorted(_PREFABS.glob("*.yaml")) if "." not in file.stem]


def complete_code(incomplete: str) -> list[tuple[str, str]]:
    """Completes diagnostic codes with their titles; in a comma-separated list, the last one."""
    text = (_PACKAGE / "diagnostics" / "codes.yaml").read_text(encoding="utf-8")
    before = incomplete[: incomplete.rfind(",") + 1]
    return [(before + code, title) for code, title in re.findall(_CODE, text)]


def complete_setting() -> list[str]:
    """Completes `name=value` for the scene's parameters, with the options of a choice or the default."""
    found: list[str] = []
    for name, node in _list_declared("params").items():
        given = _mapping(node) or {"default": node}
        plain = [_safe_text(value) for value in _list(given.get("options")) or [given.get("default")]]
        found += [f"{name}={value}" for value in dict.fromkeys(plain)]
    return found


def complete_entity() -> list[str]:
    """Completes the scene's entities, also those inside instances."""
    return list(_list_declared("entities"))


def complete_camera() -> list[str]:
    """Completes the scene's cameras."""
    return list(_list_declared("cameras"))


def complete_limit() -> list[str]:
    """Completes `name=value` for the limits, with their defaults."""
    from dataclasses import asdict

    from scenecc.source import Limits

    return [f"{name}={value}" for name, value in asdict(Limits()).items()]


def complete_loss() -> list[str]:
    """Completes the losses that an import can accept."""
    from scenecc.importers.imported_scene import ALL_LOSSES, LOSSES

    return [ALL_LOSSES, *(name for name, row in LOSSES.items() if row.changes_machine)]


def one_of(names: Iterable[str]) -> Callable[[], list[str]]:
    """Returns a function that completes a fixed set of names."""
    known = list(names)
    return lambda: known


def _safe_text(value: Any) -> str:
    """Returns a value as written after `name=`; "" if it needs quotes."""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return text if isinstance(value, str | int | float) and re.fullmatch(_PLAIN, text) else ""


def _list_declared(section: str) -> dict[str, Any]:
    """Returns a section's items, by name, of all scenes on the command line."""
    found: dict[str, Any] = {}
    # Typer's own parser drops all arguments if the last option lacks its value, which is being completed.
    for word in command_words()[2:]:
        if word.lower().endswith(_SUFFIXES):
            declared = _Declared(section, os.path.realpath(os.path.dirname(word)))
            found.update(declared.of(word, _DEEPEST))
    return {name: node for name, node in found.items() if re.fullmatch(_PLAIN_PATH, name)}


class _Declared:
    """Reads the items of a section. No file outside `folder` is read."""

    def __init__(self, section: str, folder: str) -> None:
        self._section = section
        self._folders = tuple(os.path.join(each, "") for each in (folder, os.path.realpath(_PREFABS)))
        self._bytes_left = _MOST_BYTES

    def of(self, file: str, deepest: int) -> Iterator[tuple[str, Any]]:
        """Yields the names and nodes of a file and of those that it uses."""
        size = os.path.getsize(file) if os.path.isfile(file) else None
        if not deepest or size is None or size > self._bytes_left:
            return
        self._bytes_left -= size  # counted at each use, so that the work ends
        data = _data(file)
        for reference in _list(data.get("include")):
            yield from self._list_prefab_params(reference, file, deepest)
        for name, node in _mapping(data.get(self._section)).items():
            if self._section != "entities" or {"use", "repeat"}.isdisjoint(_mapping(node)):
                yield name, node
        if self._section == "params":
            return
        for name, node in _mapping(data.get("entities")).items():
            given = _mapping(node)
            if "use" in given and "repeat" not in given:
                prefix = "" if given.get("prefix") == "" else f"{name}/"
                for inner, inner_node in self._list_prefab_params(given["use"], file, deepest):
                    yield prefix + inner, inner_node

    def _list_prefab_params(self, reference: Any, file: str, deepest: int) -> Iterator[tuple[str, Any]]:
        if not isinstance(reference, str) or "\0" in reference or not self._bytes_left:
            return
        name = reference.removeprefix(_SHIPPED)
        used = os.path.join(os.path.dirname(file), name) if name == reference else f"{_PREFABS}/{name}.yaml"
        if os.path.realpath(used).startswith(self._folders):
            yield from self.of(used, deepest - 1)


def _mapping(node: Any) -> dict[str, Any]:
    return cast("dict[str, Any]", node) if isinstance(node, dict) else {}


def _list(node: Any) -> list[Any]:
    return cast("list[Any]", node) if isinstance(node, list) else []


@lru_cache
def _data(file: str) -> dict[str, Any]:
    from scenecc.diagnostics import Sink
    from scenecc.source.read import read_file

    document = read_file(file, Sink())
    return {} if document is None else document.data
