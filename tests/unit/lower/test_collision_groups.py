"""Collision groups as four integers, and links that ignore one another."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.structures import body_of
from sapien import physx
from unit.lower.articulations.test_articulations import BOX
from unit.lower.scenes import BALL, codes, entity, scene

from scenecc import compile_scene, load_scene, validate
from scenecc.lower.articulations import articulations

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic


NAMES = [f"g{i}" for i in range(31)]


def collide(a: Any, b: Any) -> bool:
    """SAPIEN's rule over the four integers of two shapes."""
    ignored = (a[2] & b[2]) and (a[3] & 0xFFFF) == (b[3] & 0xFFFF)
    return bool(((a[0] & b[1]) or (a[1] & b[0])) and not ignored)


def bits_of(groups: dict[str, Any]) -> dict[str | None, list[int]]:
    """The integers of every group, and under None those of what has no group."""
    entities = {f"in_{name}": {"shapes": BALL, "collision_group": name} for name in groups}
    plan = compile_scene({"scenecc": 1, "collision_groups": groups, "entities": {**entities, "free": {"shapes": BALL}}})
    found: dict[str | None, list[int]] = {None: [1, 1, 0, 0]}
    for name in groups:
        value = body_of(entity(plan, f"in_{name}")).collision_groups
        assert value is not None
        found[name] = value.data[0].tolist()
    assert body_of(entity(plan, "free")).collision_groups is None, "no group: SAPIEN's default, untouched"
    return found


@st.composite
def groupings(draw: st.DrawFn) -> dict[str, Any]:
    names = draw(st.lists(st.sampled_from(NAMES), unique=True, min_size=1))
    return {name: {"ignore": draw(st.lists(st.sampled_from(names), max_size=4))} for name in names}


@given(groupings())
def test_two_collide_unless_one_ignores_the_other(groups: dict[str, Any]) -> None:
    bits = bits_of(groups)
    for a, b in itertools.product(bits, repeat=2):
        ignored = a is not None and b is not None and (b in groups[a]["ignore"] or a in groups[b]["ignore"])
        assert collide(bits[a], bits[b]) == (not ignored), (a, b)


def test_exactly_31_groups_fit() -> None:
    groups: dict[str, Any] = {name: {"ignore": [name]} for name in NAMES}
    bits = bits_of(groups)
    assert all(0 <= number < 2**32 for row in bits.values() for number in row)
    assert codes({"scenecc": 1, "collision_groups": {**groups, "g31": {}}}) == [("SC312", "collision_groups.g31")]


def test_all_of_a_body_s_shapes_get_them_in_the_engine() -> None:
    document = scene(
        {"shapes": [*BALL, *BALL], "collision_group": "b"}, collision_groups={"a": {"ignore": ["b"]}, "b": {}}
    )
    with load_scene(document, render=False) as batch:
        component = batch.entities["body"].objs[0].components[0]
        assert isinstance(component, physx.PhysxRigidBaseComponent)
        assert [shape.collision_groups for shape in component.collision_shapes] == [[4, 0b101, 0, 0]] * 2


@pytest.mark.parametrize("bits", [[0, 0, 0, 0], [2**32 - 1, 1, 7, 65535]])
def test_bits_are_passed_on(bits: list[int]) -> None:
    value = body_of(entity(compile_scene(scene({"collision_bits": bits})))).collision_groups
    assert value is not None
    assert value.data.tolist() == [bits]


ALL = 1 << 29


def star(count: int = 3) -> dict[str, Any]:
    """A root with some links on it, each a sibling of the others."""
    children: list[dict[str, Any]] = [
        {"name": f"l{i}", "joint": {"name": f"j{i}", "type": "revolute"}, "shapes": BOX} for i in range(count)
    ]
    return {"name": "root", "shapes": BOX, "children": children}


def articulation_scene(links: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": {"arm": {"root": star(), "links": links, **keys}}}


def told(data: Any) -> list[tuple[str, str, str]]:
    return [(found.code, found.path, found.message) for found in validate(data)]


def test_bits_by_which_links_collide_that_ignore_one_another_are_told_with_both_places() -> None:
    data = articulation_scene({"l1": {"collision_bits": [1, 1, 0, 0]}}, disable_self_collisions=True)
    (found,) = validate(data)
    assert (found.code, found.severity, found.path) == ("SC524", "warning", "entities.arm.links.l1.collision_bits")
    # The root is its parent, with which it collides never.
    assert found.message == "with these bits `l1` and `l0`, and 1 other pair collide, but should ignore one another"
    assert [note.message for note in found.related] == ["should ignore one another"]


KEPT = {
    "the bit and the id": ({"l1": {"collision_bits": [1, 1, ALL | 4, 0]}}, True),
    "another common bit": ({"l.": {"collision_bits": [1, 1, 4, 0]}}, True),
    "collides with nothing": ({"l1": {"collision_bits": [0, 0, 0, 0]}}, True),
    "nothing ignored": ({"l1": {"collision_bits": [1, 1, 0, 0]}}, False),
    "a group before": ({"l1": {"collision_bits": [1, 1, 0, 0]}, "l.": {"collision_group": "g"}}, True),
    "of the root": ({"root": {"collision_bits": [1, 1, 0, 0]}}, True),
}


@pytest.mark.parametrize(("links", "ignored"), KEPT.values(), ids=KEPT)
def test_bits_that_keep_what_is_ignored_are_taken_without_a_word(links: dict[str, Any], ignored: bool) -> None:
    data = articulation_scene(links, **({"disable_self_collisions": True} if ignored else {}))
    groups = {"collision_groups": {"g": {"ignore": []}}} if "l." in links and "l1" in links else {}
    assert told({**data, **groups}) == []


def test_another_id_parts_what_shares_a_bit_and_a_pattern_is_told_once() -> None:
    data = articulation_scene({"l[12]": {"collision_bits": [1, 1, ALL, 7]}}, disable_self_collisions=True)
    ((code, path, message),) = told(data)
    assert (code, path) == ("SC524", 'entities.arm.links["l[12]"].collision_bits')
    assert message.startswith("with these bits `l1` and `l0`, and 1 other pair collide")


def test_a_link_that_touches_nothing_is_none_of_them() -> None:
    data = articulation_scene({"l1": {"collision_bits": [1, 1, 0, 0]}}, disable_self_collisions=True)
    for link in data["entities"]["arm"]["root"]["children"]:
        link["visuals"] = link.pop("shapes")
        link["inertial"] = {"mass": 1, "inertia": [1, 1, 1]}
    assert "SC524" not in {code for code, _, _ in told(data)}


def of_a_file(folder: Path, **keys: str) -> list[Diagnostic]:
    links = "".join(
        f'<link name="l{i}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>' for i in range(4)
    )
    joints = "".join(
        f'<joint name="j{i}" type="continuous"><parent link="l0"/><child link="l{i}"/></joint>' for i in range(1, 4)
    )
    (folder / "r.urdf").write_text(f'<robot name="r">{links}{joints}</robot>')
    pairs = [(0, 1), (1, 2), (2, 3)]
    rows = "".join(f'\n<disable_collisions link1="l{a}" link2="l{b}" reason="Default"/>' for a, b in pairs)
    (folder / "pairs.srdf").write_text(f'<robot name="r">{rows}</robot>')
    text = "scenecc: 1\nentities:\n  arm:\n    urdf: r.urdf\n    srdf: pairs.srdf\n    links:\n"
    rows = "".join(f"      {name}: {{{said}}}\n" for name, said in keys.items())
    (folder / "scene.yaml").write_text(text + rows)
    return validate(folder / "scene.yaml")


def test_of_an_srdf_the_pair_is_shown(tmp_path: Path) -> None:
    (found,) = of_a_file(tmp_path, l3="collision_bits: [1, 1, 0, 0]")
    assert found.message == "with these bits `l3` and `l2` collide, but should ignore one another"
    assert (found.line, found.column) == (7, 28)
    (note,) = found.related
    assert (str(note.location.file).endswith("pairs.srdf"), note.location.line) == (True, 4)
    # That with its parent takes no bit, so that l2 and l3 have the second one.
    assert of_a_file(tmp_path, l3="collision_bits: [1, 1, 2, 0]") == []
    assert of_a_file(tmp_path, l3="gravity: false") == []


def test_the_engine_lets_them_collide_as_told() -> None:
    """Two links in one another part where their bits let them collide, and rest where they ignore one another."""

    def turned(links: dict[str, Any]) -> float:
        data = articulation_scene(links, disable_self_collisions=True, fix_root_link=True, gravity=False)
        for i, link in enumerate(data["entities"]["arm"]["root"]["children"]):
            link["joint"] |= {"axis": "z", "origin": [1, 0, 0]}
            link["shapes"] = [{**BOX[0], "pose": [1, 0.05 * i, 0]}]
        with load_scene(data, render=False) as batch:
            batch.step(20)
            return float(abs(batch.articulations["arm"].qpos).max())

    assert turned({}) == 0
    assert turned({"l1": {"collision_bits": [1, 1, 0, 0]}}) > 1e-3


def test_more_articulations_than_the_fourth_integer_tells_apart_are_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(articulations, "COLLISION_ID_BITS", 2)
    alike = {"root": star(), "disable_self_collisions": True}

    def of(count: int) -> dict[str, Any]:
        free = {"free": {"root": star(), "pose": {"p": [0, 0, 9]}}}
        arms = {f"arm{i}": {**alike, "pose": {"p": [i, 0, 0]}} for i in range(count)}
        return {"scenecc": 1, "entities": {**free, **arms}}

    assert told(of(3)) == []
    message = "PhysX can distinguish 3 articulations whose links ignore one another, and this is one more"
    assert told(of(5)) == [("SC519", "entities.arm3", message)]
    bits = [entity.structures[0].bodies[0].collision_groups for entity in compile_scene(of(3)).entities]
    assert [None if groups is None else groups.numbers() for groups in bits] == [
        None,
        *((1, 1, ALL, number) for number in range(3)),
    ]
