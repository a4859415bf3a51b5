"""Writes and reads files of starts: JSON, with the rows in a Parquet table beside it above 1 MB."""

from __future__ import annotations

import io
import json
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, cast

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from scenecc.diagnostics.messages import show
from scenecc.extras import install_hint
from scenecc.files import TooLongError, read_at_most, unique_keys
from scenecc.variation.chosen import ChosenUnits, chosen_units
from scenecc.version import VERSION

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

LARGEST_INLINE: Final = 1_000_000
"""Bytes of rows in the JSON itself. More are in a table beside it."""

Index = Annotated[int, Field(ge=0)]
Pose = Annotated[list[float], Field(min_length=7, max_length=7)]


def _unit(numbers: list[float]) -> list[float]:
    if len(numbers) != 3 or numbers[0] not in {0, 1} or numbers[1] not in range(10_001) or not 0 <= numbers[2] < 1:
        raise ValueError("not a lane, a word and a number of it")
    return numbers


ChosenUnit = Annotated[list[float], AfterValidator(_unit)]


def _whole(made_from: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    if made_from.keys() != {"parts", "params", "files", "versions"}:
        raise ValueError("not a result of `fingerprint.fingerprint`")
    return made_from


def _distinct(rows: list[StartRecord]) -> list[StartRecord]:
    if len({(row.seed, row.scene) for row in rows}) < len(rows):
        raise ValueError("a scene occurs twice with one seed")
    choosing = [row.scene for row in rows if row.chosen]
    if choosing and (any(row.poses or row.joints for row in rows) or len({*choosing}) < len(rows)):
        raise ValueError("a file has either poses or chosen values")
    return rows


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class StartRecord(_Strict):
    """One start.

    Attributes:
        seed, scene: the scene, and the seed of all its draws.
        poses: entity → p [m], q (wxyz), in the world of the scene.
        joints: articulation → joint → position [m, rad].
        draws: what was drawn again for this start: path → value. For readers; a build draws it from the seed.
        chosen: key of a draw → (lane, word, u), which replace random numbers of this scene. Such a start has no poses.
    """

    seed: Index
    scene: Index
    poses: dict[str, Pose]
    joints: dict[str, dict[str, float]] = {}
    draws: dict[str, Any] = {}
    chosen: dict[str, list[ChosenUnit]] = {}


class StartsFile(_Strict):
    """The content of a file of starts.

    Attributes:
        scene: name of the scene.
        num_scenes: number of scenes that were built with each seed.
        made_from: result of `fingerprint.fingerprint`.
        rows: the starts, by seed and scene.
    """

    scene: str
    num_scenes: Annotated[int, Field(ge=1)]
    made_from: Annotated[dict[str, dict[str, Any]], AfterValidator(_whole)]
    rows: Annotated[list[StartRecord], AfterValidator(_distinct)]

    def chosen(self) -> dict[str, ChosenUnits]:
        """Returns key → numbers that replace random ones."""
        return chosen_units(
            (
                (
                    row.scene,
                    {key: [(int(one[0]), int(one[1]), one[2]) for one in units] for key, units in row.chosen.items()},
                )
                for row in self.rows
                if row.scene < self.num_scenes
            ),
            self.num_scenes,
        )


class InvalidStartsError(Exception):
    """A file is not a file of starts, or is damaged."""


def short_floats(numbers: Any) -> list[float]:
    """Returns float32 numbers as the shortest decimals that give them."""
    return [float(str(number)) for number in np.asarray(numbers, np.float32)]


def starts_files(content: StartsFile, name: str) -> dict[str, bytes]:
    """Returns the files of starts by name: the JSON, and the table if the rows are large.

    Args:
        content: the starts.
        name: file name of the JSON.

    Raises:
        ImportError: the rows are large, and pyarrow is not installed.
    """
    rows = [row.model_dump(exclude=None if row.chosen else {"chosen"}) for row in content.rows]
    head: dict[str, Any] = {"scenecc_starts": 1, **content.model_dump(exclude={"rows"})}
    lines = [_dumps(row) for row in rows]
    tables: dict[str, bytes] = {}
    if sum(map(len, lines)) > LARGEST_INLINE:
        table = _table_bytes(rows)
        head |= {"table": f"{Path(name).stem}.parquet", "table_sha256": sha256(table).hexdigest()}
        tables[head["table"]] = table
    members = [f'"{key}": {_dumps(item)}' for key, item in head.items()]
    members += ['"sha256": ""'] if tables else ['"sha256": ""', '"rows": [\n  ' + ",\n  ".join(lines) + "\n ]"]
    text = ("{\n " + ",\n ".join(members) + "\n}\n").encode()
    return {name: text.replace(_UNSIGNED, _UNSIGNED[:-1] + _digest(text) + b'"', 1), **tables}


def read_starts(path: Path, find: Callable[[str], Path], most: int) -> StartsFile:
    """Reads a file of starts.

    Args:
        path: of the JSON.
        find: returns the path of the table from its name.
        most: maximum size of each file [bytes].

    Raises:
        InvalidStartsError: it is not a file of starts, or was edited or cut.
        OSError: it cannot be read.
    """
    text = _read(path, most)
    data = _parse(text)
    digest = str(data.pop("sha256", "")).encode("utf-8", "replace")
    if not digest or _digest(text.replace(_UNSIGNED[:-1] + digest, _UNSIGNED[:-1], 1)) != digest:
        raise InvalidStartsError("it was changed or cut off after scenecc wrote it")
    if "table" in data:
        table, known = data.pop("table"), data.pop("table_sha256", None)
        if not isinstance(table, str) or table != Path(table).name or not table.isprintable():
            raise InvalidStartsError("`table` is not the name of a file beside it")
        content = _read(find(table), most)
        if sha256(content).hexdigest() != known:
            raise InvalidStartsError(f"its table `{table}` is another one, or was changed or cut off")
        try:
            data["rows"] = _table_rows(content)
        except (ValueError, LookupError, TypeError, AttributeError, NotImplementedError, OSError):
            raise InvalidStartsError(f"its table `{table}` is not what scenecc writes") from None
    del data["scenecc_starts"]
    try:
        return StartsFile.model_validate(data)
    except ValidationError as error:
        where = ".".join(map(str, error.errors(include_url=False)[0]["loc"]))
        raise InvalidStartsError(f"`{where}` is not what scenecc writes") from None


def _read(path: Path, most: int) -> bytes:
    try:
        return read_at_most(path, most)
    except TooLongError as error:
        raise InvalidStartsError(str(error.strerror)) from None


def _parse(text: bytes) -> dict[str, Any]:
    try:
        data: Any = json.loads(text, object_pairs_hook=unique_keys, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise InvalidStartsError("it is not JSON that `scenecc settle` or `cover` wrote") from None
    if not isinstance(data, dict) or "scenecc_starts" not in data:
        raise InvalidStartsError("it has no key `scenecc_starts`")
    known = cast("dict[str, Any]", data)
    number = known["scenecc_starts"]
    if type(number) is not int or number != 1:
        raise InvalidStartsError(f"it has version {show(number)}, and scenecc {VERSION} reads version 1")
    return known


def _refuse(word: str) -> None:
    raise ValueError(word)


def _dumps(data: Any) -> str:
    return json.dumps(data, ensure_ascii=False)


_UNSIGNED: Final = b'"sha256": ""'


def _digest(text: bytes) -> bytes:
    """Returns the hash of a text whose own hash is empty. Line ends do not count: git may change them."""
    return sha256(text.replace(b"\r\n", b"\n")).hexdigest().encode()


def _table_bytes(rows: Sequence[dict[str, Any]]) -> bytes:
    """Returns the rows as a Parquet table: poses and joint positions as maps to float32, draws as JSON."""
    pa, pq = import_module("pyarrow"), import_module("pyarrow.parquet")
    text, number = pa.string(), pa.float32()
    columns = {
        "seed": pa.array([str(row["seed"]) for row in rows], text),
        "scene": pa.array([row["scene"] for row in rows], pa.int32()),
        "poses": pa.array([[*row["poses"].items()] for row in rows], pa.map_(text, pa.list_(number))),
        "joints": pa.array(
            [[(name, [*positions.items()]) for name, positions in row["joints"].items()] for row in rows],
            pa.map_(text, pa.map_(text, number)),
        ),
        "draws": pa.array([json.dumps(row["draws"]) for row in rows], text),
    }
    if any("chosen" in row for row in rows):
        columns["chosen"] = pa.array([json.dumps(row["chosen"]) for row in rows], text)
    stream = io.BytesIO()
    pq.write_table(pa.table(columns), stream, version="2.6", compression="zstd")
    return stream.getvalue()


def _table_rows(content: bytes) -> list[dict[str, Any]]:
    try:
        pq: Any = import_module("pyarrow.parquet")
    except ImportError:
        raise InvalidStartsError(f"its table needs pyarrow: {install_hint('sweep')}") from None
    return [
        {
            "seed": int(row["seed"]),
            "scene": row["scene"],
            "poses": dict(row["poses"]),
            "joints": {name: dict(positions) for name, positions in row["joints"]},
            "chosen": json.loads(row.get("chosen") or "{}"),
        }
        for row in pq.read_table(io.BytesIO(content)).to_pylist()
    ]
