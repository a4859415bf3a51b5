"""MJCF files as editable scenes: what is built of the bodies written equals what is built of the file itself."""

from __future__ import annotations

import os
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

import scenecc
from scenecc.backends.sapien.measure import measure_bodies
from scenecc.importers.import_scene import import_scene
from scenecc.importers.imported_scene import LOSSES
from tests.fidelity.mjcf_cases import CASES, COMMON

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredShape

pytest.importorskip("mujoco")

QUICK = ("several joints", "several robots and bodies", "texture")

_JOINT_FIELDS = (
    *("limits", "friction", "armature", "max_velocity", "stiffness", "damping", "force_limit", "drive_target"),
    *("drive_velocity_target", "qpos"),
)

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"

WHEELS = Path(os.environ.get("SCENECC_WHEELS", "nowhere"))
FILES = sorted(file for package in ("dm_control", "robosuite") for file in (WHEELS / package).rglob("*.xml"))


def imported(file: Path, scene: Path, **options: Any) -> Any:
    import_scene(file, scene, allow=LOSSES, asset_roots=[file.parent], **options)
    return scenecc.load_scene(scene, render=False)


def assert_same_import(file: Path, folder: Path) -> None:
    """Compares everything that moves and collides, and the poses at random positions of the joints."""
    with ExitStack() as stack:
        kept = stack.enter_context(imported(file, folder / "kept.yaml", keep_file=True))
        written = stack.enter_context(imported(file, folder / "written.yaml"))
        pairs = list(zip(_bodies(kept), _bodies(written), strict=True))
        for (one, _, first), (two, _, second) in pairs:
            _assert_same_body(first, second, f"{one} and {two}")
        colliding = [(owner, a, b) for (_, owner, a), (_, _, b) in pairs if a.shapes][:40]
        for number, (owner, first, second) in enumerate(colliding):
            for other, third, fourth in colliding[number + 1 :]:
                static = first.body_type == third.body_type == "static"
                if not static and not (owner is other and _are_neighbours(owner, first, third)):
                    assert _touching(first, third) == _touching(second, fourth), (first.name, third.name)
        rng = np.random.default_rng(0)
        for old, new in zip(kept.articulations.values(), written.articulations.values(), strict=True):
            one, two = old.objs[0], new.objs[0]
            low, high = np.clip(one.qlimits, -1, 1).T
            one.qpos = two.qpos = rng.uniform(low, high)
            for a, b in zip(one.links, two.links, strict=True):
                assert_allclose(a.entity_pose.p, b.entity_pose.p, atol=2e-5, err_msg=a.name)
                assert abs(np.dot(a.entity_pose.q, b.entity_pose.q)) == pytest.approx(1, abs=1e-5), a.name


def _bodies(batch: Any) -> Iterator[tuple[str, MeasuredEntity, MeasuredBody]]:
    """Articulations first, as in a file; a body that is only visible may have another type."""
    (scene,) = measure_bodies(batch).scenes
    for entity in scene.entities:
        for body in entity.bodies:
            yield f"{entity.entity.name}/{body.name}", entity, body


def _assert_same_body(first: MeasuredBody, second: MeasuredBody, name: str) -> None:
    if first.shapes:
        assert first.body_type == second.body_type, name
    assert_allclose(first.pose[:3], second.pose[:3], atol=1e-5, err_msg=name)
    assert abs(np.dot(first.pose[3:], second.pose[3:])) == pytest.approx(1, abs=1e-6), name
    assert Counter(map(_shape_facts, first.shapes)) == Counter(map(_shape_facts, second.shapes)), name
    assert len(first.body.visuals) == len(second.body.visuals), name
    if first.mass is not None and first.body_type == "dynamic":
        assert second.mass is not None
        assert_allclose(first.mass.mass, second.mass.mass, rtol=1e-6, err_msg=name)
        assert_allclose(first.mass.com[:3], second.mass.com[:3], atol=1e-6, err_msg=name)
        tensors = [_tensor(one.mass.com[3:], one.mass.inertia) for one in (first, second) if one.mass is not None]
        assert_allclose(*tensors, atol=1e-5 * np.abs(tensors[0]).max(), err_msg=name)
    one, two = first.joint, second.joint
    if one is None or one.type == "fixed":
        assert two is None or two.type == "fixed", name
        return
    assert two is not None
    assert one.type == two.type
    for field in _JOINT_FIELDS:
        assert_allclose(getattr(one, field), getattr(two, field), rtol=1e-6, atol=1e-6, err_msg=f"{name} {field}")


def _shape_facts(shape: MeasuredShape) -> tuple[Any, ...]:
    """Kind, sizes, place and friction. A round solid may be turned over, and a sphere in any way."""
    x, y, z, *q = np.round(np.array(shape.pose, np.float64), 4) + 0.0
    turn: Any = ()
    if shape.kind not in {"sphere", "capsule", "cylinder"}:
        turn = tuple(np.abs(q).round(3).tolist())
    sizes = tuple(float(f"{size:.5g}") for size in shape.sizes)
    return shape.kind, sizes, (x, y, z), turn, round(shape.static_friction, 5), round(shape.dynamic_friction, 5)


def _tensor(q: Any, moments: Any) -> Any:
    w, x, y, z = q
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return turn @ np.diag(moments) @ turn.T


def _are_neighbours(owner: MeasuredEntity, first: MeasuredBody, second: MeasuredBody) -> bool:
    """Whether one is the parent of the other; PhysX does not let these collide."""
    bodies = list(owner.bodies)
    return bodies.index(first) == second.parent or bodies.index(second) == first.parent


def _touching(first: MeasuredBody, second: MeasuredBody) -> set[bool]:
    """Whether shapes of two bodies collide by their integers."""
    found: set[bool] = set()
    for a in {shape.groups for shape in first.shapes}:
        for b in {shape.groups for shape in second.shapes}:
            ignored = bool(a[2] & b[2]) and a[3] & 0xFFFF == b[3] & 0xFFFF
            found.add(bool(a[0] & b[1] or a[1] & b[0]) and not ignored)
    return found


def _write(case: str, folder: Path) -> Path:
    for name in ("parts", "meshes"):
        (folder / name).mkdir()
    (folder / "parts/common.xml").write_text(COMMON)
    (folder / "meshes/rock.obj").write_text("mtllib gone.mtl\n" + TETRAHEDRON)
    Image.new("RGB", (4, 4)).save(folder / "wood.png")
    file = folder / "world.xml"
    file.write_text(CASES[case])
    return file


@pytest.mark.parametrize("case", QUICK)
def test_bodies_written_equal_those_of_the_file(case: str, tmp_path: Path) -> None:
    assert_same_import(_write(case, tmp_path), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("case", [case for case in CASES if case not in QUICK])
def test_bodies_written_equal_those_of_any_file(case: str, tmp_path: Path) -> None:
    assert_same_import(_write(case, tmp_path), tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not FILES, reason="SCENECC_WHEELS names no folder with dm_control or robosuite")
@pytest.mark.parametrize("file", FILES, ids=lambda file: "-".join(file.parts[-3:]))
def test_bodies_written_equal_those_of_files_in_wheels(file: Path, tmp_path: Path) -> None:
    try:
        import_scene(file, tmp_path / "first.yaml", allow=LOSSES, asset_roots=[WHEELS], keep_file=True)
    except scenecc.SceneError:
        pytest.skip("the file itself cannot be built")
    assert_same_import(file, tmp_path)
