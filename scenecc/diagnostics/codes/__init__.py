"""The one table of codes: a file of rows a stage, joined here."""

from scenecc.diagnostics.codes import (
    assets,
    constraints,
    engine,
    expansion,
    export,
    export_extra,
    export_meshes,
    language,
    limits,
    mjcf,
    names,
    physics,
    pictures,
    plan,
    reading,
    robots,
    usage,
    viewing,
)
from scenecc.diagnostics.codes.row import Code, Fault

BANDS: dict[str, str] = {
    "0": "reading YAML",
    "1": "the language: the shape of the data",
    "2": "parameters, expressions, prefabs and includes",
    "3": "names and scene selections",
    "4": "assets and files of robots",
    "5": "physics",
    "6": "limits",
    "7": "plans as JSON, and files of other programs",
    "8": "the engine and the machine",
    "9": "use of the tool",
}
"""What the first digit of a code means."""

CODES: dict[str, Code] = {
    row.code: row
    for module in (
        reading,
        language,
        expansion,
        names,
        assets,
        robots,
        mjcf,
        physics,
        constraints,
        pictures,
        limits,
        plan,
        export,
        export_meshes,
        engine,
        export_extra,
        viewing,
        usage,
    )
    for row in module.ROWS
}
"""Every code, by code."""

_FAULTS: dict[str, Fault] = {"8": "machine", "9": "usage"}
"""What has to be put right for a code, by its first digit; for all others it is the scene."""


def at_fault(code: str) -> Fault:
    """What has to be put right where a code is reported."""
    return CODES[code].at_fault or _FAULTS.get(code[2], "scene")


__all__ = ["BANDS", "CODES", "Code", "Fault", "at_fault"]
