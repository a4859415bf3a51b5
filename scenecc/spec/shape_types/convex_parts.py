"""Meshes of several convex parts."""

from typing import Annotated, Literal

from pydantic import Field

from scenecc.spec.base import Maybe, Model, key
from scenecc.spec.leaf import Fixed
from scenecc.spec.scalars import MOST, Count, CountOrNone
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, FileKeys, Scale


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


class ConvexPartsShape(ConvexPartsKeys, BothKeys):
    """Convex parts that collide, and the mesh itself seen."""


class ConvexPartsCollision(ConvexPartsKeys, CollisionKeys):
    """Convex parts that only collide."""
