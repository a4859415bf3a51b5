"""Settings of the simulation, collision groups, and mass properties of bodies."""

from typing import Annotated

from pydantic import Field

from scenecc.plan.properties import CONTACT_OFFSET, REST_OFFSET
from scenecc.spec.base import (
    Finite,
    Iterations,
    Maybe,
    Name,
    NameRole,
    NonNegative,
    Positive,
    Positive3,
    PositiveInt32,
    SpecModel,
    Vec3,
    VelocityIterations,
    key,
)
from scenecc.spec.pose import Pose
from scenecc.spec.values import Fixed, Leaf

MAX_THREADS = 256
"""Most threads, to protect the machine."""


class DefaultMaterial(SpecModel):
    """Material of shapes without their own."""

    static_friction: Fixed[NonNegative] = Field(description="Coefficient of static friction.")
    dynamic_friction: Fixed[NonNegative] = Field(description="Coefficient of dynamic friction, at most the static one.")
    restitution: Fixed[NonNegative] = Field(description="Coefficient of restitution, 0 to 1.")


class SdfKeys(SpecModel):
    """How signed distance fields are cooked: `sapien.physx.set_sdf_config`."""

    spacing: Maybe[Fixed[Positive]] = key("Distance between samples [m].", default=0.01)
    subgrid_size: Maybe[Fixed[PositiveInt32]] = key("Cells along an edge of a subgrid.", default=6)
    num_threads_for_construction: Maybe[Fixed[Annotated[int, Field(ge=1, le=MAX_THREADS)]]] = key(
        "Number of cooking threads.", default=4
    )


class GpuMemoryKeys(SpecModel):
    """Capacities of PhysX on the GPU: `sapien.physx.set_gpu_memory_config`."""

    temp_buffer_capacity: Maybe[Fixed[PositiveInt32]] = key("[bytes]", default=2**24)
    max_rigid_contact_count: Maybe[Fixed[PositiveInt32]] = key("Contacts.", default=2**19)
    max_rigid_patch_count: Maybe[Fixed[PositiveInt32]] = key("Contact patches.", default=81920)
    heap_capacity: Maybe[Fixed[PositiveInt32]] = key("[bytes]", default=2**26)
    found_lost_pairs_capacity: Maybe[Fixed[PositiveInt32]] = key("Pairs.", default=2**18)
    found_lost_aggregate_pairs_capacity: Maybe[Fixed[PositiveInt32]] = key("Pairs.", default=1024)
    total_aggregate_pairs_capacity: Maybe[Fixed[PositiveInt32]] = key("Pairs.", default=1024)
    collision_stack_size: Maybe[Fixed[PositiveInt32]] = key("[bytes]", default=2**22)


class PhysicsSpec(SpecModel):
    """Simulation settings; the defaults are SAPIEN's."""

    timestep: Maybe[Fixed[Positive]] = key("Time step [s].", default=0.01)
    gravity: Maybe[Fixed[Vec3]] = key("World frame [m/s²].", default=[0, 0, -9.81])
    bounce_threshold: Maybe[Fixed[NonNegative]] = key(
        "Relative speed below which contacts do not bounce [m/s].", default=2
    )
    enable_pcm: Maybe[Fixed[bool]] = key("Persistent contact manifolds.", default=True)
    enable_tgs: Maybe[Fixed[bool]] = key("Temporal Gauss-Seidel solver.", default=True)
    enable_ccd: Maybe[Fixed[bool]] = key("Continuous collision detection.", default=False)
    enable_enhanced_determinism: Maybe[Fixed[bool]] = key(
        "Results do not depend on other objects in the scene.", default=False
    )
    enable_friction_every_iteration: Maybe[Fixed[bool]] = key("Friction in every solver iteration.", default=True)
    cpu_workers: Maybe[Fixed[Annotated[int, Field(ge=0, le=MAX_THREADS)]]] = key(
        "Threads of a scene; 0: the caller's.", default=0
    )
    default_material: Maybe[DefaultMaterial] = key("Material of shapes without their own.")
    contact_offset: Maybe[Fixed[Positive]] = key("Default for shapes [m].", default=CONTACT_OFFSET)
    rest_offset: Maybe[Fixed[Finite]] = key("Default for shapes [m].", default=REST_OFFSET)
    solver_position_iterations: Maybe[Fixed[Iterations]] = key("Default for bodies.", default=10)
    solver_velocity_iterations: Maybe[Fixed[VelocityIterations]] = key("Default for bodies.", default=1)
    sleep_threshold: Maybe[Fixed[NonNegative]] = key("Default for bodies [m²/s²].", default=0.005)
    sdf: Maybe[SdfKeys] = key("How signed distance fields are cooked.")
    scene_spacing: Maybe[Fixed[Positive]] = key("Distance between scenes that share one GPU simulation [m].")
    gpu_memory: Maybe[GpuMemoryKeys] = key("Capacities of PhysX on the GPU.")


class InertialSpec(SpecModel):
    """Mass properties given instead of computed from shapes and densities."""

    mass: Leaf[Positive] = Field(description="Mass [kg].")
    com: Maybe[Pose] = key("Centre of mass and principal axes, in the body's frame.", default=[0, 0, 0])
    inertia: Leaf[Positive3] = Field(description="Principal moments [ixx, iyy, izz] along the axes of `com` [kg·m²].")


class CollisionGroup(SpecModel):
    """The groups that this group does not collide with."""

    ignore: list[Fixed[Annotated[Name, NameRole("group")]]] = Field(
        default_factory=list, description="Names of groups to ignore; may include the group itself."
    )
