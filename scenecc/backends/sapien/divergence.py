"""Whether a simulation still means something: all that moves is finite, and near enough for single precision."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.backends.sapien.objects import ArticulationObjects, is_dynamic
from scenecc.diagnostics import Location
from scenecc.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.objects import BodyObjects
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan


DIVERGENCE_LIMIT: Final = 1e6
"""[m, m/s, rad, rad/s] Single precision tells 0.06 m apart there: no scene means that."""

_DIVERGENCE_HINT: Final = "a smaller `physics.timestep`, weaker drives, or masses that differ less may help"

CHECK_INTERVAL: Final = 10
"""Steps from one look to the next: a look costs as much as some steps."""


class _Divergence(NamedTuple):
    """A body, or a link of an articulation, that is not finite or beyond `DIVERGENCE_LIMIT`."""

    scene: int
    entity: str
    link: str
    finite: bool

    def __str__(self) -> str:
        what = f"link `{self.link}` of `{self.entity}`" if self.link else f"`{self.entity}`"
        return (
            f"{what} {'is beyond 1e6 m, m/s, rad or rad/s' if self.finite else 'is not finite'} in scene {self.scene}"
        )


def check_divergence(
    plan: ScenePlan, present: Iterable[BodyObjects | ArticulationObjects], steps: Mapping[int, int], sink: Sink
) -> None:
    """Looks at all that moves.

    Args:
        plan: where the entities were written.
        present: what is in the scenes now.
        steps: of each scene, how many were simulated.
        sink: is told what diverged.

    Raises:
        SceneError: something did.
    """
    found: list[_Divergence] = []
    for held in present:
        found += _diverged_links(held) if isinstance(held, ArticulationObjects) else _diverged_bodies(held)
    if not found:
        return
    first = min(found, key=lambda one: one.scene)
    others = len({one.scene for one in found}) - 1
    too = f", and others are in {others} more scene{'s' * (others > 1)}" if others else ""
    place = next(entity.origin for entity in plan.entities if entity.name == first.entity)
    sink.report("SC820", f"{first} by step {steps[first.scene]}{too}", place or Location(None), hint=_DIVERGENCE_HINT)
    raise SceneError(sink.diagnostics())


def _diverged_bodies(bodies: BodyObjects) -> list[_Divergence]:
    rows = [row for row, component in enumerate(bodies.components) if is_dynamic(component)]
    numbers = _body_motion([bodies.objs[row] for row in rows], [bodies.components[row] for row in rows])
    return [
        _Divergence(bodies.scene_idxs[rows[number]], bodies.name, "", fine)
        for number, fine in _rows_beyond_limit(numbers)
    ]


def _diverged_links(held: ArticulationObjects) -> list[_Divergence]:
    found: list[_Divergence] = []
    rows = [row for row in range(len(held.objs)) if held.in_scene(row)]
    links = [(row, link) for row in rows for link in held.links[row]]
    numbers = _body_motion([entity for row in rows for entity in held.entities[row]], [link for _, link in links])
    found += [_link_divergence(held, *links[number], finite=fine) for number, fine in _rows_beyond_limit(numbers)]
    joints = [(row, joint) for row in rows for joint in held.joints[row]]
    there = {one.scene for one in found}
    for number, fine in _rows_beyond_limit(_joint_motion([held.objs[row] for row in rows])):
        row, joint = joints[number]
        one = _link_divergence(held, row, joint.get_child_link(), finite=fine)
        if one.scene not in there:
            found.append(one)
    return found


def _link_divergence(held: ArticulationObjects, row: int, link: Any, *, finite: bool) -> _Divergence:
    return _Divergence(held.scene_idxs[row], held.name, link.get_name(), finite)


def _body_motion(entities: Sequence[Any], components: Sequence[Any]) -> NDArray[np.float32]:
    """(N, 13) poses and velocities."""
    velocities = [v for c in components for v in (c.get_linear_velocity(), c.get_angular_velocity())]
    pose = np.array([entity.get_pose().__getstate__() for entity in entities], np.float32).reshape(-1, 7)
    return np.hstack((pose, np.array(velocities, np.float32).reshape(-1, 6)))


def _joint_motion(objs: Sequence[Any]) -> NDArray[np.float32]:
    """(N, 2) positions and velocities of all joints that move."""
    numbers = [np.stack((obj.get_qpos(), obj.get_qvel()), axis=1) for obj in objs]
    return np.concatenate(numbers) if numbers else np.empty((0, 2), np.float32)


def _rows_beyond_limit(numbers: NDArray[np.float32]) -> list[tuple[int, bool]]:
    """The rows that hold a number which is not finite or too large, and whether all of their numbers are finite."""
    fine = (np.abs(numbers) <= DIVERGENCE_LIMIT).all(axis=1)  # no comparison holds for a number that is none
    return [(row, bool(np.isfinite(numbers[row]).all())) for row in np.flatnonzero(~fine).tolist()]
