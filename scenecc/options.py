"""Options that callers choose, declared once, and checks of the arguments that they give."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from operator import index
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typing_extensions import TypedDict

from scenecc.source import Limits, make_limits
from scenecc.source.paths import asset_roots as search_path

if TYPE_CHECKING:
    from collections.abc import Sequence


class CompileOptions(TypedDict, total=False):
    """The options of every function that compiles a scene, as keywords.

    Attributes:
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: values of the file's parameters.
        draws: values of the file's shared draws, one row a scene.
        asset_roots: folders in which `asset://` is looked up, before those of `SCENECC_ASSET_PATH`.
        allow_outside_assets: let paths leave the scene's folder and the asset roots.
        limits: limits to raise or lower, by name; see `docs/language.md`.
    """

    num_scenes: int | None
    seed: int | None
    params: Mapping[str, Any] | None
    draws: Mapping[str, Any] | None
    asset_roots: Iterable[str | PathLike[str]]
    allow_outside_assets: bool
    limits: Mapping[str, int] | None


@dataclass(frozen=True, slots=True)
class Options:
    """`CompileOptions`, checked."""

    num_scenes: int | None = None
    seed: int | None = None
    params: Mapping[str, Any] = field(default_factory=dict[str, Any])
    draws: Mapping[str, Any] = field(default_factory=dict[str, Any])
    asset_roots: tuple[Path, ...] = ()
    allow_outside_assets: bool = False
    limits: Limits = field(default_factory=Limits)

    @classmethod
    def of(
        cls,
        *,
        num_scenes: int | None = None,
        seed: int | None = None,
        params: Mapping[str, Any] | None = None,
        draws: Mapping[str, Any] | None = None,
        asset_roots: Iterable[str | PathLike[str]] = (),
        allow_outside_assets: bool = False,
        limits: Mapping[str, int] | None = None,
    ) -> Options:
        """Checks them.

        Raises:
            ValueError: one is out of its range.
            TypeError: a number is no integer, or `params` or `draws` no mapping.
        """
        return cls(
            None if num_scenes is None else integer(num_scenes, "num_scenes", 1),
            None if seed is None else integer(seed, "seed", 0),
            _by_name(params, "params"),
            _by_name(draws, "draws"),
            search_path(_folders(asset_roots)),
            flag(allow_outside_assets, "allow_outside_assets"),
            make_limits(_by_name(limits, "limits")),
        )

    @classmethod
    def of_call(
        cls, function: Callable[..., object], given: Mapping[str, Any], declared: type[Any] = CompileOptions
    ) -> Options:
        """The compile options among the keyword arguments of a function.

        Args:
            function: the public function, which error messages name.
            given: its `**` arguments.
            declared: the TypedDict of these.

        Raises:
            TypeError: as of `check_keywords` and `of`.
            ValueError: as of `of`.
        """
        check_keywords(function, given, declared)
        return cls.of(**{name: given[name] for name in CompileOptions.__annotations__ if name in given})


def check_keywords(function: Callable[..., object], given: Iterable[str], declared: type[Any] = CompileOptions) -> None:
    """Raises TypeError for a keyword that a function does not take, with the nearest one that it takes.

    Args:
        function: the public function.
        given: the names of its `**` arguments.
        declared: the TypedDict of these.
    """
    unknown = next((name for name in given if name not in declared.__annotations__), None)
    if unknown is None:
        return
    from inspect import signature

    from scenecc.diagnostics.messages import suggest

    own = [name for name, one in signature(function).parameters.items() if one.kind is one.KEYWORD_ONLY]
    hint = suggest(unknown, (*own, *declared.__annotations__))
    raise TypeError(f"{function.__qualname__}() has no argument `{unknown}`; {hint}")


def _folders(given: Any) -> list[str | PathLike[str]]:
    several: list[Any] = [given] if isinstance(given, str | PathLike) or not isinstance(given, Iterable) else [*given]
    if not all(isinstance(one, str | PathLike) for one in several):
        raise TypeError(f"asset_roots must be folders, as paths, not {given!r}")
    return several


def _by_name(given: Mapping[str, Any] | None, name: str) -> dict[str, Any]:
    if given is not None and not isinstance(given, Mapping):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"{name} must be a mapping from names to values, not {given!r}")
    return dict(given or {})


def integer(value: object, name: str, least: int) -> int:
    """An argument that is an integer, Python's or numpy's.

    Raises:
        TypeError: it is none; True and False are none either.
        ValueError: it is below `least`.
    """
    try:
        number = None if _is_flag(value) else index(value)  # pyright: ignore[reportArgumentType] - asked, not assumed
    except TypeError:
        number = None
    if number is None:
        raise TypeError(f"{name} must be an integer, not {value!r}")
    if number < least:
        raise ValueError(f"{name} must be at least {least}, not {number}")
    return number


def flag(value: object, name: str) -> bool:
    """An argument that is True or False, Python's or numpy's. Raises TypeError where it is neither."""
    if not _is_flag(value):
        raise TypeError(f"{name} must be True or False, not {value!r}")
    return bool(value)


def _is_flag(value: object) -> bool:
    """By its type's name: numpy 1 and 2 call their flag otherwise, and numpy may not be loaded at all."""
    return type(value).__name__ in {"bool", "bool_"}


def indices(values: Iterable[Any], name: str) -> list[int]:
    """An argument that names several things by their indices.

    Raises:
        TypeError: it is not several integers.
        ValueError: one is negative.
    """
    if isinstance(values, str | bytes) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name} must be integers, as in [0, 2] or range(4), not {values!r}")
    return [integer(each, f"an index in {name}", 0) for each in values]


def check_scene_idxs(given: Iterable[Any]) -> tuple[int, ...]:
    """The indices as Python's integers, in the order given.

    Raises:
        TypeError: it is not several integers. A mask of booleans is refused too: as indices it would name scenes 0
            and 1.
        ValueError: one is given twice.
    """
    if isinstance(given, str | bytes) or not hasattr(given, "__iter__"):
        raise TypeError(f"scene_idxs are scene indices, as in [0, 2] or range(4), not {given!r}")
    indices: list[int] = []
    for item in given:
        if _is_bool(item):
            raise TypeError("scene_idxs are scene indices, not a mask: take numpy.flatnonzero(mask)")
        indices.append(_check_integer(item, "a scene index"))
    if len(set(indices)) != len(indices):
        raise ValueError(f"scene_idxs name a scene twice: {indices}")
    return tuple(indices)


def check_seeds(seed: int | Iterable[int] | None, last: Sequence[int]) -> tuple[int, ...]:
    """A seed for each of some scenes: one for all, one for each, or None for those that they had last.

    Raises:
        TypeError: one is no integer.
        ValueError: one is negative, or there are more or fewer than scenes.
    """
    if seed is None:
        return tuple(last)
    if isinstance(seed, Iterable) and not isinstance(seed, str | bytes):
        seeds = tuple(_check_seed(each) for each in seed)
        if len(seeds) != len(last):
            raise ValueError(f"{len(seeds)} seeds for {len(last)} scenes")
        return seeds
    return (_check_seed(seed),) * len(last)


def _check_seed(given: object) -> int:
    seed = _check_integer(given, "a seed")
    if seed < 0:
        raise ValueError(f"a seed is not negative, as {seed} is")
    return seed


def _check_integer(given: Any, what: str) -> int:
    try:
        if not _is_bool(given):
            return operator.index(given)
    except TypeError:
        pass
    raise TypeError(f"{what} is an integer, not {given!r}")


def _is_bool(given: object) -> bool:
    # By its name: numpy 1 and 2 call theirs otherwise.
    return type(given).__name__ in {"bool_", "bool"}
