"""What `scenecc render` writes, against pictures of the same scenes built by hand in SAPIEN. Needs a device."""

from __future__ import annotations

from io import BytesIO
from math import radians, tan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from PIL import Image, ImageSequence
from plugins.segmentation import ids_of
from plugins.videos import decoded

from scenecc import Rendering, SceneError, load_scene, render_scene
from scenecc.render.images import BAR

pytestmark = [pytest.mark.render, pytest.mark.quick, pytest.mark.usefixtures("held_renderer")]

ASSETS = Path(__file__).parents[2] / "scenes" / "assets"
WIDTH, HEIGHT = 96, 72
EYE = {"p": [-1.2, 0.3, 0.9], "look_at": [0, 0, 0.2]}
CUBE = {"pose": [0, 0, 0.5], "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1], "color": [1, 0, 0]}]}
FLOOR = {"body_type": "static", "shapes": [{"type": "plane"}]}


LIGHTS: dict[str, Any] = {
    "environment": {"ambient_light": [0.3, 0.3, 0.3]},
    "lights": {
        "sun": {"type": "directional", "direction": [1, 1, -1], "color": [1, 1, 1]},
        "top": {"type": "directional", "direction": [0, 0, -1], "color": [1, 1, 1]},
    },
}


def document(entities: dict[str, Any], eye: dict[str, Any] | None = None, **sections: Any) -> dict[str, Any]:
    cameras = {"eye": {"pose": EYE, "width": WIDTH, "height": HEIGHT, **(eye or {})}}
    return {"scenecc": 1, "entities": entities, "cameras": cameras, **LIGHTS, **sections}


def pixels(found: Rendering) -> np.ndarray[Any, Any]:
    return np.asarray(Image.open(BytesIO(found.png())))


class ByHand:
    """A scene under `LIGHTS`, before the same camera."""

    def __init__(self) -> None:
        self.scene = sapien.Scene()
        self.scene.set_ambient_light([0.3, 0.3, 0.3])
        self.scene.add_directional_light([1, 1, -1], [1, 1, 1])
        self.scene.add_directional_light([0, 0, -1], [1, 1, 1])

    def picture(
        self, pose: sapien.Pose, near: float = 0.01, far: float = 100, fovy: float = radians(60)
    ) -> np.ndarray[Any, Any]:
        """As SAPIEN's examples save it."""
        camera = self.scene.add_camera("eye", WIDTH, HEIGHT, fovy, near, far)
        camera.get_entity().set_pose(pose)
        self.scene.update_render()
        camera.take_picture()
        return (camera.get_picture("Color")[..., :3] * 255).clip(0, 255).astype(np.uint8)


def eye_pose(source: dict[str, Any]) -> sapien.Pose:
    with load_scene(source, render=True) as batch:
        return batch.cameras["eye"].objs[0].get_entity().get_pose()


def red_cube(scene: sapien.Scene) -> Any:
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=(0.1, 0.1, 0.1))
    builder.add_box_visual(half_size=(0.1, 0.1, 0.1), material=sapien.render.RenderMaterial(base_color=[1, 0, 0, 1]))
    builder.initial_pose = sapien.Pose([0, 0, 0.5])
    return builder.build("cube")


def test_a_picture_after_steps_is_that_of_the_same_scene_by_hand() -> None:
    source = document({"floor": FLOOR, "cube": CUBE})
    hand = ByHand()
    hand.scene.add_ground(0)
    red_cube(hand.scene)
    for steps in (0, 25):
        found = render_scene(source, camera="eye", steps=steps)
        for _ in range(steps):
            hand.scene.step()
        assert np.array_equal(pixels(found), hand.picture(eye_pose(source))), steps
    assert found.camera == "eye"
    assert [picture.scene_idx for picture in found.pictures] == [0]


@pytest.mark.parametrize("size", [(WIDTH, HEIGHT), (40, 90)])
def test_without_a_camera_the_scene_is_framed(size: tuple[int, int]) -> None:
    """All of it is in the picture, whatever the picture's shape, and nearly fills it."""
    source = {"scenecc": 1, "entities": {"floor": FLOOR, "cube": CUBE, "other": {**CUBE, "pose": [0, 1, 0.1]}}}
    found = render_scene(source, size=size, what="segmentation")
    assert pixels(found).shape == size[::-1]
    names = {row.name: row.id for row in found.legend()}
    rows, columns = np.nonzero(np.isin(pixels(found), [names["cube"], names["other"]]))
    assert 0 < rows.min() <= rows.max() < size[1] - 1
    assert 0 < columns.min() <= columns.max() < size[0] - 1
    assert (np.ptp(columns) if size[0] < size[1] else np.ptp(rows)) > 0.4 * min(size)


def test_the_camera_that_frames_the_scene_is_one_that_can_be_made_by_hand() -> None:
    source = {"scenecc": 1, "entities": {"cube": CUBE}, **LIGHTS}
    with load_scene(source, render=True) as batch:
        camera = batch.framed(WIDTH, HEIGHT)
        camera.capture("color")
        made = camera.objs[0]
        seen = made.get_entity().get_pose(), made.near, made.far, made.fovy
    hand = ByHand()
    red_cube(hand.scene)
    assert np.array_equal(pixels(render_scene(source, size=(WIDTH, HEIGHT), samples=1)), hand.picture(*seen))


def test_a_cube_is_where_the_cameras_matrix_says() -> None:
    source = document({"cube": CUBE})
    with load_scene(source, render=True) as batch:
        camera = batch.cameras["eye"].objs[0]
        intrinsic, extrinsic = camera.get_intrinsic_matrix(), camera.get_extrinsic_matrix()
    corners = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (0.4, 0.6)])
    there = (extrinsic[:3, :3] @ corners.T + extrinsic[:3, 3:]).T @ intrinsic.T
    u, v = there[:, 0] / there[:, 2], there[:, 1] / there[:, 2]
    picture = pixels(render_scene(source, camera="eye")).astype(int)
    red = (picture[..., 0] > 60) & (picture[..., 1] < 30) & (picture[..., 2] < 30)
    rows, columns = np.nonzero(red)
    assert abs(columns.min() - u.min()) <= 1
    assert abs(columns.max() + 1 - u.max()) <= 1
    assert abs(rows.min() - v.min()) <= 1
    assert abs(rows.max() + 1 - v.max()) <= 1


def test_a_depth_agrees_with_geometry_to_a_millimetre() -> None:
    """A floor seen at a slant, and a box straight ahead."""
    box = {"body_type": "static", "pose": [1.6, 0, 1], "shapes": [{"type": "box", "half_size": [0.1, 0.2, 0.2]}]}
    eye = {"pose": {"p": [0, 0, 1], "rpy_deg": [0, 0, 0]}, "width": 64, "height": 48, "fovy_deg": 60}
    found = pixels(render_scene(document({"floor": FLOOR, "box": box}, eye), camera="eye", what="depth"))
    assert found.dtype == np.uint16
    assert (found[22:26, 30:34] == 1500).all()
    focal = 24 / tan(radians(30))
    down = (np.arange(48) + 0.5 - 24) / focal
    rows = np.flatnonzero(down > 0.3)  # the floor's points up to 3.3 m away
    expected = 1000 / down[rows]
    assert len(rows) > 10
    assert np.abs(found[rows][:, [0, 10, 63]] - expected[:, None]).max() <= 1
    assert not found[0].any(), "nothing above the horizon"


def test_ids_map_back_to_names() -> None:
    entities = {
        "floor": FLOOR,
        "cube": CUBE,
        "ball": {"pose": [0, 0.4, 0.1], "scene_idxs": [1], "shapes": [{"type": "sphere", "radius": 0.1}]},
    }
    source = document(entities, num_scenes=2)
    with load_scene(source, render=True) as batch:
        eye = batch.cameras["eye"]
        captured = eye.capture("segmentation")["segmentation"][..., 0]
        names = [eye.names(index) for index in (0, 1)]
    for index in (0, 1):
        found = render_scene(source, camera="eye", scenes=str(index), what="segmentation")
        image = Image.open(BytesIO(found.png()))
        assert image.mode == "P"
        assert np.array_equal(np.asarray(image), captured[index])
        rows = {row.id: row for row in found.legend()}
        assert set(rows) == {*np.unique(captured[index]).tolist()} - {0}
        assert {number: row.name for number, row in rows.items()} == {n: names[index][n] for n in rows}
        colors = np.asarray(image.convert("RGB"))
        for row in rows.values():
            assert {bytes(color).hex() for color in colors[captured[index] == row.id]} == {row.color[1:]}
    assert {row.name for row in found.legend()} == {"floor", "cube", "ball"}
    sheet = render_scene(source, camera="eye", grid=True, what="segmentation")
    assert np.array_equal(ids_of(pixels(sheet)[BAR:, WIDTH:]), captured[1])
    assert {row.name: row.scene_idxs for row in sheet.legend()} == {"floor": (0, 1), "cube": (0, 1), "ball": (1,)}


def test_normals_are_in_the_cameras_frame() -> None:
    box = {"body_type": "static", "pose": [1, 0, 0], "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]}
    found = pixels(render_scene(document({"box": box}, {"pose": [0, 0, 0]}), camera="eye", what="normal"))
    assert found[HEIGHT // 2, WIDTH // 2].tolist() == [128, 128, 255], "towards the camera is +z"
    assert not found[0].any()


def test_a_camera_without_normals_is_told_at_its_shader() -> None:
    source = document({"cube": CUBE}, {"shader": "minimal"})
    with pytest.raises(SceneError) as caught:
        render_scene(source, camera="eye", what="normal")
    (told,) = caught.value.diagnostics
    assert (told.code, told.path) == ("SC913", "cameras.eye.shader")
    assert pixels(render_scene(source, camera="eye", what="depth")).any()


def test_a_sheet_of_sixteen_scenes() -> None:
    cube = {**CUBE, "pose": [0, 0, {"uniform": [0.1, 0.6]}]}
    source = document({"cube": cube}, num_scenes=16)
    found = render_scene(source, camera="eye", grid=True)
    sheet = pixels(found)
    assert sheet.shape == (4 * (HEIGHT + BAR), 4 * WIDTH, 3)
    with load_scene(source, render=True) as batch:
        color = batch.cameras["eye"].capture("color")["color"]
    for index in range(16):
        top, left = index // 4 * (HEIGHT + BAR), index % 4 * WIDTH
        tile = sheet[top + BAR : top + BAR + HEIGHT, left : left + WIDTH]
        assert np.array_equal(tile, (color[index, ..., :3] * 255).clip(0, 255).astype(np.uint8)), index
        assert sheet[top : top + BAR, left : left + WIDTH].any(), "its label"
    some = render_scene(source, camera="eye", scenes="3,5")
    assert [picture.scene_idx for picture in some.pictures] == [3, 5]
    assert np.array_equal(pixels(some)[BAR:, :WIDTH], sheet[BAR : BAR + HEIGHT, 3 * WIDTH :])


def test_a_sheet_has_the_scenes_that_the_camera_is_in() -> None:
    source = document({"cube": CUBE}, {"scene_idxs": "1::2"}, num_scenes=4)
    found = render_scene(source, camera="eye", grid=True)
    assert [picture.scene_idx for picture in found.pictures] == [1, 3]
    assert [picture.scene_idx for picture in render_scene(source, camera="eye").pictures] == [1]


@pytest.mark.parametrize(("every", "count", "rate"), [(None, 14, 100 / 3), (5, 9, 20.0)])
def test_a_video_has_a_frame_every_few_steps(every: int | None, count: int, rate: float, tmp_path: Path) -> None:
    source = document({"floor": FLOOR, "cube": CUBE})
    found = render_scene(source, camera="eye", steps=41, video="mp4", every=every)
    assert (found.frames, found.rate) == (count, pytest.approx(rate))
    (tmp_path / "video.mp4").write_bytes(found.video or b"")
    played, frames = decoded(tmp_path / "video.mp4")
    assert played == pytest.approx(rate, abs=0.01)
    assert [frame.shape for frame in frames] == [(HEIGHT, WIDTH, 3)] * count
    start = pixels(render_scene(source, camera="eye")).astype(int)
    assert np.abs(frames[0] - start).mean() < 4 < np.abs(frames[-1] - start).mean(), "the first is of the start"
    # The video does not change what is simulated.
    assert np.array_equal(pixels(found), pixels(render_scene(source, camera="eye", steps=41)))


def test_a_video_of_several_scenes_is_of_their_sheet() -> None:
    source = document({"cube": {**CUBE, "pose": [0, 0, {"per_scene": [0.3, 0.6]}]}}, num_scenes=2)
    found = render_scene(source, camera="eye", grid=True, steps=8, video="gif", every=2)
    image: Any = Image.open(BytesIO(found.video or b""))
    assert image.size == (2 * WIDTH, HEIGHT + BAR)
    assert sum(frame.info["duration"] for frame in ImageSequence.Iterator(image)) == 100
    assert image.n_frames == found.frames == 5


def test_a_matrix_is_scaled_with_the_picture() -> None:
    lens = {"intrinsic": {"fx": 80, "fy": 82, "cx": 40, "cy": 30}}
    source = document({"floor": FLOOR, "cube": CUBE}, lens)
    small = pixels(render_scene(source, camera="eye", what="segmentation"))
    large = pixels(render_scene(source, camera="eye", what="segmentation", size=(3 * WIDTH, 3 * HEIGHT)))
    assert np.array_equal(large[1::3, 1::3], small), "the middle one of nine is the same point"


def test_what_is_hidden_is_for_people() -> None:
    goal = {"hidden": True, "body_type": "kinematic", "visuals": [{"type": "sphere", "radius": 0.2}]}
    source = document({"goal": goal, "cube": CUBE})

    def seen(**options: Any) -> set[str]:
        return {row.name for row in render_scene(source, what="segmentation", **options).legend()}

    assert seen(camera="eye") == {"cube"}
    assert seen(camera="eye", hidden=True) == {"goal", "cube"}
    assert seen(size=(WIDTH, HEIGHT)) == {"goal", "cube"}
    assert seen(size=(WIDTH, HEIGHT), hidden=False) == {"cube"}


DYNAMIC, KINEMATIC, STATIC, LINK = (
    (0.0437, 0.2051, 0.6867, 1),
    (0.8879, 0.2705, 0.0242, 1),
    (0.3231, 0.3231, 0.3231, 1),
    (0.1001, 0.3564, 0.0782, 1),
)


def cooked(shape: Any, material: Any) -> Any:
    """What the engine collides with, face by face."""
    vertices, normals = [], []
    for face in shape.triangles:
        a, b, c = (shape.vertices[corner] * shape.scale for corner in face)
        normal = np.cross(b - a, c - a)
        vertices += [a, b, c]
        normals += [normal / np.linalg.norm(normal)] * 3
    faces = np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
    corners, facing = np.array(vertices, np.float32), np.array(normals, np.float32)
    return sapien.render.RenderShapeTriangleMesh(corners, faces, facing, np.zeros((0, 2), np.float32), material)


def drawn(scene: sapien.Scene, builder: Any, kind: str, color: tuple[float, ...], pose: sapien.Pose) -> None:
    """Builds an actor, and draws its collision shapes as SAPIEN's viewer does."""
    builder.set_physx_body_type(kind)
    builder.initial_pose = pose
    entity = builder.build()
    material, body = sapien.render.RenderMaterial(base_color=list(color)), sapien.render.RenderBodyComponent()
    for shape in entity.components[0].collision_shapes:
        match type(shape).__name__.removeprefix("PhysxCollisionShape"):
            case "Box":
                made = sapien.render.RenderShapeBox(shape.half_size, material)
            case "Sphere":
                made = sapien.render.RenderShapeSphere(shape.radius, material)
            case "Capsule":
                made = sapien.render.RenderShapeCapsule(shape.radius, shape.half_length, material)
            case "Cylinder":
                made = sapien.render.RenderShapeCylinder(shape.radius, shape.half_length, material)
            case "Plane":
                made = sapien.render.RenderShapePlane([1, 1e4, 1e4], material)
            case _:
                made = cooked(shape, material)
        made.local_pose = shape.local_pose
        body.attach(made)
    entity.add_component(body)


def test_what_collides_is_drawn_as_the_engine_has_it() -> None:
    mug, gem, turn = str(ASSETS / "mug.obj"), str(ASSETS / "gem.stl"), [0.9238795, 0, 0.3826834, 0]
    visuals = [{"type": "sphere", "radius": 0.9, "color": [0, 1, 0]}]
    primitives = [
        {"type": "box", "half_size": [0.1, 0.2, 0.05]},
        {"type": "sphere", "radius": 0.12, "pose": [0.3, 0, 0]},
        {"type": "capsule", "radius": 0.05, "half_length": 0.1, "pose": {"p": [0, 0.4, 0.1], "q": turn}, "axis": "x"},
        {"type": "cylinder", "radius": 0.05, "half_length": 0.2, "pose": [0, -0.4, 0.1], "axis": "x"},
    ]
    entities = {
        "floor": {"body_type": "static", "collisions": [{"type": "plane"}], "visuals": visuals},
        "body": {"pose": [0, 0, 0.5], "collisions": primitives, "visuals": visuals},
        "mug": {
            "body_type": "kinematic",
            "pose": [0.3, 0.3, 0.3],
            "collisions": [{"type": "convex_mesh", "file": mug, "scale": [2, 2, 3]}],
        },
        "gem": {
            "body_type": "static",
            "pose": [-0.2, 0.4, 0.2],
            "collisions": [{"type": "triangle_mesh", "file": gem, "scale": [2, 3, 2]}],
        },
        "seen": {"body_type": "none", "visuals": visuals},
    }
    source = document(entities)
    found = render_scene(source, camera="eye", collision=True, allow_outside_assets=True)
    hand = ByHand()
    builder = hand.scene.create_actor_builder()
    builder.add_plane_collision(sapien.Pose(q=[0.7071068, 0, -0.7071068, 0]))
    drawn(hand.scene, builder, "static", STATIC, sapien.Pose())
    builder = hand.scene.create_actor_builder()
    builder.add_box_collision(half_size=(0.1, 0.2, 0.05))
    builder.add_sphere_collision(sapien.Pose([0.3, 0, 0]), radius=0.12)
    builder.add_capsule_collision(sapien.Pose([0, 0.4, 0.1], turn), radius=0.05, half_length=0.1)
    builder.add_cylinder_collision(sapien.Pose([0, -0.4, 0.1]), radius=0.05, half_length=0.2)
    drawn(hand.scene, builder, "dynamic", DYNAMIC, sapien.Pose([0, 0, 0.5]))
    builder = hand.scene.create_actor_builder()
    builder.add_convex_collision_from_file(mug, scale=(2, 2, 3))
    drawn(hand.scene, builder, "kinematic", KINEMATIC, sapien.Pose([0.3, 0.3, 0.3]))
    builder = hand.scene.create_actor_builder()
    builder.add_nonconvex_collision_from_file(gem, scale=(2, 3, 2))
    drawn(hand.scene, builder, "static", STATIC, sapien.Pose([-0.2, 0.4, 0.2]))
    theirs = hand.picture(eye_pose(document({"cube": CUBE})))
    assert np.array_equal(pixels(found), theirs)
    names = {
        row.name
        for row in render_scene(
            source, camera="eye", collision=True, what="segmentation", allow_outside_assets=True
        ).legend()
    }
    assert names == {"floor", "body", "mug", "gem"}


def test_links_are_drawn_as_they_collide_where_their_joints_put_them() -> None:
    arm = {
        "root": {
            "name": "base",
            "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}],
            "children": [
                {
                    "name": "tip",
                    "joint": {"name": "lift", "type": "prismatic", "axis": [0, 0, 1], "limits": [0, 1]},
                    "collisions": [{"type": "box", "half_size": [0.05, 0.05, 0.1]}],
                    "visuals": [{"type": "sphere", "radius": 0.4}],
                }
            ],
        },
        "fix_root_link": True,
        "qpos": {"lift": 0.5},
    }
    found = render_scene(document({"arm": arm}), camera="eye", collision=True)
    hand = ByHand()
    for half, z in ((0.1, 0.0), (0.05, 0.5)):
        builder = hand.scene.create_actor_builder()
        builder.add_box_visual(
            half_size=(half, half, 0.1), material=sapien.render.RenderMaterial(base_color=list(LINK))
        )
        builder.initial_pose = sapien.Pose([0, 0, z])
        builder.build_kinematic()
    assert np.array_equal(pixels(found), hand.picture(eye_pose(document({"cube": CUBE}))))


def test_a_camera_that_was_taken_out_takes_no_picture_and_one_that_frames_comes_back() -> None:
    with load_scene(document({"cube": CUBE}), render=True) as batch:
        eye, framing = batch.cameras["eye"], batch.framed(40, 30)
        before = framing.capture("color")["color"]
        for camera in (eye, framing):
            camera.retire(0)
            camera.retire(0)
        assert batch.scenes[0].render_system.cameras == []
        assert np.array_equal(framing.capture("color")["color"], before)
        with pytest.raises(RuntimeError, match="'eye' was removed from scene 0"):
            eye.capture("color")
        with pytest.raises(ValueError, match="1 to 16384 pixels"):
            batch.framed(0, 10)
