"""Reads what episodes have drawn: the output of `scenecc draws`, the table of a sweep, starts, or lines of JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final, NamedTuple, cast

from scenecc.diagnostics.messages import cut
from scenecc.files import TooLongError, read_at_most

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

MOST_BYTES: Final = 2**30
"""Maximum size of a file of episodes."""

Cell = float | str
"""A drawn number (a flag is 0 or 1), or a text."""


class Episode(NamedTuple):
    """What one episode has drawn. `where`: its line or row, its seed and its scene, for messages."""

    where: str
    values: Mapping[str, Any]


class InvalidEpisodesError(ValueError):
    """A file has no drawn values."""


def read_episodes(path: Path) -> Iterator[Episode]:
    """Yields the episodes of a file: CSV, Parquet, JSON or one JSON object per line, by its suffix.

    Raises:
        InvalidEpisodesError: it is none of these, or an episode has no drawn values.
        OSError: it cannot be read.
    """
    try:
        content = read_at_most(path, MOST_BYTES)
    except TooLongError as error:
        raise InvalidEpisodesError(str(error.strerror)) from None
    suffix = path.suffix.lower()
    if suffix == ".parquet" or content[:4] == b"PAR1":
        return _of_parquet(content)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidEpisodesError("it is neither text in UTF-8 nor a Parquet table") from None
    return _of_csv(text) if suffix == ".csv" else _of_json(text)


def _of_parquet(content: bytes) -> Iterator[Episode]:
    pq: Any = import_module("pyarrow.parquet")
    try:
        table = pq.read_table(io.BytesIO(content))
        for number, row in enumerate(table.to_pylist()):
            yield _episode(row, f"row {number + 1}")
    except (ValueError, OSError) as error:
        if isinstance(error, InvalidEpisodesError):
            raise
        raise InvalidEpisodesError("it is not a Parquet table") from None


def _of_csv(text: str) -> Iterator[Episode]:
    try:
        for number, row in enumerate(csv.DictReader(io.StringIO(text), strict=True)):
            if None in row or None in row.values():
                raise InvalidEpisodesError(f"line {number + 2} has another number of cells than the first line")
            yield _episode({name: _of_cell(cell) for name, cell in row.items()}, f"line {number + 2}")
    except csv.Error as error:
        raise InvalidEpisodesError(f"it is not CSV: {error}") from None


def _of_cell(cell: str) -> Any:
    if cell in {"", "true", "false"}:
        return {"": None, "true": True, "false": False}[cell]
    try:
        return float(cell)
    except ValueError:
        return cell


def _of_json(text: str) -> Iterator[Episode]:
    try:
        data: Any = json.loads(text)
    except RecursionError:
        raise InvalidEpisodesError("it is nested too deeply") from None
    except ValueError:
        yield from _of_lines(text)
        return
    if isinstance(data, dict):
        members = cast("dict[str, Any]", data)
        data = members.get("draws") if isinstance(members.get("draws"), list) else members.get("rows", [members])
    if not isinstance(data, list):
        raise InvalidEpisodesError("it has no list of episodes")
    for number, row in enumerate(cast("list[Any]", data)):
        yield _episode(row, f"episode {number + 1}")


def _of_lines(text: str) -> Iterator[Episode]:
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        try:
            data: Any = json.loads(line)
        except (ValueError, RecursionError):
            raise InvalidEpisodesError(f"line {number} is not JSON") from None
        yield _episode(data, f"line {number}")


def _episode(row: Any, where: str) -> Episode:
    """Returns an episode from a mapping of its values, or one that contains it as `values` or `draws`."""
    if not isinstance(row, dict):
        raise InvalidEpisodesError(f"{where} is not a mapping from names to values")
    given = cast("dict[str, Any]", row)
    if "scenecc_passport" in given:
        raise InvalidEpisodesError(f'{where} is a passport, which has no drawn values; write `info["draws"]` beside it')
    known = [f"{name} {cut(str(given[name]))}" for name in ("seed", "scene") if given.get(name) is not None]
    where = f"{where} ({', '.join(known)})" if known else where
    for key in ("values", "draws"):
        inner = given.get(key, "")
        if isinstance(inner, str):
            try:
                inner = json.loads(inner)
            except (ValueError, RecursionError):
                continue  # a draw of this name
        if isinstance(inner, int | float):
            continue
        values = cast("dict[str, Any]", inner) if isinstance(inner, dict) else None
        if values is None or (values and all(isinstance(one, dict) for one in values.values())):
            raise InvalidEpisodesError(f"`{key}` of {where} is not a mapping from names to drawn values")
        return Episode(where, values)
    return Episode(where, given)


def to_cell(item: Any) -> Cell | None:
    """Returns a number rounded to 6 digits, in which float32 and text agree, or a text; None for anything else."""
    if isinstance(item, str):
        return math.inf if item == "inf" else -math.inf if item == "-inf" else item
    if not isinstance(item, int | float):
        return None
    try:
        number = float(item)
    except OverflowError:  # an integer of hundreds of digits
        return math.inf if item > 0 else -math.inf
    return None if math.isnan(number) else float(f"{number:.6g}") + 0.0


def flat_columns(values: Mapping[str, Any]) -> dict[str, Cell]:
    """Returns all numbers and texts of an episode by column."""
    found: dict[str, Cell] = {}
    todo: list[tuple[str, Any]] = [*values.items()]
    while todo:
        name, item = todo.pop()
        item = item.tolist() if hasattr(item, "tolist") else item
        if isinstance(item, list | tuple):
            todo += [(f"{name}[{number}]", one) for number, one in enumerate(cast("list[Any]", item))]
        elif (cell := to_cell(item)) is not None:
            found[name] = cell
    return found
