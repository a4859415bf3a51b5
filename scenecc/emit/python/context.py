"""What all parts of a script share: materials, mount targets, identifiers and files.

A material that is the same in every scene is one variable. One that varies is created in the loop over scenes.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from scenecc.emit.python.source import Group, SourceNode, SourceWriter, call, string
from scenecc.emit.python.values import numbers_literal, structure_variants
from scenecc.plan import Friction, literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.emit.python.files import ScriptFiles
    from scenecc.emit.python.source import Identifiers
    from scenecc.emit.python.values import SceneValues
    from scenecc.plan import BodyStructure, CollisionShape, ScenePlan, Texture, Value, VisualMaterial, VisualShape
    from scenecc.plan.body import Mount


MaterialSort = Literal["physical", "look"]
"""Of colliding shapes, and of those that are seen."""

_SORTS: Final[tuple[MaterialSort, ...]] = ("physical", "look")


class ScriptMaterials:
    """The materials that shapes of a plan have."""

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
        """An expression for the material of a shape."""
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
        """The variable of the material of shapes that name none; None: SAPIEN's own."""
        return None if self._default is None else "default_material"

    def write(self, source: SourceWriter, files: ScriptFiles) -> None:
        """One assignment a material that is the same everywhere; those that are seen where there is a renderer."""
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
        """The materials of an entity's bodies that differ from scene to scene, ahead of what is made of them."""
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
    """Index of a material that is the same everywhere to the names of the entities that have it, by first use."""
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
    """A call with numbers; `columns`: None where they are the same everywhere."""
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
    """A `RenderTexture2D`; where scenes may differ, `columns` are those of what has it, and `key` names its list."""
    arguments: dict[str, SourceNode] = {
        name: string(value) if isinstance(value, str) else repr(value) for name, value in texture.sampling().items()
    }
    file = files.name(int(texture.file.data[0])) if columns is None else columns.value(texture.file, key, files.name)
    return call("sapien.render.RenderTexture2D", call("str", file), **arguments)


class MountTargets:
    """What of a plan is held on to."""

    def __init__(self, plan: ScenePlan) -> None:
        mounts = [mount for constraint in plan.constraints for mount in (constraint.child, constraint.parent)]
        mounts += [item.mount for section in (plan.lights, plan.cameras) for item in section]
        self._links: dict[str, dict[str | None, None]] = {}
        for mount in mounts:
            if mount is not None:
                self._links.setdefault(mount.entity, {})[mount.link] = None

    @staticmethod
    def expression(mount: Mount) -> str:
        """The `sapien.Entity` that is held on to, in `scene`."""
        link = "" if mount.link is None else f", {string(mount.link)}"
        return f"held[scene, {string(mount.entity)}{link}]"

    def is_body(self, names: tuple[str, ...]) -> bool:
        """Whether an entity of one of these names is held on to as a body."""
        return None in self._of(names)

    def links(self, names: tuple[str, ...]) -> list[str]:
        """The links of them that are held on to."""
        return [link for link in self._of(names) if link is not None]

    def _of(self, names: tuple[str, ...]) -> dict[str | None, None]:
        return {link: None for name in names for link in self._links.get(name, ())}

    def write_head(self, source: SourceWriter) -> None:
        """The dictionary, where anything is held on to."""
        if self._links:
            source.line()
            source.comment("What constraints, lights and cameras hold on to, by scene and name.")
            source.line("held = {}")

    @staticmethod
    def write_body(source: SourceWriter, name: SourceNode, entity: str) -> None:
        """Keeps a body. `name`: an expression for its entity's name. `entity`: one for the entity."""
        source.statement(entity, assign=f"held[scene, {name}]")

    @staticmethod
    def write_link(source: SourceWriter, name: SourceNode, link: str, entity: str) -> None:
        """Keeps a link, likewise."""
        source.statement(entity, assign=f"held[scene, {name}, {string(link)}]")


@dataclass(frozen=True, slots=True)
class ScriptContext:
    """Names, files and materials of a script, and what is held on to in it."""

    names: Identifiers
    files: ScriptFiles
    materials: ScriptMaterials
    mount_targets: MountTargets
