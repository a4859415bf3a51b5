"""Engine objects of one entity or component across the scenes of a batch, and checks of values that users set."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from scenecc.backends.sapien.engine import physx, sapien
from scenecc.backends.sapien.shared_materials import MaterialPool
from scenecc.diagnostics.messages import show, suggest
from scenecc.geometry.rotations import UNIT_TOLERANCE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    Array = TypeVar("Array", bound=NDArray[Any])

Named = TypeVar("Named")


@dataclass(frozen=True, slots=True)
class EntityObjects:
    """The engine's objects of one entity, one for each scene of the batch that has it.

    Attributes:
        scene_idxs: indices among all scenes of the plan, ascending.
        objs: the object of each scene.
        row_of: scene index → row of the above.
    """

    name: str
    scene_idxs: tuple[int, ...]
    objs: list[Any]
    row_of: dict[int, int] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "row_of", {index: row for row, index in enumerate(self.scene_idxs)})

    def rows_in(self, scene_idxs: Iterable[int]) -> list[int]:
        """Returns the rows of the given scenes that have the entity, in their order."""
        return [self.row_of[index] for index in scene_idxs if index in self.row_of]


@dataclass(frozen=True, slots=True)
class BodyObjects(EntityObjects):
    """One entity's bodies; `objs` are `sapien.Entity`s.

    Attributes:
        components: the physical component of each scene, or None.
    """

    components: list[Any]

    def parts(self, row: int) -> list[tuple[Any, Any]]:
        """Returns the `sapien.Entity` of a row with its physical component; empty if it has none."""
        component = self.components[row]
        return [] if component is None else [(self.objs[row], component)]


@dataclass(frozen=True, slots=True)
class ArticulationObjects(EntityObjects):
    """One entity's articulations; `objs` are `PhysxArticulation`s. Make it while all are in their scenes.

    Attributes:
        entities, links: of each scene, in the order of the plan, which is also the order in which they are added.
        joints: active joints in the order of the engine's `qpos`. Outside a scene the engine has none.
        columns: position in `qpos` of each active joint, in the order of the plan.
        dof: largest number of active joints.
    """

    entities: list[list[Any]]
    links: list[list[Any]]
    joints: list[list[Any]] = field(init=False)
    columns: list[NDArray[np.intp]] = field(init=False)
    dof: int = field(init=False)

    def __post_init__(self) -> None:
        EntityObjects.__post_init__(self)
        joints = [obj.get_active_joints() for obj in self.objs]
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "columns", list(map(_joint_columns, self.links)))
        object.__setattr__(self, "dof", max(map(len, joints), default=0))

    def parts(self, row: int) -> list[tuple[Any, Any]]:
        """Returns the `sapien.Entity` and link of each link in a row, in the order in which they are added."""
        return list(zip(self.entities[row], self.links[row], strict=True))

    def in_scene(self, row: int) -> bool:
        """Returns whether it is in its scene now."""
        return self.entities[row][0].get_scene() is not None


@dataclass(frozen=True, slots=True)
class DrawnObjects:
    """Objects that no entity holds, kept by a build for resets.

    Attributes:
        physical, visual: drawn materials, by index in the plan's table, then by scene.
        densities: for rigid components with a drawn mass: mass [kg] and inertia (3,) [kg·m²] by density.
        pool: the materials that drawn ones with few values share.
    """

    physical: dict[int, dict[int, Any]] = field(default_factory=dict[int, "dict[int, Any]"])
    visual: dict[int, dict[int, Any]] = field(default_factory=dict[int, "dict[int, Any]"])
    densities: dict[Any, tuple[float, Any]] = field(default_factory=dict[Any, "tuple[float, Any]"])
    pool: MaterialPool = field(default_factory=MaterialPool)


def _joint_columns(links: list[Any]) -> NDArray[np.intp]:
    moving = [link.get_index() for link in links if link.get_joint().get_dof()]
    return np.argsort(np.argsort(moving))


def iterate_entities(objects: BodyObjects | ArticulationObjects) -> Iterator[tuple[int, Any]]:
    """Yields scene index and `sapien.Entity` of each body, in build order in each scene."""
    if isinstance(objects, BodyObjects):
        yield from zip(objects.scene_idxs, objects.objs, strict=True)
    else:
        for index, entities in zip(objects.scene_idxs, objects.entities, strict=True):
            yield from ((index, entity) for entity in entities)


def is_dynamic(component: Any) -> bool:
    """Returns whether a body is dynamic and was not made kinematic since."""
    return isinstance(component, physx.PhysxRigidDynamicComponent) and not component.get_kinematic()


def is_kinematic(component: Any) -> bool:
    """Returns whether the engine moves a body only by its pose and kinematic targets."""
    return isinstance(component, physx.PhysxRigidDynamicComponent) and component.get_kinematic()


def root_is_fixed(links: Sequence[Any]) -> bool:
    """Returns whether the first link of an articulation is fixed to the world."""
    return links[0].get_joint().get_type() == "fixed"


class ComponentBatch:
    """One entity, constraint, light or camera of the plan, in every scene that has it.

    Args:
        name: in the plan.
        scene_idxs: the scenes of the batch that have it, ascending.
        objs: its components in this order.
    """

    def __init__(self, name: str, scene_idxs: tuple[int, ...], objs: list[Any]) -> None:
        self._name = name
        self._scene_idxs = scene_idxs
        self._objs = objs
        self._closed = False

    def __setattr__(self, name: str, value: object) -> None:
        """Refuses an unknown public name, because writing to a misspelt `pose` would have no effect."""
        kind = type(self)
        if not name.startswith("_") and not hasattr(kind, name):
            known = (each for each in dir(kind) if getattr(getattr(kind, each), "fset", None) is not None)
            raise AttributeError(f"{kind.__name__} has no attribute `{name}`; {suggest(name, known)}")
        super().__setattr__(name, value)

    def __len__(self) -> int:
        return len(self._scene_idxs)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._name!r}, scene_idxs={list(self._scene_idxs)})"

    @property
    def name(self) -> str:
        """Its name in the plan, also that of its components."""
        return self._name

    @property
    def scene_idxs(self) -> tuple[int, ...]:
        """The scenes of this batch that have it, as indices among all scenes of the plan."""
        return self._scene_idxs

    @property
    def objs(self) -> list[Any]:
        """SAPIEN's component in each of these scenes. Raises RuntimeError once the batch is closed."""
        self._check_open()
        return self._objs

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError(f"the scenes of '{self._name}' are closed")

    def _close(self) -> None:
        self._closed = True
        self._objs = []


def spread_poses(pose: Any, count: int) -> list[sapien.Pose]:
    """Returns `count` poses from (7,), (count, 7), a `sapien.Pose` or a sequence of them. Raises ValueError."""
    if isinstance(pose, sapien.Pose):
        return [pose] * count
    if isinstance(pose, (list, tuple)):
        items: list[Any] = [*pose]  # pyright: ignore[reportUnknownArgumentType]
        if items and all(isinstance(item, sapien.Pose) for item in items):
            if len(items) != count:
                raise ValueError(f"{len(items)} poses for {count} scenes")
            return items
    rows = spread_array(pose, 7, count, "a pose")
    lengths = np.linalg.norm(rows[:, 3:].astype(np.float64), axis=1)
    if (np.abs(lengths - 1) > UNIT_TOLERANCE).any():
        raise ValueError("a pose's quaternion (its last four numbers, wxyz) must be of unit length")
    return [sapien.Pose(row[:3], row[3:]) for row in rows]


def spread_joint_values(numbers: Any, dofs: list[int], width: int, what: str) -> list[NDArray[np.float32]]:
    """Returns a row of joint values for each articulation, from (width,) or (B, width).

    `dofs`: number of active joints in each, at most `width`; further values are ignored. Raises ValueError.
    """
    rows = np.asarray(numbers, dtype=np.float32)
    if rows.shape not in ((width,), (1, width), (len(dofs), width)):
        raise ValueError(f"{what} must be ({width},) or ({len(dofs)}, {width}), not {rows.shape}")
    rows = np.broadcast_to(rows, (len(dofs), width))
    found = [row[:dof].copy() for row, dof in zip(rows, dofs, strict=True)]
    if not all(np.isfinite(row).all() for row in found):
        raise ValueError(f"{what} must be finite")
    return found


def unknown_name(name: object, known: Sequence[str], what: str, owner: str | None = None) -> KeyError:
    """Returns the error for an unknown name, with the closest known name. `what`: kind of the names: "link"."""
    whose = "" if owner is None else f" of '{owner}'"
    by = "" if isinstance(name, str) else " (objects are found by name, not by number)"
    return KeyError(f"no {what} {show(name)}{whose}{by}; {suggest(str(name), known) or 'there are none'}")


class NamedObjects(dict[str, Named]):
    """Objects by name. An unknown name raises KeyError with the closest. Arguments are as for `unknown_name`."""

    def __init__(self, objects: Mapping[str, Named], what: str, owner: str | None = None) -> None:
        super().__init__(objects)
        self._what, self._owner = what, owner

    def __missing__(self, name: str) -> Named:
        raise unknown_name(name, tuple(self), self._what, self._owner)


def freeze_array(array: Array) -> Array:
    """Returns the array, made read-only, because writing to a copy of the engine's values would have no effect."""
    array.flags.writeable = False
    return array


def pad_rows(rows: list[Any], width: int) -> NDArray[np.float32]:
    """Returns (B, width, …) from rows (dof, …), padded with NaN."""
    shape = np.shape(rows[0])[1:] if rows else ()
    found = np.full((len(rows), width, *shape), np.nan, np.float32)
    for row, numbers in zip(found, rows, strict=True):
        row[: len(numbers)] = numbers
    return found


def spread_array(given: Any, width: int, count: int, what: str) -> NDArray[np.float32]:
    """Returns (count, width) float32 from (width,) or (count, width). Raises ValueError."""
    rows = np.asarray(given, dtype=np.float32)
    if rows.shape not in ((width,), (1, width), (count, width)):
        raise ValueError(f"{what} must be ({width},) or ({count}, {width}), not {rows.shape}")
    if not np.isfinite(rows).all():
        raise ValueError(f"{what} must be finite")
    return np.broadcast_to(rows, (count, width)).copy()
