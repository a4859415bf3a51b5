"""Expanding texts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from plugins.expander import Expander

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def expanded(tmp_path: Path) -> Expander:
    return Expander(tmp_path)
