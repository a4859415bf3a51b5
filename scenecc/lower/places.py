"""Where entities stand in the world: `relative_to` chains, composed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.lower.poses import IDENTITY_POSE, Pose7, compose, lower_pose
from scenecc.spec.errors import cut, suggest
from scenecc.spec.pose import PoseMapping

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.spec.body import Body, Frame

WORLD = "world"


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

    def world(self, name: str) -> Pose7:
        """The world pose of an entity or a frame; the identity where it was reported."""
        found = self._world.get(name)
        if found is not None:
            return found
        pose = self._placed[name].pose
        if not isinstance(pose, PoseMapping) or pose.relative_to is None:
            found = self._world[name] = lower_pose(pose, self.origin(name), ("pose",), self._sink)
            return found
        chain = self._chain(name)
        pose = IDENTITY_POSE
        for member in reversed(chain):
            known = self._world.get(member)
            pose = compose(pose, self._local(member)) if known is None else known
            self._world[member] = pose
        return pose

    def _chain(self, name: str) -> list[str]:
        """The entity, what it stands relative to, and so on outwards; cut where something was reported."""
        chain = [name]
        # A frame is wherever somebody stands relative to it, so it passes on whose scenes count.
        inner = name
        while (parent := self._parent(chain[-1])) is not None:
            if parent in chain:
                self._cycle(chain[chain.index(parent) :])
                break
            if not self._exists_wherever(inner, parent):
                break
            if self._sections[parent] == "entities":
                inner = parent
            chain.append(parent)
        return chain

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
            hint=suggest(str(parent), [other for other in self._placed if other != name]),
        )
        return None

    def _exists_wherever(self, name: str, parent: str) -> bool:
        """Whether the parent is in every scene that the child is in; frames are in all."""
        mine, others = self._selections.get(name), self._selections.get(parent)
        if mine is None or others is None or (missing := set(mine).difference(others)) == set():
            return True
        self._sink.report(
            "SC311",
            f"`{parent}` is not in scene {min(missing)}, where `{name}` stands relative to it",
            self.origin(name).child("pose", "relative_to"),
            related=[(f"where `{parent}` is", self.origin(parent).child("scene_idxs"), "value")],
        )
        return False

    def _cycle(self, members: list[str]) -> None:
        # One report for a cycle, at the member that stands first in the file.
        names = list(self._placed)
        start = members.index(min(members, key=names.index))
        ordered = members[start:] + members[:start]
        self._sink.report(
            "SC304",
            "poses stand relative to one another in a circle: " + " → ".join([*ordered, ordered[0]]),
            self.origin(ordered[0]).child("pose", "relative_to"),
            related=[("and here", self.origin(name).child("pose", "relative_to"), "value") for name in ordered[1:]],
        )

    def _local(self, name: str) -> Pose7:
        return lower_pose(self._placed[name].pose, self.origin(name), ("pose",), self._sink)

    def origin(self, name: str) -> Origin:
        """The node of an entity or a frame."""
        found = self._origins.get(name)
        if found is None:
            found = self._origins[name] = self._origin.child(self._sections[name], name)
        return found
