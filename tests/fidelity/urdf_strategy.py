"""Random URDFs that both SAPIEN's loader and the reader take."""

from __future__ import annotations

import numpy as np
from fidelity.urdf_cases import joint, robot
from hypothesis import strategies as st

NUMBERS = st.one_of(
    st.floats(-3, 3, allow_subnormal=False), st.integers(-2, 2).map(float), st.sampled_from([np.pi / 2, -np.pi / 2])
)
SIZES = st.floats(1e-3, 2)


def _triple(draw: st.DrawFn, numbers: st.SearchStrategy[float] = NUMBERS) -> str:
    return " ".join(repr(float(draw(numbers))) for _ in range(3))


def _origin(draw: st.DrawFn) -> str:
    xyz = f' xyz="{_triple(draw)}"' if draw(st.booleans()) else ""
    rpy = f' rpy="{_triple(draw)}"' if draw(st.booleans()) else ""
    return f"<origin{xyz}{rpy}/>"


def _geometry(draw: st.DrawFn) -> str:
    kind = draw(st.sampled_from(["box", "sphere", "capsule", "cylinder"]))
    if kind == "box":
        return f'<box size="{_triple(draw, SIZES)}"/>'
    length = "" if kind == "sphere" else f' length="{draw(SIZES)!r}"'
    return f'<{kind} radius="{draw(SIZES)!r}"{length}/>'


def _inertial(draw: st.DrawFn) -> str:
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    axes, _ = np.linalg.qr(generator.normal(size=(3, 3)))
    moments = generator.uniform(1, 1.9, 3) * 10.0 ** generator.integers(-6, 2)
    tensor = axes @ np.diag(moments) @ axes.T if draw(st.booleans()) else np.diag(moments)
    places = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
    values = " ".join(f'{name}="{float(tensor[place])!r}"' for name, place in places.items())
    return f'<inertial>{_origin(draw)}<mass value="{draw(SIZES)!r}"/><inertia {values}/></inertial>'


@st.composite
def urdfs(draw: st.DrawFn) -> str:
    """A URDF of up to seven links in any tree."""
    count = draw(st.integers(1, 7))
    content = ""
    for index in range(count):
        inner = _inertial(draw) if draw(st.booleans()) else ""
        for tag in draw(st.lists(st.sampled_from(["visual", "collision"]), max_size=3)):
            inner += f"<{tag}>{_origin(draw)}<geometry>{_geometry(draw)}</geometry></{tag}>"
        content += f'<link name="l{index}">{inner}</link>'
    for index in draw(st.permutations(range(1, count))):
        kind = draw(st.sampled_from(["fixed", "revolute", "continuous", "prismatic"]))
        low, high = sorted((draw(NUMBERS), draw(NUMBERS)))
        inner = f'{_origin(draw)}<axis xyz="{_triple(draw)}"/><limit lower="{low!r}" upper="{high!r}"/>'
        parent = draw(st.integers(0, index - 1))
        content += joint(f"j{index}", kind, f"l{parent}", f"l{index}", inner)
    return robot(content)
