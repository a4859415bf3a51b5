"""Patterns of names."""

from __future__ import annotations

import re

import pytest

from scenecc.scene_file.patterns import group_by_pattern, pattern_of

ARM = [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]


@pytest.mark.parametrize(
    ("members", "pattern"),
    [
        (ARM, ".*"),
        (ARM[:7], "panda_joint.*"),
        (ARM[7:], "panda_finger_joint.*"),
        (["panda_joint2", "panda_joint4"], "panda_joint(2|4)"),
        (["panda_joint2"], "panda_joint2"),
        (["panda_joint1", "panda_finger_joint1"], "panda_.*joint1"),
    ],
)
def test_a_pattern_matches_only_its_names(members: list[str], pattern: str) -> None:
    found = pattern_of(members, ARM)
    assert found == pattern
    assert [name for name in ARM if re.fullmatch(found, name)] == [name for name in ARM if name in members]


def test_shared_values_are_written_once() -> None:
    settings = {name: {"stiffness": 1000.0} | ({"force_limit": 100.0} if "finger" not in name else {}) for name in ARM}
    assert group_by_pattern(settings, ARM) == {".*": {"stiffness": 1000.0}, "panda_joint.*": {"force_limit": 100.0}}
