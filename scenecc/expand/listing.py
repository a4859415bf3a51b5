"""Lists the parameters of a file, and the built-in prefabs, without expansion."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import show
from scenecc.expand.documents import (
    PREFAB_FOLDER,
    SHIPPED_PREFIX,
    Load,
    edition_here,
    editions,
    is_within_object_limit,
    scene_loader,
    shipped_file,
    shipped_names,
    top_document,
)
from scenecc.expand.module_compiler import compile_module
from scenecc.expand.modules import ModuleLibrary
from scenecc.source import Document, Limits, read_file
from scenecc.source.paths import AssetScope
from scenecc.spec.parse import parse

if TYPE_CHECKING:
    from scenecc.expand.params import Param


@frozen
class ParamRow:
    """One parameter of a file.

    Attributes:
        name: its name.
        type: a parameter type, or "any".
        default: the default as YAML; None if a value is required.
        range: "0.1 to 2", "at least 1" or the options of a choice; "" for any value of the type.
        description: its description; "" if it has none.
        value: the default as plain data; None if a value is required.
        low, high: minimum and maximum as plain data; None for no bound.
        options: options of a choice, as plain data; empty for other types.
    """

    name: str
    type: str
    default: str | None
    range: str
    description: str
    value: Any = None
    low: Any = None
    high: Any = None
    options: tuple[Any, ...] = ()


@frozen
class PrefabRow:
    """One built-in prefab.

    Attributes:
        name: value for `use`: `scenecc:table`.
        params: parameters of the selected edition, in order.
        description: one line.
        editions: the Python packages for which the prefab has an edition, sorted.
        edition: the package of the selected edition; None for the plain prefab.
    """

    name: str
    params: tuple[ParamRow, ...]
    description: str
    editions: tuple[str, ...] = ()
    edition: str | None = None


def list_params(document: Document, *, load: Load, limits: Limits, sink: Sink) -> list[ParamRow] | None:
    """Returns the parameters of a document and its includes, in order; None if an error was reported.

    `load` is a `scenecc.expand.documents.scene_loader`. Sets `sink.locate`.
    """
    library = ModuleLibrary(load, limits.depth, sink)
    sink.locate = library.locate
    top = top_document(document)
    library.add(top)
    if not is_within_object_limit(document, limits, sink) or parse(document.data, Origin(document.name), sink) is None:
        return None
    module = library.module(top, None)
    params = compile_module(module, None, lambda _document, _uri, _place: None, sink).params if module.good else {}
    return None if sink.failed else [_row(param) for param in params.values()]


def list_prefabs() -> list[PrefabRow]:
    """Returns the built-in prefabs, sorted by name."""
    rows: list[PrefabRow] = []
    limits = Limits()
    for name in shipped_names():
        sink, scope = Sink(), AssetScope(PREFAB_FOLDER)
        edition = edition_here(name, scope)
        document = read_file(PREFAB_FOLDER / shipped_file(name, edition), sink, limits)
        assert document is not None, f"the prefab {name} cannot be read"
        load = scene_loader(scope, limits, sink)
        params = list_params(document, load=load, limits=limits, sink=sink)
        assert params is not None, f"the prefab {name} has errors"
        description = str(document.data.get("description", "")).split("\n", 1)[0]
        rows.append(PrefabRow(SHIPPED_PREFIX + name, tuple(params), description, tuple(editions(name)), edition))
    return rows


def _row(param: Param) -> ParamRow:
    default = None if param.default is None else _format_value(param.default)
    return ParamRow(
        param.name,
        param.kind or "any",
        default,
        _range(param),
        param.description,
        param.default,
        param.low,
        param.high,
        param.options,
    )


def _format_value(value: Any) -> str:
    """Formats a value as YAML on one line."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _range(param: Param) -> str:
    if param.options:
        return ", ".join(_format_value(option) for option in param.options)
    low, high = (None if bound is None else show(bound) for bound in (param.low, param.high))
    if low is not None and high is not None:
        return f"{low} to {high}"
    return f"at least {low}" if low is not None else f"at most {high}" if high is not None else ""
