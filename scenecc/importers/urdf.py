"""Imports a URDF as an entity that refers to the unchanged file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.importers.imported_scene import REPAIRED, Asset, ImportContext, ImportedScene, Loss
from scenecc.importers.numbers import Names, starts_at_limits
from scenecc.robots.urdf import read_urdf as read_robots

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic, Sink
    from scenecc.robots.description import RobotDescription
    from scenecc.source.paths import ResolvedFile

_REPAIRS: Final = {"inertia": "inertias", "limits": "joint-limits", "files": "missing-files", "shapes": "colliders"}
"""Repair option of the scene → kind of loss."""

_UNREAL_INERTIAS: Final = frozenset({"SC468", "SC475"})
"""Warnings about inertias that other programs read differently from SAPIEN."""

_ASSUMED_MASS: Final = "SC448"
"""Code of notes about masses that the file does not have."""


def import_urdf(path: Path, context: ImportContext) -> ImportedScene | None:
    """Returns a scene with the robot of a URDF; None after an error. Repairs are listed as losses."""
    found = context.resolve(path)
    if found is None:
        return None
    described, losses, repair = _read(found, context)
    if described is None:
        return None
    entities: dict[str, Any] = {}
    bodies: dict[str, str] = {}
    name = Names("world").new(path.stem)
    repaired = {"repair": repair} if repair else {}
    entities[name] = {"urdf": Asset(path.name, found.path), **repaired, **starts_at_limits(described.robots)}
    for robot in described.robots:
        entity = name if len(described.robots) == 1 else f"{name}/{robot.links[0].name}"
        bodies |= {f"{entity}/{link.name}": link.name for link in robot.links}
        if len(robot.links) == 1:
            bodies[entity] = robot.links[0].name
    document = {"scenecc": 1, "name": name, "entities": entities}
    return ImportedScene(document, losses, bodies, codes_of_losses=_UNREAL_INERTIAS | {_ASSUMED_MASS})


def _read(file: ResolvedFile, context: ImportContext) -> tuple[RobotDescription | None, tuple[Loss, ...], list[str]]:
    """Reads the file with as few repairs as necessary."""
    described, trial = _try_read(file, frozenset(), context)
    needed: list[str] = []
    if described is None:
        errors = _count_errors(trial)
        needed = [name for name in _REPAIRS if _count_errors(_try_read(file, frozenset({name}), context)[1]) < errors]
        described, trial = _try_read(file, frozenset(needed), context)
    if described is None:
        read_robots(file, scope=context.scope, sink=context.sink, repair=frozenset(needed))
        return None, (), []
    if "inertia" not in needed and _inertia_warnings(trial):
        whole, repaired = _try_read(file, frozenset({*needed, "inertia"}), context)
        if whole is not None and len(_inertia_warnings(repaired)) < len(_inertia_warnings(trial)):
            described, trial, needed = whole, repaired, ["inertia", *needed]
    losses: list[Loss] = []
    for name in needed:
        notes = _try_read(file, frozenset({name}), context)[1].diagnostics()
        repaired = [note for note in notes if note.code == REPAIRED]
        losses += [Loss(_REPAIRS[name], note.message, note.location) for note in repaired]
    losses += [Loss("inertias", note.message, note.location) for note in _inertia_warnings(trial)]
    if any(note.code == _ASSUMED_MASS and note.hint for note in trial.diagnostics()):
        # Fixed links get the mass that they have in the file: none.
        needed = [*needed, "mass"]
        described, trial = _try_read(file, frozenset(needed), context)
    listed = {loss.message for loss in losses}
    assumed = [note for note in trial.diagnostics() if note.code in {_ASSUMED_MASS, REPAIRED}]
    losses += [Loss("assumed-masses", note.message, note.location) for note in assumed if note.message not in listed]
    return described, tuple(losses), needed


def _inertia_warnings(sink: Sink) -> list[Diagnostic]:
    return [note for note in sink.diagnostics() if note.code in _UNREAL_INERTIAS]


def _try_read(
    file: ResolvedFile, repair: frozenset[str], context: ImportContext
) -> tuple[RobotDescription | None, Sink]:
    trial = context.sink.another()
    return read_robots(file, scope=context.scope, sink=trial, repair=repair), trial


def _count_errors(sink: Sink) -> int:
    return sum(found.severity == "error" for found in sink.diagnostics())
