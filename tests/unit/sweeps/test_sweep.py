"""A sweep's table: what is in it, and that it is the same to the byte however the work was done."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples

import scenecc
from scenecc.drawn_values import DrawnValues
from scenecc.sweeps import folder as folders
from scenecc.sweeps import sweep as sweeps
from scenecc.sweeps.units import do_unit

SCENE = """\
scenecc: 1
num_scenes: 3
params: {mass: 1.0}
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube:
    pose: [{uniform: [-0.1, 0.1]}, 0, "${0.05 if scene == 2 else 0.1}"]
    mass: "${mass}"
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1], color: {choice: ["#ff0000", "#00ff00"]}}]
"""


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(SCENE)
    return Path("scene.yaml")


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.sweeps.units.SCENES_OF_A_UNIT", 2)
    monkeypatch.setattr("scenecc.sweeps.folder._ROWS_OF_A_GROUP", 7)


def run(scene: Path, output: str, **changes: Any) -> scenecc.Sweep:
    asked: dict[str, Any] = {"seeds": range(2, 7), "settle": 0.05, **changes}
    return scenecc.sweep(scene, output=output, **asked)


def table(result: scenecc.Sweep) -> bytes:
    assert result.table is not None
    return result.table.read_bytes()


def log(folder: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in Path(folder, "log.jsonl").read_text().splitlines()]


def rows(result: scenecc.Sweep) -> list[dict[str, Any]]:
    return pq.read_table(result.table).to_pylist()


def test_a_row_describes_its_scene(scene: Path) -> None:
    result = run(scene, "out", params=[{"mass": 2.0}, {"mass": 1.0}])
    found = rows(result)
    assert result.units == result.done == 2 * 5 * 2
    keys = [(row["parameters"], row["seed"], row["scene"]) for row in found]
    masses = ('{"mass": 1.0}', '{"mass": 2.0}')
    assert keys == [(mass, seed, index) for mass in masses for seed in range(2, 7) for index in range(3)]
    with scenecc.load_scene(scene, seed=4, render=False) as batch:
        poses = batch.entities["cube"].pose
    for row in found[6:9]:
        assert row["file"] == "scene.yaml"
        assert [one["name"] for one in row["poses"]] == ["floor", "cube"]
        assert np.array_equal(np.array(row["poses"][1]["pose"], np.float32), poses[row["scene"]])
        draws = json.loads(row["draws"])
        assert np.allclose(draws["cube.pose"], poses[row["scene"]])
        assert draws["cube.shapes[0].material.base_color"] in ([1, 0, 0, 1], [0, 1, 0, 1])
        assert len(draws) == 2


def test_draws_have_the_names_of_the_file() -> None:
    wide = {"uniform": [0.1, 0.2]}
    ball: dict[str, Any] = {"type": "sphere", "radius": wide, "name": "knob"}
    slide = {"name": "slide", "type": "prismatic", "axis": "y"}
    follow = {**slide, "name": "follow", "mimic": {"joint": "slide", "multiplier": wide}}
    left = {"name": "left", "joint": slide, "shapes": [{**ball, "radius": 0.1}]}
    right = {"name": "right", "joint": follow, "shapes": [ball]}
    variants = [{"shapes": [{"type": "box", "half_size": [wide, 0.1, 0.1]}]}, {"shapes": [ball]}]
    entities = {"toy": {"variants": variants, "pick": 0}, "arm": {"root": {"name": "base", "children": [left, right]}}}
    plan = scenecc.open_scene({"scenecc": 1, "entities": entities}).plan
    assert set(DrawnValues(plan).read([0])) == {
        "toy.variants[0].shapes[0].half_size",
        "toy.variants[1].shapes[0].radius",
        "arm/right.shapes[0].radius",
        "arm.mimics.follow.multiplier",
    }


def test_findings_of_a_sweep_are_those_of_check(scene: Path) -> None:
    found = rows(run(scene, "out", seeds=[3]))
    codes = [[one["code"] for one in row["findings"]] for row in found]
    assert codes[0] == codes[1] == []
    overlap = next(one for one in found[2]["findings"] if one["code"] == "SC850")
    (checked,) = [one for one in scenecc.check_scene(scene, seed=3, settle=0) if one.code == "SC850"]
    for name in ("message", "file", "line", "column", "path", "hint", "severity"):
        assert overlap[name] == getattr(checked, name)
    assert "--seed 3 --scene 2" in overlap["hint"]


def test_a_failed_scene_does_not_affect_others(scene: Path) -> None:
    fast = '    linear_velocity: ["${2e6 if scene == 0 else 0}", 0, 0]\n'
    scene.write_text(SCENE.replace("    mass:", f"{fast}    mass:"))
    found = rows(run(scene, "out", seeds=[0]))
    codes = [{one["code"] for one in row["findings"]} for row in found]
    assert [index for index in range(3) if "SC820" in codes[index]] == [0]
    assert all(row["poses"] for row in found)


def test_a_bad_file_stops_the_sweep_before_it_begins(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("bad.yaml").write_text(SCENE.replace("half_size", "half_sizes"))
    compiled: list[object] = []
    compile_source = sweeps.compile_source
    monkeypatch.setattr(sweeps, "compile_source", lambda *a, **k: compiled.append(a[0]) or compile_source(*a, **k))
    with pytest.raises(scenecc.SceneError) as raised:
        scenecc.sweep([scene, "bad.yaml"], output="out", seeds=range(8))
    assert [one.code for one in raised.value.diagnostics] == ["SC101"]
    assert compiled.count("bad.yaml") == 1
    assert not Path("out").exists()


def test_a_draw_that_fails_for_one_seed_is_a_row(scene: Path) -> None:
    text = SCENE.replace("num_scenes: 3", "num_scenes: 1").replace("${mass}", "${1 + sqrt(chance - 0.5)}")
    scene.write_text(text.replace("entities:", "draws: {chance: {uniform: [0, 1]}}\nentities:"))
    found = rows(run(scene, "out", seeds=range(8)))
    failed = [row for row in found if row["scene"] is None]
    assert 0 < len(failed) < 8
    assert all(row["findings"] and row["draws"] is None for row in failed)


def test_the_table_is_the_same_however_it_was_made(scene: Path) -> None:
    whole = table(run(scene, "alone"))
    assert table(run(scene, "several", jobs=3)) == whole
    parts = [run(scene, "parts", shard=(part, 3)) for part in (3, 1)]
    assert [(part.table, part.done) for part in parts] == [(None, 3), (None, 7)]
    assert table(run(scene, "parts")) == whole
    assert table([run(scene, "parts2", shard=(part, 2)) for part in (2, 1)][-1]) == whole
    assert sorted(path.name for path in Path("parts2").iterdir()) == [
        "log-1-of-2.jsonl", "log-2-of-2.jsonl", "parts", "sweep.json", "table.parquet",
    ]  # fmt: skip


EXPECTS = """\
expect:
  holds: [{after: 0.01, that: "${position('cube')[0] < 0}"}]
"""


@settings(max_examples=examples(5), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), parts=st.integers(1, 4), expects=st.booleans())
def test_executors_do_not_change_the_table(scene: Path, data: st.DataObject, parts: int, *, expects: bool) -> None:
    scene.write_text(SCENE + EXPECTS * expects)
    with TemporaryDirectory() as folder:
        alone = run(scene, f"{folder}/alone")
        assert (("SC861", "error") in alone.counts) == expects
        for part in data.draw(st.permutations(range(1, parts + 1))):
            left = run(scene, f"{folder}/parts", shard=(part, parts), jobs=data.draw(st.integers(1, 2)))
        assert table(left) == table(alone)


def test_an_interrupted_sweep_resumes(scene: Path) -> None:
    class EndedError(Exception):
        pass

    def end(done: int, total: int) -> None:
        assert total == 10
        if done == 4:
            raise EndedError

    with pytest.raises(EndedError):
        run(scene, "ended", progress=end)
    results = Path("ended/parts/results.txt")
    assert len(results.read_bytes().splitlines()) == 4
    with results.open("ab") as file:
        file.write(results.read_bytes().splitlines()[0][:-9])  # as the process left its last line
    told: list[tuple[int, int]] = []
    ended = run(scene, "ended", progress=lambda done, total: told.append((done, total)))
    assert told == [(done, 10) for done in range(5, 11)]
    assert table(ended) == table(run(scene, "alone"))
    assert [line["attempt"] for line in log("ended") if line["seconds"] > 0] == [1] * 10
    assert run(scene, "ended", progress=lambda *_: pytest.fail("nothing is left to do")) == ended


def test_a_crashed_unit_is_retried_and_then_reported(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run(scene, "alone")

    def dies(work: Any, unit: Any, *, always: bool) -> Any:
        flag = Path(f"died-{unit.seed}-{unit.first}")
        if unit.seed % 2 and (always or not flag.exists()):
            flag.touch()
            os.kill(os.getpid(), 9)
        return do_unit(work, unit)

    monkeypatch.setattr(sweeps, "do_unit", lambda work, unit: dies(work, unit, always=False))
    assert table(run(scene, "once", jobs=2)) == table(whole)
    assert [line["died"] for line in log("once") if "died" in line] == ["signal 9"] * 4
    assert {line["attempt"] for line in log("once") if line["seed"] == 3 and "died" not in line} == {2}

    monkeypatch.setattr(sweeps, "do_unit", lambda work, unit: dies(work, unit, always=True))
    result = run(scene, "always", jobs=2)
    assert result.counts["SC822", "error"] == 4
    found = rows(result)
    assert [row["findings"][0]["code"] for row in found if row["scene"] is None] == ["SC822"] * 4
    assert [row for row in found if row["seed"] % 2 == 0] == [row for row in rows(whole) if row["seed"] % 2 == 0]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"seeds": range(9)}, 'seeds "2:7", not "0:9"'),
        ({"do": ["state"]}, 'do ["check", "state"], not ["state"]'),
        ({"params": {"mass": 3}}, "parameters"),
        ({"num_scenes": 1}, "num_scenes 3, not 1"),
    ],
)
def test_the_folder_of_another_sweep_is_refused(scene: Path, changes: dict[str, Any], told: str) -> None:
    run(scene, "out", shard=(1, 10))
    with pytest.raises(scenecc.SceneError, match="SC940") as raised:
        run(scene, "out", **changes)
    assert told in raised.value.diagnostics[0].message


def test_a_changed_file_or_version_is_reported(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene.write_text(SCENE + "include: [part.txt]\n")
    Path("part.txt").write_text("scenecc: 1\n")
    run(scene, "out", shard=(1, 10))
    Path("part.txt").write_text("scenecc: 1\n# other\n")
    with pytest.raises(scenecc.SceneError, match=r"`part.txt` has changed since it began"):
        run(scene, "out")
    Path("part.txt").write_text("scenecc: 1\n")
    monkeypatch.setattr(folders, "VERSION", "9.9")
    with pytest.raises(scenecc.SceneError, match=r'scenecc ".*", not "9.9"'):
        run(scene, "out")


def test_a_file_changed_during_a_sweep_stops_it(scene: Path) -> None:
    def change(done: int, total: int) -> None:
        scene.write_text(SCENE + "# other\n")

    with pytest.raises(scenecc.SceneError, match="SC829") as raised:
        run(scene, "out", progress=change)
    assert "scene.yaml` has different content" in raised.value.diagnostics[0].message
    scene.write_text(SCENE)
    assert run(scene, "out").table is not None


def test_two_processes_cannot_run_the_same_part(scene: Path) -> None:
    def again(done: int, total: int) -> None:
        with pytest.raises(scenecc.SceneError, match="another process"):
            run(scene, "out")

    run(scene, "out", progress=again)


def test_a_missing_package_of_sweeps_gives_an_install_hint(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(scenecc.SceneError, match=r"\[ray\]"):
        run(scene, "out", ray=True)
    monkeypatch.setattr(sweeps, "find_spec", lambda name: None)
    with pytest.raises(scenecc.SceneError, match=r"\[sweep\]"):
        run(scene, "out")


@pytest.mark.parametrize(
    "wrong",
    [{"do": []}, {"do": ["view"]}, {"seeds": []}, {"seeds": [-1]}, {"seeds": [2**64]}, {"shard": (3, 2)}, {"jobs": 0},
     {"settle": -1.0}, {"params": []}],
)  # fmt: skip
def test_sweep_refuses_arguments_out_of_range(scene: Path, wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError):  # noqa: PT011
        run(scene, "out", **wrong)
    assert not Path("out").exists()


@pytest.mark.render
def test_a_swept_picture_equals_that_of_render(scene: Path) -> None:
    # In a process that has no renderer yet: `sweep` forks, and a renderer's threads are not in a fork.
    script = (
        "import scenecc; scenecc.sweep('scene.yaml', output='out', do=['render', 'state'], seeds=[5], size=(64, 48))"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    found = pq.read_table("out/table.parquet").to_pylist()
    assert found
    for row in found:
        expected = scenecc.render_scene(scene, seed=5, scenes=str(row["scene"]), size=(64, 48)).png()
        assert (Path("out") / row["picture"]).read_bytes() == expected
