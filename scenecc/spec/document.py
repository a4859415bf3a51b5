"""The model of a scene file."""

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, WithJsonSchema

from scenecc.spec.base import (
    AnyText,
    Maybe,
    NewName,
    NonNegativeInt,
    PositiveInt,
    SceneName,
    SpecModel,
    StartsName,
    Text,
    key,
)
from scenecc.spec.entities import Entity
from scenecc.spec.nodes import LazyType
from scenecc.spec.repetition import NewVariable, Variable
from scenecc.spec.values import Fixed

if TYPE_CHECKING:
    from scenecc.spec.constraint import Constraint
    from scenecc.spec.expect import ExpectSpec
    from scenecc.spec.params import Draw
    from scenecc.spec.physics import CollisionGroup, PhysicsSpec
    from scenecc.spec.pose import FrameSpec
    from scenecc.spec.rendering import CameraSpec, EnvironmentSpec, Light
    from scenecc.spec.shapes import Material
else:
    CameraSpec = Annotated[Any, LazyType("scenecc.spec.rendering", "CameraSpec")]
    Constraint = Annotated[Any, LazyType("scenecc.spec.constraint", "Constraint")]
    EnvironmentSpec = Annotated[Any, LazyType("scenecc.spec.rendering", "EnvironmentSpec")]
    ExpectSpec = Annotated[Any, LazyType("scenecc.spec.expect", "ExpectSpec")]
    Light = Annotated[Any, LazyType("scenecc.spec.rendering", "Light")]
    Draw = Annotated[Any, LazyType("scenecc.spec.params", "Draw")]
    Material = Annotated[Any, LazyType("scenecc.spec.shapes", "Material")]
    PhysicsSpec = Annotated[Any, LazyType("scenecc.spec.physics", "PhysicsSpec")]
    CollisionGroup = Annotated[Any, LazyType("scenecc.spec.physics", "CollisionGroup")]
    FrameSpec = Annotated[Any, LazyType("scenecc.spec.pose", "FrameSpec")]

Param = Annotated[Any, WithJsonSchema({"x-ref": "Parameter"})]
"""A default or a mapping. Expansion validates it."""

# `Literal[1]` would accept 1.0 and true.
Version = Annotated[int, Field(ge=1, le=1), WithJsonSchema({"const": 1})]


class SceneFile(SpecModel):
    """A batch of parallel SAPIEN scenes.

    Units are SI, angles radians unless a key ends in `_deg`, quaternions [w, x, y, z], the world z-up.
    """

    scenecc: Version = Field(description="Version of the language.")
    name: Maybe[Fixed[Text]] = key("Name of the scene; default: the file's stem.")
    description: Fixed[AnyText] = Field(default="", description="Description of the scene.")
    num_scenes: Fixed[PositiveInt] = Field(default=1, description="Number of parallel scenes.")
    seed: Fixed[NonNegativeInt] = Field(default=0, description="Seed of every draw.")
    starts: Maybe[Fixed[StartsName]] = key(
        "File of starts from `scenecc settle`, where the scenes begin.", examples=["starts.json"]
    )
    params: dict[Variable, Param] = Field(
        default_factory=dict, description="Parameters of the file: name → default, or a mapping."
    )
    draws: dict[NewVariable, Draw] = Field(
        default_factory=dict, description="Values that differ from scene to scene, for any `${…}` in the file."
    )
    include: list[Fixed[SceneName]] = Field(
        default_factory=list, description="Files merged in before this one, in order.", examples=[["common.yaml"]]
    )
    physics: Maybe[PhysicsSpec] = key("Simulation settings.")
    environment: Maybe[EnvironmentSpec] = key("Ambient light and the environment map.")
    materials: dict[NewName, Material] = Field(default_factory=dict, description="Named materials.")
    collision_groups: dict[NewName, CollisionGroup] = Field(
        default_factory=dict, description="Groups of bodies that may ignore one another."
    )
    frames: dict[NewName, FrameSpec] = Field(default_factory=dict, description="Named poses without a body.")
    entities: dict[NewName, Entity] = Field(default_factory=dict, description="Objects of the scenes, in build order.")
    constraints: dict[NewName, Constraint] = Field(
        default_factory=dict, description="Constraints between two bodies, or a body and the world."
    )
    lights: dict[NewName, Light] = Field(
        default_factory=dict, description="Lights; default: a rig of ManiSkill's tasks."
    )
    cameras: dict[NewName, CameraSpec] = Field(
        default_factory=dict, description="Cameras; default: one that frames the scene."
    )
    expect: Maybe[ExpectSpec] = key("What must hold in the scenes; `scenecc check` tests it.")
