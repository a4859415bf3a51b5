# A script of plain SAPIEN calls, written by scenecc.
#
# decomposed: 2 parallel scenes.
#
# Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.
# It finds its files relative to its own folder: move it together with them, or emit it again.

import atexit
import functools
import shutil
import tempfile
from pathlib import Path

import coacd
import sapien
import trimesh
from sapien import physx


@functools.cache
def convex_parts(mesh: Path, **parameters: object) -> str:
    """Returns a file with CoACD's convex parts of a mesh, which is deleted at exit."""
    coacd.set_log_level("error")
    whole = trimesh.load(mesh, force="mesh")
    parts = coacd.run_coacd(coacd.Mesh(whole.vertices, whole.faces), **parameters)
    joined = trimesh.util.concatenate([trimesh.Trimesh(*part) for part in parts])
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    file = Path(folder) / "parts.ply"
    joined.export(file)
    return str(file)


HERE = Path(__file__).resolve().parent
BOWL = HERE / "../../scenes/assets/bowl.obj"
FILES = [BOWL]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 2 parallel scenes. `render`: also build visuals."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    scenes: list[sapien.Scene] = []
    for _ in range(2):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]))
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]),
                scale=[10, 10, 10],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # bowl
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_multiple_convex_collisions_from_file(
            filename=convex_parts(
                BOWL,
                threshold=0.3,
                max_convex_hull=4,
                preprocess_mode="off",
                preprocess_resolution=30,
                resolution=1000,
                mcts_nodes=10,
                mcts_iterations=60,
                mcts_max_depth=2,
                pca=False,
                merge=True,
                seed=1,
            ),
        )
        builder.initial_pose = sapien.Pose([0, 0, 0.3])
        builder.build(name="bowl")

    # ball
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.02)
        builder.initial_pose = sapien.Pose([0, 0, 0.5])
        builder.build(name="ball")

    return scenes


def main() -> None:
    """Simulates 100 steps and prints the poses of all entities in the first scene."""
    scenes = build_scenes()
    for _ in range(100):
        for scene in scenes:
            scene.step()
    for entity in scenes[0].entities:
        print(entity.name, entity.pose.p, entity.pose.q)


if __name__ == "__main__":
    main()
