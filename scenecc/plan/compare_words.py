"""What two plans have in a field, in few words that differ where the values do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.plan.value_words import (
    color_words,
    is_any_rotation,
    item_words,
    pair_words,
    part_of,
    set_words,
    support_words,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from scenecc.plan.scene import ScenePlan
    from scenecc.plan.value import Value

_LONGEST: Final = 120
_COLORS: Final = frozenset({"base_color", "emission"})


def cut(text: str) -> str:
    """At most a line of it."""
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def rows_words(
    path: str,
    a: NDArray[Any],
    b: NDArray[Any],
    scenes: NDArray[np.int64],
    name: Callable[[int], str] | None = None,
) -> tuple[str, str]:
    """Two arrays of rows (B, …) that differ in each of the scenes (B,). `name`: what an index stands for."""
    show = _shown_as(path, name)
    first, second = ([_tupled(row) for row in rows.tolist()] for rows in (a, b))
    words = pair_words(first, second, show)
    if words[0] == words[1] and len(scenes) > 1:
        # The same values in other scenes: the first of these tells them apart.
        one = pair_words(first[:1], second[:1], show)
        words = (f"{one[0]} in scene {scenes[0]}, …", f"{one[1]} in scene {scenes[0]}, …")
    return words


def own_words(path: str, rows: NDArray[Any], name: Callable[[int], str] | None = None) -> str:
    """An array of rows (B, …) of which the other plan has nothing."""
    return set_words([_tupled(row) for row in rows.tolist()], _shown_as(path, name))


def _shown_as(path: str, name: Callable[[int], str] | None) -> Callable[[Any, int], str]:
    if name is not None:
        return lambda index, _: name(int(index))
    if path.rpartition(".")[2] == "gravity":
        return lambda disabled, _: item_words(not disabled)
    return item_words


def held_words(field: str, a: list[Any], b: list[Any], files: Sequence[str]) -> tuple[str | None, str | None]:
    """What materials hold in a field, of which None is nothing. `files`: names by number."""
    shown: Callable[[Any, int], str] = color_words if field in _COLORS else item_words
    if field.endswith(".file"):
        shown = lambda number, _: str(files[number])  # noqa: E731

    def show(item: Any, digits: int) -> str:
        return "left out" if item is None else shown(item, digits)

    words = pair_words(list(map(_tupled, a)), list(map(_tupled, b)), show)
    nothing = [all(item is None for item in items) for items in (a, b)]
    return None if nothing[0] else words[0], None if nothing[1] else words[1]


def reset_words(values: tuple[Value, Value], plans: tuple[ScenePlan, ScenePlan], part: slice | None) -> tuple[str, str]:
    """What resets can give in two plans that are the same as built. `part`: of each row."""
    first, second = (_reset_words(value, plan, part) for value, plan in zip(values, plans, strict=True))
    return first, f"{second}, drawn otherwise" if first == second else second


def _reset_words(value: Value, plan: ScenePlan, part: slice | None) -> str:
    from scenecc.variation.node_bounds import find_bounds  # noqa: PLC0415 - most plans have no recipes

    if value.recipe is None:
        return "as built"
    found = find_bounds(value.recipe, dict(plan.draws), num_scenes=plan.num_scenes)
    if part is not None and found.low is not None:
        found = part_of(found, part.start, part.stop)
        if part.start and is_any_rotation(found):
            return "any rotation at reset"
    within = "" if found.exact or found.alternatives is not None or found.low is None else "within "
    return f"{within}{support_words(found)} at reset"


def _tupled(item: Any) -> Any:
    return tuple(map(_tupled, item)) if isinstance(item, list) else item  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
