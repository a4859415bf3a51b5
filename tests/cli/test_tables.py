from __future__ import annotations

import re
import unicodedata
from dataclasses import replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from scenecc import SummaryRow
from scenecc.cli.tables import built, escape_text, index_ranges, planned, stage_times
from scenecc.inspect import VaryingField


@pytest.mark.parametrize(
    ("idxs", "shown"),
    [
        ((), ""),
        ((0,), "0"),
        ((0, 2), "0, 2"),
        ((0, 1), "0, 1"),
        (range(4096), "0–4095"),
        ((0, 1, 2, 3, 8, 10, 11, 12), "0–3, 8, 10–12"),
    ],
)
def test_scene_indices_are_abbreviated(idxs: tuple[int, ...], shown: str) -> None:
    assert index_ranges(idxs) == shown


@given(st.sets(st.integers(0, 60)))
def test_abbreviated_indices_are_equivalent(idxs: set[int]) -> None:
    read: list[int] = []
    for part in filter(None, index_ranges(sorted(idxs)).split(", ")):
        first, _, last = part.partition("–")
        read += range(int(first), int(last or first) + 1)
    assert read == sorted(idxs)


def test_stage_times_sum_to_the_total() -> None:
    assert stage_times({"read": 0.0021, "build": 1.5}) == "read 2.1 ms, build 1.50 s; 1.50 s in all"


@given(st.lists(st.text(min_size=1), max_size=4))
@example(["\x1b[2J", "a\n::error::x", "::error::x", " ::error::x", "##[error]x", "\x9b2J", "\u202ex", "\ud800"])
def test_tables_escape_names_for_terminals_and_runners(names: list[str]) -> None:
    rows = [SummaryRow(name, "dynamic", 1, None, None, (0,)) for name in names]
    lines = built(rows).removesuffix("\n").split("\n")
    field = VaryingField("mass", "".join(names), at_reset=False)
    for row in rows:
        lines += planned([replace(row, varying=(field,))]).split("\n\n")[-1].split("\n")[1:-1]
    assert len(lines) == 1 + 2 * len(names)
    for line in lines:
        assert not re.match(r"\s*::|.*##\[", line)
        assert not any(unicodedata.category(char) in {"Cc", "Cs", "Zl", "Zp"} or char == "\u202e" for char in line)
    assert escape_text("red.box-2 é") == "red.box-2 é"


def test_the_fields_of_a_plan_are_listed_below_its_objects() -> None:
    fields = (VaryingField("pose.p", "0 … 1 each", at_reset=True), VaryingField("mass", "1 | 2", at_reset=False))
    rows = [
        SummaryRow("ball", "dynamic", 2, None, (0.1, 0.2, 0.3), (0, 1), 5, fields),
        SummaryRow("wall", "static", 1, None, None, (0,), 3, ()),
    ]
    assert planned(rows) == (
        "name  body     shapes  size [m]         scenes  differing\n"
        "ball  dynamic       2  0.1 × 0.2 × 0.3  0, 1    2 of 5\n"
        "wall  static        1  –                0       –\n"
        "\n"
        "      differs            values\n"
        "ball  pose.p   at reset  0 … 1 each\n"
        "      mass               1 | 2\n"
    )


def test_many_entities_share_lines() -> None:
    pose = (VaryingField("pose.p", "0 … 1 each", at_reset=True),)
    rows = [SummaryRow(f"ball_{i}", "dynamic", 1, None, (0.1, 0.1, 0.1), (0, 1), 5, pose) for i in range(1000)]
    rows.append(replace(rows[0], name="ball_1000", size=(0.2, 0.1, 0.1), varying=()))
    assert planned(rows, whole=False).splitlines()[1:] == [
        "ball_0 … ball_1000 (1001)  dynamic       1  0.1–0.2 × 0.1 × 0.1  0, 1    1 of 5",
        "",
        "                           differs            values",
        "ball_0 … ball_1000 (1001)  pose.p   at reset  0 … 1 each",
    ]
    assert len(planned(rows).splitlines()) == 2 * len(rows) + 2
    words = [replace(rows[0], name=f"{'ab'[i % 2]}/{chr(0x3B1 + i)}") for i in range(32)]
    assert [line.split("  ")[0] for line in built(words, whole=False).splitlines()] == [
        "name", "a/α … a/Ϗ (16)", "b/β … b/ϐ (16)",
    ]  # fmt: skip
    others = [replace(row, name=row.name[2:]) for row in words]
    assert built(others, whole=False).splitlines()[1].startswith("α … ϐ (32)  dynamic")


def test_differences_between_scenes_are_marked() -> None:
    row = SummaryRow("ball", "dynamic", 1, 0.05, (0.1, 0.1, 0.1), (0, 1), masses=(0.05, 0.12), size_differs=True)
    assert built([row]).splitlines()[1].split("  ")[-3:] == ["0.05–0.12", "~ 0.1 × 0.1 × 0.1", "0, 1"]
    same = replace(row, masses=(0.05, 0.05), size_differs=False)
    assert built([same]).splitlines()[1].split("  ")[-2] == "0.1 × 0.1 × 0.1"


def test_articulations_and_mounted_objects_are_summarised() -> None:
    fields = (VaryingField("color", "0 … 1", at_reset=False),)
    rows = [
        SummaryRow("robot", "articulation", 17, 17.45, None, (0, 1), masses=(17.45, 17.45), link_count=15, dof=9),
        SummaryRow("stone", "articulation", 1, 1.0, None, (0,), masses=(1.0, 1.0), link_count=1),
        SummaryRow("tied", "weld", 0, None, None, (0,), section="constraints", mounts=("ball", "robot/hand")),
        SummaryRow("lamp", "spot", 0, None, None, (1,), 4, fields, section="lights", mounts=("world",)),
    ]
    assert built(rows) == (
        "name   body                           shapes  mass [kg]  size [m]  scenes\n"
        "robot  articulation, 15 links, 9 dof      17      17.45  –         0, 1\n"
        "stone  articulation, 1 link, 0 dof         1          1  –         0\n"
        "\n"
        "name  in           type  on                 scenes\n"
        "tied  constraints  weld  ball – robot/hand  0\n"
        "lamp  lights       spot  world              1\n"
    )
    assert planned(rows).endswith("\n             differs    values\nlights.lamp  color      0 … 1\n")


def test_a_long_table_is_cut_and_names_the_option_for_all_rows() -> None:
    cube = SummaryRow("", "dynamic", 1, 1.0, None, (0,), masses=(1.0, 1.0))
    copies = [replace(cube, name=f"cube_{i}") for i in range(31)]
    assert built(copies, whole=False).splitlines()[1].startswith("cube_0 … cube_30 (31)  dynamic")
    assert len(built(copies[:30], whole=False).splitlines()) == 31
    differing = [replace(cube, name=f"cube_{i}", masses=(i + 1.0, i + 1.0)) for i in range(40)]
    assert "cube_0 … cube_39 (40)  dynamic       1       1–40" in built(differing, whole=False)
    assert len(built(differing).splitlines()) == 41
    fields = tuple(VaryingField(f"shapes[{i}].density", "1 … 2", at_reset=False) for i in range(35))
    text = planned([replace(cube, name="cube", varying=fields)], whole=False)
    assert text.splitlines()[-1] == "… 5 more rows, which --all shows"
    assert "more rows" not in planned([replace(cube, name="cube", varying=fields)])
