"""Scopes of an SDF: worlds and models with their includes, and the frames in each namespace."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from scenecc.diagnostics.messages import suggest
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, invert
from scenecc.importers.numbers import Names
from scenecc.importers.sdf_files import SdfFile, SourceElement, find_included_model, read_sdf_file, text_of
from scenecc.importers.sdf_robots import robot_element
from scenecc.importers.urdf import ReadUrdf, read_repaired_urdf

WORLD = "world"
MODEL = "__model__"
SEPARATOR = "::"


@dataclass(slots=True)
class Scope:
    """A world or a model: the namespace of its links, joints, frames and nested models.

    Attributes:
        file: the file that contains it.
        element: its <world> or <model>.
        name: from its element, or from the <include> of its file.
        base: name of its own frame, `world` or `__model__`.
        placing: the element with its <pose>: itself or the <include>.
        placing_file: the file that contains `placing`.
        placement_frame: the model frame that the pose places; "" for its own frame.
        is_static: whether the model or one around it is static.
        is_merged: whether its names also belong to the enclosing scope.
        models: nested models, by name.
        missing: names of included models that are left out.
        robot: the URDF that it is; None for an SDF.
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
    robot: ReadUrdf | None = None
    models: dict[str, Scope] = field(default_factory=dict[str, "Scope"])
    missing: set[str] = field(default_factory=set[str])
    links: dict[str, SourceElement] = field(default_factory=dict[str, "SourceElement"])
    joints: dict[str, SourceElement] = field(default_factory=dict[str, "SourceElement"])
    frames: dict[str, SourceElement] = field(default_factory=dict[str, "SourceElement"])
    _poses: dict[str, Pose7 | None] = field(default_factory=dict[str, Pose7 | None])

    def pose_of(self, name: str, user: SourceElement) -> Pose7:
        """Returns the pose of a frame in the scope's own frame; the identity after an error at `user`."""
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
        """Returns the pose of an element in the scope's own frame. `default`: the frame if <pose> names none."""
        pose = element.find("pose")
        frame = default if pose is None else pose.attributes.get("relative_to", "") or default
        return compose(self.pose_of(frame, element), (file or self.file).pose(element))

    def model_pose(self, model: Scope) -> Pose7:
        """Returns the pose of a nested model's frame in the scope's own frame."""
        placed_pose = self.placed(model.placing, self.base, model.placing_file)
        if not model.placement_frame:
            return placed_pose
        return compose(placed_pose, invert(model.pose_of(model.placement_frame, model.placing)))

    def link_of(self, name: str, user: SourceElement, depth: int = 0) -> str | None:
        """Returns the path from this scope to the link that a frame is attached to; None after an error at `user`."""
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
            self._report_unknown(name, user)
            return None
        return self.link_of(target, user, depth + 1)

    def knows(self, name: str) -> bool:
        """Returns whether the scope has a frame of this name."""
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
        self._report_unknown(name, user)
        return IDENTITY_POSE

    def _report_unknown(self, name: str, user: SourceElement) -> None:
        if name.partition(SEPARATOR)[0] in self.missing:
            # The missing model is a loss already; so is everything attached to it.
            self.file.lose("joints", f"<{user.tag}> is attached to the missing model `{name}`", user)
            return
        known = [*self.links, *self.joints, *self.frames, *self.models]
        self.file.error(f"there is no frame or link `{name[:80]}` in `{self.name}`", user, hint=suggest(name, known))


_MAX_DEPTH: Final = 20
_MAX_INCLUDES: Final = 2000


class ScopeReader:
    """Reads scopes.

    Args:
        file: the file to import.
    """

    def __init__(self, file: SdfFile) -> None:
        self._top = file
        self._count = 0
        self._names: dict[int, Names] = {}

    def world(self, element: SourceElement) -> Scope:
        """Returns the scope of a <world>, or of an <sdf> without one."""
        file = self._top
        scope = Scope(file, element, element.attributes.get("name", "world"), WORLD, element, file)
        self._fill(scope, (file.path.resolve(),))
        return scope

    def _fill(self, scope: Scope, chain: tuple[Path, ...]) -> None:
        for child in scope.element.children:
            if child.tag == "include":
                self._include(child, scope, chain)
            elif child.tag == "model":
                self._add(self._model(child, scope), scope, chain)
            elif child.tag in {"link", "joint", "frame"}:
                table = {"link": scope.links, "joint": scope.joints, "frame": scope.frames}[child.tag]
                name = child.attributes.get("name", "")
                # Models flattened by older versions have links named `MODEL::LINK`.
                is_flat = scope.file.is_before(1, 8)
                if not name or name in table or (SEPARATOR in name and not is_flat):
                    what = "is used twice" if name in table else "is not a valid name"
                    scope.file.error(f"`{name[:80]}` {what}, in a <{child.tag}> of `{scope.name}`", child)
                    continue
                table[name] = child

    def _model(self, element: SourceElement, scope: Scope) -> Scope:
        name = element.attributes.get("name", "")
        is_static = scope.is_static or scope.file.flag(element, "static", default=False)
        frame = element.attributes.get("placement_frame", "")
        return Scope(scope.file, element, name, MODEL, element, scope.file, frame, is_static)

    def _robot(self, include: SourceElement, robot: ReadUrdf, scope: Scope) -> Scope:
        """Returns the scope of an included URDF, with its links and joints as elements at the <include>."""
        file, static = scope.file, scope.is_static or scope.file.flag(include, "static", default=False)
        merge, frame = include.attributes.get("merge") in {"true", "1"}, text_of(include, "placement_frame")
        element = robot_element(robot.robots, include)
        name = text_of(include, "name") or robot.name or robot.path.stem
        return Scope(file, element, name, MODEL, include, file, frame, static, merge, robot)

    def _add(self, model: Scope, scope: Scope, chain: tuple[Path, ...]) -> None:
        if not model.name or SEPARATOR in model.name or len(chain) > _MAX_DEPTH + 1:
            what = "is not a valid model name" if len(chain) <= _MAX_DEPTH + 1 else "is nested too deeply"
            scope.file.error(f"`{model.name[:80]}` {what}", model.placing)
            return
        if model.name in scope.models:
            # Drake and Gazebo refuse this, but worlds saved by older versions have it.
            names = self._names.setdefault(id(scope), Names())
            free = names.new(model.name)
            while free in scope.models:
                free = names.new(model.name)
            scope.file.lose("names", f"a second model `{model.name}` is renamed to `{free}`", model.placing)
            model = replace(model, name=free)
        scope.models[model.name] = model
        self._fill(model, chain)

    def _include(self, element: SourceElement, scope: Scope, chain: tuple[Path, ...]) -> None:
        self._count += 1
        uri, file = text_of(element, "uri"), scope.file
        for plugin in element.all("plugin"):
            file.lose("plugins", f"<plugin> `{plugin.attributes.get('filename', '')}` of an <include>", plugin)
        found = find_included_model(uri, file)
        if isinstance(found, str):
            file.lose("models", f"<include>: {found}", element)
            scope.missing.add(text_of(element, "name") or Path(uri).stem)
            return
        if found in chain or len(chain) > _MAX_DEPTH or self._count > _MAX_INCLUDES:
            why = "includes itself" if found in chain else "includes too many files"
            file.error(f"`{uri[:80]}` {why}", element)
            return
        if found.suffix.lower() == ".urdf":
            robot = read_repaired_urdf(found, file.context)
            if robot is not None:
                self._add(self._robot(element, robot, scope), scope, (*chain, found))
            return
        loaded = read_sdf_file(found, file.context, file.losses)
        if loaded is None:
            return
        inner, root = loaded
        models = list(root.all("model"))
        if len(models) != 1:
            kinds = ", ".join(dict.fromkeys(f"<{child.tag}>" for child in root.children)) or "nothing"
            file.lose("models", f"`{uri[:80]}` contains {kinds} instead of one model", element)
            return
        name = text_of(element, "name") or models[0].attributes.get("name", "")
        static = file.flag(element, "static", default=inner.flag(models[0], "static", default=False))
        posed = element.find("pose") is not None
        frame = text_of(element, "placement_frame") or models[0].attributes.get("placement_frame", "")
        self._add(
            Scope(
                inner,
                models[0],
                name,
                MODEL,
                element if posed else models[0],
                file if posed else inner,
                frame,
                scope.is_static or static,
                element.attributes.get("merge") in {"true", "1"},
            ),
            scope,
            (*chain, found),
        )
