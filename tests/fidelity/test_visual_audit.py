"""Sabotage of what the builder makes of images: the audit names the property. Needs a device to render with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import pytest
from fidelity.hand import Case, built, plan_of
from plugins.sample_plans import indices

from scenecc.backends.sapien import assets, instantiate
from scenecc.diagnostics import Sink
from scenecc.plan import BodyStructure, Box, VisualShape, constant
from scenecc.plan.body import Texture, VisualMaterial

Level = Literal["full", "fast"]


@pytest.mark.render
@pytest.mark.parametrize("level", ["fast", "full"])
@pytest.mark.parametrize(
    ("asked", "changed", "name"),
    [
        ({}, {"mipmap_levels": 2}, "mipmap_levels"),
        ({"mipmap_levels": 3}, {"mipmap_levels": 1}, "mipmap_levels"),
        ({}, {"filter_mode": "nearest"}, "filter_mode"),
        ({"address_mode": "border"}, {"address_mode": "repeat"}, "address_mode"),
        ({"srgb": False}, {"srgb": True}, "is_srgb"),
        ({}, {"srgb": False}, "is_srgb"),
    ],
)
def test_sampling_of_an_image(
    asked: dict[str, Any],
    changed: dict[str, Any],
    name: str,
    level: Level,
    image: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The builder samples an image otherwise than the plan says."""
    paint = VisualMaterial(base_color_texture=Texture(indices(0), **asked))
    box = VisualShape(Box(constant([0.1, 0.1, 0.1])), material=constant(0, int))
    seen = Case(
        BodyStructure("static", visuals=(box,)),
        lambda _builder, _scene: None,
        files=(image,),
        visual_materials=(paint,),
    )
    plan = plan_of(seen)
    built(plan, render=True, audit=level)
    make = assets.Resources.texture

    def other(self: Any, texture: Texture, row: int) -> Any:
        return make(self, replace(texture, **changed), row)

    monkeypatch.setattr(assets.Resources, "texture", other)
    sink = Sink()
    assert instantiate(plan, sink, render=True, audit=level) is None
    assert any(f"base_color_texture.{name} = " in d.message for d in sink.diagnostics())
