"""Instances of prefabs, repeated bodies and variants. Imported on first use."""

from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints, Tag

from scenecc.spec.base import (
    MAPPING_KEY,
    PREFIX_PATTERN,
    Maybe,
    NameRole,
    NonNegativeInt32,
    Reference,
    SceneName,
    key,
    names_key,
)
from scenecc.spec.body import BodyKeys, BodySpec, EntityKeys
from scenecc.spec.nodes import MAPPING, WORD, union_by_kind
from scenecc.spec.repetition import RepeatKeys, Variable
from scenecc.spec.values import Fixed, Leaf

Prefix = Annotated[str, StringConstraints(pattern=PREFIX_PATTERN)]

Override = Fixed[
    Annotated[
        Annotated[dict[str, Any], Tag(MAPPING)] | Annotated[Literal["remove"], Tag(WORD)],
        union_by_kind("a mapping of keys, or `remove`"),
    ]
]
"""Part of an object. It is validated after merging."""


class Instance(EntityKeys, RepeatKeys):
    """A scene file used as a part of this one."""

    use: Fixed[SceneName] = Field(
        description="The prefab: a path from this file's folder, pkg://PACKAGE/PATH, asset://PATH or scenecc:NAME.",
        examples=["prefabs/leg.yaml", "scenecc:table"],
    )
    with_: dict[Annotated[Variable, NameRole("argument")], Any] = names_key(
        "Its parameters; values may differ from scene to scene.", alias="with"
    )
    prefix: Maybe[Fixed[Prefix]] = key(
        'Prefix of the names inside; default: the instance\'s name and "/".', examples=[""]
    )
    override: dict[Annotated[Reference, MAPPING_KEY, NameRole("member")], Override] = names_key(
        "Object inside, by its name in the prefab (`lights/NAME`, `cameras/`, `constraints/`, `frames/`, "
        "`materials/` too) → keys that are merged into it, or `remove`.",
        examples=[{"cube": {"color": "#f0f0f0"}, "goal": "remove"}],
    )


class RepeatedBody(BodySpec, RepeatKeys):
    """A rigid body, which may have `repeat` or `if`."""


class Variant(BodyKeys):
    """One structure. Its shapes come after those that are common to all."""


class Variants(EntityKeys, BodyKeys, RepeatKeys):
    """A body with one of several structures in each scene. Keys beside `variants` apply to all."""

    variants: Annotated[list[Variant], Field(min_length=1)] = Field(description="The structures.")
    pick: Leaf[NonNegativeInt32] = Field(
        description="The index of the scene's structure; a form over indices.", examples=[{"cycle": [0, 1]}]
    )
