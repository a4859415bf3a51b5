"""What is seen and drawn anew at a reset: pictures are those of the same file built with that seed. Needs a device."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import scenecc

if TYPE_CHECKING:
    from scenecc import SceneBatch

pytestmark = pytest.mark.render

TEXT = """
scenecc: 1
draws: {tilt: {uniform: [-0.5, 0.5]}}
environment: {ambient_light: {uniform: [[0.1, 0.1, 0.1], [0.5, 0.5, 0.5]]}}
lights:
  sun: {type: directional, direction: ["${tilt}", 0, -1], color: {uniform: [[0.5, 0.5, 0.5], [2, 2, 2]]}, shadow: true}
  lamp: {type: point, position: [{uniform: [-1, 1]}, 0, 1], color: [1, {uniform: [0, 1]}, 0]}
  spot:
    type: spot
    position: [0, {uniform: [-1, 1]}, 2]
    direction: [0, {uniform: [-0.3, 0.3]}, -1]
    inner_fov: 0.5
    outer_fov: 0.8
    color: [2, 2, 2]
  on_cube: {type: point, mount: cube, pose: [0, 0, {uniform: [0.3, 0.6]}], color: [1, 1, 1]}
  turned: {type: directional, mount: cube, pose: {rpy: [0, {uniform: [0.5, 1.5]}, 0]}, color: [1, 0.2, 1]}
cameras:
  eye:
    pose: {p: [{uniform: [-2, -1.5]}, 0, 1], look_at: [0, 0, 0]}
    fovy_deg: {uniform: [40, 80]}
    width: 32
    height: 24
    near: {uniform: [0.01, 1.5]}
    far: {uniform: [2, 30]}
  matrix:
    pose: {p: [-2, 0, 1], look_at: [0, 0, 0]}
    intrinsic:
      fx: {uniform: [20, 30]}
      fy: {uniform: [20, 30]}
      cx: {uniform: [15, 17]}
      cy: {uniform: [11, 13]}
      skew: {uniform: [0, 2]}
    width: 32
    height: 24
  flat:
    pose: {p: [-2, 0, 1], look_at: [0, 0, 0]}
    orthographic: {top: {uniform: [1, 2]}}
    width: 32
    height: 24
    near: {uniform: [0.01, 1.5]}
  wrist: {mount: cube, pose: [-1, 0, {uniform: [0.2, 0.5]}], fovx: {uniform: [0.8, 1.5]}, width: 32, height: 24}
  beside: {pose: {relative_to: eye, p: [0, {uniform: [0.1, 0.2]}, 0]}, width: 32, height: 24}
materials:
  paint:
    visual:
      base_color: {uniform: [[0, 0, 0], [1, 1, 1]]}
      emission: [{uniform: [0, 0.3]}, 0, 0]
      roughness: {uniform: [0, 1]}
      metallic: {uniform: [0, 1]}
      specular: {uniform: [0, 1]}
      transmission_roughness: {uniform: [0, 1]}
entities:
  ground: {body_type: static, color: {choice: ["#ff0000", "#00ff00", "#0000ff", "#808080"]}, shapes: [{type: plane}]}
  cube: {pose: [0, 0, 0.3], material: paint, shapes: [{type: box, half_size: [0.3, 0.3, 0.3]}]}
  ball:
    pose: [0, 0.7, 0.3]
    material: paint
    shapes:
    - {type: sphere, radius: 0.2}
    - {type: box, half_size: [0.1, 0.1, 0.4], color: [{uniform: [0, 1]}, 0.5, 0.5]}
"""

CAMERAS = ("eye", "matrix", "flat", "wrist", "beside")


def loaded(seed: int, text: str = TEXT) -> SceneBatch:
    return scenecc.load_scene(io.StringIO(text), num_scenes=2, seed=seed, render=True)


def assert_same(found: dict[str, Any], wanted: dict[str, Any], *, exact: bool) -> None:
    """`exact`: entities have moved to a new scene, where the renderer may add up its lights in another order."""
    for name, shot in found.items():
        assert np.allclose(shot, wanted[name], rtol=0, atol=1e-6 if exact else 0), name


def pictures(batch: SceneBatch) -> dict[str, Any]:
    shots = {name: batch.cameras[name].capture(["color", "position"]) for name in CAMERAS}
    return {f"{name} {what}": shot for name, found in shots.items() for what, shot in found.items()}


@pytest.mark.parametrize("exact", [False, True], ids=["in place", "exact"])
def test_pictures_after_a_reset_are_those_of_a_fresh_build(exact: bool) -> None:
    with loaded(0) as batch, loaded(5) as fresh:
        before, wanted = pictures(batch), pictures(fresh)
        assert not any(np.array_equal(before[name], shot) for name, shot in wanted.items())
        batch.step(3)
        batch.reset(seed=5, exact=exact)
        assert_same(pictures(batch), wanted, exact=exact)
        state = batch.state()
        batch.reset(seed=0)
        assert_same(pictures(batch), before, exact=exact)
        batch.set_state(state)
        assert batch.state() == state
        assert_same(pictures(batch), wanted, exact=exact)


def test_what_only_transmits_light_stays_as_built() -> None:
    glass = "{visual: {ior: {uniform: [1.2, 2]}, transmission: {uniform: [0, 1]}, roughness: {uniform: [0, 1]}}}"
    text = f"scenecc: 1\nentities: {{cube: {{material: {glass}, shapes: [{{type: sphere, radius: 1}}]}}}}"
    with loaded(0, text) as batch:

        def numbers() -> tuple[float, float, float]:
            body: Any = batch.entities["cube"].objs[0]
            found = next(each for each in body.components if hasattr(each, "render_shapes"))
            material = found.render_shapes[0].material
            return material.ior, material.transmission, material.roughness

        before = numbers()
        batch.reset(seed=5)
        assert numbers()[:2] == before[:2]
        assert numbers()[2] != before[2]


def test_what_has_one_material_keeps_it_for_itself_in_each_scene() -> None:
    with loaded(0) as batch:
        bodies: list[list[Any]] = [
            [obj.find_component_by_type(component_type()) for obj in batch.entities[name].objs]
            for name in ("cube", "ball")
        ]
        materials = [[body.render_shapes[0].material for body in row] for row in bodies]
        assert len({tuple(one.base_color) for row in materials for one in row}) == 2


def component_type() -> Any:
    from sapien.render import RenderBodyComponent

    return RenderBodyComponent
