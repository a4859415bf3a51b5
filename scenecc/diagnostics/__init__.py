"""Diagnostics, the table of their codes, the sink, and one renderer per format.

Every stage reports here. This package imports none of them.
"""

from scenecc.diagnostics.codes import Severity
from scenecc.diagnostics.diagnostic import Diagnostic, Location, Origin, Related, Sink

__all__ = ["Diagnostic", "Location", "Origin", "Related", "Severity", "Sink"]
