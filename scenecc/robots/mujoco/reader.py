"""Reader for MJCF: robots and bodies as MuJoCo's compiler understands them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, nearest
from scenecc.robots.description import LinkName, RobotDescription
from scenecc.robots.files import FileReport, ReadBudget, RobotFiles
from scenecc.robots.mjcf_files import MjcfFiles, MjcfReport
from scenecc.robots.mujoco.compiler import check_mujoco, compile_mjcf, mujoco_version
from scenecc.robots.mujoco.equalities import read_constraints
from scenecc.robots.mujoco.links import MjcfModelReader
from scenecc.robots.mujoco.model import FREE, CompiledModel
from scenecc.robots.mujoco.shapes import VISUAL_GROUPS
from scenecc.robots.mujoco.source import SourceBuilder
from scenecc.source.limits import Limits

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location, Origin
    from scenecc.source.paths import AssetScope, ResolvedFile

_DEFAULT_LIMITS = Limits()


@frozen
class ReadModel:
    """A file with all that MuJoCo's compiler made of it.

    Attributes:
        description: its robots.
        model: compiled.
        links: root and link that bodies became, by the bodies' numbers.
        losses: kind, message and place of everything that is not built from the file.
    """

    description: RobotDescription
    model: CompiledModel
    links: Mapping[int, LinkName]
    losses: tuple[tuple[str, str, Location], ...]


def read_mjcf(file: ResolvedFile, **options: Any) -> RobotDescription | None:
    """The robots and bodies of an MJCF, as `read_model` reads them; None after an error."""
    found = read_model(file, **options)
    return None if found is None else found.description


def read_model(
    file: ResolvedFile,
    *,
    scope: AssetScope,
    sink: Sink,
    origin: Origin | None = None,
    keyframe: tuple[str, Origin | None] | None = None,
    visual_groups: Collection[int] = VISUAL_GROUPS,
    limits: Limits = _DEFAULT_LIMITS,
    budget: ReadBudget | None = None,
) -> ReadModel | None:
    """The robots and bodies of an MJCF; None where the file is wrong, all that is wrong having been reported.

    First come the articulations, then bodies without joints, then the world's own geoms, with MuJoCo's names; what has
    none is `body_N` or `geom_N`, and a root that a file does not have is `dummy_root_N`.

    Args:
        file: the MJCF, as `scenecc.source.paths.resolve_path` finds it.
        scope: what may be read; meshes, textures and included files are looked for inside.
        sink: takes what is wrong, at the file's own lines: codes SC401 to SC407 for files that it names, SC450 to SC458
            where it cannot be read, SC480 to SC490 for the rest.
        origin: the node of the scene that names the file, reported with each finding.
        keyframe: the name of the keyframe that gives initial positions, and where the scene says it.
        visual_groups: the groups of geoms that are seen.
        limits: `depth`: how many files include one another; `asset_bytes`: size of each.
        budget: of all files of the scene; None: it is read alone.
    """
    report = MjcfReport(FileReport(sink, origin, budget=budget))
    files = MjcfFiles(RobotFiles(file, scope), limits, report)
    root = files.read_model()
    if root is None or not check_mujoco(report, root.location):
        return None
    source = SourceBuilder(files, report).build(root)
    model = None if source is None else compile_mjcf(source, report)
    if model is None:
        return None
    number = None if keyframe is None else _keyframe(keyframe, model, report)
    if number is not None and FREE in model["jnt_type"]:
        message = "the pose of a free root is that of the scene, and not that of the keyframe"
        report.elsewhere("keyframe", message, model.location("key", number))
    report_unbuilt(model, report, number)
    reader = MjcfModelReader(model, report, number, visual_groups)
    robots = reader.robots()
    constraints = read_constraints(model, reader.links_of_bodies, report)
    if not robots and not report.failed:
        report.error("SC480", "nothing in the file is built: it has no body and no geom", root.location)
    if report.failed:
        return None
    description = RobotDescription(
        tuple(robots), tuple(files.named.found.values()), tuple(constraints), f"mujoco {mujoco_version()}"
    )
    return ReadModel(description, model, reader.links_of_bodies, tuple(report.losses))


def _keyframe(keyframe: tuple[str, Origin | None], model: CompiledModel, report: MjcfReport) -> int | None:
    """The number of a keyframe; None, reported (SC482), where there is none of the name."""
    name, origin = keyframe
    names = model.names("key")
    if name in names:
        return names.index(name)
    near = nearest(name, names)
    known = f"it has {', '.join(f'`{cut(one)}`' for one in names[:12])}" if names else "it has none: leave the key out"
    hint = f"did you mean `{near}`?" if near else known
    message = f"the file has no keyframe `{cut(name)}`"
    findings = report.findings
    findings.errors += 1
    findings.sink.report("SC482", message, origin or findings.place(model.source.elements[0].location), hint=hint)
    return None


@dataclass(frozen=True, slots=True)
class _Unbuilt:
    """A property that is not built.

    Attributes:
        arrays: of `mjModel`.
        kind, message, hint: of the finding.
        most: the largest number that has no effect.
        is_note: whether it says nothing of masses, joints or contacts.
    """

    arrays: str
    kind: str
    message: str
    hint: str | None = None
    most: float = 0
    is_note: bool = False


_UNBUILT: Final = (
    _Unbuilt("jnt_springyield", "spring/yield", "springs of joints that yield (`springyield`) stay elastic"),
    _Unbuilt("geom_adhesion", "contact/adhesion", "`adhesion` of geoms is not built"),
    _Unbuilt("geom_surfacevel", "contact/surfacevel", "`surfacevel` of geoms is not built: their surfaces stand still"),
    _Unbuilt(
        "geom_condim",
        "friction",
        "torsional and rolling friction (`condim` of 4 and 6) is not built",
        "`patch_radius` under `links` gives torsional friction",
        most=3,
    ),
    _Unbuilt(
        "actuator_damping actuator_dampingpoly actuator_armature",
        "actuator/reflected",
        "`damping` and `armature` of actuators are not built",
    ),
    _Unbuilt("actuator_delay", "actuator/delay", "delays of actuators are not built"),
    _Unbuilt("mat_reflectance", "look/reflectance", "`reflectance` of materials is not shown", is_note=True),
)

_OF_KEYFRAME: Final = (
    _Unbuilt("key_qvel", "keyframe/qvel", "velocities of the keyframe are not built", "`qvel` of the scene gives them"),
    _Unbuilt("key_act", "keyframe/act", "states of actuators in the keyframe are not built"),
    _Unbuilt("key_plastic", "keyframe/plastic", "springs that have yielded in the keyframe are not built"),
)


def report_unbuilt(model: CompiledModel, report: MjcfReport, keyframe: int | None) -> None:
    """Tells what the model and the keyframe have and SAPIEN has not."""
    for one in _UNBUILT:
        rows = {row for array in one.arrays.split() for row in _rows(model.arrays.get(array), one.most)}
        _report(one, sorted(rows), model, report)
    if keyframe is not None:
        for one in _OF_KEYFRAME:
            values = model.arrays.get(one.arrays)
            if values is not None and values[keyframe].any():
                _report(one, [keyframe], model, report)
        _report_mocap_poses(model, report, keyframe)
    _report_looks(model, report)
    if any(model.header["option"]["fluid"]):
        message = "`density` and `viscosity` of <option> are not built: no fluid carries or slows down what moves"
        hint = "`linear_damping` and `angular_damping` slow bodies down"
        report.left_out("fluid", message, model.source.first("option").location, hint)


def _report(one: _Unbuilt, rows: list[int], model: CompiledModel, report: MjcfReport) -> None:
    if not rows:
        return
    message = one.message if len(rows) == 1 else f"{one.message} (there are {len(rows)})"
    place = model.location(one.arrays.partition("_")[0], rows[0])
    if one.is_note:
        report.elsewhere(one.kind, message, place)
    else:
        report.left_out(one.kind, message, place, one.hint)


def _rows(values: NDArray[Any] | None, most: float) -> list[int]:
    """The elements of which any number is larger, whatever its sign. `values`: None where MuJoCo does not have them."""
    if values is None or not values.size:
        return []
    return np.flatnonzero((np.abs(values.reshape(len(values), -1)) > most).any(axis=1)).tolist()


def _report_mocap_poses(model: CompiledModel, report: MjcfReport, keyframe: int) -> None:
    """A keyframe moves mocap bodies too."""
    for body, number in enumerate(model["body_mocapid"].tolist()):
        if number < 0:
            continue
        position, turn = (model[f"key_{name}"][keyframe].reshape(-1, width)[number] for name, width in _MOCAP)
        if np.any(position != model["body_pos"][body]) or np.any(turn != model["body_quat"][body]):
            message = "poses of mocap bodies are those of the file, and not those of the keyframe"
            report.left_out("keyframe/mocap", message, model.location("key", keyframe))


_MOCAP: Final = (("mpos", 3), ("mquat", 4))


def _report_looks(model: CompiledModel, report: MjcfReport) -> None:
    """Textures of files that are repeated."""
    repeated = (model["mat_texrepeat"] != 1).any(axis=1) | model["mat_texuniform"].astype(bool)
    textures = [set(row.tolist()) for row in model["mat_texid"]]
    rows = [row for row in np.flatnonzero(repeated).tolist() if any(map(model.texture, textures[row]))]
    shown = _Unbuilt("mat_texrepeat", "look/repeat", "textures are not repeated", is_note=True)
    _report(shown, rows, model, report)
