"""What a training loop reads of a batch, against what a person reads of the same scenes with SAPIEN alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fidelity.compare import STEPS
from fidelity.hand import built
from fidelity.hand_articulations import Case, by_hand, plan_of

from scenecc.backends.sapien import SceneBatch

LINKS = ["tip", "base", "lower"]


def find_arm(scene: Any) -> Any:
    (arm,) = scene.get_all_articulations()
    return arm


def body_names(contact: Any) -> tuple[str, str]:
    """As a batch calls the bodies of a contact by hand, whose links have no more than their own name."""
    first, second = (body.entity.name for body in contact.bodies)
    own = {"ground", "box"}
    return (first if first in own else f"arm/{first}", second if second in own else f"arm/{second}")


def assert_same_links(batch: SceneBatch, hand: list[Any]) -> None:
    arm = batch.articulations["arm"]
    for row, scene in enumerate(hand):
        for column, name in enumerate(LINKS):
            link = find_arm(scene).find_link_by_name(name)
            pose = link.entity.pose
            assert (arm.link_pose(LINKS)[row, column] == [*pose.p, *pose.q]).all()
            velocity = [*link.linear_velocity, *link.angular_velocity]
            assert (arm.link_velocity(LINKS)[row, column] == velocity).all()


def points_by_hand(scene: Any, name: str) -> list[tuple[Any, ...]]:
    """Position, normal, separation, impulse and names; of pairs that have this body (all for "") with it first."""
    order = ["ground", *(f"arm/{link.name}" for link in find_arm(scene).links), "box"]
    found = []
    for contact in scene.get_contacts():
        names = body_names(contact)
        on = [name in {body, body.split("/")[0]} for body in names]
        turned = order.index(names[0]) > order.index(names[1]) if on[0] == on[1] else on[1]
        if any(on) or not name:
            sign, pair = (-1, names[::-1]) if turned else (1, names)
            found += [
                (point.position, sign * point.normal, point.separation, sign * point.impulse, *pair)
                for point in contact.points
            ]
    return sorted(found, key=lambda row: (order.index(row[4]), order.index(row[5]), *row[0]))


def assert_same_contacts(batch: SceneBatch, hand: list[Any]) -> int:
    rows = [(index, *row) for index, scene in enumerate(hand) for row in points_by_hand(scene, "")]
    found = batch.contacts()
    assert len(found.scene) == len(rows)
    for number, row in enumerate(rows):
        for ours, theirs in zip(found, row, strict=True):
            assert np.array_equal(ours[number], theirs)
    return len(rows)


def force_by_hand(scene: Any, name: str) -> np.ndarray:
    """The sum of the impulses on `box`, `arm` or a link over the time step."""
    total = np.zeros(3)
    for _, _, _, impulse, a, b in points_by_hand(scene, name):
        if not (a.startswith("arm") and b.startswith("arm") and name == "arm"):
            total += impulse
    return (total / scene.timestep).astype(np.float32)


def test_links_contacts_and_forces_are_those_of_sapien_over_300_steps() -> None:
    batch, hand = built(plan_of(Case())), by_hand(Case())
    points, forces = 0, set()
    for _ in range(STEPS):
        batch.step()
        for scene in hand:
            scene.step()
        assert_same_links(batch, hand)
        points += assert_same_contacts(batch, hand)
        for name in ("box", "arm", "ground", "arm/tip", "arm/flap"):
            force = batch.net_contact_force(name)
            assert (force == [force_by_hand(scene, name) for scene in hand]).all()
            forces |= {name} if force.any() else set()
    assert points > STEPS
    assert forces >= {"box", "arm", "ground"}


def test_a_box_at_rest_is_held_by_its_weight() -> None:
    batch = built(plan_of(Case()))
    batch.step(1000)
    mass = batch.entities["box"].objs[0].components[0].mass  # pyright: ignore[reportAttributeAccessIssue]
    on_box, on_ground = batch.net_contact_force("box"), batch.net_contact_force("ground")
    assert on_box == pytest.approx(np.tile([0, 0, 9.81 * mass], (3, 1)), rel=1e-3, abs=1e-3 * mass)
    assert on_ground[:, 2] == pytest.approx(-on_box[:, 2] - batch.net_contact_force("arm")[:, 2], rel=1e-5)


def test_contacts_of_a_pair_are_turned_so_that_the_normal_is_from_b_to_a() -> None:
    batch = built(plan_of(Case()))
    batch.step(1000)
    one, other = batch.contacts("box", "ground"), batch.contacts("ground", "box")
    assert (one.normal[:, 2] > 0.99).all()
    assert len(one.scene) >= 9
    assert set(one.a) == set(other.b) == {"box"}
    for ours, theirs, sign in zip(one[:5], other[:5], (1, 1, -1, 1, -1), strict=True):
        assert (ours == sign * theirs).all()
    everything = batch.contacts("box")
    assert set(everything.a) == {"box"}
    assert (batch.contacts(b="ground").normal[:, 2] > 0.99).all()
    assert set(batch.contacts("arm/base").a) <= {"arm/base"}
