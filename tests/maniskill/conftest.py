"""ManiSkill's environments leave SAPIEN's process-wide defaults changed; what comes after must not see it."""

from __future__ import annotations

import importlib.util
import logging
from collections.abc import Iterator
from pathlib import Path

import pytest
from plugins.maniskill_scenes import engine_as_before


@pytest.hookimpl(tryfirst=True)  # before tests/conftest.py asks for the marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.maniskill)
            # What ManiSkill and its dependencies warn of is not ours to mend.
            item.add_marker(pytest.mark.filterwarnings("default"))


@pytest.fixture(autouse=True)
def process_defaults() -> Iterator[None]:
    if importlib.util.find_spec("mani_skill") is None:
        yield
        return
    level = logging.root.manager.disable
    logging.disable()  # ManiSkill warns of tasks that give no initial pose
    with engine_as_before():
        yield
    logging.disable(level)
