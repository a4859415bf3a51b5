"""Joints of a compiled model, with drives from its actuators and initial positions from a keyframe."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from scenecc.geometry.rotations import AXES
from scenecc.robots.description import DescribedDrive, DescribedJoint, DescribedMimic, SapienJointType
from scenecc.robots.mujoco.model import BALL, FREE, HINGE, JOINT_EQUALITY, SLIDE, CompiledModel
from scenecc.robots.poses import axis_pose

if TYPE_CHECKING:
    from collections.abc import Collection

    from scenecc.diagnostics import Location
    from scenecc.robots.mjcf_files import MjcfReport

_TO_JOINT, _TO_JOINT_IN_PARENT = 0, 1
"""`mjtTrn`: actuators on a joint; the two are the same for hinges and slides."""

_GROUPS = 31
"""Number of actuator groups that can be disabled."""

_NO_DYNAMICS, _FIXED_GAIN, _AFFINE_BIAS = 0, 0, 1
"""`mjtDyn`, `mjtGain` and `mjtBias` of the actuators that become drives."""


@dataclass(frozen=True, slots=True)
class _Servo:
    """A position or velocity actuator, in joint coordinates.

    Attributes:
        number: index of the actuator.
        stiffness, damping: of the drive.
        target: MuJoCo joint position [rad or m].
        limit: maximum force or torque [N or N·m]; None: unlimited.
    """

    number: int
    stiffness: float
    damping: float
    target: float
    limit: float | None


class MjcfJointReader:
    """Reads the joints of a compiled model.

    Args:
        model: the compiled model.
        report: receives the findings.
        keyframe: index of the keyframe with the initial positions; None: the model's own positions.
    """

    def __init__(self, model: CompiledModel, report: MjcfReport, keyframe: int | None) -> None:
        self._model = model
        self._report = report
        self._keyframe = keyframe
        self._report_springs()
        self._report_flags()
        self._pins, self._mimics = self._read_couplings()
        self._drives = self._read_drives()

    def of_body(self, joints: list[int]) -> list[DescribedJoint]:
        """Returns the joints of a body, in its frame. A ball joint becomes three hinges."""
        return [made for joint in joints for made in self._joint(joint)]

    def is_coupled(self, name: str) -> bool:
        """Returns whether a joint follows another one, or is followed."""
        followers = (self._model.name("jnt", joint) for joint in self._mimics)
        return name in {*followers, *(mimic.source for mimic in self._mimics.values())}

    def _joint(self, joint: int) -> list[DescribedJoint]:
        model = self._model
        kind, dof = int(model["jnt_type"][joint]), int(model["jnt_dofadr"][joint])
        name, place = model.name("jnt", joint), model.location("jnt", joint)
        if kind == FREE:
            return []
        anchor = tuple(model["jnt_pos"][joint].tolist())
        start = self._start(joint)
        if kind == BALL:
            self._report.leave_out("ball", "a ball joint becomes three hinges, about x, y and z", place)
            angles = (None,) * 3 if start is None else _hinge_angles(start)
            return [
                self._describe_joint(
                    f"{name}_{word}" if name else "", "revolute", axis, anchor, place, dof + i, qpos=angle
                )
                for i, ((word, axis), angle) in enumerate(zip(AXES.items(), angles, strict=True))
            ]
        zero = float(model["qpos0"][model["jnt_qposadr"][joint]])  # MuJoCo's `ref`: the position that becomes 0 here
        limited = bool(model["jnt_limited"][joint])
        low, high = model["jnt_range"][joint].tolist() if limited else (-math.inf, math.inf)
        kinds: dict[int, SapienJointType] = {SLIDE: "prismatic", HINGE: "revolute_unwrapped" if limited else "revolute"}
        made = self._describe_joint(
            name, kinds[kind], tuple(model["jnt_axis"][joint].tolist()), anchor, place, dof, (low - zero, high - zero)
        )
        if (pin := self._pins.get(joint)) is not None:
            return [replace(made, limits=(pin, pin), qpos=pin)]
        qpos = None if start is None else min(max(start[0] - zero, low - zero), high - zero)
        return [replace(made, qpos=qpos, mimic=self._mimics.get(joint), drive=self._drive(joint, zero))]

    def _describe_joint(
        self,
        name: str,
        kind: SapienJointType,
        axis: Any,
        anchor: Any,
        place: Location,
        dof: int,
        limits: tuple[float, float] = (-math.inf, math.inf),
        *,
        qpos: float | None = None,
    ) -> DescribedJoint:
        frame = axis_pose(axis, anchor)
        return DescribedJoint(
            name=name,
            type=kind,
            pose_in_parent=frame,
            pose_in_child=frame,
            location=place,
            limits=limits,
            # SAPIEN's default is 0.05; MuJoCo's joints have no such friction.
            friction=0.0,
            friction_force=float(self._model["dof_frictionloss"][dof]) or None,
            damping=max(0.0, float(self._model["dof_damping"][dof])),
            armature=float(self._model["dof_armature"][dof]) or None,
            qpos=qpos,
        )

    def _start(self, joint: int) -> list[float] | None:
        if self._keyframe is None:
            return None
        first = int(self._model["jnt_qposadr"][joint])
        count = 4 if self._model["jnt_type"][joint] == BALL else 1
        return self._model["key_qpos"][self._keyframe][first : first + count].tolist()

    def _report_springs(self) -> None:
        """Reports springs and dampers that PhysX cannot represent."""
        model, left = self._model, self._report.leave_out
        stiff, damp = model.arrays.get("jnt_stiffnesspoly"), model.arrays.get("dof_dampingpoly")
        for joint, dof in enumerate(model["jnt_dofadr"].tolist()):
            kind, place, stiffness = self._kind(joint), model.location("jnt", joint), model["jnt_stiffness"][joint]
            if (stiff is not None and stiff[joint].any()) or (damp is not None and damp[dof].any()):
                left("spring/power", "only the first number of stiffness and damping is built", place)
            if stiffness < 0 or model["dof_damping"][dof] < 0:
                left("spring/sign", "negative `stiffness` and `damping` are not built", place)
            if model["dof_armature"][dof] < 0:
                message = f"`armature` is {model['dof_armature'][dof]:g}, but cannot be negative"
                self._report.error("SC481", message, place)
            if kind == BALL and (stiffness or model["jnt_limited"][joint]):
                left("ball/range", "limits and the spring of a ball joint are not built", place)
            keys = [key for key in ("damping", "armature", "frictionloss") if model[f"dof_{key}"][dof]]
            keys += ["stiffness"] if stiffness else []
            if kind == FREE and keys:
                message = f"a free joint is built without its {', '.join(f'`{key}`' for key in keys)}"
                left("spring/free", message, place, "use `linear_damping` and `angular_damping` in the scene")

    def _report_flags(self) -> None:
        if self._model.header["option"]["override"]:
            message = '`<flag override="enable"/>` is not built: contacts have the friction of their geoms'
            self._report.leave_out("flag/override", message, self._model.source.first("flag").location)
        for flag in ("CONSTRAINT", "LIMIT", "EQUALITY", "ACTUATION", "SPRING", "DAMPER"):
            if flag in self._model.header["disabled"]:
                what = "limits and equalities stay" if flag == "CONSTRAINT" else "what it disables stays"
                message = f'`<flag {flag.lower()}="disable"/>` is ignored: {what} on'
                self._report.leave_out(f"flag/{flag}", message, self._model.source.first("flag").location)

    # --- equalities of two joints

    def _read_couplings(self) -> tuple[dict[int, float], dict[int, DescribedMimic]]:
        """Returns the positions of pinned joints, measured from their `ref`, and the mimics, by joint number.

        A joint is pinned if its polynomial is constant: without a second joint, without powers, or with a pinned one.
        """
        model = self._model
        pins: dict[int, float] = {}
        mimics: dict[int, DescribedMimic] = {}
        rest = [
            number
            for number, kind in enumerate(model["eq_type"].tolist())
            if kind == JOINT_EQUALITY and model["eq_active0"][number] and self._is_coupling_of_axes(number)
        ]
        while constant := [number for number in rest if self._source(number) in {None, *pins}]:
            for number in constant:
                joint, source = int(model["eq_obj1id"][number]), self._source(number)
                if self._is_first(number, joint, pins):
                    position = 0.0 if source is None else pins[source]
                    factors = enumerate(model["eq_data"][number][:5].tolist())
                    pins[joint] = sum(factor * position**power for power, factor in factors)
                rest.remove(number)
        for number in rest:
            joint, source = int(model["eq_obj1id"][number]), int(model["eq_obj2id"][number])
            offset, multiplier, *higher = model["eq_data"][number][:5].tolist()
            if any(higher):
                why = f"it follows `{self._joint_name(source)}` by a polynomial, but PhysX has multiples and offsets"
                self._report_free(joint, why, model.location("eq", number))
            elif self._is_first(number, joint, {**pins, **mimics}):
                place = model.location("eq", number)
                mimics[joint] = DescribedMimic(model.name("jnt", source), multiplier, offset, place)
        return pins, mimics

    def _source(self, equality: int) -> int | None:
        """Returns the second joint of an equality; None if its position has no effect."""
        source = int(self._model["eq_obj2id"][equality])
        return source if source >= 0 and self._model["eq_data"][equality][1:5].any() else None

    def _is_coupling_of_axes(self, number: int) -> bool:
        """Returns whether an equality is between hinges and slides; reports it otherwise."""
        joint, source = int(self._model["eq_obj1id"][number]), self._source(number)
        if {self._kind(each) for each in (joint, source) if each is not None} <= {HINGE, SLIDE}:
            return True
        self._report_free(joint, "only hinges and slides can follow each other", self._model.location("eq", number))
        return False

    def _is_first(self, number: int, joint: int, found: Collection[int]) -> bool:
        """Returns whether no earlier equality moves a joint; reports it otherwise."""
        if joint not in found:
            return True
        message = f"`{self._joint_name(joint)}` can follow only one other joint"
        self._report.leave_out("coupling/second", message, self._model.location("eq", number))
        return False

    def _report_free(self, joint: int, why: str, place: Location) -> None:
        name = self._joint_name(joint)
        self._report.leave_out(f"coupling/{name}", f"`{name}` is free: {why}", place)

    def _joint_name(self, joint: int) -> str:
        return self._model.name("jnt", joint) or f"joint_{joint}"

    def _kind(self, joint: int) -> int:
        return int(self._model["jnt_type"][joint])

    # --- actuators

    def _read_drives(self) -> dict[int, list[_Servo]]:
        """Returns the position and velocity actuators of each joint, by joint number."""
        model = self._model
        found: dict[int, list[_Servo]] = {}
        left: Counter[str] = Counter()
        places: dict[str, Location] = {}
        for number in range(len(model["actuator_trntype"])):
            joint = int(model["actuator_trnid"][number][0])
            if self._is_disabled(number):
                continue
            on_joint = model["actuator_trntype"][number] in {_TO_JOINT, _TO_JOINT_IN_PARENT}
            why = self._why_no_drive(number) if on_joint else "on tendons, sites or bodies"
            if why is None and self._kind(joint) in {HINGE, SLIDE}:
                if (servo := self._servo(number)) is not None:
                    found.setdefault(joint, []).append(servo)
                continue
            why = why or "on ball and free joints"
            left[why] += 1
            places.setdefault(why, model.location("actuator", number))
        for why, count in left.items():
            message = f"actuators {why} are not built (there are {count})"
            self._report.leave_out(f"actuator/{why}", message, places[why], "use `drives` in the scene")
        return found

    def _control(self, number: int) -> float:
        """Returns an actuator's control in the keyframe. In MuJoCo 4 it may have several; then it is not a drive."""
        if self._keyframe is None:
            return 0.0
        model = self._model
        addresses = model.arrays.get("actuator_ctrladr")
        address = number if addresses is None else int(addresses[number])
        control = float(model["key_ctrl"][self._keyframe][address])
        if model["actuator_ctrllimited"][address] and "CLAMPCTRL" not in model.header["disabled"]:
            low, high = model["actuator_ctrlrange"][address].tolist()
            return min(max(control, low), high)
        return control

    def _is_disabled(self, number: int) -> bool:
        """Returns whether `actuatorgroupdisable` includes an actuator's group."""
        group = int(self._model["actuator_group"][number])
        return bool(0 <= group < _GROUPS and self._model.header["option"]["disableactuator"] >> group & 1)

    def _why_no_drive(self, number: int) -> str | None:
        model = self._model
        if model["actuator_dyntype"][number] != _NO_DYNAMICS:
            return "with a state of their own"
        if model["actuator_gaintype"][number] != _FIXED_GAIN:
            return "with a gain that depends on the state"
        # A motor only applies commanded forces; it needs no drive.
        return None if model["actuator_biastype"][number] <= _AFFINE_BIAS else "with a muscle or user bias"

    def _servo(self, number: int) -> _Servo | None:
        """Returns an actuator as a drive; None if it is not one, or cannot be built (reported)."""
        model, place = self._model, self._model.location("actuator", number)
        gear = float(model["actuator_gear"][number][0])
        bias, position, velocity = model["actuator_biasprm"][number][:3].tolist()
        if model["actuator_biastype"][number] != _AFFINE_BIAS or not (position or velocity):
            return None
        if position > 0 or velocity > 0:
            self._report.leave_out("actuator/sign", "an actuator that pushes away from its target is not built", place)
            return None
        offset = float(model["actuator_gainprm"][number][0]) * self._control(number) + bias
        if not position and offset:
            message = "a velocity actuator with a nonzero target is built with target 0"
            self._report.leave_out("actuator/velocity", message, place)
        limit = None
        if model["actuator_forcelimited"][number]:
            limit = self._larger_limit(model["actuator_forcerange"][number], place) * abs(gear)
        target = offset / (-position * gear) if position and gear else 0.0
        # Avoids -0.0.
        return _Servo(number, 0.0 - position * gear**2, 0.0 - velocity * gear**2, target, limit)

    def _larger_limit(self, forces: Any, place: Location) -> float:
        """Returns the larger of both force limits, as a drive has only one."""
        low, high = forces.tolist()
        if low != -high:
            message = "a drive has one force limit: the larger end of `forcerange` or `actuatorfrcrange`"
            self._report.leave_out("actuator/range", message, place)
        return max(abs(low), abs(high))

    def _drive(self, joint: int, zero: float) -> DescribedDrive | None:
        """Returns the drive of a hinge or slide, from its actuators or its own spring."""
        model = self._model
        spring = float(model["jnt_stiffness"][joint])
        servos = self._drives.get(joint, [])
        place = model.location("jnt", joint)
        if not servos and spring > 0:
            rest = float(model["qpos_spring"][model["jnt_qposadr"][joint]]) - zero
            return DescribedDrive(spring, 0.0, None, rest)
        if not servos:
            return None
        if spring > 0:
            message = "the spring of a joint with a position or velocity actuator is not built"
            self._report.leave_out("spring", message, place)
        limits = [servo.limit for servo in servos if servo.limit is not None]
        if limits and len(servos) > 1:
            message = "several actuators of a joint become one drive: their force limits are added"
            self._report.leave_out("actuator/several", message, model.location("actuator", servos[1].number))
        limit = sum(limits) if len(limits) == len(servos) else None
        if model["jnt_actfrclimited"][joint]:
            most = self._larger_limit(model["jnt_actfrcrange"][joint], place)
            limit = most if limit is None else min(limit, most)
        stiffness = sum(servo.stiffness for servo in servos)
        # Where the forces of all actuators balance.
        pull = sum(servo.stiffness * servo.target for servo in servos)
        aimed = None if self._keyframe is None else (pull / stiffness if stiffness else 0.0) - zero
        return DescribedDrive(stiffness, sum(servo.damping for servo in servos), limit, aimed)


def _hinge_angles(q: list[float]) -> tuple[float, float, float]:
    """Returns intrinsic rotation angles about x, then y, then z [rad]. `q`: wxyz."""
    length = math.sqrt(sum(part * part for part in q)) or 1.0
    w, x, y, z = (part / length for part in q)
    # R = Rx·Ry·Rz: its first row is (cy·cz, -cy·sz, sy) and its last column (sy, -sx·cy, cx·cy).
    about_y = math.asin(max(-1.0, min(1.0, 2 * (x * z + w * y))))
    about_x = math.atan2(2 * (w * x - y * z), 1 - 2 * (x * x + y * y))
    about_z = math.atan2(2 * (w * z - x * y), 1 - 2 * (y * y + z * z))
    return about_x, about_y, about_z
