"""Imports Drake's model directives (`.dmd.yaml`): models of other files, placed by frames and welds.

The models are read by the readers of their formats. As in Drake, all joints are at their default positions when models
are placed, and a weld to the world fixes a model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import cut, suggest
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose, invert
from scenecc.importers.dmd_transforms import read_transform, required_value
from scenecc.importers.imported_scene import ImportContext, ImportedScene, Loss
from scenecc.importers.mjcf import MJCF_LOSS_CODES
from scenecc.importers.model_files import ModelReader, NamedModel
from scenecc.importers.numbers import Names
from scenecc.importers.placed_entities import still_links
from scenecc.importers.sdf import SdfViews
from scenecc.importers.sdf_files import SdfFile, find_file
from scenecc.importers.sdf_scopes import SEPARATOR
from scenecc.importers.sdf_shapes import FRICTION
from scenecc.importers.urdf import URDF_LOSS_CODES
from scenecc.importers.writer import write_world
from scenecc.importers.yaml_values import ValueFault, YamlValue, read_yaml_value
from scenecc.robots.description import IN_WORLD, DescribedConstraint, LinkName
from scenecc.robots.world import DescribedPhysics, DescribedWorld, RobotFile

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_MAX_DEPTH: Final = 20

_MAX_FILES: Final = 500


@dataclass(frozen=True, slots=True)
class _Frame:
    """A frame: the link that carries it (or `IN_WORLD`), and its pose in the link."""

    link: LinkName
    pose: Pose7


@dataclass(frozen=True, slots=True)
class _Tie:
    """Places two models so that `child` is at `parent`. `welds`: whether it also holds them there."""

    parent: _Frame
    child: _Frame
    value: YamlValue
    welds: bool


def import_dmd(path: Path, context: ImportContext) -> ImportedScene | None:
    """Returns the scene of a file of model directives; after errors only its losses, or None."""
    found = context.resolve(path)
    if found is None:
        return None
    reader = _DirectivesReader(context)
    reader.read_file(found.path, str(path), "", ())
    if not context.sink.failed:
        reader.place()
    return reader.scene(path)


@dataclass(slots=True)
class _Scope:
    """A file of directives. `namespace`: prefix of its names, with its separator, or ""."""

    file: SdfFile
    namespace: str
    chain: tuple[Path, ...]

    def full(self, name: str) -> str:
        """Returns a name with its namespace."""
        return name if name == "world" else self.namespace + name


class _DirectivesReader:
    def __init__(self, context: ImportContext) -> None:
        self._context = context
        self._losses: list[Loss] = []
        self._models: dict[str, NamedModel] = {}
        self._missing: set[str] = set()
        self._instances: set[str] = set()
        self._frames: dict[str, _Frame] = {}
        self._ties: list[_Tie] = []
        self._groups: dict[str, set[LinkName]] = {}
        self._ignored: list[tuple[str, str, YamlValue]] = []
        self._count = 0
        self._reader = ModelReader(context, self._losses)
        self._read: dict[str, Callable[[YamlValue, _Scope], None]] = {
            "add_model": self._add_model,
            "add_model_instance": self._add_instance,
            "add_frame": self._add_frame,
            "add_weld": self._add_weld,
            "add_collision_filter_group": self._add_group,
            "add_directives": self._add_directives,
        }

    def read_file(self, path: Path, shown: str, namespace: str, chain: tuple[Path, ...]) -> None:
        """Reads the directives of a file in order; each that is invalid is reported."""
        top = read_yaml_value(path, shown, self._context)
        if top is None:
            return
        scope = _Scope(SdfFile(self._context, path, self._losses), namespace, (*chain, path))
        try:
            items = required_value(top, top.entries("directives"), "directives").items()
        except ValueFault as fault:
            hint = fault.hint or "a file of Drake's model directives starts with `directives:`"
            self._context.sink.report("SC433", fault.message, fault.place, hint=hint)
            return
        for item in items:
            self._read_directive(item, scope)

    def _read_directive(self, item: YamlValue, scope: _Scope) -> None:
        try:
            entries = item.entries(*self._read)
            if len(entries) != 1:
                raise item.fault("{} must be one directive, such as `add_model`")
            ((name, value),) = entries.items()
            self._read[name](value, scope)
        except ValueFault as fault:
            fault.report(self._context.sink, self._losses)

    def _add_model(self, value: YamlValue, scope: _Scope) -> None:
        known = ("name", "file", "default_joint_positions", "default_free_body_pose")
        keys = value.entries(*known)
        name, uri = scope.full(required_value(value, keys, "name").text()), required_value(value, keys, "file")
        if name in self._models or name in self._instances or name in self._missing or name == "world":
            raise keys["name"].fault(f"a second model has the name `{cut(name)}`")
        self._count += 1
        if self._count > _MAX_FILES:
            raise value.fault(f"more than {_MAX_FILES} models")
        self._missing.add(name)
        model = self._reader.read(name, uri, scope.file)
        if model is None:
            return
        self._missing.discard(name)
        self._models[name] = model
        positions, poses = (keys[key].entries() if key in keys else {} for key in known[2:])
        for joint, row in positions.items():
            if items := row.items():
                self._reader.set_joint(model, joint, row, row.numbers(len(items)))
        for frame, row in poses.items():
            base, pose = read_transform(row)
            parent = self._frame("world" if base is None else base.text(), base or row, scope)
            child = self._frame_of(model, frame, row)
            if child.pose == IDENTITY_POSE and not self._reader.placed.is_root(child.link):
                words = f"the free pose of `{cut(frame)}`, which a joint carries and Drake does not move"
                self._losses.append(Loss("settings", words, row.location))
                continue
            self._ties.append(_Tie(_Frame(parent.link, compose(parent.pose, pose)), child, row, welds=False))

    def _add_instance(self, value: YamlValue, scope: _Scope) -> None:
        keys = value.entries("name")
        self._instances.add(scope.full(required_value(value, keys, "name").text()))

    def _add_frame(self, value: YamlValue, scope: _Scope) -> None:
        keys = value.entries("name", "X_PF")
        name = scope.full(required_value(value, keys, "name").text())
        base, pose = read_transform(required_value(value, keys, "X_PF"))
        if base is None:
            raise keys["X_PF"].fault("{} needs a `base_frame`")
        if not self._knows(name):
            self._missing.add(name)
        owner = name.rpartition(SEPARATOR)[0]
        own = f"{owner}{SEPARATOR}{base.text()}"
        is_own = SEPARATOR not in base.text() and self._knows(own)
        parent = self._frame(own.removeprefix(scope.namespace) if is_own else base.text(), base, scope)
        if self._knows(name):
            raise keys["name"].fault(f"a second frame has the name `{cut(name)}`")
        self._missing.discard(name)
        frame = self._frames[name] = _Frame(parent.link, compose(parent.pose, pose))
        if name == scope.full(name.rpartition(SEPARATOR)[2]) and parent.link != IN_WORLD:
            # A frame without a model belongs to that of its base.
            self._frames.setdefault(
                f"{self._reader.model_of(parent.link)}{SEPARATOR}{name.rpartition(SEPARATOR)[2]}", frame
            )

    def _add_weld(self, value: YamlValue, scope: _Scope) -> None:
        keys = value.entries("parent", "child", "X_PC")
        ends = [required_value(value, keys, key) for key in ("parent", "child")]
        parent, child = (self._find_frame(end, scope) for end in ends)
        base, pose = read_transform(keys["X_PC"]) if "X_PC" in keys else (None, IDENTITY_POSE)
        if base is not None:
            raise base.fault("{} has no effect: `parent` is the base of a weld", "remove it")
        if parent is None or child is None:
            return
        if parent.link[0] == child.link[0]:
            raise value.fault("{} welds a model to itself")
        self._ties.append(_Tie(_Frame(parent.link, compose(parent.pose, pose)), child, value, welds=True))

    def _add_group(self, value: YamlValue, scope: _Scope) -> None:
        known = ("name", "members", "member_groups", "ignored_collision_filter_groups", "model_namespace")
        keys = value.entries(*known)
        if "model_namespace" in keys:
            scope = replace(scope, namespace=scope.full(keys["model_namespace"].text()) + SEPARATOR)
        name = scope.full(required_value(value, keys, "name").text())
        members, groups, others = (keys[key].items() if key in keys else [] for key in known[1:4])
        links = {frame.link for each in members if (frame := self._find_frame(each, scope))} - {IN_WORLD}
        self._groups[name] = links.union(*(self._group(scope.full(each.text()), each) for each in groups))
        self._ignored += [(name, scope.full(each.text()), each) for each in others]

    def _group(self, name: str, value: YamlValue) -> set[LinkName]:
        if name not in self._groups:
            raise value.fault(f"there is no collision filter group `{cut(name)}`", suggest(name, [*self._groups]))
        return self._groups[name]

    def _add_directives(self, value: YamlValue, scope: _Scope) -> None:
        keys = value.entries("file", "model_namespace")
        file, inner = required_value(value, keys, "file"), keys.get("model_namespace")
        namespace = scope.namespace if inner is None else scope.full(inner.text()) + SEPARATOR
        self._count += 1
        found = find_file(file.text(), scope.file)
        if isinstance(found, str):
            self._missing.add(namespace.removesuffix(SEPARATOR))
            raise file.fault(f"directives: {found}", loss="models")
        if found in scope.chain or len(scope.chain) > _MAX_DEPTH or self._count > _MAX_FILES:
            why = "adds itself" if found in scope.chain else "adds too many files"
            raise file.fault(f"`{cut(file.text())}` {why}")
        self.read_file(found, str(found), namespace, scope.chain)

    def _knows(self, name: str) -> bool:
        model, rest = self._owner(name)
        return name in self._frames or (model is not None and model.knows(rest))

    def _owner(self, name: str) -> tuple[NamedModel | None, str]:
        """Returns the model whose name begins a frame's name, and the rest of the name."""
        parts = name.split(SEPARATOR)
        for count in range(len(parts) - 1, 0, -1):
            model = self._models.get(SEPARATOR.join(parts[:count]))
            if model is not None:
                return model, SEPARATOR.join(parts[count:])
        return None, name

    def _find_frame(self, value: YamlValue, scope: _Scope) -> _Frame | None:
        """Returns the frame of this name; None if it is not found, which is reported."""
        try:
            return self._frame(value.text(), value, scope)
        except ValueFault as fault:
            fault.report(self._context.sink, self._losses)
            return None

    def _frame(self, name: str, value: YamlValue, scope: _Scope) -> _Frame:
        """Returns a frame by its name; one without a model must be the only one of this name."""
        if name == "world":
            return _Frame(IN_WORLD, IDENTITY_POSE)
        full = scope.full(name)
        if full in self._frames:
            return self._frames[full]
        model, rest = self._owner(full)
        if model is not None:
            return self._frame_of(model, rest, value)
        if SEPARATOR not in name:
            own = [*{frame for key, frame in self._frames.items() if key.rpartition(SEPARATOR)[2] == name}]
            holders = [model for model in self._models.values() if model.knows(name)]
            if len(own) + len(holders) > 1:
                raise value.fault(f"several models have a frame `{cut(name)}`", "write MODEL::FRAME")
            if own or holders:
                return own[0] if own else self._frame_of(holders[0], name, value)
        if any(f"{full}{SEPARATOR}".startswith(f"{each}{SEPARATOR}" if each else "") for each in self._missing):
            raise value.fault(f"`{cut(name)}` depends on a missing file or frame", loss="joints")
        raise value.fault(
            f"there is no frame `{cut(name)}`", suggest(full, ["world", *self._frames, *self._of_models()])
        )

    def _of_models(self) -> Iterator[str]:
        for model in self._models.values():
            yield from (f"{model.name}{SEPARATOR}{name}" for name in model.names())

    def _frame_of(self, model: NamedModel, name: str, value: YamlValue) -> _Frame:
        found = model.frame(name)
        if found is None:
            raise value.fault(f"`{cut(model.name)}` has no frame `{cut(name)}`", suggest(name, model.names()))
        return _Frame(*found)

    # --- placing

    def place(self) -> None:
        """Places the models along the ties, from the world outwards, and fixes or welds them."""
        pending, reader = list(self._ties), self._reader
        done = {IN_WORLD[0], *(entity.name for entity in reader.parts.entities if still_links(entity))}
        while pending:
            tie = next((one for one in pending if (one.parent.link[0] in done) != (one.child.link[0] in done)), None)
            for one in [one for one in pending if one.parent.link[0] in done and one.child.link[0] in done]:
                words = "{} moves a model that is placed already"
                one.value.fault(words, loss="" if one.welds else "settings").report(self._context.sink, self._losses)
                pending.remove(one)
            if tie is not None:
                self._join(tie, is_child_placed=tie.child.link[0] in done)
                pending.remove(tie)
                done |= {tie.parent.link[0], tie.child.link[0]}
            elif pending:
                moved = {one.child.link[0] for one in pending}
                roots = (one.parent.link[0] for one in pending if one.parent.link[0] not in moved)
                done.add(next(roots, pending[0].parent.link[0]))

    def _join(self, tie: _Tie, *, is_child_placed: bool) -> None:
        placed = self._reader.placed
        still, moved = (tie.child, tie.parent) if is_child_placed else (tie.parent, tie.child)
        target = compose(placed.pose_of(still.link), still.pose)
        placed.move(moved.link, compose(target, invert(compose(placed.pose_of(moved.link), moved.pose))))
        if not tie.welds:
            return
        if placed.is_still(still.link) and placed.is_root(moved.link):
            placed.fix(moved.link)
            return
        pose = compose(still.pose, invert(moved.pose))
        if still is tie.parent and placed.attach(still.link, moved.link, pose, tie.value.location):
            return
        parent, child = (tie.child, tie.parent) if placed.is_still(tie.child.link) else (tie.parent, tie.child)
        name = f"{parent.link[1] or parent.link[0]}_{child.link[1]}"
        rows = (name, "weld", parent.link, child.link, parent.pose, child.pose, tie.value.location)
        self._reader.parts.constraints.append(DescribedConstraint(*rows))

    # --- the scene

    def scene(self, path: Path) -> ImportedScene | None:
        """Returns the scene, or only the losses after errors."""
        if self._context.sink.failed:
            return ImportedScene({}, tuple(self._losses))
        parts, views = self._reader.parts, SdfViews()
        for full, built in parts.links.items():
            if built.link is not None:
                views.add_link(full, built, built.link)
        place, ignored = Location(str(path)), self._ignored_pairs()
        if not parts.entities and not self._losses:
            self._context.sink.report("SC433", "there is nothing to import: the file adds no model", place)
            return None
        world = DescribedWorld(
            Names().new(path.name.partition(".")[0]),
            self._reader.placed.entities(),
            DescribedPhysics(friction=FRICTION),
            tuple(parts.constraints),
            tuple(views.lights),
            tuple(views.cameras),
            ignored,
        )
        written = write_world(world)
        self._losses += written.lost_filters(place)
        content = written.document, tuple(self._losses), written.bodies
        codes = URDF_LOSS_CODES | MJCF_LOSS_CODES
        return ImportedScene(*content, places=written.places, codes_of_losses=codes)

    def _ignored_pairs(self) -> frozenset[frozenset[LinkName]]:
        """Returns the pairs that the collision filter groups separate. Shapes of files cannot be separated: a loss."""
        entities = {entity.name: entity for entity in self._reader.parts.entities}
        found: set[frozenset[LinkName]] = set()
        for first, second, value in self._ignored:
            try:
                groups = self._group(first, value), self._group(second, value)
            except ValueFault as fault:
                fault.report(self._context.sink, self._losses)
                continue
            pairs = {frozenset((a, b)) for a in groups[0] for b in groups[1] if a != b}
            kept = {pair for pair in pairs if any(isinstance(entities[name].content, RobotFile) for name, _ in pair)}
            found |= pairs - kept
            if kept:
                rows = sorted(f"`{self._reader.model_of(link)}{SEPARATOR}{link[1]}`" for link in min(kept, key=sorted))
                words = f"{' and '.join(rows)} would collide, since the scene names their files"
                self._losses.append(Loss("collision-filters", words, value.location))
        return frozenset(found)
