"""`inspect_scene`: a scene as one tree of facts, with the files that it uses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Final

from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
from scenecc.errors import SceneError
from scenecc.files import open_regular
from scenecc.inspect.entities import Made, entity_item, scene_facts, summarize, used_materials
from scenecc.inspect.facts import Fact, FactReader, Item, fact, mount_words, some_words
from scenecc.named_files import DICT
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import CompileResult, Source, build_batch, compile_or_raise, list_result_params, select_scenes
from scenecc.plan import ArticulationStructure, Constraint, Value
from scenecc.plan.body import Texture
from scenecc.plan.constraint import is_ball
from scenecc.plan.rendering import Camera, Light, SkyMap
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.expand.listing import ParamRow
    from scenecc.inspect.varying import VaryingField
    from scenecc.plan import Entity, ScenePlan
    from scenecc.source.paths import FileReference

_DEFAULTS: Final = (Fact("defaults", value=True, words="SAPIEN's defaults"),)


def scene_item(
    plan: ScenePlan,
    *,
    scene: int | None,
    made: Mapping[str, Made],
    params: Sequence[ParamRow] = (),
    given: Mapping[str, Any] | None = None,
    files: tuple[Item, ...] = (),
) -> Item:
    """Returns the tree of a scene.

    Args:
        plan: of the scenes.
        scene: the scene to describe. None: all of them, with ranges of values.
        made: measured entities by name; empty if nothing was built.
        params: parameters of the scene file.
        given: values of parameters from the caller.
        files: items of the scene's files.
    """
    facts = [fact("num_scenes", plan.num_scenes), fact("seed", plan.seed)]
    if scene is not None:
        facts.append(fact("scene", scene))
    if plan.description:
        facts.append(Fact("description", plan.description, plan.description.partition("\n")[0]))
    groups: list[tuple[str, Item | tuple[Item, ...]]] = [
        ("physics", Item("", "", tuple(FactReader(plan, 0).of(plan.physics)) or _DEFAULTS)),
        ("parameters", tuple(_param_item(row, given or {}) for row in params)),
        (
            "entities",
            tuple(entity_item(one, plan, scene, made.get(one.name)) for one in _in_scene(plan.entities, scene)),
        ),
        ("constraints", tuple(_object_item(one, one.joint, plan, scene) for one in _in_scene(plan.constraints, scene))),
        ("lights", tuple(_object_item(one, one.light, plan, scene) for one in _in_scene(plan.lights, scene))),
        ("cameras", tuple(_object_item(one, one.lens, plan, scene) for one in _in_scene(plan.cameras, scene))),
    ]
    if plan.expectations:
        from scenecc.plan.expect import describe_expectation

        expected = [one for one in plan.expectations if scene is None or scene in getattr(one, "scene_idxs", (scene,))]
        groups.append(("expect", tuple(Item(one.name, describe_expectation(one), ()) for one in expected)))
    if plan.environment is not None:
        facts_of = FactReader(plan, scene)
        around = (*facts_of.of(plan.environment, without=("map",)), *facts_of.of(plan.environment.map, "map"))
        groups.append(("environment", Item("", _map_word(plan), around)))
    groups += [("materials", _materials(plan, scene)), ("variation", _variation(plan, scene)), ("files", files)]
    return Item(plan.name, "scene", tuple(facts), tuple(group for group in groups if group[1]))


def entities_item(entities: Iterable[Entity], plan: ScenePlan, *, scene: int | None, made: Mapping[str, Made]) -> Item:
    """Returns the tree of some entities. Other arguments are as for `scene_item`."""
    items = tuple(entity_item(one, plan, scene, made.get(one.name)) for one in entities)
    facts = (fact("num_scenes", plan.num_scenes), *([] if scene is None else [fact("scene", scene)]))
    return Item(plan.name, "scene", facts, (("entities", items),))


def matching(plan: ScenePlan, pattern: str | None, scene: int | None) -> list[Entity]:
    """Returns the entities of a scene (None: of all) whose names match a pattern (`*`, `?`, `[…]`; None: any)."""
    entities = _in_scene(plan.entities, scene)
    return [one for one in entities if pattern is None or one.name == pattern or fnmatchcase(one.name, pattern)]


def _in_scene(listed: Iterable[Any], scene: int | None) -> list[Any]:
    return [one for one in listed if scene is None or scene in one.scene_idxs]


_DESCRIBED_FIELDS: Final = frozenset({"name", "scene_idxs", "parent", "joint", "light", "width", "height", "lens"})
"""Fields of a constraint, light or camera that are described separately."""


def _object_item(one: Constraint | Light | Camera, kind: Any, plan: ScenePlan, scene: int | None) -> Item:
    """Returns the item of a constraint, light or camera. `kind`: its joint, light or lens, whose fields are inlined."""
    facts = FactReader(plan, None if scene is None else one.scene_idxs.index(scene))
    first: tuple[Fact, ...] = ()
    if isinstance(one, Constraint):
        parent = mount_words(one.parent)
        first = (Fact("parent", parent, parent),)
    elif isinstance(one, Camera):
        first = (fact("size", [one.width, one.height], "px"),)
    listed = (*scene_facts(one.scene_idxs, plan), *first, *facts.of(one, without=_DESCRIBED_FIELDS), *facts.of(kind))
    is_joint = isinstance(one, Constraint)
    return Item(one.name, "ball" if is_joint and is_ball(kind) else type_name(kind.__class__), listed)


def _map_word(plan: ScenePlan) -> str:
    around = plan.environment and plan.environment.map
    return "" if around is None else "sky map" if isinstance(around, SkyMap) else "cube map"


def _param_item(row: ParamRow, given: Mapping[str, Any]) -> Item:
    facts: list[Fact] = []
    if row.name in given:
        facts.append(Fact("value", given[row.name], str(given[row.name])))
    if row.default is not None:
        facts.append(Fact("default", row.value, row.default))
    facts += [Fact(name, bound, "") for name, bound in (("min", row.low), ("max", row.high)) if bound is not None]
    if row.options:
        facts.append(Fact("options", list(row.options), ""))
    if row.range:
        facts.append(Fact("range", row.range, row.range))
    if row.description:
        facts.append(Fact("description", row.description, row.description))
    return Item(row.name, row.type, tuple(facts))


def _materials(plan: ScenePlan, scene: int | None) -> tuple[Item, ...]:
    """Returns the tables of materials, because shapes refer to them by number."""
    users: dict[tuple[str, int], list[Entity]] = {}
    for entity in _in_scene(plan.entities, scene):
        for kind, numbers in used_materials(entity).items():
            for number in numbers:
                users.setdefault((kind, number), []).append(entity)
    items: list[Item] = []
    for kind, table in (("physical", plan.physical_materials), ("visual", plan.visual_materials)):
        for number, material in enumerate(table):
            having = users.get((kind, number), [])
            if scene is not None and not having:
                continue
            # Rows of a material follow the scenes of its users.
            row = None if scene is None else having[0].scene_idxs.index(scene)
            names = tuple(entity.name for entity in having)
            used = Fact("used_by", list(names), some_words(names))
            items.append(Item("", kind, (fact("number", number), *FactReader(plan, row).of(material), used)))
    return tuple(items)


def _variation(plan: ScenePlan, scene: int | None) -> tuple[Item, ...]:
    """Returns the varying fields of each object, as a dry run lists them."""
    rows = summarize(plan, None, None if scene is None else (scene,))
    return tuple(Item(row.name, "", tuple(map(_varying_fact, row.varying))) for row in rows if row.varying)


def _varying_fact(field: VaryingField) -> Fact:
    words = f"{field.values} at reset" if field.at_reset else field.values
    return Fact(field.field, {"values": field.values, "at_reset": field.at_reset}, words)


_IMAGES: Final = frozenset((".png", ".jpg", ".jpeg", ".bmp", ".tga", ".hdr", ".exr", ".ktx", ".ktx2"))
_MAPS: Final = ("file", "px", "nx", "py", "ny", "pz", "nz")
_UNIT: Final = 1000


def file_items(
    plan: ScenePlan, scene: tuple[str, Path] | None, named: Mapping[Path, FileReference]
) -> tuple[Item, ...]:
    """Returns an item for each file, the scene's own first.

    Args:
        plan: of the scene.
        scene: name of the scene's file in messages, and its path. None: it is not in a file.
        named: files that were read to make the plan.
    """
    used = {plan.files[index].path: use for index, use in _uses(plan).items()}
    by_uri = {naming.uri: path for path, naming in named.items()}
    files = {path: naming.uri for path, naming in named.items()} | {file.path: file.uri for file in plan.files}
    found = [] if scene is None else [_file_item(scene[0], scene[1], "scene", (), ())]
    for path, uri in files.items():
        naming = named.get(path)
        by = () if naming is None else tuple(naming.by)
        role, names = used.get(path, ("" if naming is None else naming.role, ()))
        if not role:
            # Files that no part of the plan has belong to the file that names them: a material file, a texture, an
            # SRDF.
            owner = used.get(next((by_uri[name] for name in by if name in by_uri), path), ("other", ()))[0]
            role = owner if path.suffix.lower() not in _IMAGES else "heights" if _is_of_scene_files(by) else "texture"
        found.append(_file_item(uri, path, role, by, names))
    return tuple(found)


def _is_of_scene_files(names: Sequence[str]) -> bool:
    """Returns whether only scene files name a file, as for terrain heights, which are in the plan."""
    return bool(names) and all(name == DICT or name.lower().endswith((".yaml", ".yml")) for name in names)


def _uses(plan: ScenePlan) -> dict[int, tuple[str, tuple[str, ...]]]:
    """Returns the role of each file of a plan, by index, and the names of its users."""
    found: dict[int, tuple[str, dict[str, None]]] = {}
    for role, value, name in _values(plan):
        for index in value.bounds.alternatives or ():
            found.setdefault(int(index), (role, {}))[1][name] = None
    return {index: (role, tuple(names)) for index, (role, names) in found.items()}


def _values(plan: ScenePlan) -> Iterator[tuple[str, Value, str]]:
    """Yields every value that names files: their role, the value, and its owner."""
    for entity in plan.entities:
        yield from _list_values(entity, plan)
    for light in plan.lights:
        texture = getattr(light.light, "texture", None)
        if isinstance(texture, Texture):
            yield "texture", texture.file, light.name
    around = plan.environment and plan.environment.map
    for name in _MAPS:
        value = getattr(around, name, None)
        if isinstance(value, Value):
            yield "environment", value, "environment"


def _list_values(entity: Entity, plan: ScenePlan) -> Iterator[tuple[str, Value, str]]:
    for structure in entity.structures:
        if isinstance(structure, ArticulationStructure):
            yield from (("robot", file, entity.name) for file in structure.description_files)
    for body in entity.bodies:
        for shape in (*body.collisions, *body.visuals):
            file = getattr(shape.geometry, "file", None)
            if isinstance(file, Value):
                yield "mesh", file, entity.name
    for index in used_materials(entity)["visual"]:
        for texture in plan.visual_materials[index].textures().values():
            yield "texture", texture.file, entity.name


def _file_item(uri: str, path: Path, role: str, by: tuple[str, ...], names: tuple[str, ...]) -> Item:
    facts = [Fact("path", str(path), "")]
    read = _read(path)
    if read is None:
        facts += [Fact("bytes", None, "can no longer be read"), Fact("sha256", None, "")]
    else:
        size, digest = read
        facts += [Fact("bytes", size, _size(size)), Fact("sha256", digest, digest[:16])]
    facts += [
        Fact("named_by", list(by), "" if names else ", ".join(by)),
        Fact("used_by", list(names), some_words(names)),
    ]
    return Item(uri, role, tuple(facts))


def _read(path: Path) -> tuple[int, str] | None:
    """Returns size [bytes] and SHA-256 of a file, or None if it no longer exists."""
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


class InspectChoices(TypedDict, total=False):
    """What to describe of a scene.

    Attributes:
        scene: the scene to describe. None: all of them, with ranges of values.
        entity: the only entity to describe: a name, or a pattern of names (`*`, `?`, `[…]`).
        depth: maximum depth of the tree below the scene. None: unlimited.
        build: ask the engine for masses, and for sizes of meshes and articulations, in `scene` or else in the first
            scene of each entity. No render device is needed. Otherwise only values from the file are listed.
        progress: called with (finished scenes, all scenes) while the engine builds.
    """

    scene: int | None
    entity: str | None
    depth: int | None
    build: bool
    progress: Callable[[int, int], None] | None


class InspectArguments(InspectChoices, CompileOptions, total=False):
    """The arguments of `inspect_scene`."""


@frozen
class Inspection:
    """The result of `inspect_scene`.

    Attributes:
        item: the scene, as a tree.
        diagnostics: warnings and notes.
    """

    item: Item
    diagnostics: list[Diagnostic]


def inspect_source(source: Source, **given: Unpack[InspectArguments]) -> Inspection:
    """Describes a scene as a tree of facts.

    Args:
        source: as for `validate`.
        given: those of `InspectChoices` and of `CompileOptions`.

    Raises:
        SceneError: the scene is invalid, the engine or the machine cannot build it, or there is no such scene or
            entity.
        ValueError: an argument is out of range.
    """
    asked = Options.of_call(inspect_source, given, InspectArguments)
    scene, entity, depth = given.get("scene"), given.get("entity"), given.get("depth")
    sink = Sink()
    build = given.get("build", True)
    depth = None if depth is None else integer(depth, "depth", 0)
    done = compile_or_raise(source, asked, sink)
    plan = done.plan
    chosen = _select_entities(plan, scene, entity, sink)
    made = _measure_entities(plan, chosen, scene, sink, given.get("progress")) if build and chosen else {}
    if entity is not None:
        item = entities_item(chosen, plan, scene=scene, made=made)
    else:
        listed, files = list_result_params(done, asked.limits), _files(done)
        item = scene_item(plan, scene=scene, made=made, params=listed, given=asked.params, files=files)
    return Inspection(item if depth is None else item.cut(depth), sink.diagnostics())


def _select_entities(plan: ScenePlan, scene: int | None, entity: str | None, sink: Sink) -> list[Entity]:
    """Returns the entities to describe. Raises SceneError if the scene or the entity does not exist."""
    if scene is not None:
        select_scenes(str(integer(scene, "scene", 0)), plan.num_scenes, sink, "scene")
        if sink.failed:
            raise SceneError(sink.diagnostics())
    chosen = matching(plan, entity, scene)
    if entity is not None and not chosen:
        where = "" if scene is None else f" in scene {scene}"
        hint = suggest(entity, [one.name for one in matching(plan, None, scene)])
        message = f"no entity{where} is called `{cut(entity)}`"
        sink.report("SC910", message, Location(None), hint=hint, path=("entity",))
        raise SceneError(sink.diagnostics())
    return chosen


def _measure_entities(
    plan: ScenePlan,
    entities: list[Entity],
    scene: int | None,
    sink: Sink,
    progress: Callable[[int, int], None] | None,
) -> dict[str, Made]:
    """Builds and measures some entities, and returns them by name."""
    from scenecc.backends.sapien.measure import measure_bodies

    first = {one.name: one.scene_idxs[0] if scene is None else scene for one in entities}
    idxs = sorted({*first.values()})
    with build_batch(plan, sink, scene_idxs=idxs, render=False, audit=False, progress=progress) as batch:
        measured = measure_bodies(batch)
    return {
        one.entity.name: (at.index, one)
        for at in measured.scenes
        for one in at.entities
        if first.get(one.entity.name) == at.index
    }


def _files(done: CompileResult) -> tuple[Item, ...]:
    document = done.document
    top = (document.name, document.path) if document is not None and document.name and document.path else None
    return file_items(done.plan, top, done.scope.memory.named)
