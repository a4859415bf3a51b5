"""What YAML means, and what of it a scene file must not hold."""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

import pytest
from plugins.diagnostics import TakingSink

from scenecc.diagnostics import Diagnostic
from scenecc.source import read_text

Read = Callable[..., Any]
Faults = Callable[..., list[Diagnostic]]

READ_RIGHT = {
    "a: yes\nb: 'x'\n": {"a": "yes", "b": "x"},
    "a: '12'\nb: \"12\"\nc: 12\n": {"a": "12", "b": "12", "c": 12},
    "{'a': 1, \"b\": 2, c: {d: [1, [2], {e: 3}]}}": {"a": 1, "b": 2, "c": {"d": [1, [2], {"e": 3}]}},
    '{"a": 1, "b": [true, "x", 1.5]}': {"a": 1, "b": [True, "x", 1.5]},
    "a: |\n  x\n  y\nb: >\n  x\n  y\n": {"a": "x\ny\n", "b": "x y\n"},
    "a: !!str 12\nb: !!int '12'\nc: !!float 1\nd: !!bool 'true'\ne: !!float .inf\n": {
        "a": "12",
        "b": 12,
        "c": 1.0,
        "d": True,
        "e": float("inf"),
    },
    "a: !!map {b: 1}\nc: !!seq [1]\n!!str 12: x\n": {"a": {"b": 1}, "c": [1], "12": "x"},
    "a: !!str\nb: ''\nc: []\nd: {}\n": {"a": "", "b": "", "c": [], "d": {}},
    "? a\n: 1\n": {"a": 1},
    "per_scene: {0: a, 12: b, default: c}\n": {"per_scene": {"0": "a", "12": "b", "default": "c"}},
    "'<<': 1\n": {"<<": 1},
    "a: <<\n": {"a": "<<"},
    "---\na: 1\n...\n": {"a": 1},
    "%YAML 1.2\n---\na: 1\n": {"a": 1},
    "x-note: [anything]\na: 1\n": {"x-note": ["anything"], "a": 1},
    "a: ${r}\nb: -${r / 2}\nc: ${f(1)[0]}\n": {"a": "${r}", "b": "-${r / 2}", "c": "${f(1)[0]}"},
    "a: ü €\nb: '\U0001f600'\n": {"a": "ü €", "b": "\U0001f600"},
    "a: 1\rb: 2\r\nc: 3\n": {"a": 1, "b": 2, "c": 3},
    "\ufeffa: 1\n": {"a": 1},
    "a:\t1\t# tab\nb: [1,\t2]\n": {"a": 1, "b": [1, 2]},
    "a: &x k\n*x : 2\n": {"a": "k", "k": 2},
    "a: &x 1\nb: &x 2\nc: *x\n": {"a": 1, "b": 2, "c": 2},
    "a: &x [&x 1, *x]\n": {"a": [1, 1]},
}


@pytest.mark.parametrize("text", [text for text, data in READ_RIGHT.items() if data is not None])
def test_valid_text_gives_the_expected_data(text: str, read: Read) -> None:
    data = read(text)
    assert data == READ_RIGHT[text]
    assert list(data) == list(READ_RIGHT[text] or ())


MERGES = {
    "a: &a {p: 1, q: 2}\nb: {z: 0, <<: *a, q: 5}\n": [("z", 0), ("p", 1), ("q", 5)],
    "a: &a {p: 1, q: 2}\nb: {q: 5, <<: *a, z: 0}\n": [("q", 5), ("p", 1), ("z", 0)],
    "a: &a {p: 1}\nc: &c {p: 2, q: 3}\nb: {<<: [*a, *c]}\n": [("p", 1), ("q", 3)],
    "a: &a {p: 1}\nb: {<<: [*a, {r: 4}], s: 5}\n": [("p", 1), ("r", 4), ("s", 5)],
    "a: &a {p: 1}\nc: &c {<<: *a, q: 3}\nb: {<<: *c}\n": [("p", 1), ("q", 3)],
    "b: {<<: {p: 1, <<: {q: 2}}, q: 3}\n": [("p", 1), ("q", 3)],
    "a: &a {}\nb: {<<: *a}\n": [],
}


@pytest.mark.parametrize("text", MERGES)
def test_merge_keys_are_applied(text: str, read: Read) -> None:
    assert list(read(text)["b"].items()) == MERGES[text]


def test_a_merge_does_not_change_the_anchor(read: Read) -> None:
    data = read("a: &a {p: 1, q: {r: 1}}\nb: {<<: *a, p: 2}\n")
    assert data["a"] == {"p": 1, "q": {"r": 1}}
    assert data["b"]["q"] is data["a"]["q"]


def test_aliases_share_their_node(read: Read) -> None:
    data = read("a: &a [1, {b: 2}]\nc: [*a, *a]\n")
    assert data["c"][0] is data["a"]
    assert data["c"][1] is data["a"]


REFUSED = {
    "a: 1\nb: 2\na: 3\n": ("SC004", 3, 1, "a"),
    "a: 1\n'a': 3\n": ("SC004", 2, 1, "a"),
    "a: {b: [{c: 1, c: 2}]}\n": ("SC004", 1, 16, "a.b[0].c"),
    "b: &b {p: 1}\nc: {<<: *b, q: 1, q: 2}\n": ("SC004", 2, 19, "c.q"),
    "b: &b {p: 1}\nc: {<<: *b, p: 1, p: 2}\n": ("SC004", 2, 19, "c.p"),
    "b: &b {p: 1}\nc: {<<: *b, <<: *b}\n": ("SC004", 2, 13, "c.<<"),
    "per_scene: {0: a, 00: b}\n": ("SC004", 1, 19, "per_scene.0"),
    "per_scene: {true: a}\n": ("SC005", 1, 13, "per_scene"),
    "per_scene: {a: {0: a}}\n": ("SC005", 1, 17, "per_scene.a"),
    "12: 1\n": ("SC005", 1, 1, ""),
    "a: {true: 1}\n": ("SC005", 1, 5, "a"),
    "a: {1.5: 1}\n": ("SC005", 1, 5, "a"),
    "a: {~: 1}\n": ("SC005", 1, 5, "a"),
    "? [1, 2]\n: 1\n": ("SC005", 1, 3, ""),
    "? {a: 1}\n: 1\n": ("SC005", 1, 3, ""),
    "a: &x [1]\n*x : 2\n": ("SC005", 2, 1, ""),
    "a: &x 1\n*x : 2\n": ("SC005", 2, 1, ""),
    "!!int 12: 1\n": ("SC005", 1, 1, ""),
    "a:\nb: 1\n": ("SC006", 1, 1, "a"),
    "a: {b: {c: ~}}\n": ("SC006", 1, 9, "a.b.c"),
    "a: [1, null]\n": ("SC006", 1, 8, "a[1]"),
    "a:\n  -\n  - 1\n": ("SC006", 2, 4, "a[0]"),
    "a: !!null x\n": ("SC008", 1, 4, "a"),
    "a: !!null ''\n": ("SC006", 1, 1, "a"),
    "<<:\n": ("SC006", 1, 1, "<<"),
    "a: 1\n---\nb: 1\n": ("SC007", 2, 1, ""),
    "a: 1\n...\n---\n": ("SC007", 3, 1, ""),
    "a: !local 1\n": ("SC008", 1, 4, "a"),
    "a: !!python/object/apply:os.system [ls]\n": ("SC008", 1, 4, "a"),
    "a: !!python/name:os.system x\n": ("SC008", 1, 4, "a"),
    "a: !!binary aGk=\n": ("SC008", 1, 4, "a"),
    "a: !!set {b: 1}\n": ("SC008", 1, 4, "a"),
    "a: !!timestamp 2001-12-14\n": ("SC008", 1, 4, "a"),
    "a: !!omap [b: 1]\n": ("SC008", 1, 4, "a"),
    "a: !!int x\n": ("SC008", 1, 4, "a"),
    "a: !!int 1.5\n": ("SC008", 1, 4, "a"),
    "a: !!int true\n": ("SC008", 1, 4, "a"),
    "a: !!bool 1\n": ("SC008", 1, 4, "a"),
    "a: !!float x\n": ("SC008", 1, 4, "a"),
    "a: !!map [1]\n": ("SC008", 1, 4, "a"),
    "a: !!seq {b: 1}\n": ("SC008", 1, 4, "a"),
    "a: !!str [1]\n": ("SC008", 1, 4, "a"),
    "a: !!map 1\n": ("SC008", 1, 4, "a"),
    "a: !<tag:example.org,2000:x> 1\n": ("SC008", 1, 4, "a"),
    "!foo a: 1\n": ("SC008", 1, 1, ""),
    "%TAG !! !x\n---\na: !!int 1\n": ("SC008", 3, 4, "a"),
    "a: *b\n": ("SC009", 1, 4, "a"),
    "a: [*b]\nc: &b 1\n": ("SC009", 1, 5, "a[0]"),
    "a: {<<: *b}\n": ("SC009", 1, 9, "a.<<"),
    "a: &a [*a]\n": ("SC010", 1, 8, "a[0]"),
    "a: &a {b: {c: *a}}\n": ("SC010", 1, 15, "a.b.c"),
    "&a a: {<<: *a}\n": ("SC011", 1, 8, "a.<<"),
    "a: &a {<<: *a}\n": ("SC010", 1, 12, "a.<<"),
    "&top\na: *top\n": ("SC010", 2, 4, "a"),
    "a: {<<: 1}\n": ("SC011", 1, 5, "a.<<"),
    "a: {<<: [1]}\n": ("SC011", 1, 5, "a.<<"),
    "": ("SC012", 1, 1, ""),
    "# nothing\n": ("SC012", 1, 1, ""),
    "---\n": ("SC012", 1, 1, ""),
    "~\n": ("SC012", 1, 1, ""),
    "- a\n": ("SC013", 1, 1, ""),
    "a\n": ("SC013", 1, 1, ""),
    "12\n": ("SC013", 1, 1, ""),
    "a: 1e400\n": ("SC014", 1, 4, "a"),
    "a: [" + "1" * 101 + "]\n": ("SC014", 1, 5, "a[0]"),
    "a: !!float 1e400\n": ("SC014", 1, 4, "a"),
    "%YAML 1.1\n---\na: 1\n": ("SC003", 1, 1, ""),
}


@pytest.mark.parametrize("text", REFUSED)
def test_invalid_text_gives_its_code_and_place(text: str, faults: Faults) -> None:
    found = [(fault.code, fault.line, fault.column, fault.path) for fault in faults(text)]
    assert found == [REFUSED[text]]


def test_both_places_of_a_duplicate_key_are_named(faults: Faults) -> None:
    first, second = faults("a: 1\nb: {c: 1,\n    c: 2}\n# ü\n  \na: 3\n")
    assert (first.line, first.column, first.location.end_column) == (3, 5, 6)
    assert [(place.message, place.location.line, place.location.column) for place in first.related] == [
        ("first written here", 2, 5)
    ]
    assert (second.line, second.related[0].location.line, second.related[0].location.text) == (6, 1, "a: 1")


def test_each_repetition_of_a_key_refers_to_the_first(faults: Faults) -> None:
    assert [(fault.line, fault.related[0].location.line) for fault in faults("a: 1\na: 2\na: 3\n")] == [(2, 1), (3, 1)]


def test_a_nested_duplicate_refers_to_its_own_first(faults: Faults) -> None:
    outer, inner = faults("a: {b: 1}\na: {b: 1, c: 2,\n  b: 3}\n")
    assert (outer.line, outer.related[0].location.line) == (2, 1)
    assert (inner.line, inner.related[0].location.line, inner.path) == (3, 2, "a.b")


def test_all_errors_of_a_text_are_reported_at_once(faults: Faults) -> None:
    text = "a: 1\nb:\na: 2\n12: 3\nc: !x 1\nd: *e\nf: 1e999\ng: {<<: 1}\nh: [1, ${x}]\n"
    found = [(fault.code, fault.line) for fault in faults(text)]
    assert found == [
        ("SC006", 2),
        ("SC004", 3),
        ("SC005", 4),
        ("SC008", 5),
        ("SC009", 6),
        ("SC014", 7),
        ("SC011", 8),
        ("SC003", 9),
    ]


def test_columns_of_diagnostics_count_characters(faults: Faults) -> None:
    fault = faults("a: {'\U0001f600ü': 1, b: !x y}\n")[0]
    assert (fault.line, fault.column, fault.location.end_column) == (1, 17, 21)


def test_the_garbage_collector_is_enabled_after_reading(sink: TakingSink) -> None:
    assert gc.isenabled()
    read_text("a: [", None, sink)
    assert gc.isenabled()
    sink.take("SC003")
    gc.disable()
    try:
        read_text("a: 1", None, sink)
        assert not gc.isenabled()
    finally:
        gc.enable()


@pytest.mark.parametrize("text", [text for text in READ_RIGHT if "\t" not in text])
def test_libyaml_and_the_python_parser_read_the_same(text: str, read: Read, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("yaml.__with_libyaml__", False)
    assert read(text) == READ_RIGHT[text]


@pytest.mark.parametrize("text", REFUSED)
def test_libyaml_and_the_python_parser_refuse_the_same(
    text: str, faults: Faults, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("yaml.__with_libyaml__", False)
    code, line, _, path = REFUSED[text]
    assert [(fault.code, fault.line, fault.path) for fault in faults(text)] == [(code, line, path)]
