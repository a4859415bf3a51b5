"""Compiles modules and prefabs once, for expansion in each use."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin, Path
from scenecc.diagnostics.messages import cut
from scenecc.expand.documents import SceneDocument, count_node_objects, count_values, find_per_scene_lists
from scenecc.expand.expansion import ExpansionFrame, MeshMeasurer, ObjectBudget
from scenecc.expand.modules import EXPECT, Module, ModuleLibrary, ModulePart, SectionEntry, chain_text
from scenecc.expand.params import Param, read_param
from scenecc.expand.patterns import (
    BUILTIN_MEANINGS,
    PARAM_DEFAULT,
    NameMeaning,
    Pattern,
    PatternCompiler,
    RepeatAxes,
    check_new_name,
)
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import is_mapping

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from scenecc.diagnostics import Sink

_COPY_KEYS = frozenset(("repeat", "if", "name"))
"""Keys that control which copies exist. They are not part of the expanded node."""

ATTACHED_SECTIONS = ("constraints", "lights", "cameras")
"""Sections that are built after the entities and may be attached to them, in the order of expansion."""

_INSTANCE_KEYS = frozenset((*_COPY_KEYS, "use", "with", "prefix", "scene_idxs", "override"))

FIXED_OVERRIDE_KEYS = frozenset((*_COPY_KEYS, "use", "prefix", "override"))
"""Keys that determine which objects a prefab has, and their names."""

_OVERRIDE_DEPTH = 4
"""Length of an override's path: `entities`, the instance, `override`, a name."""


@dataclass(frozen=True, slots=True)
class NodeTemplate:
    """A node and its pattern.

    Attributes:
        node: the unexpanded node, without keys that expansion consumes.
        pattern: its pattern; None if it has no expressions.
        part: its document.
        path: its path in the document.
    """

    node: Any
    pattern: Pattern | None
    part: ModulePart
    path: Path

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns the node with the values of a frame."""
        return self.node if self.pattern is None else self.pattern.make(frame)


@dataclass(frozen=True, slots=True)
class InstanceTemplate:
    """The keys of an instance other than its pose.

    Attributes:
        reference: reference to the prefab's file.
        given: arguments, by parameter.
        prefix: prefix of the names inside; None for the instance's name and a slash.
        overrides: overrides, by the name of the object inside.
    """

    reference: NodeTemplate
    given: dict[str, NodeTemplate]
    prefix: NodeTemplate | None
    overrides: dict[str, NodeTemplate]


@dataclass(frozen=True, slots=True)
class UnitTemplate:
    """An unexpanded entity, instance, constraint, light or camera.

    Attributes:
        section: its section.
        name: its key in the section.
        body: its node. For an instance, the node of its frame.
        axes: its `repeat`.
        condition: its `if`.
        namer: its `name`, which names the copies.
        selection: its `scene_idxs`.
        use: the prefab; None if it is not an instance.
        weight: objects that each copy counts as; see `count_node_objects`.
    """

    section: str
    name: str
    body: NodeTemplate
    axes: RepeatAxes | None
    condition: NodeTemplate | None
    namer: NodeTemplate | None
    selection: NodeTemplate | None
    use: InstanceTemplate | None
    weight: int


@dataclass(frozen=True, slots=True)
class CompiledModule:
    """A compiled module.

    Attributes:
        module: its source.
        params: parameters by name, in order.
        draws, materials, groups, frames: nodes by name, in order.
        settings: `physics` and `environment`, each by key.
        units: the entities.
        fastened: the constraints, then the lights and the cameras.
        expectations: the `expect` of each document that has one.
        weight: objects that each use counts as, without repeated units and instances.
    """

    module: Module
    params: dict[str, Param]
    draws: dict[str, NodeTemplate]
    materials: dict[str, NodeTemplate]
    groups: dict[str, NodeTemplate]
    frames: dict[str, NodeTemplate]
    settings: dict[str, dict[str, NodeTemplate]]
    units: list[UnitTemplate]
    fastened: list[UnitTemplate]
    expectations: list[NodeTemplate]
    weight: int


def compile_module(module: Module, use: Origin | None, measure: MeshMeasurer, sink: Sink) -> CompiledModule:
    """Compiles a module and reports errors that do not depend on its use. `use` is the first use, None for the top."""
    return _ModuleCompiler(module, use, measure, sink).compiled()


class _ModuleCompiler:
    """Compiles one module: first its parameters and draws, because later nodes may read them."""

    def __init__(self, module: Module, use: Origin | None, measure: MeshMeasurer, sink: Sink) -> None:
        self._module = module
        self._use = use
        self._measure = measure
        self._sink = sink
        self._expansion_frames: dict[int, ExpansionFrame] = {}
        self._names: dict[str, NameMeaning] = dict(BUILTIN_MEANINGS)

    def compiled(self) -> CompiledModule:
        """Returns the compiled module. Sections are compiled in the order in which names may be read."""
        params = self._params()
        draws = self._draws()
        sections = (
            self._section("materials"),
            self._section("collision_groups", "`collision_groups`"),
            self._section("frames"),
        )
        units = self._units("entities")
        fastened = [unit for section in ATTACHED_SECTIONS for unit in self._units(section)]
        return CompiledModule(
            self._module,
            params,
            draws,
            *sections,
            {"physics": self._section("physics", "`physics`"), "environment": self._section("environment")},
            units,
            fastened,
            self._expectations(),
            self._weight((draws, *sections), [*units, *fastened]),
        )

    def _weight(self, sections: Iterable[Mapping[str, NodeTemplate]], units: list[UnitTemplate]) -> int:
        params = self._module.section("params").values()
        count = sum(1 + count_values(entry.node) for entry in params) // _VALUES_PER_OBJECT
        count += sum(count_node_objects(made.node) for nodes in sections for made in nodes.values())
        return count + sum(unit.weight for unit in units if unit.axes is None and unit.use is None)

    def _frame(self, part: ModulePart) -> ExpansionFrame:
        frame = self._expansion_frames.get(id(part))
        if frame is None:
            frame = ExpansionFrame(part.document.name, part.parent(self._use), {}, _NO_BUDGET, self._sink)
            frame.measure = partial(self._measure, part.document)
            self._expansion_frames[id(part)] = frame
        return frame

    def _compiler(self, entry: SectionEntry, structure: str | None = None) -> PatternCompiler:
        return PatternCompiler(self._names, self._frame(entry.part), structure)

    def _section(self, section: str, structure: str | None = None) -> dict[str, NodeTemplate]:
        return {
            name: self._make_template(entry, self._compiler(entry, structure))
            for name, entry in self._module.section(section).items()
        }

    @staticmethod
    def _make_template(entry: SectionEntry, compiler: PatternCompiler) -> NodeTemplate:
        return NodeTemplate(entry.node, compiler.pattern(entry.node, entry.path), entry.part, entry.path)

    def _expectations(self) -> list[NodeTemplate]:
        """Returns the `expect` nodes of all documents. They are not merged."""
        nodes = [(part, part.document.document.data.get(EXPECT)) for part in self._module.parts]
        entries = [SectionEntry(node, part, (EXPECT,)) for part, node in nodes if is_mapping(node)]
        return [self._make_template(entry, self._compiler(entry)) for entry in entries]

    def _params(self) -> dict[str, Param]:
        draws: dict[str, NameMeaning] = dict.fromkeys(self._module.section("draws"), "draw")
        params: dict[str, Param] = {}
        for name, entry, names in self._list_entries("params", "parameter", "later parameter"):
            frame = self._frame(entry.part)
            compiler = PatternCompiler({**draws, **names}, frame, PARAM_DEFAULT)
            found = read_param(name, entry.node, entry.part, compiler, frame)
            if found is not None:
                params[name] = found
        return params

    def _draws(self) -> dict[str, NodeTemplate]:
        return {
            name: self._make_template(entry, PatternCompiler(names, self._frame(entry.part)))
            for name, entry, names in self._list_entries("draws", "draw", "later draw")
        }

    def _list_entries(
        self, section: str, meaning: NameMeaning, later: NameMeaning
    ) -> Iterator[tuple[str, SectionEntry, dict[str, NameMeaning]]]:
        """Yields the entries of a section, each with a snapshot of the names that it may read: those above it."""
        entries = self._module.section(section)
        for name, entry in entries.items():
            if check_new_name(name, meaning, self._names, entry.path, self._frame(entry.part)):
                self._names[name] = later
        for name, entry in entries.items():
            own: dict[str, NameMeaning] = {name: "itself"} if self._names.get(name, "").startswith("later") else {}
            yield name, entry, {**self._names, **own}
            if self._names.get(name) == later:
                self._names[name] = meaning

    def _units(self, section: str) -> list[UnitTemplate]:
        return [self._unit(section, name, entry) for name, entry in self._module.section(section).items()]

    def _unit(self, section: str, name: str, entry: SectionEntry) -> UnitTemplate:
        node, path = entry.node, entry.path
        compiler = self._compiler(entry)
        axes = None
        if "repeat" in node:
            axes, compiler = compiler.axes(node["repeat"], (*path, "repeat"))
        else:
            self._needs_repeat(node, entry)
        use = self._use_of(node, entry, compiler) if section == "entities" and "use" in node else None
        dropped = _INSTANCE_KEYS if use is not None else _COPY_KEYS & node.keys()
        inner = compiler.entries(node, path, frozenset(dropped)) if is_mapping(node) else None
        body = NodeTemplate(
            node if inner is None else inner.node, inner if inner and inner.patterns else None, entry.part, path
        )
        condition, namer, selection = (
            self._compile_fixed(node, key, entry, compiler) for key in ("if", "name", "scene_idxs")
        )
        return UnitTemplate(section, name, body, axes, condition, namer, selection, use, count_node_objects(node))

    def _needs_repeat(self, node: dict[str, Any], entry: SectionEntry) -> None:
        if "name" in node:
            hint = "the key of an entity is its name; `name` names the copies of a repeated entity"
            self._frame(entry.part).report(
                "SC224", "`name` has no effect without `repeat`", (*entry.path, "name"), at="key", hint=hint
            )

    @staticmethod
    def _compile_fixed(
        node: dict[str, Any], key: str, entry: SectionEntry, compiler: PatternCompiler
    ) -> NodeTemplate | None:
        """Compiles a key that determines structure. Returns None if the key is missing."""
        if key not in node:
            return None
        path = (*entry.path, key)
        fixed = PatternCompiler(compiler.names, compiler.frame, f"`{key}`")
        return NodeTemplate(node[key], fixed.pattern(node[key], path), entry.part, path)

    def _use_of(self, node: dict[str, Any], entry: SectionEntry, compiler: PatternCompiler) -> InstanceTemplate:
        reference = self._compile_fixed(node, "use", entry, compiler)
        assert reference is not None
        for name, item in node.get("override", {}).items():
            for key in item if is_mapping(item) and not name.startswith(NOTE_PREFIX) else ():
                if key in FIXED_OVERRIDE_KEYS:
                    message = f"`{key}` cannot be overridden"
                    hint = "it determines which objects the prefab has; set a parameter of the prefab in `with`"
                    place = (*entry.path, "override", name, key)
                    self._frame(entry.part).report("SC244", message, place, at="key", hint=hint)
        return InstanceTemplate(
            reference,
            self._parts(node, "with", entry, compiler),
            self._compile_fixed(node, "prefix", entry, compiler),
            self._parts(node, "override", entry, replace(compiler, depth=_OVERRIDE_DEPTH)),
        )

    @staticmethod
    def _parts(
        node: dict[str, Any], key: str, entry: SectionEntry, compiler: PatternCompiler
    ) -> dict[str, NodeTemplate]:
        path = (*entry.path, key)
        return {
            name: NodeTemplate(item, compiler.pattern(item, (*path, name)), entry.part, (*path, name))
            for name, item in node.get(key, {}).items()
            if not name.startswith(NOTE_PREFIX)
        }


_VALUES_PER_OBJECT = 4
"""Number of values in parameter declarations that count as one object."""


_NO_BUDGET = ObjectBudget("SC604", "objects", "objects", 0)
"""Compilation creates no objects."""


DocumentChain = tuple["SceneDocument", ...]
"""A chain of documents, each used by the one before, from the top."""

_IGNORED_KEYS = ("physics", "environment", "num_scenes", "seed", "starts")
"""Keys of a prefab that apply only when it is compiled as a scene."""


class PrefabLibrary:
    """The prefabs of one compilation."""

    def __init__(self, library: ModuleLibrary, measure: MeshMeasurer, sink: Sink) -> None:
        self._library = library
        self._measure = measure
        self._sink = sink
        self._compiled: dict[str, CompiledModule | None] = {}

    def find(self, reference: str, owner: SceneDocument, place: Origin, chain: DocumentChain) -> CompiledModule | None:
        """Returns the compiled prefab that `owner` uses, or None after a reported error. `chain` ends with `owner`."""
        document = self._library.find(reference, owner, place)
        if document is None:
            return None
        names = [above.shown for above in (*chain, document)]
        if any(document.identity == above.identity for above in chain):
            message = f"a prefab uses itself: {chain_text(names)}"
            self._sink.report("SC232", message, place, hint="remove one of these uses")
            return None
        if self._library.is_too_deep(names, place):
            return None
        if document.identity not in self._compiled:
            module = self._library.module(document, place)
            self._check(module, place)
            compiled = compile_module(module, place, self._measure, self._sink) if module.good else None
            self._compiled[document.identity] = compiled
        return self._compiled[document.identity]

    def _check(self, module: Module, place: Origin) -> None:
        """Reports keys and lists that have no meaning in a prefab."""
        for part in module.parts:
            data, parent = part.document.document.data, part.parent(place)
            for key in _IGNORED_KEYS:
                if key in data:
                    message = f"`{key}` of a prefab is ignored: the scene sets it"
                    self._sink.report("SC241", message, Origin(part.document.name, (key,), "", parent), at="key")
        for section in module.sections.values():
            for name, entry in section.items():
                for path in find_per_scene_lists(entry.node, entry.path) if entry.path[:1] != ("params",) else ():
                    origin = entry.origin(place)
                    message = f"`{cut(name)}` lists values by scene, but an instance may be in any scenes"
                    hint = "write {per_scene: {0: …, default: …}}, `cycle` or a parameter"
                    self._sink.report("SC242", message, Origin(origin.file, path, "", origin.parent), hint=hint)
