"""What surrounds the scenes."""

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, Tag

from scenecc.spec.base import Maybe, Model, Text, key
from scenecc.spec.later import Later
from scenecc.spec.leaf import Leaf
from scenecc.spec.light_types import LightColor
from scenecc.spec.unions import MAPPING, WORD, by_kind


class CubeMap(Model):
    """Six pictures around the scene, each seen along one of the axes."""

    px: Leaf[Text] = Field(description="Picture towards +x.")
    nx: Leaf[Text] = Field(description="Picture towards -x.")
    py: Leaf[Text] = Field(description="Picture towards +y.")
    ny: Leaf[Text] = Field(description="Picture towards -y.")
    pz: Leaf[Text] = Field(description="Picture towards +z.")
    nz: Leaf[Text] = Field(description="Picture towards -z.")


if TYPE_CHECKING:
    _Faces = CubeMap
else:
    _Faces = Annotated[Any, Later("scenecc.spec.environment", "CubeMap")]

EnvironmentMap = Leaf[
    Annotated[
        Annotated[Text, Tag(WORD)] | Annotated[_Faces, Tag(MAPPING)],
        by_kind("a file, or a mapping with px, nx, py, ny, pz, nz"),
    ]
]
"""A file, or six."""


class Environment(Model):
    """Light from everywhere, and what is seen where there is nothing."""

    ambient_light: Maybe[LightColor] = key('Linear RGB, which may exceed 1, or "#rrggbb".', default=[0, 0, 0])
    map: Maybe[EnvironmentMap] = key("The surroundings: a file, or six pictures.")
