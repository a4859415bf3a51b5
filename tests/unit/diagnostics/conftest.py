"""Diagnostics for the renderers: a handful that shows every part, and arbitrary ones."""

from __future__ import annotations

import pytest

from scenecc.diagnostics import Diagnostic, Related
from scenecc.diagnostics.diagnostic import Location


@pytest.fixture
def typo() -> Diagnostic:
    """An error with all its parts."""
    return Diagnostic(
        code="SC101",
        severity="error",
        message="`half_sise` is not a key of a box",
        location=Location("scene.yaml", 4, 20, 29, "      - {type: box, half_sise: [1, 1, 1]}"),
        path="entities.cube.shapes[0].half_sise",
        hint="did you mean `half_size`?",
        related=(Related("the box is here", Location("scene.yaml", 112, 9, 10, "      - {type: box}")),),
    )


@pytest.fixture
def bare() -> Diagnostic:
    """A warning about a dict: no file, no line, no hint."""
    return Diagnostic("SC501", "warning", "the mass is tiny", Location(None), path="entities.cube.mass")
