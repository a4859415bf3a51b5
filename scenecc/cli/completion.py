"""What a shell completes: scenes, prefabs, codes, and names that the scene of the command line declares.

It reads scenes as plain data, without their models, and says nothing of what is wrong with them.
"""

# `os.path` says False of a name where `pathlib` raises: one that is too long, or in a folder that is locked.
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
"""How many files that use one another are read."""

_MOST_BYTES: Final = 2**19
"""Of all scenes that are read for one word: a shell waits for it."""

_PLAIN: Final = r"(?a)[\w.+-]+"
"""A value that a shell takes as it is. Shells run what stands in `$()`, also in the name of a file."""

_PLAIN_PATH: Final = r"(?a)[\w./+-]+"
"""Likewise a name of the scene."""

_PLAIN_NAME: Final = r"[\w.+,@%-]+"
"""Likewise that of a file. Others are left to the shell, which quotes them."""

_CODE: Final = r"(?m)^(SC\d+):\n(?:  (?!title:).*\n)*  title: '?(.*?)'?$"


def command_words() -> list[str]:
    """Of the command line that a shell completes; none where it does not."""
    return (os.environ.get("COMP_WORDS") or os.environ.get("_TYPER_COMPLETE_ARGS") or "").split()


def complete_scene(incomplete: str) -> list[str]:
    """Scene files and folders. A folder alone is entered, since a shell ends the word behind what it completes."""
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
    """The prefabs that ship with scenecc; editions for a package have its name behind a point."""
    prefix = _SHIPPED if incomplete.startswith(_SHIPPED) else ""
    return [prefix + file.stem for file in sorted(_PREFABS.glob("*.yaml")) if "." not in file.stem]


def complete_code(incomplete: str) -> list[tuple[str, str]]:
    """The codes of diagnostics with their titles; of several with commas between, the last."""
    text = (_PACKAGE / "diagnostics" / "codes.yaml").read_text(encoding="utf-8")
    before = incomplete[: incomplete.rfind(",") + 1]
    return [(before + code, title) for code, title in re.findall(_CODE, text)]


def complete_setting() -> list[str]:
    """Parameters of the scene as `name=value`: the options of a choice, or the default."""
    found: list[str] = []
    for name, node in _list_declared("params").items():
        given = _mapping(node) or {"default": node}
        plain = [_safe_text(value) for value in _list(given.get("options")) or [given.get("default")]]
        found += [f"{name}={value}" for value in dict.fromkeys(plain)]
    return found


def complete_entity() -> list[str]:
    """The names of entities of the scene, those inside instances included."""
    return list(_list_declared("entities"))


def complete_camera() -> list[str]:
    """The names of its cameras."""
    return list(_list_declared("cameras"))


def one_of(names: Iterable[str]) -> Callable[[], list[str]]:
    """Completes one of a few names."""
    known = list(names)
    return lambda: known


def _safe_text(value: Any) -> str:
    """A value as it is written after `name=`; "" for one that a shell would take apart."""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return text if isinstance(value, str | int | float) and re.fullmatch(_PLAIN, text) else ""


def _list_declared(section: str) -> dict[str, Any]:
    """What the scenes on the command line declare in a section, by name."""
    found: dict[str, Any] = {}
    # Typer's own parser drops all arguments where the last option lacks its value, which is being completed.
    for word in command_words()[2:]:
        if word.lower().endswith(_SUFFIXES):
            declared = _Declared(section, os.path.realpath(os.path.dirname(word)))
            found.update(declared.of(word, _DEEPEST))
    return {name: node for name, node in found.items() if re.fullmatch(_PLAIN_PATH, name)}


class _Declared:
    """What a scene declares in a section. `folder`: outside of which no file is read."""

    def __init__(self, section: str, folder: str) -> None:
        self._section = section
        self._folders = tuple(os.path.join(each, "") for each in (folder, os.path.realpath(_PREFABS)))
        self._bytes_left = _MOST_BYTES

    def of(self, file: str, deepest: int) -> Iterator[tuple[str, Any]]:
        """Names and nodes of a file, and of those that it uses."""
        size = os.path.getsize(file) if os.path.isfile(file) else None
        if not deepest or size is None or size > self._bytes_left:
            return
        self._bytes_left -= size  # each time that a file is used, so that the work has an end
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
