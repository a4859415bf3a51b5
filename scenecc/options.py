"""The options of the API, each declared once, and checks of arguments."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from numbers import Real
from operator import index
from os import PathLike, fspath
from os.path import isdir, lexists
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Any, Literal, Union, cast, get_args, get_origin, get_type_hints

from typing_extensions import TypedDict

from scenecc.source import Limits, make_limits
from scenecc.source.paths import asset_roots as search_path

if TYPE_CHECKING:
    from scenecc.variation.chosen import DrawRecord


class EnvironmentOptions(TypedDict, total=False):
    """`CompileOptions` without `num_scenes`, because a ManiSkill environment sets it."""

    seed: int | None
    params: Mapping[str, Any] | None
    draws: Mapping[str, Any] | None
    starts: str | PathLike[str] | None
    asset_roots: Iterable[str | PathLike[str]]
    allow_outside_assets: bool
    limits: Mapping[str, int] | None


class CompileOptions(EnvironmentOptions, total=False):
    """The keyword options of every function that compiles a scene.

    Attributes:
        num_scenes: number of scenes, overriding the file.
        seed: seed, overriding the file.
        params: values of the file's parameters.
        draws: values of the file's shared draws, one row per scene.
        starts: file of starts from `settle_scene` or `cover_scene`, where the scenes begin, overriding the file.
        asset_roots: folders to search for `asset://` paths, before those of `SCENECC_ASSET_PATH`.
        allow_outside_assets: allow paths outside the scene's folder and the asset roots.
        limits: limits to change, by name; see `docs/reference/language.md`.
    """

    num_scenes: int | None


@dataclass(frozen=True, slots=True)
class Options:
    """Checked `CompileOptions`.

    `at_starts`: whether the scenes begin at the starts of a file, if any is named. `settle_scene` ignores them.
    `record`: numbers that replace random ones, and what lowering records; None: those of the starts.
    """

    num_scenes: int | None = None
    seed: int | None = None
    params: Mapping[str, Any] = field(default_factory=dict[str, Any])
    draws: Mapping[str, Any] = field(default_factory=dict[str, Any])
    starts: Path | None = None
    asset_roots: tuple[Path, ...] = ()
    allow_outside_assets: bool = False
    limits: Limits = field(default_factory=Limits)
    at_starts: bool = True
    record: DrawRecord | None = None

    @classmethod
    def of(
        cls,
        *,
        num_scenes: int | None = None,
        seed: int | None = None,
        params: Mapping[str, Any] | None = None,
        draws: Mapping[str, Any] | None = None,
        starts: str | PathLike[str] | None = None,
        asset_roots: Iterable[str | PathLike[str]] = (),
        allow_outside_assets: bool = False,
        limits: Mapping[str, int] | None = None,
    ) -> Options:
        """Returns checked options. Only ranges are checked here; `check_keywords` checks types.

        Raises:
            ValueError: an option is out of range, an asset root is not a folder, or a path contains a null character.
            TypeError: a number is not an integer, or a folder is not a path.
        """
        roots = _folders(asset_roots)
        if (fault := folder_fault(roots)) is not None:
            raise ValueError(f"asset_roots: {fault}")
        if starts is not None and "\0" in fspath(starts):
            raise ValueError(f"starts must not contain a null character: {starts!r}")
        return cls(
            None if num_scenes is None else integer(num_scenes, "num_scenes", 1),
            None if seed is None else integer(seed, "seed", 0),
            dict(params or {}),
            dict(draws or {}),
            None if starts is None else Path(starts),
            search_path(roots),
            bool(allow_outside_assets),
            make_limits(limits),
        )

    @classmethod
    def of_call(
        cls, function: Callable[..., object], given: Mapping[str, Any], declared: type[Any] = CompileOptions
    ) -> Options:
        """Returns the compile options among the keyword arguments of a function.

        Args:
            function: the public function, for error messages.
            given: its `**` arguments.
            declared: the TypedDict of these arguments.

        Raises:
            TypeError: as in `check_keywords` and `of`.
            ValueError: as in `of`.
        """
        check_keywords(function, given, declared)
        return cls.of(**{name: given[name] for name in CompileOptions.__annotations__ if name in given})


def check_keywords(
    function: Callable[..., object], given: Mapping[str, Any], declared: type[Any] = CompileOptions
) -> None:
    """Checks the `**` arguments of a public function against their declaration.

    Args:
        function: the public function, for error messages.
        given: its `**` arguments.
        declared: the TypedDict of these arguments.

    Raises:
        TypeError: a keyword is unknown (the message gives the nearest one), or as in `check_types`.
        ValueError: as in `check_types`.
    """
    unknown = next((name for name in given if name not in declared.__annotations__), None)
    if unknown is None:
        check_types(function, given, _types_of(declared))
        return
    from inspect import signature

    from scenecc.diagnostics.messages import suggest

    own = [name for name, one in signature(function).parameters.items() if one.kind is one.KEYWORD_ONLY]
    known = (*own, *declared.__annotations__)
    meant = _OTHER_NAMES.get(unknown, "")
    hint = _REMOVED.get(unknown) or (
        f"did you mean `{meant}`?" if meant in known else suggest(unknown, known, "its help")
    )
    raise TypeError(f"{function.__qualname__}() has no argument `{unknown}`; {hint}")


_REMOVED: Mapping[str, str] = {
    "backend": "SAPIEN's scenes are built on the CPU; for thousands of scenes on a GPU use `scenecc.maniskill`"
}
"""Removed arguments, and what to use instead."""

_OTHER_NAMES: Mapping[str, str] = {"scenes": "scene_idxs"}
"""Argument names of other functions → the name that this function may have instead."""

_types_of = cache(get_type_hints)


def check_types(function: Callable[..., object], given: Mapping[str, Any], types: Mapping[str, Any]) -> None:
    """Checks the types of arguments of a public function.

    Args:
        function: the public function, for error messages.
        given: arguments by name.
        types: their annotated types by name. The items of an iterator are not checked here, but when it is read.

    Raises:
        TypeError: a value has the wrong type. True and False are not integers.
        ValueError: a string is not one of the allowed values.
    """
    for name, value in given.items():
        if not _is_of_type(value, types[name]):
            wanted = _type_words(types[name])
            error = ValueError if isinstance(value, str) and wanted.startswith("one of ") else TypeError
            raise error(f"{function.__qualname__}(): {name} must be {wanted}, not {value!r}")


def path_argument(function: Callable[..., object], name: str, value: Any) -> Path:
    """Returns a path argument of a public function as a `Path`.

    Raises:
        TypeError: it is not a path.
        ValueError: it contains a null character.
    """
    check_types(function, {name: value}, {name: str | PathLike[str]})
    if "\0" in fspath(value):
        raise ValueError(f"{function.__qualname__}(): {name} must not contain a null character: {value!r}")
    return Path(value)


_TYPE_WORDS: Mapping[Any, str] = {
    bool: "True or False",
    int: "an integer",
    float: "a number",
    str: "a string",
    PathLike: "a path",
    Callable: "a function",
    Mapping: "a mapping from names to values",
    tuple[int, int]: "two integers",
    tuple[float, float, float]: "three numbers",
    Iterable[int]: "integers, as in [0, 2] or range(4)",
    Iterable[str]: 'names, as in ["a", "b"]',
    Iterable: "paths of folders",
}


def _type_words(kind: Any) -> str:
    origin = get_origin(kind) or kind
    if origin is Literal:
        return f"one of {', '.join(map(str, get_args(kind)))}"
    if origin in _UNIONS:
        return " or ".join(_type_words(one) for one in get_args(kind) if one is not NoneType)
    return _TYPE_WORDS.get(kind) or _TYPE_WORDS.get(origin) or f"a {origin.__name__}"


_UNIONS = (Union, UnionType)


def _is_of_type(value: Any, kind: Any) -> bool:
    origin, parts = get_origin(kind) or kind, get_args(kind)
    check = _TYPE_CHECKS.get(origin)
    return isinstance(value, origin) if check is None else check(value, parts)


def _is_several(value: Any, parts: tuple[Any, ...]) -> bool:
    """Returns whether a value is an iterable of the type, or a single path where several are allowed. Iterators are not
    read.
    """
    if isinstance(value, str | PathLike):
        return _is_of_type(value, parts[0])
    if not isinstance(value, Collection):
        return isinstance(value, Iterable)
    return all(_is_of_type(one, parts[0]) for one in cast("Collection[Any]", value))


def _is_row(value: Any, parts: tuple[Any, ...]) -> bool:
    if not isinstance(value, tuple | list):
        return False
    items = cast("Sequence[Any]", value)
    return len(items) == len(parts) and all(map(_is_of_type, items, parts))


_TYPE_CHECKS: Mapping[Any, Callable[[Any, tuple[Any, ...]], bool]] = {
    **dict.fromkeys(_UNIONS, lambda value, parts: any(_is_of_type(value, one) for one in parts)),
    Literal: lambda value, parts: isinstance(value, str) and value in parts,
    bool: lambda value, _parts: _is_flag(value),
    int: lambda value, _parts: _integer(value) is not None,
    float: lambda value, _parts: isinstance(value, Real) and not _is_flag(value),
    tuple: _is_row,
    Iterable: _is_several,
}
"""Checks for types that `isinstance` does not cover."""


def _folders(given: Any) -> list[str | PathLike[str]]:
    several: list[Any] = [given] if isinstance(given, str | PathLike) else [*given]
    for one in several:
        if not isinstance(one, str | PathLike):
            raise TypeError(f"asset_roots must be paths of folders, not {one!r}")
        if "\0" in fspath(one):
            raise ValueError(f"asset_roots must not contain a null character: {one!r}")
    return several


def folder_fault(roots: Iterable[str | PathLike[str]]) -> str | None:
    """Returns why a path is not a folder to search; None if all are."""
    for root in roots:
        if not isdir(root):  # noqa: PTH112 - False without access, where `Path.is_dir` raises
            is_there = lexists(root)
            return f"`{fspath(root)}` is not a folder" if is_there else f"there is no folder `{fspath(root)}`"
    return None


def integer(value: object, name: str, least: int) -> int:
    """Returns an integer argument, Python's or numpy's, as an int.

    Raises:
        TypeError: it is not an integer; True and False are not integers either.
        ValueError: it is below `least`.
    """
    number = _integer(value)
    if number is None:
        raise TypeError(f"{name} must be an integer, not {value!r}")
    if number < least:
        raise ValueError(f"{name} must be at least {least}, not {number}")
    return number


def _integer(value: Any) -> int | None:
    try:
        return None if _is_flag(value) else index(value)
    except TypeError:
        return None


def _is_flag(value: object) -> bool:
    """Checks the name of the type: numpy 1 and 2 name their bool differently, and numpy may not be loaded."""
    return type(value).__name__ in {"bool", "bool_"}


def read_indices(values: Iterable[Any], name: str) -> list[int]:
    """Returns an argument of indices as a list of ints.

    Raises:
        TypeError: an index is not an integer.
        ValueError: an index is negative.
    """
    return [integer(each, f"an index in {name}", 0) for each in values]


def check_scene_idxs(given: Iterable[Any]) -> tuple[int, ...]:
    """Returns scene indices as Python ints, in the given order.

    Raises:
        TypeError: it is not an iterable of integers. Boolean masks are rejected: as indices they would mean scenes 0
            and 1.
        ValueError: an index is given twice.
    """
    if isinstance(given, str | bytes) or not hasattr(given, "__iter__"):
        raise TypeError(f"scene_idxs must be scene indices, as in [0, 2] or range(4), not {given!r}")
    indices: list[int] = []
    for item in given:
        if _is_flag(item):
            raise TypeError("scene_idxs must be scene indices, not a mask: use numpy.flatnonzero(mask)")
        indices.append(_check_integer(item, "a scene index"))
    if len(set(indices)) != len(indices):
        raise ValueError(f"scene_idxs contains a scene twice: {indices}")
    return tuple(indices)


def check_seeds(seed: int | Iterable[int] | None, last: Sequence[int]) -> tuple[int, ...]:
    """Returns a seed for each of some scenes: one for all, one for each, or None for their last ones.

    Raises:
        TypeError: a seed is not an integer.
        ValueError: a seed is negative, or the number of seeds is not the number of scenes.
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
        raise ValueError(f"a seed must not be negative: {seed}")
    return seed


def _check_integer(given: Any, what: str) -> int:
    if (number := _integer(given)) is None:
        raise TypeError(f"{what} must be an integer, not {given!r}")
    return number
