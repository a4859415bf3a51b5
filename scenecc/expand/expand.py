"""The expansion stage: turns a document and the files it uses into the data of one scene file."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location, Origin
from scenecc.diagnostics.messages import cut, show, suggest
from scenecc.expand.arguments import BoundParams, ParamArgument, bind_params, entity_name, material_name
from scenecc.expand.documents import FailedValue, Load, SceneDocument, has_varying, top_document
from scenecc.expand.expansion import (
    BudgetExhausted,
    ExpansionFrame,
    ExpansionWriter,
    ObjectBudget,
    SourceMark,
    scoped_name,
)
from scenecc.expand.module_compiler import (
    FIXED_OVERRIDE_KEYS,
    CompiledModule,
    PrefabLibrary,
    compile_module,
)
from scenecc.expand.modules import EXPECT, ModuleLibrary
from scenecc.expand.overrides import (
    INSTANCE_KEYS,
    OVERRIDE_SECTIONS,
    REMOVE,
    InstanceOverrides,
    Override,
    OverrideMerger,
    check_removals,
    make_overrides,
    says_world,
)
from scenecc.expand.params import form_key
from scenecc.expand.patterns import PatternCompiler, check_condition, hoist_invariants, refuse_structure
from scenecc.source.document import copy_mapping
from scenecc.spec.base import NAME_PATTERN, NOTE_PREFIX, PATTERN_HINTS, PREFIX_PATTERN
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.spec.references import qualified_name, resolve_scene_idxs
from scenecc.variation.forms import ONCE

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from scenecc.diagnostics.diagnostic import Path
    from scenecc.expand.expansion import Expansion, MeasureMesh, MeshMeasurer, OverridePlace
    from scenecc.expand.module_compiler import DocumentChain, InstanceTemplate, NodeTemplate, UnitTemplate
    from scenecc.expand.modules import ModulePart
    from scenecc.expand.params import Param
    from scenecc.expand.patterns import NameMeaning
    from scenecc.source import Document, Limits


@dataclass(slots=True)
class ModuleScope:
    """One use of a module.

    Attributes:
        compiled: the module.
        name: full name of the instance; "" for the top.
        prefix: prefix of the names of its entities and frames.
        use: origin of the `use`; None for the top.
        selection: the scenes that the instance is in.
        values: values of parameters and constants, by name.
        failed: parameters whose value has a reported error.
        chain: the modules that lead here, this one last.
        hidden: whether its entities are hidden from cameras.
        overrides: overrides of this instance and of the enclosing ones, innermost first.
    """

    compiled: CompiledModule
    name: str
    prefix: str
    use: Origin | None
    selection: Selection
    values: dict[str, Any]
    failed: frozenset[str]
    chain: DocumentChain
    hidden: bool = False
    overrides: tuple[InstanceOverrides, ...] = ()
    expansion_frames: dict[int, ExpansionFrame] = field(default_factory=dict[int, ExpansionFrame])

    def frame(self, part: ModulePart, objects: ObjectBudget, sink: Sink) -> ExpansionFrame:
        """Returns the frame of one of the module's documents."""
        frame = self.expansion_frames.get(id(part))
        if frame is None:
            parent = part.parent(self.use)
            frame = ExpansionFrame(part.document.name, parent, self.values, objects, sink, self.failed)
            self.expansion_frames[id(part)] = frame
        return frame


_NO_POSE: dict[str, Any] = {"pose": [0, 0, 0]}
"""Frame of an instance without a pose."""


@dataclass(frozen=True, slots=True)
class ModuleExpander:
    """Expands modules.

    Attributes:
        output: collects the expanded nodes.
        prefabs: finds prefabs.
        scenes: reads scene selections.
        draws: names of the shared draws that the caller provides.
        objects: budget of entities and repeated shapes.
        instances: budget of instances.
        sink: receives diagnostics.
    """

    output: ExpansionWriter
    prefabs: PrefabLibrary
    scenes: SceneSelections
    draws: Collection[str]
    objects: ObjectBudget
    instances: ObjectBudget
    sink: Sink

    def bind(
        self,
        compiled: CompiledModule,
        given: Mapping[str, ParamArgument],
        *,
        scope: str,
        use: Origin | Location | None,
        key: str = "",
    ) -> BoundParams:
        """Binds a module's parameters. `key` is the name prefix of materials that are given as mappings."""

        def name_of(param: Param, argument: ParamArgument) -> Any:
            if argument.scope == scope and isinstance(argument.value, str):
                return argument.value
            if param.kind == "entity":
                return entity_name(argument, self.output.names)
            return material_name(argument, f"{key}with.{param.name}", self.output, self.sink)

        return bind_params(
            compiled,
            given,
            {"num_scenes": self.scenes.count},
            scope=scope,
            use=use,
            name_of=name_of,
            objects=self.objects,
            sink=self.sink,
        )

    def expand(self, scope: ModuleScope, bound: BoundParams) -> None:
        """Writes all nodes of a module."""
        self._write_varying_params(scope, bound)
        self._write_draws(scope)
        compiled = scope.compiled
        for section, nodes in (("materials", compiled.materials), ("collision_groups", compiled.groups)):
            for name, made in nodes.items():
                self._node(section, scoped_name(scope.name, name), made, scope)
        if scope.name or compiled.params:
            # Another instance or parameter value may use a material that is unused here.
            self.output.names.used_materials.update([scoped_name(scope.name, name) for name in compiled.materials])
        for name, made in compiled.frames.items():
            self._write_placed("frames", scope.prefix + name, made, scope)
        if not scope.name:
            for section, nodes in compiled.settings.items():
                for name, made in nodes.items():
                    self._node(section, name, made, scope)
        for unit in compiled.units:
            self._unit(unit, scope)
        for unit in compiled.fastened:
            self._unit(unit, scope)
        for number, made in enumerate(compiled.expectations):
            self._expectation(scoped_name(scope.name, f"{number}"), made, scope)

    def _write_varying_params(self, scope: ModuleScope, bound: BoundParams) -> None:
        """Writes parameters that differ between scenes as draws."""
        for name, argument in bound.varying.items():
            full = scoped_name(scope.name, name)
            place = argument.place if isinstance(argument.place, SourceMark) else SourceMark(argument.place.file, ())
            self.output.add("draws", full, argument.value, place, by_scene=argument.by_scene)
            if argument.scope != scope.name:
                self.output.names.given[full] = argument.scope
            if argument.wanted is not None:
                self.output.names.wanted[full] = argument.wanted

    def _write_draws(self, scope: ModuleScope) -> None:
        for name, made in scope.compiled.draws.items():
            frame = scope.frame(made.part, self.objects, self.sink)
            value = made.make(frame)
            full = scoped_name(scope.name, name)
            if has_varying(value) or full in self.draws:
                self.output.add("draws", full, value, frame.mark(made.path))
            else:
                # A constant: expressions that read it can be evaluated once for all scenes.
                scope.values[name] = value

    def _node(self, section: str, name: str, made: NodeTemplate, scope: ModuleScope) -> bool:
        frame = scope.frame(made.part, self.objects, self.sink)
        overrides = self._overrides(section, name, scope) if scope.overrides and section in OVERRIDE_SECTIONS else []
        if overrides is None:
            return False
        frame.lists = {}
        node, places = made.make(frame), None
        if overrides:
            node, places = self._merge_overrides(node, overrides, section, name)
        return self.output.add(section, name, node, frame.mark(made.path), frame.lists, overrides=places)

    def _write_placed(self, section: str, name: str, made: NodeTemplate, scope: ModuleScope) -> None:
        if self._node(section, name, made, scope) and scope.name:
            self.output.names.scopes[name] = scope.name
            if scope.selection is not None:
                # The arguments that it reads may have values only in these scenes.
                self.output.selections[name] = scope.selection

    def _expectation(self, name: str, made: NodeTemplate, scope: ModuleScope) -> None:
        if self._node(EXPECT, name, made, scope):
            self.output.names.scopes[qualified_name(EXPECT, name)] = scope.name
            if scope.selection is not None:
                self.output.selections[qualified_name(EXPECT, name)] = scope.selection

    def _unit(self, unit: UnitTemplate, scope: ModuleScope) -> None:
        frame = scope.frame(unit.body.part, self.objects, self.sink)
        if unit.axes is None:
            self._write_unit(unit, unit.name, scope, frame)
            return
        loop = unit.axes.loop(frame)
        if loop is None:
            return
        budget = self.objects if unit.use is None else self.instances
        budget.take(loop.count * unit.weight, frame, unit.axes.path)
        pattern = unit.body.pattern
        if pattern is not None and loop.count > 1:
            unit = replace(unit, body=replace(unit.body, pattern=hoist_invariants(pattern, loop.names)))
        for number in frame.each_copy(loop):
            self._write_unit(unit, f"{unit.name}_{number}", scope, frame)

    def _write_unit(self, unit: UnitTemplate, name: str, scope: ModuleScope, frame: ExpansionFrame) -> None:
        """Writes one entity, instance, constraint, light or camera. `name` is used if it has no `name` key."""
        if unit.condition is not None and not self._holds(unit.condition, frame):
            return
        if unit.namer is not None and unit.axes is not None:
            name = _make_name(unit.namer, "name", NAME_PATTERN, frame) or name
        if unit.use is not None:
            self._instance(unit, name, scope, frame)
            return
        full = scope.prefix + name
        overrides = self._overrides(unit.section, full, scope) if scope.overrides else []
        if overrides is None:
            return
        selection = self._selection(unit, scope, frame, overrides)
        if selection is not None and not selection:
            return
        frame.lists = {}
        node, places = unit.body.make(frame), None
        if overrides:
            node, places = self._merge_overrides(node, overrides, unit.section, full)
        if selection is not None:
            self.output.selections[qualified_name(unit.section, full)] = selection
            if "scene_idxs" in node:
                node = {key: item for key, item in node.items() if key != "scene_idxs"}
        if scope.hidden and unit.section == "entities":
            node = {**node, "hidden": True}
        mark = frame.mark(unit.body.path)
        if self.output.add(unit.section, full, node, mark, frame.lists, overrides=places) and scope.name:
            self.output.names.scopes[qualified_name(unit.section, full)] = scope.name

    def _overrides(self, section: str, full: str, scope: ModuleScope) -> list[Override] | None:
        """Returns the overrides of an object, innermost first; None if it is removed."""
        found: list[Override] = []
        for table in scope.overrides:
            override = table.find(section, full, self.sink)
            if override is not None:
                if override.value == REMOVE:
                    self.output.removed.setdefault((section, full), override.origin())
                    return None
                found.append(override)
        return found

    def _merge_overrides(
        self, node: Any, overrides: list[Override], section: str, full: str
    ) -> tuple[Any, dict[Path, OverridePlace]]:
        """Merges overrides into a node. Returns it with the place of each override."""
        merger = OverrideMerger(section, self.sink)
        for override in overrides:
            node = merger.merge(node, override)
            if says_world(override.value):
                self.output.names.worlds[qualified_name(section, full)] = override.scope
        return node, merger.places

    def _selection(
        self, unit: UnitTemplate, scope: ModuleScope, frame: ExpansionFrame, overrides: list[Override]
    ) -> Selection:
        """Returns the scenes of a unit, narrowed by the enclosing instance; None if no instance narrows them."""
        given = _find_last_selection(overrides) if overrides else None
        if given is not None and scope.selection is not None:
            return self.scenes.narrowed(given.value["scene_idxs"], scope.selection, given.origin("scene_idxs"))
        if scope.selection is None or unit.selection is None:
            return scope.selection
        return self.scenes.narrowed(unit.selection.make(frame), scope.selection, frame.origin(unit.selection.path))

    @staticmethod
    def _holds(condition: NodeTemplate, frame: ExpansionFrame) -> bool:
        return check_condition(condition.make(frame), condition.path, frame)

    def _instance(self, unit: UnitTemplate, name: str, scope: ModuleScope, frame: ExpansionFrame) -> None:
        use = unit.use
        assert use is not None
        if unit.axes is None:
            self.instances.take(unit.weight, frame, unit.body.path)
        place = frame.origin(use.reference.path)
        reference = use.reference.make(frame)
        if not isinstance(reference, str) or isinstance(reference, FailedValue):
            message = f"`use` must be a string, not {show(reference)}"
            refuse_structure(reference, use.reference.path, "use", "SC103", message, frame)
            return
        compiled = self.prefabs.find(reference, unit.body.part.document, place, scope.chain)
        if compiled is None:
            return
        full = scope.prefix + name
        prefix = f"{full}/"
        if use.prefix is not None:
            prefix = scope.prefix + (_make_name(use.prefix, "prefix", PREFIX_PATTERN, frame) or "")
        start = self.output.counts() if scope.overrides else {}
        called = _anchor_name(full, prefix, compiled) if scope.overrides else full
        overrides = self._overrides("use", called, scope) if scope.overrides else []
        said = overrides or []
        selection = self._instance_selection(unit, said, scope, frame)
        if selection is not None and not selection:
            return
        self.objects.take(compiled.weight, frame, unit.body.path)
        arguments = self._arguments(use, said, selection, scope, frame)
        bound = self.bind(compiled, arguments, scope=full, use=place, key=f"{name}.")
        chain = (*scope.chain, compiled.module.main.document)
        body, places = unit.body.make(frame), None
        if said:
            body, places = self._merge_overrides(
                body, [_placement_override(one, self.sink) for one in said], "entities", called
            )
        hidden = scope.hidden or body.get("hidden") is True
        own, tables = None, scope.overrides
        if use.overrides:
            own = InstanceOverrides(full, prefix, make_overrides(use.overrides, frame, scope.name, scope.prefix))
            tables = (own, *tables)
        inner = ModuleScope(
            compiled, full, prefix, place, selection, dict(bound.values), bound.failed, chain, hidden, tables
        )
        self.output.names.prefixes[full] = prefix
        mark = frame.mark(unit.body.path)
        self.expand(inner, bound)
        if tables:
            self.output.names.overridden.add(full)
        self._anchor(full, body, mark, selection, scope, places)
        if overrides is None:
            self.output.remove(start, self.output.removed["use", called])
        if own is not None:
            own.check(self.output.removed, self.sink)

    def _instance_selection(
        self, unit: UnitTemplate, overrides: list[Override], scope: ModuleScope, frame: ExpansionFrame
    ) -> Selection:
        """Returns the scenes of an instance: None for every scene, empty if an error was reported."""
        override = _find_last_selection(overrides) if overrides else None
        if override is not None:
            return self.scenes.narrowed(override.value["scene_idxs"], scope.selection, override.origin("scene_idxs"))
        if unit.selection is None:
            return scope.selection
        given = unit.selection.make(frame)
        return self.scenes.narrowed(given, scope.selection, frame.origin(unit.selection.path))

    def _arguments(
        self,
        use: InstanceTemplate,
        overrides: list[Override],
        selection: Selection,
        scope: ModuleScope,
        frame: ExpansionFrame,
    ) -> dict[str, ParamArgument]:
        """Returns the arguments of an instance, by parameter."""
        arguments = {
            param: ParamArgument(made.make(frame), frame.mark(made.path), made.part.document, scope.name)
            for param, made in use.given.items()
        }
        for override in overrides:
            given = override.value.get("with", {})
            for param, value in given.items() if is_mapping(given) else ():
                mark = replace(override.record.mark, path=(*override.record.mark.path, "with", param))
                arguments[param] = ParamArgument(value, mark, override.document, override.scope)
        if selection is None:
            return arguments
        return {param: self._map_by_scene(argument, selection) for param, argument in arguments.items()}

    def _map_by_scene(self, argument: ParamArgument, selection: tuple[int, ...]) -> ParamArgument:
        """Turns the `per_scene` lists of an argument, with one value per scene of the instance, into mappings."""
        if not has_varying(argument.value):
            return argument
        turned: dict[Path, tuple[int, ...]] = {}
        value, wrong = self.scenes.by_scene(argument.value, selection, (), turned)
        if wrong is not None and isinstance(argument.place, SourceMark):
            message = f"`per_scene` must have {len(selection)} values, one for each scene of the instance"
            place = replace(argument.place, path=(*argument.place.path, *wrong))
            self.sink.report("SC106", message, place.origin)
        return replace(argument, value=value, by_scene=turned)

    def _anchor(
        self,
        full: str,
        body: dict[str, Any],
        mark: SourceMark,
        selection: Selection,
        scope: ModuleScope,
        places: Mapping[Path, OverridePlace] | None,
    ) -> None:
        """Writes the frame of an instance."""
        output = self.output
        # With an empty prefix, an entity of the prefab may have the instance's name. The entity keeps it.
        is_taken = full in output.sections["entities"] and output.names.scopes.get(full, scope.name) != scope.name
        anchor = f"{full}/instance" if is_taken else full
        output.names.anchors[full] = anchor
        node = {"pose": body["pose"]} if "pose" in body else _NO_POSE
        if "place" in body:
            node = {**node, "place": body["place"]}
        if not output.add("frames", anchor, node, mark, overrides=places):
            return
        if scope.name:
            output.names.scopes[anchor] = scope.name
        if selection is not None:
            output.selections[anchor] = selection


def _find_last_selection(overrides: list[Override]) -> Override | None:
    """Returns the last override that sets `scene_idxs`, or None."""
    return next((one for one in reversed(overrides) if "scene_idxs" in one.value), None)


def _anchor_name(full: str, prefix: str, compiled: CompiledModule) -> str:
    """Returns an instance's name for overrides. With an empty prefix, an entity inside may have its name."""
    is_taken = any(prefix + unit.name == full for unit in compiled.units)
    return f"{full}/instance" if is_taken else full


def _placement_override(override: Override, sink: Sink) -> Override:
    """Returns an override of an instance with only its placement keys. Unknown keys are reported."""
    kept: dict[str, Any] = {}
    for key, item in override.value.items():
        if key in INSTANCE_KEYS:
            kept[key] = item
        elif not key.startswith(NOTE_PREFIX) and key not in FIXED_OVERRIDE_KEYS:
            hint = f"it is an instance: write `NAME/…: {{{cut(key)}: …}}` for an object inside, or `with: {{…}}`"
            sink.report("SC101", f"unknown key `{cut(key)}`", override.origin(key), at="key", hint=hint)
    kept.pop("with", None)
    return replace(override, value=kept)


def _make_name(made: NodeTemplate, key: str, pattern: str, frame: ExpansionFrame) -> str | None:
    """Returns a string that matches a pattern, or reports it and returns None."""
    text = made.make(frame)
    if isinstance(text, str) and re.fullmatch(pattern, text):
        return text
    refuse_structure(text, made.path, key, "SC107", f"{show(text)} is not a name", frame, hint=PATTERN_HINTS[pattern])
    return None


Selection = tuple[int, ...] | None
"""Scene indices, ascending; None for every scene."""

_INDEX_TYPES = (int, str)


class SceneSelections:
    """Reads each scene selection once.

    Args:
        count: number of scenes.
        most: most scenes that all selections together may hold; equal selections count once.
        sink: receives diagnostics.
    """

    def __init__(self, count: int, most: int, sink: Sink) -> None:
        self.count = count
        self._sink = sink
        self._known: dict[str, tuple[int, ...]] = {}
        self._narrowed: dict[tuple[str, int], tuple[tuple[int, ...], tuple[int, ...]]] = {}
        self._most = self._left = most

    def narrowed(self, given: Any, outer: Selection, place: Origin) -> Selection:
        """Returns the intersection of a selection with the enclosing one; empty if an error was reported.

        Raises:
            BudgetExhausted: the selections hold too many scenes in total. The error is reported first.
        """
        key = repr(given)
        if key not in self._known:
            self._known[key] = self._count_scenes(self._select(given, place) or (), place)
        chosen = self._known[key]
        if outer is None or not chosen:
            return chosen
        # Keyed by identity: the contents of an instance share one tuple. The cache keeps it alive.
        found = self._narrowed.get((key, id(outer)))
        if found is None:
            among = frozenset(outer)
            narrowed = self._count_scenes(tuple(scene for scene in chosen if scene in among), place)
            found = self._narrowed[key, id(outer)] = (outer, narrowed)
        return found[1]

    def _count_scenes(self, selection: tuple[int, ...], place: Origin) -> tuple[int, ...]:
        self._left -= len(selection)
        if self._left < 0:
            message = f"all instances together select more than {self._most} scenes in all"
            hint = "raise it with --limit objects=N or limits={'objects': N}"
            self._sink.report("SC604", message, place, hint=hint)
            raise BudgetExhausted
        return selection

    def _select(self, given: Any, place: Origin) -> Selection:
        # An expression may have returned any type.
        if isinstance(given, str) or (is_sequence(given) and all(type(item) in _INDEX_TYPES for item in given)):
            return resolve_scene_idxs(given if isinstance(given, str) else list(given), self.count, place, self._sink)
        message = f'`scene_idxs` must be a list of indices, or a slice such as "0:8", not {show(given)}'
        self._sink.report("SC103", message, place)
        return None

    def by_scene(
        self, value: Any, selection: tuple[int, ...], path: Path, turned: dict[Path, tuple[int, ...]]
    ) -> tuple[Any, Path | None]:
        """Turns the `per_scene` lists of a value, with one item per selected scene, into mappings by scene index.

        Returns the value, and the path of the first list of wrong length or None. `turned` receives the scenes of each
        converted list, by its path.
        """
        form = form_key(value)
        if form is None:
            return value, None
        items = value[form]
        if form == ONCE:
            made, wrong = self.by_scene(items, selection, (*path, form), turned)
            return {**value, form: made}, wrong
        if form == "per_scene" and is_sequence(items) and len(items) != len(selection):
            return value, (*path, form)
        pairs = items.items() if is_mapping(items) else enumerate(items) if is_sequence(items) else ()
        changed: dict[Any, Any] = {}
        for key, item in pairs:
            changed[key], wrong = self.by_scene(item, selection, (*path, form, key), turned)
            if wrong is not None:
                return value, wrong
        if form == "per_scene" and is_sequence(items):
            # The draw exists in every scene but is read only in the selected ones, so its default does not matter.
            turned[(*path, form)] = selection
            rows = {str(scene): changed[index] for index, scene in enumerate(selection)}
            return {**value, form: {**rows, "default": changed[0]}}, None
        kept: Any = changed if is_mapping(items) else list(changed.values()) if is_sequence(items) else items
        return {**value, form: kept}, None


PARAMS = "params"
"""File name in diagnostics about arguments of the API or the command line."""

DRAWS = "draws"
"""File name in diagnostics about draws from the API or the command line."""

_HEAD = ("scenecc", "name", "description", "num_scenes", "seed", "starts")


def expand(
    document: Document,
    *,
    params: Mapping[str, Any],
    num_scenes: int | None,
    seed: int | None,
    draws: Collection[str],
    load: Load,
    measure: MeshMeasurer,
    limits: Limits,
    sink: Sink,
) -> Expansion | None:
    """Expands a document. Returns None if an error was reported.

    Afterwards `sink.locate` finds places in all documents. The caller sets `sink.trace` to the expansion's `trace`.

    Args:
        document: the top document, already validated.
        params: parameter values by name. Paths in them are relative to the document's folder.
        num_scenes: overrides the document's.
        seed: overrides the document's.
        draws: names of the shared draws that the caller provides.
        load: reads included and used files; see `scenecc.expand.documents.scene_loader`.
        measure: returns the bounds of meshes; see `scenecc.named_files.mesh_measurer`.
        limits: limits on the size of the expansion.
        sink: receives diagnostics.
    """
    given = copy_mapping(params, sink, limits)
    if given is None:
        return None
    top = top_document(document)
    library = ModuleLibrary(load, limits.depth, sink)
    library.add(top)
    sink.locate = library.locate
    module = library.module(top, None)
    if not module.good:
        return None
    compiled = compile_module(module, None, measure, sink)
    arguments = {name: ParamArgument(value, Location(PARAMS), top, "") for name, value in given.items()}
    head = _expand_head(compiled, arguments, partial(measure, top), limits, sink)
    output = ExpansionWriter(top.name, sink)
    objects = ObjectBudget("SC604", "objects", "objects", limits.objects)
    instances = ObjectBudget("SC604", "instances", "objects", limits.objects)
    scenes = SceneSelections(_scene_count(head, num_scenes, limits), limits.objects_in_all_scenes, sink)
    builder = ModuleExpander(output, PrefabLibrary(library, measure, sink), scenes, draws, objects, instances, sink)
    if not _expand_top(builder, compiled, arguments, top, objects, sink):
        return None
    _check_draws(draws, compiled, output, sink)
    check_removals(output, sink)
    if sink.failed:
        return None
    if num_scenes is not None:
        head["num_scenes"] = num_scenes
    if seed is not None:
        head["seed"] = seed
    defaults = {name: param.default for name, param in compiled.params.items() if name not in given}
    return output.expansion(head, library.documents, given, defaults)


def _expand_head(
    compiled: CompiledModule,
    arguments: Mapping[str, ParamArgument],
    measure: MeasureMesh,
    limits: Limits,
    sink: Sink,
) -> dict[str, Any]:
    """Returns the head keys of the top document. They may read parameters, but not `num_scenes`."""
    document = compiled.module.main.document
    data = document.document.data
    head = {key: data[key] for key in _HEAD if key in data}
    if not any(isinstance(item, str) and "${" in item for item in head.values()):
        return head
    few = ObjectBudget("SC604", "objects", "objects", limits.objects)
    try:
        early = bind_params(
            compiled,
            arguments,
            {},
            scope="",
            use=None,
            name_of=lambda _, argument: argument.value,
            objects=few,
            sink=Sink(),  # the final binding reports these errors
        )
    except BudgetExhausted:
        return head
    frame = ExpansionFrame(document.name, None, early.values, few, sink, measure=measure)
    names: dict[str, NameMeaning] = dict.fromkeys(compiled.params, "parameter")
    for key, item in head.items():
        pattern = PatternCompiler(names, frame, f"`{key}`").pattern(item, (key,))
        if pattern is not None:
            head[key] = pattern.make(frame)
    return head


def _scene_count(head: Mapping[str, Any], num_scenes: int | None, limits: Limits) -> int:
    """Returns the number of scenes. `num_scenes` overrides the head."""
    count = head.get("num_scenes", 1) if num_scenes is None else num_scenes
    # A later stage reports an invalid number.
    return count if type(count) is int and 1 <= count <= limits.scenes else 1


def _expand_top(
    builder: ModuleExpander,
    compiled: CompiledModule,
    arguments: Mapping[str, ParamArgument],
    top: SceneDocument,
    objects: ObjectBudget,
    sink: Sink,
) -> bool:
    """Expands the top module. Returns False if a limit was exceeded, which is reported."""
    try:
        objects.take(compiled.weight, ExpansionFrame(top.name, None, {}, objects, sink), ())
        bound = builder.bind(compiled, arguments, scope="", use=Location(PARAMS))
        builder.expand(ModuleScope(compiled, "", "", None, None, dict(bound.values), bound.failed, (top,)), bound)
    except BudgetExhausted:
        return False
    return True


def _check_draws(draws: Collection[str], compiled: CompiledModule, output: ExpansionWriter, sink: Sink) -> None:
    """Reports draws from the caller that do not exist in the scene."""
    known = dict.fromkeys((*compiled.draws, *output.sections["draws"]))
    for name in map(str, draws):
        if name not in known:
            message = f"there is no shared draw `{cut(name)}`"
            sink.report("SC250", message, Location(DRAWS), hint=suggest(name, known))
