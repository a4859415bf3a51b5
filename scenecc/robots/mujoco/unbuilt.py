"""Properties of a compiled model that SAPIEN does not have: each kind is told once, with the number of elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.robots.mjcf_files import MjcfReport
    from scenecc.robots.mujoco.model import CompiledModel


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
