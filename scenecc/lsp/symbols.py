"""The outline of a scene file: its sections, with the names in them."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from scenecc.spec.references import NAME_SECTIONS

if TYPE_CHECKING:
    from scenecc.lsp.analysis import SceneText
    from scenecc.source.document import Span


class Symbol(NamedTuple):
    """A section, or a name in it.

    Attributes:
        name: its name.
        section: the section that it is, or that contains it.
        span: span of its key.
        last: last line of its content.
        detail: kind of object.
        below: the names of a section.
    """

    name: str
    section: str
    span: Span
    last: int
    detail: str = ""
    below: tuple[Symbol, ...] = ()


def symbols_of(text: SceneText) -> list[Symbol]:
    """Returns the sections of a text that contain names, in file order."""
    found: list[Symbol] = []
    for section in NAME_SECTIONS:
        span = text.key_span((section,))
        if span is not None:
            below = (_make_symbol(text, section, name) for name in text.names(section))
            found.append(Symbol(section, section, span, span[0], below=tuple(one for one in below if one)))
    found.sort(key=lambda one: one.span[:2])
    return [_close_section(one, text) for one in found]


def _make_symbol(text: SceneText, section: str, name: str) -> Symbol | None:
    span = text.key_span((section, name))
    if span is None:
        return None
    keys = text.scalars((section, name))
    kind = next((key for key in ("use", "urdf", "mjcf", "root", "variants") if key in keys), None)
    detail = keys.get("type") or (kind and f"{kind} {keys[kind] or ''}".rstrip()) or keys.get("body_type") or ""
    return Symbol(name, section, span, span[0], detail)


def _close_section(section: Symbol, text: SceneText) -> Symbol:
    """Returns a section whose parts end where the next one begins."""
    lines = [leaf.line for leaf in text.leaves if leaf.path[:1] == (section.section,)]
    last = max(lines, default=section.last)
    starts = [one.span[0] for one in section.below]
    ends = [*[max(after - 1, start) for start, after in pairwise(starts)], last][: len(starts)]
    below = tuple(one._replace(last=max(end, one.last)) for one, end in zip(section.below, ends, strict=True))
    return section._replace(last=last, below=below)
