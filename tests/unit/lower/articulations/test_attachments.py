"""Parts that are attached to an articulation: what is built equals one tree, or one file, that says the same."""

from __future__ import annotations

import copy
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import pytest

from scenecc import compile_scene, load_scene, validate
from scenecc.plan import ArticulationStructure, Connection, Link, ScenePlan
from scenecc.plan.body import groups_collide

BOX: Any = {"type": "box", "half_size": [0.1, 0.1, 0.1]}
HINGE: Any = {"type": "revolute", "origin": [0, 0, 0.2], "axis": "y", "limits": [-1, 1]}


def link(name: str, *children: Any, joint: Any = None, **keys: Any) -> dict[str, Any]:
    made: dict[str, Any] = {"name": name, "shapes": [BOX], **keys}
    if joint is not None:
        made["joint"] = joint
    return {**made, "children": list(children)} if children else made


def scene(**entity: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": {"arm": {"fix_root_link": True, **entity}}}


def structures(plan: ScenePlan) -> tuple[ArticulationStructure, ...]:
    found = plan.entities[-1].structures
    assert all(isinstance(one, ArticulationStructure) for one in found)
    return found  # pyright: ignore[reportReturnType]


def codes(document: Any) -> list[str]:
    return [diagnostic.code for diagnostic in validate(document)]


UPPER = link("upper", joint={"name": "shoulder", **HINGE})
FINGER = link("finger", joint={"name": "slide", "type": "prismatic", "axis": "y", "limits": [0, 0.1]})


def flat(palm: Any) -> dict[str, Any]:
    """The arm as one tree. `palm`: what hangs on its upper link."""
    return link("base", {**UPPER, "children": [palm]})


def hand(*children: Any, joint: Any, prefix: str = "hand_") -> dict[str, Any]:
    """The palm with its finger, as in one tree."""
    slide = {**FINGER["joint"], "name": f"{prefix}slide"}
    return link(f"{prefix}palm", {**FINGER, "name": f"{prefix}finger", "joint": slide}, *children, joint=joint)


def test_a_fixed_part() -> None:
    pose = {"p": [0, 0, 0.3], "rpy_deg": [0, 0, 45]}
    part = {"to": "upper", "pose": pose, "prefix": "hand_", "root": link("palm", FINGER)}
    whole = scene(root=link("base", UPPER), attach={"hand": part})
    assert compile_scene(whole) == compile_scene(scene(root=flat(hand(joint={"type": "fixed", "origin": pose}))))


def test_a_part_on_a_joint_inside_another_part() -> None:
    turn = {"name": "turn", "type": "continuous", "origin": [0.1, 0, 0], "axis": [0, 0, 2], "damping": 0.3}
    camera = {"to": "finger", "prefix": "eye_", "joint": turn, "root": link("body")}
    part = {"to": "upper", "prefix": "hand_", "root": link("palm", FINGER), "attach": {"camera": camera}}
    whole = scene(root=link("base", UPPER), attach={"hand": part}, qpos={"hand_eye_turn": 0.2})
    body = link("hand_eye_body", joint={**turn, "name": "hand_eye_turn"})
    tree = flat(hand(joint={"type": "fixed"}))
    tree["children"][0]["children"][0]["children"][0]["children"] = [body]
    assert compile_scene(whole) == compile_scene(scene(root=tree, qpos={"hand_eye_turn": 0.2}))


def test_a_part_on_a_link_of_an_earlier_part() -> None:
    whole = scene(
        root=link("base", UPPER),
        attach={
            "hand": {"to": "upper", "prefix": "hand_", "root": link("palm", FINGER)},
            "camera": {"to": "hand_palm", "prefix": "eye_", "root": link("body")},
        },
    )
    body = link("eye_body", joint={"type": "fixed"})
    assert compile_scene(whole) == compile_scene(scene(root=flat(hand(body, joint={"type": "fixed"}))))


def test_keys_of_the_whole_win_over_those_of_parts_and_these_over_those_of_their_parts() -> None:
    inner = {
        "to": "finger",
        "joint": {"name": "turn", **HINGE},
        "root": link("body"),
        "qpos": [0.3],
        "drives": {".*": {"stiffness": 1, "damping": 2, "force_limit": 3}},
        "links": {"body": {"linear_damping": 1, "angular_damping": 2}},
    }
    part = {
        "to": "upper",
        "root": link("palm", FINGER),
        "qpos": {"slide": 0.05, "eye/turn": 0.4},
        "joints": {"slide": {"friction": 1, "armature": 2}},
        "drives": {"eye/turn": {"damping": 5, "force_limit": 6}},
        "links": {"eye/body": {"angular_damping": 4}},
        "attach": {"eye": inner},
    }
    whole = scene(
        root=link("base", UPPER),
        qpos={"hand/slide": 0.06},
        joints={"hand/slide": {"friction": 3}},
        drives={"hand/eye/.*": {"force_limit": 7}},
        attach={"hand": part},
    )
    links = {one.name: one for one in structures(compile_scene(whole))[0].links}
    slide, turn = links["hand/finger"].joint, links["hand/eye/body"].joint
    assert slide is not None
    assert turn is not None
    numbers = {
        name: getattr(joint, name).numbers()[0]
        for joint, names in (
            (slide, ("qpos", "friction", "armature")),
            (turn, ("stiffness", "damping", "force_limit", "drive_target")),
        )
        for name in names
    }
    assert numbers == {
        "qpos": 0.06,
        "friction": 3,
        "armature": 2,
        "stiffness": 1,
        "damping": 5,
        "force_limit": 7,
        "drive_target": 0.4,
    }
    body = links["hand/eye/body"].body
    assert body.linear_damping is not None
    assert body.angular_damping is not None
    assert (body.linear_damping.numbers(), body.angular_damping.numbers()) == ((1,), (4,))


def urdf(*names: str, first: str = "base") -> str:
    """A chain of boxes on hinges."""
    box = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    links = "".join(f'<link name="{name}">{box}</link>' for name in (first, *names))
    joints = "".join(
        f'<joint name="to_{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        '<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for parent, child in zip((first, *names), names, strict=False)
    )
    return f'<robot name="r">{links}{joints}</robot>'


def srdf(*pairs: tuple[str, str]) -> str:
    said = "".join(f'<disable_collisions link1="{one}" link2="{other}" reason="Default"/>' for one, other in pairs)
    return f'<robot name="r">{said}</robot>'


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def ignoring(structure: ArticulationStructure) -> set[tuple[str, str]]:
    """The pairs of links that their bits keep apart."""
    groups = {
        one.name: one.body.collisions[0].collision_groups or one.body.collision_groups
        for one in structure.links
        if one.body.collisions
    }
    bits = {name: (1, 1, 0, 0) if value is None else value.numbers() for name, value in groups.items()}
    pairs = combinations(bits, 2)
    return {(a, b) for a, b in pairs if not groups_collide(tuple(map(int, bits[a])), tuple(map(int, bits[b])))}


def test_pairs_of_each_file_and_ignored_links_never_collide() -> None:
    Path("arm.urdf").write_text(urdf("a", "b", "c"))
    Path("arm.srdf").write_text(srdf(("base", "b"), ("a", "c")))
    Path("hand.urdf").write_text(urdf("d", "e", first="palm"))
    Path("hand.srdf").write_text(srdf(("palm", "e")))
    part = {"urdf": "hand.urdf", "to": "c", "ignore": ["b", "c"]}
    (made,) = structures(compile_scene(scene(urdf="arm.urdf", attach={"hand": part})))
    files = {("base", "b"), ("a", "c"), ("hand/palm", "hand/e")}
    ignored = {(one, f"hand/{other}") for one in "bc" for other in ("palm", "d", "e")}
    # The root of a part and the link that carries it are parent and child.
    found = ignoring(made) - {("b", "c"), ("hand/palm", "hand/d"), ("hand/d", "hand/e"), ("c", "hand/palm")}
    assert found == files | ignored - {("c", "hand/palm")}


def pairs_of(count: int, first: str) -> tuple[list[str], list[tuple[str, str]]]:
    """Names of links in a chain, and pairs of which no two can share a bit."""
    names = [f"{first}{i}" for i in range(2 * count)]
    return names, [(names[i], names[i + count]) for i in range(count)]


@pytest.mark.parametrize(("inner", "expected"), [(1, []), (2, ["SC336"])])
def test_more_sets_of_links_than_bits_are_an_error(inner: int, expected: list[str]) -> None:
    names, pairs = pairs_of(31, "a")
    Path("arm.urdf").write_text(urdf(*names))
    Path("arm.srdf").write_text(srdf(*pairs))
    others, more = pairs_of(inner, "b")
    Path("hand.urdf").write_text(urdf("between", *others, first="palm"))
    Path("hand.srdf").write_text(srdf(*more))
    document = scene(urdf="arm.urdf", attach={"hand": {"urdf": "hand.urdf", "to": names[-1]}})
    assert [code for code in codes(document) if code != "SC519"] == expected


def test_pairs_share_bits_where_there_are_too_few() -> None:
    """All pairs of some links take as many bits as there are pairs; one bit says the same."""
    names = [f"a{i}" for i in range(8)]
    spread = [pair for pair in combinations(names, 2) if names.index(pair[1]) - names.index(pair[0]) > 1]
    Path("arm.urdf").write_text(urdf(*names))
    Path("arm.srdf").write_text(srdf(*spread))
    Path("hand.urdf").write_text(urdf(*names, first="palm"))
    Path("hand.srdf").write_text(srdf(*spread))
    alone: Any = {"urdf": "arm.urdf"}
    (made,) = structures(compile_scene(scene(**alone, attach={"hand": {"urdf": "hand.urdf", "to": "a7"}})))
    expected = {*spread, *((f"hand/{one}", f"hand/{other}") for one, other in spread)}
    chain = ["base", *names, "hand/palm", *(f"hand/{name}" for name in names)]
    assert ignoring(made) - set(pairwise(chain)) == expected


@pytest.mark.parametrize("form", [{"cycle": ["one.urdf", "two.urdf"]}, {"choice": ["one.urdf", "two.urdf"]}])
def test_a_part_of_several_files(form: Any) -> None:
    Path("one.urdf").write_text(urdf("d", first="palm"))
    Path("two.urdf").write_text(urdf("d", "e", first="palm"))
    Path("arm.urdf").write_text(urdf("a"))
    part: Any = {"urdf": "one.urdf", "to": "a", "qpos": {"to_d": 0.1}, "links": {"d|e": {"linear_damping": 1}}}
    eye: Any = {"to": "hand/d", "root": link("body")}
    made = scene(urdf="arm.urdf", attach={"hand": {**part, "urdf": form}, "eye": eye})
    varying = structures(compile_scene(made, num_scenes=4))
    part["links"] = {"d|e?": {"linear_damping": 1}}
    alone = [
        structures(compile_scene(scene(urdf="arm.urdf", attach={"hand": {**part, "urdf": file}, "eye": eye})))[0]
        for file in ("one.urdf", "two.urdf")
    ]
    assert [without_files(one) for one in varying] == [without_files(one) for one in alone]
    files = [[link.file is not None for link in one.links] for one in varying]
    assert files == [[True] * 4 + [False], [True] * 5 + [False]]


def without_files(structure: ArticulationStructure) -> list[Link]:
    """Links, without the indices of their files, which are each plan's own."""
    return [replace(link, file=None) for link in structure.links]


def test_the_whole_and_a_part_vary_together() -> None:
    for name, links in (("a", ("x", "y")), ("b", ("y",)), ("c", ("d",)), ("d", ("d", "e"))):
        Path(f"{name}.urdf").write_text(urdf(*links))
    part = {"urdf": {"cycle": ["c.urdf", "d.urdf"]}, "to": "y"}
    made = scene(urdf={"cycle": ["a.urdf", "a.urdf", "b.urdf", "b.urdf"]}, attach={"hand": part})
    plan = compile_scene(made, num_scenes=8)
    counts = [len(one.links) for one in structures(plan)]
    pick = plan.entities[-1].pick
    assert pick is not None
    assert [counts[int(i)] for i in pick.numbers()] == [5, 6, 4, 5, 5, 6, 4, 5]


MJCF = """<mujoco><worldbody><body name="palm" pos="0 0 0.1"><geom type="box" size="0.1 0.1 0.1"/>
<body name="left" pos="0.3 0 0"><joint name="l" axis="0 1 0"/>
<geom type="box" size="0.1 0.1 0.1"/></body>
<body name="right" pos="-0.3 0 0"><joint name="r" axis="0 1 0"/><geom type="box" size="0.1 0.1 0.1"/></body></body>
</worldbody><equality><connect name="loop" body1="left" body2="right" anchor="0 0 0"/></equality></mujoco>"""


def test_constraints_of_a_part_are_the_articulations() -> None:
    Path("hand.xml").write_text(MJCF)
    document = scene(root=link("base", UPPER), attach={"hand": {"mjcf": "hand.xml", "to": "upper"}})
    # The pose of the root is the part's.
    assert codes(document) == ["SC337"]
    (constraint,) = compile_scene(document).constraints
    assert constraint.name == "arm/hand/loop"
    assert isinstance(constraint.joint, Connection)
    assert {str(constraint.parent), str(constraint.child)} == {"arm/hand/left", "arm/hand/right"}
    with load_scene(document, render=False) as batch:
        batch.step()
    entity = document["entities"]["arm"]
    entity["attach"]["hand"]["mjcf"] = {"cycle": ["hand.xml", "other.xml"]}
    Path("other.xml").write_text(MJCF.replace("0.3 0 0", "0.4 0 0"))
    assert "SC327" in codes({**document, "num_scenes": 2})


@pytest.mark.parametrize("joint", ["", "<freejoint/>"])
def test_a_rigid_body_is_a_part_if_its_file_lets_it_move(joint: str) -> None:
    Path("tool.xml").write_text(
        f'<mujoco><worldbody><body name="tool">{joint}<geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
    )
    document = scene(root=link("base", UPPER), attach={"tool": {"mjcf": "tool.xml", "to": "upper"}})
    assert codes(document) == (["SC337"] if joint else ["SC336"])


def test_parts_take_expressions_and_repetition() -> None:
    part = {
        "to": "${'upper' if reach > 1 else 'base'}",
        "pose": [0, 0, "${reach}"],
        "root": {"name": "palm", "shapes": [{"repeat": {"i": [-1, 1]}, **BOX, "pose": ["${i * reach}", 0, 0]}]},
    }
    document = {**scene(root=link("base", UPPER), attach={"hand": part}), "params": {"reach": 2}}
    (made,) = structures(compile_scene(document))
    palm = made.links[-1]
    assert palm.parent == 1
    assert palm.joint is not None
    assert palm.joint.pose_in_parent is not None
    assert palm.joint.pose_in_parent.numbers()[2] == 2
    assert [one.pose.numbers()[0] for one in palm.body.collisions if one.pose is not None] == [-2, 2]


def test_draws_of_a_part_are_known_by_its_place() -> None:
    part: Any = {"to": "upper", "root": link("palm", FINGER), "qpos": {"slide": {"uniform": [0, 0.1]}}}
    document = {**scene(root=link("base", UPPER), attach={"a": part, "b": copy.deepcopy(part)}), "num_scenes": 3}
    joints = {one.name: one for one in structures(compile_scene(document))[0].active_joints}
    rows = [tuple(qpos.data) for name in ("a/slide", "b/slide") if (qpos := joints[name].qpos) is not None]
    assert len(set(rows)) == 2
    with load_scene(document, render=False) as batch:
        arm = batch.articulations["arm"]
        before = arm.qpos.copy()
        batch.reset(seed=1)
        assert (arm.qpos[:, 1:] != before[:, 1:]).all()


@pytest.mark.parametrize(("count", "expected"), [(254, []), (255, ["SC519"]), (300, ["SC519"])])
def test_how_many_links_there_may_be(count: int, expected: list[str]) -> None:
    parts = {f"p{i}": {"to": "base", "root": {"name": "base"}} for i in range(count)}
    assert codes(scene(root=link("base"), attach=parts)) == expected


def test_objects_of_parts_are_counted() -> None:
    parts = {f"p{i}": {"to": "base", "root": link("base")} for i in range(5)}
    document = scene(root=link("base"), attach=parts)
    assert [one.code for one in validate(document, limits={"objects": 11})] == ["SC604"]
    assert codes(document) == []
