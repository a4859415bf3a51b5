"""Modules into output: one namespace after the other, entities in the order in which they are built."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import show
from scenecc.expand.arguments import Argument, Bound, bind_params
from scenecc.expand.contents import is_varying
from scenecc.expand.expansion import Mark
from scenecc.expand.materials import material_name
from scenecc.expand.named_materials import may_be_named
from scenecc.expand.output import Output, scoped
from scenecc.expand.run import Failed
from scenecc.expand.scopes import Scope
from scenecc.expand.still import stilled
from scenecc.spec.base import NAME_PATTERN, PREFIX_PATTERN, SPELLINGS
from scenecc.spec.known import known_as

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from scenecc.diagnostics import Location, Origin, Path, Sink
    from scenecc.expand.compiled import CompiledModule, Written, WrittenUnit
    from scenecc.expand.params import Param
    from scenecc.expand.prefabs import Prefabs
    from scenecc.expand.run import Budget, Run
    from scenecc.expand.scenes import Scenes, Selection

_NOWHERE: dict[str, Any] = {"pose": [0, 0, 0]}
"""The frame of an instance without a pose."""


class Builder:
    """Expands modules.

    Args:
        output: what is written.
        prefabs: finds them.
        scenes: reads selections.
        draws: the shared draws that are given from outside.
        objects: how many entities and repeated shapes may be made.
        instances: how many instances.
        sink: takes the diagnostics.
    """

    def __init__(
        self,
        output: Output,
        prefabs: Prefabs,
        scenes: Scenes,
        draws: Collection[str],
        objects: Budget,
        instances: Budget,
        sink: Sink,
    ) -> None:
        self._output = output
        self._prefabs = prefabs
        self._scenes = scenes
        self._draws = draws
        self._objects = objects
        self._instances = instances
        self._sink = sink

    def bind(
        self,
        compiled: CompiledModule,
        given: Mapping[str, Argument],
        *,
        scope: str,
        use: Origin | Location | None,
        key: str = "",
    ) -> Bound:
        """The values of a module's parameters. `key`: what stands before the names of materials given as mappings."""

        def material(param: Param, argument: Argument) -> Any:
            if argument.scope == scope and isinstance(argument.value, str):
                return argument.value
            return material_name(argument, f"{key}with.{param.name}", self._output, self._sink)

        return bind_params(
            compiled,
            given,
            {"num_scenes": self._scenes.count},
            scope=scope,
            use=use,
            material=material,
            objects=self._objects,
            sink=self._sink,
        )

    def expand(self, scope: Scope, bound: Bound) -> None:
        """Writes all that a module has."""
        self._varying(scope, bound)
        self._shared_draws(scope)
        compiled = scope.compiled
        for section, nodes in (("materials", compiled.materials), ("collision_groups", compiled.groups)):
            for name, made in nodes.items():
                self._node(section, scoped(scope.name, name), made, scope)
        # What one use of a prefab leaves unused another uses, and so it is with other parameters.
        unsuspected = compiled.materials if scope.name else may_be_named(compiled)
        self._output.used_materials.update([scoped(scope.name, name) for name in unsuspected])
        for name, made in compiled.frames.items():
            self._placed("frames", scope.prefix + name, made, scope)
        if not scope.name:
            for section, nodes in compiled.settings.items():
                for name, made in nodes.items():
                    self._node(section, name, made, scope)
        for unit in compiled.units:
            self._unit(unit, scope)
        for unit in compiled.fastened:
            self._unit(unit, scope)

    def _varying(self, scope: Scope, bound: Bound) -> None:
        """Parameters that differ from scene to scene become draws."""
        for name, argument in bound.varying.items():
            full = scoped(scope.name, name)
            place = argument.place if isinstance(argument.place, Mark) else Mark(argument.place.file, ())
            self._output.add("draws", full, argument.value, place, by_scene=argument.by_scene)
            if argument.scope != scope.name:
                self._output.given[full] = argument.scope
            if argument.wanted is not None:
                self._output.wanted[full] = argument.wanted

    def _shared_draws(self, scope: Scope) -> None:
        for name, made in scope.compiled.draws.items():
            run = scope.run(made.part, self._objects, self._sink)
            value = made.make(run)
            full = scoped(scope.name, name)
            if is_varying(value) or full in self._draws:
                self._output.add("draws", full, value, run.mark(made.path))
            else:
                # The same in every scene: whatever reads it is the same too, and need not be computed for each.
                scope.values[name] = value

    def _node(self, section: str, name: str, made: Written, scope: Scope) -> bool:
        run = scope.run(made.part, self._objects, self._sink)
        run.lists = {}
        node = made.make(run)
        return self._output.add(section, name, node, run.mark(made.path), run.lists)

    def _placed(self, section: str, name: str, made: Written, scope: Scope) -> None:
        if self._node(section, name, made, scope) and scope.name:
            self._output.scopes[name] = scope.name
            if scope.selection is not None:
                # What it reads of a `with` may have a value in these scenes alone.
                self._output.selections[name] = scope.selection

    def _unit(self, unit: WrittenUnit, scope: Scope) -> None:
        run = scope.run(unit.body.part, self._objects, self._sink)
        if unit.axes is None:
            self._one(unit, unit.name, scope, run)
            return
        loop = unit.axes.loop(run)
        if loop is None:
            return
        budget = self._objects if unit.use is None else self._instances
        budget.take(loop.count * unit.weight, run, unit.axes.path)
        values, names = run.values, loop.names
        pattern = unit.body.pattern
        if pattern is not None and loop.count > 1:
            unit = replace(unit, body=replace(unit.body, pattern=stilled(pattern, names)))
        for number, members in enumerate(loop):
            values.update(zip(names, members, strict=True))
            run.copies.append((loop, number))
            self._one(unit, f"{unit.name}_{number}", scope, run)
            run.copies.pop()
        for name in names:
            values.pop(name, None)

    def _one(self, unit: WrittenUnit, name: str, scope: Scope, run: Run) -> None:
        """One entity, instance, constraint, light or camera. `name`: what it is called without a `name` of its own."""
        if unit.condition is not None and not self._holds(unit.condition, run):
            return
        if unit.namer is not None and unit.axes is not None:
            name = _spelled(unit.namer, "name", NAME_PATTERN, run) or name
        if unit.use is not None:
            self._instance(unit, name, scope, run)
            return
        full = scope.prefix + name
        selection = self._selection(unit, scope, run)
        if selection is not None and not selection:
            return
        run.lists = {}
        node = unit.body.make(run)
        if selection is not None:
            self._output.selections[known_as(unit.section, full)] = selection
            if "scene_idxs" in node:
                node = {key: item for key, item in node.items() if key != "scene_idxs"}
        if scope.hidden and unit.section == "entities":
            node = {**node, "hidden": True}
        if self._output.add(unit.section, full, node, run.mark(unit.body.path), run.lists) and scope.name:
            self._output.scopes[known_as(unit.section, full)] = scope.name

    def _selection(self, unit: WrittenUnit, scope: Scope, run: Run) -> Selection:
        """The scenes of what is inside an instance that narrows them; None where none does."""
        if scope.selection is None or unit.selection is None:
            return scope.selection
        return self._scenes.narrowed(unit.selection.make(run), scope.selection, run.origin(unit.selection.path))

    @staticmethod
    def _holds(condition: Written, run: Run) -> bool:
        value = condition.make(run)
        if type(value) is bool:
            return value
        if is_varying(value):
            run.report("SC203", "`if` cannot read what differs from scene to scene", condition.path)
        elif not isinstance(value, Failed):
            run.report("SC223", f"`if` must be true or false, not {show(value)}", condition.path)
        return False

    def _instance(self, unit: WrittenUnit, name: str, scope: Scope, run: Run) -> None:
        use = unit.use
        assert use is not None
        if unit.axes is None:
            self._instances.take(unit.weight, run, unit.body.path)
        place = run.origin(use.reference.path)
        reference = use.reference.make(run)
        if not isinstance(reference, str) or isinstance(reference, Failed):
            if is_varying(reference):
                run.report("SC203", "`use` cannot read what differs from scene to scene", use.reference.path)
            elif not isinstance(reference, Failed):
                run.report("SC103", f"`use` must be a text, not {show(reference)}", use.reference.path)
            return
        compiled = self._prefabs.find(reference, unit.body.part.document, place, scope.chain)
        selection = scope.selection
        if unit.selection is not None:
            given = unit.selection.make(run)
            selection = self._scenes.narrowed(given, scope.selection, run.origin(unit.selection.path))
        if compiled is None or (selection is not None and not selection):
            return
        self._objects.take(compiled.weight, run, unit.body.path)
        full = scope.prefix + name
        arguments = {param: self._argument(made, selection, scope, run) for param, made in use.given.items()}
        bound = self.bind(compiled, arguments, scope=full, use=place, key=f"{name}.")
        prefix = f"{full}/"
        if use.prefix is not None:
            prefix = scope.prefix + (_spelled(use.prefix, "prefix", PREFIX_PATTERN, run) or "")
        chain = (*scope.chain, compiled.module.main.document)
        body = unit.body.make(run)
        hidden = scope.hidden or body.get("hidden") is True
        inner = Scope(compiled, full, prefix, place, selection, dict(bound.values), bound.failed, chain, hidden)
        self._output.prefixes[full] = prefix
        mark = run.mark(unit.body.path)
        self.expand(inner, bound)
        self._anchor(full, body, mark, selection, scope)

    def _argument(self, made: Written, selection: Selection, scope: Scope, run: Run) -> Argument:
        value = made.make(run)
        turned: dict[Path, tuple[int, ...]] = {}
        if selection is not None and is_varying(value):
            value, wrong = self._scenes.by_scene(value, selection, (), turned)
            if wrong is not None:
                message = f"`per_scene` must have {len(selection)} values, one for each scene of the instance"
                run.report("SC106", message, (*made.path, *wrong))
        return Argument(value, run.mark(made.path), made.part.document, scope.name, turned)

    def _anchor(self, full: str, body: dict[str, Any], mark: Mark, selection: Selection, scope: Scope) -> None:
        """The frame in which an instance stands."""
        output = self._output
        # A prefab without a prefix may hold an entity of the instance's own name, which then has it.
        is_taken = full in output.sections["entities"] and full in output.scopes and output.scopes[full] != scope.name
        anchor = f"{full}/instance" if is_taken else full
        output.anchors[full] = anchor
        node = {"pose": body["pose"]} if "pose" in body else _NOWHERE
        if not output.add("frames", anchor, node, mark):
            return
        if scope.name:
            output.scopes[anchor] = scope.name
        if selection is not None:
            output.selections[anchor] = selection


def _spelled(made: Written, key: str, pattern: str, run: Run) -> str | None:
    """A text that must fit a pattern; None where it was reported. `key`: where it is written."""
    text = made.make(run)
    if isinstance(text, str) and re.fullmatch(pattern, text):
        return text
    if is_varying(text):
        run.report("SC203", f"`{key}` cannot read what differs from scene to scene", made.path)
    elif not isinstance(text, Failed):
        run.report("SC107", f"{show(text)} is not a name", made.path, hint=SPELLINGS[pattern])
    return None
