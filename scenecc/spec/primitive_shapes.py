"""Primitive shapes. Imported on first use.

Each `BoxKeys` has three models: `BoxShape` collides and is visible, `BoxCollision` only collides, `BoxVisual` is only
visible. A model is created on first access.
"""

from typing import Any, Literal

from pydantic import Field

from scenecc.spec.base import Finite, ImageName, Maybe, Positive, Positive2, Positive3, SpecModel, Vec3, key
from scenecc.spec.pose import AxisName
from scenecc.spec.shapes import CollisionKeys, ShapeBothKeys, VisualKeys
from scenecc.spec.values import Fixed, Leaf

HeightRow = list[Fixed[Finite]]


class BoxKeys(SpecModel):
    """A box."""

    type: Literal["box"]
    half_size: Leaf[Positive3] = Field(description="Half extents along x, y, z [m].")


class SphereKeys(SpecModel):
    """A sphere."""

    type: Literal["sphere"]
    radius: Leaf[Positive] = Field(description="Radius [m].")


class CapsuleKeys(SpecModel):
    """A cylinder with a half sphere at both ends."""

    type: Literal["capsule"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length between the centres of the caps [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class CylinderKeys(SpecModel):
    """A cylinder. What collides is a convex mesh."""

    type: Literal["cylinder"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class ConeKeys(SpecModel):
    """A cone with 32 sides, its tip towards +axis. What collides is a convex mesh."""

    type: Literal["cone"]
    radius: Leaf[Positive] = Field(description="Radius of the base [m].")
    half_length: Leaf[Positive] = Field(description="Half of the height; the origin is halfway up [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class RingKeys(SpecModel):
    """A ring, or tube, with 32 sides about its axis. What collides are 32 convex meshes."""

    type: Literal["ring"]
    inner_radius: Leaf[Positive] = Field(description="Radius of the hole, at most 0.999 of `outer_radius` [m].")
    outer_radius: Leaf[Positive] = Field(description="Outer radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis of the hole.")


class HeightfieldKeys(SpecModel):
    """Terrain of triangles over a grid of heights, on bodies that do not fall: one of `file` and `heights`."""

    type: Literal["heightfield"]
    size: Leaf[Positive3] = Field(description="Extents along x and y, and the height of the value 1 or of white [m].")
    file: Maybe[Fixed[ImageName]] = key("A grey PNG of 8 or 16 bits, its top at +y; black is 0 and white 1.")
    heights: Maybe[Fixed[list[Fixed[HeightRow]]]] = key(
        "Rows of heights from +y to -y, each from -x to +x.", excludes=("file",)
    )


class PlaneKeys(SpecModel):
    """An endless plane; everything on the side of its normal is free. Never on a dynamic body."""

    type: Literal["plane"]
    normal: Leaf[Vec3] = Field(default=(0.0, 0.0, 1.0), description="Direction of the free side, of any length.")
    offset: Leaf[Finite] = Field(default=0.0, description="Distance along the normal [m].")


class PlaneVisualKeys(SpecModel):
    """Keys of a visible plane."""

    half_size: Leaf[Positive2] = Field(
        default=(10.0, 10.0), description="Visible half extent along the plane's own y and z, as in SAPIEN [m]."
    )


class PlaneCollisionKeys(SpecModel):
    """Keys of a plane that collides."""

    every_scene: Fixed[bool] = Field(
        default=False, description="In a shared GPU simulation: build it in each scene, not once."
    )


class TiledPlaneVisual(VisualKeys):
    """A flat quad facing +z with a repeated texture (ManiSkill's)."""

    type: Literal["tiled_plane"]
    half_size: Leaf[Positive2] = Field(description="Along x and y [m].")
    texture_repeat: Leaf[Positive2] = Field(description="How often the texture repeats along x and y.")


_ROLES: dict[str, tuple[type[SpecModel], str]] = {
    "Shape": (ShapeBothKeys, "A {}."),
    "Collision": (CollisionKeys, "A collision-only {}."),
    "Visual": (VisualKeys, "A visual-only {}."),
}
"""Suffix of a model's name → the keys of its list, and its description."""

_ROLE_KEYS: dict[str, tuple[type[SpecModel], ...]] = {
    "PlaneShape": (PlaneVisualKeys, PlaneCollisionKeys),
    "PlaneCollision": (PlaneCollisionKeys,),
    "PlaneVisual": (PlaneVisualKeys,),
}
"""Model → keys that the shape has only in this list."""


def __getattr__(name: str) -> Any:
    """Returns a shape's model for one kind of list, for example `BoxShape`."""
    noun, role = next(((name.removesuffix(end), end) for end in _ROLES if name.endswith(end)), (name, ""))
    keys = globals().get(f"{noun}Keys")
    if not role or keys is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    list_keys, description = _ROLES[role]
    bases = (keys, *_ROLE_KEYS.get(name, ()), list_keys)
    made = type(name, bases, {"__module__": __name__, "__doc__": description.format(noun.lower())})
    globals()[name] = made
    return made
