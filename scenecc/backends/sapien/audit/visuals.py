"""Visible shapes against the plan, every property of them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.backends.sapien.audit.difference import same, shown
from scenecc.backends.sapien.audit.geometry import VISUAL_SIZES, tiles
from scenecc.backends.sapien.audit.shapes import look_at_pose
from scenecc.backends.sapien.columns import plain_row
from scenecc.backends.sapien.knobs import RENDER_KNOBS
from scenecc.plan import Mesh, TiledPlane, VisualMaterial

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.backends.sapien.audit.defaults import Defaults
    from scenecc.backends.sapien.audit.sweep import Place, Sweep
    from scenecc.plan import BodyStructure, ScenePlan, Texture, VisualShape

_TEXTURES = tuple(
    f"{name}_texture" for name in ("base_color", "normal", "roughness", "metallic", "emission", "transmission")
)
_SAMPLING = {
    "mipmap_levels": "mipmap_levels",
    "filter_mode": "filter_mode",
    "address_mode": "address_mode",
    "is_srgb": "srgb",
}
"""SAPIEN's names for how an image is sampled to the plan's."""

_IMAGE = {"mipmap_levels": 1, "filter_mode": "linear", "address_mode": "repeat", "is_srgb": True}
"""What `sapien.render.RenderTexture2D` takes for an image of which nothing is said, by its signature."""

_NOTHING_SAID = VisualMaterial()


class VisualAudit:
    """Reads the render components of bodies."""

    def __init__(self, plan: ScenePlan, defaults: Defaults, sweep: Sweep) -> None:
        self._plan = plan
        self._defaults = defaults
        self._sweep = sweep

    def look_at(self, structure: BodyStructure, component: Any, row: int, place: Place) -> None:
        """A render component and all its shapes."""
        own = {knob.get: plain_row(value, row) for knob, value in RENDER_KNOBS.said(structure)}
        self._sweep.expect_but(self._defaults.look, own, component, place)
        found = component.render_shapes
        if len(found) != len(structure.visuals):
            self._sweep.tell(place, "render_shapes", len(structure.visuals), len(found))
            return
        for shape, made in zip(structure.visuals, found, strict=True):
            self._shape(shape, made, row, place._replace(origin=shape.origin))

    def _shape(self, shape: VisualShape, found: Any, row: int, place: Place) -> None:
        kind, sizes = VISUAL_SIZES[type(shape.geometry)]
        if type(found) is not kind:
            self._sweep.tell(place, "type", kind.__name__, type(found).__name__)
            return
        expected = sizes(shape.geometry, row) | {"name": shape.name or "", "front_face": _front_face(shape, row)}
        if isinstance(shape.geometry, Mesh):
            expected["filename"] = self._path(int(shape.geometry.file.row(row)))
        self._compare(expected, found, place)
        look_at_pose(shape.pose, found, row, place, self._sweep, self._defaults)
        if isinstance(shape.geometry, TiledPlane):
            corners, uvs = tiles(shape.geometry, row)
            part = found.parts[0]
            for name, wanted, actual in (("vertices", corners, part.vertices), ("uvs", uvs, part.get_vertex_uv())):
                if not same(wanted, actual):
                    self._sweep.tell(place, name, wanted.tolist(), actual.tolist())
        if shape.material is not None or not isinstance(shape.geometry, Mesh):
            asked = (
                _NOTHING_SAID if shape.material is None else self._plan.visual_materials[int(shape.material.row(row))]
            )
            for part in found.parts:
                self._paint(asked, part.material, row, place)

    def _paint(self, asked: VisualMaterial, found: Any, row: int, place: Place) -> None:
        self._compare(self._defaults.paint | asked.row(row), found, place)
        for name in _TEXTURES:
            texture, image = getattr(asked, name), getattr(found, name)
            if texture is None or image is None:
                if texture is not image:
                    self._sweep.tell(place, name, _word(texture), _word(image))
                continue
            for key, wanted in sampled(self._plan, texture, row).items():
                if wanted != (actual := getattr(image, key)):
                    self._sweep.tell(place, f"{name}.{key}", wanted, actual)

    def _compare(self, expected: Mapping[str, Any], found: Any, place: Place) -> None:
        for name, value in expected.items():
            actual = getattr(found, name)
            if not same(value, actual):
                self._sweep.tell(place, name, shown(value), shown(actual))

    def _path(self, file: int) -> str:
        return str(self._plan.files[file].path)


def sampled(plan: ScenePlan, texture: Texture, row: int) -> dict[str, object]:
    """What can be read of an image, by the engine's names; SAPIEN's own where the plan says nothing."""
    said = {key: getattr(texture, name) for key, name in _SAMPLING.items()}
    own = {key: _IMAGE[key] if value is None else value for key, value in said.items()}
    return {"filename": str(plan.files[int(texture.file.row(row))].path), **own}


def _word(image: object) -> str:
    return "none" if image is None else "an image"


def _front_face(shape: VisualShape, row: int) -> str:
    if shape.front_face is not None:
        return shape.front_face
    mirrored = isinstance(shape.geometry, Mesh) and math.prod(shape.geometry.scale.row(row).tolist()) < 0
    return "clockwise" if mirrored else "counterclockwise"
