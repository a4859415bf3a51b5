"""The sink, and the fixture that fails a test which leaves a diagnostic in it.

The fixture as every test gets it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics import Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import At, Location, Origin, dotted

if TYPE_CHECKING:
    from plugins.diagnostics import TakingSink


TESTS = Path(__file__).parents[2]
ERROR = next(row.code for row in CODES.values() if row.severity == "error")


def locate(origin: Origin, at: At) -> Location:
    """Nodes on lines by their first key, keys left of values."""
    line = {"b": 2, "a": 1}.get(str(origin.path[0]) if origin.path else "")
    return Location(origin.file, line, {"key": 1, "value": 5}[at] if line else None)


def test_findings_are_sorted_by_place() -> None:
    sink = Sink(locate)
    sink.report(ERROR, "last", Origin("z.yaml", ("a",)))
    sink.report(ERROR, "third", Origin("s.yaml", ("b",)))
    sink.report(ERROR, "second", Origin("s.yaml", ("a",)))
    sink.report(ERROR, "first", Origin("s.yaml", ("a",)), at="key")
    assert [d.message for d in sink.diagnostics()] == ["first", "second", "third", "last"]


def test_equal_findings_are_merged() -> None:
    sink = Sink()
    for _ in range(2):
        sink.report(ERROR, "wrong", Origin("s.yaml", ("a",)))
    sink.report(ERROR, "wrong", Origin("s.yaml", ("b",)))
    assert len(sink.diagnostics()) == 2


def test_only_errors_make_a_sink_fail() -> None:
    sink = Sink()
    assert not sink.failed
    for row in CODES.values():
        if row.severity != "error":
            sink.report(row.code, "well", Origin(None))
    assert not sink.failed
    sink.report(ERROR, "wrong", Origin(None))
    assert sink.failed


def test_a_document_that_was_used_names_its_users() -> None:
    top = Origin("top.yaml", ("a",))
    middle = Origin("middle.yaml", ("b",), parent=top)
    sink = Sink(locate)
    sink.report(ERROR, "wrong", Origin("leaf.yaml", ("a",), parent=middle), related=[("first here", top, "key")])
    (found,) = sink.diagnostics()
    places = [(r.message, r.location.file, r.location.line, r.location.column) for r in found.related]
    assert places == [
        ("first here", "top.yaml", 1, 1),
        ("used from here", "middle.yaml", 2, 5),
        ("used from here", "top.yaml", 1, 5),
    ]


def test_dotted_quotes_unusual_keys() -> None:
    assert dotted(("entities", "cube", "shapes", 0, "half_size", 1)) == "entities.cube.shapes[0].half_size[1]"
    assert dotted(("entities", "a.b", 'say "x"', "")) == 'entities["a.b"]["say \\"x\\""][""]'
    assert dotted(()) == ""


def run_tests(folder: Path, text: str) -> str:
    """What pytest says of a file of tests that uses the fixture."""
    (folder / "test_it.py").write_text(text, encoding="utf-8")
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "plugins.diagnostics", "-p", "no:cacheprovider", "test_it.py"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(TESTS)},
        capture_output=True,
        text=True,
        check=False,
    )
    return run.stdout + run.stderr


def test_the_sink_fixture_fails_a_test_that_leaves_a_diagnostic(tmp_path: Path) -> None:
    out = run_tests(
        tmp_path,
        f"""
from scenecc.diagnostics import Origin

def test_takes_all(sink):
    sink.report({ERROR!r}, "wrong", Origin("s.yaml", ("a",)))
    assert sink.take({ERROR!r}, path="a").message == "wrong"

def test_leaves_one(sink):
    sink.report({ERROR!r}, "unexpected thing", Origin("s.yaml", ("a",)))

def test_takes_one_of_two(sink):
    for item in (1, 2):
        sink.report({ERROR!r}, "twice", Origin("s.yaml", ("a", item)))
    sink.take({ERROR!r})

def test_takes_what_is_not_there(sink):
    sink.take({ERROR!r})
""",
    )
    assert f"reported and never taken:\n  s.yaml: error {ERROR}: unexpected thing (a)\n" in out
    assert f"reported and never taken:\n  s.yaml: error {ERROR}: twice (a[2])\n" in out
    assert f"no {ERROR} among: nothing" in out
    assert "1 failed, 3 passed, 2 errors" in out


def test_findings_beyond_the_maximum_are_announced() -> None:
    warning = next(row.code for row in CODES.values() if row.severity == "warning")
    for code, last in ((ERROR, "SC016"), (warning, warning)):
        sink = Sink()
        for index in range(100_000):
            sink.report(code, "wrong", Origin("s.yaml", ("a", index)))
        found = sink.diagnostics()
        assert [each.code for each in found] == [code] * 1000 + [last]
        assert found[-1].path == "a[1000]"
        assert "stopped after 1000" in found[-1].message
        assert sink.failed is (code == ERROR)


def test_many_warnings_do_not_hide_errors() -> None:
    warning = next(row.code for row in CODES.values() if row.severity == "warning")
    sink = Sink()
    for index in range(2000):
        sink.report(warning, "odd", Origin("s.yaml", ("a", index)))
    sink.report(ERROR, "wrong", Origin("s.yaml", ("b",)))
    assert sink.failed
    assert ERROR in {found.code for found in sink.diagnostics()}


def test_one_copy_is_reported_and_the_others_are_counted() -> None:
    sink = Sink()
    for i in range(5):
        sink.report(ERROR, f"wrong by {i}", Origin("s.yaml", ("a",), copy=f"i={i}"))
        sink.report(ERROR, f"twice wrong by {i}", Origin("s.yaml", ("a",), copy=f"i={i}"))
    sink.report(ERROR, "wrong", Origin("s.yaml", ("b",), copy="i=4"))
    assert [found.message for found in sink.diagnostics()] == [
        "wrong by 0 (i=0; and in 4 other copies)",
        "twice wrong by 0 (i=0; and in 4 other copies)",
        "wrong (i=4)",
    ]


def test_the_chain_of_uses_is_shown_for_the_first_use() -> None:
    sink = Sink()
    for name in ("one", "two"):
        inner = Origin("mid.yaml", ("entities", "x", "use"), parent=Origin("top.yaml", ("entities", name, "use")))
        sink.report(ERROR, "wrong", Origin("leaf.yaml", ("a",), parent=inner))
    (found,) = sink.diagnostics()
    assert found.message == "wrong (and in 1 other use)"
    assert [(related.message, related.location.file) for related in found.related] == [
        ("used from here", "mid.yaml"),
        ("used from here", "top.yaml"),
    ]


def test_origins_are_traced_when_they_are_reported() -> None:
    sink = Sink()
    written = Origin("s.yaml", ("as", "written"), copy="i=1")
    sink.report(ERROR, "before", Origin("s.yaml", ("a",)))
    sink.trace = lambda origin: written
    sink.report(ERROR, "after", Origin("s.yaml", ("a",)), related=[("other", Origin("s.yaml", ("b",)), "value")])
    before, after = sink.diagnostics()
    assert (before.path, after.path) == ("a", "as.written")
    assert after.related[0].message == "other (i=1)"


def test_take_removes_an_expected_diagnostic(sink: TakingSink) -> None:
    sink.report(ERROR, "one", Origin("s.yaml", ("a",)))
    sink.report(ERROR, "two", Origin("s.yaml", ("b",)))
    assert sink.take(ERROR, path="b").message == "two"
    assert [d.message for d in sink.left()] == ["one"]
    assert sink.take(ERROR).message == "one"
    with pytest.raises(AssertionError, match="among: nothing"):
        sink.take(ERROR)
