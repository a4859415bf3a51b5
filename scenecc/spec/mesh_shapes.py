"""Shapes from mesh files. Imported on first use."""

from typing import Annotated, Literal

from pydantic import Field

from scenecc.plan.properties import INT32_MAX
from scenecc.spec.base import Maybe, NonNegativeInt32, PositiveInt32, SpecModel, key
from scenecc.spec.shapes import CollisionKeys, MeshFileKeys, MirrorScale, Scale, ShapeBothKeys, VisualKeys
from scenecc.spec.values import Fixed


class ConvexMeshKeys(MeshFileKeys):
    """A mesh that collides as its convex hull."""

    type: Literal["convex_mesh"]


class ConvexMeshShape(ConvexMeshKeys, ShapeBothKeys):
    """A mesh that collides as its convex hull."""

    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")


class ConvexMeshCollision(ConvexMeshKeys, CollisionKeys):
    """A collision-only convex hull."""

    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")


class ConvexMeshVisual(ConvexMeshKeys, VisualKeys):
    """A visual-only mesh."""

    scale: MirrorScale = Field(default=1.0, description="One factor or [x, y, z]; negative mirrors.")


class CoacdKeys(SpecModel):
    """CoACD's arguments, as `sapien.wrapper.coacd.do_coacd` names them."""

    threshold: Maybe[Fixed[Annotated[float, Field(ge=0.01, le=1)]]] = key("Concavity at which to stop.", default=0.05)
    max_convex_hull: Maybe[Fixed[Annotated[int, Field(ge=-1, le=INT32_MAX)]]] = key(
        "Maximum number of parts; -1: no limit.", default=-1
    )
    preprocess_mode: Maybe[Fixed[Literal["auto", "on", "off"]]] = key("Make the mesh manifold first.", default="auto")
    preprocess_resolution: Maybe[Fixed[PositiveInt32]] = key("Resolution of the manifold mesh.", default=30)
    resolution: Maybe[Fixed[PositiveInt32]] = key("Samples for the concavity.", default=2000)
    mcts_nodes: Maybe[Fixed[PositiveInt32]] = key("Child nodes of the search.", default=20)
    mcts_iterations: Maybe[Fixed[PositiveInt32]] = key("Iterations of the search.", default=150)
    mcts_max_depth: Maybe[Fixed[PositiveInt32]] = key("Depth of the search.", default=3)
    pca: Maybe[Fixed[bool]] = key("Align to principal axes first.", default=False)
    merge: Maybe[Fixed[bool]] = key("Merge parts afterwards.", default=True)
    seed: Maybe[Fixed[NonNegativeInt32]] = key("Seed of the search.", default=0)


class ConvexPartsKeys(MeshFileKeys):
    """Several convex meshes of one file: SAPIEN's "multiple convex meshes"."""

    type: Literal["convex_parts"]
    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")
    decomposition: Fixed[Literal["none", "coacd"]] = Field(
        default="none", description="none: the file's own parts; coacd: cut by CoACD (extra `convex`)."
    )
    decomposition_params: Maybe[CoacdKeys] = key("CoACD's arguments.")


class ConvexPartsShape(ConvexPartsKeys, ShapeBothKeys):
    """A mesh that collides as its convex parts."""


class ConvexPartsCollision(ConvexPartsKeys, CollisionKeys):
    """Convex parts that only collide."""


class TriangleMeshKeys(MeshFileKeys):
    """A non-convex mesh; on a dynamic body it needs `sdf: true`."""

    type: Literal["triangle_mesh"]
    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")
    sdf: Fixed[bool] = Field(default=False, description="Cook a signed distance field, which a dynamic body needs.")


class TriangleMeshShape(TriangleMeshKeys, ShapeBothKeys):
    """A non-convex mesh that collides and is visible."""


class TriangleMeshCollision(TriangleMeshKeys, CollisionKeys):
    """A collision-only non-convex mesh."""


class MeshVisual(MeshFileKeys, VisualKeys):
    """The mesh of a file, with its own materials unless one is given."""

    type: Literal["mesh"]
    scale: MirrorScale = Field(default=1.0, description="One factor or [x, y, z]; negative mirrors.")
