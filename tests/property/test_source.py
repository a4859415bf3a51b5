"""Properties of the reader: data survives, any text is answered, and places are true."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import Any

import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from plugins.nightly import assert_took, examples

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin, Path
from scenecc.source import read_dict, read_text

# What YAML 1.1's dumper leaves unquoted and 1.2 reads as a number is not the reader's fault, nor is what
# the reader refuses in any text; both are taken out of what is dumped.
CHARACTERS = st.characters(exclude_categories=["Cs"], exclude_characters="\x85\u2028\u2029\ufffe\uffff\x7f")
TEXTS = st.text(CHARACTERS, max_size=20)
KEYS = TEXTS.filter(lambda key: "\0" not in key)
SCALARS = st.booleans() | st.integers(-(10**30), 10**30) | st.floats(allow_nan=False) | TEXTS
DATA = st.dictionaries(
    KEYS,
    st.recursive(
        SCALARS, lambda below: st.lists(below, max_size=4) | st.dictionaries(KEYS, below, max_size=4), max_leaves=20
    ),
    max_size=5,
)


class Dumper(yaml.SafeDumper):
    """Quotes every string: which plain ones are strings is another matter in YAML 1.1."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


Dumper.add_representer(str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"'))


def same(first: Any, second: Any) -> bool:
    """Equal in value, type and, of dicts, order."""
    if type(first) is not type(second):
        return False
    if isinstance(first, dict):
        return list(first) == list(second) and all(same(first[key], second[key]) for key in first)
    if isinstance(first, list):
        return len(first) == len(second) and all(map(same, first, second))
    if isinstance(first, float):
        return first == second and math.copysign(1, first) == math.copysign(1, second)
    return first == second


@given(DATA, st.booleans() | st.none(), st.booleans())
def test_what_is_dumped_is_read_back(data: dict[str, Any], flow: bool | None, unicode: bool) -> None:
    text = yaml.dump(data, Dumper=Dumper, default_flow_style=flow, allow_unicode=unicode, sort_keys=False)
    sink = Sink()
    document = read_text(text, None, sink)
    assert document is not None, sink.diagnostics()
    assert same(document.data, data)


WORDS = st.sampled_from(["a", "box", "x-y", "half_size", "hello world", "ü", "no way", "${r / 2}"])
PLAIN = st.recursive(
    st.booleans() | st.integers() | st.floats(-1e6, 1e6).map(lambda x: round(x, 6)) | WORDS,
    lambda below: st.lists(below, max_size=4) | st.dictionaries(WORDS, below, max_size=4),
    max_leaves=20,
)


@given(st.dictionaries(WORDS, PLAIN, max_size=5), st.booleans() | st.none())
def test_what_safe_dump_writes_is_read_back(data: dict[str, Any], flow: bool | None) -> None:
    sink = Sink()
    document = read_text(yaml.safe_dump(data, default_flow_style=flow, sort_keys=False), None, sink)
    assert document is not None, sink.diagnostics()
    assert same(document.data, data)


@given(DATA)
def test_a_dict_is_taken_as_it_is(data: dict[str, Any]) -> None:
    sink = Sink()
    document = read_dict(data, sink)
    assert document is not None
    assert same(document.data, data)


PIECES = st.sampled_from([
    "a", "b", "12", "1e3", "~", "&x ", "*x", "<<", "!!str ", "!!int ", "!t ", ": ", ":", "- ", "? ", ", ", "[", "]",
    "{", "}", "'", '"', "|\n", ">\n", "\n", "\n  ", "\n    ", " ", "\t", "#", "---\n", "...\n", "%TAG ! x\n", "\\",
    "${", "\r", "\x00", "\u2028", "ü", "\ud800", "\ufeff",
])  # fmt: skip


@settings(max_examples=examples(400))
@given(st.lists(PIECES, max_size=40).map("".join) | st.text(max_size=200))
@example("a: &x {<<: *x}\n*x : 1")
@example("? &x a\n: *x\n? *x\n: *x")
@example("{? : 1, <<: [&y {b: 1}, *y]}")
def test_any_text_is_answered(text: str) -> None:
    sink = Sink()
    start = time.process_time()
    document = read_text(text, "x.yaml", sink)
    assert_took(time.process_time() - start, most=1.0)
    assert (document is None) == sink.failed
    for found in sink.diagnostics():
        assert found.line is not None
        assert found.column is not None
        assert found.message
    if document is not None:
        for path, _ in nodes(document.data):
            assert document.locate(Origin("x.yaml", path), "value").line is not None


@settings(max_examples=examples(200))
@given(st.binary(max_size=200) | st.text(max_size=50).map(lambda text: text.encode("utf-16", "surrogatepass")))
def test_any_bytes_are_answered(content: bytes) -> None:
    sink = Sink()
    assert (read_text(content, "x.yaml", sink) is None) == sink.failed
    assert all(str(found) for found in sink.diagnostics())


def nodes(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """All nodes below a value, and itself."""
    yield path, value
    if isinstance(value, dict):
        for key, item in value.items():
            yield from nodes(item, (*path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from nodes(item, (*path, index))


@settings(max_examples=examples(200))
@given(DATA, st.booleans() | st.none())
def test_places_hold_what_is_written_there(data: dict[str, Any], flow: bool | None) -> None:
    text = yaml.dump(data, Dumper=Dumper, default_flow_style=flow, allow_unicode=True, sort_keys=False, width=10**6)
    document = read_text(text, None, Sink())
    assert document is not None
    for path, value in nodes(document.data):
        place = document.locate(Origin(None, path), "value")
        assert place.text is not None
        assert place.column is not None
        written = place.text[place.column - 1 : (place.end_column or 0) - 1]
        if not isinstance(value, (dict, list)):
            assert same(_only(f"[{written}]"), value)
        if path and isinstance(path[-1], str):
            key = document.locate(Origin(None, path), "key")
            assert key.text is not None
            assert key.column is not None
            assert _only(f"[{key.text[key.column - 1 : (key.end_column or 0) - 1]}]") == path[-1]


def _only(text: str) -> Any:
    document = read_text("x: " + text, None, Sink())
    assert document is not None, text
    return document.data["x"][0]
