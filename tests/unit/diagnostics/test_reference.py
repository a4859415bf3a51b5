"""`scenecc explain`, and the pages that are generated from the same table."""

from __future__ import annotations

import unicodedata
from pathlib import Path

import pytest
from plugins.diagnostics_pages import main, pages

from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.formats.style import visible
from scenecc.diagnostics.reference import explain_code, nearest_codes

ROOT = Path(__file__).parents[3]


def test_explain_describes_every_code() -> None:
    for code, row in CODES.items():
        text = explain_code(code)
        assert text is not None, code
        assert text.startswith(f"{code}: {row.title}\n")
        assert row.severity in text, code
        assert " ".join(row.cause.split()) in " ".join(text.split()), code
        assert all(visible(line.replace("\t", "")) in text.replace("\t", "") for line in row.example.split("\n")), code
        assert not [c for c in text if c not in "\n\t" and unicodedata.category(c) in {"Cc", "Cf", "Cs"}], code
        assert " ".join(row.cure.split()) in " ".join(text.split()), code
        assert text.endswith("\n"), code


def test_codes_are_found_in_any_notation() -> None:
    code = next(iter(CODES))
    assert explain_code(code.lower()) == explain_code(code[2:]) == explain_code(f" {code} ") == explain_code(code)


def test_an_unknown_code_has_no_explanation() -> None:
    assert explain_code("SC000000") is None
    assert explain_code("") is None


def test_the_nearest_codes_come_first() -> None:
    code = next(iter(CODES))
    assert nearest_codes(code[:-1])
    assert code in nearest_codes(code + "0")
    assert nearest_codes(code.lower() + "x")[0] == code
    assert set(nearest_codes("SC999", count=2)) <= set(CODES)
    assert len(nearest_codes("SC999", count=2)) <= 2
    assert nearest_codes("banana") == nearest_codes("SC9999") == []


def test_the_committed_pages_match_the_table() -> None:
    folder = ROOT / "docs/reference/diagnostics"
    committed = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
    assert committed == pages(), "run `python tests/plugins/diagnostics_pages.py docs/reference/diagnostics`"


def test_each_code_is_once_in_the_table_and_once_as_an_entry() -> None:
    for code in CODES:
        text = pages()[f"sc{code[2]}.md"]
        assert text.count(f"\n## {code}\n") == 1
        assert text.count(f"\n| [{code}](#{code.lower()}) |") == 1


def test_the_index_links_to_every_page() -> None:
    index, *others = pages().items()
    assert index[0] == "index.md"
    assert all(f"]({name})" in index[1] for name, _ in others)


def test_the_generator_writes_the_pages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path / "codes")]) == 0
    assert {path.name: path.read_text(encoding="utf-8") for path in (tmp_path / "codes").iterdir()} == pages()
    assert main([]) == main(["a", "b"]) == 2
    assert "usage" in capsys.readouterr().err
