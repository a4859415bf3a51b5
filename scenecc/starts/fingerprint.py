"""What the starts of a scene depend on, and how two scenes differ in it."""

from __future__ import annotations

import json
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.messages import cut, show
from scenecc.source.paths import name_of_file
from scenecc.source.provenance import content_hash
from scenecc.version import VERSION

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.expand.expansion import Expansion
    from scenecc.plan import ScenePlan
    from scenecc.source import Document
    from scenecc.source.paths import AssetScope

_SECTIONS: Final = ("physics", "materials", "collision_groups", "draws", "frames", "entities", "constraints")
"""The sections that are simulated. The others may change without a change of the starts."""

_SCENE_FILES: Final = frozenset(("include", "prefab", "starts"))
"""Roles of files whose content is in the sections, or is the starts."""

_DIGITS: Final = 16
"""Hexadecimal digits of each hash."""


def fingerprint(document: Document, expansion: Expansion | None, scope: AssetScope, plan: ScenePlan) -> dict[str, Any]:
    """Returns what the starts of a scene depend on besides its seed and its number of scenes, as plain data."""
    data = document.data if expansion is None else expansion.data
    parts = {
        f"{section}.{name}": _digest(node)
        for section in _SECTIONS
        for name, node in ({"": data.get(section)} if section == "physics" else data.get(section) or {}).items()
    }
    if expansion is not None and expansion.selections:
        parts["scene_idxs"] = _digest({name: [*idxs] for name, idxs in expansion.selections.items()})
    hashes = {file.path: file.sha256 for file in plan.files if file.sha256 is not None}
    files = {
        name_of_file(path, scope): (hashes.get(path) or content_hash(path) or "")[:_DIGITS]
        for path, reference in scope.memory.named.items()
        if reference.role not in _SCENE_FILES
    }
    params = {} if expansion is None else {**expansion.defaults, **expansion.params}
    return {"parts": parts, "params": _plain(params), "files": dict(sorted(files.items())), "versions": _versions()}


def scene_differences(was: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Returns how the scene of some starts differs from one that would begin there, worded for a message. The parts of
    the file are compared only if parameters and assets are equal, since they follow from them.
    """
    before, after = was["params"], now["params"]
    found = [f"the parameter `{cut(name)}` {_change(before, after, name)}" for name in _changed(before, after)]
    for name in _changed(was["files"], now["files"]):
        known = name in was["files"] and name in now["files"]
        change = "changed" if known else "is new" if name in now["files"] else "is no longer used"
        found.append(f"`{cut(name, 200)}` {change}")
    if not found:
        for name in _changed(was["parts"], now["parts"]):
            change = "changed" if name in was["parts"] and name in now["parts"] else "is new"
            found.append(f"`{cut(name).rstrip('.')}` {change if name in now['parts'] else 'no longer exists'}")
        if not found and [*was["parts"]] != [*now["parts"]]:
            found.append("the order of the entities changed")
    return found


def other_versions(was: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Returns the programs whose versions differ, with both versions, worded for a message."""
    before, after = was["versions"], now["versions"]
    return [
        f"{cut(name)} {cut(str(before.get(name, 'none')))} (here {after.get(name, 'none')})"
        for name in _changed(before, after)
    ]


def is_unrelated(was: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    """Returns whether two scenes have no entity with the same name."""
    before, after = ({name for name in each["parts"] if name.startswith("entities.")} for each in (was, now))
    return before.isdisjoint(after) and bool(before or after)


def _changed(was: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for name in {**was, **now}:
        if name not in was or name not in now or json.dumps(was[name]) != json.dumps(now[name]):
            yield name


def _change(was: Mapping[str, Any], now: Mapping[str, Any], name: str) -> str:
    if name not in was:
        return "is new"
    return f"was {show(was[name])} and is {show(now[name])}" if name in now else "no longer exists"


def _plain(data: Any) -> Any:
    return json.loads(json.dumps(data, default=repr))


def _digest(node: Any) -> str:
    return sha256(json.dumps(node, sort_keys=True, default=repr).encode()).hexdigest()[:_DIGITS]


def _versions() -> dict[str, str]:
    try:
        return {"scenecc": VERSION, "sapien": version("sapien")}
    except PackageNotFoundError:
        return {"scenecc": VERSION}
