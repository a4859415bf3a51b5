"""Files of a starter folder: a scene and its robot, a test, the commit hook and the workflow."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Final

from scenecc.diagnostics.frozen import frozen
from scenecc.extras import install_origin, local_path
from scenecc.version import VERSION

_FOLDER: Final = Path(__file__).parent / "templates"

ROBOTS: Final[dict[str, str | None]] = {"arm": None, "panda": "maniskill", "quadruped": None}
"""Robot → the extra of scenecc that has its files; None: the template itself contains its links."""

_ROBOT: Final = "\n  robot: {use: robot.yaml}\n"
"""Added to the entities of a template that needs no robot."""


@frozen
class StarterTemplate:
    """A starter scene.

    Attributes:
        description: what it contains.
        robots: names of the supported robots; the first is the default.
        needs_robot: whether it has a robot by default.
    """

    description: str
    robots: tuple[str, ...]
    needs_robot: bool = True


TEMPLATES: Final[dict[str, StarterTemplate]] = {
    "pick_place": StarterTemplate("a cube on a table, and a goal to move it to", ("arm", "panda")),
    "kitchen": StarterTemplate("a counter with drawers, a shelf and crockery", ("arm", "panda")),
    "locomotion": StarterTemplate("a ground with stones, for a walking robot", ("quadruped",)),
    "empty": StarterTemplate("a ground and a cube", tuple(ROBOTS), needs_robot=False),
}
"""Templates by name; each is a file in `templates/scenes`, and each robot one in `templates/robots`."""


OWNER: Final = "OWNER"
"""What a user replaces where the repository of scenecc is unknown."""

ADDRESS: Final = f"https://github.com/{OWNER}/scenecc"


def repository_address() -> str:
    """Returns the `https` address of the repository that scenecc was installed from; `ADDRESS` if it is unknown."""
    origin = install_origin()
    url = origin.get("url", "")
    if "dir_info" in origin:
        command = ["git", "--git-dir", str(local_path(url) / ".git"), "remote", "get-url", "origin"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=10)  # noqa: S603
            url = done.stdout.strip()
        except (OSError, subprocess.SubprocessError):  # git is not installed
            return ADDRESS
    found = re.fullmatch(r"(?:https://|ssh://)?(?:[^@/]*@)?([\w.-]+\.\w+)[:/](?!\d+/)([\w.~/-]+?)(?:\.git)?/?", url)
    return f"https://{found[1]}/{found[2]}" if found and "archive_info" not in origin else ADDRESS


def starter_files(template: str, robot: str | None, address: str = ADDRESS) -> dict[str, bytes]:
    """Returns the files of a new folder, by their paths in it.

    Args:
        template: a key of `TEMPLATES`.
        robot: a robot that the template supports, or None.
        address: address of scenecc's repository, from which the workflow installs it.
    """
    from scenecc.spec.json_schema import json_schema  # noqa: PLC0415 - loads all models

    scene = _text(f"scenes/{template}.yaml")
    files = {"scene.yaml": scene if robot is None or TEMPLATES[template].needs_robot else scene + _ROBOT}
    if robot is not None:
        files["robot.yaml"] = _text(f"robots/{robot}.yaml")
    extra = ROBOTS.get(robot or "")
    package = f"scenecc[{extra}]" if extra else "scenecc"
    workflow = _text("project/workflow.yml").replace("PACKAGE", f"{package} @ git+{address}@v{VERSION}")
    return {
        name: content.encode()
        for name, content in {
            **files,
            "test_scenes.py": _text("project/test_scenes.py"),
            "pytest.ini": _text("project/pytest.ini"),
            # An editor finds the schema beside the scenes, without a network.
            "scene.schema.json": json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n",
            ".pre-commit-config.yaml": _text("project/pre-commit-config.yaml"),
            ".github/workflows/scenes.yml": workflow,
        }.items()
    }


def _text(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
