"""Compares a built scene with the engine or library of its source format."""

from __future__ import annotations

import json
import math
import subprocess
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics import Sink
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut
from scenecc.importers import suffix_of
from scenecc.importers.imported_scene import ImportedScene, ReferencePose
from scenecc.interrupt import ask_module
from scenecc.pipeline import build_batch, compile_or_raise
from scenecc.plan.articulation import ArticulationStructure

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from scenecc.options import Options
    from scenecc.plan.snapshot import EngineSnapshot

_DRAKE_SECONDS: Final = 120

_SHOWN_NAMES: Final = 3

_READ_BY_DRAKE: Final = frozenset({".sdf", ".world", ".urdf", ".dmd.yaml", ".dmd.yml"})


@frozen
class Certificate:
    """Result of the comparison.

    Attributes:
        bodies: number of bodies built.
        mass: total of all dynamic bodies and links [kg].
        engine: name of the reference engine or library; "" if there is none.
        why_no_engine: why an engine that reads the file was not used; "" if there is none.
        compared: number of bodies in both.
        not_compared: names in the scene of the source's bodies that the engine does not have.
        position: largest position difference [m].
        angle: largest rotation difference [rad].
        masses: number of masses compared, without kinematic bodies, whose mass has no effect.
        relative_mass: largest relative mass difference.
    """

    bodies: int
    mass: float
    engine: str = ""
    compared: int = 0
    not_compared: tuple[str, ...] = ()
    position: float = 0.0
    angle: float = 0.0
    masses: int = 0
    relative_mass: float = 0.0
    why_no_engine: str = ""

    def lines(self) -> list[str]:
        """Returns the result as text."""
        lines = [f"built {_body_count_text(self.bodies)}; total moving mass {self.mass:.6g} kg"]
        if not self.engine:
            why = self.why_no_engine or "no other engine reads such files"
            return [*lines, f"not compared with another engine: {why}"]
        if not self.compared:
            why = f"none of the bodies has the name of a body in {self.engine}"
            return [*lines, f"compared with {self.engine}: nothing: {why if self.bodies else 'no body is built'}"]
        lines.append(f"compared with {self.engine}: {_body_count_text(self.compared)}")
        if self.not_compared:
            named = ", ".join(f"`{cut(name)}`" for name in self.not_compared[:_SHOWN_NAMES])
            more = len(self.not_compared) - _SHOWN_NAMES
            lines[-1] += f"; not compared: {named}" + (f" and {more} more" if more > 0 else "")
        lines.append(f"  poses differ by at most {self.position:.2g} m and {self.angle:.2g} rad")
        if self.masses:
            lines.append(f"  masses ({self.masses}) differ by at most {self.relative_mass:.2g} (relative)")
        return lines


def certificate_of(found: ImportedScene, source: Path, target: Path, options: Options) -> Certificate:
    """Builds the written scene file and compares it. Raises SceneError if it does not build."""
    sink = Sink()
    plan = compile_or_raise(target, replace(options, allow_outside_assets=False), sink).plan
    with build_batch(plan, sink, scene_idxs=None, render=False, audit=True) as batch:
        from scenecc.backends.sapien.measure import measure_bodies  # noqa: PLC0415 - with the engine

        built = _bodies(measure_bodies(batch))
    certificate = Certificate(len(built), math.fsum(body.mass or 0.0 for body in built.values()))
    engine, reference = found.engine, dict(found.reference)
    if not engine and suffix_of(source) in _READ_BY_DRAKE:
        if find_spec("pydrake") is None:
            return replace(certificate, why_no_engine="Drake is not installed (`pip install drake`)")
        engine = "Drake"
        answer = _ask_drake(source, found, options)
        if isinstance(answer, str):
            return replace(certificate, why_no_engine=answer)
        reference = answer
    return _compare(certificate, built, found.bodies, engine, reference)


def _body_count_text(count: int) -> str:
    return f"{count} {'body' if count == 1 else 'bodies'}"


def _bodies(snapshot: EngineSnapshot) -> dict[str, ReferencePose]:
    """Returns the bodies of the first scene, by `ENTITY` or `ENTITY/LINK`."""
    found: dict[str, ReferencePose] = {}
    for entity in snapshot.scenes[0].entities:
        for body in entity.bodies:
            is_link = isinstance(entity.structure, ArticulationStructure)
            name = f"{entity.entity.name}/{body.name}" if is_link else entity.entity.name
            # PhysX ignores the mass of kinematic bodies.
            mass = None if body.body_type == "kinematic" else body.mass
            found[name] = ReferencePose(body.pose, None if mass is None else mass.mass)
    return found


def _compare(
    certificate: Certificate,
    built: Mapping[str, ReferencePose],
    names: Mapping[str, str],
    engine: str,
    reference: Mapping[str, ReferencePose],
) -> Certificate:
    pairs = [(built[mine], reference[own]) for mine, own in names.items() if mine in built and own in reference]
    weighed = [(a.mass, b.mass) for a, b in pairs if a.mass is not None and b.mass]
    return replace(
        certificate,
        engine=engine,
        compared=len(pairs),
        not_compared=tuple(mine for mine, own in names.items() if mine in built and own not in reference),
        position=max((math.dist(a.pose[:3], b.pose[:3]) for a, b in pairs), default=0.0),
        angle=max((_angle(a.pose[3:], b.pose[3:]) for a, b in pairs), default=0.0),
        masses=len(weighed),
        relative_mass=max((abs(a - b) / b for a, b in weighed), default=0.0),
    )


def _angle(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Returns the angle between two rotations. The chord is more precise than the cosine for small angles."""
    chord = min(math.dist(a, b), math.dist(a, [-each for each in b]))
    return 4 * math.asin(min(1.0, chord / 2))


def _ask_drake(source: Path, found: ImportedScene, options: Options) -> dict[str, ReferencePose] | str:
    """Returns poses and masses from Drake, run in a separate process; or the reason why there are none."""
    if any(loss.kind == "models" for loss in found.losses):
        return "Drake would read models that are left out"
    request = {"file": str(source.absolute()), "roots": [str(root) for root in options.asset_roots]}
    try:
        done = ask_module("scenecc.importers.drake_poses", request, seconds=_DRAKE_SECONDS)
    except subprocess.TimeoutExpired:
        return f"Drake did not read the file in {_DRAKE_SECONDS} s"
    if done.returncode:
        *_, last = "", *done.stderr.decode(errors="replace").strip().splitlines()
        return f"Drake refuses the file: {cut(last)}" if done.returncode > 0 else "Drake crashes on the file"
    rows: dict[str, Any] = json.loads(done.stdout)
    # A URDF has one robot, and its bodies have the names of its links.
    is_urdf = source.suffix.lower() == ".urdf"
    named = {name.rpartition("::")[2] if is_urdf else name: row for name, row in rows.items()}
    return {name: ReferencePose(tuple(row["pose"]), row["mass"]) for name, row in named.items()}
