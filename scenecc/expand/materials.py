"""Materials as values of parameters: a name means a material of the file that gives it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest
from scenecc.expand.expansion import Mark
from scenecc.expand.output import Output, scoped
from scenecc.spec.plain import is_mapping

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.expand.arguments import Argument

ABSOLUTE = "/"
"""What a name begins with that means the same in every scope."""


def material_name(argument: Argument, key: str, output: Output, sink: Sink) -> Any:
    """What stands for a material argument: a name that any scope understands.

    Args:
        argument: a name, or a mapping.
        key: what a mapping is called among the materials of the scope that gives it.
        output: takes it.
        sink: takes the diagnostics.
    """
    value, place = argument.value, argument.place
    materials = output.sections["materials"]
    if is_mapping(value):
        name = scoped(argument.scope, key)
        while name in materials:
            name += "_"
        output.add("materials", name, value, place if isinstance(place, Mark) else Mark(place.file, ()))
        output.used_materials.add(name)
        return ABSOLUTE + name
    if not isinstance(value, str) or value.startswith(ABSOLUTE):
        return value
    name = scoped(argument.scope, value)
    if name in materials:
        output.used_materials.add(name)
        return ABSOLUTE + name
    prefix = scoped(argument.scope, "")
    known = [
        other[len(prefix) :] for other in materials if other.startswith(prefix) and "/" not in other[len(prefix) :]
    ]
    hint = suggest(value, known) or "a material is named under `materials` or written inline"
    message = f"there is no material `{cut(value)}`"
    sink.report("SC301", message, argument.told, hint=hint)
    return value
