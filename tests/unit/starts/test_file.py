"""Files of starts: what is refused, with which words."""

from __future__ import annotations

import json
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

import scenecc
from scenecc.starts.file import InvalidStartsError, StartRecord, StartsFile, read_starts, short_floats, starts_files
from scenecc.starts.fingerprint import other_versions, scene_differences

POSE = [0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0]
SCENE: dict[str, Any] = {
    "scenecc": 1,
    "name": "one",
    "params": {"height": 1},
    "entities": {"cube": {"pose": [0, 0, "${height}"], "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]}},
}


def content(rows: list[StartRecord] | None = None, **changes: Any) -> StartsFile:
    made_from: dict[str, dict[str, Any]] = {"parts": {}, "params": {}, "files": {}, "versions": {}}
    one = StartRecord(seed=0, scene=0, poses={"cube": POSE})
    return StartsFile(**{"scene": "one", "num_scenes": 1, "made_from": made_from, "rows": rows or [one], **changes})


def write(
    folder: Path, change: Callable[[str], str] = lambda text: text, rows: list[StartRecord] | None = None
) -> Path:
    path = folder / "starts.json"
    path.write_text(change(starts_files(content(rows), path.name)[path.name].decode()))
    return path


def read(path: Path) -> StartsFile:
    return read_starts(path, path.parent.joinpath, 1_000_000)


def test_what_was_written_is_read(tmp_path: Path) -> None:
    assert read(write(tmp_path)) == content()
    assert read(write(tmp_path, lambda text: text.replace("\n", "\r\n"))) == content()


def test_floats_are_the_shortest_that_give_the_same_float32() -> None:
    assert short_floats([0.1, 1 / 3]) == [0.1, 0.33333334]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace("0.1", "0.5"), "it was changed or cut off"),
        (lambda text: text[:-20], "it is not JSON"),
        (lambda text: text.replace('"scenecc_starts": 1', '"scenecc_starts": true'), "it has version true"),
        (lambda text: text.replace('"scenecc_starts": 1', '"scenecc_starts": 1.0'), "it has version 1.0"),
        (lambda text: text.replace('"num_scenes": 1', '"num_scenes": 1, "num_scenes": 2'), "it is not JSON"),
        (lambda text: text.replace("0.1", "NaN"), "it is not JSON"),
        (lambda _: "{}", "it has no key `scenecc_starts`"),
        (lambda _: "[" * 100_000, "it is not JSON"),
        (lambda text: text.replace('"sha256"', '"other"'), "it was changed or cut off"),
    ],
    ids=["edited", "cut", "true", "float", "twice", "nan", "empty", "deep", "unsigned"],
)
def test_a_damaged_file_is_refused(tmp_path: Path, change: Callable[[str], str], message: str) -> None:
    with pytest.raises(InvalidStartsError, match=message):
        read(write(tmp_path, change))


def signed(folder: Path, change: Callable[[dict[str, Any]], Any]) -> Path:
    """Writes a file whose content was changed by someone who also corrected its hash."""
    path = write(folder)
    data = json.loads(path.read_text()) | {"sha256": ""}
    change(data)
    text = json.dumps(data)
    digest = sha256(text.encode()).hexdigest()
    path.write_text(text.replace('"sha256": ""', f'"sha256": "{digest}"', 1))
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data["made_from"].pop("params"), "`made_from` is not what"),
        (lambda data: data["rows"].append(data["rows"][0]), "`rows` is not what"),
        (lambda data: data.update(table="\0"), "not the name of a file"),
        (lambda data: data.update(table="\ud800"), "not the name of a file"),
    ],
    ids=["made_from", "twice", "nul", "surrogate"],
)
def test_a_damaged_file_with_the_right_hash_is_refused(
    tmp_path: Path, change: Callable[[dict[str, Any]], Any], message: str
) -> None:
    with pytest.raises(InvalidStartsError, match=message):
        read(signed(tmp_path, change))


@pytest.mark.parametrize(
    "columns", [None, {"seed": ["x"]}, {"seed": ["0"], "scene": [0], "poses": [[1]], "joints": [[]]}]
)
def test_a_table_of_something_else_is_refused(tmp_path: Path, columns: dict[str, list[Any]] | None) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    table = tmp_path / "starts.parquet"
    table.write_bytes(b"PAR1") if columns is None else pq.write_table(pa.table(columns), table)
    names = {"table": table.name, "table_sha256": sha256(table.read_bytes()).hexdigest()}
    with pytest.raises(InvalidStartsError, match=r"its table .* is not what"):
        read(signed(tmp_path, lambda data: data.update(names) or data.pop("rows")))


def faults(scene: dict[str, Any], starts: Path, **options: Any) -> list[scenecc.Diagnostic]:
    try:
        scenecc.compile_scene(scene, starts=starts, **options)
    except scenecc.SceneError as error:
        return [one for one in error.diagnostics if one.severity == "error"]
    return []


def test_differences_name_parameters_and_assets_first() -> None:
    was = {"parts": {"physics.": "a", "entities.cube": "b"}, "params": {"size": 1}, "files": {"a.obj": "1"}}
    assert not scene_differences(was, was)
    now = {"parts": {"physics.": "a", "entities.cube": "c"}, "params": {"size": 2}, "files": {"b.obj": "1"}}
    assert scene_differences(was, now) == [
        "the parameter `size` was 1 and is 2",
        "`a.obj` is no longer used",
        "`b.obj` is new",
    ]
    assert scene_differences(was, {**was, "parts": now["parts"]}) == ["`entities.cube` changed"]
    assert scene_differences(was, {**was, "parts": {"physics.": "b"}}) == [
        "`physics` changed",
        "`entities.cube` no longer exists",
    ]


def with_fingerprint(folder: Path, rows: list[StartRecord], scene: dict[str, Any] = SCENE) -> Path:
    """Writes starts that belong to a scene, without simulating it."""
    from scenecc.diagnostics import Sink
    from scenecc.options import Options
    from scenecc.pipeline import compile_or_raise
    from scenecc.starts.fingerprint import fingerprint

    result = compile_or_raise(scene, Options.of(), Sink())
    assert result.document is not None
    made_from = fingerprint(result.document, result.expansion, result.scope, result.plan)
    path = folder / "starts.json"
    path.write_bytes(starts_files(content(rows, made_from=made_from), path.name)[path.name])
    return path


@pytest.mark.parametrize(
    "poses",
    [{}, {"ball": POSE}, {"cube": POSE, "ball": POSE}, {"cube": [1e30, *POSE[1:]]}, {"cube": [*POSE[:3], 2, 0, 0, 0]}],
    ids=["none", "other", "more", "far", "scaled"],
)
def test_starts_that_do_not_fit_are_refused(tmp_path: Path, poses: dict[str, list[float]]) -> None:
    path = with_fingerprint(tmp_path, [StartRecord(seed=0, scene=0, poses=poses)])
    (fault,) = faults(SCENE, path)
    assert fault.code == "SC935"


@pytest.fixture
def starts(tmp_path: Path) -> Path:
    return with_fingerprint(tmp_path, [StartRecord(seed=5, scene=0, poses={"cube": POSE})])


def test_starts_are_in_the_plan(starts: Path) -> None:
    plan = scenecc.compile_scene(SCENE, starts=starts)
    assert plan.entities[0].pose.row(0)[:3].astype("float32").tolist() == pytest.approx(POSE[:3])
    assert scenecc.compile_scene(scenecc.plan_text(plan)) == plan
    assert [one.path for one in scenecc.compare_scenes(plan, scenecc.compile_scene(SCENE))][-1] == "starts"
    text = scenecc.plan_text(plan)
    state = json.loads(text)["starts"][0]["state"]
    (fault,) = scenecc.validate(text.replace(state, state[:-8]))
    assert (fault.code, fault.path) == ("SC701", "starts[0]")
    twice = json.loads(text)
    twice["starts"] *= 2
    (fault,) = scenecc.validate(json.dumps(twice))
    assert (fault.code, fault.path) == ("SC701", "starts[1]")


def test_versions_may_name_other_programs() -> None:
    told = other_versions({"versions": {"sapien": "3", "other": "1"}}, {"versions": {"sapien": "3", "physx": "5"}})
    assert told == ["other 1 (here none)", "physx none (here 5)"]


def test_what_is_not_simulated_may_change(starts: Path) -> None:
    camera = {"eye": {"pose": [0, 0, 2]}}
    assert not faults({**SCENE, "cameras": camera, "description": "new", "expect": {"settled": {}}}, starts)


@pytest.mark.parametrize(
    ("scene", "options", "code", "words"),
    [
        (SCENE, {"params": {"height": 2}}, "SC936", "the parameter `height` was 1 and is 2"),
        ({**SCENE, "physics": {"timestep": 0.002}}, {}, "SC936", "`physics` changed"),
        (
            {**SCENE, "name": "two", "entities": {"ball": SCENE["entities"]["cube"]}},
            {},
            "SC936",
            "another scene (`one`)",
        ),
        (SCENE, {"num_scenes": 3}, "SC937", "was made with 1 scene, and 3 are built"),
        (SCENE, {"draws": {"a": [1]}}, "SC250", "there is no shared draw"),
    ],
    ids=["parameter", "physics", "unrelated", "number", "draws"],
)
def test_starts_of_another_scene_are_refused_with_the_difference(
    starts: Path, scene: dict[str, Any], options: dict[str, Any], code: str, words: str
) -> None:
    (fault,) = faults(scene, starts, **options)
    assert (fault.code, words in fault.message) == (code, True), fault


def test_other_versions_are_a_warning(starts: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.starts.fingerprint.VERSION", "9.9")
    (found,) = scenecc.validate(SCENE, starts=starts)
    assert (found.severity, "(here 9.9)" in found.message) == ("warning", True)


def test_a_plan_accepts_no_starts(starts: Path) -> None:
    (fault,) = scenecc.validate(scenecc.compile_scene(SCENE), starts=starts)
    assert (fault.code, fault.message) == ("SC907", "a plan does not accept starts: its values are final")
