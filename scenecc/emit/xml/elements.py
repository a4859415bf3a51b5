"""XML as it is written: elements, and numbers as short as they can be."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

_INDENT = "  "


class Element:
    """An element and those in it. Attributes that are None are not there."""

    __slots__ = ("attributes", "children", "tag")

    def __init__(self, tag: str, **attributes: Any) -> None:
        self.tag = tag
        self.attributes = {name: written(value) for name, value in attributes.items() if value is not None}
        self.children: list[Element] = []

    def add(self, tag: str, **attributes: Any) -> Element:
        """A new element in this one."""
        return self.take(Element(tag, **attributes))

    def take(self, child: Element) -> Element:
        """Puts an element into this one, as the last."""
        self.children.append(child)
        return child

    def walk(self) -> Iterator[Element]:
        """This one and all below it, in the order of the text."""
        yield self
        for child in self.children:
            yield from child.walk()

    def lines(self, depth: int = 0) -> Iterator[str]:
        """The text of it, line by line."""
        head = "".join(f" {name}={quoteattr(value)}" for name, value in self.attributes.items())
        if not self.children:
            yield f"{_INDENT * depth}<{self.tag}{head}/>"
            return
        yield f"{_INDENT * depth}<{self.tag}{head}>"
        for child in self.children:
            yield from child.lines(depth + 1)
        yield f"{_INDENT * depth}</{self.tag}>"


def document(root: Element) -> bytes:
    """A file of this element."""
    return "\n".join(['<?xml version="1.0" encoding="utf-8"?>', *root.lines(), ""]).encode()


def written(value: Any) -> str:
    """An attribute: a text, a flag, a number, or several numbers."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    return number(float(value)) if np.ndim(value) == 0 else numbers(value)


def numbers(values: Iterable[float]) -> str:
    """Numbers with spaces between them."""
    return " ".join(number(float(value)) for value in values)


def number(value: float) -> str:
    """The shortest text of a number; of one that single precision holds, the shortest that this reads as it."""
    if value == 0:
        return "0"
    with np.errstate(over="ignore"):
        single = np.float32(value)
    text = str(single) if float(single) == value else repr(value)
    return text.removesuffix(".0")
