"""Scenes with an MJCF against the builders of ManiSkill's loader: every property of what is built, and 200 steps."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.mjcf_cases import CASES
from fidelity.mjcf_records import loaded
from fidelity.test_mjcf import shipped
from sapien import physx

from scenecc import load_scene

pytestmark = pytest.mark.maniskill

STEPS = 200
POSE = [0.3, -0.2, 1.5, 0.9238795, 0, 0, 0.3826834]
BUILT = (
    "hinge",
    "slide",
    "several joints",
    "fixed by a class's axis",
    "free with joints inside",
    "branches",
    "contacts switched off",
    "capsule between points",
    "friction",
    "mesh",
    "classes",
    "thirty-two bonds",
)


def by_loader(path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The file by ManiSkill's loader, shown to nobody, and what a person calls that builds it."""
    articulations, actors = loaded(path, monkeypatch)
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    filled = [actor for actor in actors if actor.collision_records or actor.visual_records]
    many = len(articulations) + len(filled) > 1
    for builder in articulations:
        builder.set_scene(scene)
        builder.set_initial_pose(sapien.Pose(POSE[:3], POSE[3:]))
        for link in builder.link_builders:
            link.visual_records = []
        built = builder.build()
        root = builder.link_builders[0].name
        built.name = f"robot/{root}" if many else "robot"
        low, high = np.array([joint.limits[0] for joint in built.active_joints]).reshape(-1, 2).T
        # A joint starts at 0, or at the limit that is nearest to it.
        built.set_qpos(np.clip(np.zeros(len(low), np.float32), low, high))
    names = iter(name_of(path, len(filled)))
    for builder in filled:
        builder.set_scene(scene)
        builder.visual_records = []
        builder.set_initial_pose(sapien.Pose(POSE[:3], POSE[3:]))
        builder.build(name=f"robot/{next(names)}" if many else "robot")
    return scene


def name_of(path: Path, count: int) -> list[str]:
    """The names of bodies that stand still, which the loader does not tell."""
    from fidelity.mjcf_records import read

    description, _ = read(path)
    assert description is not None
    names = [robot.links[0].name for robot in description.robots if robot.body_type is not None]
    assert len(names) == count
    return names


def compared(path: Path, uri: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hand = by_loader(path, monkeypatch)
    batch = load_scene(
        {
            "scenecc": 1,
            "entities": {"robot": {"mjcf": uri, "loader": "maniskill", "pose": {"p": POSE[:3], "q": POSE[3:]}}},
        },
        asset_roots=[folder],
        render=False,
    )
    assert_same_scene(batch.scenes[0], hand)
    assert_same_trajectory([batch.scenes[0]], [hand], steps=STEPS)


@pytest.mark.parametrize("path", shipped(), ids=lambda path: path.stem)
def test_a_file_of_maniskill_moves_as_its_loader_builds_it(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = path.as_posix().rsplit("/mani_skill/", 1)[1]
    compared(path, f"pkg://mani_skill/{inner}", tmp_path, monkeypatch)


@pytest.mark.parametrize("name", BUILT)
def test_a_feature_moves_as_maniskills_loader_builds_it(
    name: str, tmp_path: Path, meshes: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "rock.obj").write_bytes(meshes["rock"].read_bytes())
    path = tmp_path / "robot.xml"
    path.write_text(CASES[name])
    compared(path, "asset://robot.xml", tmp_path, monkeypatch)


class _Builders:
    """Gives a loader the builders of a scene."""

    def __init__(self, scene: Any) -> None:
        self.create_articulation_builder = scene.create_articulation_builder
        self.create_actor_builder = scene.create_actor_builder


@pytest.mark.render
@pytest.mark.parametrize("path", shipped(), ids=lambda path: path.stem)
def test_a_file_of_maniskill_is_seen_as_its_loader_shows_it(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mani_skill.utils.building import _mjcf_loader as module

    inner = path.as_posix().rsplit("/mani_skill/", 1)[1]
    robot = {"mjcf": f"pkg://mani_skill/{inner}", "loader": "maniskill"}
    batch = load_scene({"scenecc": 1, "entities": {"robot": robot}}, render=True)
    monkeypatch.setattr(module, "DEFAULT_MJCF_OPTIONS", {"contact": True})
    scene: Any = sapien.Scene()
    loader = module.MJCFLoader()
    loader.set_scene(_Builders(scene))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        (builder,), *_ = loader.parse(str(path))
    (ours,) = next(iter(batch.articulations.values())).objs
    seen = 0
    for mine, theirs in zip(ours.links, builder.build().links, strict=True):
        shown: list[Any] = [
            link.entity.find_component_by_type(sapien.render.RenderBodyComponent) for link in (mine, theirs)
        ]
        assert (shown[0] is None) == (shown[1] is None)
        if shown[0] is not None:
            for one, other in zip(shown[0].render_shapes, shown[1].render_shapes, strict=True):
                assert looks(one) == looks(other)
                seen += 1
    assert seen > 0


def looks(shape: Any) -> list[Any]:
    """What can be read of a shape that is seen."""
    names = ("base_color", "emission", "specular", "roughness", "metallic", "transmission", "ior")
    pose = [*shape.local_pose.p.tolist(), *shape.local_pose.q.tolist()]
    return [type(shape), shape.name, pose, *(getattr(shape.material, name) for name in names)]
