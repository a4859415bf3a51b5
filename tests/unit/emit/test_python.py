from __future__ import annotations

import ast
import dataclasses
import inspect
import io
import subprocess
import sys
import tokenize
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from plugins.nightly import assert_took, examples
from plugins.plan_strategy import plans
from plugins.sample_plans import FLAG, INT, SAMPLES, entity, look, pose, rubbing, solid
from plugins.structures import body_of

from scenecc.diagnostics import Sink
from scenecc.emit import EMITTERS, emit
from scenecc.emit.python.bodies import BODY_PROPERTIES, COLLISIONS, RENDER_PROPERTIES, VISUALS
from scenecc.emit.python.files import COACD_DEFAULTS
from scenecc.emit.python.source import (
    WIDTH,
    Group,
    Identifiers,
    SourceNode,
    SourceWriter,
    call,
    list_of,
    number_literal,
    string,
)
from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionGeometry,
    CollisionShape,
    ConvexMesh,
    GpuMemory,
    Mesh,
    Physics,
    ScenePlan,
    SdfConfig,
    Sphere,
    VisualGeometry,
    VisualShape,
    constant,
    per_scene,
)
from scenecc.plan.body import AssetFile
from scenecc.plan.json_codec import plan_to_json
from scenecc.plan.scene import SDF_CONFIG_NAMES


def script(plan: ScenePlan, **options: Any) -> str:
    sink = Sink()
    text = emit(plan, "python", sink, **options)
    assert text is not None, sink.diagnostics()
    assert not sink.diagnostics()
    return text


def test_the_script_tables_cover_all_geometry() -> None:
    assert set(COLLISIONS) == set(get_args(CollisionGeometry))
    assert set(VISUALS) == set(get_args(VisualGeometry))


def test_the_script_tables_cover_all_properties() -> None:
    elsewhere = {"body_type", "collisions", "visuals", "mass", "com", "inertial"}
    elsewhere |= {"collision_groups", "shapeless", "origin"}
    assert {*BODY_PROPERTIES, *RENDER_PROPERTIES} | elsewhere == {
        item.name for item in dataclasses.fields(BodyStructure)
    }


def test_a_script_gives_coacd_the_defaults_of_sapien() -> None:
    from sapien.wrapper.coacd import do_coacd

    parameters = inspect.signature(do_coacd).parameters
    assert dataclasses.asdict(COACD_DEFAULTS) == {
        item.name: parameters[item.name].default for item in dataclasses.fields(COACD_DEFAULTS)
    }


def test_each_target_has_a_module() -> None:
    for target in EMITTERS:
        assert emit(SAMPLES["varied"](), target, Sink())
    with pytest.raises(KeyError):
        emit(SAMPLES["varied"](), "fortran", Sink())


def test_json_is_the_canonical_json() -> None:
    plan = SAMPLES["varied"]()
    assert emit(plan, "json", Sink()) == plan_to_json(plan)
    assert emit(plan, "json", Sink(), base=Path("/x")) == plan_to_json(plan, base=Path("/x"))


def test_any_plan_is_a_formatted_script_or_reported(tmp_path: Path) -> None:
    pytest.importorskip("ruff")
    count = 0

    @given(plans())
    @settings(max_examples=examples(60), suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
    def write(plan: ScenePlan) -> None:
        nonlocal count
        sink = Sink()
        text = emit(plan, "python", sink)
        if text is None:
            assert {found.code for found in sink.diagnostics()} == {"SC720"}
            return
        ast.parse(text)
        (tmp_path / f"script_{count}.py").write_text(text, encoding="utf-8")
        count += 1

    write()
    assert count
    for arguments in (["format", "--diff"], ["check", "--select", "F,I,W,E4,E7,E9"]):
        command = [sys.executable, "-m", "ruff", *arguments, "--isolated", "--line-length", str(WIDTH), str(tmp_path)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[:3000]


HOSTILE = [
    "'); import os; os.system('true')  #",
    '"""\nimport os\n"""',
    "a\nb\r\u2028c",
    "\\",
    "class",
    "scenes",
    "print",
    "l",
    "0",
    "",
    "…",
    "x" * 500,
    "{x}",
    "\ud800",
]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_names_are_only_ever_strings(text: str) -> None:
    def plan(name: str, other: str) -> ScenePlan:
        body = BodyStructure(
            "dynamic",
            (
                CollisionShape(ConvexMesh(constant(0, INT), constant([1, 1, 1])), material=constant(0, INT)),
                CollisionShape(Box(per_scene([[1, 1, 1], [2, 2, 2]]))),
            ),
            (VisualShape(Mesh(constant(0, INT), constant([1, 1, 1])), name=name),),
        )
        twin = dataclasses.replace(entity(name, pose(0, 0, 1), body), name=other)
        return ScenePlan(
            name,
            3,
            (entity(name, pose(0, 0, 1), body, (0, 2)), twin),
            Physics(),
            files=(AssetFile(name, Path("/x")), AssetFile(f"pkg://{name}/{name}", Path("/y"))),
            physical_materials=(rubbing(0.1, 0.1, 0.1),),
            description=f"{name}\n{name}",
        )

    def shape_of(plan: ScenePlan) -> list[str]:
        tree = ast.parse(script(plan))
        assert tree.body
        return [type(node).__name__ for node in ast.walk(tree)]

    hostile, tame = plan(text, text + "2"), plan("tame", "tame2")
    if 0 < len(text) < 60:  # an empty name of a shape is not written, and a long path is broken otherwise
        assert shape_of(hostile) == shape_of(tame)
    strings = {node.value for node in ast.walk(ast.parse(script(hostile))) if isinstance(node, ast.Constant)}
    assert {text, text + "2"} <= strings


COOKIE = "coding: utf-7 "
RUNS = "+AAo-import os+ADs-os.system(+ACI-echo PWNED+ACI-)+AAo-"


def code_of(script: bytes) -> str:
    """What Python runs, without its strings, and with identifiers numbered in order of appearance.

    From bytes: a line that names an encoding counts then, as it does for a file.
    """
    numbers: dict[str, str] = {}
    tree = ast.parse(script)
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            node.id = node.id if node.id in {"physx", "sapien"} else numbers.setdefault(node.id, f"n{len(numbers)}")
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            node.value = ""
    return ast.dump(tree)


def named(name: str, description: str, entities: tuple[str, str]) -> ScenePlan:
    body = BodyStructure("dynamic", (CollisionShape(Box(constant([1, 1, 1])), material=constant(0, INT)),))
    first, second = (entity(text, pose(0, 0, 1), body) for text in entities)
    moved = dataclasses.replace(second, pose=per_scene([[0, 0, z, 1, 0, 0, 0] for z in range(3)]))
    materials = (rubbing(0.1, 0.1, 0.1),)
    return ScenePlan(name, 3, (first, moved), Physics(), physical_materials=materials, description=description)


TEXTS = st.one_of(
    st.text(max_size=60),
    st.text(st.sampled_from("\n\r\x0b\x0c\x1c\x1d\x1e\x85\u2028\u2029\x00\x1a#'\"\\ ax+-:="), max_size=40),
    st.tuples(st.sampled_from(["", "x\n", "\r", "\x0c"]), st.sampled_from([COOKIE, "-*- coding=cp037 -*-", RUNS])).map(
        "".join
    ),
)


@pytest.mark.quick
@given(TEXTS, TEXTS, st.lists(TEXTS, min_size=2, max_size=2, unique=True))
@example("x coding: utf-7 ", RUNS, ["a", "b"])
@example("x", COOKIE + RUNS, ["a", "b"])
@example("x", "", [COOKIE, RUNS])
def test_no_text_of_a_scene_is_ever_run(name: str, description: str, entities: list[str]) -> None:
    first, second = entities
    text = script(named(name, description, (first, second)))
    written = text.encode()
    assert tokenize.detect_encoding(io.BytesIO(written).readline)[0] == "utf-8"
    assert code_of(written) == code_of(script(named("tame", "", ("first", "second"))).encode())
    comments = [token for token in tokenize.tokenize(io.BytesIO(written).readline) if token.type == tokenize.COMMENT]
    assert all(token.string.isprintable() for token in comments)
    assert text.splitlines() == text.removesuffix("\n").split("\n"), "lines are what every reader takes for lines"


def test_thousands_of_equal_names_are_emitted_quickly() -> None:
    import time

    names = Identifiers()
    names.take("shared_3")
    start = time.process_time()
    found = [names.take("shared") for _ in range(20_000)]
    assert_took(time.process_time() - start, most=5)
    assert found[:3] == ["shared", "shared_2", "shared_4"]
    assert len(set(found)) == len(found)


@given(st.lists(st.text(max_size=80), max_size=30))
def test_names_in_a_script_are_unique_identifiers(wanted: list[str]) -> None:
    names = Identifiers()
    found = [names.take(text) for text in wanted]
    assert len(set(found)) == len(found)
    assert all(name.isidentifier() and name.isascii() for name in found)
    assert not {"l", "O", "I", "scene", "print", "class", "match"} & set(found)


@given(st.text(st.sampled_from("a'\"\\\n{é\u202e\x00\ud800"), max_size=12))
def test_a_string_literal_is_that_string(text: str) -> None:
    assert ast.literal_eval(string(text)) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_literal_is_that_number_to_the_bit(item: float) -> None:
    assert np.float64(ast.literal_eval(number_literal(item))).tobytes() == np.float64(item).tobytes()


def test_items_that_do_not_fit_are_written_one_per_line() -> None:
    source = SourceWriter()
    source.statement(call("f", list_of(["1"]), a="x" * 60, b=list_of(["1234567890"] * 9)), assign="y")
    assert source.text == (
        "y = f(\n    [1],\n    a=" + "x" * 60 + ",\n    b=[\n" + "        1234567890,\n" * 9 + "    ],\n)\n"
    )


@pytest.mark.parametrize("name", [8, 30, 42, 50, 80, 120])
@pytest.mark.parametrize("found", ["entity", Group("articulation.find_link_by_name(", ('"elbow"',), ").entity")])
def test_a_long_target_breaks_after_what_is_assigned_as_ruff_would(
    name: int, found: SourceNode, tmp_path: Path
) -> None:
    pytest.importorskip("ruff")
    source = SourceWriter()
    source.statement(found, assign=Group("held[", ("scene", string("n" * name), string("elbow")), "]"))
    path = tmp_path / "script.py"
    path.write_text(source.text, encoding="utf-8")
    command = [sys.executable, "-m", "ruff", "format", "--diff", "--isolated", "--line-length", str(WIDTH), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("idxs", "text"),
    [
        ((0, 1, 2, 3, 4, 5), "for scene in scenes:"),
        ((1, 2, 3), "for scene in scenes[1:4]:"),
        ((0, 2, 4), "for scene in scenes[0:5:2]:"),
        ((4,), "scene = scenes[4]"),
        ((0, 1, 5), "cube_scenes = [0, 1, 5]\n    for scene in [scenes[k] for k in cube_scenes]:"),
    ],
)
def test_scene_selections_are_readable(idxs: tuple[int, ...], text: str) -> None:
    plan = ScenePlan("p", 6, (entity("cube", pose(0, 0, 1), solid(Box(constant([1, 1, 1]))), idxs),), Physics())
    assert f"    # cube\n    {text}\n" in script(plan)


def test_collision_and_visual_shapes_share_a_list_of_sizes() -> None:
    assert script(SAMPLES["varied"]()).count("[0.06, 0.05, 0.04],") == 1


def variants_of(holder: Any, skip: set[str]) -> list[tuple[str, Any]]:
    """The same dataclass, once without each of the fields that it gives."""
    return [
        (item.name, dataclasses.replace(holder, **{item.name: None}))
        for item in dataclasses.fields(holder)
        if item.name not in skip and item.default is None and getattr(holder, item.name) is not None
    ]


def test_a_script_drops_no_simulation_setting() -> None:
    plan = SAMPLES["knobs"]()
    given_fields = {item.name for item in dataclasses.fields(Physics)} - {"origin"}
    assert {name for name, _ in variants_of(plan.physics, set())} == given_fields
    texts = {script(dataclasses.replace(plan, physics=physics)) for _, physics in variants_of(plan.physics, set())}
    # Only a GPU simulation has a spacing and a memory; a remark says once for both that they are left out.
    assert len(texts - {script(plan)}) == len(given_fields) - 2
    assert "apply to a shared GPU simulation" in script(plan)
    for name, sdf in variants_of(SdfConfig(0.1, 2, 3), set()):
        assert script(ScenePlan("p", 1, (), Physics(sdf=sdf))) != script(
            ScenePlan("p", 1, (), Physics(sdf=SdfConfig(0.1, 2, 3)))
        ), name
    assert set(SDF_CONFIG_NAMES) == {item.name for item in dataclasses.fields(SdfConfig)}
    assert "GPU" in script(ScenePlan("p", 1, (), Physics(gpu_memory=GpuMemory(heap_capacity=5))))


def test_a_script_drops_no_property_of_a_body_or_shape() -> None:
    full = body_of(SAMPLES["knobs"]().entities[1])
    seen = (VisualShape(Sphere(constant(0.1)), pose(0, 0, 1), constant(0, INT), "name", "clockwise"),)
    full = dataclasses.replace(
        full,
        visuals=seen,
        com=constant([0.1, 0.0, 0.0]),
        disable_gravity=constant(True, FLAG),
        visibility=constant(0.5),
        shading_mode=constant(1, INT),
        collisions=(
            dataclasses.replace(
                full.collisions[0], material=constant(0, INT), collision_groups=constant([1, 2, 3, 4], INT)
            ),
            CollisionShape(Sphere(constant(0.2))),
        ),
    )

    def text(body: BodyStructure) -> str:
        return script(
            ScenePlan(
                "p",
                1,
                (entity("x", pose(0, 0, 0), body, (0,)),),
                Physics(),
                (),
                physical_materials=(rubbing(1, 1, 0),),
                visual_materials=(look(ior=2),),
            )
        )

    bodies = [body for _, body in variants_of(full, {"inertial"})]
    first, other = full.collisions
    bodies += [dataclasses.replace(full, collisions=(one, other)) for _, one in variants_of(first, set())]
    bodies += [dataclasses.replace(full, visuals=(one,)) for _, one in variants_of(seen[0], set())]
    texts = [text(body) for body in (full, *bodies)]
    assert len(set(texts)) == len(texts)
    nullable = [
        (cls, item.name)
        for cls in (BodyStructure, CollisionShape, VisualShape)
        for item in dataclasses.fields(cls)
        if item.default is None and item.name not in {"inertial", "shapeless", "origin"}
    ]
    assert len(texts) == 1 + len(nullable)


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (solid(Sphere(constant(1)), body_type="static", linear_damping=constant(1)), "linear_damping"),
        (solid(Sphere(constant(1)), body_type="static", mass=constant(1)), "mass"),
        (solid(Sphere(constant(1)), body_type="none"), "collisions"),
        (solid(Sphere(constant(1)), visibility=constant(1)), "visibility"),
    ],
)
def test_unsupported_body_fields_are_an_error_in_a_script(body: BodyStructure, field: str) -> None:
    sink = Sink()
    assert emit(ScenePlan("p", 2, (entity("it", pose(0, 0, 0), body),), Physics()), "python", sink) is None
    (found,) = sink.diagnostics()
    assert found.code == "SC720"
    assert f"`{field}`" in found.message


def test_files_of_packages_and_asset_roots_are_found_at_run_time(tmp_path: Path) -> None:
    files = (
        AssetFile("pkg://sapien/version.py", tmp_path / "a"),
        AssetFile("asset://deep/mesh.obj", tmp_path / "b"),
        AssetFile(str(tmp_path / "abs.obj"), tmp_path / "abs.obj"),
        AssetFile("beside.obj", tmp_path / "beside.obj"),
    )
    (tmp_path / "root" / "deep").mkdir(parents=True)
    for path in (tmp_path / "root/deep/mesh.obj", tmp_path / "abs.obj", tmp_path / "beside.obj"):
        path.touch()
    text = script(ScenePlan("p", 1, (), Physics(), files=files), base=tmp_path)
    bound = "# It finds its files relative to its own folder: "
    assert bound in text
    assert bound not in script(ScenePlan("p", 1, (), Physics(), files=files[:1]), base=tmp_path)
    (tmp_path / "scenes.py").write_text(text + "\nprint(len(FILES))\n")
    command = [sys.executable, str(tmp_path / "scenes.py")]
    for root, code in (("root", 0), ("nowhere", 1)):
        environment = {"SCENECC_ASSET_PATH": str(tmp_path / root), "PATH": "/usr/bin:/bin"}
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, timeout=100)
        assert done.returncode == code, done.stderr
        assert code == 0 or "deep/mesh.obj is not in a folder of SCENECC_ASSET_PATH" in done.stderr


def test_ten_thousand_bodies_and_many_scenes_are_emitted_quickly() -> None:
    import time

    body = solid(Box(constant([0.1, 0.1, 0.1])))
    many = ScenePlan("p", 2, tuple(entity(f"b{i}", pose(i, 0, 0), body) for i in range(10_000)), Physics())
    rows = np.hstack([np.random.default_rng(0).random((4096, 3)), np.tile([1.0, 0, 0, 0], (4096, 1))])
    everywhere = tuple(range(4096))
    moved = tuple(
        entity(f"b{i}", per_scene(rows + np.array([i, 0, 0, 0, 0, 0, 0])), body, everywhere) for i in range(5)
    )
    wide = ScenePlan("p", 4096, moved, Physics())
    for plan in (many, wide):
        start = time.process_time()
        script(plan)
        plan_to_json(plan)
        assert_took(time.process_time() - start, most=10)
