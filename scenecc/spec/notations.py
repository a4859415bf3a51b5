"""Values in notations of other tools: numbers with units, colours as bytes, names and short texts."""

from __future__ import annotations

import re
from math import pi
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.messages import nearest
from scenecc.spec.key_hints import entry_at, numbers
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path

LONGEST_NAME: Final = 60
"""Longest text of which a name is made [characters]."""

BYTE: Final = 255

_LEAST_BYTE: Final = 5
"""A colour whose largest number is below this is not in bytes."""


def color_of(found: Any) -> str | list[float] | None:  # noqa: PLR0911 - a case each
    """Returns the colour here for one in another notation, or a CSS name; None if it is not known."""
    from PIL import ImageColor

    if isinstance(found, str) and len(found) <= LONGEST_NAME:
        word = _joined(found)
        is_hex = not word.isalpha()  # `bad` and `facade` are words
        if is_hex and (short := re.fullmatch(r"#?([0-9a-f])([0-9a-f])([0-9a-f])", word)):
            return "#" + "".join(2 * digit for digit in short.groups())
        if is_hex and (whole := re.fullmatch(r"(?:#|0x)?((?:[0-9a-f]{2}){3,4})", word)):
            return f"#{whole[1]}"
        if name := nearest(word, ImageColor.colormap, _ALIKE):
            return "#" + bytes(ImageColor.getrgb(name)[:3]).hex()
        listed = re.fullmatch(r"(?:rgba?)?[(\[]?([\d.,]+)[)\]]?", word)
        found = listed[1].split(",") if listed else []
    parts = numbers(found)
    if len(parts) not in {3, 4} or min(parts) < 0 or max(parts) > BYTE:
        return None
    if max(parts) <= 1:
        return parts
    if max(parts) < _LEAST_BYTE or any(one != int(one) for one in parts[:3]):
        return None  # brighter than white, not bytes
    alpha = [one if one > 1 else one * BYTE for one in parts[3:]]
    # Bytes are sRGB, as in a text; a list would be linear.
    return "#" + "".join(f"{round(one):02x}" for one in (*parts[:3], *alpha))


_ALIKE: Final = 0.85
"""Least similarity of names of colours. `light red` is not `lightgrey`."""


def is_named_otherwise(found: Any, color: Any) -> bool:
    """Returns whether a colour is that of a name similar to what was found, which may be meant or not."""
    from PIL import ImageColor

    is_word = isinstance(found, str) and _joined(found).isalpha() and isinstance(color, str)
    return is_word and _joined(found) not in ImageColor.colormap


def _joined(text: str) -> str:
    return text.strip().lower().replace(" ", "").replace("_", "")


_UNITS: Final = {
    unit: float(factor)
    for unit, factor in (
        pair.split("=")
        for pair in (
            "kg=1 kgs=1 g=1e-3 mg=1e-6 Mg=1e3 t=1e3 tonnes=1e3 tons=1e3 lb=0.45359237 lbs=0.45359237 pound=0.45359237 "
            "pounds=0.45359237 oz=0.0283495231 ounces=0.0283495231 kilograms=1 grams=1e-3 "
            "m=1 km=1e3 dm=0.1 cm=1e-2 cms=1e-2 mm=1e-3 mms=1e-3 um=1e-6 µm=1e-6 meter=1 meters=1 metre=1 metres=1 "
            "centimeters=1e-2 centimetres=1e-2 millimeters=1e-3 millimetres=1e-3 "
            "in=0.0254 inch=0.0254 inches=0.0254 ft=0.3048 foot=0.3048 feet=0.3048 yd=0.9144 "
            "km/h=0.277777777778 kph=0.277777777778 mph=0.44704 milliseconds=1e-3 minutes=60 "
            "px=1 pixels=1 s=1 sec=1 seconds=1 ms=1e-3 us=1e-6 µs=1e-6 min=60 %=1e-2 "
            "N=1 Nm=1 N*m=1 N·m=1 N/m=1 Nm/rad=1 N·m/rad=1 N*m/rad=1 "
            "N*s/m=1 N·s/m=1 m/s=1 cm/s=1e-2 mm/s=1e-3 rad/s=1 m/s2=1 m/s^2=1 m/s²=1 "
            "kg/m3=1 kg/m^3=1 kg/m³=1 g/cm3=1e3 g/cm^3=1e3 g/cm³=1e3 g/cc=1e3 kg/l=1e3 kg*m2=1 kg*m^2=1 kg·m²=1 "
            f"rad=1 radians=1 rpm={pi / 30} "
            + " ".join(f"{unit}={pi / 180}" for unit in ("deg", "degs", "degree", "degrees", "°", "deg/s", "°/s"))
        ).split()
    )
}
"""Unit after a number → factor to SI."""

SI: Final = "masses are in kg, lengths in m, times in s, angles in rad"

_QUANTITY: Final = re.compile(
    r"\s*([-+]?(?:\d{1,12}[.,]?\d{0,12}|\.\d{1,12})(?:[eE][-+]?\d{1,2})?)\s*([^\s\d.].{0,11}?)\s*"
)


THOUSANDS: Final = r"([-+]?[1-9]\d{0,2}),(\d{3})"
"""A number with a comma that may separate thousands or decimals."""

_LENGTHS: Final = (
    "m km dm cm cms mm mms um µm meter meters metre metres centimeters centimetres millimeters millimetres "
    "in inch inches ft foot feet yd % "
)
_MASSES: Final = "kg kgs g t tonnes tons lb lbs pound pounds oz ounces kilograms grams mg "
_TIMES: Final = "s sec seconds ms us µs milliseconds min minutes "
_ANGLES: Final = "rad radians deg degs degree degrees ° "
_SPEEDS: Final = "m/s cm/s mm/s km/h kph mph "
_RATES: Final = "rad/s deg/s °/s rpm "
_INERTIAS: Final = "kg*m2 kg*m^2 kg·m² "

_IN_METRES: Final = (
    "apart at center com contact_offset deeper_than facing far gap half_height half_length half_size half_width "
    "height inner_radius look_at min_patch_radius near origin outer_radius p patch_radius pose pose_in_child "
    "pose_in_parent position radius region rest_offset scene_spacing shadow_far shadow_near shadow_scale size "
    "spacing top within x y z"
)

_QUANTITIES: Final = (
    ("mass", _MASSES, "a mass in kg"),
    ("density", "kg/m3 kg/m^3 kg/m³ g/cm3 g/cm^3 g/cm³ g/cc kg/l", "a density in kg/m³"),
    ("timestep", f"{_TIMES} hz fps", "a time in s"),
    ("after seconds", _TIMES, "a time in s"),
    ("cx cy fx fy height shadow_map_size skew width", "px pixels %", "a number of pixels"),
    (_IN_METRES, _LENGTHS, "a length in m"),
    ("angle fovx fovy inner_fov outer_fov rpy twist yaw", _ANGLES, "an angle in rad"),
    ("angle_deg fovx_deg fovy_deg limits_deg rpy_deg within_deg yaw_deg", _ANGLES, "an angle in degrees"),
    ("limits offset qpos target", _LENGTHS + _ANGLES, "a length in m or an angle in rad"),
    ("bounce_threshold linear linear_velocity max_depenetration_velocity max_linear_velocity", _SPEEDS, "it in m/s"),
    ("angular angular_velocity max_angular_velocity", _RATES, "it in rad/s"),
    ("max_velocity qvel velocity_target", _SPEEDS + _RATES, "it in m/s or rad/s"),
    ("force_limit friction_force", "N Nm N*m N·m", "it in N or N·m"),
    ("stiffness", "N/m Nm/rad N·m/rad N*m/rad", "it in N/m or N·m/rad"),
    ("damping", "N*s/m N·s/m", "it in N·s/m or N·m·s/rad"),
    ("linear_damping angular_damping", "%", "it in 1/s"),
    ("armature", _MASSES + _INERTIAS, "it in kg or kg·m²"),
    ("inertia", _INERTIAS, "it in kg·m²"),
    ("gravity", "m/s2 m/s^2 m/s²", "it in m/s²"),
    ("sleep_threshold", "", "it in m²/s²"),
    ("max_contact_impulse", "", "it in N·s"),
)
"""Keys, the units that are converted to theirs, and what it is."""

_OF_KEY: Final = {key: row[1:] for row in reversed(_QUANTITIES) for key in row[0].split()}


def _doubt(path: Path, number: str, unit: str) -> str | None:
    """Returns a hint for a number with two readings, or a unit that the key does not take; else None."""
    if re.fullmatch(THOUSANDS, number):
        return f"write the number without commas, or with a decimal point: {SI}"
    # The name of an entity or a camera is no key, unless it is all there is.
    keys = [key for key in reversed(path) if isinstance(key, str)]
    own = next((_OF_KEY[key] for key in keys[:1] + keys[1:-2] if key in _OF_KEY), None)
    if own is None and (len(path) == 1 or path[0] in {"draws", "params", *FORM_KEYS}):
        return None  # a user's own quantity
    units, quantity = own or ("%", "only the number")
    if keys[:1] == ["height"] and path[:1] != ("cameras",):
        units, quantity = _LENGTHS, "a length in m"
    return None if unit.lower() in units.lower().split() else f"write {quantity}"


def unit_hint(path: Path, text: str) -> str | None:
    """Returns a hint for a number with a unit, or None."""
    found = _QUANTITY.fullmatch(text)
    if found is None:
        return None
    number, unit = float(found[1].replace(",", ".")), found[2]
    is_rate = unit in {"Hz", "hz", "fps"} and number > 0
    factor = _UNITS.get(unit, _UNITS.get(unit.lower()))
    if factor is None and not is_rate:
        return None
    if doubt := _doubt(path, found[1], unit):
        return doubt
    if factor is None:
        return f"write {entry_at(path, 1 / number)}: a time step is one divided by the frequency [s]"
    takes_degrees = any(str(key).endswith("_deg") for key in path)
    if takes_degrees and unit[:1] in {"d", "r", "°"}:
        return f"write {entry_at(path, number * factor * 180 / pi)}: this key is in degrees"
    return f"write {entry_at(path, number * factor)}: {SI}"
