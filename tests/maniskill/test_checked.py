"""`scenecc check`, which finds all that `validate` does, of the scenes of ManiSkill's tasks: no fault, and no warning.

The other scenes that are shipped are held to the same without the extra, in `tests/test_scenes_tree.py`.
"""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from plugins.expectations import ROOT


@pytest.mark.timeout(600)
def test_the_check_finds_nothing_in_scenes_of_tasks() -> None:
    """Two tasks overlap at the start as ManiSkill builds them; their files say so under `expect`."""
    asked = [sys.executable, "-m", "scenecc", "check", "scenes/maniskill", "--strict", "--format", "json", "--no-cache"]
    done = subprocess.run([*asked, "--jobs", "2"], cwd=ROOT, capture_output=True, text=True, check=False)
    faults = [one for one in json.loads(done.stdout)["diagnostics"] if one["severity"] != "note"]
    assert (faults, done.returncode) == ([], 0), done.stderr
