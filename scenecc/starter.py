"""A folder to begin with: a scene and its robot, a test, the commit hook and the workflow."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from scenecc.diagnostics.frozen import frozen
from scenecc.version import VERSION

_FOLDER: Final = Path(__file__).parent / "templates"

ROBOTS: Final[dict[str, str | None]] = {"arm": None, "panda": "maniskill", "quadruped": None}
"""Robots, and the extra of scenecc that has the files of one; None: its links are written in the template."""

_ROBOT: Final = "\n  robot: {use: robot.yaml}\n"
"""What is added to the entities of a template that needs no robot."""


@frozen
class StarterTemplate:
    """A scene to begin with.

    Attributes:
        description: what is in it.
        robots: those that it takes, by name; unless one is asked for, the first.
        needs_robot: whether it has one without being asked.
    """

    description: str
    robots: tuple[str, ...]
    needs_robot: bool = True


TEMPLATES: Final[dict[str, StarterTemplate]] = {
    "pick_place": StarterTemplate("a cube on a table, and where to bring it", ("arm", "panda")),
    "kitchen": StarterTemplate("a counter with drawers, a shelf and crockery", ("arm", "panda")),
    "locomotion": StarterTemplate("ground with stones, for a robot that walks", ("quadruped",)),
    "empty": StarterTemplate("a ground and a cube", tuple(ROBOTS), needs_robot=False),
}
"""By name; each is a file in `templates/scenes`, and each robot one in `templates/robots`."""


def starter_files(template: str, robot: str | None) -> dict[str, bytes]:
    """The files of a new folder, by their paths in it.

    Args:
        template: one of `TEMPLATES`.
        robot: one that the template takes, or None.
    """
    from scenecc.spec.json_schema import json_schema  # noqa: PLC0415 - loads all models

    scene = _text(f"scenes/{template}.yaml")
    files = {"scene.yaml": scene if robot is None or TEMPLATES[template].needs_robot else scene + _ROBOT}
    if robot is not None:
        files["robot.yaml"] = _text(f"robots/{robot}.yaml")
    workflow = _text("project/workflow.yml").replace("VERSION", VERSION)
    return {
        name: content.encode()
        for name, content in {
            **files,
            "test_scenes.py": _text("project/test_scenes.py"),
            # Beside the scenes, an editor finds it without a network.
            "scene.schema.json": json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n",
            ".pre-commit-config.yaml": _text("project/pre-commit-config.yaml"),
            ".github/workflows/scenes.yml": _with_extras(workflow, ROBOTS.get(robot or "")),
        }.items()
    }


def _with_extras(workflow: str, extra: str | None) -> str:
    return workflow.replace("EXTRAS", extra) if extra else workflow.replace("[EXTRAS]", "").replace("EXTRAS", "")


def _text(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
