"""What can be asked about the language and about scenes without building one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["check_limits", "json_schema", "read_setting"]


def json_schema() -> dict[str, Any]:
    """The JSON Schema of scene files, for editors."""
    from scenecc.spec.schema import json_schema as schema

    return schema()


def check_limits(limits: Mapping[str, int] | None) -> None:
    """Whether `limits` can be given to the functions of the API.

    Raises:
        ValueError: a name is not that of a limit, or a value is not a positive integer.
    """
    from scenecc.source import make_limits

    make_limits(limits)


def read_setting(text: str) -> tuple[str, Any]:
    """The name and the value of a parameter, from `name=value`. The value is YAML on one line.

    Raises:
        ValueError: it is not of that form.
    """
    from scenecc.diagnostics import Sink
    from scenecc.source import read_value

    name, equals, written = text.partition("=")
    if not equals or not name.strip():
        raise ValueError("it is not name=value, as in size=0.5")
    sink = Sink()
    value = read_value(written, sink)
    for diagnostic in sink.diagnostics():
        if diagnostic.code == "SC006":
            raise ValueError('it has no value (an empty text is "")')
        raise ValueError(f"{diagnostic.message}{f' ({diagnostic.hint})' if diagnostic.hint else ''}")
    return name.strip(), value
