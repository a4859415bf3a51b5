"""The materials that a file may have under other parameters than those that it is given."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.values.failure import ExpressionError
from scenecc.values.template import Template

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.expand.compiled import CompiledModule, WrittenUnit

_QUOTED = re.compile(r"'([^']*)'|\"([^\"]*)\"")
_NAMING = frozenset(("material", "with", "repeat"))
"""Keys below which a text may be the name of a material."""

_INLINE = frozenset(("physical", "visual"))
_NEVER_A_NAME = frozenset(("number", "integer", "boolean", "vector", "color", "file"))
"""Types of parameters that are no text, or none that names a material."""


def may_be_named(compiled: CompiledModule) -> set[str]:
    """The materials of a module that something in it names, or may name, whatever its parameters are.

    What is the same under all parameters is left out: whether it is used shows in the end.
    """
    materials = compiled.materials
    if not materials:
        return set()
    search = _Search(compiled)
    entries = compiled.module.section("entities")
    for unit in compiled.units:
        if _depends(unit):
            search.look(entries[unit.name].node, naming=False)
    return {*compiled.default_materials(), *search.found} & materials.keys()


def _depends(unit: WrittenUnit) -> bool:
    """Whether anything of an entity may be otherwise under other parameters."""
    return unit.body.pattern is not None or not (unit.axes is unit.condition is unit.use is None)


class _Search:
    """Looks through entities as they are written.

    Attributes:
        found: the texts that may name a material.
    """

    def __init__(self, compiled: CompiledModule) -> None:
        self.found: set[str] = set()
        self._materials = compiled.materials
        self._params = compiled.params

    def look(self, node: Any, *, naming: bool) -> None:
        """Looks through a node. `naming`: whether a text in it may be a name."""
        if isinstance(node, str):
            if naming:
                self.found.update(self._expressed(node) if "${" in node else (node,))
        elif is_mapping(node):
            if naming and not _INLINE.isdisjoint(node):
                return
            for key, item in node.items():
                if not key.startswith(NOTE_PREFIX):
                    self.look(item, naming=naming or key in _NAMING)
        elif is_sequence(node):
            for item in node:
                self.look(item, naming=naming)

    def _expressed(self, text: str) -> Iterable[str]:
        try:
            template = Template.parse(text)
        except ExpressionError:
            return ()
        parts = template.expressions()
        if len(parts) > 1:
            pattern = "".join(re.escape(part) if isinstance(part, str) else ".*" for part in parts)
            return filter(re.compile(pattern, re.DOTALL).fullmatch, self._materials)
        params = [self._params[name] for name in template.names if name in self._params]
        texts = [param for param in params if param.kind not in _NEVER_A_NAME]
        if not texts:
            return [one or other for one, other in _QUOTED.findall(text)]
        if texts[0].kind == "choice" and text[2:-1].strip() == texts[0].name:
            return [option for option in texts[0].options if isinstance(option, str)]
        return self._materials
