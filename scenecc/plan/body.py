"""Bodies of a plan, their shapes, and the materials and files that shapes refer to."""

from __future__ import annotations

import os
from dataclasses import field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.files import State
    from scenecc.plan.geometry import CollisionGeometry, VisualGeometry
    from scenecc.plan.value import Value


@frozen
class NamedFile:
    """A file that another file references: a material file, a texture, a buffer.

    Attributes:
        uri: as written, relative to the referencing file.
        sha256, path, state: see `AssetFile`.
    """

    uri: str
    sha256: str
    path: Path | None = field(default=None, compare=False)
    state: State | None = field(default=None, compare=False)


@frozen
class AssetFile:
    """A file that the scene uses.

    Attributes:
        uri: `pkg://…` or `asset://…` as written, else the path relative to the top scene's folder
            (posix), else an absolute path.
        path: where it was found on this machine; not part of the plan's identity.
        sha256: hash when it was checked; None if no build opens the file (a robot's description) or the plan's files
            were not checked.
        names: the files that it references and that a build opens.
        state: of the file when it was checked. A build compares it to detect a later change.
        optional_names: whether its images and material files may be missing. Missing ones are not rendered.
        data: content, if the scene has no such file: a PLY of `robots.mujoco.shapes` in the user's cache folder. None:
            the content is in the scene's own file.
        read_by: program and version that read a robot's file: "mujoco 4.0.0". None: scenecc.
        origin: the first node that references it.
    """

    uri: str
    path: Path = field(compare=False)
    sha256: str | None = None
    names: tuple[NamedFile, ...] = ()
    state: State | None = field(default=None, compare=False)
    optional_names: bool = False
    data: bytes | None = field(default=None, repr=False)
    read_by: str | None = None
    origin: Origin | None = field(default=None, compare=False)


@frozen
class Friction:
    """The numbers of a `sapien.physx.PhysxMaterial`, the same in every scene. Without unit."""

    static_friction: float
    dynamic_friction: float
    restitution: float


@frozen
class PhysicalMaterial:
    """`sapien.physx.PhysxMaterial`: (·,) each, without unit."""

    static_friction: Value
    dynamic_friction: Value
    restitution: Value

    def values(self) -> tuple[Value, ...]:
        """All its values."""
        return (self.static_friction, self.dynamic_friction, self.restitution)

    def row(self, index: int) -> Friction:
        """Its numbers in row `index` of an entity (not a scene index)."""
        return Friction(*(float(value.row(index)) for value in self.values()))


@frozen
class Texture:
    """An image and its sampling. None is the default of `sapien.render.RenderTexture2D`.

    `file`: (·,) index into `ScenePlan.files`.
    """

    file: Value
    mipmap_levels: int | None = None
    filter_mode: Literal["nearest", "linear"] | None = None
    address_mode: Literal["repeat", "border", "edge", "mirror"] | None = None
    srgb: bool | None = None

    def sampling(self) -> dict[str, int | str | bool]:
        """The sampling settings of the plan, by the names of these fields and of SAPIEN's arguments."""
        given = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "file"}
        return {name: value for name, value in given.items() if value is not None}


@frozen
class VisualMaterial:
    """`sapien.render.RenderMaterial`. None keeps SAPIEN's default.

    Attributes:
        base_color, emission: (·, 4), linear RGBA in 0..1 (an emission may be brighter).
        specular, roughness, metallic, transmission, ior, transmission_roughness: (·,).
    """

    base_color: Value | None = None
    emission: Value | None = None
    specular: Value | None = None
    roughness: Value | None = None
    metallic: Value | None = None
    transmission: Value | None = None
    ior: Value | None = None
    transmission_roughness: Value | None = None
    base_color_texture: Texture | None = None
    normal_texture: Texture | None = None
    roughness_texture: Texture | None = None
    metallic_texture: Texture | None = None
    emission_texture: Texture | None = None
    transmission_texture: Texture | None = None

    def numbers(self) -> dict[str, Value]:
        """The given colours and numbers, by field."""
        given = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: item for name, item in given.items() if item is not None and not isinstance(item, Texture)}

    def textures(self) -> dict[str, Texture]:
        """The given textures, by field."""
        given = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: item for name, item in given.items() if isinstance(item, Texture)}

    def values(self) -> tuple[Value, ...]:
        """All its values, including those of its textures."""
        return (*self.numbers().values(), *(texture.file for texture in self.textures().values()))

    def row(self, index: int) -> dict[str, float | list[float]]:
        """The given colours and numbers in row `index` of an entity, by field."""
        return {name: value.row(index).tolist() for name, value in self.numbers().items()}


def rebase_file(file: AssetFile, base: Path) -> AssetFile:
    """Renames a file for a document in the folder `base`. Relative URIs are rewritten, others stay."""
    if "://" in file.uri or Path(file.uri).is_absolute():
        return file
    return replace(file, uri=Path(os.path.relpath(file.path, base.absolute())).as_posix())


BodyType = Literal["dynamic", "kinematic", "static", "none", "link"]
"""A "link" is part of an articulation, never an entity."""


@frozen
class CollisionShape:
    """A collision shape.

    Attributes:
        geometry: type and sizes.
        pose: (·, 7) in the body's frame, p [m] then q (wxyz); None: the identity.
        material: (·,) index into `ScenePlan.physical_materials`; None: the default material.
        density: (·,) [kg/m³]; None: SAPIEN's (1000, a plane's 0).
        contact_offset, rest_offset, patch_radius, min_patch_radius: (·,) [m].
        collision_groups: (·, 4) SAPIEN's four integers; None: those of the body.
    """

    geometry: CollisionGeometry
    pose: Value | None = None
    material: Value | None = None
    density: Value | None = None
    contact_offset: Value | None = None
    rest_offset: Value | None = None
    patch_radius: Value | None = None
    min_patch_radius: Value | None = None
    collision_groups: Value | None = None
    origin: Origin | None = field(default=None, compare=False)


@frozen
class VisualShape:
    """A visual shape.

    Attributes:
        geometry: type and sizes.
        pose: (·, 7) in the body's frame, p [m] then q (wxyz); None: the identity.
        material: (·,) index into `ScenePlan.visual_materials`; None: a fresh `RenderMaterial`, and
            for a mesh the materials of its file.
        name: the render shape's name; None: "".
        front_face: None: SAPIEN's (clockwise for a mirrored mesh, else counterclockwise).
    """

    geometry: VisualGeometry
    pose: Value | None = None
    material: Value | None = None
    name: str | None = None
    front_face: Literal["counterclockwise", "clockwise"] | None = None
    origin: Origin | None = field(default=None, compare=False)


@frozen
class Inertial:
    """Mass properties that are given, not computed.

    Attributes:
        mass: (·,) [kg].
        com: (·, 7) centre of mass and principal axes in the body's frame.
        inertia: (·, 3) principal moments along the axes of `com` [kg·m²].
    """

    mass: Value
    com: Value
    inertia: Value


@frozen
class BodyStructure:
    """All arguments of `ActorBuilder` for a body, and its properties.

    Attributes:
        mass: (·,) [kg]; scales the mass and inertia computed from the densities.
        com: (·, 3) centre of mass in the body's frame [m], instead of the computed one or that of `inertial`.
        disable_gravity: (·,) bool.
        locked_motion_axes: (·, 6) bool, x y z rx ry rz; true locks the axis.
        linear_velocity, angular_velocity: (·, 3) initial, world frame [m/s, rad/s].
        linear_damping, angular_damping: (·,) [1/s].
        max_linear_velocity [m/s], max_angular_velocity [rad/s], max_depenetration_velocity [m/s],
            max_contact_impulse [N·s], sleep_threshold [m²/s²]: (·,).
        solver_position_iterations, solver_velocity_iterations: (·,) integers.
        collision_groups: (·, 4) SAPIEN's four integers, for each shape without its own.
        visibility: (·,) in 0..1; shading_mode: (·,) integer; of the render body.
        shapeless: whether the body has no shapes on purpose.
    """

    body_type: BodyType
    collisions: tuple[CollisionShape, ...] = ()
    visuals: tuple[VisualShape, ...] = ()
    mass: Value | None = None
    com: Value | None = None
    inertial: Inertial | None = None
    disable_gravity: Value | None = None
    locked_motion_axes: Value | None = None
    linear_velocity: Value | None = None
    angular_velocity: Value | None = None
    linear_damping: Value | None = None
    angular_damping: Value | None = None
    max_linear_velocity: Value | None = None
    max_angular_velocity: Value | None = None
    max_depenetration_velocity: Value | None = None
    max_contact_impulse: Value | None = None
    sleep_threshold: Value | None = None
    solver_position_iterations: Value | None = None
    solver_velocity_iterations: Value | None = None
    collision_groups: Value | None = None
    visibility: Value | None = None
    shading_mode: Value | None = None
    shapeless: bool | None = None
    origin: Origin | None = field(default=None, compare=False)

    def shape_groups(self) -> tuple[Value | None, ...]:
        """SAPIEN's four integers of each collision shape, (·, 4); None: the defaults."""
        if all(shape.collision_groups is None for shape in self.collisions):
            return (self.collision_groups,) * len(self.collisions)
        return tuple(shape.collision_groups or self.collision_groups for shape in self.collisions)

    @property
    def bodies(self) -> tuple[BodyStructure, ...]:
        """The body itself. An articulation returns its links here."""
        return (self,)


@frozen
class Mount:
    """A body or link that something is attached to.

    Attributes:
        entity: its name in the plan.
        link: of an articulation; None: the entity is a body.
    """

    entity: str
    link: str | None = None

    def __str__(self) -> str:
        """Its name in a scene file: `ENTITY` or `ENTITY/LINK`."""
        return self.entity if self.link is None else f"{self.entity}/{self.link}"


DEFAULT_COLLISION_GROUPS = (1, 1, 0, 0)
"""SAPIEN's default integers of a shape."""

COLLISION_ID_BITS = 0xFFFF
"""The bits of the fourth integer that matter for the third."""


def groups_collide(a: Any, b: Any) -> Any:
    """SAPIEN's rule for the four integers of two shapes (`PhysxCollisionShape.set_collision_groups`).

    Args:
        a: four integers, or four arrays of integers for many pairs at once.
        b: the same for the other shapes.
    """
    ignored = ((a[2] & b[2]) != 0) & ((a[3] & COLLISION_ID_BITS) == (b[3] & COLLISION_ID_BITS))
    return (((a[0] & b[1]) | (a[1] & b[0])) != 0) & (ignored == 0)
