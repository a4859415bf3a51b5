"""Texts that are made to hang, exhaust or confuse: a clear error, or read right."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from plugins.diagnostics import TakingSink
from plugins.nightly import assert_took

from scenecc import validate
from scenecc.diagnostics import Sink
from scenecc.source import Limits, read_file, read_text

MIB = 2**20


def _laughs(merge: bool = False) -> str:
    lines = ["a0: &a0 {k: 1}" if merge else "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    for level in range(1, 30):
        below = ", ".join([f"*a{level - 1}"] * 10)
        lines.append(
            f"a{level}: &a{level} {{k: {{<<: [{below}], k{level}: [{below}]}}}}"
            if merge
            else f"a{level}: &a{level} [{below}]"
        )
    return "\n".join(lines)


def _tall() -> str:
    """Aliases to deep nodes under deep nodes: a height of thousands from few of them."""
    tall = [f"a{level}: &a{level} " + "[" * 90 + f"*a{level - 1}" + "]" * 90 for level in range(1, 60)]
    return "\n".join(["a0: &a0 1", *tall])


HOSTILE: dict[str, tuple[Callable[[], str | bytes], str]] = {
    "billion laughs": (_laughs, "SC603"),
    "billion laughs by merges": (lambda: _laughs(merge=True), "SC603"),
    "height by aliases": (_tall, "SC602"),
    "5000 [": (lambda: "a: " + "[" * 5000 + "]" * 5000, "SC602"),
    "5000 {": (lambda: "a: " + "{a: " * 5000 + "1" + "}" * 5000, "SC602"),
    "5000 { as keys": (lambda: "{" * 5000, "SC602"),
    "5000 -": (lambda: "a:\n  " + "- " * 5000 + "1", "SC602"),
    "5000 ?": (lambda: "? " * 5000, "SC602"),
    "5000 indents": (lambda: "".join(" " * i + "a:\n" for i in range(5000)), "SC602"),
    "5000 merges": (lambda: "a: " + "{<<: " * 5000, "SC602"),
    "a million -": (lambda: "a:\n  " + "- " * 1_000_000, "SC602"),
    "16 MiB of [": (lambda: "[" * 16 * MIB, "SC013 SC602"),  # the latter where libyaml looks too far ahead
    "16 MiB of [ in a key": (lambda: "a: " + "[" * (16 * MIB - 3), "SC602"),
    "16 MiB of {": (lambda: "{" * 16 * MIB, "SC602"),
    "16 MiB of blanks": (lambda: " " * 16 * MIB, "SC012"),
    "16 MiB of line breaks": (lambda: "\n" * 16 * MIB, "SC601"),
    "16 MiB of comment": (lambda: "#" * 16 * MIB, "SC012"),
    "16 MiB of one scalar": (lambda: "x" * 16 * MIB, "SC013"),
    "16 MiB of quotes": (lambda: 'a: "' + "x" * (16 * MIB - 4), "SC003"),
    "16 MiB of a digit": (lambda: "a: " + "1" * (16 * MIB - 3), "SC014"),
    "16 MiB of hexadecimal": (lambda: "a: 0x" + "f" * (16 * MIB - 5), "SC014"),
    "16 MiB of an anchor": (lambda: "&" + "a" * (16 * MIB - 1), "SC012"),
    "one byte too many": (lambda: "#" * (16 * MIB + 1), "SC601"),
    "one character too many": (lambda: "#" * (16 * MIB - 1) + "ü", "SC601"),
    "zero bytes": (lambda: b"\0" * 16 * MIB, "SC002"),
    "documents": (lambda: "---\n" * 4 * MIB, "SC012"),
    "colons": (lambda: "a: " * MIB, "SC003"),
    "a bracket too many after a long line": (lambda: "x: [" + "1, " * 100_000 + "1]\ny: [1]]\n", "SC003"),
    "words without commas": (
        lambda: "".join(f"k{i}: [{'a b, ' * 55}a]\n" for i in range(90)) + f"x: [{'a b { ' * 45}\n",
        "SC003",
    ),
    "errors": (lambda: "x:\n" + "- \n" * MIB, "SC016"),
    "duplicates": (lambda: "a: 1\n" * MIB, "SC016"),
    "number keys": (lambda: "1: 1\n" * MIB, "SC016"),
    "tag directives": (lambda: "".join(f"%TAG !a{i}! x\n" for i in range(500_000)) + "---\na: 1", "SC008"),
    "tag directives later": (
        lambda: "a: 1\n...\r" + "".join(f"%TAG !a{i}! x\r" for i in range(500_000)) + "---\na: 1",
        "SC008",
    ),
    "a PNG": (lambda: b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 100, "SC002"),
    "an ELF": (lambda: b"\x7fELF\x02\x01\x01" + b"\0" * 100, "SC002"),
    "a gzip": (lambda: b"\x1f\x8b\x08" + bytes(range(256)), "SC002"),
    "a zero byte": (lambda: "a: b\0c", "SC002"),
    "UTF-16 without a mark": (lambda: "a: 1".encode("utf-16-le"), "SC002"),
    "UTF-16 cut short": (lambda: "a: 1".encode("utf-16")[:-1], "SC002"),
    "UTF-32": (lambda: "a: 1".encode("utf-32"), "SC002"),
    "Latin-1": (lambda: "a: ü\n".encode("latin-1"), "SC002"),
    "bytes of a surrogate": (lambda: b"a: \xed\xa0\x80", "SC002"),
    "a surrogate": (lambda: "a: \ud800", "SC002"),
    "a surrogate behind a byte order mark": (lambda: "\ufeff\ud800", "SC002"),
    "an escaped surrogate": (lambda: 'a: "\\ud800"', "SC003"),
    "an overlong form": (lambda: b"a: \xc0\xaf", "SC002"),
    "next line": (lambda: "a: x\x85b: 1", "SC002"),
    "line separator": (lambda: "# a\u2028b: 1", "SC002"),
    "paragraph separator": (lambda: "a: 'x\u2029y'", "SC002"),
    "delete": (lambda: "a: \x7f", "SC002"),
    "escape": (lambda: "a: \x1b[31m", "SC002"),
    "vertical tab": (lambda: "a: 1\x0bb: 2", "SC002"),
    "no character": (lambda: "a: \uffff", "SC002"),
}


@pytest.fixture
def second() -> Iterator[None]:
    """Fails a test that takes more than a second of the processor, at night."""
    start = time.process_time()
    yield
    assert_took(time.process_time() - start, most=1.0)


@pytest.fixture
def hostile(request: pytest.FixtureRequest) -> str | bytes:
    """The text, made before the clock runs."""
    return HOSTILE[request.param][0]()


@pytest.mark.parametrize(
    ("hostile", "name"), [(name, name) for name in HOSTILE], indirect=["hostile"], ids=list(HOSTILE)
)
def test_hostile_text_is_refused_quickly(hostile: str | bytes, name: str, second: None) -> None:
    sink = Sink()
    assert read_text(hostile, "x.yaml", sink) is None
    found = sink.diagnostics()
    expected = HOSTILE[name][1].split()
    assert found[-1].code in expected or found[0].code in expected, [str(one)[:200] for one in found[:3]]
    assert len(found) <= 1001


HARMLESS: dict[str, Callable[[], str]] = {
    "anchors": lambda: "a: [" + ", ".join(f"&a{i} 1" for i in range(100_000)) + "]",
    "redefinitions": lambda: "a: [" + "&a 1, *a, " * 5000 + "]",
    "a long line": lambda: "a: [" + "1.5, " * 100_000 + "]",
    "a long string": lambda: "a: " + "x y " * 4_000_000,
    "a long number": lambda: "a: 0." + "3" * 10_000_000,
    "lines of a string": lambda: "a:\n" + "  x\n" * 2_000_000,
}


@pytest.mark.parametrize("name", HARMLESS)
def test_large_harmless_text_is_read_quickly(name: str, sink: TakingSink) -> None:
    text = HARMLESS[name]()
    start = time.process_time()
    assert read_text(text, "x.yaml", sink) is not None
    assert_took(time.process_time() - start, most=1.0)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le-bom", "utf-16-be-bom"])
def test_invalid_encodings_are_refused(encoding: str, sink: TakingSink) -> None:
    text = "a: ü\r\nb: [1, '\U0001f600']\r\n"
    if encoding.endswith("-bom"):
        content = ("\ufeff" + text).encode(encoding.removesuffix("-bom"))
    else:
        content = text.encode(encoding)
    document = read_text(content, None, sink)
    assert document is not None
    assert document.data == {"a": "ü", "b": [1, "\U0001f600"]}


def test_invalid_bytes_are_reported_at_their_place() -> None:
    sink = Sink()
    read_text("a: 1\nbü: tür\n".encode().replace(b"t\xc3\xbcr", b"t\xfcr"), "x.yaml", sink)
    (found,) = sink.diagnostics()
    assert (found.line, found.column, found.location.text) == (2, 6, "bü: t\ufffdr")
    assert "0xFC" in found.message


def test_invalid_characters_are_reported_at_their_place() -> None:
    sink = Sink()
    read_text("a: 1\r\nb: '\U0001f600\x07'", "x.yaml", sink)
    (found,) = sink.diagnostics()
    assert (found.line, found.column) == (2, 6)
    assert "U+0007" in found.message
    assert found.hint == 'delete it, or write "\\u0007" in double quotes'


def test_pipes_and_devices_are_refused(tmp_path: Path, second: None) -> None:
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    locked = tmp_path / "locked.yaml"
    locked.write_text("a: 1")
    locked.chmod(0)
    cases: list[Path | str] = [pipe, tmp_path, tmp_path / "missing.yaml", "/dev/zero", "/dev/null", "a\0b", "x" * 5000]
    if os.geteuid() != 0:
        cases.append(locked)
    for case in cases:
        sink = Sink()
        assert read_file(case, sink) is None
        (found,) = sink.diagnostics()
        assert (found.code, found.file, found.line) == ("SC001", str(case), None)


def test_a_file_above_the_limit_is_not_read(tmp_path: Path, second: None) -> None:
    path = tmp_path / "sparse.yaml"
    with path.open("wb") as file:
        file.truncate(2**40)
    sink = Sink()
    assert read_file(path, sink) is None
    assert [found.code for found in sink.diagnostics()] == ["SC601"]


@pytest.mark.parametrize(
    ("text", "limits", "code"),
    [
        ("a: 1", {"text_bytes": 3}, "SC601"),
        ("a: [[1]]", {"depth": 2}, "SC602"),
        ("a: &a [1]\nb: [*a]", {"depth": 2}, "SC602"),
        ("a: &a [1]\nb: *a", {"alias_nodes": 1}, "SC603"),
        ("a: &a {b: 1}\nc: {<<: *a}", {"alias_nodes": 1}, "SC603"),
    ],
)
def test_an_exceeded_limit_is_named_and_can_be_raised(
    text: str, limits: dict[str, int], code: str, sink: TakingSink
) -> None:
    assert read_text(text, None, sink, Limits(**limits)) is None
    found = sink.take(code)
    (name,) = limits
    assert name in found.message
    assert found.hint is not None
    assert f"--limit {name}=" in found.hint
    assert f"limits={{'{name}'" in found.hint
    assert read_text(text, None, sink, Limits(**{name: limits[name] + 1})) is not None


@pytest.mark.parametrize("text", ["a: " + "[" * 1500, "a:\n  " + "- " * 1500])
@pytest.mark.parametrize("depth", [100, 500])
def test_text_deeper_than_libyaml_is_refused(text: str, depth: int) -> None:
    """libyaml 0.2.6 gives up by itself, before it, PyYAML 6.0.1 to 6.0.3, scenecc does: the same code and ceiling."""
    sink = Sink()
    assert read_text(text, None, sink, Limits(depth=depth)) is None
    (found,) = sink.diagnostics()
    assert (found.code, found.line is not None) == ("SC602", True)
    assert "1000" in str(found.hint)


DEEP = 300


@pytest.mark.parametrize(
    "values",
    [
        {"params": "{p: " + "[" * DEEP + "]" * DEEP + "}"},
        {"draws": "{d: " + "{choice: [" * DEEP + "1" + "]}" * DEEP + "}"},
    ],
    ids=["lists", "draws"],
)
@pytest.mark.parametrize("how", ["file", "include", "use"])
def test_values_too_deep_for_later_stages_are_refused(values: dict[str, str], how: str, tmp_path: Path) -> None:
    """With the limit raised, text is read deeper than it is expanded."""
    section, text = next(iter(values.items()))
    deep = tmp_path / "deep.yaml"
    deep.write_text(f"scenecc: 1\n{section}: {text}\nentities: {{a: {{shapes: [{{type: sphere, radius: 1}}]}}}}\n")
    file = tmp_path / "scene.yaml"
    uses = {"include": "include: [deep.yaml]", "use": "entities: {u: {use: deep.yaml}}"}
    file.write_text(f"scenecc: 1\n{uses.get(how, '')}\n")
    (found,) = validate(deep if how == "file" else file, limits={"depth": 1000})
    assert (found.code, "Python's stack" in found.message) == ("SC602", True)


@pytest.mark.parametrize("deep", [999, 50_000])
def test_depth_beyond_the_python_stack_is_refused(deep: int) -> None:
    """The stack may end before the limit of libyaml."""
    sink = Sink()
    assert read_text("a: " + "[" * deep, None, sink, Limits(depth=100_000)) is None
    assert {found.code for found in sink.diagnostics()} == {"SC602"}
