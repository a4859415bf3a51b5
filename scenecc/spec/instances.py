"""Instances of prefabs, repeated bodies and variants. Imported when a document has one."""

from typing import Annotated, Any

from pydantic import Field, StringConstraints

from scenecc.spec.base import PREFIX_PATTERN, Maybe, NonNegativeInt32, Text, key
from scenecc.spec.body import BodyKeys, BodySpec, EntityKeys
from scenecc.spec.repetition import RepeatKeys, Variable
from scenecc.spec.values import Fixed, Leaf

Prefix = Annotated[str, StringConstraints(pattern=PREFIX_PATTERN)]


def _empty_dict() -> dict[str, Any]:
    return {}


class Instance(EntityKeys, RepeatKeys):
    """A scene file used as a part of this one."""

    use: Fixed[Text] = Field(
        description="The prefab: a path from this file's folder, pkg://PACKAGE/PATH, asset://PATH or scenecc:NAME.",
        examples=["prefabs/leg.yaml", "scenecc:table"],
    )
    with_: dict[Variable, Any] = Field(
        default_factory=_empty_dict, alias="with", description="Its parameters; values may differ from scene to scene."
    )
    prefix: Maybe[Fixed[Prefix]] = key(
        'Before the names inside; left out: the instance\'s name and "/".', examples=[""]
    )


class RepeatedBody(BodySpec, RepeatKeys):
    """One rigid body a scene, repeated or on a condition."""


class Variant(BodyKeys):
    """One structure. Its shapes come after those that are common to all."""


class Variants(EntityKeys, BodyKeys, RepeatKeys):
    """One body a scene, of one of several structures. What stands beside `variants` is common to all."""

    variants: Annotated[list[Variant], Field(min_length=1)] = Field(description="The structures.")
    pick: Leaf[NonNegativeInt32] = Field(
        description="The index of the scene's structure; a form over indices.", examples=[{"cycle": [0, 1]}]
    )
