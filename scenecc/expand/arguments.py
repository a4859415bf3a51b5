"""The values of a file's parameters, for one use of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Location, Origin
from scenecc.diagnostics.messages import cut, nearest, suggest
from scenecc.expand.contents import count_values, has_failed, is_varying
from scenecc.expand.expansion import Mark
from scenecc.expand.ranges import form_of, varying_misfit
from scenecc.expand.run import Run
from scenecc.spec.param_types import kind_of
from scenecc.spec.plain import is_mapping, is_sequence

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from collections.abc import Set as AbstractSet

    from scenecc.diagnostics import Path, Sink
    from scenecc.expand.compiled import CompiledModule
    from scenecc.expand.documents import SceneDocument
    from scenecc.expand.params import Param
    from scenecc.expand.run import Budget
    from scenecc.spec.param_types import Misfit, ParamType


@dataclass(frozen=True, slots=True)
class Argument:
    """A value for a parameter.

    Attributes:
        value: plain, a form, or a template.
        place: where it is given.
        document: whose paths it holds.
        scope: in which the names in it mean something.
        by_scene: its lists that were turned into mappings, as `scenecc.expand.expansion.Record` has them.
        wanted: what its parameter takes; None where that is anything, or is not known yet.
    """

    value: Any
    place: Mark | Location
    document: SceneDocument
    scope: str
    by_scene: Mapping[Path, tuple[int, ...]] | None = None
    wanted: ParamType | None = None

    @property
    def told(self) -> Origin | Location:
        """The place as it is told."""
        return self.place.origin if isinstance(self.place, Mark) else self.place


@dataclass(frozen=True, slots=True)
class Bound:
    """The values of parameters.

    Attributes:
        values: of those that are the same in every scene.
        varying: those that are not.
        failed: those without a value, which was reported.
    """

    values: dict[str, Any]
    varying: dict[str, Argument]
    failed: frozenset[str]


def bind_params(
    compiled: CompiledModule,
    given: Mapping[str, Argument],
    constants: Mapping[str, Any],
    *,
    scope: str,
    use: Origin | Location | None,
    material: Callable[[Param, Argument], Any],
    objects: Budget,
    sink: Sink,
) -> Bound:
    """The values of all parameters of a module; what is wrong is reported.

    Args:
        compiled: the module.
        given: parameter → argument.
        constants: what expressions may read beside earlier parameters.
        scope: of the module.
        use: the `use` of a prefab; where the arguments come from, for the top module.
        material: names the material that is given to a parameter.
        objects: how many may still be made.
        sink: takes the diagnostics.
    """
    _known(compiled, given, sink)
    values = dict(constants)
    varying: dict[str, Argument] = {}
    failed = set(compiled.module.section("params")) - compiled.params.keys()
    parent = use if isinstance(use, Origin) else None
    for name, declared in compiled.params.items():
        param = declared
        argument = given.get(name)
        if argument is None or param.kind is None:
            default = _default(param, values, failed, scope, parent, objects, sink)
            if default is not None and param.kind is None and not is_varying(default.value):
                param = replace(param, kind=kind_of(default.value))
            argument = argument or default
        if argument is None:
            _required(param, use, parent, sink)
            failed.add(name)
            continue
        # Before anything looks through it: lists of lists that expressions make grow from use to use.
        objects.take_for(count_values(argument.value, objects.most_values), argument.told, sink)
        if has_failed(argument.value):
            failed.add(name)
            continue
        wanted = param.takes()
        wrong = wanted and varying_misfit(argument.value, wanted)
        if wanted is not None and wrong is not None:
            failed.add(name)
            _refuse(replace(wanted, declared=_declared(param, argument, parent)), argument, wrong, sink)
            continue
        value = _inside(param, argument, compiled, material)
        if is_varying(value):
            wanted = wanted and replace(wanted, declared=_declared(param, argument, parent))
            varying[name] = replace(argument, value=value, wanted=wanted)
        else:
            values[name] = value
    return Bound(values, varying, frozenset(failed))


def _known(compiled: CompiledModule, given: Mapping[str, Argument], sink: Sink) -> None:
    for name, argument in given.items():
        # A declaration that was reported may have been meant.
        if name not in compiled.module.section("params"):
            message = f"there is no parameter `{cut(name)}`"
            hint = suggest(name, compiled.params)
            sink.report("SC210", message, argument.told, at="key", hint=hint, path=(name,))


def _default(
    param: Param,
    values: dict[str, Any],
    failed: AbstractSet[str],
    scope: str,
    use: Origin | None,
    objects: Budget,
    sink: Sink,
) -> Argument | None:
    if param.default is None:
        return None
    run = Run(param.part.document.name, param.part.parent(use), values, objects, sink, failed)
    value = param.default if param.pattern is None else param.pattern.make(run)
    return Argument(value, run.mark(param.default_path), param.part.document, scope)


def _required(param: Param, use: Origin | Location | None, parent: Origin | None, sink: Sink) -> None:
    declared = Origin(param.part.document.name, param.path, "", param.part.parent(parent))
    hint = f"{param.description or 'it has no default'}; give it "
    hint += f"`with: {{{param.name}: …}}`" if parent is not None else f"--set {param.name}=…, or a `default`"
    place = declared if parent is None or use is None else use
    related = [("the parameter", declared, "key")] if place is not declared else []
    sink.report("SC213", f"the parameter `{cut(param.name)}` needs a value", place, hint=hint, related=related)  # pyright: ignore[reportArgumentType]


def _declared(param: Param, argument: Argument, parent: Origin | None) -> Origin | None:
    """Where a parameter is declared; None where the argument is its default, which stands there."""
    if isinstance(argument.place, Mark) and argument.place.path[:2] == param.path:
        return None
    return Origin(param.part.document.name, param.path, "", param.part.parent(parent))


def _refuse(wanted: ParamType, argument: Argument, wrong: Misfit, sink: Sink) -> None:
    code, words = wrong
    related = [("the parameter", wanted.declared, "key")] if wanted.declared is not None else []
    message = f"the parameter `{cut(wanted.name)}` {words}"
    near = None
    if isinstance(argument.value, str):
        near = nearest(argument.value, [option for option in wanted.options if isinstance(option, str)])
    hint = None if near is None else f"did you mean `{near}`?"
    sink.report(code, message, argument.told, hint=hint, related=related, path=(wanted.name,))  # pyright: ignore[reportArgumentType]


def _inside(
    param: Param, argument: Argument, compiled: CompiledModule, material: Callable[[Param, Argument], Any]
) -> Any:
    """The argument as it means the same inside the module: files where they lie, materials by their names."""
    if param.kind == "file":
        return _relocated(argument.value, argument.document, compiled)
    if param.kind == "material":
        return _each_name(argument.value, param, argument, material)
    return argument.value


def _relocated(value: Any, owner: SceneDocument, compiled: CompiledModule) -> Any:
    """A file, so that every document of the module finds it."""
    if all(owner.shares_folder(part.document) for part in compiled.module.parts):
        return value
    return map_alternatives(value, lambda item: owner.absolute(item) if isinstance(item, str) else item)


def _each_name(value: Any, param: Param, argument: Argument, material: Callable[[Param, Argument], Any]) -> Any:
    def named(item: Any) -> Any:
        return material(param, replace(argument, value=item))

    return map_alternatives(value, named)


def map_alternatives(value: Any, change: Callable[[Any], Any]) -> Any:
    """A value, plain or a form, with each of the alternatives that its form lists changed."""
    form = form_of(value)
    if form is None:
        return change(value)
    items = value[form]
    if is_mapping(items):
        changed: Any = {key: map_alternatives(item, change) for key, item in items.items()}
    elif is_sequence(items):
        changed = [map_alternatives(item, change) for item in items]
    else:
        changed = items
    return {**value, form: changed}
