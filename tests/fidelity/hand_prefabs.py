"""What the prefabs that ship build, written by hand with `sapien.ActorBuilder` and nothing of ours.

A function tells a builder the shapes of one body. Sizes, places and colours are those of ManiSkill 3.0.1's convenience
builders (`mani_skill/utils/building/actors/common.py`, `ground.py`, `scene_builder/table`), of the tutorial's
`create_table`, and for the rest, which are our own, worked out shape by shape.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import sapien
from sapien import Pose, physx

UP = [0.7071068, 0, -0.7071068, 0]
"""Turns a plane's normal, which is x, up: ManiSkill's and `Scene.add_ground`'s."""

TARGET_RED = [194 / 255, 19 / 255, 22 / 255, 1]
RED, BLUE, GREEN = [220 / 255, 12 / 255, 12 / 255, 1], [0, 44 / 255, 193 / 255, 1], [17 / 255, 190 / 255, 70 / 255, 1]
WHITE = [1, 1, 1, 1]

TABLE_HEIGHT = 0.9196429
TABLE_MESH = "pkg://mani_skill/utils/scene_builder/table/assets/table.glb"

Color = Sequence[float]


@dataclass
class Seen:
    """A visual shape as it was asked for."""

    type: str
    pose: Any
    color: Color | None
    sizes: dict[str, Any] = field(default_factory=dict)


class Builder(sapien.ActorBuilder):
    """SAPIEN's builder, with a note of what is to be seen in place of materials, which need a device to render with.

    `render`: whether it is built as well.
    """

    def __init__(self, scene: Any, *, render: bool) -> None:
        super().__init__()
        self.set_scene(scene)
        self.seen: list[Seen] = []
        self._render = render

    def look(self, type_: str, pose: Any, color: Color, **sizes: Any) -> None:
        """A primitive that is seen; its material keeps the alpha of its colour, as a `RenderMaterial` does."""
        self.seen.append(Seen(type_, pose, color, sizes))
        if self._render:
            add: Callable[..., object] = getattr(self, f"add_{type_}_visual")
            add(pose, **sizes, material=sapien.render.RenderMaterial(base_color=[*color, 1][:4]))


def cube(b: Builder, *, half_size: float, color: Color, add_collision: bool = True) -> None:
    box(b, half_sizes=[half_size] * 3, color=color, add_collision=add_collision)


def box(b: Builder, *, half_sizes: Sequence[float], color: Color, add_collision: bool = True) -> None:
    if add_collision:
        b.add_box_collision(half_size=tuple(half_sizes))
    b.look("box", Pose(), color, half_size=tuple(half_sizes))


def sphere(b: Builder, *, radius: float, color: Color, add_collision: bool = True) -> None:
    if add_collision:
        b.add_sphere_collision(radius=radius)
    b.look("sphere", Pose(), color, radius=radius)


def cylinder(b: Builder, *, radius: float, half_length: float, color: Color, add_collision: bool = True) -> None:
    if add_collision:
        b.add_cylinder_collision(radius=radius, half_length=half_length)
    b.look("cylinder", Pose(), color, radius=radius, half_length=half_length)


def red_white_target(b: Builder, *, radius: float, thickness: float, add_collision: bool = True) -> None:
    rings = [
        (radius, thickness / 2, TARGET_RED),
        (radius * 4 / 5, thickness / 2 + 1e-5, WHITE),
        (radius * 3 / 5, thickness / 2 + 2e-5, TARGET_RED),
        (radius * 2 / 5, thickness / 2 + 3e-5, WHITE),
        (radius * 1 / 5, thickness / 2 + 4e-5, TARGET_RED),
    ]
    for across, half, color in rings:
        b.look("cylinder", Pose(), color, radius=across, half_length=half)
        if add_collision:
            b.add_cylinder_collision(radius=across, half_length=half)


def twocolor_peg(
    b: Builder, *, length: float, width: float, color_1: Color, color_2: Color, add_collision: bool = True
) -> None:
    if add_collision:
        b.add_box_collision(half_size=(length, width, width))
    b.look("box", Pose([-length / 2, 0, 0]), color_1, half_size=[length / 2, width, width])
    b.look("box", Pose([length / 2, 0, 0]), color_2, half_size=[length / 2, width, width])


def fourcolor_peg(
    b: Builder,
    *,
    length: float,
    width: float,
    color_1: Color = RED,
    color_2: Color = BLUE,
    color_3: Color = GREEN,
    color_4: Color = WHITE,
    add_collision: bool = True,
) -> None:
    if add_collision:
        b.add_box_collision(half_size=(length, width, width))
    for x, y, color in [(-1, -1, color_1), (1, -1, color_2), (-1, 1, color_3), (1, 1, color_4)]:
        pose = Pose([x * length / 2, y * width / 2, 0])
        b.look("box", pose, color, half_size=[length / 2, width / 2, width])


def colorful_cube(b: Builder, *, half_size: float, color: Color, add_collision: bool = True) -> None:
    if add_collision:
        material = physx.PhysxMaterial(static_friction=5, dynamic_friction=3, restitution=0)
        b.add_box_collision(half_size=(half_size,) * 3, material=material)
    b.look("box", Pose(), color, half_size=[half_size] * 3)


def ground(b: Builder, *, altitude: float = 0, add_collision: bool = True, **_: Any) -> None:
    """What collides; the floor that is seen is no primitive of the builder's."""
    if add_collision:
        b.add_plane_collision(Pose([0, 0, altitude], UP))


def solid(b: Builder, half_size: Sequence[float], at: Sequence[float], color: Color) -> None:
    b.add_box_collision(Pose(at), half_size=tuple(half_size))
    b.look("box", Pose(at), color, half_size=half_size)


def table(
    b: Builder, *, size: float = 1, height: float = 1, thickness: float = 0.1, color: Color = (0.8, 0.6, 0.4)
) -> None:
    """The tutorial's `create_table`."""
    solid(b, [size / 2, size / 2, thickness / 2], [0.0, 0.0, -thickness / 2], color)
    for i in [-1, 1]:
        for j in [-1, 1]:
            x, y = i * (size - thickness) / 2, j * (size - thickness) / 2
            solid(b, [thickness / 2, thickness / 2, height / 2], [x, y, -height / 2], color)


WORKSPACE_POSE = Pose([-0.12, 0, -TABLE_HEIGHT], [math.cos(math.pi / 4), 0, 0, math.sin(math.pi / 4)])


def workspace_table(
    b: Builder, *, color: Color = (0.3419144249086609, 0.1714411007328226, 0.05448027644244237)
) -> None:
    """ManiSkill's block; boxes in place of its mesh."""
    b.add_box_collision(Pose([0, 0, TABLE_HEIGHT / 2]), half_size=(2.418 / 2, 1.209 / 2, TABLE_HEIGHT / 2))
    b.look("box", Pose([0, 0, TABLE_HEIGHT - 0.02]), color, half_size=[2.418 / 2, 1.209 / 2, 0.02])
    for x in (-1.1, 1.1):
        for y in (-0.5, 0.5):
            leg = TABLE_HEIGHT / 2 - 0.02
            b.look("box", Pose([x, y, leg]), color, half_size=[0.04, 0.04, leg])


def bin_(b: Builder, *, length: float, width: float, height: float, thickness: float, color: Color) -> None:
    solid(b, [length / 2, width / 2, thickness / 2], [0, 0, thickness / 2], color)
    wall, middle = (height - thickness) / 2, (height + thickness) / 2
    for y in (-(width - thickness) / 2, (width - thickness) / 2):
        solid(b, [length / 2, thickness / 2, wall], [0, y, middle], color)
    for x in (-(length - thickness) / 2, (length - thickness) / 2):
        solid(b, [thickness / 2, width / 2 - thickness, wall], [x, 0, middle], color)


def shelf(
    b: Builder,
    *,
    width: float,
    depth: float,
    height: float,
    thickness: float,
    boards: int,
    color: Color,
    back: bool = True,
) -> None:
    for y in (-(width - thickness) / 2, (width - thickness) / 2):
        solid(b, [depth / 2, thickness / 2, height / 2], [0, y, height / 2], color)
    for board in range(boards):
        z = thickness / 2 + board * (height - thickness) / (boards - 1)
        solid(b, [depth / 2, width / 2 - thickness, thickness / 2], [0, 0, z], color)
    if back:
        solid(b, [thickness / 2, width / 2, height / 2], [-(depth + thickness) / 2, 0, height / 2], color)


def stairs(b: Builder, *, steps: int, rise: float, run: float, width: float, color: Color) -> None:
    for step in range(1, steps + 1):
        solid(b, [run / 2, width / 2, step * rise / 2], [(step - 0.5) * run, 0, step * rise / 2], color)


Hand = Callable[..., None]

HAND: dict[str, Hand] = {
    "cube": cube,
    "box": box,
    "sphere": sphere,
    "cylinder": cylinder,
    "red_white_target": red_white_target,
    "twocolor_peg": twocolor_peg,
    "fourcolor_peg": fourcolor_peg,
    "colorful_cube": colorful_cube,
    "table": table,
    "bin": bin_,
    "shelf": shelf,
    "stairs": stairs,
    "ground": ground,
}
"""Prefabs of one body, by name."""


def build(scene: Any, name: str, hand: Hand, body_type: str, pose: Any, *, render: bool, **params: Any) -> Builder:
    """One body by hand, in a scene; its builder."""
    builder = Builder(scene, render=render)
    hand(builder, **params)
    builder.set_physx_body_type(body_type)
    builder.initial_pose = pose
    builder.build(name=name)
    return builder
