"""Joints that follow others, as equalities of joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import Model
    from scenecc.plan import ArticulationStructure
    from scenecc.plan.snapshot import MeasuredEntity


def write_mimics(model: Model, measured: MeasuredEntity, structure: ArticulationStructure) -> None:
    """An equality a mimic: MuJoCo counts both positions from where the model starts."""
    entity, row = measured.entity.name, measured.row
    starts = {body.joint.name: body.joint.qpos for body in measured.bodies if body.joint is not None}
    for mimic in structure.mimics:
        multiplier, offset = float(mimic.multiplier.row(row)), float(mimic.offset.row(row))
        apart = multiplier * starts[mimic.source] + offset - starts[mimic.joint]
        model.sections["equality"].add(
            "joint",
            joint1=model.joints[entity, mimic.joint],
            joint2=model.joints[entity, mimic.source],
            polycoef=(apart, multiplier, 0, 0, 0),
        )
