"""What an MJCF may hold that nothing is made of, and where it belongs in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

ELEMENT_HINTS: dict[str, str] = {
    "actuator": "say under `drives` what drives the joints",
    "camera": "declare it under `cameras`, with `mount` where it moves with a link",
    "contact": "say under `collision_groups` and `links` what ignores what",
    "equality": "declare it under `constraints`",
    "inertial": "masses follow from the shapes' densities; `links: {NAME: {inertial: …}}` gives others",
    "keyframe": "give `qpos`",
    "light": "declare it under `lights`",
    "option": "timestep, gravity and solver are the scene's `physics`",
    "site": "declare a `frame`, or mount on the link",
}
"""What to do in a scene about an element that is not read."""

_ATTRIBUTE_HINTS: dict[tuple[str, str], str] = {
    ("body", "gravcomp"): "`gravity: false` under `links` takes gravity away",
    ("body", "mocap"): "it stands still, where it has no joints; declare a kinematic body in the scene",
    (
        "geom",
        "mass",
    ): "masses follow from densities (1000 where none is given); `links: {NAME: {mass: …}}` gives others",
    ("joint", "armature"): "`joints: {NAME: {armature: …}}` gives it",
    ("joint", "stiffness"): "`drives: {NAME: {stiffness: …}}` pulls a joint back",
    ("option", "gravity"): ELEMENT_HINTS["option"],
    ("option", "timestep"): ELEMENT_HINTS["option"],
    ("texture", "builtin"): "paint the texture into a file",
}


def attribute_hint(tag: str, names: Iterable[str]) -> str | None:
    """What to do in a scene about attributes that are not read."""
    hints = [_ATTRIBUTE_HINTS[tag, name] for name in names if (tag, name) in _ATTRIBUTE_HINTS]
    return "; ".join(dict.fromkeys(hints)) or None
