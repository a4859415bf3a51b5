"""Several errors of one validator at once, and errors that know how they are told."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails, InitErrorDetails

    from scenecc.diagnostics import At, PathKey

TOLD = "#told"
"""The error type of a mistake that brings its own diagnostic in its context."""

THIS = "{this}"
"""Stands in such a message for what the value at the mistake's place is called."""


def told(
    code: str, message: str, *, at: At = "value", hint: str | None = None, span: tuple[int, int] | None = None
) -> PydanticCustomError:
    """A mistake as it is to be told.

    Args:
        code: a row of the table of codes.
        message: of the diagnostic; `THIS` in it is replaced.
        at: which half of the entry is meant.
        hint: of the diagnostic.
        span: the part of a text that is meant (characters, end exclusive); None: all of it.
    """
    return PydanticCustomError(
        TOLD, "{message}", {"code": code, "message": message, "at": at, "hint": hint, "span": span}
    )


class Mistakes:
    """The errors of one validator, raised together."""

    def __init__(self) -> None:
        self._lines: list[InitErrorDetails] = []

    def add(self, error: PydanticCustomError, found: Any, *loc: PathKey) -> None:
        """Adds one.

        Args:
            error: what is wrong.
            found: the value.
            loc: where it is in the value that is validated.
        """
        self._lines.append({"type": error, "loc": loc, "input": found})

    def take(self, problem: ValidationError, *loc: PathKey) -> None:
        """Adds the errors of a validator that was called for a part of the value."""
        self._lines += [_again(error, loc) for error in problem.errors(include_url=False)]

    def stop(self) -> None:
        """Raises what there is.

        Raises:
            ValidationError: there was a mistake.
        """
        if self._lines:
            raise ValidationError.from_exception_data("value", self._lines)


def _again(error: ErrorDetails, loc: tuple[PathKey, ...]) -> InitErrorDetails:
    kind, context = error["type"], error.get("ctx", {})
    again: Any = PydanticCustomError(kind, error["msg"], context) if kind.startswith("#") else kind  # pyright: ignore[reportArgumentType]
    return {"type": again, "loc": (*loc, *error["loc"]), "input": error["input"], "ctx": context}
