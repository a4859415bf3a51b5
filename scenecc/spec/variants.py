"""One logical entity whose structure differs from scene to scene."""

from typing import Annotated

from pydantic import Field

from scenecc.spec.body import BodyKeys, EntityKeys
from scenecc.spec.copies import Copies
from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import CountOrNone


class Variant(BodyKeys):
    """One structure. Its shapes come after those that are common to all."""


class Variants(EntityKeys, BodyKeys, Copies):
    """One body a scene, of one of several structures. What stands beside `variants` is common to all."""

    variants: Annotated[list[Variant], Field(min_length=1)] = Field(description="The structures.")
    pick: Leaf[CountOrNone] = Field(
        description="The index of the scene's structure; a form over indices.", examples=[{"cycle": [0, 1]}]
    )
