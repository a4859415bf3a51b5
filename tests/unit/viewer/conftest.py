"""A page of two scenes, which no browser shows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    import viser
    from plugins.shown import Shown


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    from scenecc import PageAddress
    from scenecc.viewer.server import PageServer

    made = PageServer(PageAddress(port=0), "test")
    yield made.viser
    made.close()


@pytest.fixture
def scene_text() -> str:
    """What is shown; a file of tests may show another scene."""
    from plugins.shown import SCENE

    return SCENE


@pytest.fixture
def shown(server: viser.ViserServer, tmp_path: Path, scene_text: str) -> Iterator[Shown]:
    from plugins.shown import Shown

    path = tmp_path / "scene.yaml"
    path.write_text(scene_text)
    made = Shown(server, path)
    made.session.start()
    yield made
    made.session.close()
