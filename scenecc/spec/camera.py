"""Cameras."""

from typing import Annotated, Literal

from pydantic import Field

from scenecc.spec.base import Finite, Maybe, OpeningAngle, OpeningDegrees, Positive, SpecModel, Text, key
from scenecc.spec.body import SceneIdxs
from scenecc.spec.pose import Pose
from scenecc.spec.repetition import RepeatKeys
from scenecc.spec.values import Fixed, Leaf

_Pixels = Annotated[int, Field(ge=1, le=16384)]

ShaderName = Literal["default", "minimal", "trivial", "rt", "shadow_catcher"]
"""SAPIEN's shader packs that make pictures of everything that a scene holds."""


class IntrinsicKeys(SpecModel):
    """The matrix of a pinhole camera."""

    fx: Leaf[Positive] = Field(description="Focal length in widths of a pixel [px].")
    fy: Leaf[Positive] = Field(description="Focal length in heights of a pixel [px].")
    cx: Maybe[Leaf[Finite]] = key("Where the axis meets the picture, from the left [px]; left out: half the width.")
    cy: Maybe[Leaf[Finite]] = key("Likewise, from the top [px]; left out: half the height.")
    skew: Maybe[Leaf[Finite]] = key("Skew of the pixels [px].", default=0)


class OrthographicKeys(SpecModel):
    """A camera without perspective."""

    top: Leaf[Positive] = Field(description="Half of the height that it sees [m]; pixels are square.")


class CameraSpec(RepeatKeys):
    """A camera. It looks along x of its pose, z is up."""

    pose: Maybe[Pose] = key("In the world, in the frame of `relative_to`, or in that of `mount`; `look_at` aims it.")
    width: Maybe[Fixed[_Pixels]] = key("[px]", default=640)
    height: Maybe[Fixed[_Pixels]] = key("[px]", default=480)
    fovy: Maybe[Leaf[OpeningAngle]] = key("Angle of view from top to bottom [rad].")
    fovy_deg: Maybe[Leaf[OpeningDegrees]] = key("The same [degrees].", default=60)
    fovx: Maybe[Leaf[OpeningAngle]] = key("Angle of view from left to right [rad].")
    fovx_deg: Maybe[Leaf[OpeningDegrees]] = key("The same [degrees].")
    intrinsic: Maybe[IntrinsicKeys] = key("The matrix, in place of an angle.")
    orthographic: Maybe[OrthographicKeys] = key("No perspective, in place of an angle.")
    near: Maybe[Leaf[Positive]] = key("Nearest distance that is seen [m].", default=0.01)
    far: Maybe[Leaf[Positive]] = key("Farthest distance that is seen [m].", default=100)
    mount: Maybe[Fixed[Text]] = key("ENTITY or ENTITY/LINK that it is fastened to.", examples=["robot/hand"])
    shader: Maybe[Fixed[ShaderName]] = key("SAPIEN's shader pack.", default="default")
    scene_idxs: Maybe[SceneIdxs] = key(
        'The scenes it exists in: indices, a slice such as "0:8", or a list of both. Left out: every scene.'
    )
