"""Diagnostics, the table of their codes, the sink, and one renderer per format.

Every stage reports here, and this package imports none of them.
"""

from scenecc.diagnostics.codes import Severity
from scenecc.diagnostics.diagnostic import (
    At,
    Diagnostic,
    Location,
    Locator,
    Origin,
    Path,
    PathKey,
    Related,
    Sink,
    Tracer,
    dotted,
    nowhere,
)

__all__ = [
    "At",
    "Diagnostic",
    "Location",
    "Locator",
    "Origin",
    "Path",
    "PathKey",
    "Related",
    "Severity",
    "Sink",
    "Tracer",
    "dotted",
    "nowhere",
]
