"""What is said of links and joints, one by one or by patterns of their names."""

from math import inf
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, Strict, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.base import MAPPING_KEY, Maybe, Model, Name, key
from scenecc.spec.body import CollisionBits
from scenecc.spec.later import Later
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.material import MaterialRef
from scenecc.spec.mistakes import told
from scenecc.spec.name_patterns import PatternError, name_pattern
from scenecc.spec.scalars import Finite, NonNegative, Positive, Unit
from scenecc.spec.unions import COMPONENTS, MAPPING, by_kind

if TYPE_CHECKING:
    from scenecc.spec.inertial import Inertial
else:
    Inertial = Annotated[Any, Later("scenecc.spec.inertial", "Inertial")]

_HINT = (
    "letters, `.`, `[…]`, `|`, groups, `?`, `*`, `+` and `{m,n}`; what is repeated repeats nothing itself; "
    "it matches whole names"
)


def _readable(text: str) -> str:
    if not text.startswith("x-"):
        try:
            name_pattern(text)
        except PatternError as error:
            raise told("SC323", str(error), at="key", hint=_HINT) from error
    return text


Pattern = Annotated[str, AfterValidator(_readable), MAPPING_KEY]
"""A regular expression that matches whole names."""

_Side = Annotated[float, Field(ge=-inf, allow_inf_nan=True)]
LimitPair = Annotated[tuple[_Side, _Side], Strict(strict=False)]
Limits = TypeAliasType("Limits", Leaf[LimitPair])
"""[lowest, highest]; `-.inf` and `.inf` where there is none."""

MOST_JOINTS = 4096
"""More than any articulation has."""

JointNumbers = TypeAliasType(
    "JointNumbers",
    Leaf[
        Annotated[
            Annotated[list[Finite], Field(min_length=0, max_length=MOST_JOINTS), Tag(COMPONENTS)]
            | Annotated[dict[str, Leaf[Finite]], Tag(MAPPING)],
            by_kind("a list of one number for each joint that moves, or a mapping of their names"),
        ]
    ],
)
"""One number for each joint that moves, in SAPIEN's order, or by their names."""


class LinkKeys(Model):
    """What may be said of a link."""

    material: Maybe[MaterialRef] = key("Of its shapes.")
    density: Maybe[Leaf[NonNegative]] = key("Of its shapes [kg/m³].")
    patch_radius: Maybe[Leaf[NonNegative]] = key("Of its shapes, for torsional friction [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("Of its shapes, likewise [m].", default=0)
    gravity: Maybe[Leaf[bool]] = key("false: gravity does not pull it.", default=True)
    collision_group: Maybe[Fixed[Name]] = key("A name from `collision_groups`.")
    collision_bits: Maybe[Fixed[CollisionBits]] = key(
        "SAPIEN's four integers, as they are; not with `collision_group`.", default=[1, 1, 0, 0]
    )
    linear_damping: Maybe[Leaf[NonNegative]] = key("[1/s]", default=0.05)
    angular_damping: Maybe[Leaf[NonNegative]] = key("[1/s]", default=0.05)
    max_linear_velocity: Maybe[Leaf[Positive]] = key("[m/s]")
    max_angular_velocity: Maybe[Leaf[Positive]] = key("[rad/s]")
    max_depenetration_velocity: Maybe[Leaf[Positive]] = key("Fastest way out of an overlap [m/s].")
    max_contact_impulse: Maybe[Leaf[Positive]] = key("[N·s]")
    mass: Maybe[Leaf[Positive]] = key("Mass [kg]; scales the inertia that it has otherwise.")
    inertial: Maybe[Inertial] = key("Mass properties, given; not with `mass`.")
    visibility: Maybe[Leaf[Unit]] = key("Of the render body, 0 to 1.", default=1)


class JointKeys(Model):
    """What may be said of joints."""

    friction: Maybe[Leaf[NonNegative]] = key("Friction.", default=0.05)
    armature: Maybe[Leaf[NonNegative]] = key("Inertia of the drive itself [kg or kg·m²].", default=0)
    limits: Maybe[Limits] = key("Lowest and highest position [m or rad].", examples=[[-1.57, 1.57]])
    limits_deg: Maybe[Limits] = key("The same in degrees.", examples=[[-90, 90]])
    max_velocity: Maybe[Leaf[Positive]] = key("Fastest [m/s or rad/s].")


class DriveKeys(Model):
    """What may be said of the drives of joints. In place of the damping that a joint has by itself."""

    stiffness: Maybe[Leaf[NonNegative]] = key("Force for each metre or radian off the target.", default=0)
    damping: Maybe[Leaf[NonNegative]] = key("Force against each metre or radian a second off the target.", default=0)
    force_limit: Maybe[Leaf[NonNegative]] = key("The most that it exerts [N or N·m]. Left out: a URDF's effort.")
    mode: Maybe[Fixed[Literal["force", "acceleration"]]] = key("What stiffness and damping are of.", default="force")
    target: Maybe[Leaf[Finite]] = key("Where to. Left out: where the joint starts, again at every reset.")
    velocity_target: Maybe[Leaf[Finite]] = key("How fast.", default=0)
