"""Files that change on disk while the process lives, and parts of a file that SAPIEN would leave out."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from fidelity.hand import component
from plugins.mesh_files import checked
from unit.assets.test_assets import png

from scenecc.backends.sapien import assets, engine, instantiate
from scenecc.backends.sapien.engine import EngineFailure, physx, sapien
from scenecc.diagnostics import Sink
from scenecc.plan import CollisionShape, ConvexMesh, ConvexParts, ScenePlan, TriangleMesh, constant
from scenecc.plan.body import AssetFile

PlanOf = Callable[..., ScenePlan]


def shape(geometry: type, **more: Any) -> CollisionShape:
    return CollisionShape(geometry(constant(0, int), constant([1, 1, 1]), **more))


def extent(plan: ScenePlan) -> float:
    """Largest x of the built shape's vertices."""
    sink = Sink()
    batch = instantiate(plan, sink, render=False)
    assert batch is not None, sink.diagnostics()
    (made,) = component(batch, "body").collision_shapes
    return float(made.vertices[:, 0].max())


def write(path: Path, half: float, *, keep_times: bool = False) -> None:
    before = path.stat() if path.exists() else None
    trimesh.creation.box((2 * half, 1, 1)).export(path)
    if keep_times and before is not None:
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


@pytest.mark.parametrize("geometry", [ConvexMesh, ConvexParts, TriangleMesh])
def test_a_rewritten_mesh_is_read_again(geometry: type, tmp_path: Path, plan_of_shapes: PlanOf) -> None:
    path = tmp_path / "box.obj"
    plan = plan_of_shapes(shape(geometry), files=(path,), kind="static")
    for half in (0.25, 0.5, 0.75):
        write(path, half)
        assert extent(plan) == half


def test_a_rewritten_mesh_with_its_old_date_and_size_is_read_again(tmp_path: Path, plan_of_shapes: PlanOf) -> None:
    path = tmp_path / "box.obj"
    plan = plan_of_shapes(shape(ConvexMesh), files=(path,))
    write(path, 0.25)
    assert extent(plan) == 0.25
    write(path, 0.75, keep_times=True)
    assert extent(plan) == 0.75


def test_a_rewritten_mesh_that_other_code_had_read_is_read_again(tmp_path: Path, plan_of_shapes: PlanOf) -> None:
    path = tmp_path / "box.obj"
    write(path, 0.25)
    other = physx.PhysxCollisionShapeConvexMesh(str(path), [1, 1, 1], physx.get_default_material())
    write(path, 0.5)
    assert extent(plan_of_shapes(shape(ConvexMesh), files=(path,))) == 0.5
    assert other.vertices[:, 0].max() == 0.25


def test_a_symlink_to_another_mesh_is_read_again(tmp_path: Path, plan_of_shapes: PlanOf) -> None:
    first, second, link = tmp_path / "a.obj", tmp_path / "b.obj", tmp_path / "box.obj"
    write(first, 0.25)
    write(second, 0.5)
    plan = plan_of_shapes(shape(ConvexMesh), files=(link,))
    for target, half in ((first, 0.25), (second, 0.5)):
        link.unlink(missing_ok=True)
        link.symlink_to(target)
        assert extent(plan) == half


def test_a_mesh_that_did_not_change_stays_cooked(
    tmp_path: Path, plan_of_shapes: PlanOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "box.obj"
    write(path, 0.25)
    plan = plan_of_shapes(shape(ConvexMesh), files=(path,))
    extent(plan)
    monkeypatch.setattr(assets.MESH_CACHE, "_clear", lambda: pytest.fail("the cache was emptied"))
    assert extent(plan) == 0.25


def test_files_from_before_the_process_are_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "box.obj"
    write(path, 0.25)
    cleared: list[int] = []
    started = assets._process_start()
    assert 0 < started < path.stat().st_mtime_ns
    assets.FileCache(lambda: cleared.append(1)).refresh([AssetFile("box.obj", path)])
    assert cleared == [1]
    later = path.stat().st_ctime_ns + 10 * assets._START_MARGIN
    monkeypatch.setattr(assets, "_process_start", lambda: later)
    assets.FileCache(lambda: cleared.append(2)).refresh([AssetFile("box.obj", path)])
    assert cleared == [1]


@pytest.mark.parametrize("name", ["thing.obj", "thing.mtl", "wood grain.png"])
def test_a_changed_buffer_of_a_mesh_is_read_again(name: str, tmp_path: Path) -> None:
    write(tmp_path / "thing.obj", 0.25)
    own = (tmp_path / "thing.obj").read_text()
    (tmp_path / "thing.obj").write_text(f"mtllib thing.mtl\n{own}")
    (tmp_path / "thing.mtl").write_text("newmtl a\nmap_Kd -s 1 1 1 wood grain.png\n")
    (tmp_path / "wood grain.png").write_bytes(png())
    file = checked(tmp_path / "thing.obj", "visual")
    before = assets.file_signature(file)
    assert len(before) == 3
    assets.check_files_unchanged([file])
    (tmp_path / name).write_bytes((tmp_path / name).read_bytes() + b"\n")
    assert assets.file_signature(file) != before
    with pytest.raises(EngineFailure, match=f"{name}' changed while the scene was built"):
        assets.check_files_unchanged([file])


def parts_with_a_speck(path: Path) -> Path:
    """A box, and a part so small that PhysX refuses to cook it."""
    good = trimesh.creation.box((1, 1, 1))
    corners = np.vstack([np.zeros((1, 3)), 1e-7 * np.eye(3)])
    speck = trimesh.Trimesh(corners, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]], process=False)
    trimesh.util.concatenate([good, speck]).export(path)
    return path


def test_a_mesh_part_that_sapien_leaves_out_is_reported(
    tmp_path: Path, plan_of_shapes: PlanOf, capfd: pytest.CaptureFixture[str]
) -> None:
    """Its loader drops parts that cannot be cooked, with a line in its log; asked again, without one."""
    plan = plan_of_shapes(shape(ConvexParts), files=(parts_with_a_speck(tmp_path / "parts.ply"),))
    for _ in range(2):
        sink = Sink()
        assert instantiate(plan, sink, render=False) is None
        (told,) = sink.diagnostics()
        assert told.code == "SC801"
        assert "1 of the mesh's parts" in told.message
    assert "component" in capfd.readouterr().err


@pytest.mark.parametrize("level", ["error", "critical", "off"])
def test_a_dropped_part_is_seen_where_the_engine_is_silenced(
    level: str, tmp_path: Path, plan_of_shapes: PlanOf, capfd: pytest.CaptureFixture[str]
) -> None:
    plan = plan_of_shapes(shape(ConvexParts), files=(parts_with_a_speck(tmp_path / "parts.ply"),))
    sink = Sink()
    sapien.set_log_level(level)
    try:
        assert instantiate(plan, sink, render=False) is None
        with tempfile.TemporaryFile() as file, engine._redirect_standard_error(file.fileno()):
            assert engine._log_level(file) == level, "as the user has set it"
    finally:
        sapien.set_log_level("warn")
    assert "1 of the mesh's parts" in sink.diagnostics()[0].message
    assert not capfd.readouterr().err, "the user has asked for silence"


def test_a_dropped_part_is_seen_without_a_standard_error(tmp_path: Path, plan_of_shapes: PlanOf) -> None:
    plan = plan_of_shapes(shape(ConvexParts), files=(parts_with_a_speck(tmp_path / "parts.ply"),))
    sink = Sink()
    kept = os.dup(2)
    os.close(2)
    try:
        assert instantiate(plan, sink, render=False) is None
        with pytest.raises(OSError, match="descriptor"):
            os.fstat(2)
    finally:
        os.dup2(kept, 2)
        os.close(kept)
    assert "1 of the mesh's parts" in sink.diagnostics()[0].message
