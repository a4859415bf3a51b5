"""`cover_scene` and `scene_coverage`: all pairs of a file, under its own conditions."""

from __future__ import annotations

import csv
import io
import json
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import scenecc

SIX: dict[str, Any] = {
    "scenecc": 1,
    "draws": {"a": {"choice": [1, 2, 3, 4]}, "b": {"integers": [1, 4]}, "u": {"uniform": [0, 1]}},
    "entities": {
        "cube": {
            "pose": [{"choice": [0.0, 0.1, 0.2, 0.3]}, {"normal": [0, 1], "clip": [-9, 9]}, "${u}"],
            "mass": {"choice": [1, 2, 3, 4], "weights": [5, 1, 1, 1]},
            "shapes": [
                {"type": "box", "half_size": "${[a/100, b/100, 0.1]}"},
                {"type": "sphere", "radius": {"choice": [0.1, 0.2, 0.3, {"uniform": [0.4, 0.5]}]}},
            ],
            "pick": {"choice": [0, 1]},
            "variants": [{"linear_damping": {"choice": [0.1, 0.2]}}, {"angular_damping": {"log_uniform": [0.1, 0.2]}}],
        }
    },
}


def built(scene: dict[str, Any], cover: scenecc.SceneCover, folder: Path) -> dict[str, np.ndarray]:
    cover.write(folder / "starts.json")
    (found,) = scenecc.scene_draws(scene, starts=folder / "starts.json", num_scenes=len(cover.rows))
    return dict(found.values)


def test_every_pair_of_the_built_values_is_met(tmp_path: Path) -> None:
    cover = scenecc.cover_scene(SIX)
    values = built(SIX, cover, tmp_path)
    assert len(cover.rows) <= 28
    radius = np.minimum(values["cube.shapes[1].radius"], 0.4)
    columns = [values["a"], values["b"], values["cube.pose"][:, 0], values["cube.mass"], radius, values["cube.pick"]]
    for first, second in combinations(columns, 2):
        wanted = set(product({*first.tolist()}, {*second.tolist()}))
        assert set(zip(first.tolist(), second.tolist(), strict=True)) == wanted
    assert [len({*column.tolist()}) for column in columns] == [4, 4, 4, 4, 4, 2]
    assert {frozenset((one.first, one.second)) for one in cover.missed} == {
        frozenset((("cube.pick", 1), ("cube.variants[0].linear_damping", value))) for value in (0.1, 0.2)
    }
    ranks = np.sort(np.argsort(np.argsort(values["u"])))
    assert np.allclose(np.sort(values["u"]), (ranks + 0.5) / len(ranks))
    normal = np.sort(values["cube.pose"][:, 1])
    assert normal[0] < -1.9
    assert normal[-1] > 1.9


def test_a_cover_is_the_same_again_and_for_any_seed(tmp_path: Path) -> None:
    first, second = scenecc.cover_scene(SIX), scenecc.cover_scene(SIX)
    assert first.content == second.content
    values = built(SIX, first, tmp_path)
    (other,) = scenecc.scene_draws(SIX, starts=tmp_path / "starts.json", num_scenes=len(first.rows), seed=9)
    assert all(np.array_equal(values[name], other.values[name], equal_nan=True) for name in values)


def test_chosen_values_equal_those_written_by_hand(tmp_path: Path) -> None:
    cover = scenecc.cover_scene(SIX)
    values = built(SIX, cover, tmp_path)
    scene = json.loads(json.dumps(SIX))
    count = len(cover.rows)
    cube = scene["entities"]["cube"]
    for name in ("a", "b", "u"):
        scene["draws"][name] = {"per_scene": values[name].tolist()}
    cube["pose"][0] = {"per_scene": values["cube.pose"][:, 0].tolist()}
    cube["pose"][1] = {"per_scene": values["cube.pose"][:, 1].tolist()}
    cube["mass"] = {"per_scene": values["cube.mass"].tolist()}
    cube["shapes"][1]["radius"] = {"per_scene": values["cube.shapes[1].radius"].tolist()}
    cube["pick"] = {"per_scene": values["cube.pick"].astype(int).tolist()}
    for number, key in enumerate(("linear_damping", "angular_damping")):
        rows = np.nan_to_num(
            values[f"cube.variants[{number}].{key}" if f"cube.variants[{number}].{key}" in values else f"cube.{key}"],
            nan=0.1,
        )
        cube["variants"][number][key] = {"per_scene": rows.tolist()}
    (hand,) = scenecc.scene_draws(scene, num_scenes=count)
    for name in hand.values:
        assert np.array_equal(hand.values[name], values[name], equal_nan=True), name


def test_a_plan_keeps_the_chosen_values(tmp_path: Path) -> None:
    cover = scenecc.cover_scene(SIX)
    cover.write(tmp_path / "starts.json")
    plan = scenecc.compile_scene(SIX, starts=tmp_path / "starts.json", num_scenes=len(cover.rows))
    text = scenecc.plan_text(plan)
    assert scenecc.plan_text(scenecc.compile_scene(text)) == text


CONDITIONS: dict[str, Any] = {
    "scenecc": 1,
    "draws": {"a": {"choice": [1, 2, 3]}, "b": {"choice": [1, 2, 3]}, "c": {"choice": ["x", "y"]}},
    "entities": {
        "ball": {"mass": "${a - b + 0.5}", "shapes": [{"type": "sphere", "radius": "${0.1 if c == 'x' else 0.2}"}]}
    },
}


def test_pairs_that_expressions_exclude_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(CONDITIONS))
    cover = scenecc.cover_scene(path)
    assert {(one.first[1], one.second[1], one.why) for one in cover.missed} == {
        (1, 2, "excluded"), (1, 3, "excluded"), (2, 3, "excluded")
    }  # fmt: skip
    assert all(one.by.startswith(f"{path}:") for one in cover.missed)
    assert cover.met == 6 + 6 + 6
    values = built(CONDITIONS, cover, tmp_path)
    assert set(zip(values["a"].tolist(), values["b"].tolist(), strict=True)) == {
        (a, b) for a in (1, 2, 3) for b in (1, 2, 3) if a >= b
    }


def test_an_expression_excludes_only_with_the_item_that_has_it() -> None:
    ball = {"shapes": [{"type": "sphere", "radius": 0.1}], "linear_damping": {"choice": [0, "${1 / (2 - a)}"]}}
    cover = scenecc.cover_scene({"scenecc": 1, "draws": {"a": {"choice": [0, 1, 2]}}, "entities": {"ball": ball}})
    assert [(one.first, one.second[1], one.why) for one in cover.missed] == [(("a", 2), "item 1", "excluded")]


def test_what_ranges_exclude_is_tried_with_other_numbers() -> None:
    scene = json.loads(json.dumps(CONDITIONS))
    scene["draws"]["u"] = {"uniform": [0, 1]}
    scene["entities"]["ball"]["mass"] = "${1 if u < 0.7 else a - 3}"
    cover = scenecc.cover_scene(scene)
    assert not cover.missed


@pytest.mark.parametrize(
    ("draws", "words"),
    [
        ({}, "the file draws nothing"),
        ({"u": {"uniform": [0.1, 0.2]}}, "only from ranges"),
        ({"u": {"choice": [0, -1]}}, "no scene"),
    ],
)
def test_nothing_to_cover_is_an_error(draws: dict[str, Any], words: str) -> None:
    radius = "${u}" if draws else 0.1
    scene = {"scenecc": 1, "draws": draws, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": radius}]}}}
    with pytest.raises(scenecc.SceneError, match=words):
        scenecc.cover_scene(scene)
    with pytest.raises(scenecc.SceneError, match=words):
        scenecc.scene_coverage(scene, [])


def test_sobol_balances_alternatives_and_fills_ranges(tmp_path: Path) -> None:
    cover = scenecc.cover_scene(SIX, sobol=16)
    values = built(SIX, cover, tmp_path)
    assert all(np.unique(values[name], return_counts=True)[1].tolist() == [4, 4, 4, 4] for name in ("a", "b"))
    assert sorted(np.floor(values["u"] * 16).tolist()) == list(range(16))


def episodes(count: int) -> list[dict[str, Any]]:
    (found,) = scenecc.scene_draws(SIX, num_scenes=count)
    return [{name: rows[scene] for name, rows in found.values.items()} for scene in range(count)]


def test_coverage_counts_the_pairs_of_episodes() -> None:
    rows = episodes(30)
    found = scenecc.scene_coverage(SIX, rows)
    assert found.episodes == 30
    names = {"a": "a", "b": "b", "cube.mass": "cube.mass", "cube.pick": "cube.pick"}
    for first, second in combinations(names, 2):
        seen = {(float(row[first]), float(row[second])) for row in rows}
        missed = {
            (float(one.first[1]), float(one.second[1]))
            for one in found.missed
            if (one.first[0], one.second[0]) == (first, second)
        } | {
            (float(one.second[1]), float(one.first[1]))
            for one in found.missed
            if (one.second[0], one.first[0]) == (first, second)
        }
        wanted = set(product({float(v) for v in found.factors[first]}, {float(v) for v in found.factors[second]}))
        assert missed == wanted - seen
    assert found.hidden == ()


def test_a_cover_has_full_coverage() -> None:
    cover = scenecc.cover_scene(SIX)
    found = scenecc.scene_coverage(SIX, [row.draws for row in cover.content.rows])
    assert found.missed == ()
    assert found.met == cover.met
    assert found.share == 1.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "there is no episode"),
        ("{", "line 1 is not JSON"),
        ("[1]", "not a mapping"),
        ('{"other": 1}', "no episode has"),
        ('{"scenecc_passport": 1}', "is a passport"),
        ('[{"a": 1}, {"seed": 3, "values": null}]', r"`values` of episode 2 \(seed 3\) is not a mapping"),
        ('{"values": [1]}', "`values` of episode 1 is not a mapping"),
        ('{"values": {"a": {"b": 1}}}', "`values` of episode 1 is not a mapping"),
        ("[" * 100_000, "nested too deeply"),
        ('{"a": 7}', r"episode 1: a = 7.0, which this file does not draw: 1 \| 2 \| 3 \| 4"),
        ('{"seed": 3, "scene": 1, "values": {"a": 1, "b": 9}}', r"\(seed 3, scene 1\): b = 9"),
    ],
)
def test_other_files_are_refused(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "draws.json"
    path.write_text(text)
    with pytest.raises(scenecc.SceneError, match=words) as caught:
        scenecc.scene_coverage(SIX, path)
    assert {one.code for one in caught.value.diagnostics} == {"SC946"}


def test_a_csv_with_cells_missing_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "draws.csv"
    written = io.StringIO()
    csv.writer(written).writerows([["a", "b"], [1]])
    path.write_text(written.getvalue())
    with pytest.raises(scenecc.SceneError, match="another number of cells"):
        scenecc.scene_coverage(SIX, path)


def test_conditions_that_exclude_most_are_exact(tmp_path: Path) -> None:
    scene = {
        "scenecc": 1,
        "draws": {name: {"integers": [0, 4]} for name in "abcd"},
        "entities": {
            "ball": {
                "mass": "${1 if a == b and b == c else 0}",
                "linear_damping": "${1 / (d + 0.5)}",
                "shapes": [{"type": "sphere", "radius": 0.1}],
            }
        },
    }
    cover = scenecc.cover_scene(scene)
    assert (cover.met, len(cover.missed)) == (3 * 5 + 3 * 25, 3 * 20)
    assert len(cover.rows) <= 26
    assert {one.why for one in cover.missed} == {"excluded"}
    values = built(scene, cover, tmp_path)
    assert np.array_equal(values["a"], values["b"])


def test_a_column_of_chosen_numbers_may_be_short_in_a_plan(tmp_path: Path) -> None:
    scene = {
        "scenecc": 1,
        "entities": {"ball": {"mass": {"choice": [1, 2, 3]}, "shapes": [{"type": "sphere", "radius": 0.1}]}},
    }
    cover = scenecc.cover_scene(scene)
    cover.write(tmp_path / "starts.json")
    plan = scenecc.compile_scene(scene, starts=tmp_path / "starts.json", num_scenes=3)
    data = json.loads(scenecc.plan_text(plan))
    text = json.dumps(data)
    column = json.dumps([row.chosen['["entities", "ball", "mass"]'][0][2] for row in cover.content.rows])
    assert column in text
    with scenecc.load_scene(text.replace(column, "[0.5]"), render=False) as batch:
        batch.reset(seed=4)
        assert batch.drawn()["ball.mass"][0] == 2
    with pytest.raises(scenecc.SceneError):
        scenecc.compile_scene(text.replace(column, "[1.5]"))


def test_a_variant_that_a_draw_picks_is_a_condition() -> None:
    scene = {
        "scenecc": 1,
        "draws": {"kind": {"choice": [0, 1]}, "a": {"choice": [1, 2]}},
        "entities": {
            "ball": {
                "mass": "${a}",
                "pick": "${kind}",
                "variants": [{"shapes": [{"type": "sphere", "radius": {"choice": [0.1, 0.2]}}]} for _ in range(2)],
            }
        },
    }
    cover = scenecc.cover_scene(scene)
    assert all(
        (f"ball.variants[{number}].shapes[0].radius" in row) == (row["kind"] == number)
        for row in cover.rows
        for number in (0, 1)
    )
    assert (cover.met, len(cover.missed)) == (4 + 4 + 4 + 4, 4 + 4)
    assert scenecc.scene_coverage(scene, [row.draws for row in cover.content.rows]).missed == ()


def test_an_integer_beyond_floats_is_no_traceback() -> None:
    from scenecc.coverage.episodes import to_cell

    assert to_cell(-(10**400)) == -float("inf")


def test_a_draw_that_nothing_reads_is_no_factor() -> None:
    cover = scenecc.cover_scene({**SIX, "draws": {**SIX["draws"], "unread": {"choice": [1, 2, 3]}}})
    assert "unread" not in cover.factors
    assert [one.code for one in cover.diagnostics] == ["SC319"]
