"""Mass properties that are given."""

from pydantic import Field

from scenecc.spec.base import Maybe, Model, key
from scenecc.spec.leaf import Leaf
from scenecc.spec.pose import Pose
from scenecc.spec.scalars import Positive, Positive3


class Inertial(Model):
    """Mass properties given instead of computed from shapes and densities."""

    mass: Leaf[Positive] = Field(description="Mass [kg].")
    com: Maybe[Pose] = key("Centre of mass and principal axes, in the body's frame.", default=[0, 0, 0])
    inertia: Leaf[Positive3] = Field(description="Principal moments [ixx, iyy, izz] along the axes of `com` [kg·m²].")
