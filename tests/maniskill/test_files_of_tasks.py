"""Files of ManiSkill's tasks, loaded into ManiSkill: what its own tasks build and place, names and all.

That every file gives its task's scene in bare SAPIEN is another test's; here are those that use most of what there is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from plugins.live.starting import start_from
from plugins.maniskill_scenes import new_scene
from plugins.maniskill_tasks import STEPS, Captured, references
from plugins.trajectory import first_difference, trajectory

from scenecc.decompiler.reading import read_scene
from scenecc.decompiler.verify import differences

FILES = Path(__file__).parents[2] / "scenes" / "maniskill"


TASKS = (
    "PickCube-v1",  # a robot by its URDF, a table, what is hidden
    "TwoRobotStackCube-v1",  # two of them
    "PegInsertionSide-v1",  # shapes by parameters
    "RotateValveLevel2-v1",  # a tree of links
    "MS-AntRun-v1",  # a robot whose MJCF is written out
    "UnitreeG1PlaceAppleInBowl-v1",  # meshes, a free root
)


@pytest.fixture(scope="session")
def tasks(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return references(tmp_path_factory, tasks=TASKS)


@pytest.mark.quick
@pytest.mark.timeout(600)  # the first to ask waits until the tasks are captured
@pytest.mark.parametrize("task", TASKS)
def test_a_tasks_file_in_maniskill_is_the_task(task: str, tasks: Any) -> None:
    from scenecc.maniskill import load_into, sim_config

    reference = tasks[task]
    assert isinstance(reference, Captured)
    file = FILES / f"{task}.yaml"
    scene = new_scene(sim_config=sim_config(file))
    load_into(scene, file)
    (found,) = scene.sub_scenes
    start_from(found, reference.scene)
    assert differences(reference.scene, read_scene(found)) == []
    assert first_difference(reference.trajectory, trajectory(found, STEPS)) is None
