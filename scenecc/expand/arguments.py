"""Binds the parameters of a module to arguments, for one use of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Location, Origin, Path
from scenecc.diagnostics.messages import cut, suggest
from scenecc.expand.documents import SceneDocument, count_values, has_failed, has_varying, iterate_texts
from scenecc.expand.expansion import ExpansionFrame, ExpansionWriter, ObjectBudget, SourceMark, scoped_name
from scenecc.expand.params import Param, form_key, varying_misfit
from scenecc.spec.nodes import EXPRESSION_START, child_at, is_mapping, is_sequence
from scenecc.spec.params import ParamIssue, ParamType, infer_param_kind
from scenecc.variation.forms import FORM_KEYS, ONCE, Template
from scenecc.variation.operations import ExpressionError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from collections.abc import Set as AbstractSet

    from scenecc.diagnostics import Sink
    from scenecc.expand.module_compiler import CompiledModule
    from scenecc.source import Document
    from scenecc.spec.references import NameScopes


@dataclass(frozen=True, slots=True)
class ParamArgument:
    """A value for a parameter.

    Attributes:
        value: plain data, a form or a template.
        place: its place in the source.
        document: base of its relative paths.
        scope: scope of the names in it.
        by_scene: see `scenecc.expand.expansion.TraceRecord`.
        wanted: type of its parameter; None if it takes any value or is not known yet.
    """

    value: Any
    place: SourceMark | Location
    document: SceneDocument
    scope: str
    by_scene: Mapping[Path, tuple[int, ...]] | None = None
    wanted: ParamType | None = None

    @property
    def told(self) -> Origin | Location:
        """The place for diagnostics."""
        return self.place.origin if isinstance(self.place, SourceMark) else self.place


@dataclass(frozen=True, slots=True)
class BoundParams:
    """The values of parameters.

    Attributes:
        values: values of parameters that are the same in every scene.
        varying: arguments that differ between scenes.
        failed: parameters with a reported error.
    """

    values: dict[str, Any]
    varying: dict[str, ParamArgument]
    failed: frozenset[str]


def bind_params(
    compiled: CompiledModule,
    given: Mapping[str, ParamArgument],
    constants: Mapping[str, Any],
    *,
    scope: str,
    use: Origin | Location | None,
    name_of: Callable[[Param, ParamArgument], Any],
    objects: ObjectBudget,
    sink: Sink,
) -> BoundParams:
    """Binds all parameters of a module and reports invalid arguments.

    Args:
        compiled: the module.
        given: arguments, by parameter.
        constants: names that defaults may read in addition to earlier parameters.
        scope: scope of the module.
        use: origin of the `use`; for the top module the place of the arguments.
        name_of: returns the name of the material or entity in an argument.
        objects: budget of objects.
        sink: receives diagnostics.
    """
    _check_known(compiled, given, sink)
    values = dict(constants)
    varying: dict[str, ParamArgument] = {}
    failed = set(compiled.module.section("params")) - compiled.params.keys()
    parent = use if isinstance(use, Origin) else None
    for name, declared in compiled.params.items():
        param = declared
        argument = given.get(name)
        if argument is None or param.kind is None:
            default = _default(param, values, failed, scope, parent, objects, sink)
            if default is not None and param.kind is None and not has_varying(default.value):
                param = replace(param, kind=infer_param_kind(default.value))
            argument = argument or default
        if argument is None:
            _report_missing(param, use, parent, sink)
            failed.add(name)
            continue
        # Before anything walks through it: nested lists made by expressions may grow with every use.
        objects.take_for(count_values(argument.value, objects.most_values), argument.told, sink)
        if has_failed(argument.value):
            failed.add(name)
            continue
        wanted = param.takes()
        wrong = wanted and varying_misfit(argument.value, wanted)
        if wanted is not None and wrong is not None:
            failed.add(name)
            _refuse(replace(wanted, declared=_find_declaration(param, argument, parent)), argument, wrong, sink)
            continue
        value = _relocate_argument(param, argument, compiled, name_of)
        if has_varying(value):
            wanted = wanted and replace(wanted, declared=_find_declaration(param, argument, parent))
            varying[name] = replace(argument, value=value, wanted=wanted)
        else:
            values[name] = value
    return BoundParams(values, varying, frozenset(failed))


def _check_known(compiled: CompiledModule, given: Mapping[str, ParamArgument], sink: Sink) -> None:
    for name, argument in given.items():
        # Declarations with errors count too: no second error for them.
        if name not in compiled.module.section("params"):
            message = f"there is no parameter `{cut(name)}`"
            hint = suggest(name, compiled.params, "`scenecc params FILE`")
            if name in compiled.module.section("draws"):
                hint = f'it is a draw: give values in Python, `draws={{"{cut(name)}": …}}`, or make it a parameter'
            sink.report("SC210", message, argument.told, at="key", hint=hint, path=(name,))


def _default(
    param: Param,
    values: dict[str, Any],
    failed: AbstractSet[str],
    scope: str,
    use: Origin | None,
    objects: ObjectBudget,
    sink: Sink,
) -> ParamArgument | None:
    if param.default is None:
        return None
    frame = ExpansionFrame(param.part.document.name, param.part.parent(use), values, objects, sink, failed)
    value = param.default if param.pattern is None else param.pattern.make(frame)
    return ParamArgument(value, frame.mark(param.default_path), param.part.document, scope)


def _report_missing(param: Param, use: Origin | Location | None, parent: Origin | None, sink: Sink) -> None:
    declared = Origin(param.part.document.name, param.path, "", param.part.parent(parent))
    hint = f"{param.description or 'it has no default'}; give it "
    hint += f"`with: {{{param.name}: …}}`" if parent is not None else f"--set {param.name}=…, or a `default`"
    place = declared if parent is None or use is None else use
    related = [("the parameter", declared, "key")] if place is not declared else []
    sink.report("SC213", f"the parameter `{cut(param.name)}` needs a value", place, hint=hint, related=related)  # pyright: ignore[reportArgumentType]


def _find_declaration(param: Param, argument: ParamArgument, parent: Origin | None) -> Origin | None:
    """Returns the origin of a parameter's declaration; None if the argument is its default."""
    if isinstance(argument.place, SourceMark) and argument.place.path[:2] == param.path:
        return None
    return Origin(param.part.document.name, param.path, "", param.part.parent(parent))


def _refuse(wanted: ParamType, argument: ParamArgument, wrong: ParamIssue, sink: Sink) -> None:
    from scenecc.spec.value_hints import choice_hint, color_hint, kind_hint  # noqa: PLC0415 - for errors

    code, words = wrong
    related = [("the parameter", wanted.declared, "key")] if wanted.declared is not None else []
    message = f"the parameter `{cut(wanted.name)}` {words}"
    hint, value = None, argument.value
    is_default = isinstance(argument.place, SourceMark) and argument.place.path[-1:] == ("default",)
    path = ("default" if is_default else wanted.name,)
    if wanted.kind == "choice" and isinstance(value, str):
        hint = choice_hint(value, [option for option in wanted.options if isinstance(option, str)])
    elif wanted.kind == "color":
        hint = color_hint(path, value)
    elif code == "SC211":
        hint = kind_hint(_KINDS.get(wanted.kind, ""), path, value)
    sink.report(code, message, argument.told, hint=hint, related=related, path=(wanted.name,))  # pyright: ignore[reportArgumentType]


_KINDS: Final = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "vector": "a list"}
"""Kind of a parameter → what its value must be, in the words of `kind_hint`."""


def _relocate_argument(
    param: Param, argument: ParamArgument, compiled: CompiledModule, name: Callable[[Param, ParamArgument], Any]
) -> Any:
    """Converts an argument so that its paths and names are valid inside the module."""
    if param.kind == "file":
        return _relocate_file(argument.value, argument.document, compiled)
    if param.kind in {"material", "entity"}:
        return _map_names(argument.value, param, argument, name)
    return argument.value


def _relocate_file(value: Any, owner: SceneDocument, compiled: CompiledModule) -> Any:
    """Converts a file path so that it is valid in every document of the module."""
    if all(owner.shares_folder(part.document) for part in compiled.module.parts):
        return value
    return map_alternatives(value, lambda item: owner.absolute(item) if isinstance(item, str) else item)


def _map_names(value: Any, param: Param, argument: ParamArgument, name: Callable[[Param, ParamArgument], Any]) -> Any:
    def named(item: Any) -> Any:
        return name(param, replace(argument, value=item))

    return map_alternatives(value, named)


def map_alternatives(value: Any, change: Callable[[Any], Any]) -> Any:
    """Applies `change` to a plain value, or to each alternative of a form."""
    form = form_key(value)
    if form is None:
        return change(value)
    items = value[form]
    if form == ONCE:
        changed: Any = map_alternatives(items, change)
    elif is_mapping(items):
        changed = {key: map_alternatives(item, change) for key, item in items.items()}
    elif is_sequence(items):
        changed = [map_alternatives(item, change) for item in items]
    else:
        changed = items
    return {**value, form: changed}


ABSOLUTE_PREFIX = "/"
"""Prefix of a name that is valid in every scope."""


def entity_name(argument: ParamArgument, names: NameScopes) -> Any:
    """Returns the absolute name of an entity argument."""
    value = argument.value
    if not isinstance(value, str) or value.startswith(ABSOLUTE_PREFIX):
        return value
    return f"{ABSOLUTE_PREFIX}{names.full_name(value, argument.scope)}"


def material_name(argument: ParamArgument, key: str, output: ExpansionWriter, sink: Sink) -> Any:
    """Returns the absolute name of a material argument. An inline material is added to `materials`.

    Args:
        argument: a name or a mapping.
        key: name for an inline material, in the argument's scope.
        output: receives the inline material.
        sink: receives diagnostics.
    """
    value, place = argument.value, argument.place
    materials = output.sections["materials"]
    if is_mapping(value):
        name = scoped_name(argument.scope, key)
        while name in materials:
            name += "_"
        output.add("materials", name, value, place if isinstance(place, SourceMark) else SourceMark(place.file, ()))
        output.names.used_materials.add(name)
        return ABSOLUTE_PREFIX + name
    if not isinstance(value, str) or value.startswith(ABSOLUTE_PREFIX):
        return value
    name = scoped_name(argument.scope, value)
    if name in materials:
        output.names.used_materials.add(name)
        return ABSOLUTE_PREFIX + name
    prefix = scoped_name(argument.scope, "")
    known = [
        other[len(prefix) :] for other in materials if other.startswith(prefix) and "/" not in other[len(prefix) :]
    ]
    hint = suggest(value, known) or "a material is named under `materials` or written inline"
    message = f"there is no material `{cut(value)}`"
    sink.report("SC301", message, argument.told, hint=hint)
    return value


_USE_KEY = ("use",)
_NAMED_NODE_DEPTH = 2
"""Length of a named node's path: section and name."""
_MAX_SCALARS = 200
"""Most strings that are searched for names. A larger node is not the value of a single key."""


def find_argument_origins(documents: Mapping[str | None, Document], origin: Origin) -> tuple[Origin, ...]:
    """Returns the origins of the prefab arguments that a reported value reads; empty if it reads none.

    Also empty for a whole entity, light or link, since a report about one is not about a single value.
    """
    if origin.parent is None or origin.file not in documents:
        return ()
    if _is_whole(_find_node(documents[origin.file].data, origin.path), origin.path):
        return ()
    return _argument_origins(documents, origin)


def _is_whole(node: Any, path: Path) -> bool:
    """Whether a node is a named node of a section, or a link of a tree."""
    if not is_mapping(node) or any(key in FORM_KEYS for key in node):
        return False
    return len(path) == _NAMED_NODE_DEPTH or path[-1:] == ("root",) or path[-2:-1] == ("children",)


def _argument_origins(documents: Mapping[str | None, Document], origin: Origin) -> tuple[Origin, ...]:
    """Returns the origins of the arguments that a node reads, then of those that they read themselves."""
    use = origin.parent
    if use is None or use.path[-1:] != _USE_KEY or origin.file not in documents or use.file not in documents:
        return ()
    instance = _find_node(documents[use.file].data, use.path[:-1])
    given = instance.get("with") if is_mapping(instance) else None
    places = {name: Origin(use.file, (*use.path[:-1], "with", name), use.copy, use.parent) for name in _keys(given)}
    places |= _override_origins(documents, use)
    if not places:
        return ()
    read: set[str] = set()
    for number, text in enumerate(iterate_texts(_find_node(documents[origin.file].data, origin.path))):
        if number == _MAX_SCALARS:
            return ()
        read |= _names(text)
    found = [place for name, place in places.items() if name in read]
    return (*found, *dict.fromkeys(outer for one in found for outer in _argument_origins(documents, one)))


def _override_origins(documents: Mapping[str | None, Document], use: Origin) -> dict[str, Origin]:
    """Returns the origins of the arguments that overrides of outer instances give to an instance, by name."""
    found: dict[str, Origin] = {}
    name, outer = str(use.path[1]), use.parent
    while outer is not None and outer.path[-1:] == _USE_KEY and outer.file in documents:
        path = (*outer.path[:-1], "override", name, "with")
        given = _find_node(documents[outer.file].data, path)
        found |= {key: Origin(outer.file, (*path, key), outer.copy, outer.parent) for key in _keys(given)}
        name, outer = f"{outer.path[1]}/{name}", outer.parent
    return found


def _keys(given: Any) -> Iterable[str]:
    return given if is_mapping(given) else ()


def _find_node(node: Any, path: Path) -> Any:
    """Returns the node at a path. Stops at a scalar, because an expression may return a list."""
    for segment in path:
        if not is_mapping(node) and not is_sequence(node):
            break
        node = child_at(node, segment)
    return node


def _names(text: str) -> frozenset[str]:
    if EXPRESSION_START not in text:
        return frozenset()
    try:
        template = Template.parse(text)
        return template.names.union(*(path.places for path in template.meshes.values()))
    except ExpressionError:
        return frozenset()
