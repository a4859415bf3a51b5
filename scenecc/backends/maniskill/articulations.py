"""Articulations of the plan as ManiSkill's, through its own builder, which its loaders of URDF and MJCF use as well."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.backends.maniskill.actors import batched_pose
from scenecc.backends.maniskill.theirs import Articulation, ArticulationBuilder

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.backends.sapien.turn import ArticulationTurn


class PlannedArticulationBuilder(ArticulationBuilder):
    """ManiSkill's builder, whose links come from a turn of the plan, scene by scene.

    ManiSkill's `build` adds them to their sub-scenes and registers the articulation. Links, joints and mimics are made
    by the turn: ManiSkill's own have frictions that are dropped and mimics that mean something else.
    """

    def __init__(self, turn: ArticulationTurn, scene_idxs: Sequence[int]) -> None:
        super().__init__()  # pyright: ignore[reportUnknownMemberType]
        self._turn = turn
        self._waiting = list(scene_idxs)

    def _build_entities(
        self, fix_root_link: object = None, name_prefix: str = "", initial_pose: Any = None
    ) -> list[Any]:
        del fix_root_link  # the turn has it
        own = self._turn.table[self._waiting.pop(0)]
        assert own is not None
        builder, row = own
        entities, links = builder.make(row)
        for link in links:
            link.set_name(name_prefix + link.get_name())
            joint = link.get_joint()
            joint.set_name(name_prefix + joint.get_name())
        if initial_pose is not None:
            entities[0].set_pose(initial_pose)
        self._turn.entities.append(entities)
        self._turn.links.append(links)
        return entities


def build_articulation(turn: ArticulationTurn, scene: Any) -> Any:
    """One articulation of the plan in a `ManiSkillScene`, all of whose sub-scenes are among the turn's, by their index.

    Where the links are not the same in all of its scenes, each scene has one of its own, `NAME-INDEX`, and what is
    returned, and stands in the environment's state, is a view by `Articulation.merge`, in scene order.

    Raises:
        EngineFailure: the engine refuses a shape or a value.
    """
    name, pose = turn.entity.name, batched_pose(turn, scene)
    if len(turn.parts) == 1:
        return _built(turn, scene, name, turn.scene_idxs, pose)
    parts: list[Any] = []
    for number, index in enumerate(turn.scene_idxs):
        part = _built(turn, scene, f"{name}-{index}", (index,), pose if len(pose) == 1 else pose[number])
        scene.remove_from_state_dict_registry(part)
        parts.append(part)
    links = [[link.name for link in part.structure.links] for part in turn.parts]
    view = Articulation.merge(parts, name=name, merge_links=all(names == links[0] for names in links))
    view.initial_pose = pose
    scene.add_to_state_dict_registry(view)
    return view


def _built(turn: ArticulationTurn, scene: Any, name: str, scene_idxs: Sequence[int], pose: Any) -> Any:
    builder = PlannedArticulationBuilder(turn, scene_idxs)
    builder.set_scene(scene)
    builder.set_scene_idxs(list(scene_idxs))
    builder.initial_pose = pose
    before = len(turn.links)
    articulation = builder.build(name)
    for index, links in zip(scene_idxs, turn.links[before:], strict=True):
        turn.objs.append(_start(turn, links, index, f"scene-{index}_{name}", on_gpu=scene.gpu_sim_enabled))
    return articulation


def _start(turn: ArticulationTurn, links: list[Any], index: int, name: str, *, on_gpu: bool) -> Any:
    """Everything that ManiSkill's builder does not set; a GPU holds positions in buffers that are not there yet."""
    own = turn.table[index]
    assert own is not None
    builder, row = own
    articulation = builder.settle(links, row) if on_gpu else builder.start(links, row)
    articulation.set_name(name)
    return articulation
