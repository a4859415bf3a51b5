"""SRDFs: which pairs count, their bits, and their faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics import Sink
from scenecc.robots.urdf import MAX_IGNORED_PAIRS, read_urdf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path


def pair(first: str, second: str, reason: str = ' reason="Default"') -> str:
    """A pair, on a line of its own."""
    return f'\n<disable_collisions link1="{first}" link2="{second}"{reason}/>'


class Robot:
    """A star of links with an SRDF beside it."""

    def __init__(self, folder: Path, count: int = 5) -> None:
        self.folder = folder
        links = "".join(f'<link name="l{i}"/>' for i in range(count))
        joints = "".join(
            f'<joint name="j{i}" type="fixed"><parent link="l0"/><child link="l{i}"/></joint>' for i in range(1, count)
        )
        (folder / "robot.urdf").write_text(f'<robot name="r">{links}{joints}</robot>')

    def read(self, pairs: str, name: str = "robot.srdf", **options: object) -> tuple[list[int] | None, list[str]]:
        """The bits of the links, and the line, column, code and message of what is told."""
        (self.folder / name).write_text(pairs if pairs.startswith("<") else f'<robot name="r">{pairs}</robot>')
        sink = Sink()
        path = self.folder / "robot.urdf"
        found = read_urdf(ResolvedFile(path, path.name), scope=AssetScope(self.folder), sink=sink, **options)  # type: ignore[arg-type]
        told = [f"{d.file}:{d.line}:{d.column} {d.code} {d.message}" for d in sink.diagnostics()]
        return None if found is None else [link.ignore_bits for link in found.robots[0].links], told


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    return Robot(tmp_path)


def test_each_pair_takes_a_bit_except_parent_and_child(robot: Robot) -> None:
    pairs = pair("l1", "l2") + pair("l0", "l3") + pair("l3", "l1", ' reason="default"') + pair("l2", "l1")
    assert robot.read(pairs) == ([0, 0b111, 0b101, 0b010, 0], [])


def test_adjacent_and_never_pairs_are_skipped_silently(robot: Robot) -> None:
    pairs = pair("l1", "l2", ' reason="Never"') + pair("l1", "l3", ' reason="Adjacent"')
    assert robot.read(pairs) == ([0, 0, 0, 0, 0], [])


def test_pairs_with_other_reasons_are_reported_with_their_count(robot: Robot) -> None:
    pairs = pair("l1", "l2", ' reason="User"') + pair("l1", "l3", "") + pair("l1", "nobody", ' reason="User"')
    bits, told = robot.read(pairs)
    assert bits == [0, 0, 0, 0, 0]
    what = "3 disabled pairs have a reason other than `Default`, so SAPIEN ignores them"
    assert told == [f"robot.srdf:2:1 SC474 {what}"]


def test_the_sibling_srdf_is_read_unless_the_scene_sets_srdf(robot: Robot) -> None:
    pairs = pair("l1", "l2")
    assert robot.read(pairs)[0] == [0, 1, 1, 0, 0]
    assert robot.read(pairs, srdf=None)[0] == [0, 0, 0, 0, 0]
    other = ResolvedFile(robot.folder / "other.srdf", "other.srdf")
    assert robot.read(pair("l3", "l4"), "other.srdf", srdf=other)[0] == [0, 0, 0, 1, 1]


@pytest.mark.parametrize(
    ("pairs", "expected"),
    [
        (pair("l1", "l9"), "2:39 SC471 the robot has no link `l9`"),
        (pair("l1", "l1"), "2:39 SC471 link `l1` is paired with itself"),
        ('\n<disable_collisions link1="l1" reason="Default"/>', "2:1 SC455 <disable_collisions> has no `link2`"),
        ("<srdf/>", "1:1 SC453 the root of an SRDF is <robot>, not <srdf>"),
        ("<robot>", "1:8 SC450 this is not well-formed XML: the file ends before <robot> is closed"),
        ("<!DOCTYPE x><robot/>", "1:1 SC451 document types are refused: they may declare entities and name files"),
    ],
)
def test_an_srdf_error_is_reported_at_its_line(robot: Robot, pairs: str, expected: str) -> None:
    assert robot.read(pairs) == (None, [f"robot.srdf:{expected}"])


def test_more_pairs_than_bits_are_an_error(tmp_path: Path) -> None:
    robot = Robot(tmp_path, 40)
    pairs = [pair("l1", f"l{i}") for i in range(2, MAX_IGNORED_PAIRS + 3)]
    bits, told = robot.read("".join(pairs[:MAX_IGNORED_PAIRS]))
    assert not told
    assert bits is not None
    assert bits[1] == 2**31 - 1
    bits, told = robot.read("".join(pairs))
    assert bits is None
    assert told == ["robot.srdf:33:1 SC473 more than 31 pairs of links must not collide, but there are no more bits"]
