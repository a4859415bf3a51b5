"""Expressions in a document as written, and what is said where nothing may differ from scene to scene."""

from __future__ import annotations

from typing import Any

from scenecc.spec.mistakes import THIS, told
from scenecc.spec.plain import is_mapping
from scenecc.variation.errors import ExpressionError
from scenecc.variation.forms import FORM_KEYS
from scenecc.variation.template import Template


def read_fixed(node: Any) -> Template:
    """An expression in a document as written; anything else that varies is a mistake.

    Raises:
        PydanticCustomError: it is one.
    """
    if is_mapping(node):
        form = next(key for key in node if key in FORM_KEYS)
        raise told("SC116", f"{THIS} cannot differ from scene to scene: `{form}` has no place here")
    if isinstance(node, Template):
        raise told("SC116", f"{THIS} reads {read_names(node)} and so would differ from scene to scene, which it cannot")
    return written(node)


def written(text: str) -> Template:
    """The template of a text in a document as written.

    Raises:
        PydanticCustomError: it cannot be read.
    """
    try:
        return Template.parse(text)
    except ExpressionError as problem:
        raise told("SC118", problem.message, hint=problem.hint, span=(problem.start, problem.end)) from None


def read_names(template: Template) -> str:
    """The names that a template reads, as a message has them."""
    return " and ".join(f"`{name}`" for name in sorted(template.names))
