"""Prints poses and masses of a file's bodies according to Drake: `python -m scenecc.importers.drake_poses`.

Standard input is JSON: `{"file": PATH, "roots": [FOLDER, …]}`. The result is JSON: `MODEL::BODY` → `{"pose": …, "mass":
…}`, a pose as p [m] and q (wxyz). Runs as a separate process, since Drake crashes on some files. If Drake refuses a
file, the last line of standard error has the reason.
"""

from __future__ import annotations

import json
import resource
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import numpy as np

_MAX_MEMORY: Final = 8 * 2**30
"""Address space of this process [bytes]; Drake maps about 1 GiB itself."""


def main() -> None:
    """Answers the request on standard input."""
    resource.setrlimit(resource.RLIMIT_AS, (_MAX_MEMORY, _MAX_MEMORY))
    asked = json.load(sys.stdin)
    plants: Any = import_module("pydrake.multibody.plant")
    parsing: Any = import_module("pydrake.multibody.parsing")
    plant = plants.MultibodyPlant(time_step=0.001)
    parser = parsing.Parser(plant)
    packages = parser.package_map()
    for name in packages.GetPackageNames():
        packages.Remove(name)  # one of them would be downloaded
    # Like scenecc, it finds the package that contains the file.
    above = next((each for each in Path(asked["file"]).parents if (each / "package.xml").is_file()), None)
    if above is not None:
        packages.AddPackageXml(str(above / "package.xml"))
    for root in asked["roots"]:
        packages.PopulateFromFolder(root)
    try:
        parser.AddModels(asked["file"])
    except RuntimeError as error:
        sys.exit(str(error).partition("\n")[0])
    plant.Finalize()
    context = plant.CreateDefaultContext()
    # A joint that cannot be at 0 starts at its limit, as in a scene.
    limits = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    plant.SetPositions(context, np.clip(plant.GetPositions(context), *limits))
    found: dict[str, Any] = {}
    for index in _bodies(plant):
        body = plant.get_body(index)
        pose = plant.EvalBodyPoseInWorld(context, body)
        name = f"{plant.GetModelInstanceName(body.model_instance())}::{body.name()}"
        quaternion = pose.rotation().ToQuaternion().wxyz()
        found[name] = {
            "pose": [*map(float, pose.translation()), *map(float, quaternion)],
            "mass": float(body.get_mass(context)),
        }
    print(json.dumps(found))  # noqa: T201 - the answer


def _bodies(plant: Any) -> list[Any]:
    module: Any = import_module("pydrake.multibody.tree")
    return [module.BodyIndex(number) for number in range(1, plant.num_bodies())]


if __name__ == "__main__":
    main()
