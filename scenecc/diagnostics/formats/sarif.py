"""The `sarif` format: SARIF 2.1.0, which code scanning services and editors read."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.formats.style import Style, encodable, unchecked, unchecked_text, uri
from scenecc.diagnostics.reference import markdown
from scenecc.version import VERSION

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic, Location

Json = dict[str, object]

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


def render(diagnostics: Sequence[Diagnostic], style: Style) -> str:
    """Returns a SARIF 2.1.0 log of one run. File names are relative to `style.root`, the log's `%SRCROOT%`.

    The rules are the occurring codes in their own order. A file outside the root has an absolute URI.
    """
    rules = {code: i for i, code in enumerate(sorted({encodable(d.code) for d in diagnostics}))}
    run: Json = {
        "tool": {"driver": {"name": "scenecc", "version": VERSION, "rules": list(map(_rule, rules))}},
        "columnKind": "unicodeCodePoints",
        "results": [_result(d, rules, style.root) for d in diagnostics],
    }
    if line := unchecked_text(unchecked(diagnostics, style)):
        notes = [{"level": "note", "message": {"text": encodable(line)}}]
        run["invocations"] = [{"executionSuccessful": True, "toolExecutionNotifications": notes}]
    return json.dumps({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _rule(code: str) -> Json:
    row = CODES.get(code)
    if row is None:
        return {"id": code}
    return {
        "id": row.code,
        "shortDescription": {"text": row.title},
        "fullDescription": {"text": row.cause},
        "help": {"text": row.cure, "markdown": markdown(row)},
        "defaultConfiguration": {"level": row.severity},
    }


def _result(diagnostic: Diagnostic, rules: dict[str, int], root: PurePath | None) -> Json:
    rule = encodable(diagnostic.code)
    result: Json = {
        "ruleId": rule,
        "ruleIndex": rules[rule],
        "level": diagnostic.severity,
        "message": {"text": _message(diagnostic)},
    }
    location = _physical(diagnostic.location, root)
    if diagnostic.path:
        location["logicalLocations"] = [{"fullyQualifiedName": encodable(diagnostic.path)}]
    if location:
        result["locations"] = [location]
    if diagnostic.related:
        result["relatedLocations"] = [
            {"id": i, **_physical(related.location, root), "message": {"text": encodable(related.message)}}
            for i, related in enumerate(diagnostic.related)
        ]
    return result


def _message(diagnostic: Diagnostic) -> str:
    """Returns message and hint, because SARIF has no field for the hint of a single result."""
    hint = f"\nHint: {diagnostic.hint}" if diagnostic.hint else ""
    return encodable(diagnostic.message + hint)


def _physical(location: Location, root: PurePath | None) -> Json:
    if not location.file:
        return {}
    name, relative = uri(location.file, root)
    artifact: Json = {"uri": name, "uriBaseId": "%SRCROOT%"} if relative else {"uri": name}
    physical: Json = {"artifactLocation": artifact}
    if location.line is not None:
        physical["region"] = _region(location.line, location.column, location.end_column)
    return {"physicalLocation": physical}


def _region(line: int, column: int | None, end_column: int | None) -> Json:
    region: Json = {"startLine": line}
    if column is not None:
        region["startColumn"] = column
        if end_column is not None and end_column > column:
            region["endColumn"] = end_column
    return region
