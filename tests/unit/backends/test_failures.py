"""What the engine or the machine cannot do is told at the shape that asked, and nothing is left behind."""

from __future__ import annotations

import builtins
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from scenecc.backends.sapien import build, instantiate
from scenecc.backends.sapien.engine import physx
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.geometry.ply import encode_ply
from scenecc.plan import (
    BodyStructure,
    Box,
    CoacdParams,
    CollisionShape,
    Constraint,
    ConvexMesh,
    ConvexParts,
    Entity,
    Mount,
    Physics,
    ScenePlan,
    TriangleMesh,
    Weld,
    constant,
    per_scene,
)

PlanOf = Callable[..., ScenePlan]


def mesh(geometry: type, index: int = 0, **more: Any) -> CollisionShape:
    origin = Origin("scene.yaml", ("entities", "body", "shapes", index))
    return CollisionShape(geometry(constant(index, int), constant([1, 1, 1]), **more), origin=origin)


def complaints(plan: ScenePlan, **options: Any) -> list[Diagnostic]:
    sink = Sink()
    batch = instantiate(plan, sink, **{"render": False, **options})
    assert batch is None
    assert sink.failed
    return sink.diagnostics()


@pytest.fixture
def text(tmp_path: Path) -> Path:
    path = tmp_path / "notes.obj"
    path.write_text("these are words, no mesh\n")
    return path


@pytest.mark.parametrize("geometry", [ConvexMesh, ConvexParts, TriangleMesh])
@pytest.mark.parametrize("there", [True, False])
def test_a_mesh_that_cannot_be_cooked_is_reported(
    geometry: type, there: bool, text: Path, tmp_path: Path, plan_of_shapes: PlanOf
) -> None:
    """SAPIEN's own builder builds a milligram without a shape here."""
    path = text if there else tmp_path / "missing.obj"
    (told,) = complaints(plan_of_shapes(mesh(geometry), files=(path,), kind="static"))
    assert (told.code, told.path) == ("SC801", "entities.body.shapes[0]" + ".file" * there)
    assert ("SAPIEN cannot read" if there else f"no file '{path}'") in told.message


def test_all_meshes_that_cannot_be_cooked_are_reported(text: Path, tmp_path: Path, plan_of_shapes: PlanOf) -> None:
    other = tmp_path / "others.obj"
    other.write_text("more words\n")
    told = complaints(plan_of_shapes(mesh(ConvexMesh, 0), mesh(ConvexMesh, 1), files=(text, other)))
    assert [d.path for d in told] == ["entities.body.shapes[0].file", "entities.body.shapes[1].file"]


def test_nothing_is_built_if_a_mesh_fails(text: Path, plan_of_shapes: PlanOf, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "new_scene", lambda *_, **__: pytest.fail("a scene was made"))
    (told,) = complaints(plan_of_shapes(mesh(ConvexMesh), files=(text,)))
    assert told.code == "SC801"


def test_a_mesh_that_fails_in_some_scenes_is_reported(text: Path, tmp_path: Path) -> None:
    good = tmp_path / "good.obj"
    good.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")
    origin = Origin("scene.yaml", ("entities", "body"))
    shape = CollisionShape(ConvexMesh(per_scene([0, 1], np.int64), constant([1, 1, 1])), origin=origin)
    entity = Entity("body", (0, 1), constant([0, 0, 0, 1, 0, 0, 0]), (BodyStructure("dynamic", (shape,)),))
    from scenecc.plan.body import AssetFile

    files = (AssetFile("good.obj", good), AssetFile("notes.obj", text))
    plan = ScenePlan("test", 2, (entity,), Physics(), files=files)
    assert [d.code for d in complaints(plan)] == ["SC801"]
    batch = instantiate(plan, Sink(), render=False, scene_idxs=[0])
    assert batch is not None


def test_a_shape_refused_during_a_build_clears_all_scenes(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.backends.sapien import builder

    made: list[Any] = []
    new_scene = build.new_scene
    monkeypatch.setattr(build, "new_scene", lambda *a, **k: made.append(new_scene(*a, **k)) or made[-1])
    caller = builder.PreparedShape

    def steps(make: Any, *rest: Any) -> Any:
        def refuse(row: int) -> Any:
            if row == 2:
                raise RuntimeError("out of luck")
            return make(row)

        return caller(refuse, *rest)

    monkeypatch.setattr(builder, "PreparedShape", steps)
    (told,) = complaints(plan)
    assert (told.code, told.path) == ("SC801", "entities.table.shapes[0]")
    assert "out of luck" in told.message
    assert len(made) == 4
    assert all(scene.entities == [] for scene in made)


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
@pytest.mark.parametrize(
    ("module", "step"),
    [(build, "ConstraintSet"), (build, "LightsAndCameras"), (build, "audit_scenes"), (build, "SceneBatch")],
)
def test_an_error_after_the_bodies_are_built_clears_all_scenes(
    module: ModuleType, step: str, error: type[BaseException], plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Any] = []
    new_scene = build.new_scene
    monkeypatch.setattr(build, "new_scene", lambda *a, **k: made.append(new_scene(*a, **k)) or made[-1])

    def stop(*_: object, **__: object) -> None:
        assert all(len(scene.entities) == len(plan.entities) for scene in made)
        raise error

    monkeypatch.setattr(module, step, stop)
    tied = replace(plan, constraints=(Constraint("tie", (0,), Weld(), Mount("cube")),))
    with pytest.raises(error):
        instantiate(tied, Sink(), render=False)
    assert len(made) == plan.num_scenes
    assert all(scene.entities == [] for scene in made)


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("static", {"linear_damping": constant(0.5)}),
        ("static", {"mass": constant(1.0)}),
        ("none", {"linear_damping": constant(0.5)}),
        ("none", {"mass": constant(1.0)}),
        ("none", {"collision_groups": constant([1, 1, 0, 0], np.int64)}),
        ("none", {"collisions": (CollisionShape(Box(constant([1, 1, 1]))),)}),
        ("dynamic", {"solver_position_iterations": constant(-1, np.int64)}),
    ],
)
def test_fields_that_a_body_type_lacks_are_refused(kind: Any, said: dict[str, Any], plan_of_shapes: PlanOf) -> None:
    """Scene files are checked for this before; a plan may come from elsewhere."""
    plan = plan_of_shapes(kind=kind)
    (entity,) = plan.entities
    body = replace(entity.structures[0], **said)
    (told,) = complaints(replace(plan, entities=(replace(entity, structures=(body,)),)))
    assert (told.code, told.path) == ("SC808", "entities.body")


def test_without_a_render_device_visuals_are_refused_or_skipped(
    plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(build, "render_problem", lambda: "failed to find a rendering device")
    (told,) = complaints(plan, render=True)
    assert told.code == "SC803"
    batch = instantiate(plan, Sink(), render=None)
    assert batch is not None
    assert not batch.render


def test_a_missing_sapien_is_reported(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def absent(name: str, *rest: Any) -> Any:
        if name == "sapien" or name.startswith("scenecc.backends.sapien.engine"):
            raise ModuleNotFoundError("No module named 'sapien'")
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", absent)
    (told,) = complaints(plan)
    assert told.code == "SC805"
    assert "No module named 'sapien'" in told.message
    assert "pip install" in (told.hint or "")


@pytest.mark.parametrize(
    ("version", "good"), [("3.0.3", True), ("3.0.4.dev1", True), ("3.0.2", False), ("2.2.2", False), ("3.1.0", False)]
)
def test_an_unsupported_version_of_sapien_is_reported(
    version: str, good: bool, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sapien

    monkeypatch.setattr(sapien, "__version__", version)
    sink = Sink()
    assert (instantiate(plan, sink, render=False) is not None) == good
    assert [d.code for d in sink.diagnostics()] == ([] if good else ["SC805"])


def test_importing_the_backend_loads_no_engine_and_warns_of_nothing() -> None:
    code = (
        "import sys, warnings; warnings.simplefilter('error')\n"
        "import scenecc.backends.sapien as backend\n"
        "assert 'sapien' not in sys.modules\n"
        "backend.SceneBatch\n"
        "assert 'sapien' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_missing_coacd_is_reported(
    text: Path, plan_of_shapes: PlanOf, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from scenecc.backends.sapien import assets

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(assets.importlib.util, "find_spec", lambda name: None)
    (told,) = complaints(plan_of_shapes(mesh(ConvexParts, coacd=CoacdParams()), files=(text,)))
    assert (told.code, told.path) == ("SC806", "entities.body.shapes[0]")
    assert "[convex]" in (told.hint or "")


def test_a_failure_of_coacd_is_reported(
    text: Path, plan_of_shapes: PlanOf, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("coacd")
    cache = tmp_path / "cache"
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    (told,) = complaints(plan_of_shapes(mesh(ConvexParts, coacd=CoacdParams(preprocess_mode="on")), files=(text,)))
    assert told.code == "SC806"
    assert [path for path in cache.rglob("*") if path.is_file()] == []


def test_a_coacd_cache_that_cannot_be_written_is_reported(
    text: Path, plan_of_shapes: PlanOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coacd")
    monkeypatch.setenv("XDG_CACHE_HOME", str(text))
    (told,) = complaints(plan_of_shapes(mesh(ConvexParts, coacd=CoacdParams()), files=(text,)))
    assert told.code == "SC806"
    assert "XDG_CACHE_HOME" in (told.hint or "")


def test_ply_of_parts_never_starts_like_a_line_break(tmp_path: Path) -> None:
    """SAPIEN's reader would end the process on such a file."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]], dtype="<f4")
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    for byte in b"\n\r":
        vertices[0, 0] = np.frombuffer(bytes([byte, 0, 0, 61]), "<f4")[0]
        path = tmp_path / f"{byte}.ply"
        path.write_bytes(encode_ply(vertices, faces))
        (part,) = physx.PhysxCollisionShapeConvexMesh.load_multiple(str(path), (1, 1, 1), physx.PhysxMaterial(0, 0, 0))
        assert {*map(tuple, part.vertices)} == {*map(tuple, vertices)}


def test_the_worker_is_only_asked_in_json(tmp_path: Path) -> None:
    """Nothing of a mesh's name reaches a shell or an argument list."""
    pytest.importorskip("coacd")
    name = tmp_path / "$(touch pwned).obj"
    name.write_text("")
    request = json.dumps({"mesh": str(name), "arguments": {}, "output": str(tmp_path / "out.ply")})
    done = subprocess.run(
        [sys.executable, "-m", "scenecc.backends.sapien.coacd_worker"],
        input=request,
        text=True,
        capture_output=True,
        check=False,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode != 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [name.name]


def test_no_warning_reaches_the_user(plan: ScenePlan) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        batch = instantiate(plan, Sink())
    assert batch is not None
