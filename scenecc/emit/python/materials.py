"""Materials of a plan in a script: a variable each, named after the one entity that has it where there is but one."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Literal

from scenecc.emit.python.columns import number, variants
from scenecc.emit.python.layout import Group, Node, Source, call, list_of, string
from scenecc.plan import Texture

if TYPE_CHECKING:
    from scenecc.emit.python.files import Files
    from scenecc.emit.python.names import Names
    from scenecc.plan import PhysicalMaterial, ScenePlan, VisualMaterial

_Sort = Literal["physical", "look"]


class Materials:
    """The materials that shapes of a plan have."""

    def __init__(self, plan: ScenePlan, names: Names) -> None:
        self._plan = plan
        self._physical = _named(_users(plan, "physical"), "physical", names)
        self._looks = _named(_users(plan, "look"), "look", names)
        bodies = [body for entity in plan.entities for _, body, _ in variants(entity)]
        needed = any(shape.material is None for body in bodies for shape in body.collisions)
        self._default = plan.physics.default_material if needed else None

    def physical(self, index: int) -> str:
        """The variable of a physical material."""
        return self._physical[int(index)]

    def look(self, index: int) -> str:
        """The variable of a visual material."""
        return self._looks[int(index)]

    @property
    def default(self) -> str | None:
        """The variable of the material of shapes that name none; None: SAPIEN's own."""
        return None if self._default is None else "default_material"

    def write(self, source: Source, files: Files) -> None:
        """One assignment a material; those that are seen where there is a renderer."""
        if self._default is not None or self._physical:
            source.line()
        if self._default is not None:
            source.statement(_physical(self._default), assign="default_material")
        for index, name in self._physical.items():
            source.statement(_physical(self._plan.physical_materials[index]), assign=name)
        if not self._looks:
            return
        source.line()
        with source.block("if render:"):
            for index, name in self._looks.items():
                _write_look(source, name, self._plan.visual_materials[index], files)


def _users(plan: ScenePlan, sort: _Sort) -> dict[int, set[str]]:
    """Table index to the names of the entities that have it, in order of first use."""
    users: dict[int, set[str]] = {}
    for entity in plan.entities:
        for _, structure, rows in variants(entity):
            for shape in structure.collisions if sort == "physical" else structure.visuals:
                if shape.material is not None:
                    data = shape.material.data[rows] if shape.material.varies else shape.material.data
                    for index in data.tolist():
                        users.setdefault(index, set()).add(entity.name)
    return users


def _named(users: dict[int, set[str]], sort: _Sort, names: Names) -> dict[int, str]:
    return {
        index: names.take(f"{next(iter(entities))}_{sort}" if len(entities) == 1 else f"shared_{sort}")
        for index, entities in users.items()
    }


def _physical(material: PhysicalMaterial) -> Group:
    given = {item.name: number(float(getattr(material, item.name))) for item in fields(material)}
    return call("physx.PhysxMaterial", **given)


def _write_look(source: Source, name: str, material: VisualMaterial, files: Files) -> None:
    plain: dict[str, Node] = {}
    textures: dict[str, Texture] = {}
    for item in fields(material):
        value = getattr(material, item.name)
        if isinstance(value, Texture):
            textures[item.name] = value
        elif value is not None:
            plain[item.name] = _plain(value)
    source.statement(call("sapien.render.RenderMaterial", **plain), assign=name)
    for key, texture in textures.items():
        source.statement(_texture(texture, files), assign=f"{name}.{key}")


def _plain(value: float | tuple[float, ...]) -> Node:
    return list_of([number(float(x)) for x in value]) if isinstance(value, tuple) else number(float(value))


def _texture(texture: Texture, files: Files) -> Group:
    given = {item.name: getattr(texture, item.name) for item in fields(texture) if item.name != "file"}
    arguments: dict[str, Node] = {
        key: string(value) if isinstance(value, str) else number(value)
        for key, value in given.items()
        if value is not None
    }
    return call("sapien.render.RenderTexture2D", call("str", files.name(texture.file)), **arguments)
