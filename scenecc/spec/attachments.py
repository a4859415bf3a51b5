"""Parts that are attached to an articulation. Imported on first use."""

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, ValidationError
from pydantic_core import PydanticCustomError, core_schema

from scenecc.spec.articulation import JointNumbers, JointPatterns, MjcfKeys, TreeJoint, TreeKeys, UrdfKeys
from scenecc.spec.base import MAPPING_KEY, ErrorCollector, LinkName, Maybe, Name, custom_error, key, list_key, names_key
from scenecc.spec.instances import Prefix
from scenecc.spec.nodes import PART_LABELS, WRONG_KIND, LazyType, ModelChoice, is_mapping
from scenecc.spec.pose import Pose
from scenecc.spec.values import Fixed

if TYPE_CHECKING:
    from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

PART_TYPES = {
    PART_LABELS["urdf"]: LazyType("scenecc.spec.attachments", "UrdfPart"),
    PART_LABELS["mjcf"]: LazyType("scenecc.spec.attachments", "MjcfPart"),
    PART_LABELS["root"]: LazyType("scenecc.spec.attachments", "TreePart"),
}
"""Label of a part → its model."""


class PartAnnotation(ModelChoice):
    """Annotation of a part, whose keys determine its model."""

    def __init__(self, *, nested: bool = False) -> None:
        self._nested = nested

    def choose(self, node: Any) -> "type[BaseModel] | None":
        """Returns the model of a part; that of a URDF if its file is not written yet."""
        label = next((label for key, label in PART_LABELS.items() if key in node), PART_LABELS["urdf"])
        return PART_TYPES[label].type

    def __get_pydantic_core_schema__(self, source: Any, handler: "GetCoreSchemaHandler") -> "CoreSchema":
        return core_schema.no_info_plain_validator_function(_read_part)

    def __get_pydantic_json_schema__(self, schema: "CoreSchema", handler: "GetJsonSchemaHandler") -> "JsonSchemaValue":
        found: JsonSchemaValue = {"required": ["urdf"]}
        for form, label in reversed(PART_LABELS.items()):
            later = PART_TYPES[label]
            # A part may contain parts, whose schema is the definition being generated.
            then = {"x-ref": later.type.__name__} if self._nested else later.json_schema(handler)
            found = {"if": {"required": [form]}, "then": then, "else": found}
        return found


def _read_part(node: Any) -> Any:
    if not is_mapping(node):
        raise PydanticCustomError(WRONG_KIND, "{expected}", {"expected": "a mapping with `to` and a file or a `root`"})
    label = next((label for key, label in PART_LABELS.items() if key in node), None)
    if label is None:
        raise custom_error("SC102", "{this} lacks the key `urdf`, `mjcf` or `root`", at="key")
    mistakes = ErrorCollector()
    made: Any = None
    try:
        made = PART_TYPES[label].validate(node)
    except ValidationError as problem:
        mistakes.take(problem, label)
    mistakes.stop()
    return made


Part = Annotated[Any, PartAnnotation()]
"""A part that is attached to an articulation."""


class PartKeys(JointPatterns):
    """Keys of any part. Links and joints have the part's own names in it."""

    to: Fixed[LinkName] = Field(
        description="Link that it is attached to, of the articulation or of an earlier part (`gripper/palm`)."
    )
    pose: Maybe[Pose] = key("Pose of its root in the frame of `to`; a fixed joint holds it there.", default=[0, 0, 0])
    joint: Maybe[TreeJoint] = key("The joint between `to` and its root, instead of `pose`.", excludes=("pose",))
    prefix: Maybe[Fixed[Prefix]] = key(
        'Prefix of the names of its links and joints; default: the name of the part and "/".', examples=[""]
    )
    ignore: list[Fixed[LinkName]] = list_key("Links of the articulation that never collide with it.")
    qpos: Maybe[JointNumbers] = key(
        "Initial positions of its joints [m or rad]; the `qpos` of the articulation overrides them."
    )
    fix_root_link: Maybe[Fixed[bool]] = key("Not used: its root is attached to `to`.")
    attach: dict[Annotated[Name, MAPPING_KEY], Annotated[Any, PartAnnotation(nested=True)]] = names_key(
        "Parts that are attached to it."
    )


class UrdfPart(PartKeys, UrdfKeys):
    """A part that a URDF describes."""


class MjcfPart(PartKeys, MjcfKeys):
    """A part that an MJCF describes."""


class TreePart(PartKeys, TreeKeys):
    """A part written as a tree of links."""
