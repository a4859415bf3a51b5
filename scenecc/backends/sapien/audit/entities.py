"""Checks which entities each scene holds, in which order, and where."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.differences import AuditDifference, format_engine_numbers
from scenecc.backends.sapien.properties import select_rows
from scenecc.geometry.rotation_arrays import compose
from scenecc.plan.link_poses import step_poses, steps_across

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.preparation import EntityLookup, PreparedArticulation
    from scenecc.geometry.rotation_arrays import Floats
    from scenecc.plan import ArticulationStructure, Entity, Value
    from scenecc.plan.rendering import Camera, Light

LINK_TOLERANCE = 1e-5
"""Tolerance of a link's position, multiplied by its distance from the world's origin beyond 1 m: the engine chains
links in float32.
"""


@dataclass(frozen=True, slots=True)
class EntityBlock:
    """The entities of one item of the plan, in the order in which they were added to each scene.

    Attributes:
        item: the item.
        scene_idxs: (N,) the scene of each entity, as an index in the plan.
        objs: (N,) the `sapien.Entity`s.
        poses: (N, 7) float32, the planned poses.
        tolerances: (N,) of the poses; 0: bit-identical; infinite: the engine does not know them yet.
        links: (N,) names of the links; empty if the item is not an articulation.
    """

    item: Entity | Light | Camera
    scene_idxs: Sequence[int]
    objs: list[Any]
    poses: NDArray[np.float32]
    tolerances: NDArray[np.float64]
    links: tuple[str, ...] = ()

    def difference(self, number: int, what: str, expected: object, found: object) -> AuditDifference:
        """Returns a difference of one of the entities."""
        link = self.links[number] if self.links else ""
        return AuditDifference(self.item, what, expected, found, self.scene_idxs[number], link)


def plain_block(
    item: Entity | Light | Camera, scene_idxs: Sequence[int], rows: NDArray[np.intp], objs: list[Any]
) -> EntityBlock:
    """Makes a block of bodies, lights or cameras at their poses. `rows`: of the plan's values."""
    poses = np.empty((len(rows), 7), np.float32)
    poses[:] = select_rows(item.pose, rows)
    return EntityBlock(item, scene_idxs, objs, poses, np.zeros(len(rows)))


def articulation_block(prepared: PreparedArticulation, *, moved: bool) -> EntityBlock:
    """Makes a block of an articulation's links. `moved`: all links are at their poses, not only the root."""
    entity, counts = prepared.entity, np.array([len(links) for links in prepared.links], np.intp)
    starts = np.cumsum(counts) - counts
    poses, tolerances = np.empty((int(counts.sum()), 7), np.float32), np.empty(int(counts.sum()))
    names: dict[int, tuple[str, ...]] = {}
    for part in prepared.parts:
        names |= dict.fromkeys(part.numbers.tolist(), tuple(link.name for link in part.structure.links))
        tolerance = LINK_TOLERANCE * _center_of_mass_reach(prepared.links[int(part.numbers[0])])
        for which, rows in enumerate(_link_poses(entity, part.structure, part.rows)):
            places = starts[part.numbers] + which
            poses[places] = rows
            tolerances[places] = tolerance if moved or which == 0 else np.inf
    return EntityBlock(
        entity,
        np.repeat(prepared.scene_idxs, counts).tolist(),
        list(chain.from_iterable(prepared.entities)),
        poses,
        tolerances,
        tuple(chain.from_iterable(names[number] for number in range(len(counts)))),
    )


def _pose_rows(pose: Value, rows: NDArray[np.intp]) -> Floats:
    return np.broadcast_to(select_rows(pose, rows), (len(rows), 7))


def _center_of_mass_reach(links: Iterable[Any]) -> float:
    """Returns the largest distance of centres of mass from their links' frames [m]; at least 1.

    The engine computes with centres of mass, so poses of links and joints lose precision with this distance.
    """
    return max([1.0, *(float(np.abs(link.cmass_local_pose.p).max()) for link in links)])


def _link_poses(entity: Entity, structure: ArticulationStructure, rows: NDArray[np.intp]) -> list[Floats]:
    """Returns the poses (B, 7) of each link in the world of its scene, in the order of the plan."""
    found: list[Floats] = []
    for link in structure.links:
        if link.parent is None or link.joint is None:
            found.append(_normalize(_pose_rows(entity.pose, rows)))
            continue
        pose = found[link.parent]
        for step in steps_across(link.joint, entity.scene_idxs):
            data = select_rows(step.value, rows)
            pose = compose(pose, _normalize(step_poses(step, np.broadcast_to(data, (len(rows), *data.shape[1:])))))
        found.append(pose)
    return found


def _normalize(poses: Floats) -> Floats:
    """Returns poses with quaternions of unit length, as the engine stores them."""
    found = poses.copy()
    found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
    return found


def entity_differences(
    blocks: Sequence[EntityBlock], lookup: EntityLookup, *, shared: bool, poses: bool
) -> Iterator[AuditDifference]:
    """Yields differences in the entities of each scene, in build order and pose.

    `shared`: the scenes also hold other entities. `poses`: compare poses, if every scene has the right entities.
    """
    # Environments of ManiSkill may share one `sapien.Scene`.
    scenes = {id(scene): (index, scene) for index, scene in zip(lookup.scene_idxs, lookup.scenes, strict=True)}
    key_of = {index: id(scene) for index, scene in zip(lookup.scene_idxs, lookup.scenes, strict=True)}
    objs = [entity for block in blocks for entity in block.objs]
    rows_of: dict[int, list[int]] = {key: [] for key in scenes}
    for row, index in enumerate(chain.from_iterable(block.scene_idxs for block in blocks)):
        rows_of[key_of[index]].append(row)
    order: list[int] = []
    packed = [np.empty((0, 7), np.float32)]
    for key, (index, scene) in scenes.items():
        wanted, present = [objs[row] for row in rows_of[key]], scene.entities
        own: Any = slice(None)
        if shared:
            known = set(map(id, wanted))
            own = [place for place, entity in enumerate(present) if id(entity) in known]
            present = [present[place] for place in own]
        # Comparing lists checks identity first, which avoids a Python loop in the usual case.
        if wanted != present:
            poses = False
            yield _order_difference(blocks, wanted, present, index)
        order += rows_of[key]
        # SAPIEN packs q, then p, of each entity of a scene in the order in which they were added.
        packed.append(np.frombuffer(scene.pack_poses(), np.float32).reshape(-1, 7)[own])
    if poses:
        found = np.empty((len(objs), 7), np.float32)
        found[order] = np.concatenate(packed)[:, [4, 5, 6, 0, 1, 2, 3]]
        yield from _pose_differences(blocks, found)


def _order_difference(
    blocks: Sequence[EntityBlock], wanted: list[Any], present: list[Any], index: int
) -> AuditDifference:
    if len(wanted) != len(present):
        return AuditDifference(None, "entities in the scene", len(wanted), len(present), index)
    row = next(row for row, entity in enumerate(wanted) if entity is not present[row])
    block = next(block for block in blocks if wanted[row] in block.objs)
    number = block.objs.index(wanted[row])
    name, found = block.links[number] if block.links else block.item.name, present[row].name
    other = f"'{found}'" if found != name else f"another entity '{found}'"
    return block.difference(number, f"entity {row} of the build order", f"'{name}'", other)


def _pose_differences(blocks: Sequence[EntityBlock], found: NDArray[np.float32]) -> Iterator[AuditDifference]:
    """Yields differences in poses. `found`: (N, 7) of all entities, block by block."""
    wanted = np.concatenate([np.empty((0, 7), np.float32), *(block.poses for block in blocks)])
    wrong = (found != wanted).any(axis=1)
    if not wrong.any():
        return
    tolerances = np.concatenate([block.tolerances for block in blocks])
    # A rotation has two quaternions, and the engine may store either.
    sign = np.where((found[:, 3:] * wanted[:, 3:]).sum(axis=1) < 0, -1.0, 1.0)
    far = np.maximum(1.0, np.abs(wanted[:, :3]).max(axis=1))
    position = np.abs(found[:, :3] - wanted[:, :3]).max(axis=1)
    rotation = np.abs(found[:, 3:] - sign[:, None] * wanted[:, 3:]).max(axis=1)
    wrong &= (tolerances == 0) | ~(np.maximum(position, rotation) <= tolerances * far)
    places = [(block, number) for block in blocks for number in range(len(block.objs))]
    for row in np.flatnonzero(wrong).tolist():
        block, number = places[row]
        yield block.difference(number, "pose", format_engine_numbers(wanted[row]), format_engine_numbers(found[row]))
