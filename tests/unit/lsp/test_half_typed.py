"""Scenes that end anywhere: every question has an answer, in a bounded time."""

from contextlib import suppress
from pathlib import Path
from random import Random
from time import perf_counter

import pytest
from plugins.editor import Editor
from plugins.nightly import assert_took

from scenecc.lsp import worker
from scenecc.lsp.completion import completions
from scenecc.lsp.edits import RefusedError, corrections, rename
from scenecc.lsp.hover import hover_at
from scenecc.lsp.language import load_language
from scenecc.lsp.names import definition_of
from scenecc.lsp.references import mentions
from scenecc.lsp.symbols import symbols_of
from scenecc.options import Options

SCENES = sorted((Path(__file__).parents[3] / "scenes").glob("*.yaml"))[:20]
CUTS = 40


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.stem)
def test_a_scene_truncated_anywhere_is_analysed(scene):
    load_language()
    editor = Editor(scene.parent, {})
    text, random = scene.read_text(), Random(scene.stem)
    for _ in range(CUTS):
        cut = text[: random.randrange(len(text))]
        editor.workspace.put(scene, cut)
        before = perf_counter()
        view = editor.view
        ask_everything(view, scene, random)
        assert_took(perf_counter() - before, most=5)


def ask_everything(view, scene, random):
    shown = view.texts[scene]
    line = len(shown.lines) - 1
    for place in ((line, len(shown.lines[line])), (random.randrange(line + 1), random.randrange(80))):
        completions(view, scene, *place)
        hover_at(view, scene, *place)
        with suppress(RefusedError):
            rename(view, scene, *place, "another")
    symbols_of(shown)
    for leaf in shown.leaves:
        for mention in mentions(view, shown, leaf):
            definition_of(view, shown, leaf, mention)


@pytest.mark.parametrize("scene", SCENES[::5], ids=lambda scene: scene.stem)
def test_a_truncated_scene_reports_only_its_syntax_error(scene):
    """The mistake of a text that is no YAML is told alone; corrections are looked for in whatever is found."""
    text, random = scene.read_text(), Random(scene.stem)
    editor = Editor(scene.parent, {})
    for _ in range(CUTS // 4):
        cut = text[: random.randrange(len(text))]
        answer = worker.answer(worker.CheckRequest(worker.OpenScene(scene, {scene: cut}, Options())))
        assert isinstance(answer, worker.CheckAnswer)
        editor.workspace.put(scene, cut)
        shown = editor.view.texts[scene]
        if not shown.tree.is_whole:
            assert len(answer.diagnostics) == 1
        for found in answer.diagnostics:
            list(corrections(shown, found))
