"""Links of drafts to links of the plan: their bodies, with all that is said of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.lower.articulations.draft import Touch
from scenecc.lower.articulations.maps import said
from scenecc.lower.bodies import INERTIA, KNOBS
from scenecc.lower.groups import find_group
from scenecc.lower.kinds import number
from scenecc.lower.materials import DENSITY, PLAIN
from scenecc.lower.placing.shape_poses import local_pose
from scenecc.lower.shapes import Defaults
from scenecc.plan import BodyStructure, Inertial, Value, literal, varying

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.lower.articulations.draft import DraftLink, Layer
    from scenecc.lower.articulations.said import Said
    from scenecc.lower.groups import Bits

_KNOBS = (
    "gravity",
    "linear_damping",
    "angular_damping",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
)
_MASS = KNOBS["mass"][1]
_RADIUS = number("patch_radius")
DEFAULT_BITS: Bits = (1, 1, 0, 0)


class Links:
    """Makes the bodies of links.

    Args:
        groups: the bits of the collision groups of the document.
        sink: takes the diagnostics.
    """

    def __init__(self, groups: dict[str, Bits], sink: Sink) -> None:
        self._groups = groups
        self._sink = sink

    def body(self, link: DraftLink, layers: Sequence[Layer], own: int, ignored: int, values: Said) -> BodyStructure:
        """The body of a link.

        Args:
            link: of it.
            layers: what is said of the whole, what patterns say of the link, and what it says itself.
            own: the id of the articulation among those whose links ignore one another.
            ignored: bits of the third collision integer that the link has whatever its file says.
            values: of the articulation.
        """
        touch = Touch(
            Defaults(values.surface(layers) or PLAIN, None, values.value(layers, "density", DENSITY)),
            values.value(layers, "patch_radius", _RADIUS),
            values.value(layers, "min_patch_radius", _RADIUS),
        )
        collisions, visuals = link.shaping(touch)
        knobs: dict[str, Value] = {}
        for key in _KNOBS:
            field, kind = KNOBS[key]
            found = values.value(layers, key, kind)
            if found is not None:
                knobs[field] = found
        # What a link says itself, and does nothing on it, is left in for a rule to report.
        looks, groups = said(layers, "visibility"), said(layers, "collision_bits", "collision_group")
        if looks is not None and (visuals or looks is link.own):
            knobs["visibility"] = values.of(looks, "visibility", KNOBS["visibility"][1])
        bits = self._bits(link, layers, own, ignored, values)
        if bits is not None and (collisions or (groups is not None and groups is link.own)):
            knobs["collision_groups"] = bits
        mass, inertial = self._weight(link, layers, values, dense=bool(collisions))
        return BodyStructure(
            body_type="link",
            collisions=collisions,
            visuals=visuals,
            mass=mass,
            inertial=inertial,
            origin=link.origin,
            **knobs,
        )

    def _bits(self, link: DraftLink, layers: Sequence[Layer], own: int, ignored: int, values: Said) -> Value | None:
        """The four integers; None where they are SAPIEN's own."""
        layer = said(layers, "collision_bits", "collision_group")
        bits: Bits = DEFAULT_BITS
        if layer is not None:
            keys, origin = layer
            group, written = keys.collision_group, getattr(keys, "collision_bits", None)
            if group is not None and written is not None:
                self._exclude("collision_group", "collision_bits", layer)
            if written is not None:
                return values.of(layer, "collision_bits", KNOBS["collision_bits"][1])
            found = find_group(
                self._groups, str(group), origin.child("collision_group"), values.leaves.scope, self._sink
            )
            bits = found or DEFAULT_BITS
        third = bits[2] | link.ignore_bits | ignored
        bits = (bits[0], bits[1], third, own if third else bits[3])
        return None if layer is None and bits == DEFAULT_BITS else literal(bits, "int64")

    def _weight(
        self, link: DraftLink, layers: Sequence[Layer], values: Said, *, dense: bool
    ) -> tuple[Value | None, Inertial | None]:
        """The mass that scales, and the mass properties that are given. `dense`: whether shapes give it any."""
        nearest = said(layers, "mass", "inertial")
        if nearest is None:
            return None, link.inertial
        keys = nearest[0]
        if keys.mass is not None and keys.inertial is not None:
            self._exclude("mass", "inertial", nearest)
        if keys.inertial is not None:
            given = self._given(nearest, values)
            if nearest is not link.own:
                self._is_real(given, link, nearest)
            return None, given
        mass = values.of(nearest, "mass", _MASS)
        if not dense and link.inertial is None:
            message = (
                f"`{cut(link.name)}` has no colliding shape and no inertia, so there is nothing that `mass` could scale"
            )
            hint = "give it `shapes` or `collisions`, or `inertial` in place of `mass`"
            self._sink.report("SC510", message, nearest[1].child("mass"), hint=hint)
        return (mass, None) if link.inertial is None else (None, _scaled(link.inertial, mass, values))

    @staticmethod
    def _given(layer: Layer, values: Said) -> Inertial:
        keys, origin = layer
        place, leaves, given = origin.child("inertial"), values.leaves, keys.inertial
        return Inertial(
            leaves.value(given.mass, _MASS, place, "mass"),
            local_pose(given.com, origin, ("inertial", "com"), "a centre of mass", leaves),
            leaves.value(given.inertia, INERTIA, place, "inertia"),
        )

    def _is_real(self, inertial: Inertial, link: DraftLink, layer: Layer) -> None:
        """Told where a pattern says it; what a link says itself is another rule's."""
        moments = inertial.inertia.numbers() if inertial.inertia.is_constant else ()
        if moments and 2 * max(moments) > sum(moments) * (1 + 1e-9):
            self._sink.report(
                "SC506",
                f"no body has the inertia of `{cut(link.name)}`: one moment is above the sum of the others",
                layer[1].child("inertial", "inertia"),
                hint="each of ixx, iyy, izz is at most the sum of the other two",
            )

    def _exclude(self, first: str, second: str, layer: Layer) -> None:
        origin = layer[1]
        self._sink.report(
            "SC111",
            f"`{first}` and `{second}` exclude each other",
            origin.child(second),
            at="key",
            related=[("the first", origin.child(first), "key")],
        )


def _scaled(inertial: Inertial, mass: Value, values: Said) -> Inertial:
    """What a file says of a link's mass, for another mass: I · (m / m0), the centre of mass unchanged."""
    (before,) = inertial.mass.numbers()
    moments = inertial.inertia.numbers()
    if mass.is_constant:
        (after,) = mass.numbers()
        return Inertial(mass, inertial.com, literal(tuple(one * (after / before) for one in moments)))
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.bounds import UNKNOWN, ValueBounds  # noqa: PLC0415 - likewise

    support, found = UNKNOWN, mass.bounds
    # Of some expressions nothing is known until they are drawn.
    if isinstance(found.low, int | float) and isinstance(found.high, int | float):
        low, high = (tuple(one * (end / before) for one in moments) for end in (found.low, found.high))
        support = ValueBounds(None, low, high, exact=False)
    rows = len(values.leaves.scenes)

    def draw() -> NDArray[Any]:
        # A mass has one row where it is equal in all scenes.
        return np.broadcast_to(np.array(moments) * (mass.data[:, None] / before), (rows, len(moments)))

    return Inertial(mass, inertial.com, varying(draw, bounds=support, rows=rows))
