"""Everything that is said of a scene, as one tree."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, Final

from scenecc.plan import SkyMap
from scenecc.plan.fields import type_name
from scenecc.summary.bodies import entity_item, scene_facts, used_materials
from scenecc.summary.facts import Facts, fact, mount_words
from scenecc.summary.item import Fact, Item, some_words
from scenecc.summary.rows import summarize

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from scenecc.expand.listing import ParamRow
    from scenecc.plan import Camera, Constraint, Entity, Light, ScenePlan
    from scenecc.summary.bodies import Made
    from scenecc.summary.fields import VaryingField

_DEFAULTS: Final = (Fact("defaults", value=True, words="all of them SAPIEN's defaults"),)


def scene_item(
    plan: ScenePlan,
    *,
    scene: int | None,
    made: Mapping[str, Made],
    params: Sequence[ParamRow] = (),
    given: Mapping[str, Any] | None = None,
    files: tuple[Item, ...] = (),
) -> Item:
    """All that is said of a scene.

    Args:
        plan: of it.
        scene: the one that is told; None: what all of them can be.
        made: entities as the engine has them, by name; none where it was not asked.
        params: of the scene file.
        given: the values that these were given.
        files: of `scenecc.summary.used_files`.
    """
    facts = [fact("num_scenes", plan.num_scenes), fact("seed", plan.seed)]
    if scene is not None:
        facts.append(fact("scene", scene))
    if plan.description:
        facts.append(Fact("description", plan.description, plan.description.partition("\n")[0]))
    groups: list[tuple[str, Item | tuple[Item, ...]]] = [
        ("physics", Item("", "", tuple(Facts(plan, 0).of(plan.physics)) or _DEFAULTS)),
        ("parameters", tuple(_param(row, given or {}) for row in params)),
        ("entities", tuple(entity_item(one, plan, scene, made.get(one.name)) for one in _in(plan.entities, scene))),
        ("constraints", tuple(_constraint(one, plan, scene) for one in _in(plan.constraints, scene))),
        ("lights", tuple(_light(one, plan, scene) for one in _in(plan.lights, scene))),
        ("cameras", tuple(_camera(one, plan, scene) for one in _in(plan.cameras, scene))),
    ]
    if plan.environment is not None:
        facts_of = Facts(plan, scene)
        around = (*facts_of.of(plan.environment, without=("map",)), *facts_of.of(plan.environment.map, "map"))
        groups.append(("environment", Item("", _map_word(plan), around)))
    groups += [("materials", _materials(plan, scene)), ("variation", _variation(plan, scene)), ("files", files)]
    return Item(plan.name, "scene", tuple(facts), tuple(group for group in groups if group[1]))


def entities_item(entities: Iterable[Entity], plan: ScenePlan, *, scene: int | None, made: Mapping[str, Made]) -> Item:
    """What is said of some entities; other arguments are those of `scene_item`."""
    items = tuple(entity_item(one, plan, scene, made.get(one.name)) for one in entities)
    facts = (fact("num_scenes", plan.num_scenes), *([] if scene is None else [fact("scene", scene)]))
    return Item(plan.name, "scene", facts, (("entities", items),))


def matching(plan: ScenePlan, pattern: str | None, scene: int | None) -> list[Entity]:
    """The entities of a scene, or of all, whose names a pattern (`*`, `?`, `[…]`) matches; None matches every one."""
    entities = _in(plan.entities, scene)
    return [one for one in entities if pattern is None or one.name == pattern or fnmatchcase(one.name, pattern)]


def _in(listed: Iterable[Any], scene: int | None) -> list[Any]:
    return [one for one in listed if scene is None or scene in one.scene_idxs]


def _row(one: Constraint | Light | Camera, scene: int | None) -> int | None:
    return None if scene is None else one.scene_idxs.index(scene)


def _constraint(one: Constraint, plan: ScenePlan, scene: int | None) -> Item:
    facts = Facts(plan, _row(one, scene))
    parent = mount_words(one.parent)
    told = (
        *scene_facts(one.scene_idxs, plan),
        Fact("parent", parent, parent),
        *facts.of(one, without=("name", "scene_idxs", "parent", "joint")),
        *facts.of(one.joint),
    )
    return Item(one.name, type_name(type(one.joint)), told)


def _light(one: Light, plan: ScenePlan, scene: int | None) -> Item:
    facts = Facts(plan, _row(one, scene))
    told = (
        *scene_facts(one.scene_idxs, plan),
        *facts.of(one, without=("name", "scene_idxs", "light")),
        *facts.of(one.light),
    )
    return Item(one.name, type_name(type(one.light)), told)


def _camera(one: Camera, plan: ScenePlan, scene: int | None) -> Item:
    facts = Facts(plan, _row(one, scene))
    told = (
        *scene_facts(one.scene_idxs, plan),
        fact("size", [one.width, one.height], "px"),
        *facts.of(one, without=("name", "scene_idxs", "width", "height", "lens")),
        *facts.of(one.lens),
    )
    return Item(one.name, type_name(type(one.lens)), told)


def _map_word(plan: ScenePlan) -> str:
    around = plan.environment and plan.environment.map
    return "" if around is None else "sky map" if isinstance(around, SkyMap) else "cube map"


def _param(row: ParamRow, given: Mapping[str, Any]) -> Item:
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
    """The tables of materials: shapes name them by number."""
    users: dict[tuple[str, int], list[Entity]] = {}
    for entity in _in(plan.entities, scene):
        for kind, numbers in used_materials(entity).items():
            for number in numbers:
                users.setdefault((kind, number), []).append(entity)
    items: list[Item] = []
    for kind, table in (("physical", plan.physical_materials), ("visual", plan.visual_materials)):
        for number, material in enumerate(table):
            having = users.get((kind, number), [])
            if scene is not None and not having:
                continue
            # Rows of a material follow the scenes of those that have it.
            row = None if scene is None else having[0].scene_idxs.index(scene)
            names = tuple(entity.name for entity in having)
            used = Fact("used_by", list(names), some_words(names))
            items.append(Item("", kind, (fact("number", number), *Facts(plan, row).of(material), used)))
    return tuple(items)


def _variation(plan: ScenePlan, scene: int | None) -> tuple[Item, ...]:
    """What scenes differ in, object by object, as a dry run tells it."""
    rows = summarize(plan, None, None if scene is None else (scene,))
    return tuple(Item(row.name, "", tuple(map(_differing, row.varying))) for row in rows if row.varying)


def _differing(field: VaryingField) -> Fact:
    words = f"{field.values} at reset" if field.at_reset else field.values
    return Fact(field.field, {"values": field.values, "at_reset": field.at_reset}, words)
