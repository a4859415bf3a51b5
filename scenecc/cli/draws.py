"""`scenecc draws`."""

from __future__ import annotations

import csv
import io
import json
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from scenecc.cli.check import parse_seeds, refuse_seed_beside
from scenecc.cli.options import SceneArgument, Scenes, takes_compile_options
from scenecc.cli.output import STDOUT, end, print_out, progress, scene_errors, usage_error, write_output
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text, table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from scenecc import SceneDraws


_DrawsFormat = Literal["text", "json", "csv", "parquet"]


@takes_compile_options
def draws(
    scene: SceneArgument,
    *,
    seeds: Annotated[
        Any, typer.Option("--seeds", metavar="A:B", parser=parse_seeds, help="Draw with each seed from A to B-1.")
    ] = None,
    scenes: Scenes = None,
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="FILE", help="Output file; - is standard output.")
    ] = None,
    form: Annotated[
        _DrawsFormat | None,
        typer.Option("--format", help="Format of the values.", show_default="that of the suffix of -o, else text"),
    ] = None,
    options: dict[str, Any],
) -> None:
    """Print the values that a scene draws.

    Prints the shared draws, and all fields that are drawn or differ between scenes, for each seed and scene, as a
    build draws them. No engine is started. In a scene without a value, the value is left out (text), null (json),
    empty (csv), or NaN or null (parquet). Parquet needs the extra `sweep`.

    \b
    Examples:
      scenecc draws scenes/draws.yaml
      scenecc draws scenes/clutter.yaml --seeds 0:20 --scene 3 --format json
      scenecc draws scenes/clutter.yaml --seeds 0:1000 -o draws.parquet
    """
    import scenecc

    refuse_seed_beside(seeds, options)
    suffix = Path(output or "").suffix.lower().removeprefix(".")
    chosen = form or (suffix if suffix in _WRITERS else "text")
    if chosen == "parquet" and output in {None, STDOUT}:
        raise typer.BadParameter("Parquet is written to a file: -o FILE.parquet", param_hint="'--format'")
    if chosen == "parquet" and find_spec("pyarrow") is None:
        from scenecc.extras import install_hint

        end([usage_error("SC828", "Parquet needs pyarrow, not installed here", hint=install_hint("sweep"))])
    beside = "json" if chosen == "json" else "text"
    source = checked_source(scene, None if output == STDOUT else output, beside)
    with scene_errors(options, beside), progress("draws") as show:
        found = scenecc.scene_draws(source, seeds=seeds, scenes=scenes, progress=show, **options)
    content = _WRITERS[chosen](found)
    if output is None:
        print_out(content)
    elif (reason := write_output(output, content)) is not None:
        end([usage_error(*reason, file=output)], beside)


def _rows(found: Sequence[SceneDraws]) -> Iterator[tuple[int, int, dict[str, Any]]]:
    """Yields seed, scene and plain values by name, in which None is a missing value."""
    from scenecc.drawn_values import plain_values

    for one in found:
        columns = {name: plain_values(values) for name, values in one.values.items()}
        for number, scene in enumerate(one.scene_idxs):
            yield one.seed, scene, {name: values[number] for name, values in columns.items()}


def _text(found: Sequence[SceneDraws]) -> str:
    from scenecc.plan.display import format_item, to_tuples

    rows = [
        (str(seed), str(scene), escape_text(name), escape_text(format_item(to_tuples(value))))
        for seed, scene, values in _rows(found)
        for name, value in values.items()
        if value is not None
    ]
    return table(("seed", "scene", "name", "value"), rows) if rows else "no draws\n"


def _json(found: Sequence[SceneDraws]) -> str:
    rows = [{"seed": seed, "scene": scene, "values": values} for seed, scene, values in _rows(found)]
    return json.dumps({"draws": rows, "diagnostics": []}, indent=2) + "\n"


def _csv(found: Sequence[SceneDraws]) -> str:
    """Returns one line per seed and scene. A vector has a column per number: `cube.pose[0]`."""
    rows = [{"seed": seed, "scene": scene, **_cells(values)} for seed, scene, values in _rows(found)]
    names = dict.fromkeys(name for row in rows for name in row)
    written = io.StringIO()
    writer = csv.DictWriter(written, [*names] or ["seed", "scene"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return written.getvalue()


def _cells(values: dict[str, Any]) -> dict[str, Any]:
    cells: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, list):
            several: list[Any] = value  # pyright: ignore[reportUnknownVariableType]
            cells |= _cells({f"{name}[{number}]": item for number, item in enumerate(several)})
        elif value is not None:
            cells[name] = json.dumps(value) if isinstance(value, bool) else value
    return cells


def _parquet(found: Sequence[SceneDraws]) -> bytes:
    """Returns one row per seed and scene. A vector is a list; a value that differs in type by scene is JSON."""
    pa: Any = import_module("pyarrow")
    names = dict.fromkeys(name for one in found for name in one.values)
    columns: dict[str, list[Any]] = {
        "seed": [one.seed for one in found for _ in one.scene_idxs],
        "scene": [scene for one in found for scene in one.scene_idxs],
    }
    if max(columns["seed"], default=0) >= _SEED_LIMIT:
        columns["seed"] = list(map(str, columns["seed"]))
    for name in names:
        rows = [one.values[name].tolist() if name in one.values else [None] * len(one.scene_idxs) for one in found]
        columns[name] = [row for several in rows for row in several]
        try:
            pa.array(columns[name])
        except (pa.ArrowInvalid, pa.ArrowTypeError):
            columns[name] = [None if row is None else json.dumps(row) for row in columns[name]]
    written = io.BytesIO()
    import_module("pyarrow.parquet").write_table(pa.table(columns), written)
    return written.getvalue()


_SEED_LIMIT: Final = 2**63

_WRITERS: Final[dict[str, Callable[[Sequence[SceneDraws]], str | bytes]]] = {
    "text": _text,
    "json": _json,
    "csv": _csv,
    "parquet": _parquet,
}
