"""What a script says of articulations, and what it cannot."""

from __future__ import annotations

import ast
import dataclasses
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.plan_parts import ROOT, pose
from plugins.robot_plans import arm, crawler, linked, robots

from scenecc.diagnostics import Sink
from scenecc.emit import emit
from scenecc.emit.python.articulations import ARTICULATION_PROPERTIES, engine_order
from scenecc.plan import ArticulationStructure, Box, CollisionShape, Entity, Joint, Link, Mimic, constant, literal
from scenecc.plan.articulation import VELOCITY_FIELDS
from scenecc.plan.body import AssetFile
from scenecc.plan.properties import property_fields

ARM = arm(ids=constant([1, 1, 0, 0], np.int64), start=literal(0.3))


def written(structure: ArticulationStructure, **more: Any) -> tuple[str | None, list[str]]:
    """The script of one articulation in one scene, and the messages of what it cannot say."""
    entity = Entity("robot", (0,), pose(0, 0, 0), (structure,), **more)
    sink = Sink()
    plan = dataclasses.replace(robots(), num_scenes=1, entities=(entity,))
    text = emit(plan, "python", sink)
    assert {found.code for found in sink.diagnostics()} <= {"SC720"}
    return text, [found.message for found in sink.diagnostics()]


def with_joint(number: int, **changed: Any) -> ArticulationStructure:
    links = list(ARM.links)
    joint = links[number].joint
    assert joint is not None
    links[number] = dataclasses.replace(links[number], joint=dataclasses.replace(joint, **changed))
    return dataclasses.replace(ARM, links=tuple(links))


def test_a_script_drops_no_field_of_a_joint_or_articulation() -> None:
    full = with_joint(
        2,
        drive_mode="acceleration",
        qvel=literal(0.1),
        drive_velocity_target=literal(0.2),
        stiffness=literal(1),
        damping=literal(2),
        force_limit=literal(3),
    )
    joint = full.links[2].joint
    assert joint is not None
    names = [item.name for item in dataclasses.fields(Joint) if item.default is None and item.compare]
    assert all(getattr(joint, name) is not None for name in names)
    links = full.links

    def without(name: str) -> ArticulationStructure:
        changed = dataclasses.replace(links[2], joint=dataclasses.replace(joint, **{name: None}))
        return dataclasses.replace(full, links=(*links[:2], changed, *links[3:]))

    texts = [written(structure)[0] for structure in (full, *map(without, names))]
    assert len(set(texts)) == len(texts)
    whole = dataclasses.replace(crawler(), solver_position_iterations=literal(3, "int64"))
    some = [dataclasses.replace(whole, **{name: None}) for name in (*ARTICULATION_PROPERTIES, *VELOCITY_FIELDS)]
    assert len({written(structure)[0] for structure in (whole, *some)}) == len(some) + 1
    assert set(property_fields("joint")) <= set(names)


@pytest.mark.parametrize(
    ("structure", "words"),
    [
        (dataclasses.replace(crawler(), fix_root_link=True), "a fixed root has no `linear_velocity`"),
        (dataclasses.replace(ARM, mimics=(Mimic("left slide", "elbow", literal(1), literal(0)),)), "fixed joint"),
        (
            ArticulationStructure((Link("only", linked(sleep_threshold=literal(1))),)),
            "a body of type link without visuals has no `sleep_threshold`",
        ),
    ],
    ids=["root", "mimic", "link"],
)
def test_unsupported_articulation_fields_are_an_error_in_a_script(structure: ArticulationStructure, words: str) -> None:
    text, messages = written(structure)
    assert text is None
    assert any(words in message for message in messages)


def test_a_script_names_the_files_of_an_articulation_without_reading_them(tmp_path: Path) -> None:
    plan = robots()
    files = (*plan.files[:2], AssetFile("robots/arm.urdf", tmp_path / "gone.urdf"))
    text = emit(dataclasses.replace(plan, files=files), "python", Sink())
    assert text is not None
    assert "    # From robots/arm.urdf.\n" in text
    assert text.count("arm.urdf") == text.count("    # From robots/arm.urdf.\n")


def test_a_script_comments_on_hidden_entities() -> None:
    text, _ = written(ARM, hidden=True)
    assert text is not None
    assert "# Hidden from sensors" in text
    assert "# Hidden from sensors" not in (written(ARM)[0] or "")


def test_hostile_names_are_only_ever_strings() -> None:
    name = "'); import os; os.system('true')  #"
    links = (
        dataclasses.replace(ARM.links[0], name=name),
        Link("arm", linked(), 0, Joint("revolute", name, friction=literal(1), qpos=literal(0))),
        Link("\n", linked(), 0, Joint("revolute", "\n", friction=literal(1), qpos=literal(0))),
    )
    text, _ = written(ArticulationStructure(links, mimics=(Mimic("\n", name, literal(1), literal(0)),)))
    tree = ast.parse(text or "")
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id == "os"]
    assert name in {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}


@pytest.mark.parametrize("seed", range(20))
def test_a_script_has_joints_in_the_engines_order(seed: int) -> None:
    import sapien
    from sapien import physx

    draw = random.Random(seed)
    body = linked(CollisionShape(Box(constant([0.1, 0.1, 0.1]))))
    links = [Link("0", body)]
    for number in range(1, draw.randint(2, 20)):
        joint = Joint(draw.choice(["fixed", "revolute", "prismatic"]), str(number), pose(0.1, 0, 0))
        links.append(Link(str(number), body, draw.randrange(number), joint))
    structure = ArticulationStructure(tuple(links), fix_root_link=True)
    text, _ = written(structure)
    scope: dict[str, Any] = {"__name__": "script", "__file__": str(ROOT / "script.py")}
    exec(text or "", scope)
    (scene,) = scope["build_scenes"]()
    assert isinstance(scene, sapien.Scene)
    link = scene.entities[0].find_component_by_type(physx.PhysxArticulationLinkComponent)
    assert isinstance(link, physx.PhysxArticulationLinkComponent)
    assert [joint.name for joint in link.articulation.active_joints] == [link.name for link in engine_order(structure)]


def test_more_links_than_physx_supports_are_an_error_in_a_script() -> None:
    def chain(count: int) -> ArticulationStructure:
        below = (Link(f"l{n}", ARM.links[0].body, n - 1, Joint("fixed")) for n in range(1, count))
        return ArticulationStructure((Link("l0", ARM.links[0].body), *below))

    assert written(chain(255))[1] == []
    text, messages = written(chain(256))
    assert text is None
    assert messages == ["`robot`: an articulation has 256 links; PhysX on the CPU supports at most 255"]
