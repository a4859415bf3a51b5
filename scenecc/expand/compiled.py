"""A module looked through once, ready to be expanded as often as it is used."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.expand.contents import count_values, weight
from scenecc.expand.names import BUILTIN, DEFAULT, Meaning, Names, check_free
from scenecc.expand.params import Param, read_param
from scenecc.expand.patterns import Axes, Compiler, Pattern
from scenecc.expand.run import Budget, Run
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.plain import is_mapping

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.diagnostics import Origin, Path, Sink
    from scenecc.expand.modules import Entry, Module, Part

_OF_COPIES = frozenset(("repeat", "if", "name"))
"""Keys that say which entities there are, and are no part of them."""

FASTENED = ("constraints", "lights", "cameras")
"""Sections of what is built after the entities, and may hold on to them. In this order they are written."""

_OF_INSTANCES = frozenset((*_OF_COPIES, "use", "with", "prefix", "scene_idxs"))


@dataclass(frozen=True, slots=True)
class Written:
    """A node and its pattern.

    Attributes:
        node: as written, without what is not part of it.
        pattern: None where there is nothing to fill in.
        part: the document in which it is written.
        path: of it there.
    """

    node: Any
    pattern: Pattern | None
    part: Part
    path: Path

    def make(self, run: Run) -> Any:
        """The node with the values of a run."""
        return self.node if self.pattern is None else self.pattern.make(run)


@dataclass(frozen=True, slots=True)
class Use:
    """What an instance has beside its pose.

    Attributes:
        reference: of the prefab's file.
        given: parameter → its value.
        prefix: what stands before the names inside; None: the instance's name and a slash.
    """

    reference: Written
    given: dict[str, Written]
    prefix: Written | None


@dataclass(frozen=True, slots=True)
class WrittenUnit:
    """One written entity, constraint, light or camera, or several; or instances of a prefab.

    Attributes:
        section: of it.
        name: as written.
        body: its node; of an instance what is left of it for its frame.
        axes: what repeats it.
        condition: its `if`.
        namer: the names of its copies.
        selection: its `scene_idxs`.
        use: the prefab; None for what is no instance.
        weight: for how many objects each copy counts: one, or as many as it has shapes, and more where it is long.
    """

    section: str
    name: str
    body: Written
    axes: Axes | None
    condition: Written | None
    namer: Written | None
    selection: Written | None
    use: Use | None
    weight: int


@dataclass(frozen=True, slots=True)
class CompiledModule:
    """A module, looked through.

    Attributes:
        module: of it.
        params: by name, in order.
        draws, materials, groups, frames: by name, in order.
        settings: `physics` and `environment`, each by key.
        units: the entities.
        fastened: the constraints, then the lights and the cameras.
        weight: for how many objects a use of it counts, but for what is repeated in it and the instances.
    """

    module: Module
    params: dict[str, Param]
    draws: dict[str, Written]
    materials: dict[str, Written]
    groups: dict[str, Written]
    frames: dict[str, Written]
    settings: dict[str, dict[str, Written]]
    units: list[WrittenUnit]
    fastened: list[WrittenUnit]
    weight: int

    def default_materials(self) -> list[str]:
        """The materials that parameters have by default."""
        params = self.params.values()
        return [param.default for param in params if param.kind == "material" and isinstance(param.default, str)]


def compile_module(module: Module, use: Origin | None, sink: Sink) -> CompiledModule:
    """Looks through a module; what is wrong in every use of it is reported.

    Args:
        module: a file with all that it includes.
        use: what it is first used from.
        sink: takes the diagnostics.
    """
    return _ModuleCompiler(module, use, sink).compiled()


class _ModuleCompiler:
    """Looks through one module: first its parameters and draws, whose names everything after them may read."""

    def __init__(self, module: Module, use: Origin | None, sink: Sink) -> None:
        self._module = module
        self._use = use
        self._sink = sink
        self._runs: dict[int, Run] = {}
        self._names: dict[str, Meaning] = dict(BUILTIN)

    def compiled(self) -> CompiledModule:
        """The module, looked through in the order in which names may be read."""
        params = self._params()
        draws = self._draws()
        sections = (
            self._section("materials"),
            self._section("collision_groups", "`collision_groups`"),
            self._section("frames"),
        )
        units = self._units("entities")
        fastened = [unit for section in FASTENED for unit in self._units(section)]
        return CompiledModule(
            self._module,
            params,
            draws,
            *sections,
            {"physics": self._section("physics", "`physics`"), "environment": self._section("environment")},
            units,
            fastened,
            self._weight((draws, *sections), [*units, *fastened]),
        )

    def _weight(self, sections: Iterable[Mapping[str, Written]], units: list[WrittenUnit]) -> int:
        params = self._module.section("params").values()
        count = sum(1 + count_values(entry.node) for entry in params) // _PER_PARAMETER
        count += sum(weight(made.node) for nodes in sections for made in nodes.values())
        return count + sum(unit.weight for unit in units if unit.axes is None and unit.use is None)

    def _run(self, part: Part) -> Run:
        run = self._runs.get(id(part))
        if run is None:
            run = Run(part.document.name, part.parent(self._use), {}, _NO_OBJECTS, self._sink)
            self._runs[id(part)] = run
        return run

    def _compiler(self, entry: Entry, structure: str | None = None) -> Compiler:
        return Compiler(self._names, self._run(entry.part), structure)

    def _section(self, section: str, structure: str | None = None) -> dict[str, Written]:
        return {
            name: self._made(entry, self._compiler(entry, structure))
            for name, entry in self._module.section(section).items()
        }

    @staticmethod
    def _made(entry: Entry, compiler: Compiler) -> Written:
        return Written(entry.node, compiler.pattern(entry.node, entry.path), entry.part, entry.path)

    def _params(self) -> dict[str, Param]:
        entries = self._module.section("params")
        for name, entry in entries.items():
            if check_free(name, "parameter", self._names, entry.path, self._run(entry.part)):
                self._names[name] = "later parameter"
        draws: dict[str, Meaning] = dict.fromkeys(self._module.section("draws"), "draw")
        params: dict[str, Param] = {}
        for name, entry in entries.items():
            run = self._run(entry.part)
            # The defaults before it may be read; the names of a snapshot stay as they are now.
            names: dict[str, Meaning] = {**draws, **self._names, **_itself(name, self._names)}
            found = read_param(name, entry.node, entry.part, Compiler(names, run, DEFAULT), run)
            if found is not None:
                params[name] = found
            if self._names.get(name) == "later parameter":
                self._names[name] = "parameter"
        return params

    def _draws(self) -> dict[str, Written]:
        entries = self._module.section("draws")
        for name, entry in entries.items():
            if check_free(name, "draw", self._names, entry.path, self._run(entry.part)):
                self._names[name] = "later draw"
        draws: dict[str, Written] = {}
        for name, entry in entries.items():
            names: dict[str, Meaning] = {**self._names, **_itself(name, self._names)}
            draws[name] = self._made(entry, Compiler(names, self._run(entry.part)))
            if self._names.get(name) == "later draw":
                self._names[name] = "draw"
        return draws

    def _units(self, section: str) -> list[WrittenUnit]:
        return [self._unit(section, name, entry) for name, entry in self._module.section(section).items()]

    def _unit(self, section: str, name: str, entry: Entry) -> WrittenUnit:
        node, path = entry.node, entry.path
        compiler = self._compiler(entry)
        axes = None
        if "repeat" in node:
            axes, compiler = compiler.axes(node["repeat"], (*path, "repeat"))
        else:
            self._needs_repeat(node, entry)
        use = self._use_of(node, entry, compiler) if section == "entities" and "use" in node else None
        dropped = _OF_INSTANCES if use is not None else _OF_COPIES & node.keys()
        inner = compiler.entries(node, path, frozenset(dropped)) if is_mapping(node) else None
        body = Written(
            node if inner is None else inner.node, inner if inner and inner.patterns else None, entry.part, path
        )
        condition, namer, selection = (self._fixed(node, key, entry, compiler) for key in ("if", "name", "scene_idxs"))
        return WrittenUnit(section, name, body, axes, condition, namer, selection, use, weight(node))

    def _needs_repeat(self, node: dict[str, Any], entry: Entry) -> None:
        if "name" in node:
            hint = "an entity is called as its key says; `name` names the copies of what is repeated"
            self._run(entry.part).report(
                "SC224", "`name` does nothing without `repeat`", (*entry.path, "name"), at="key", hint=hint
            )

    @staticmethod
    def _fixed(node: dict[str, Any], key: str, entry: Entry, compiler: Compiler) -> Written | None:
        """A key that decides about structure; None where it is not there."""
        if key not in node:
            return None
        path = (*entry.path, key)
        fixed = Compiler(compiler.names, compiler.run, f"`{key}`")
        return Written(node[key], fixed.pattern(node[key], path), entry.part, path)

    def _use_of(self, node: dict[str, Any], entry: Entry, compiler: Compiler) -> Use:
        reference = self._fixed(node, "use", entry, compiler)
        assert reference is not None
        given = node.get("with", {})
        path = (*entry.path, "with")
        return Use(
            reference,
            {
                name: Written(item, compiler.pattern(item, (*path, name)), entry.part, (*path, name))
                for name, item in given.items()
                if not name.startswith(NOTE_PREFIX)
            },
            self._fixed(node, "prefix", entry, compiler),
        )


_PER_PARAMETER = 4
"""How many values in the declarations of parameters count as an object."""


def _itself(name: str, names: Names) -> dict[str, Meaning]:
    """What a draw or default of some name cannot read: the one of that name."""
    return {name: "itself"} if names.get(name, "").startswith("later") else {}


_NO_OBJECTS = Budget("SC604", "objects", "objects", 0)
"""Nothing is made while a module is looked through."""
