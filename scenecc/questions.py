"""What can be asked about the language and about scenes without building one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["check_limits", "json_schema"]


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
