"""Reads a URDF with pinocchio, in a Python that has it: one request and one answer per line of JSON.

A request: `file`, and `qpos`, joint name → position. An answer: `links`, name → position [m]; `joints`, name → lower
and upper limit, the mass, centre of mass and inertia matrix of all that moves with it, in the world; or `error`.
"""

from __future__ import annotations

import importlib
import json
import math
import sys
from typing import Any


def main() -> None:
    """Answers requests until the input ends."""
    pinocchio: Any = importlib.import_module("pinocchio")
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = _answer(pinocchio, request["file"], request["qpos"])
        except (ValueError, RuntimeError, IndexError) as error:
            answer = {"error": str(error)}
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


def _answer(pinocchio: Any, file: str, positions: dict[str, float]) -> dict[str, Any]:
    model = pinocchio.buildModelFromUrdf(file)
    data, qpos = model.createData(), pinocchio.neutral(model)
    for number, name in enumerate(model.names):
        if name in positions:
            first, joint, angle = model.idx_qs[number], model.joints[number], positions[name]
            # A continuous joint has the cosine and the sine of its angle.
            values = [angle] if joint.nq == 1 else [math.cos(angle), math.sin(angle)]
            qpos[first : first + joint.nq] = values
    pinocchio.framesForwardKinematics(model, data, qpos)
    joints: dict[str, Any] = {}
    for number in range(1, model.njoints):
        moved, place = data.oMi[number].act(model.inertias[number]), model.idx_qs[number]
        one = model.joints[number].nq == 1
        joints[model.names[number]] = {
            "limits": [float(model.lowerPositionLimit[place]), float(model.upperPositionLimit[place])] if one else None,
            "mass": moved.mass,
            "com": moved.lever.tolist(),
            "inertia": moved.inertia.tolist(),
            "links": [f.name for f in model.frames if f.type == pinocchio.BODY and f.parentJoint == number],
        }
    bodies = [k for k, frame in enumerate(model.frames) if frame.type == pinocchio.BODY]
    return {"links": {model.frames[k].name: data.oMf[k].translation.tolist() for k in bodies}, "joints": joints}


if __name__ == "__main__":
    main()
