"""Every visual shape, material and texture against hand-written SAPIEN. Needs a device to render with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import SCENES, Case, box_shape, built, by_hand, component, counts, plan_of
from plugins.sample_plans import indices, look

from scenecc.backends.sapien.geometry import VISUAL_SHAPES
from scenecc.plan import (
    BodyStructure,
    Box,
    Capsule,
    Cone,
    Cylinder,
    Entity,
    Heightfield,
    Mesh,
    Physics,
    Ring,
    ScenePlan,
    Sphere,
    TiledPlane,
    VisualGeometry,
    VisualPlane,
    VisualShape,
    constant,
    per_scene,
)
from scenecc.plan.body import Texture, VisualMaterial

pytestmark = [pytest.mark.render, pytest.mark.quick]

SIZES = [0.05, 0.06, 0.07]
POSE = [0.01, 0.02, -0.03, 0.5, 0.5, 0.5, 0.5]
OAK = look(base_color=(0.6, 0.4, 0.2, 0.5), roughness=0.7)
STEEL = look(
    emission=(0.1, 0.2, 0.3, 1.0),
    specular=0.4,
    metallic=0.9,
    transmission=0.1,
    ior=1.3,
    transmission_roughness=0.2,
)
COLORS = ("base_color", "emission")

Meshes = dict[str, Path]


def material(numbers: VisualMaterial) -> Any:
    """As a person writes it."""
    made = sapien.render.RenderMaterial()
    for name in (*COLORS, "specular", "roughness", "metallic", "transmission", "ior", "transmission_roughness"):
        if (value := getattr(numbers, name)) is not None:
            getattr(made, f"set_{name}")(value.data[0].tolist())
    return made


def seen(*visuals: VisualShape, **knobs: Any) -> BodyStructure:
    return BodyStructure("dynamic", (box_shape(*SIZES),), visuals, **knobs)


def case(structure: BodyStructure, look: Callable[[Any, int], Any], **more: Any) -> Case:
    def build(builder: Any, scene: int) -> None:
        builder.add_box_collision(half_size=SIZES)
        look(builder, scene)

    return Case(structure, build, **more)


def assert_same(it: Case) -> None:
    batch, hand = built(plan_of(it), render=True), by_hand(it, rendered=True)
    assert batch.render
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand, steps=20)


CASES: dict[str, Callable[[Meshes], Case]] = {
    "box": lambda _: case(
        seen(VisualShape(Box(per_scene([[s, 0.1, 0.2] for s in SIZES])))),
        lambda b, i: b.add_box_visual(half_size=[SIZES[i], 0.1, 0.2]),
    ),
    "sphere": lambda _: case(
        seen(VisualShape(Sphere(per_scene(SIZES)))), lambda b, i: b.add_sphere_visual(radius=SIZES[i])
    ),
    "capsule": lambda _: case(
        seen(VisualShape(Capsule(constant(0.1), per_scene(SIZES)))),
        lambda b, i: b.add_capsule_visual(radius=0.1, half_length=SIZES[i]),
    ),
    "cylinder": lambda _: case(
        seen(VisualShape(Cylinder(constant(0.1), per_scene(SIZES)))),
        lambda b, i: b.add_cylinder_visual(radius=0.1, half_length=SIZES[i]),
    ),
    "plane": lambda _: case(
        seen(VisualShape(VisualPlane(constant([3.0, 4.0])))), lambda b, _: b.add_plane_visual(scale=[10, 3.0, 4.0])
    ),
    "mesh, as its file shows it": lambda m: case(
        seen(VisualShape(Mesh(constant(0, int), constant([1, 2, 0.5])))),
        lambda b, _: b.add_visual_from_file(str(m["rock"]), scale=[1, 2, 0.5]),
        files=(m["rock"],),
    ),
    "mesh, mirrored in one scene": lambda m: case(
        seen(
            VisualShape(
                Mesh(counts([0, 1, 0]), per_scene([[1, 1, 1], [-1, 1, 1], [-1, -1, 1]])), material=constant(0, int)
            )
        ),
        lambda b, i: b.add_visual_from_file(
            str(m[("rock", "wedge", "rock")[i]]),
            scale=[[1, 1, 1], [-1, 1, 1], [-1, -1, 1]][i],
            material=material(OAK),
        ),
        files=(m["rock"], m["wedge"]),
        visual_materials=(OAK,),
    ),
    "pose and name": lambda _: case(
        seen(VisualShape(Box(constant(SIZES)), pose=constant(POSE), name="lid"), VisualShape(Sphere(constant(0.1)))),
        lambda b, _: (
            b.add_box_visual(pose=sapien.Pose(POSE[:3], POSE[3:]), half_size=SIZES, name="lid"),
            b.add_sphere_visual(radius=0.1),
        ),
    ),
    "material": lambda _: case(
        seen(VisualShape(Box(constant(SIZES)), material=counts([0, 1, 0]))),
        lambda b, i: b.add_box_visual(half_size=SIZES, material=material((OAK, STEEL, OAK)[i])),
        visual_materials=(OAK, STEEL),
    ),
    "visibility and shading mode": lambda _: Case(
        BodyStructure(
            "kinematic",
            (),
            (VisualShape(Box(constant(SIZES))),),
            visibility=per_scene([0.0, 0.5, 1.0]),
            shading_mode=counts([0, 1, 0]),
        ),
        lambda b, i: b.add_box_visual(half_size=SIZES),
        lambda c, i: (
            setattr(c.entity.components[0], "visibility", (0.0, 0.5, 1.0)[i]),
            setattr(c.entity.components[0], "shading_mode", (0, 1, 0)[i]),
        ),
        kind="kinematic",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_visual_is_as_written_by_hand(name: str, meshes: Meshes) -> None:
    assert_same(CASES[name](meshes))


def test_front_face() -> None:
    """SAPIEN's builder has no word for it; a person would set it on the shape."""
    boxes = tuple(
        VisualShape(Box(constant(SIZES)), front_face=face) for face in ("clockwise", "counterclockwise", None)
    )
    batch = built(plan_of(case(seen(*boxes), lambda b, _: None)), render=True)
    for scene in range(SCENES):
        faces = [shape.front_face for shape in component(batch, "body", scene).render_shapes]
        assert faces == ["clockwise", "counterclockwise", "counterclockwise"]


def test_textures(image: Path) -> None:
    plain = Texture(indices(0))
    told = Texture(indices(0), mipmap_levels=3, filter_mode="nearest", address_mode="border", srgb=False)
    paint = VisualMaterial(
        base_color_texture=plain,
        normal_texture=told,
        roughness_texture=told,
        metallic_texture=told,
        emission_texture=plain,
        transmission_texture=told,
    )

    def look(builder: Any, scene: int) -> None:
        made = sapien.render.RenderMaterial()
        one = sapien.render.RenderTexture2D(str(image))
        other = sapien.render.RenderTexture2D(
            str(image), mipmap_levels=3, filter_mode="nearest", address_mode="border", srgb=False
        )
        made.base_color_texture = made.emission_texture = one
        made.normal_texture = made.roughness_texture = made.metallic_texture = made.transmission_texture = other
        builder.add_box_visual(half_size=SIZES, material=made)

    assert_same(
        case(
            seen(VisualShape(Box(constant(SIZES)), material=constant(0, int))),
            look,
            files=(image,),
            visual_materials=(paint,),
        )
    )


def test_tiled_plane_repeats_its_texture() -> None:
    """Against the quad written out by hand."""
    half, repeat = [0.5, 0.25], [4.0, 2.0]

    def look(builder: Any, scene: int) -> None:
        return None

    it = case(
        seen(VisualShape(TiledPlane(constant(half), constant(repeat)), material=constant(0, int))),
        look,
        visual_materials=(OAK,),
    )
    shape = component(built(plan_of(it), render=True), "body").render_shapes[0]
    part = shape.parts[0]
    assert part.vertices.tolist() == [[-0.5, -0.25, 0], [0.5, -0.25, 0], [0.5, 0.25, 0], [-0.5, 0.25, 0]]
    assert part.get_vertex_uv().tolist() == [[-1.5, -0.5], [2.5, -0.5], [2.5, 1.5], [-1.5, 1.5]]
    assert part.get_vertex_normal().tolist() == [[0, 0, 1]] * 4
    corners = part.vertices[part.triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (faces[:, 2] > 0).all()


def shown(geometry: VisualGeometry) -> Any:
    """The part of the render shape of a geometry."""
    it = case(seen(VisualShape(geometry)), lambda _builder, _scene: None)
    return component(built(plan_of(it), render=True), "body").render_shapes[0].parts[0]


def test_a_cone_is_drawn_from_its_base_to_its_tip() -> None:
    vertices = shown(Cone(constant(0.2), constant(0.3))).vertices.astype(np.float64)
    x, radius = vertices[:, 0], np.hypot(vertices[:, 1], vertices[:, 2])
    on_side = np.isclose(radius, 0.2 * (0.3 - x) / 0.6, atol=1e-6)
    on_base = np.isclose(x, -0.3, atol=1e-6) & (radius <= 0.2 + 1e-6)
    assert (on_side | on_base).all()
    assert (x.max(), radius.max()) == pytest.approx((0.3, 0.2))


def test_a_ring_is_drawn_with_its_hole() -> None:
    vertices = shown(Ring(constant(0.1), constant(0.2), constant(0.05))).vertices.astype(np.float64)
    radius = np.hypot(vertices[:, 1], vertices[:, 2])
    assert np.abs(vertices[:, 0]) == pytest.approx(0.05)
    assert {round(float(number), 6) for number in radius} == {0.1, 0.2}


def test_terrain_is_drawn_from_the_rear_left_corner_to_the_front_right() -> None:
    heights = ((0.0, 0.5, 0.25), (1.0, 0.0, -0.5))
    vertices = shown(Heightfield(constant([0.4, 0.6, 2.0]), heights)).vertices
    expected = {
        (x, y, 2 * z)
        for y, row in zip((0.3, -0.3), heights, strict=True)
        for x, z in zip((-0.2, 0, 0.2), row, strict=True)
    }
    assert {tuple(round(float(number), 6) for number in vertex) for vertex in vertices} == expected


TESTED = {Box, Sphere, Capsule, Cylinder, VisualPlane, Mesh, TiledPlane, Cone, Ring, Heightfield}


def test_every_geometry_that_is_seen_has_a_case() -> None:
    assert set(VISUAL_SHAPES) == TESTED


def test_none_is_only_seen() -> None:
    body = BodyStructure("none", visuals=(VisualShape(Sphere(constant(0.1)), material=constant(0, int)),))
    every = tuple(range(SCENES))
    plan = ScenePlan(
        "goal",
        SCENES,
        (Entity("goal", every, constant([0, 0, 1, 1, 0, 0, 0]), (body,)),),
        Physics(),
        visual_materials=(OAK,),
    )
    batch = built(plan, render=True)
    for scene in batch.scenes:
        (goal,) = scene.entities
        assert [type(c).__name__ for c in goal.components] == ["RenderBodyComponent"]
    batch.step(3)
    assert (batch.entities["goal"].pose == np.array([0, 0, 1, 1, 0, 0, 0], np.float32)).all()


def test_render_false_leaves_visuals_out(meshes: Meshes) -> None:
    it = CASES["material"](meshes)
    batch = built(plan_of(it), render=False)
    assert not batch.render
    assert [type(c).__name__ for c in batch.entities["body"].objs[0].components] == ["PhysxRigidDynamicComponent"]


def test_render_none_renders_where_a_device_exists(meshes: Meshes) -> None:
    assert built(plan_of(CASES["material"](meshes)), render=None).render


def test_a_picture_shows_the_body() -> None:
    """The whole path down to pixels: a red box in front of a camera, in two scenes of different size."""
    red = look(emission=(1.0, 0.0, 0.0, 1.0), base_color=(1.0, 0.0, 0.0, 1.0))
    box = VisualShape(Box(per_scene([[0.1, 0.1, 0.1], [0.1, 0.3, 0.3]])), material=constant(0, int))
    plan = ScenePlan(
        "picture",
        2,
        (Entity("box", (0, 1), constant([1, 0, 0, 1, 0, 0, 0]), (BodyStructure("none", visuals=(box,)),)),),
        Physics(),
        visual_materials=(red,),
    )
    batch = built(plan, render=True)
    areas: list[int] = []
    for scene in batch.scenes:
        scene.set_ambient_light([0.5, 0.5, 0.5])
        camera = scene.add_camera("camera", 64, 64, 1.0, 0.01, 10)
        scene.update_render()
        camera.take_picture()
        picture = camera.get_picture("Color")
        areas.append(int((picture[..., 0] > picture[..., 2] + 0.3).sum()))
    assert 0 < areas[0] < areas[1]
