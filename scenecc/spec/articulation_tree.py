"""Links in a tree, written in the scene file."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, WithJsonSchema

from scenecc.spec.articulation_maps import Limits, LinkKeys
from scenecc.spec.base import Maybe, Model, Name, key
from scenecc.spec.later import Later
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.pose import Direction, Pose
from scenecc.spec.scalars import Finite, NonNegative
from scenecc.spec.shapes import CollisionSpec, ShapeSpec, VisualSpec

TreeJointType = Literal["fixed", "revolute", "revolute_unwrapped", "continuous", "prismatic"]


def _none() -> list[Any]:
    return []


class MimicKeys(Model):
    """A joint that moves as another one does."""

    joint: Fixed[Name] = Field(description="The other joint.")
    multiplier: Maybe[Leaf[Finite]] = key("Of its position.", default=1)
    offset: Maybe[Leaf[Finite]] = key("Added to that [m or rad].", default=0)


class TreeJoint(Model):
    """The joint between a link and its parent."""

    name: Maybe[Fixed[Name]] = key("What `qpos`, `joints` and `drives` call it.")
    type: Fixed[TreeJointType] = Field(
        description="fixed; revolute, revolute_unwrapped, continuous (no limits): about the axis; prismatic: along it."
    )
    origin: Maybe[Pose] = key("Of the link in its parent's frame, where the joint is at 0.", default=[0, 0, 0])
    axis: Maybe[Leaf[Direction]] = key("In the link's frame: [x, y, z] or one of x, y, z.", default="x")
    pose_in_parent: Maybe[Pose] = key("Of the joint's frame, in place of `origin`; its x is the axis.")
    pose_in_child: Maybe[Pose] = key("Of the joint's frame, in place of `axis`; its x is the axis.")
    limits: Maybe[Limits] = key("Lowest and highest position [m or rad]. Left out: none.", examples=[[0, 1.57]])
    limits_deg: Maybe[Limits] = key("The same in degrees.", examples=[[0, 90]])
    friction: Maybe[Leaf[NonNegative]] = key("Friction.", default=0.05)
    damping: Maybe[Leaf[NonNegative]] = key("Damping [N·s/m or N·m·s/rad]; `drives` replaces it.", default=0)
    armature: Maybe[Leaf[NonNegative]] = key("Inertia of the drive itself [kg or kg·m²].", default=0)
    mimic: Maybe[MimicKeys] = key("The joint that it follows.")


if TYPE_CHECKING:
    Children = list["TreeLink"]
else:
    Children = list[
        Annotated[Any, Later("scenecc.spec.articulation_tree", "TreeLink"), WithJsonSchema({"x-ref": "TreeLink"})]
    ]


class TreeLink(LinkKeys):
    """A link, and those that hang on it."""

    name: Fixed[Name] = Field(description="What `links` and mounts call it.")
    joint: Maybe[TreeJoint] = key("To the link that it hangs on; of all links but the root.")
    shapes: list[ShapeSpec] = Field(
        default_factory=_none, description="Shapes that collide and are seen.", json_schema_extra={"default": []}
    )
    collisions: list[CollisionSpec] = Field(
        default_factory=_none, description="Shapes that only collide.", json_schema_extra={"default": []}
    )
    visuals: list[VisualSpec] = Field(
        default_factory=_none, description="Shapes that are only seen.", json_schema_extra={"default": []}
    )
    children: Children = Field(
        default_factory=_none, description="The links that hang on it.", json_schema_extra={"default": []}
    )
