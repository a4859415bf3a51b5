"""What a generated document places: one body, on a target of its own that is far from all else."""

from __future__ import annotations

from random import Random
from typing import Any

from plugins.articulation_rules import FILES

from scenecc.plan.geometry import REVOLVED_SOLIDS

_WHERE: list[dict[str, Any]] = [
    {},
    {"at": [0.5, {"uniform": [-1, 1]}]},
    {"region": [[-2, -2, 0], [2, 2, 9000]]},
    {"region": [{"uniform": [[-2, -2, 0], [-1, -1, 0]]}, [2, 2, 9000]]},
    {"region": {"center": [0, 1], "radius": {"uniform": [1, 2]}}},
    {"region": "placing_frame"},
    {"region": [[-2, -2], [2, 2]], "relative_to": "world"},
    {"region": [[-2, -2], [2, 2]], "relative_to": "placing_target"},
]
_TURNS: list[dict[str, Any]] = [
    {},
    {"yaw": 1},
    {"yaw_deg": {"uniform": [0, 360]}},
    {"q": "uniform"},
    {"rpy": [0, 0, 1]},
    {"rpy_deg": [0, 90, 0]},
    {"axis_angle": {"axis": "z", "angle": 1}},
    {"facing": "placing_target"},
    {"facing": [9, 9]},
]
_BOX: dict[str, Any] = {"shapes": [{"type": "box", "half_size": [0.2, 0.1, 0.1]}]}
_THINGS: list[dict[str, Any]] = [
    _BOX,
    {"root": {"name": "base", **_BOX}},
    *({kind: file} for kind, end in (("urdf", "urdf"), ("mjcf", "xml")) for file in FILES if file.endswith(end)),
]
_UNKNOWN = ("coacd", "'plane'", "'heightfield'", *map(repr, REVOLVED_SOLIDS))
"""Of these some have no end, and of others distances are not known where their sizes differ from scene to scene."""


def placements(document: dict[str, Any], random: Random) -> None:
    """Keeps no `place` as it was made, and adds a body that is placed where one was."""
    frames, entities = document.get("frames", {}), document["entities"]
    wanted = any("place" in one for one in (*frames.values(), *entities.values()))
    for one in frames.values():
        one.pop("place", None)
        one.pop("region", None)
    for one in entities.values():
        one.pop("place", None)
    if not wanted or any(word in repr(document) for word in _UNKNOWN):
        return
    shapes = [
        {"type": "box", "half_size": [50, 50, 0.1]},
        {"type": "box", "half_size": [0.1, 50, 20], "pose": [49.9, 0, 20]},
    ]
    target = {"body_type": "static", "pose": [0, 0, 5000], "shapes": shapes}
    document.setdefault("frames", {})["placing_frame"] = {"pose": [0, 0, 0], "region": [[-1, -1], [1, 1]]}
    kind = random.choice(["on", "inside", "above"])
    place = {kind: "placing_target", **random.choice(_WHERE), **random.choice(_TURNS)}
    some: dict[str, Any] = {"near": {"placing_target": [0, 200]}, "apart": 0.01, "gap": 0.01, "tries": 500}
    place |= {key: item for key, item in some.items() if random.random() < 0.5}
    if kind == "above":
        place["height"] = random.choice([[0.1, 0.2], {"uniform": [[0.1, 0.3], [0.2, 0.4]]}])
    placed = {"placed": {"place": place, **random.choice(_THINGS)}}
    if random.random() < 0.2:
        placed["placed_beside"] = {"place": _beside(random), **_BOX}
        placed["placed"]["place"] = {"on": "placing_target"}
    document["entities"] = {**entities, "placing_target": target, **placed}


def _beside(random: Random) -> dict[str, Any]:
    next_to = {"of": "placed", "side": random.choice(["front", "back", "left", "right"]), "gap": 0.05}
    return {"on": "placing_target", "next_to": next_to, "align": random.choice(["min", "center", "max"])}
