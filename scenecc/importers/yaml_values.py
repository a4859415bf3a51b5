"""Values of YAML files of other programs, with their tags and places.

Unlike `scenecc.source`, which reads scenes, it keeps tags such as `!Rpy`. An alias is the same node as its anchor, and
each value is read by what it must be, so that aliases cannot multiply the work.
"""

from __future__ import annotations

import contextlib
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import yaml

from scenecc.diagnostics.messages import cut, suggest
from scenecc.importers.imported_scene import Loss
from scenecc.source.events import resolve_scalar
from scenecc.source.syntax_errors import ReadAborted, SourceReporter, report_syntax
from scenecc.source.text import TextLines, check_value_count, decode_text, read_bytes

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location
    from scenecc.importers.imported_scene import ImportContext

_MAX_NUMBER = 1e30
"""Larger numbers count as infinite, since the engine has single precision."""

_RANDOM = frozenset({"!Uniform", "!Gaussian", "!UniformDiscrete", "!UniformVector", "!GaussianVector"})
"""Drake's tags of values that are drawn."""

_CORE_TAG = "tag:yaml.org,2002:"


class ValueFault(Exception):
    """An invalid value: what is wrong, where, and a hint. `loss`: kind of loss instead of an error; "": an error."""

    def __init__(self, message: str, place: Location, hint: str | None = None, loss: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.place = place
        self.hint = hint
        self.loss = loss

    def report(self, sink: Sink, losses: list[Loss]) -> None:
        """Reports it as an error (SC433), or adds it to the losses."""
        if self.loss:
            losses.append(Loss(self.loss, self.message, self.place))
        else:
            sink.report("SC433", self.message, self.place, hint=self.hint)


@dataclass(frozen=True, slots=True)
class YamlValue:
    """A node of a YAML text. `name`: in messages, such as `directives[2].add_model`."""

    node: Any
    lines: TextLines
    name: str

    @property
    def location(self) -> Location:
        """Its first line."""
        start, end = self.node.start_mark, self.node.end_mark
        return self.lines.location(start.line, start.column, end.column if end.line == start.line else None)

    @property
    def tag(self) -> str:
        """Its tag, such as `!Rpy`; "" if it has none."""
        tag = self.node.tag or ""
        return "" if tag.startswith(_CORE_TAG) else tag

    def _refuse_tag(self) -> None:
        if self.tag:
            hint = "write a value; a scene draws values itself"
            what = "random value" if self.tag in _RANDOM else "tag"
            raise self.fault(f"{{}} has the {what} `{cut(self.tag)}`, which is not read", hint)

    def fault(self, message: str, hint: str | None = None, loss: str = "") -> ValueFault:
        """Returns an error at this value; `{}` in the message becomes its name."""
        return ValueFault(
            message.replace("{}", f"`{cut(self.name)}`" if self.name else "the file"), self.location, hint, loss
        )

    def entries(self, *known: str) -> dict[str, YamlValue]:
        """Returns the entries of a mapping by key. `known`: the possible keys; none: any."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self.fault("{} must be a mapping")
        found: dict[str, YamlValue] = {}
        for key, value in self.node.value:
            place = YamlValue(key, self.lines, self.name)
            if not isinstance(key, yaml.ScalarNode):
                raise place.fault("a key in {} is not a string")
            name = str(key.value)
            if known and name not in known:
                hint = suggest(name, known)
                raise place.fault(f"there is no key `{cut(name)}` in {{}}", hint)
            if name in found:
                raise place.fault(f"the key `{cut(name)}` of {{}} is written twice")
            found[name] = YamlValue(value, self.lines, f"{self.name}.{name}" if self.name else name)
        return found

    def items(self) -> list[YamlValue]:
        """Returns the items of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.fault("{} must be a list")
        return [YamlValue(item, self.lines, f"{self.name}[{index}]") for index, item in enumerate(self.node.value)]

    def text(self) -> str:
        """Returns a string that is not empty."""
        self._refuse_tag()
        if not isinstance(self.node, yaml.ScalarNode) or not self.node.value:
            raise self.fault("{} must be a string")
        return str(self.node.value)

    def number(self) -> float:
        """Returns a finite number."""
        self._refuse_tag()
        value: Any = None
        if isinstance(self.node, yaml.ScalarNode) and not self.node.style:
            try:
                value = resolve_scalar(self.node.value)
            except OverflowError:
                value = math.inf
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _MAX_NUMBER:
            raise self.fault("{} must be a finite number")
        return float(value)

    def numbers(self, count: int) -> tuple[float, ...]:
        """Returns a list of `count` finite numbers."""
        self._refuse_tag()
        items = self.items()
        if len(items) != count:
            raise self.fault(f"{{}} must be a list of {count} number{'s' if count > 1 else ''}")
        return tuple(item.number() for item in items)


_JSON_ESCAPE = re.compile(r"\\(?:u(d[89ab][0-9a-f]{2})\\u(d[c-f][0-9a-f]{2})|.)", re.IGNORECASE | re.DOTALL)


def _plain_escape(match: re.Match[str]) -> str:
    """Returns an escape of JSON as YAML has it: a character beyond U+FFFF itself instead of two halves."""
    if match[1] is None:
        return "/" if match[0] == "\\/" else match[0]
    return chr(0x10000 + ((int(match[1], 16) - 0xD800) << 10) + int(match[2], 16) - 0xDC00)


def read_yaml_value(path: Path, shown: str, context: ImportContext, *, is_json: bool = False) -> YamlValue | None:
    """Returns the top value of a file; None after an error.

    Args:
        path: of the file.
        shown: its name in messages.
        context: of the import.
        is_json: whether the file is JSON, which differs from YAML in two escapes.
    """
    content = read_bytes(str(path), context.sink, context.limits)
    text = None if content is None else decode_text(content, shown, context.sink, context.limits)
    if text is None or not check_value_count(text, shown, context.sink, context.limits):
        return None
    text = _JSON_ESCAPE.sub(_plain_escape, text) if is_json else text
    lines = TextLines(shown, text)
    try:
        node: Any = yaml.compose(text, yaml.CSafeLoader if yaml.__with_libyaml__ else yaml.SafeLoader)
    except yaml.YAMLError as error:
        with contextlib.suppress(ReadAborted):
            report_syntax(error, SourceReporter(lines, context.sink))
        return None
    except RecursionError:
        context.sink.report("SC602", "the file is nested too deeply", lines.location(0, 0, 1))
        return None
    if node is None:
        context.sink.report("SC430", "the file is empty", lines.location(0, 0, 1))
        return None
    return YamlValue(node, lines, "")
