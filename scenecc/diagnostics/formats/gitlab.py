"""The `gitlab` format: a Code Quality report, which GitLab shows in merge requests."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.formats.style import Style, encodable, relative_file

if TYPE_CHECKING:
    from scenecc.diagnostics.codes import Severity
    from scenecc.diagnostics.diagnostic import Diagnostic

_SEVERITIES: Final[dict[Severity, str]] = {"error": "major", "warning": "minor", "note": "info"}


def render(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    """Returns a JSON list with one issue per diagnostic; file names are relative to `style.root`.

    The fingerprint covers file, code, path and message, so that an edit elsewhere does not create a new issue.
    """
    issues: list[dict[str, object]] = []
    seen: dict[str, int] = {}
    for diagnostic in diagnostics:
        file = encodable(relative_file(diagnostic.place, style.root)[0])
        about = "\0".join(map(encodable, (file, diagnostic.code, diagnostic.path, diagnostic.message)))
        count = seen[about] = seen.get(about, 0) + 1
        issues.append(
            {
                "description": encodable(diagnostic.message + (f" ({diagnostic.hint})" if diagnostic.hint else "")),
                "check_name": encodable(diagnostic.code),
                "fingerprint": hashlib.sha256(f"{about}\0{count}".encode()).hexdigest(),
                "severity": _SEVERITIES[diagnostic.severity],
                "location": {"path": file, "lines": {"begin": diagnostic.line or 1}},
            }
        )
    return json.dumps(issues, indent=2) + "\n"
