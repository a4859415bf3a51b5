"""Entities that expansion makes others of: instances of prefabs, and bodies with copies."""

from typing import Annotated, Any

from pydantic import Field, StringConstraints

from scenecc.spec.base import PREFIX_PATTERN, Maybe, Text, key
from scenecc.spec.body import Body, EntityKeys
from scenecc.spec.copies import Copies, Variable
from scenecc.spec.leaf import Fixed

Prefix = Annotated[str, StringConstraints(pattern=PREFIX_PATTERN)]


def _none() -> dict[str, Any]:
    return {}


class Instance(EntityKeys, Copies):
    """A scene file used as a part of this one."""

    use: Fixed[Text] = Field(
        description="The prefab: a path from this file's folder, pkg://PACKAGE/PATH, asset://PATH or scenecc:NAME.",
        examples=["prefabs/leg.yaml", "scenecc:table"],
    )
    with_: dict[Variable, Any] = Field(
        default_factory=_none, alias="with", description="Its parameters; values may differ from scene to scene."
    )
    prefix: Maybe[Fixed[Prefix]] = key(
        'Before the names inside; left out: the instance\'s name and "/".', examples=[""]
    )


class BodyCopies(Body, Copies):
    """One rigid body a scene, repeated or on a condition."""
