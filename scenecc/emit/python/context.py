"""Shared state of a script: values by scene, materials, mount targets, identifiers and files.

A material that is the same in every scene is one variable. One that varies is created in the loop over scenes.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from scenecc.emit.python.source import (
    Group,
    Identifiers,
    SourceNode,
    SourceWriter,
    call,
    list_of,
    number_literal,
    string,
)
from scenecc.plan import literal
from scenecc.plan.body import Friction, Mount, Texture, VisualMaterial

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.emit.python.files import ScriptFiles
    from scenecc.plan import ArticulationStructure, BodyStructure, CollisionShape, Entity, ScenePlan, Value, VisualShape

IDENTITY_ROW = np.array([0, 0, 0, 1, 0, 0, 0], dtype=np.float64)


def numbers_literal(row: NDArray[Any]) -> SourceNode:
    """Returns a number, or nested lists of numbers."""
    return _nested_literal(row.tolist())


def pose_call(row: NDArray[np.float64]) -> SourceNode:
    """Returns a `sapien.Pose` call, without an identity rotation."""
    rotation = () if row[3:].tobytes() == IDENTITY_ROW[3:].tobytes() else (numbers_literal(row[3:]),)
    return call("sapien.Pose", numbers_literal(row[:3]), *rotation)


def frame_expression(value: Value | None, name: str, columns: SceneValues) -> SourceNode:
    """Returns a pose of a joint or constraint; `sapien.Pose()` if the plan has none."""
    return call("sapien.Pose") if value is None else columns.value(value, name, pose_call)


def present_fields(holder: object, names: tuple[str, ...]) -> list[str]:
    """Returns the given fields that are set."""
    return [name for name in names if getattr(holder, name) is not None]


def write_properties(
    source: SourceWriter, holder: object, names: tuple[str, ...], columns: SceneValues, variable: str
) -> None:
    """Writes the given properties that the plan sets. `variable`: the SAPIEN object that has them."""
    for name in present_fields(holder, names):
        # `armature` is one number per degree of freedom.
        literal = _list_literal if name == "armature" else numbers_literal
        node = columns.value(getattr(holder, name), name, literal)
        if name == "locked_motion_axes":
            source.statement(call(f"{variable}.set_{name}", node))
        else:
            source.statement(node, assign=f"{variable}.{name}")


def _list_literal(row: NDArray[Any]) -> SourceNode:
    return list_of([numbers_literal(row)])


def _nested_literal(item: float | list[Any]) -> SourceNode:
    if not isinstance(item, list):
        return number_literal(item)
    return list_of([_nested_literal(one) for one in item])


def structure_variants(entity: Entity) -> list[tuple[int, BodyStructure | ArticulationStructure, NDArray[np.intp]]]:
    """Returns the structures used in some scene: index, structure, and the rows of the entity that have it."""
    pick = np.broadcast_to(0 if entity.pick is None else entity.pick.data, len(entity.scene_idxs))
    found = ((index, structure, np.flatnonzero(pick == index)) for index, structure in enumerate(entity.structures))
    return [(index, structure, rows) for index, structure, rows in found if len(rows)]


@dataclass(slots=True)
class SceneValues:
    """Expressions for one entity in the scenes of one block.

    Attributes:
        ident: prefix of the names of lists.
        rows: the entity's rows (not scene indices) that the block builds.
        names: source of unique names.
    """

    ident: str
    rows: NDArray[np.intp]
    names: Identifiers
    _lists: dict[Group, str] = field(default_factory=dict[Group, str])
    _render_only: set[str] = field(default_factory=set[str])
    _rendered: bool = False

    def value(self, value: Value, name: str, write: Callable[[Any], SourceNode] = numbers_literal) -> SourceNode:
        """Returns an expression for a quantity of the plan. `write`: makes an expression from one row."""
        return self.of_block(value.data[self.rows] if value.varies else value.data, name, write)

    def of_block(
        self, data: NDArray[Any], name: str, write: Callable[[Any], SourceNode] = numbers_literal
    ) -> SourceNode:
        """Like `value`, for data with one row per row of the block, or a single row."""
        return self._choose_item([row.tobytes() for row in data], name, lambda row: write(data[row]))

    def words(self, items: Sequence[str], name: str) -> SourceNode:
        """Returns an expression for strings, one per row of the block."""
        return self._choose_item(items, name, lambda row: string(items[row]))

    def _choose_item(self, keys: Sequence[Hashable], name: str, write: Callable[[int], SourceNode]) -> SourceNode:
        """Returns a literal if all rows are equal, otherwise an item of a list by scene."""
        return write(0) if len(set(keys)) == 1 else self._item(name, list_of(list(map(write, range(len(keys))))))

    def of_rows(self, value: Value) -> NDArray[Any]:
        """Returns the plan's data, one row per row of the block."""
        return value.data[self.rows] if value.varies else np.repeat(value.data, len(self.rows), axis=0)

    @contextmanager
    def rendered(self) -> Generator[None]:
        """Lists created within the block are assigned only if `render`."""
        self._rendered = True
        yield
        self._rendered = False

    @property
    def reads_row(self) -> bool:
        """Whether any expression uses the row `i`."""
        return bool(self._lists)

    def write(self, source: SourceWriter) -> None:
        """Assigns the lists, before the loop over scenes."""
        for items, name in self._lists.items():
            if name not in self._render_only:
                source.statement(items, assign=name)
        if self._render_only:
            with source.block("if render:"):
                for items, name in self._lists.items():
                    if name in self._render_only:
                        source.statement(items, assign=name)

    def _item(self, name: str, items: Group) -> str:
        # Collision and visual shapes often have the same sizes, and share a list.
        variable = self._lists.get(items)
        if variable is None:
            variable = self._lists[items] = self.names.take(f"{self.ident}_{name}")
            if self._rendered:
                self._render_only.add(variable)
        elif not self._rendered:
            self._render_only.discard(variable)
        return f"{variable}[i]"


@contextmanager
def scene_block(
    source: SourceWriter, title: str, name: str, scene_idxs: tuple[int, ...], num_scenes: int, names: Identifiers
) -> Generator[tuple[SourceWriter, SceneValues]]:
    """Yields a source for the statements that build one object in `scene`, and runs them in each of its scenes.

    Writes nothing if there are none. `title`: a comment before them; `name`: prefix of the names of lists of values.
    """
    columns = SceneValues(name, np.arange(len(scene_idxs)), names)
    inner = SourceWriter(depth=source.depth + (len(scene_idxs) > 1))
    yield inner, columns
    if inner.is_empty:
        return
    source.gap()
    source.comment(title)
    append_in_scenes(source, inner, columns, scene_idxs, num_scenes)


def append_in_scenes(
    source: SourceWriter, inner: SourceWriter, columns: SceneValues, scene_idxs: tuple[int, ...], num_scenes: int
) -> None:
    """Appends statements that run in each of some scenes as `scene`, after the lists that they read."""
    scenes = _scene_selection(source, columns, scene_idxs, num_scenes)
    columns.write(source)
    if len(scene_idxs) > 1:
        with source.block(f"for i, scene in enumerate({scenes}):" if columns.reads_row else f"for scene in {scenes}:"):
            source.append(inner)
        return
    if num_scenes > 1:
        source.line(f"scene = {scenes}")
    source.append(inner)


def _scene_selection(source: SourceWriter, columns: SceneValues, scene_idxs: tuple[int, ...], num_scenes: int) -> str:
    """Returns an expression for the scenes of a block, or for its one scene."""
    if len(scene_idxs) == 1:
        return f"scenes[{scene_idxs[0]}]"
    if len(scene_idxs) == num_scenes:
        return "scenes"
    steps = {b - a for a, b in pairwise(scene_idxs)}
    if len(steps) == 1:
        step = steps.pop()
        first, last = scene_idxs[0], scene_idxs[-1]
        return f"scenes[{first}:{last + 1}]" if step == 1 else f"scenes[{first}:{last + 1}:{step}]"
    variable = columns.names.take(f"{columns.ident}_scenes")
    source.statement(list_of([str(index) for index in scene_idxs]), assign=variable)
    return f"[scenes[k] for k in {variable}]"


MaterialSort = Literal["physical", "look"]
"""The kind of a material: for collision shapes or for visual shapes."""

_SORTS: Final[tuple[MaterialSort, ...]] = ("physical", "look")


class ScriptMaterials:
    """The materials that the shapes of a plan use."""

    def __init__(self, plan: ScenePlan, names: Identifiers) -> None:
        self._plan = plan
        self._names = names
        self._shared = {sort: _take_names(_material_users(plan, sort), sort, names) for sort in _SORTS}
        self._own: dict[MaterialSort, dict[int, str]] = {}
        bodies = [
            body
            for entity in plan.entities
            for _, structure, _ in structure_variants(entity)
            for body in structure.bodies
        ]
        needed = any(shape.material is None for body in bodies for shape in body.collisions)
        self._default = plan.physics.default_material if needed else None

    def expression(self, material: Value, sort: MaterialSort, columns: SceneValues) -> SourceNode:
        """Returns an expression for the material of a shape."""
        own, shared = self._own.get(sort, {}), self._shared[sort]
        indices = columns.of_rows(material)
        used: list[int] = list(dict.fromkeys(indices.tolist()))
        if not own.keys() & set(used):
            return columns.value(material, "material" if sort == "physical" else "look", lambda i: shared[int(i)])
        if len(used) == 1:
            return own[used[0]]
        places = np.zeros(len(indices), np.int64)
        for place, index in enumerate(used):
            places[indices == index] = place
        which = columns.of_block(places, f"{sort}_number", numbers_literal)
        return f"({', '.join(own.get(index) or shared[index] for index in used)})[{which}]"

    @property
    def default(self) -> str | None:
        """Returns the variable of the default material, or None for SAPIEN's own."""
        return None if self._default is None else "default_material"

    def write(self, source: SourceWriter, files: ScriptFiles) -> None:
        """Assigns the materials that are the same in all scenes; visual materials only if `render`."""
        if self._default is not None or self._shared["physical"]:
            source.line()
        if self._default is not None:
            given = {item.name: literal(float(getattr(self._default, item.name))) for item in fields(Friction)}
            source.statement(_material_call("physx.PhysxMaterial", given, None), assign="default_material")
        for index, name in self._shared["physical"].items():
            self._write_physical(source, name, index, None)
        if not self._shared["look"]:
            return
        source.line()
        with source.block("if render:"):
            for index, name in self._shared["look"].items():
                _write_visual_material(source, name, self._plan.visual_materials[index], None, files)

    def write_own(
        self, source: SourceWriter, bodies: Sequence[BodyStructure], columns: SceneValues, files: ScriptFiles
    ) -> None:
        """Assigns the materials of an entity's bodies that vary by scene. Call it before writing the bodies."""
        own = self._own = {sort: self._own_names(sort, bodies, columns) for sort in _SORTS}
        for index, name in own["physical"].items():
            self._write_physical(source, name, index, columns)
        if own["look"]:
            with source.block("if render:"), columns.rendered():
                for index, name in own["look"].items():
                    _write_visual_material(source, name, self._plan.visual_materials[index], columns, files)

    def _own_names(self, sort: MaterialSort, bodies: Sequence[BodyStructure], columns: SceneValues) -> dict[int, str]:
        shapes = [shape for body in bodies for shape in _shapes_of_kind(body, sort)]
        used = [index for shape in shapes for index in _material_indices(shape, columns.rows.tolist())]
        varying = [index for index in dict.fromkeys(used) if _varies(self._plan, sort, index)]
        return {index: self._names.take(f"{columns.ident}_{sort}") for index in varying}

    def _write_physical(self, source: SourceWriter, name: str, index: int, columns: SceneValues | None) -> None:
        material = self._plan.physical_materials[index]
        given = {item.name: getattr(material, item.name) for item in fields(material)}
        source.statement(_material_call("physx.PhysxMaterial", given, columns), assign=name)


def _shapes_of_kind(body: BodyStructure, sort: MaterialSort) -> tuple[CollisionShape, ...] | tuple[VisualShape, ...]:
    return body.collisions if sort == "physical" else body.visuals


def _material_indices(shape: CollisionShape | VisualShape, rows: Iterable[int]) -> list[int]:
    if shape.material is None:
        return []
    data: list[int] = shape.material.data.tolist()
    return [data[row] for row in rows] if shape.material.varies else data


def _varies(plan: ScenePlan, sort: MaterialSort, index: int) -> bool:
    material = plan.physical_materials[index] if sort == "physical" else plan.visual_materials[index]
    return any(value.varies for value in material.values())


def _material_users(plan: ScenePlan, sort: MaterialSort) -> dict[int, set[str]]:
    """Returns, for each material that is the same in all scenes, the entities that use it, in order of first use."""
    users: dict[int, set[str]] = {}
    for entity in plan.entities:
        for _, structure, rows in structure_variants(entity):
            for shape in (shape for body in structure.bodies for shape in _shapes_of_kind(body, sort)):
                for index in _material_indices(shape, rows.tolist()):
                    if not _varies(plan, sort, index):
                        users.setdefault(index, set()).add(entity.name)
    return users


def _take_names(users: dict[int, set[str]], sort: MaterialSort, names: Identifiers) -> dict[int, str]:
    return {
        index: names.take(f"{next(iter(entities))}_{sort}" if len(entities) == 1 else f"shared_{sort}")
        for index, entities in users.items()
    }


def _material_call(constructor: str, given: dict[str, Value], columns: SceneValues | None) -> Group:
    """Returns a call with numeric arguments. `columns`: None if they are the same in all scenes."""
    arguments = {
        name: numbers_literal(value.data[0]) if columns is None else columns.value(value, name)
        for name, value in given.items()
    }
    return call(constructor, **arguments)


def _write_visual_material(
    source: SourceWriter, name: str, material: VisualMaterial, columns: SceneValues | None, files: ScriptFiles
) -> None:
    source.statement(_material_call("sapien.render.RenderMaterial", material.numbers(), columns), assign=name)
    for key, texture in material.textures().items():
        source.statement(texture_call(texture, key, columns, files), assign=f"{name}.{key}")


def texture_call(texture: Texture, key: str, columns: SceneValues | None, files: ScriptFiles) -> Group:
    """Returns a `RenderTexture2D` call. `columns`: None if the same in all scenes; `key`: name of its list of files."""
    arguments: dict[str, SourceNode] = {
        name: string(value) if isinstance(value, str) else repr(value) for name, value in texture.sampling().items()
    }
    file = files.name(int(texture.file.data[0])) if columns is None else columns.value(texture.file, key, files.name)
    return call("sapien.render.RenderTexture2D", call("str", file), **arguments)


class MountTargets:
    """The entities and links on which constraints, lights and cameras are mounted."""

    def __init__(self, plan: ScenePlan) -> None:
        mounts = [mount for constraint in plan.constraints for mount in (constraint.child, constraint.parent)]
        mounts += [item.mount for section in (plan.lights, plan.cameras) for item in section]
        self._links: dict[str, dict[str | None, None]] = {}
        for mount in mounts:
            if mount is not None:
                self._links.setdefault(mount.entity, {})[mount.link] = None

    @staticmethod
    def expression(mount: Mount) -> Group:
        """Returns an expression for the `sapien.Entity` of a mount, in `scene`."""
        names = (name for name in (mount.entity, mount.link) if name is not None)
        return Group("held[", ("scene", *map(string, names)), "]")

    def is_body(self, name: str) -> bool:
        """Returns whether an entity is a mount target as a body."""
        return None in self._links.get(name, ())

    def links(self, name: str) -> list[str]:
        """Returns the links of an entity that are mount targets."""
        return [link for link in self._links.get(name, ()) if link is not None]

    def write_head(self, source: SourceWriter) -> None:
        """Creates the dictionary of mount targets, if there are any."""
        if self._links:
            source.line()
            source.comment("Bodies that constraints, lights and cameras are attached to, by scene and name.")
            source.line("held = {}")

    @staticmethod
    def write_body(source: SourceWriter, name: SourceNode, entity: SourceNode) -> None:
        """Stores a body. `name`: an expression for its entity's name. `entity`: one for the entity."""
        source.statement(entity, assign=Group("held[", ("scene", name), "]"))

    @staticmethod
    def write_link(source: SourceWriter, name: SourceNode, link: str, entity: SourceNode) -> None:
        """Stores a link, in the same way."""
        source.statement(entity, assign=Group("held[", ("scene", name, string(link)), "]"))


@dataclass(frozen=True, slots=True)
class ScriptContext:
    """Names, files, materials and mount targets of a script."""

    names: Identifiers
    files: ScriptFiles
    materials: ScriptMaterials
    mount_targets: MountTargets
