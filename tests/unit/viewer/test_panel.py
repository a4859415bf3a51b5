"""Texts of a page: nothing of a scene becomes markup."""

from __future__ import annotations

from scenecc.inspect import Fact, Item
from scenecc.viewer import panel

EVIL = "<img src=x onerror=alert(1)>&\"'"


def test_whatever_a_scene_says_is_escaped() -> None:
    inner = Item(EVIL, EVIL, (Fact(EVIL, EVIL, EVIL),))
    item = Item(EVIL, EVIL, (Fact("mass", 1, EVIL),), ((EVIL, (inner,)), (EVIL, inner)))
    for text in (panel.facts(item), panel.line(EVIL), panel.message(EVIL, color="red")):
        assert "<img" not in text
        assert "&lt;img" in text


def test_facts_are_introduced_and_what_has_no_words_is_left_out() -> None:
    item = Item("cube", "dynamic", (Fact("mass", 1.0, "1 kg"), Fact("path", "/x", "")), (("joint", Item("", "fixed")),))
    text = panel.facts(item)
    assert ">mass</span> 1 kg" in text
    assert "path" not in text
    assert "<b>joint</b>" in text, "what has no name is called as its group"
