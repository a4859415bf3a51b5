"""The files that a scene is made of: what they are for, how large they are, and what is in them, by a hash."""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING, Final

from scenecc.files import open_regular
from scenecc.plan import ArticulationStructure, Texture, Value
from scenecc.summary.bodies import used_materials
from scenecc.summary.item import Fact, Item, some_words

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from scenecc.plan import Entity, ScenePlan
    from scenecc.source.paths import Naming

_IMAGES: Final = frozenset((".png", ".jpg", ".jpeg", ".bmp", ".tga", ".hdr", ".exr", ".ktx", ".ktx2"))
_MAPS: Final = ("file", "px", "nx", "py", "ny", "pz", "nz")
_UNIT: Final = 1000


def file_items(plan: ScenePlan, scene: tuple[str, Path] | None, named: Mapping[Path, Naming]) -> tuple[Item, ...]:
    """A row a file, the scene's own first.

    Args:
        plan: of the scene.
        scene: the scene's own file as messages have it, and where it is; None: it is in none.
        named: what was read on the way to the plan.
    """
    used = {plan.files[index].path: use for index, use in _uses(plan).items()}
    by_uri = {naming.uri: path for path, naming in named.items()}
    files = {path: naming.uri for path, naming in named.items()} | {file.path: file.uri for file in plan.files}
    found = [] if scene is None else [_item(scene[0], scene[1], "scene", (), ())]
    for path, uri in files.items():
        naming = named.get(path)
        by = () if naming is None else tuple(naming.by)
        role, names = used.get(path, ("" if naming is None else naming.role, ()))
        if not role:
            # What nothing of the plan has is part of what names it: a material file, a texture, an SRDF.
            owner = used.get(next((by_uri[name] for name in by if name in by_uri), path), ("other", ()))[0]
            role = "texture" if path.suffix.lower() in _IMAGES else owner
        found.append(_item(uri, path, role, by, names))
    return tuple(found)


def _uses(plan: ScenePlan) -> dict[int, tuple[str, tuple[str, ...]]]:
    """What the files of a plan are for, by index, and the names of what has them."""
    found: dict[int, tuple[str, dict[str, None]]] = {}
    for role, value, name in _values(plan):
        for index in value.bounds.alternatives or ():
            found.setdefault(int(index), (role, {}))[1][name] = None
    return {index: (role, tuple(names)) for index, (role, names) in found.items()}


def _values(plan: ScenePlan) -> Iterator[tuple[str, Value, str]]:
    """Every value that names files: what these are for, the value, and what has it."""
    for entity in plan.entities:
        yield from _of_entity(entity, plan)
    for light in plan.lights:
        texture = getattr(light.light, "texture", None)
        if isinstance(texture, Texture):
            yield "texture", texture.file, light.name
    around = plan.environment and plan.environment.map
    for name in _MAPS:
        value = getattr(around, name, None)
        if isinstance(value, Value):
            yield "environment", value, "environment"


def _of_entity(entity: Entity, plan: ScenePlan) -> Iterator[tuple[str, Value, str]]:
    for structure in entity.structures:
        if isinstance(structure, ArticulationStructure) and structure.file is not None:
            yield "robot", structure.file, entity.name
    for body in entity.bodies:
        for shape in (*body.collisions, *body.visuals):
            file = getattr(shape.geometry, "file", None)
            if isinstance(file, Value):
                yield "mesh", file, entity.name
    for index in used_materials(entity)["visual"]:
        for texture in plan.visual_materials[index].textures().values():
            yield "texture", texture.file, entity.name


def _item(uri: str, path: Path, role: str, by: tuple[str, ...], names: tuple[str, ...]) -> Item:
    facts = [Fact("path", str(path), "")]
    read = _read(path)
    if read is None:
        facts += [Fact("bytes", None, "cannot be read any more"), Fact("sha256", None, "")]
    else:
        size, digest = read
        facts += [Fact("bytes", size, _size(size)), Fact("sha256", digest, digest[:16])]
    facts += [
        Fact("named_by", list(by), "" if names else ", ".join(by)),
        Fact("used_by", list(names), some_words(names)),
    ]
    return Item(uri, role, tuple(facts))


def _read(path: Path) -> tuple[int, str] | None:
    """Size [bytes] and SHA-256 of a file; None where it is gone."""
    size, digest = 0, sha256()
    try:
        with open_regular(path) as file:
            while part := file.read(1 << 20):
                size += len(part)
                digest.update(part)
    except OSError:
        return None
    return size, digest.hexdigest()


def _size(count: int) -> str:
    number, unit = float(count), "B"
    for larger in ("kB", "MB", "GB"):
        if number < _UNIT:
            break
        number, unit = number / _UNIT, larger
    return f"{number:.4g} {unit}"
