"""The table of codes against itself and against the code that reports."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

import scenecc
from scenecc.diagnostics.codes import BANDS, CODES, Code

PACKAGE = Path(scenecc.__file__).parent
TABLE = PACKAGE / "diagnostics" / "codes"
FILES = {
    "reading": "0",
    "language": "1",
    "expansion": "2",
    "names": "3",
    "assets": "4",
    "robots": "4",
    "mjcf": "4",
    "physics": "5",
    "constraints": "5",
    "pictures": "5",
    "limits": "6",
    "plan": "7",
    "export": "7",
    "export_meshes": "7",
    "engine": "8",
    "export_extra": "8",
    "viewing": "8",
    "usage": "9",
}
"""Which band a file of rows holds."""


def banded_rows() -> list[tuple[str, Code]]:
    return [
        (band, row) for name, band in FILES.items() for row in import_module(f"scenecc.diagnostics.codes.{name}").ROWS
    ]


def reported() -> dict[str, set[str]]:
    """Every code that is written as a literal outside of the table, and the files that write it."""
    found: dict[str, set[str]] = {}
    for file in PACKAGE.rglob("*.py"):
        if TABLE in file.parents:
            continue
        for code in re.findall(r"""["'](SC\d{3})["']""", file.read_text(encoding="utf-8")):
            found.setdefault(code, set()).add(str(file.relative_to(PACKAGE)))
    return found


@pytest.mark.parametrize(("band", "row"), banded_rows(), ids=lambda value: getattr(value, "code", None))
def test_a_row_is_well_formed(band: str, row: Code) -> None:
    assert re.fullmatch(r"SC\d{3}", row.code)
    assert row.code[2] == band, f"{row.code} belongs to another file"
    assert row.severity in {"error", "warning", "note"}
    assert 0 < len(row.title) <= 80
    assert "\n" not in row.title
    assert not row.title.endswith(".")
    assert len(row.cause) > 20, "say why"
    assert row.example.strip()
    assert row.cure.strip()


@pytest.mark.parametrize(("band", "row"), banded_rows(), ids=lambda value: getattr(value, "code", None))
def test_an_example_is_a_scene_or_a_command(band: str, row: Code) -> None:
    assert "\t" not in row.example.replace("\\t", "") or band == "0", "a tab is YAML's own mistake"
    if not row.example.startswith("$ "):
        assert "scenecc" in row.example or band in {"0", "1"}, "a scene file says `scenecc: 1`"


def test_codes_are_unique() -> None:
    codes = [row.code for _, row in banded_rows()]
    assert len(codes) == len(set(codes))
    assert set(codes) == set(CODES)


def test_every_file_of_rows_is_in_the_table() -> None:
    files = {file.stem for file in TABLE.glob("*.py")} - {"__init__", "row"}
    assert files == set(FILES)
    assert set(FILES.values()) == set(BANDS)


def test_every_code_that_is_reported_has_a_row() -> None:
    unknown = {code: files for code, files in reported().items() if code not in CODES}
    assert not unknown


def test_every_row_is_reported_somewhere() -> None:
    dead = sorted(set(CODES) - set(reported()))
    assert not dead
