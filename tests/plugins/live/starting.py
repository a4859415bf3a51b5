"""From the same state: the last bit of a rotation that PyTorch has drawn is not the same on every processor."""

from __future__ import annotations

from typing import Any

import numpy as np
import sapien

from scenecc.decompiler.reading import LiveObject, Numbers, read_entity


def start_from(scene: Any, reference: LiveObject) -> None:
    """Turns bodies whose quaternions are a last bit off those of a reference as the reference is turned.

    ManiSkill draws rotations by PyTorch, whose cosines in single precision have another last bit on some processors
    (seen in PokeCube-v1: 0.9997301 and 0.99973017). A file has the numbers of one of them, and 200 steps can be
    compared only from the same state. Positions and links are left alone, and so is what is further off than half a
    step of a float32 near 1: these are found as differences.

    Args:
        scene: a `sapien.Scene` that has not been stepped.
        reference: a scene as it was read elsewhere.
    """
    for entity, facts in zip(scene.entities, [part for part in reference.parts if part.kind == "entity"], strict=False):
        ours, theirs = _pose(read_entity(entity)), _pose(facts)
        link = any(hasattr(component, "articulation") for component in entity.components)
        off = np.abs(ours.astype(np.float64) - theirs)
        if entity.name == facts.name and not link and not off[:3].any() and 0 < off[3:].max() <= LAST_BIT:
            entity.pose = sapien.Pose(theirs[:3].tolist(), theirs[3:].tolist())


LAST_BIT = float(np.finfo(np.float32).eps) / 2


def _pose(facts: LiveObject) -> np.ndarray:
    pose = facts.value("pose")
    assert isinstance(pose, Numbers)
    return pose.array()
