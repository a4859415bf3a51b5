"""Reading of whatever a source is: a path, a stream, a mapping, a plan or its JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TypeGuard, Union

from scenecc.diagnostics.frozen import frozen
from scenecc.source import Document, Limits, read_dict, read_text
from scenecc.source.lines import Lines
from scenecc.source.text import decode, read_bytes, read_some

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

Source = Union[str, "PathLike[str]", IO[str], IO[bytes], Mapping[str, Any], "ScenePlan"]
"""A path, an open stream, a mapping, a plan, or a plan's JSON."""

_PLAN_KEY = "scenecc_plan"
_PLAN_TEXT = re.compile(r'\s*\{\s*"scenecc_plan"\s*:')


@frozen
class Input:
    """What was read. `plan_text`: the text of a plan, where it is one and no scene."""

    document: Document
    plan_text: str | None = None


def as_plan(source: Source) -> ScenePlan | None:
    """The source itself, if it is a plan."""
    if isinstance(source, str | bytes | Mapping):
        return None
    from scenecc.plan import ScenePlan

    return source if isinstance(source, ScenePlan) else None


def read_input(source: Source, limits: Limits, sink: Sink) -> Input | None:
    """Reads a source that is no plan yet; None where it is no good.

    Raises:
        TypeError: the source is nothing that can hold a scene.
    """
    path: Path | None = None
    if isinstance(source, Mapping):
        document = read_dict(source, sink, limits)
        return document and _input(document)
    if isinstance(source, str) and _is_plan_json(source):
        name, content = "<plan>", source
    elif isinstance(source, str | PathLike):
        name, path = fspath(source), Path(source).absolute()
        content = read_bytes(name, sink, limits)
    elif _is_stream(source):
        name = getattr(source, "name", None)
        name = name if isinstance(name, str) else "<stream>"
        content = read_some(source, name, sink, limits)
    else:  # pyright: ignore[reportUnreachable] - callers without a type checker
        raise TypeError(f"a scene is a path, a stream, a mapping or a plan, not {type(source).__name__}")
    text = None if content is None else decode(content, name, sink, limits)
    if text is None:
        return None
    if _is_plan_json(text):
        return Input(Document(name, path, {}, Lines(name, text)), text)
    document = read_text(text, name, sink, limits, path)
    return document and _input(document)


def _is_stream(source: Source) -> TypeGuard[IO[str] | IO[bytes]]:
    return hasattr(source, "read")


def _input(document: Document) -> Input:
    """A plan may have become YAML or Python data on its way."""
    is_plan = _PLAN_KEY in document.data
    return Input(document, json.dumps(document.data, ensure_ascii=False) if is_plan else None)


def _is_plan_json(text: str) -> bool:
    """Whether JSON has the key of a plan at its top level. Text without that key anywhere is not parsed for it."""
    if _PLAN_TEXT.match(text):
        return True
    if f'"{_PLAN_KEY}"' not in text or text.lstrip()[:1] != "{":
        return False
    try:
        data: object = json.loads(text)
    except (ValueError, RecursionError):
        return False
    return isinstance(data, dict) and _PLAN_KEY in data
