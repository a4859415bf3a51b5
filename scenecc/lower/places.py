"""Where entities stand in the world: `relative_to` chains, composed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.words import cut, suggest_name
from scenecc.lower.poses import IDENTITY_POSE, Pose7, compose, lower_pose
from scenecc.spec.pose import PoseMapping

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.spec.body import Body, Frame

WORLD = "world"

_SHOWN = 20
"""How many members of a circle are named."""


class Places:
    """World poses of the frames and entities of a document, composed in float64."""

    def __init__(
        self,
        frames: dict[str, Frame],
        entities: dict[str, Body],
        selections: dict[str, tuple[int, ...]],
        origin: Origin,
        sink: Sink,
    ) -> None:
        self._placed: dict[str, Frame | Body] = {**frames, **entities}
        self._sections = {**dict.fromkeys(entities, "entities"), **dict.fromkeys(frames, "frames")}
        self._selections = selections
        self._origin = origin
        self._sink = sink
        self._origins: dict[str, Origin] = {}
        self._world: dict[str, Pose7] = {}
        # For each that is placed: itself if it is an entity, else the first entity that the frame stands relative to.
        self._around: dict[str, str | None] = {}

    def world(self, name: str, owner: Origin) -> Pose7:
        """The world pose of an entity or a frame; the identity where it was reported. `owner`: its node."""
        pose = self._placed[name].pose
        if not isinstance(pose, PoseMapping) or pose.relative_to is None:
            # Most stand in the world, and few of these are asked for again.
            return lower_pose(pose, owner, ("pose",), self._sink)
        found = self._world.get(name)
        if found is not None:
            return found
        chain = self._chain(name)
        pose = self._world.get(chain[-1], IDENTITY_POSE)
        around: str | None = None
        for member in reversed(chain):
            if member in self._world:
                around = self._around[member]
                continue
            pose = self._world[member] = compose(pose, self._local(member))
            # A frame is wherever somebody stands relative to it, so it passes on whose scenes count.
            if self._sections[member] == "entities":
                if around is not None:
                    self._exists_wherever(member, around)
                around = member
            self._around[member] = around
        return pose

    def _chain(self, name: str) -> list[str]:
        """What is not placed yet, from the name outwards, and the first that is; cut where something was reported."""
        chain = {name: None}
        outermost = name
        while outermost not in self._world and (parent := self._parent(outermost)) is not None:
            if parent in chain:
                members = list(chain)
                self._cycle(members[members.index(parent) :])
                break
            chain[parent] = None
            outermost = parent
        return list(chain)

    def _parent(self, name: str) -> str | None:
        pose = self._placed[name].pose
        if not isinstance(pose, PoseMapping) or pose.relative_to in (None, WORLD):
            return None
        parent = pose.relative_to
        if parent in self._placed:
            return parent
        self._sink.report(
            "SC303",
            f"there is no entity or frame `{cut(parent)}`",
            self.origin(name).child("pose", "relative_to"),
            hint=suggest_name(str(parent), (other for other in self._placed if other != name), self._sink),
        )
        return None

    def _exists_wherever(self, name: str, parent: str) -> None:
        """Reports a scene that the one entity is in and the other is not."""
        mine, others = self._selections.get(name), self._selections.get(parent)
        if mine is others or mine is None or others is None or not (missing := set(mine).difference(others)):
            return
        self._sink.report(
            "SC311",
            f"`{parent}` is not in scene {min(missing)}, where `{name}` stands relative to it",
            self.origin(name).child("pose", "relative_to"),
            related=[(f"where `{parent}` is", self.origin(parent).child("scene_idxs"), "value")],
        )

    def _cycle(self, members: list[str]) -> None:
        # One report for a cycle, at the member that stands first in the file.
        rank = {name: i for i, name in enumerate(self._placed)}
        start = members.index(min(members, key=rank.__getitem__))
        ordered = members[start:] + members[:start]
        shown = [*ordered[:_SHOWN], "…"] if len(ordered) > _SHOWN else ordered
        self._sink.report(
            "SC304",
            "poses stand relative to one another in a circle: " + " → ".join([*map(cut, shown), cut(ordered[0])]),
            self.origin(ordered[0]).child("pose", "relative_to"),
            related=[
                ("and here", self.origin(name).child("pose", "relative_to"), "value") for name in ordered[1:_SHOWN]
            ],
        )

    def _local(self, name: str) -> Pose7:
        return lower_pose(self._placed[name].pose, self.origin(name), ("pose",), self._sink)

    def origin(self, name: str) -> Origin:
        """The node of an entity or a frame."""
        found = self._origins.get(name)
        if found is None:
            found = self._origins[name] = self._origin.child(self._sections[name], name)
        return found
