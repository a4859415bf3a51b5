"""MJCF files at random: trees of bodies with joints and geoms, turned in every way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st

Draw = st.DrawFn

_NUMBERS = st.integers(-2000, 2000).map(lambda n: n / 1000)
_SIZES = st.integers(1, 500).map(lambda n: n / 1000)
_ANGLES = st.integers(-1799, 1799).map(lambda n: n / 10)


def _text(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


@st.composite
def _vectors(draw: Draw) -> tuple[float, float, float]:
    """Vectors that are not short, and none that is close to an axis: there two rotations may differ by rounding."""
    found = np.array([draw(_NUMBERS) for _ in range(3)], np.float64)
    if np.linalg.norm(found) < 0.1:
        found = np.array([0.3, -0.4, 0.5])
    return (float(found[0]), float(found[1]), float(found[2]))


@st.composite
def _turns(draw: Draw, ways: Sequence[str]) -> str:
    way = draw(st.sampled_from(ways))
    vector = draw(_vectors())
    values: Sequence[float] = ()
    match way:
        case "quat":
            values = list(np.array([*vector, 0.25]) / np.linalg.norm([*vector, 0.25]))
        case "euler":
            values = [draw(_ANGLES) for _ in range(3)]
        case "axisangle":
            values = [*vector, draw(_ANGLES)]
        case "xyaxes":
            other = [vector[1], -vector[0], vector[2] + 0.5]
            values = [*vector, *other] if np.linalg.norm(np.cross(vector, other)) > 0.05 else ()
        case "zaxis":
            values = vector
    return f' {way}="{_text(values)}"' if len(values) else ""


@st.composite
def _geoms(draw: Draw, ways: Sequence[str]) -> str:
    kind = draw(st.sampled_from(["sphere", "box", "capsule", "cylinder", "between"]))
    size = [draw(_SIZES) for _ in range(3)]
    density = draw(st.sampled_from(["", ' density="55.5"', ' density="1e3"']))
    place = f' pos="{_text(draw(_vectors()))}"'
    if kind == "between":
        start, way = draw(_vectors()), draw(_vectors())
        ends = [*start, *np.add(start, way)]
        return f'<geom type="capsule" size="{size[0]}" fromto="{_text(ends)}"{density}/>'
    return f'<geom type="{kind}" size="{_text(size)}"{place}{draw(_turns(ways))}{density}/>'


@st.composite
def _joints(draw: Draw, name: str, *, degrees: bool) -> str:
    kind = draw(st.sampled_from(["hinge", "slide"]))
    low, high = sorted((draw(_NUMBERS), draw(_NUMBERS)))
    factor = 40 if degrees and kind == "hinge" else 1
    limits = draw(st.sampled_from(["", f' range="{low * factor!r} {(high + 0.001) * factor!r}"']))
    place = draw(st.sampled_from(["", f' pos="{_text(draw(_vectors()))}"']))
    damping = draw(st.sampled_from(["", ' damping="0.25"']))
    return f'<joint name="{name}" type="{kind}" axis="{_text(draw(_vectors()))}"{limits}{place}{damping}/>'


@st.composite
def _bodies(draw: Draw, name: str, ways: Sequence[str], depth: int, *, degrees: bool) -> str:
    count = draw(st.integers(0 if depth else 1, 3))
    joints = "".join(draw(_joints(f"{name}_j{i}", degrees=degrees)) for i in range(count))
    # MuJoCo asks for a mass of whatever moves.
    geoms = "".join(draw(_geoms(ways)) for _ in range(draw(st.integers(1, 2))))
    inner = ""
    if depth < 2:
        children = range(draw(st.integers(0, 2)))
        inner = "".join(draw(_bodies(f"{name}_{i}", ways, depth + 1, degrees=degrees)) for i in children)
    place = draw(st.sampled_from(["", f' pos="{_text(draw(_vectors()))}"']))
    return f'<body name="{name}"{place}{draw(_turns(ways))}>{joints}{geoms}{inner}</body>'


@st.composite
def mjcf_files(draw: Draw, ways: Sequence[str], sequences: Sequence[str]) -> str:
    """The text of a file.

    Args:
        draw: Hypothesis's.
        ways: in which bodies and geoms are turned.
        sequences: in which Euler angles are taken.
    """
    degrees = draw(st.booleans())
    compiler = f'<compiler angle="{"degree" if degrees else "radian"}" eulerseq="{draw(st.sampled_from(sequences))}"/>'
    bodies = "".join(draw(_bodies(f"b{i}", ways, 0, degrees=degrees)) for i in range(draw(st.integers(1, 2))))
    return f"<mujoco>{compiler}<worldbody>{bodies}{draw(_geoms(ways))}</worldbody></mujoco>"
