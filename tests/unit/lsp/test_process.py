"""The process that compiles, and its client."""

import asyncio
from pathlib import Path

import pytest

from scenecc import validate
from scenecc.lsp import worker
from scenecc.lsp.process import AnalysisProcess, FaultError, WorkerStopped
from scenecc.lsp.server import SceneServer
from scenecc.options import Options


def checked(path: Path, text: str) -> worker.CheckAnswer:
    answer = worker.answer(worker.CheckRequest(worker.OpenScene(path, {path: text}, Options())))
    assert isinstance(answer, worker.CheckAnswer)
    return answer


SPHERE = "{shapes: [{type: sphere, radius: 1}]}"
SCENE = f"scenecc: 1\nentities: {{a: {SPHERE}}}\n"


def test_the_worker_reports_bugs_and_restarts_after_a_crash(tmp_path):
    path = tmp_path / "a.yaml"
    good = worker.CheckRequest(worker.OpenScene(path, {path: SCENE}, Options()))
    many = "scenecc: 1\nentities:\n" + "".join(f"  b{i}: {SPHERE}\n" for i in range(9000))
    slow = worker.CheckRequest(worker.OpenScene(path, {path: many}, Options()))
    without_text = worker.CheckRequest(worker.OpenScene(path, {}, Options()))

    async def session():
        process = AnalysisProcess()
        with pytest.raises(FaultError, match="KeyError"):
            await process.ask(without_text)
        first = await process.ask(good)
        waiting = asyncio.create_task(process.ask(good))
        for _ in range(3):
            await asyncio.sleep(0)
        process.stop_older(60)
        assert (await waiting).diagnostics == []
        waiting = asyncio.create_task(process.ask(slow))
        for _ in range(3):
            await asyncio.sleep(0)
        process.stop_older(0)
        with pytest.raises(WorkerStopped) as end:
            await waiting
        again = await process.ask(good)
        waiting = asyncio.create_task(process.ask(good))
        for _ in range(3):
            await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        last = await process.ask(good)
        process.stop()
        await asyncio.sleep(0.1)
        return first, again, last, end.value.crashed

    *answers, crashed = asyncio.run(session())
    assert [one.diagnostics for one in answers] == [[], [], []]
    assert [*answers[0].objects] == ["a"]
    assert not crashed


def test_findings_of_a_text_that_changes_while_they_are_filtered_are_dropped(tmp_path, monkeypatch):
    path = tmp_path / "a.yaml"

    def type_more(found, scene):
        server.scenes.put(path, f"{SCENE}# more\n")
        return found

    async def ask(request):
        return worker.CheckAnswer([], {str(path): path}, {})

    server = SceneServer(Options(), type_more)
    server.scenes.put(path, SCENE)
    monkeypatch.setattr(server.checker, "ask", ask)
    asyncio.run(server._check(path))
    assert not server.scenes.projects[path].is_current


def test_a_check_result_names_files_and_places(tmp_path):
    path, part = tmp_path / "a.yaml", tmp_path / "part.yaml"
    part.write_text(SCENE)
    text = "scenecc: 1\nentities:\n  b: {use: part.yaml, repeat: {i: [1, 2]}}\n"
    answer = checked(path, text)
    assert answer.files == {str(path): path, str(part): part}
    assert answer.objects is not None
    assert answer.objects["b_0/a"].place == worker.SourcePlace(part, ("entities", "a"))
    instance = answer.objects["b_1"].place
    assert instance is not None
    assert (instance.path, instance.is_copy) == (("entities", "b"), True)


BAD = Path(__file__).parents[2] / "scenes" / "bad"


# An editor opens a file as text or not at all.
NOT_TEXT = {"binary", "not_utf8", "utf16"}
TEXTS = [scene for scene in sorted(BAD.glob("*/*.yaml")) if scene.stem not in NOT_TEXT]


@pytest.mark.parametrize("scene", TEXTS[::12], ids=lambda scene: scene.stem)
def test_findings_of_the_language_server_are_those_of_validate(scene):
    assert checked(scene, scene.read_bytes().decode()).diagnostics == validate(scene)


def test_comments_silence_findings(tmp_path):
    path = tmp_path / "a.yaml"
    text = "scenecc: 1\nmaterials:\n  oak: {}  # scenecc: ignore SC313\n" + SCENE.partition("\n")[2]
    assert checked(path, text).diagnostics == []
    text = text.replace("  # scenecc: ignore SC313", "")
    (found,) = checked(path, text).diagnostics
    assert found.code == "SC313"


def test_an_entity_is_described_as_by_inspect(tmp_path):
    path = tmp_path / "a.yaml"
    answer = worker.answer(worker.Describe(worker.OpenScene(path, {path: SCENE}, Options()), "a"))
    assert isinstance(answer, worker.EntityFacts)
    assert answer.kind == "dynamic"
    assert ("mass", "4188.8 kg") in answer.facts
    assert ("size", "2 × 2 × 2 m") in answer.facts
    assert worker.answer(worker.Describe(worker.OpenScene(path, {path: SCENE}, Options()), "nobody")) is None
