"""The fixture as every test gets it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics import Origin
from scenecc.diagnostics.codes import CODES

if TYPE_CHECKING:
    from plugins.diagnostics import TakingSink

ERROR = next(row.code for row in CODES.values() if row.severity == "error")


def test_what_is_taken_is_expected(sink: TakingSink) -> None:
    sink.report(ERROR, "one", Origin("s.yaml", ("a",)))
    sink.report(ERROR, "two", Origin("s.yaml", ("b",)))
    assert sink.take(ERROR, path="b").message == "two"
    assert [d.message for d in sink.left()] == ["one"]
    assert sink.take(ERROR).message == "one"
    with pytest.raises(AssertionError, match="among: nothing"):
        sink.take(ERROR)
