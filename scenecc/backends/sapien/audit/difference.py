"""How values are compared and how a difference is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.engine import sapien
from scenecc.diagnostics import Location

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin, Sink

CODE = "SC802"

ROTATION_TOLERANCE = 5e-7
"""PhysX normalises the quaternion of a shape's pose and of a centre of mass: a few units in the last place."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One property of one body that is not what the plan says.

    Attributes:
        what: the property, by the engine's name.
        expected, found: as they are shown to people.
        origin: the node that asked; None: the entity's own.
        code: of the diagnostic.
    """

    what: str
    expected: object
    found: object
    origin: Origin | None = None
    code: str = CODE


def tell(sink: Sink, difference: Difference, who: str, scene_idxs: Sequence[int], place: Origin | None) -> None:
    """Reports what differs, at the node that asked or else at `place`.

    Args:
        sink: takes it.
        difference: as seen in the first of the scenes.
        who: has it, in words.
        scene_idxs: where, ascending.
        place: of what has it.
    """
    more = f" (and in {len(scene_idxs) - 1} more)" if len(scene_idxs) > 1 else ""
    sink.report(
        difference.code,
        f"{who} in scene {scene_idxs[0]}{more}: the engine holds {difference.what} = {difference.found}, "
        f"and the plan asks for {difference.expected}",
        difference.origin or place or Location(None),
    )


def single(value: float) -> float:
    """Rounded to float32, as the engine gives it back."""
    return float(np.float32(value))


def same(expected: Any, found: object) -> bool:
    """Equal as the engine stores it: floats as float32, all others exactly."""
    if isinstance(found, (str, int)) or found is None:
        return bool(expected == found)
    if isinstance(found, float):
        return expected == found or bool(np.float32(expected) == np.float32(found))
    a, b = plain(expected), plain(found)
    return a.shape == b.shape and (a.tobytes() == b.tobytes() or bool((a == b).all()))


def same_local_pose(expected: NDArray[np.float64], found: sapien.Pose) -> bool:
    """Whether a pose that PhysX has normalised is the expected one (7,)."""
    actual = plain(found)
    if expected.astype(np.float32).tobytes() == actual.tobytes():
        return True
    if (expected[:3].astype(np.float32) != actual[:3]).any():
        return False
    unit = expected[3:] / np.linalg.norm(expected[3:])
    return bool(np.abs(unit - actual[3:]).max() <= ROTATION_TOLERANCE)


def plain(value: object) -> NDArray[Any]:
    """Numbers of the plan or of the engine as an array: float32, integers or booleans."""
    if isinstance(value, sapien.Pose):
        return np.array(pose_state(value), dtype=np.float32)
    array: NDArray[Any] = np.asarray(value)
    with np.errstate(over="ignore"):
        return array.astype(np.float32, copy=False) if array.dtype.kind == "f" else array


def pose_state(pose: sapien.Pose) -> tuple[float, ...]:
    """p, then q: the quickest way to all seven numbers."""
    engine_pose: Any = pose
    return engine_pose.__getstate__()


def shown(value: object) -> str:
    """As people read it."""
    if isinstance(value, str) or value is None:
        return repr(value)
    array = plain(value)
    if array.size > 8:
        return f"{array.shape} numbers"
    # numpy's own words for a float32 are the shortest that tell it from its neighbours.
    return "[" + ", ".join(map(str, array.ravel())) + "]" if array.ndim else str(array[()])
