"""Imports a URDF as an entity that refers to the unchanged file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.importers.imported_scene import REPAIRED, ImportContext, ImportedScene, Loss
from scenecc.importers.numbers import Names, starts_at_limits
from scenecc.importers.writer import write_world
from scenecc.robots.files import FileReport, read_robot_bytes
from scenecc.robots.urdf import read_urdf
from scenecc.robots.world import DescribedEntity, DescribedWorld, RobotFile
from scenecc.robots.xml import XmlBounds, parse_xml

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic, Sink
    from scenecc.robots.description import DescribedRobot, RobotDescription
    from scenecc.robots.xml import SourceElement
    from scenecc.source.paths import ResolvedFile

_REPAIRS: Final = {"inertia": "inertias", "limits": "joint-limits", "files": "missing-files", "shapes": "colliders"}
"""Repair option of the scene → kind of loss."""

_UNREAL_INERTIAS: Final = frozenset({"SC468", "SC475"})
"""Warnings about inertias that other programs read differently from SAPIEN."""

_ASSUMED_MASS: Final = "SC448"
"""Code of notes about masses that the file does not have."""

URDF_LOSS_CODES: Final = _UNREAL_INERTIAS | {_ASSUMED_MASS}
"""Codes of findings about a URDF that its losses cover."""


@frozen
class ReadUrdf:
    """A URDF that can be built.

    Attributes:
        path: absolute.
        name: of its <robot>; "" if it has none.
        robots: its robots; several if its links are not connected.
        losses: what the repairs replace or omit.
        repair: value of the scene's key `repair`; empty if no repair is needed.
    """

    path: Path
    name: str
    robots: tuple[DescribedRobot, ...]
    losses: tuple[Loss, ...]
    repair: tuple[str, ...]

    @property
    def keys(self) -> tuple[tuple[str, Any], ...]:
        """Keys of an entity with the file, besides the file."""
        return (("repair", [*self.repair]),) if self.repair else ()


def import_urdf(path: Path, context: ImportContext) -> ImportedScene | None:
    """Returns a scene with the robot of a URDF; None after an error. Repairs are listed as losses."""
    read = read_repaired_urdf(path, context)
    if read is None:
        return None
    name = Names().new(path.stem)
    keys = (*read.keys, *starts_at_limits(read.robots).items())
    file = RobotFile("urdf", read.path, keys=keys, robots=read.robots)
    written = write_world(DescribedWorld(name, (DescribedEntity(name, file, Location(str(path))),)))
    return ImportedScene(written.document, read.losses, written.bodies, codes_of_losses=URDF_LOSS_CODES)


def read_repaired_urdf(path: Path, context: ImportContext) -> ReadUrdf | None:
    """Reads a URDF with as few repairs as necessary; returns None after an error."""
    found = context.resolve(path)
    described, losses, repair = (None, (), []) if found is None else _read(found, context)
    if found is None or described is None:
        return None
    root = read_urdf_root(path, context)
    name = "" if root is None else root.attributes.get("name", "")
    return ReadUrdf(found.path, name, described.robots, losses, tuple(repair))


def read_urdf_root(path: Path, context: ImportContext) -> SourceElement | None:
    """Returns the root element of a file that was read before, so its faults are not reported again."""
    report = FileReport(context.sink.another())
    data = read_robot_bytes(path, str(path), report, XmlBounds().size)
    return None if data is None else parse_xml(data, str(path), report)


def _read(file: ResolvedFile, context: ImportContext) -> tuple[RobotDescription | None, tuple[Loss, ...], list[str]]:
    """Reads the file with as few repairs as necessary."""
    described, trial = _try_read(file, frozenset(), context)
    needed: list[str] = []
    if described is None:
        errors = _count_errors(trial)
        needed = [name for name in _REPAIRS if _count_errors(_try_read(file, frozenset({name}), context)[1]) < errors]
        described, trial = _try_read(file, frozenset(needed), context)
    if described is None:
        read_urdf(file, scope=context.scope, sink=context.sink, repair=frozenset(needed))
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
    return read_urdf(file, scope=context.scope, sink=trial, repair=repair), trial


def _count_errors(sink: Sink) -> int:
    return sum(found.severity == "error" for found in sink.diagnostics())
