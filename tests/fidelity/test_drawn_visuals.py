"""What is seen of scenes that differ, against hand-written render materials. Needs a device to render with."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene
from plugins.structures import body_of

from scenecc import SceneBatch, load_scene
from scenecc.plan.body import VisualMaterial

pytestmark = pytest.mark.render

SCENES = 4
RED, GREEN, BLUE = [0.8, 0.1, 0.1, 1.0], [0.1, 0.8, 0.1, 0.5], [0.1, 0.1, 0.8, 1.0]
UP = [0.7071068, 0, -0.7071068, 0]


def loaded(text: str, **options: Any) -> SceneBatch:
    given: dict[str, Any] = {"num_scenes": SCENES, "render": True, **options}
    return load_scene(io.StringIO(text), **given)


def component(batch: SceneBatch, name: str, scene: int) -> Any:
    """What is seen of an entity in a scene."""
    components: Any = batch.entities[name].objs[scene].components
    return next(each for each in components if isinstance(each, sapien.render.RenderBodyComponent))


def material_of(batch: SceneBatch, name: str, scene: int, shape: int = 0) -> Any:
    return component(batch, name, scene).render_shapes[shape].parts[0].material


KNOWN = """
scenecc: 1
materials:
  paint:
    visual:
      base_color: {per_scene: [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1, 0.5], [0.1, 0.1, 0.8], [0.8, 0.1, 0.1]]}
      roughness: {cycle: [0.2, 0.9]}
      metallic: "${scene / 8}"
      specular: 0.3
      transmission: {per_scene: {2: 0.5, default: 0.1}}
      emission: [0, 0, "${scene / 4}", 1]
entities:
  box:
    body_type: static
    shapes: [{type: box, half_size: [0.1, 0.2, 0.3], material: paint}]
  ball:
    body_type: static
    pose: [1, 0, 0]
    color: {cycle: [[0.8, 0.1, 0.1], [0.1, 0.1, 0.8]]}
    shapes: [{type: sphere, radius: 0.1}]
  either:
    body_type: static
    pose: [2, 0, 0]
    pick: {cycle: [0, 1]}
    variants:
      - color: {per_scene: {2: [0.1, 0.1, 0.8], default: [0.8, 0.1, 0.1]}}
        shapes: [{type: capsule, radius: 0.1, half_length: 0.2}]
      - shapes: [{type: box, half_size: [0.1, 0.1, 0.1], material: {cycle: [paint, paint]}}]
"""


def known_by_hand(scene: int) -> Any:
    """The same with the numbers of one scene."""
    made: Any = sapien.Scene()
    paint = sapien.render.RenderMaterial(
        base_color=(RED, GREEN, BLUE, RED)[scene],
        roughness=(0.2, 0.9)[scene % 2],
        metallic=scene / 8,
        specular=0.3,
        transmission=0.5 if scene == 2 else 0.1,
        emission=[0, 0, scene / 4, 1],
    )

    def plain(color: list[float]) -> Any:
        return sapien.render.RenderMaterial(base_color=color)

    box, ball, either = (made.create_actor_builder() for _ in range(3))
    box.add_box_collision(half_size=[0.1, 0.2, 0.3])
    box.add_box_visual(half_size=[0.1, 0.2, 0.3], material=paint)
    ball.add_sphere_collision(radius=0.1)
    ball.add_sphere_visual(radius=0.1, material=plain((RED, BLUE)[scene % 2]))
    if scene % 2:
        either.add_box_collision(half_size=[0.1] * 3)
        either.add_box_visual(half_size=[0.1] * 3, material=paint)
    else:
        either.add_capsule_collision(radius=0.1, half_length=0.2)
        either.add_capsule_visual(radius=0.1, half_length=0.2, material=plain(BLUE if scene == 2 else RED))
    for x, builder, name in ((0, box, "box"), (1, ball, "ball"), (2, either, "either")):
        builder.initial_pose = sapien.Pose([x, 0, 0])
        builder.build_static(name=name)
    return made


def test_colours_by_scene_are_those_written_by_hand() -> None:
    with loaded(KNOWN) as batch:
        for scene in range(SCENES):
            assert_same_scene(batch.scenes[scene], known_by_hand(scene))


def test_some_scenes_of_a_batch_look_as_among_all() -> None:
    with loaded(KNOWN, scene_idxs=[3, 1]) as batch:
        for ours, scene in zip(batch.scenes, (1, 3), strict=True):
            assert_same_scene(ours, known_by_hand(scene))


DRAWN = """
scenecc: 1
seed: 7
draws:
  shade: {uniform: [[0.1, 0.1, 0.1], [0.9, 0.9, 0.9]]}
entities:
  box:
    pose: [{uniform: [-0.1, 0.1]}, 0, {uniform: [0.5, 1]}]
    shapes:
      - type: box
        half_size: {uniform: [[0.05, 0.05, 0.05], [0.1, 0.1, 0.1]]}
        material:
          visual:
            base_color: ["${shade[0]}", "${shade[1]}", "${shade[2]}", {uniform: [0.2, 1]}]
            roughness: {normal: [0.5, 0.2], clip: [0, 1]}
            metallic: {uniform: [0, 1]}
            ior: {log_uniform: [1.1, 2]}
  ball:
    pose: [1, 0, 1]
    color: "${shade}"
    shapes: [{type: sphere, radius: 0.1}]
"""
NUMBERS = ("base_color", "roughness", "metallic", "ior")


def test_what_is_drawn_is_what_the_engine_holds() -> None:
    with loaded(DRAWN) as batch:
        table = [batch.plan.visual_materials[row] for row in range(len(batch.plan.visual_materials))]
        seen: set[bytes] = set()
        for scene in range(SCENES):
            material = material_of(batch, "box", scene)
            for name in NUMBERS:
                value = drawn(batch, table, "box", name)
                assert len(value.data) == SCENES
                assert np.array_equal(np.ravel(getattr(material, name)), np.float32(np.ravel(value.row(scene)))), name
            shade = material_of(batch, "ball", scene).base_color
            assert shade[:3] == material.base_color[:3]
            assert shade[3] == 1
            seen.add(np.float32(material.base_color).tobytes())
        assert len(seen) == SCENES


def drawn(batch: SceneBatch, table: list[VisualMaterial], name: str, field: str) -> Any:
    """The values of a field of an entity's material."""
    entity = next(each for each in batch.plan.entities if each.name == name)
    index = body_of(entity).visuals[0].material
    assert index is not None
    return getattr(table[int(index.row(0))], field)


def test_scenes_of_the_same_look_share_it() -> None:
    """As a script that makes each material once: what is changed later is changed wherever it is."""
    with loaded(KNOWN) as batch:
        balls = [material_of(batch, "ball", scene) for scene in range(SCENES)]
        balls[0].set_roughness(0.125)
        assert [ball.roughness == 0.125 for ball in balls] == [True, False] * 2
        # One material, whatever else of it is the same: no two of the scenes have all its numbers.
        boxes = [material_of(batch, "box", scene) for scene in range(SCENES)]
        boxes[0].set_ior(1.75)
        assert [box.ior == 1.75 for box in boxes] == [True, False, False, False]
        assert material_of(batch, "either", 1).base_color == boxes[1].base_color


def test_images_by_scene(image: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.png"
    other.write_bytes(image.read_bytes())
    files = [image, other]
    text = f"""
scenecc: 1
entities:
  box:
    body_type: none
    visuals:
      - type: box
        half_size: [0.1, 0.1, 0.1]
        material:
          visual:
            base_color_texture:
              file: {{cycle: ["{image}", "{other}"]}}
              filter_mode: nearest
            roughness: {{uniform: [0, 1]}}
"""
    with loaded(text, allow_outside_assets=True) as batch:
        for scene in range(SCENES):
            hand: Any = sapien.Scene()
            material = sapien.render.RenderMaterial(roughness=material_of(batch, "box", scene).roughness)
            texture = sapien.render.RenderTexture2D(str(files[scene % 2]), filter_mode="nearest")
            material.base_color_texture = texture
            body, entity = sapien.render.RenderBodyComponent(), sapien.Entity()
            body.attach(sapien.render.RenderShapeBox([0.1] * 3, material))
            entity.name = body.name = "box"
            entity.add_component(body)
            hand.add_entity(entity)
            assert_same_scene(batch.scenes[scene], hand)


def quad(half: list[float], repeat: list[float], material: Any) -> Any:
    """A floor of tiles that faces up: its texture is centred, and repeats so often along x and y."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    vertices = np.zeros((4, 3), np.float32)
    vertices[:, :2] = half * corners
    uvs = (0.5 + corners / 2 * repeat).astype(np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    normals = np.array([[0, 0, 1]] * 4, np.float32)
    return sapien.render.RenderShapeTriangleMesh(vertices, triangles, normals, uvs, material)


@pytest.mark.parametrize(
    ("given", "half", "repeat", "at", "levels"),
    [
        ("{}", [50, 50], [25, 25], [0, 0, 0], 4),
        (
            "{floor_width: 8, floor_length: 20, xy_origin: [1, 2], altitude: -0.5, mipmap_levels: 1}",
            [10, 4],
            [5, 2],
            [1, 2, -0.5],
            1,
        ),
    ],
    ids=["defaults", "all given"],
)
@pytest.mark.parametrize("own", [False, True], ids=["tiles", "own image"])
def test_the_floor_shows_its_tiles(
    given: str, half: list[float], repeat: list[float], at: list[float], levels: int, own: bool, image: Path
) -> None:
    file = str(image) if own else str(Path(__file__).parents[2] / "scenecc/prefabs/tiles.png")
    given = given.replace("{", f"{{texture_file: '{file}', " if own else "{", 1)
    text = f"scenecc: 1\nentities:\n  floor: {{use: scenecc:ground, prefix: '', with: {given}}}\n"
    hand: Any = sapien.Scene()
    builder = hand.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_plane_collision(sapien.Pose([0, 0, at[2]], UP))
    material = sapien.render.RenderMaterial()
    material.base_color_texture = sapien.render.RenderTexture2D(file, mipmap_levels=levels)
    floor, seen, ground = quad(half, repeat, material), sapien.render.RenderBodyComponent(), sapien.Entity()
    floor.local_pose = sapien.Pose(at)
    seen.attach(floor)
    for each in (seen, builder.build_physx_component()):
        each.name = "ground"
        ground.add_component(each)
    ground.name = "ground"
    hand.add_entity(ground)
    with loaded(text, num_scenes=1, allow_outside_assets=True) as batch:
        assert_same_scene(batch.scenes[0], hand)
