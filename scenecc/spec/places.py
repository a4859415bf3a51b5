"""Frames and collision groups: what has a name and no body."""

from pydantic import Field

from scenecc.spec.base import Model, Name
from scenecc.spec.leaf import Fixed
from scenecc.spec.pose import Pose


class Frame(Model):
    """A place with no body, to put others relative to."""

    pose: Pose = Field(description="In the world, or in the frame of `relative_to`: [x, y, z] or a mapping.")


class CollisionGroup(Model):
    """Which groups this one does not collide with."""

    ignore: list[Fixed[Name]] = Field(
        default_factory=list, description="Names of groups, its own among them if so wished."
    )
