"""The inputs: texts as people write them, always the same for the same size."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass

_HEAD = """\
# yaml-language-server: $schema=../schemas/scene.v1.schema.json
scenecc: 1
name: generated

materials:
  wood:
    physical: {static_friction: 0.6, dynamic_friction: 0.5, restitution: 0.1, density: 700}
    visual: {base_color: [0.62, 0.45, 0.26], roughness: 0.7}
  steel:
    physical: {static_friction: 0.4, dynamic_friction: 0.35, restitution: 0.2, density: 7800}
    visual: {base_color: [0.7, 0.7, 0.72], metallic: 1, roughness: 0.3}

entities:
"""

_ENTITY = """\
  box_{number:05d}:
    pose:
      p: [{p[0]:.4f}, {p[1]:.4f}, {p[2]:.4f}]
      rpy_deg: [0, 0, {yaw:.2f}]
    material: {material}
    linear_damping: {damping}
    sleep_threshold: 0.001
    shapes:
      - type: box
        half_size: [{half[0]:.4f}, {half[1]:.4f}, {half[2]:.4f}]
"""


@dataclass(frozen=True, slots=True)
class BoxNumbers:
    """One box: half sizes and position [m], turn about z [degrees]."""

    number: int
    half: tuple[float, float, float]
    p: tuple[float, float, float]
    yaw: float


def boxes(count: int, seed: int = 7) -> Iterator[BoxNumbers]:
    """Boxes on a grid, far enough apart not to touch, each of a size of its own."""
    draw = random.Random(seed)
    side = max(1, round(count**0.5))
    for number in range(count):
        x, y = 0.5 * (number % side), 0.5 * (number // side)
        half = tuple(round(draw.uniform(0.02, 0.2), 4) for _ in range(3))
        yield BoxNumbers(
            number,
            (half[0], half[1], half[2]),
            (x, y, round(draw.uniform(0.3, 2), 4)),
            round(draw.uniform(-180, 180), 2),
        )


def scene_text(count: int) -> str:
    """A scene file of `count` one-box entities in block style; vectors in brackets, as in `scenes/`."""
    entities = (
        _ENTITY.format(
            number=box.number,
            p=box.p,
            yaw=box.yaw,
            half=box.half,
            material=("wood", "steel")[box.number % 2],
            damping=(0.05, 0.1, 0.2)[box.number % 3],
        )
        for box in boxes(count)
    )
    return _HEAD + "".join(entities)


def plain_scene_text(count: int) -> str:
    """A scene file of `count` boxes with nothing but size and pose, as other simulators are given them."""
    entity = (
        "  box_{0.number:05d}:\n    pose: {{p: {p}, rpy_deg: [0, 0, {0.yaw}]}}\n"
        "    shapes:\n      - {{type: box, half_size: {half}}}\n"
    )
    return "scenecc: 1\nentities:\n" + "".join(entity.format(b, p=list(b.p), half=list(b.half)) for b in boxes(count))


def mjcf_text(count: int) -> str:
    """The same boxes as MuJoCo reads them."""
    body = (
        '<body name="box_{0.number:05d}" pos="{p}" euler="0 0 {0.yaw}"><freejoint/>'
        '<geom type="box" size="{half}" density="1000"/></body>\n'
    )
    bodies = "".join(body.format(b, p=_words(b.p), half=_words(b.half)) for b in boxes(count))
    return f'<mujoco><compiler angle="degree" eulerseq="xyz"/><worldbody>\n{bodies}</worldbody></mujoco>\n'


def _words(numbers: tuple[float, ...]) -> str:
    return " ".join(map(str, numbers))
