"""Materials of a plan in a script.

Those that are the same in every scene are a variable each, named after the one entity that has it where there is but
one; those that differ from scene to scene are made in the loop over the scenes of each entity that has them.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Literal

import numpy as np

from scenecc.emit.python.columns import numbers, variants
from scenecc.emit.python.layout import Group, Node, Source, call, string
from scenecc.plan import Friction, literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.files import Files
    from scenecc.emit.python.names import Names
    from scenecc.plan import BodyStructure, CollisionShape, ScenePlan, Texture, Value, VisualMaterial, VisualShape

_Sort = Literal["physical", "look"]


class Materials:
    """The materials that shapes of a plan have."""

    def __init__(self, plan: ScenePlan, names: Names) -> None:
        self._plan = plan
        self._names = names
        self._shared = {sort: _named(_users(plan, sort), sort, names) for sort in ("physical", "look")}
        self._own: dict[_Sort, dict[int, str]] = {}
        bodies = [body for entity in plan.entities for _, structure, _ in variants(entity) for body in structure.bodies]
        needed = any(shape.material is None for body in bodies for shape in body.collisions)
        self._default = plan.physics.default_material if needed else None

    def physical(self, material: Value, columns: Columns) -> Node:
        """An expression for the physical material of a shape."""
        return self._expression(material, "physical", columns)

    def look(self, material: Value, columns: Columns) -> Node:
        """An expression for the visual material of a shape."""
        return self._expression(material, "look", columns)

    @property
    def default(self) -> str | None:
        """The variable of the material of shapes that name none; None: SAPIEN's own."""
        return None if self._default is None else "default_material"

    def write(self, source: Source, files: Files) -> None:
        """One assignment a material that is the same everywhere; those that are seen where there is a renderer."""
        if self._default is not None or self._shared["physical"]:
            source.line()
        if self._default is not None:
            given = {item.name: literal(float(getattr(self._default, item.name))) for item in fields(Friction)}
            source.statement(_made("physx.PhysxMaterial", given, None), assign="default_material")
        for index, name in self._shared["physical"].items():
            self._write_physical(source, name, index, None)
        if not self._shared["look"]:
            return
        source.line()
        with source.block("if render:"):
            for index, name in self._shared["look"].items():
                _write_look(source, name, self._plan.visual_materials[index], None, files)

    def write_own(self, source: Source, bodies: Sequence[BodyStructure], columns: Columns, files: Files) -> None:
        """The materials of an entity's bodies that differ from scene to scene, ahead of what is made of them."""
        own = {sort: self._own_names(sort, bodies, columns) for sort in ("physical", "look")}
        self._own = {"physical": own["physical"], "look": own["look"]}
        for index, name in own["physical"].items():
            self._write_physical(source, name, index, columns)
        if own["look"]:
            with source.block("if render:"), columns.rendered():
                for index, name in own["look"].items():
                    _write_look(source, name, self._plan.visual_materials[index], columns, files)

    def _own_names(self, sort: str, bodies: Sequence[BodyStructure], columns: Columns) -> dict[int, str]:
        shapes = [shape for body in bodies for shape in _shapes(body, sort)]
        used = [index for shape in shapes for index in _indices(shape, columns.rows.tolist())]
        varying = [index for index in dict.fromkeys(used) if _varies(self._plan, sort, index)]
        return {index: self._names.take(f"{columns.ident}_{sort}") for index in varying}

    def _write_physical(self, source: Source, name: str, index: int, columns: Columns | None) -> None:
        material = self._plan.physical_materials[index]
        given = {item.name: getattr(material, item.name) for item in fields(material)}
        source.statement(_made("physx.PhysxMaterial", given, columns), assign=name)

    def _expression(self, material: Value, sort: _Sort, columns: Columns) -> Node:
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
        which = columns.of_block(places, f"{sort}_number", numbers)
        return f"({', '.join(own.get(index) or shared[index] for index in used)})[{which}]"


def _shapes(body: BodyStructure, sort: str) -> tuple[CollisionShape, ...] | tuple[VisualShape, ...]:
    return body.collisions if sort == "physical" else body.visuals


def _indices(shape: CollisionShape | VisualShape, rows: Iterable[int]) -> list[int]:
    if shape.material is None:
        return []
    data: list[int] = shape.material.data.tolist()
    return [data[row] for row in rows] if shape.material.varies else data


def _varies(plan: ScenePlan, sort: str, index: int) -> bool:
    material = plan.physical_materials[index] if sort == "physical" else plan.visual_materials[index]
    return any(value.varies for value in material.values())


def _users(plan: ScenePlan, sort: str) -> dict[int, set[str]]:
    """Index of a material that is the same everywhere to the names of the entities that have it, by first use."""
    users: dict[int, set[str]] = {}
    for entity in plan.entities:
        for _, structure, rows in variants(entity):
            for shape in (shape for body in structure.bodies for shape in _shapes(body, sort)):
                for index in _indices(shape, rows.tolist()):
                    if not _varies(plan, sort, index):
                        users.setdefault(index, set()).add(entity.name)
    return users


def _named(users: dict[int, set[str]], sort: str, names: Names) -> dict[int, str]:
    return {
        index: names.take(f"{next(iter(entities))}_{sort}" if len(entities) == 1 else f"shared_{sort}")
        for index, entities in users.items()
    }


def _made(constructor: str, given: dict[str, Value], columns: Columns | None) -> Group:
    """A call with numbers; `columns`: None where they are the same everywhere."""
    arguments = {
        name: numbers(value.data[0]) if columns is None else columns.value(value, name) for name, value in given.items()
    }
    return call(constructor, **arguments)


def _write_look(source: Source, name: str, material: VisualMaterial, columns: Columns | None, files: Files) -> None:
    source.statement(_made("sapien.render.RenderMaterial", material.numbers(), columns), assign=name)
    for key, texture in material.textures().items():
        source.statement(texture_of(texture, key, columns, files), assign=f"{name}.{key}")


def texture_of(texture: Texture, key: str, columns: Columns | None, files: Files) -> Group:
    """A `RenderTexture2D`; where scenes may differ, `columns` are those of what has it, and `key` names its list."""
    arguments: dict[str, Node] = {
        name: string(value) if isinstance(value, str) else repr(value) for name, value in texture.sampling().items()
    }
    file = files.name(int(texture.file.data[0])) if columns is None else columns.value(texture.file, key, files.name)
    return call("sapien.render.RenderTexture2D", call("str", file), **arguments)
