"""Expectations about the scenes: the keys of `expect`. Imported on first use."""

from typing import Annotated, Any

from pydantic import Field, ModelWrapValidatorHandler, Strict, ValidationError, model_validator
from typing_extensions import Self

from scenecc.plan.expect import MAX_SECONDS
from scenecc.spec.base import AnyText, EntityName, ErrorCollector, Maybe, NonNegative, SpecModel, key
from scenecc.spec.body import SceneIdxs
from scenecc.spec.nodes import EXPANDED
from scenecc.spec.values import Fixed, VaryingAnnotation

Seconds = Annotated[float, Field(ge=0, le=MAX_SECONDS)]

Pair = Annotated[tuple[Fixed[EntityName], Fixed[EntityName]], Strict(strict=False)]

Test = Annotated[bool, VaryingAnnotation("a condition is an expression, `${…}`")]


class SettledSpec(SpecModel):
    """Dynamic bodies and free articulations stay where they start."""

    seconds: Fixed[Seconds] = Field(default=1.0, description="Duration of the simulation [s].")
    within: Fixed[NonNegative] = Field(default=0.005, description="Maximum distance from the start [m].")
    within_deg: Fixed[NonNegative] = Field(default=2.0, description="Maximum rotation from the start [degrees].")
    except_: list[Fixed[EntityName]] = Field(
        default_factory=list[str], alias="except", description="Entities that may move.", examples=[["ball"]]
    )


class NoOverlapSpec(SpecModel):
    """How deep bodies may overlap at the start, and which pairs may always overlap."""

    deeper_than: Maybe[Fixed[NonNegative]] = key("How deep bodies may overlap at the start [m].", default=0.0005)
    except_: list[Pair] = Field(
        default_factory=list[tuple[str, str]],
        alias="except",
        description="Pairs that may overlap: ENTITY (all its links) or ENTITY/LINK.",
        examples=[[["peg", "hole"]]],
    )


class ConditionSpec(SpecModel):
    """A condition at a time of the simulation."""

    after: Fixed[Seconds] = Field(default=0.0, description="Time of the test [s]; 0: at the start.")
    that: Test = Field(
        description="An expression that must be true. It may read `position(name)`, `speed(name)`, `tilt(name)`, "
        "`distance(a, b)`, `touching(a, b)` and `qpos(name, joint)`.",
        examples=["${position('cube')[2] > 0.01}"],
    )
    because: Fixed[AnyText] = Field(default="", description="Explanation for the message if it does not hold.")
    scene_idxs: Maybe[SceneIdxs] = key("The scenes in which it must hold; default: all.", examples=["::2"])


class ExpectSpec(SpecModel):
    """What must hold in the scenes; `scenecc check` tests it."""

    settled: Maybe[SettledSpec] = key("Bodies that stay where they start.")
    no_overlap: Maybe[NoOverlapSpec] = key("Overlaps at the start that are allowed.")
    holds: list[ConditionSpec] = Field(default_factory=list[ConditionSpec], description="Conditions, each at its time.")

    @model_validator(mode="wrap")
    @classmethod
    def _validate_parts(cls, node: Any, validate: ModelWrapValidatorHandler[Self]) -> Any:
        """In an expanded document, validates the expectations of each file and instance separately, by name."""
        if not EXPANDED.get():
            return validate(node)
        mistakes, made = ErrorCollector(), dict[str, ExpectSpec]()
        for name, item in node.items():
            try:
                made[name] = validate(item)
            except ValidationError as problem:  # noqa: PERF203 - there are few
                mistakes.take(problem, name)
        mistakes.stop()
        return made
