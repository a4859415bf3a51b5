"""Reads all values of a live scene that SAPIEN has getters for.

It has none for fixed tendons (mimic joints), the mass and inertia scales of a drive, limits of a distance joint,
and the time until a body sleeps. These only show in trajectories.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import numpy as np

from scenecc.decompiler import tables
from scenecc.plan.scene import SCENE_CONFIG_FIELDS


@dataclass(frozen=True)
class Numbers:
    """One number or an array of numbers, with exact bits.

    -0.0 is read as 0.0, since the sign of zero is an accident of how a pose was composed. NaNs with the same bits are
    equal.

    Attributes:
        dtype: NumPy type string (`<f4`).
        shape: array shape; `()` for a number.
        data: the array's bytes in C order.
    """

    dtype: str
    shape: tuple[int, ...]
    data: bytes

    def array(self) -> np.ndarray:
        """Returns the numbers as a read-only array."""
        return np.frombuffer(self.data, dtype=self.dtype).reshape(self.shape)

    def __str__(self) -> str:
        # repr of a float32 has just enough digits to be unique.
        values = self.array()
        if values.size > 16:
            return f"{'×'.join(map(str, self.shape))} numbers"
        return str([str(x) for x in values.ravel()]).replace("'", "") if self.shape else str(values[()])


Plain: TypeAlias = "Numbers | str | bool | int | tuple[Plain, ...] | None"


@dataclass(frozen=True)
class LiveObject:
    """An object and its parts.

    Attributes:
        kind: the engine's class (`PhysxCollisionShapeBox`), or `scene`, `articulation` and so on.
        name: the object's name, "" if it has none.
        values: properties by the engine's names, in table order.
        parts: contained objects, in the engine's order.
    """

    kind: str
    name: str
    values: tuple[tuple[str, Plain], ...]
    parts: tuple[LiveObject, ...] = ()

    def value(self, name: str) -> Plain:
        """Returns a property.

        Raises:
            KeyError: there is none.
        """
        return dict(self.values)[name]

    def of_kind(self, kind: str) -> list[LiveObject]:
        """Returns the objects of a kind in the tree, including this one, depth first."""
        found = [self] if self.kind == kind else []
        return found + [inner for part in self.parts for inner in part.of_kind(kind)]


def comparable_value(value: Any) -> Plain:
    """Converts an engine value to comparable data.

    Raises:
        TypeError: unsupported type.
    """
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if type(value).__name__ == "Pose":
        value = np.concatenate([value.p, value.q])
    if isinstance(value, (float, np.ndarray, np.generic)):
        array: Any = np.ascontiguousarray(cast("Any", value))
        array = array.reshape(np.shape(cast("Any", value)))
        array = array + np.zeros((), array.dtype) if array.dtype.kind == "f" else array
        return Numbers(array.dtype.str, array.shape, array.tobytes())
    if isinstance(value, (list, tuple)):
        return tuple(comparable_value(item) for item in cast("list[Any]", value))
    raise TypeError(f"{type(value)} is not a plain value")


NameOf: TypeAlias = Callable[[Any], str]
"""Returns the name of an entity, an articulation, a link or a joint."""


def _own_name(thing: Any) -> str:
    return thing.name


def read_scene(scene: Any, name_of: NameOf = _own_name) -> LiveObject:
    """Reads a `sapien.Scene`: settings, entities in order, then articulations in the order of their root links."""
    system = scene.physx_system
    values: list[tuple[str, Plain]] = [("timestep", comparable_value(system.timestep))]
    values += _values(system.config, SCENE_CONFIG_FIELDS)
    if (renders := _system(scene, "render")) is not None:
        values.append(("ambient_light", comparable_value(renders.ambient_light)))
    entities = [read_entity(entity, name_of) for entity in scene.entities]
    robots = [read_articulation(articulation, name_of) for articulation in articulations(scene)]
    return LiveObject("scene", "", tuple(values), (*entities, *robots))


def articulations(scene: Any) -> list[Any]:
    """Returns the articulations of a scene, in the order of their root links among the entities."""
    components = [component for entity in scene.entities for component in entity.components]
    links = [component for component in components if type(component).__name__ == "PhysxArticulationLinkComponent"]
    return [link.articulation for link in links if link.is_root]


def _system(scene: Any, name: str) -> Any:
    try:
        return scene.get_system(name)
    except RuntimeError:  # the scene has no such system
        return None


def read_entity(entity: Any, name_of: NameOf = _own_name) -> LiveObject:
    """Reads an entity and its components, in order."""
    return LiveObject(
        "entity",
        name_of(entity),
        (("pose", comparable_value(entity.pose)),),
        tuple(_component(component, name_of) for component in entity.components),
    )


def read_articulation(articulation: Any, name_of: NameOf = _own_name) -> LiveObject:
    """Reads an articulation without its links, which are read as entities, and joints, which links contain."""
    order: list[tuple[str, Plain]] = [
        ("links", comparable_value([name_of(link.entity) for link in articulation.links])),
        ("joints", comparable_value([name_of(joint) for joint in articulation.joints])),
        ("active_joints", comparable_value([name_of(joint) for joint in articulation.active_joints])),
    ]
    values = _values(articulation, tables.ARTICULATION)
    return LiveObject("articulation", name_of(articulation), tuple(order + values))


def _component(component: Any, name_of: NameOf) -> LiveObject:
    kind = type(component).__name__
    values = _values(component, tables.COMPONENTS[kind])
    parts: list[LiveObject] = []
    if hasattr(component, "collision_shapes"):
        parts += [_shape(shape) for shape in component.collision_shapes]
    if hasattr(component, "render_shapes"):
        parts += [_visual(shape) for shape in component.render_shapes]
    if hasattr(component, "parent"):
        parent = component.parent
        values.append(("parent", None if parent is None else name_of(parent.entity)))
    if kind == "PhysxArticulationLinkComponent":
        values.append(("articulation", name_of(component.articulation)))
        parts.append(_joint(component.joint, name_of))
    return LiveObject(kind, component.name, tuple(values), tuple(parts))


def _joint(joint: Any, name_of: NameOf) -> LiveObject:
    names = tables.JOINT + (tables.AXIS if joint.dof else ())
    return LiveObject("joint", name_of(joint), tuple(_values(joint, names)))


def _shape(shape: Any) -> LiveObject:
    kind = type(shape).__name__
    material = LiveObject("material", "", tuple(_values(shape.physical_material, tables.PHYSICAL_MATERIAL)))
    return LiveObject(kind, "", tuple(_values(shape, tables.SHAPES[kind])), (material,))


def _visual(shape: Any) -> LiveObject:
    kind = type(shape).__name__
    values = _values(shape, (*tables.VISUALS[kind], *tables.VISUAL))
    return LiveObject(kind, shape.name, tuple(values), tuple(_visual_part(part) for part in shape.parts))


def _visual_part(part: Any) -> LiveObject:
    arrays = {
        "vertices": part.vertices,
        "triangles": part.triangles,
        "normals": part.get_vertex_normal(),
        "uvs": part.get_vertex_uv(),
    }
    return LiveObject(
        "part", "", tuple((name, comparable_value(array)) for name, array in arrays.items()), (_look(part.material),)
    )


def _look(material: Any) -> LiveObject:
    values = _values(material, tables.VISUAL_MATERIAL)
    for name in tables.TEXTURES:
        texture = getattr(material, f"{name}_texture")
        if texture is not None:
            values += [(f"{name}_texture.{key}", value) for key, value in _values(texture, tables.TEXTURE)]
    return LiveObject("material", "", tuple(values))


def _values(owner: Any, names: tuple[str, ...]) -> list[tuple[str, Plain]]:
    return [(name, comparable_value(_get(owner, name))) for name in names]


def _get(owner: Any, name: str) -> Any:
    kind = cast("Any", type(owner))
    if hasattr(kind, name):
        value = getattr(owner, name)
        return float(cast("Any", value)) if isinstance(value, np.floating) else value
    return getattr(owner, f"get_{name}")()
