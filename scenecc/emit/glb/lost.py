"""What of a plan no GLB can hold: a warning each. That physics is not in it is in the nature of the target."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.diagnostics import Location

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet

    from scenecc.diagnostics import Origin, Sink
    from scenecc.meshes import Image, Look
    from scenecc.plan import ScenePlan

_SECTIONS: Final = {"lights": "light", "cameras": "camera"}


def tell_lost(plan: ScenePlan, scenes: AbstractSet[int], sink: Sink) -> None:
    """Warns of lights, cameras and surroundings of the scenes that are written."""
    for section, word in _SECTIONS.items():
        for item in getattr(plan, section):
            if scenes & set(item.scene_idxs):
                sink.report("SC745", f"the {word} `{item.name}` is left out", item.origin or Location(None))
    around = plan.environment
    if around is not None:
        sink.report("SC745", "`environment` is left out", around.origin or Location(None))


def tell_lost_look(look: Look, origin: Origin | None, sink: Sink) -> None:
    """Warns of what a material says and glTF has no word for. `origin`: of the first shape that has it."""
    place = origin or Location(None)
    if look.transmission_image is not None:
        sink.report("SC745", f"`transmission_texture` ({look.transmission_image.name}) is left out", place)
    if look.transmission > 0 and look.transmission_roughness != look.roughness:
        sink.report("SC745", "`transmission_roughness` is left out: `roughness` stands for it", place)
    rough, metal = look.roughness_image, look.metallic_image
    if rough is not None and metal is not None and _sampling(rough) != _sampling(metal):
        message = f"`metallic_texture` ({metal.name}) is sampled as `roughness_texture` is: glTF has both in one image"
        sink.report("SC745", message, place)
        metal = None
    for image in (look.base_color_image, look.normal_image, rough, metal, look.emission_image):
        if image is not None and image.address_mode == "border":
            sink.report("SC745", f"`address_mode: border` of {image.name} is written as `edge`", place)


def _sampling(image: Image) -> tuple[str, str]:
    return image.filter_mode, image.address_mode
