"""A YAML document against SAPIEN as a person writes it, of the same ground, body and box that falls on it.

What is written by hand is plain `sapien.ActorBuilder` and components; nothing of ours.
"""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable
from typing import Any

from fidelity.compare import assert_same_scene, assert_same_trajectory

from scenecc import SceneBatch, load_scene

UP = [0.7071068, 0, -0.7071068, 0]
SCENES = 3

Hand = Callable[[Any], object]


def nothing(_: Any) -> None:
    """Where a person does nothing."""


def load(text: str, **options: Any) -> SceneBatch:
    """The live scenes of a document; its files are relative to the current folder."""
    return load_scene(io.StringIO(text), render=False, **options)


def document(body: str, rest: str = "") -> str:
    """A whole document around the keys of a body."""
    return (
        f"scenecc: 1\nnum_scenes: {SCENES}\n{textwrap.dedent(rest)}"
        "entities:\n"
        "  ground: {body_type: static, shapes: [{type: plane}]}\n"
        "  body:\n"
        "    pose: {p: [0.01, -0.02, 0.45], q: [0.9238795, 0.2209424, 0.2209424, 0.2209424]}\n"
        + textwrap.indent(textwrap.dedent(body).strip("\n"), "    ")
        + "\n  cap: {pose: [0.02, 0.01, 0.95], shapes: [{type: box, half_size: [0.05, 0.06, 0.07]}]}\n"
    )


def by_hand(builder: Hand, component: Hand = nothing, kind: str = "dynamic") -> Any:
    """One scene as a person would write it."""
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    # A builder that is told the name gives it to the component too; `add_ground` names the entity alone.
    scene.add_ground(0, render=False).components[0].name = "ground"

    actor = scene.create_actor_builder()
    actor.set_physx_body_type(kind)
    actor.initial_pose = sapien.Pose([0.01, -0.02, 0.45], [0.9238795, 0.2209424, 0.2209424, 0.2209424])
    builder(actor)
    component(actor.build(name="body").components[-1])

    cap = scene.create_actor_builder()
    cap.add_box_collision(half_size=[0.05, 0.06, 0.07])
    cap.initial_pose = sapien.Pose([0.02, 0.01, 0.95])
    cap.build(name="cap")
    return scene


def assert_same(batch: SceneBatch, hand: list[Any]) -> None:
    """The same scenes, before and through 300 steps."""
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)


def compare(body: str, builder: Hand, component: Hand = nothing, kind: str = "dynamic", rest: str = "") -> None:
    """The keys of a body against what a person does, the same in every scene."""
    compare_each(body, lambda b, _: builder(b), lambda c, _: component(c), kind, rest)


def compare_each(
    body: str,
    builder: Callable[[Any, int], object],
    component: Callable[[Any, int], object] = lambda component, scene: None,
    kind: str = "dynamic",
    rest: str = "",
) -> None:
    """The keys of a body against what a person does in the scene of an index."""

    def scene(index: int) -> Any:
        return by_hand(lambda b: builder(b, index), lambda c: component(c, index), kind)

    with load(document(body, rest)) as batch:
        assert_same(batch, [scene(index) for index in range(SCENES)])
