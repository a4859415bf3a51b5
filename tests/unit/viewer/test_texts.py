"""Texts of a page: nothing of a scene becomes markup."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.diagnostic import Location
from scenecc.inspect import Fact, Item
from scenecc.viewer import texts

EVIL = "<img src=x onerror=alert(1)>&\"'"


def test_text_of_a_scene_is_escaped_in_html() -> None:
    inner = Item(EVIL, EVIL, (Fact(EVIL, EVIL, EVIL),))
    item = Item(EVIL, EVIL, (Fact("mass", 1, EVIL),), ((EVIL, (inner,)), (EVIL, inner)))
    for text in (texts.facts(item), texts.line(EVIL), texts.message(EVIL, color="red")):
        assert "<img" not in text
        assert "&lt;img" in text


def test_places_of_errors_are_links_only_on_this_machine() -> None:
    text = "/a b/c.yaml:5:63: error SC104: <b>\n  --> x:1:2: error\n5 | c\n"
    assert texts.message(text, color="red", links=True).count("<a ") == 1
    linked = texts.message(text, color="red", links=True)
    assert '<a href="vscode://file/a%20b/c.yaml:5:63">/a b/c.yaml:5:63</a>: error SC104: &lt;b&gt;\n' in linked
    assert "<a" not in texts.message(text, color="red")


def test_draws_of_a_scene_are_a_table() -> None:
    values = {EVIL: np.array([0.25]), "pose": np.array([[1, 2, 3.5]]), "none": np.array([np.nan])}
    text = texts.draws("Scene 0", values)
    assert "<td>0.25</td>" in text
    assert "<td>[1, 2, 3.5]</td>" in text
    assert "none" not in text
    assert "<img" not in text
    many = texts.draws("", {f"draw_{number}": np.array([1.0]) for number in range(5000)})
    assert many.count("<tr>") == 200
    assert "and 4800 more" in many


def test_facts_have_labels_and_empty_ones_are_left_out() -> None:
    item = Item("cube", "dynamic", (Fact("mass", 1.0, "1 kg"), Fact("path", "/x", "")), (("joint", Item("", "fixed")),))
    text = texts.facts(item)
    assert ">mass</span> 1 kg" in text
    assert "path" not in text
    assert "<b>joint</b>" in text, "what has no name is called as its group"


def test_findings_link_to_lines_only_on_this_machine(tmp_path: Path) -> None:
    place = Location(str(tmp_path / "a scene#1.yaml"), 7, 3)
    found = Diagnostic("SC850", "error", EVIL, place, hint=EVIL)
    linked = texts.findings([found], links=True)
    assert f'href="vscode://file{tmp_path}/a%20scene%231.yaml:7:3"' in linked
    plain = texts.findings([found], links=False)
    assert "a scene#1.yaml:7" in plain
    assert str(tmp_path) not in plain
    assert "<img" not in linked + plain
