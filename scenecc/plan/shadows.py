"""What SAPIEN's `Scene.add_*_light` gives a light of whose shadow nothing is said."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.plan.light import AreaLight, DirectionalLight, Light
from scenecc.plan.value import literal

if TYPE_CHECKING:
    from scenecc.plan.value import Value


def shadow_numbers(light: Light) -> dict[str, Value]:
    """How a light throws shadows, by the names of its component's attributes, in SAPIEN's order; {} of an area light.

    Distances are [m], the size of the map [px].
    """
    if isinstance(light.light, AreaLight):
        return {}
    parallel, given = isinstance(light.light, DirectionalLight), light.shadow
    left_out = {
        "shadow": literal(0, "bool"),
        "shadow_near": literal(-10.0 if parallel else 0.1),
        "shadow_far": literal(10.0),
        **({"shadow_half_size": literal(10.0)} if parallel else {}),
        "shadow_map_size": literal(2048, "int64"),
    }
    if given is None:
        return left_out
    said = {
        "shadow": given.on,
        "shadow_near": given.near,
        "shadow_far": given.far,
        "shadow_half_size": given.half_size,
        "shadow_map_size": given.map_size,
    }
    return {name: said[name] or otherwise for name, otherwise in left_out.items()}
