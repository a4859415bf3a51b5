"""Tendons of joints that mimic others: over which links, and with which coefficients."""

from __future__ import annotations

import pytest

from scenecc.plan import ArticulationStructure, BodyStructure, Joint, Link, Mimic, constant
from scenecc.plan.articulation import TendonPull, tendon_coefficients, tendon_links, tendon_pull


def tree(*links: tuple[str, int | None, str]) -> ArticulationStructure:
    """Links by name, number of the parent, and type of the joint, which is called as the link."""
    return ArticulationStructure(
        tuple(
            Link(name, BodyStructure("link"), parent, None if parent is None else Joint(kind, name))  # pyright: ignore[reportArgumentType]
            for name, parent, kind in links
        )
    )


ROBOT = tree(
    ("base", None, ""),
    ("a", 0, "revolute"),
    ("b", 0, "prismatic"),
    ("a1", 1, "revolute_unwrapped"),
    ("a2", 3, "revolute"),
    ("b1", 2, "fixed"),
    ("b2", 5, "revolute"),
)


def mimic(joint: str, source: str) -> Mimic:
    return Mimic(joint, source, constant(1), constant(0))


@pytest.mark.parametrize(
    ("joint", "source", "links"),
    [
        ("b", "a", [0, 1, 2]),
        ("a", "b", [0, 2, 1]),
        ("a1", "a", [0, 1, 3]),
        ("a2", "a", [0, 1, 3, 4]),
        ("a2", "b", [0, 2, 1, 3, 4]),
        ("a2", "a1", [1, 3, 4]),
    ],
)
def test_a_tendon_hangs_on_the_nearest_link_above_both(joint: str, source: str, links: list[int]) -> None:
    assert list(tendon_links(ROBOT, mimic(joint, source))) == links


def test_what_lies_between_has_no_part_in_the_length() -> None:
    links = tendon_links(ROBOT, mimic("a2", "b"))
    assert tendon_coefficients(ROBOT, mimic("a2", "b"), links, TendonPull(-0.5, 1.0, 0.1)) == [0, -0.5, 0, 0, 1]


@pytest.mark.parametrize(("multiplier", "offset"), [(0.5, 0.1), (-1.0, 0.3), (1.0, 0.0), (-4.0, 0.2), (3.0, -0.6)])
def test_the_length_at_rest_is_the_mimic_and_no_coefficient_is_above_one(multiplier: float, offset: float) -> None:
    found = tendon_pull(multiplier, offset)
    for source in (-0.7, 0.0, 0.4):
        joint = multiplier * source + offset
        assert found.source * source + found.joint * joint == pytest.approx(found.rest_length)
    assert max(abs(found.source), abs(found.joint)) == 1


@pytest.mark.parametrize(
    ("joint", "source", "message"),
    [
        ("b2", "a", "the fixed joint 'b1' lies between them"),
        ("a", "b2", "the fixed joint 'b1' lies between them"),
        ("b1", "a", "joint 'b1' is fixed"),
        ("a", "a1", "'a1' is below it in the tree"),
        ("a", "a2", "'a2' is below it in the tree"),
        ("a", "none", "there is no joint 'none'"),
        ("a", "a", "joint 'a' cannot follow 'a': it is the same joint"),
    ],
)
def test_what_no_tendon_can_do(joint: str, source: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        tendon_links(ROBOT, mimic(joint, source))
