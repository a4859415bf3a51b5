"""The public names, as a user finds them."""

from __future__ import annotations

import subprocess
import sys

import pytest
from plugins.expectations import GOOD

import scenecc


@pytest.mark.parametrize("name", scenecc.__all__)
def test_no_folder_of_the_package_has_a_public_name(name: str) -> None:
    """Importing a folder binds its name in the package, over whatever had it before."""
    assert not (GOOD.parents[2] / "scenecc" / name).is_dir()
    assert getattr(scenecc, name) is not None


def test_every_function_can_be_called_twice() -> None:
    script = (
        "import sys, scenecc\n"
        "for _ in range(2):\n"
        "    assert scenecc.validate(sys.argv[1]) == []\n"
        "    plan = scenecc.compile_scene(sys.argv[1])\n"
        "    assert scenecc.emit_scene(plan, 'json') and scenecc.emit_scene(plan, 'python')\n"
        "    scenecc.load_scene(plan, render=False).close()\n"
        "    assert scenecc.json_schema()\n"
    )
    subprocess.run([sys.executable, "-c", script, str(GOOD / "cube.yaml")], check=True, timeout=60)
