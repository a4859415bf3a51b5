"""Reads the robots and bodies of an MJCF through MuJoCo's compiler."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
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
    """An MJCF with its compiled model.

    Attributes:
        description: its robots.
        model: the compiled model.
        links: root and link name of each body, by body index.
        losses: kind, message and location of everything that is not built.
    """

    description: RobotDescription
    model: CompiledModel
    links: Mapping[int, LinkName]
    losses: tuple[tuple[str, str, Location], ...]


def read_mjcf(file: ResolvedFile, **options: Any) -> RobotDescription | None:
    """Returns the robots and bodies of an MJCF, see `read_model`; None after an error."""
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
    """Reads the robots and bodies of an MJCF; returns None after errors, which are reported.

    Articulations come first, then bodies without joints, then the world's own geoms. Names are MuJoCo's; unnamed ones
    become `body_N` or `geom_N`, and an added root `dummy_root_N`.

    Args:
        file: the MJCF, as resolved by `scenecc.source.paths.resolve_path`.
        scope: folders that may be read; meshes, textures and included files must be inside.
        sink: receives errors at the file's own lines: SC401 to SC407 for files that it names, SC450 to SC458 if it
            cannot be read, SC480 to SC490 for the rest.
        origin: the scene node that names the file, reported with each finding.
        keyframe: name of the keyframe with the initial positions, and where the scene names it.
        visual_groups: visible geom groups.
        limits: `depth` limits nested includes, `asset_bytes` the size of each file.
        budget: shared by all files of the scene; None: no budget.
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
        message = "the pose of a free root comes from the scene, not from the keyframe"
        report.note_elsewhere("keyframe", message, model.location("key", number))
    report_unbuilt(model, report, number)
    reader = MjcfModelReader(model, report, number, visual_groups)
    robots = reader.robots()
    constraints = read_constraints(model, reader.links_of_bodies, report)
    if not robots and not report.failed:
        report.error("SC480", "nothing to build: the file has no body and no geom", root.location)
    if report.failed:
        return None
    description = RobotDescription(
        tuple(robots), tuple(files.named.found.values()), tuple(constraints), f"mujoco {mujoco_version()}"
    )
    return ReadModel(description, model, reader.links_of_bodies, tuple(report.losses))


def _keyframe(keyframe: tuple[str, Origin | None], model: CompiledModel, report: MjcfReport) -> int | None:
    """Returns the index of a keyframe; None after an error (SC482)."""
    name, origin = keyframe
    names = model.names("key")
    if name in names:
        return names.index(name)
    if any(names):
        hint = suggest(name, filter(None, names))
    else:
        hint = "give its <key> a `name`" if names else "it has none: remove the key"
    message = f"the file has no keyframe `{cut(name)}`"
    findings = report.findings
    findings.errors += 1
    findings.sink.report("SC482", message, origin or findings.place(model.source.elements[0].location), hint=hint)
    return None


@dataclass(frozen=True, slots=True)
class _Unbuilt:
    """A property that is not built.

    Attributes:
        arrays: fields of `mjModel`.
        kind, message, hint: of the finding.
        most: largest value without effect.
        is_note: whether masses, joints and contacts are unaffected.
    """

    arrays: str
    kind: str
    message: str
    hint: str | None = None
    most: float = 0
    is_note: bool = False


_UNBUILT: Final = (
    _Unbuilt("jnt_springyield", "spring/yield", "joint springs that yield (`springyield`) stay elastic"),
    _Unbuilt("geom_adhesion", "contact/adhesion", "`adhesion` of geoms is not built"),
    _Unbuilt(
        "geom_surfacevel",
        "surface/velocity",
        "`surfacevel` of geoms is not built: their surfaces do not move",
        "rollers, hinges with a `velocity_target`, convey",
    ),
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
    _Unbuilt("key_qvel", "keyframe/qvel", "velocities of the keyframe are not built", "use `qvel` in the scene"),
    _Unbuilt("key_act", "keyframe/act", "states of actuators in the keyframe are not built"),
    _Unbuilt("key_plastic", "keyframe/plastic", "springs that have yielded in the keyframe are not built"),
)


def report_unbuilt(model: CompiledModel, report: MjcfReport, keyframe: int | None) -> None:
    """Reports features of the model and the keyframe that SAPIEN lacks."""
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
        message = "`density` and `viscosity` of <option> are not built: there are no fluid forces"
        hint = "`linear_damping` and `angular_damping` slow bodies down"
        report.leave_out("fluid", message, model.source.first("option").location, hint)


def _report(one: _Unbuilt, rows: list[int], model: CompiledModel, report: MjcfReport) -> None:
    if not rows:
        return
    message = one.message if len(rows) == 1 else f"{one.message} (there are {len(rows)})"
    place = model.location(one.arrays.partition("_")[0], rows[0])
    if one.is_note:
        report.note_elsewhere(one.kind, message, place)
    else:
        report.leave_out(one.kind, message, place, one.hint)


def _rows(values: NDArray[Any] | None, most: float) -> list[int]:
    """Returns the elements with any absolute value above `most`. `values`: None if this MuJoCo lacks the array."""
    if values is None or not values.size:
        return []
    return np.flatnonzero((np.abs(values.reshape(len(values), -1)) > most).any(axis=1)).tolist()


def _report_mocap_poses(model: CompiledModel, report: MjcfReport, keyframe: int) -> None:
    """Reports mocap bodies that the keyframe moves."""
    for body, number in enumerate(model["body_mocapid"].tolist()):
        if number < 0:
            continue
        position, turn = (model[f"key_{name}"][keyframe].reshape(-1, width)[number] for name, width in _MOCAP)
        if np.any(position != model["body_pos"][body]) or np.any(turn != model["body_quat"][body]):
            message = "poses of mocap bodies come from the file, not from the keyframe"
            report.leave_out("keyframe/mocap", message, model.location("key", keyframe))


_MOCAP: Final = (("mpos", 3), ("mquat", 4))


def _report_looks(model: CompiledModel, report: MjcfReport) -> None:
    """Reports repeated image textures."""
    repeated = (model["mat_texrepeat"] != 1).any(axis=1) | model["mat_texuniform"].astype(bool)
    textures = [set(row.tolist()) for row in model["mat_texid"]]
    rows = [row for row in np.flatnonzero(repeated).tolist() if any(map(model.texture, textures[row]))]
    shown = _Unbuilt("mat_texrepeat", "look/repeat", "textures are not repeated", is_note=True)
    _report(shown, rows, model, report)
