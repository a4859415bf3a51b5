"""The scene files of ManiSkill's tasks, and the table that `docs/reference/maniskill-tasks.md` has of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from plugins.expectations import ROOT
from plugins.maniskill_tasks import Captured, LeftOut

FOLDER = ROOT / "scenes" / "maniskill"
PAGE = ROOT / "docs/reference/maniskill-tasks.md"
TASKS = sorted(file.stem for file in FOLDER.glob("*-v1.yaml"))
DISTRIBUTIONS = sorted(FOLDER.glob("*.distribution.yaml"))


@dataclass(frozen=True)
class Unlike:
    """What differs between a task and its file.

    Attributes:
        each: a regular expression that each difference matches.
        first: one that the first difference of the steps matches.
        why: for the table.
    """

    each: str
    first: str
    why: str


UNLIKE = {
    "MS-HumanoidStand-v1": Unlike(
        r"/(PhysxArticulationLinkComponent\(\w+\)\.(linear|angular)_velocity|entity\(dummy_root_0\)\.pose"
        r"|articulation\(humanoid\)\.root_pose): ",
        r"^step \d+: (pose|velocity) of dummy_root_0\[\d\] is .*; 1 of 29 differ in the end, by up to 1\.19e-07$",
        "ManiSkill rotates the root after it has set the joint velocities. Until the first step the links have "
        "the velocities of an unrotated robot, and the root a quaternion that the engine has not normalised; "
        "the 200 steps are equal except for the last bit of the root",
    )
}
"""Tasks whose scene is not that of their file."""

_BEGIN, _END = "<!-- tasks: written by tests/maniskill/test_corpus.py -->", "<!-- end of tasks -->"


def page_with(table: str) -> str:
    """The page with another table."""
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(_BEGIN)[0], text.split(_END)[1]
    return f"{before}{_BEGIN}\n\n{table}\n{_END}{after}"


def table(tasks: Mapping[str, Captured | LeftOut]) -> str:
    """The tasks that build from ManiSkill's wheel and their files, then those that do not and what they lack."""
    built = {name: task for name, task in tasks.items() if isinstance(task, Captured)}
    lines = ["| task | robots | lines | equal |", "|---|---|---|---|"]
    for name, task in built.items():
        length = len((FOLDER / f"{name}.yaml").read_text(encoding="utf-8").splitlines())
        robots = ", ".join(dict.fromkeys(robot.uid for robot in task.robots))
        more = " × 2" if len(task.robots) == 2 else ""
        answer = f"no: {UNLIKE[name].why}" if name in UNLIKE else "yes"
        lines.append(f"| [{name}](../../scenes/maniskill/{name}.yaml) | {robots}{more} | {length} | {answer} |")
    left = {name: task for name, task in tasks.items() if isinstance(task, LeftOut)}
    lines += ["", f"{len(built)} tasks can be built from the wheel, and {len(left)} cannot:", ""]
    lines += ["| task | what is missing |", "|---|---|"]
    lines += [f"| {name} | {_told(task)} |" for name, task in left.items()]
    return "\n".join(lines) + "\n"


def _told(task: LeftOut) -> str:
    is_file = "/" in task.lacking and " " not in task.lacking
    return f"`{task.lacking}`" if is_file else task.lacking.replace("|", "\\|")
