"""The keys of shapes: those of every shape in a list, and those of each type."""

from typing import Annotated, Literal

from pydantic import Field, Tag
from typing_extensions import TypeAliasType

from scenecc.spec.base import Maybe, Model, Text, key
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.material import Color, MaterialRef
from scenecc.spec.pose import AxisName, Pose
from scenecc.spec.scalars import (
    MOST,
    Count,
    CountOrNone,
    Finite,
    NonNegative,
    Positive,
    Positive2,
    Positive3,
    Vec3,
)
from scenecc.spec.unions import COMPONENTS, by_kind

Scale = TypeAliasType(
    "Scale",
    Leaf[
        Annotated[
            Annotated[Positive, Tag("#number")] | Annotated[Positive3, Tag(COMPONENTS)],
            by_kind("a number or [x, y, z]"),
        ]
    ],
)
"""One number or [x, y, z], positive."""

MirrorScale = TypeAliasType(
    "MirrorScale",
    Leaf[
        Annotated[
            Annotated[Finite, Tag("#number")] | Annotated[Vec3, Tag(COMPONENTS)],
            by_kind("a number or [x, y, z]", nonzero=True),
        ]
    ],
)
"""One number or [x, y, z]; negative mirrors, zero is refused by a check."""


class ShapeKeys(Model):
    """Keys of every shape."""

    pose: Maybe[Pose] = key("In the body's frame: [x, y, z] or a mapping.")
    material: Maybe[MaterialRef] = key("A name from `materials`, or {physical, visual}.")


class CollisionKeys(ShapeKeys):
    """Keys of shapes that collide."""

    density: Maybe[Leaf[NonNegative]] = key("Density [kg/m³].", default=1000)
    contact_offset: Maybe[Leaf[Positive]] = key("Distance at which contacts begin to be made [m].", default=0.01)
    rest_offset: Maybe[Leaf[Finite]] = key("Distance at which shapes rest, below `contact_offset` [m].", default=0)
    patch_radius: Maybe[Leaf[NonNegative]] = key("Radius of the torsional friction patch [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("Smallest radius of the torsional friction patch [m].", default=0)


class VisualKeys(ShapeKeys):
    """Keys of shapes that are seen."""

    name: Maybe[Fixed[Text]] = key("Name of the render shape.")
    front_face: Maybe[Fixed[Literal["counterclockwise", "clockwise"]]] = key(
        "Which side of a triangle is its front.", default="counterclockwise"
    )
    color: Maybe[Color] = key("Base colour; leaves the rest of the material.")


class BothKeys(CollisionKeys, VisualKeys):
    """Keys of shapes that collide and are seen."""


class BoxKeys(Model):
    """A box."""

    type: Literal["box"]
    half_size: Leaf[Positive3] = Field(description="Half of the edges along x, y, z [m].")


class SphereKeys(Model):
    """A sphere."""

    type: Literal["sphere"]
    radius: Leaf[Positive] = Field(description="Radius [m].")


class CapsuleKeys(Model):
    """A cylinder with a half sphere at both ends."""

    type: Literal["capsule"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length between the centres of the caps [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class CylinderKeys(Model):
    """A cylinder. What collides is a convex mesh."""

    type: Literal["cylinder"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class PlaneKeys(Model):
    """An endless plane; everything on the side of its normal is free. Never on a dynamic body."""

    type: Literal["plane"]
    normal: Leaf[Vec3] = Field(default=(0.0, 0.0, 1.0), description="Direction of the free side, of any length.")
    offset: Leaf[Finite] = Field(default=0.0, description="Distance along the normal [m].")


class PlaneSeen(Model):
    """What is seen of a plane."""

    half_size: Leaf[Positive2] = Field(
        default=(10.0, 10.0), description="What is seen, along the plane's own y and z as SAPIEN has them [m]."
    )


class PlaneColliding(Model):
    """How often a plane is built."""

    every_scene: Fixed[bool] = Field(
        default=False, description="Where scenes share one GPU simulation: build it in each, not once."
    )


class FileKeys(Model):
    """A mesh file."""

    file: Leaf[Text] = Field(
        description="The mesh: a path from this file's folder, pkg://PACKAGE/PATH or asset://PATH."
    )


class ConvexMeshKeys(FileKeys):
    """The convex hull of a file collides; the mesh itself is seen."""

    type: Literal["convex_mesh"]


class CoacdKeys(Model):
    """CoACD's arguments, as `sapien.wrapper.coacd.do_coacd` names them."""

    threshold: Maybe[Fixed[Annotated[float, Field(ge=0.01, le=1)]]] = key("Concavity at which to stop.", default=0.05)
    max_convex_hull: Maybe[Fixed[Annotated[int, Field(ge=-1, le=MOST)]]] = key(
        "At most so many parts; -1: as many as it takes.", default=-1
    )
    preprocess_mode: Maybe[Fixed[Literal["auto", "on", "off"]]] = key("Make the mesh manifold first.", default="auto")
    preprocess_resolution: Maybe[Fixed[Count]] = key("Resolution of that.", default=30)
    resolution: Maybe[Fixed[Count]] = key("Samples for the concavity.", default=2000)
    mcts_nodes: Maybe[Fixed[Count]] = key("Child nodes of the search.", default=20)
    mcts_iterations: Maybe[Fixed[Count]] = key("Iterations of the search.", default=150)
    mcts_max_depth: Maybe[Fixed[Count]] = key("Depth of the search.", default=3)
    pca: Maybe[Fixed[bool]] = key("Align to principal axes first.", default=False)
    merge: Maybe[Fixed[bool]] = key("Merge parts afterwards.", default=True)
    seed: Maybe[Fixed[CountOrNone]] = key("Seed of the search.", default=0)


class ConvexPartsKeys(FileKeys):
    """Several convex meshes of one file: SAPIEN's "multiple convex meshes"."""

    type: Literal["convex_parts"]
    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")
    decomposition: Fixed[Literal["none", "coacd"]] = Field(
        default="none", description="none: the file's own parts; coacd: cut by CoACD (extra `convex`)."
    )
    decomposition_params: Maybe[CoacdKeys] = key("CoACD's arguments.")


class TriangleMeshKeys(FileKeys):
    """A non-convex mesh; on a dynamic body it needs `sdf: true`."""

    type: Literal["triangle_mesh"]
    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")
    sdf: Fixed[bool] = Field(default=False, description="Cook a signed distance field, which a dynamic body needs.")
