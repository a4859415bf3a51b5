"""Frames of SDF: poses relative to named frames, and the links that frames are attached to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, invert

if TYPE_CHECKING:
    from scenecc.importers.sdf_xml import SdfFile, SourceElement

WORLD = "world"
MODEL = "__model__"
SEPARATOR = "::"


@dataclass(slots=True)
class Scope:
    """A world or a model: the namespace of its links, joints, frames and nested models.

    Attributes:
        file: in which it is written.
        element: its <world> or <model>.
        name: as given by its element or by the <include> that names its file.
        base: the name of its own frame, `world` or `__model__`.
        placing: the element that holds its <pose>: itself or the <include>.
        placing_file: in which that is written.
        placement_frame: the frame of the model that stands at its pose; "" for its own frame.
        is_static: whether the model or one around it is static.
        is_merged: whether its names belong to the scope around it too.
        models: nested models, by name.
        missing: names of included models that are left out.
        links, joints, frames: elements by name.
    """

    file: SdfFile
    element: SourceElement
    name: str
    base: str
    placing: SourceElement
    placing_file: SdfFile
    placement_frame: str = ""
    is_static: bool = False
    is_merged: bool = False
    models: dict[str, Scope] = field(default_factory=dict[str, "Scope"])
    missing: set[str] = field(default_factory=set[str])
    links: dict[str, SourceElement] = field(default_factory=dict[str, "SourceElement"])
    joints: dict[str, SourceElement] = field(default_factory=dict[str, "SourceElement"])
    frames: dict[str, SourceElement] = field(default_factory=dict[str, "SourceElement"])
    _poses: dict[str, Pose7 | None] = field(default_factory=dict[str, Pose7 | None])

    def pose_of(self, name: str, user: SourceElement) -> Pose7:
        """The pose of a frame in the scope's own frame; the identity after an error at `user`."""
        if name in {"", self.base}:
            return IDENTITY_POSE
        if name not in self._poses:
            self._poses[name] = None
            self._poses[name] = self._resolve(name, user)
        found = self._poses[name]
        if found is None:
            self.file.error(f"the frame `{name}` is relative to itself", user)
            return IDENTITY_POSE
        return found

    def placed(self, element: SourceElement, default: str, file: SdfFile | None = None) -> Pose7:
        """The pose of an element, in the scope's own frame. `default`: the frame where <pose> names none."""
        pose = element.find("pose")
        frame = default if pose is None else pose.attributes.get("relative_to", "") or default
        return compose(self.pose_of(frame, element), (file or self.file).pose(element))

    def model_pose(self, model: Scope) -> Pose7:
        """The pose of a nested model's frame in the scope's own frame."""
        stands = self.placed(model.placing, self.base, model.placing_file)
        if not model.placement_frame:
            return stands
        return compose(stands, invert(model.pose_of(model.placement_frame, model.placing)))

    def link_of(self, name: str, user: SourceElement, depth: int = 0) -> str | None:
        """The path of the link that a frame is attached to, from this scope; None after an error at `user`."""
        if name in self.links:
            return name
        head, _, rest = name.partition(SEPARATOR)
        if rest and head in self.models and name not in self.frames and name not in self.joints:
            found = self.models[head].link_of(rest, user, depth)
            return None if found is None else f"{head}{SEPARATOR}{found}"
        target = None
        if name in self.models:
            target = f"{name}{SEPARATOR}{MODEL}"
        elif name in {"", self.base}:
            target = self._canonical()
        elif name in self.joints:
            child = self.joints[name].find("child")
            target = None if child is None else child.text
        elif name in self.frames:
            target = self.frames[name].attributes.get("attached_to") or self.base
        else:
            merged = next((each for each in self.models.values() if each.is_merged and each.knows(name)), None)
            target = None if merged is None else f"{merged.name}{SEPARATOR}{name}"
        if target is None or depth > len(self.joints) + len(self.frames) + len(self.models) + 10:
            self._unknown(name, user)
            return None
        return self.link_of(target, user, depth + 1)

    def knows(self, name: str) -> bool:
        """Whether the scope has a frame of that name."""
        head, _, rest = name.partition(SEPARATOR)
        if rest:
            return head in self.models and self.models[head].knows(rest)
        return name in {"", self.base} or any(
            name in table for table in (self.links, self.joints, self.frames, self.models)
        )

    def _canonical(self) -> str | None:
        named = self.element.attributes.get("canonical_link")
        first = named or next(iter(self.links), None)
        nested = next(iter(self.models), None)
        return first or (None if nested is None else f"{nested}{SEPARATOR}{MODEL}")

    def _resolve(self, name: str, user: SourceElement) -> Pose7 | None:
        if name in self.links:
            return self.placed(self.links[name], self.base)
        if name in self.joints:
            child = self.joints[name].find("child")
            return self.placed(self.joints[name], self.base if child is None else child.text)
        if name in self.frames:
            return self.placed(self.frames[name], self.frames[name].attributes.get("attached_to") or self.base)
        head, _, rest = name.partition(SEPARATOR)
        if head in self.models:
            model = self.models[head]
            pose = self.model_pose(model)
            return compose(pose, model.pose_of(rest, user)) if rest else pose
        merged = next((each for each in self.models.values() if each.is_merged and each.knows(name)), None)
        if merged is not None:
            return compose(self.model_pose(merged), merged.pose_of(name, user))
        self._unknown(name, user)
        return IDENTITY_POSE

    def _unknown(self, name: str, user: SourceElement) -> None:
        if name.partition(SEPARATOR)[0] in self.missing:
            # Which is a loss already, and so is what hangs on it.
            self.file.lose("joints", f"<{user.tag}> is attached to the missing model `{name}`", user)
            return
        known = [*self.links, *self.joints, *self.frames, *self.models]
        listed = ", ".join(f"`{each}`" for each in known[:8]) or "none"
        self.file.error(f"there is no frame or link `{name[:80]}` in `{self.name}`", user, hint=f"it has {listed}")
