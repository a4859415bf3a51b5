"""Reading for the tests of the reader."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from plugins.diagnostics import TakingSink

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.source import Limits, read_text


@pytest.fixture
def read(sink: TakingSink) -> Callable[..., Any]:
    """The data of a text; the test's sink takes what is wrong."""

    def run(text: str | bytes, **limits: int) -> Any:
        document = read_text(text, "scene.yaml", sink, Limits(**limits))
        return None if document is None else document.data

    return run


@pytest.fixture
def faults() -> Callable[..., list[Diagnostic]]:
    """What is wrong with a text that cannot be read."""

    def run(text: str | bytes, **limits: int) -> list[Diagnostic]:
        sink = Sink()
        assert read_text(text, "scene.yaml", sink, Limits(**limits)) is None
        assert sink.failed
        return sink.diagnostics()

    return run
