"""`pack_scene`: which files are packed, where they lie, and that the pack is as good as the scene."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest

from scenecc import (
    SceneError,
    check_scene,
    compare_scenes,
    compile_scene,
    list_params,
    load_scene,
    open_scene,
    pack_scene,
    validate,
)

MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
TETRAHEDRON = f"mtllib a.mtl\nusemtl m\n{MESH}"
URDF = """\
<robot name="r"><link name="a">
<visual><geometry><mesh filename="package://parts/a.obj"/></geometry></visual>
<collision><geometry><mesh filename="../parts/a.obj"/></geometry></collision>
</link>
<link name="b"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="3 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>
"""


def scene(**entities: str) -> str:
    rows = "".join(f"  {name}: {{shapes: [{{type: convex_mesh, file: {file}}}]}}\n" for name, file in entities.items())
    return f"scenecc: 1\nentities:\n{rows}"


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene's folder `a`, an asset root `b`, and a Python package `acme_parts`."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.syspath_prepend(tmp_path / "python")
    for folder in ("a/parts", "a/robots", "b/parts", "python/acme_parts/parts"):
        (tmp_path / folder).mkdir(parents=True)
        if folder.endswith("parts"):
            (tmp_path / folder / "a.obj").write_text(TETRAHEDRON + f"# {folder}\n")
            (tmp_path / folder / "a.mtl").write_text("newmtl m\nKd 1 0 0\n")
    (tmp_path / "python/acme_parts/__init__.py").write_text("raise SystemExit('imported')\n")
    (tmp_path / "a/robots/r.urdf").write_text(URDF)
    return tmp_path


def write(home: Path, text: str, name: str = "a/scene.yaml") -> Path:
    (home / name).write_text(text)
    return home / name


def packed(file: Path, home: Path, **options: Any) -> list[str]:
    """The files of the pack, which is compared with the scene once the scene's files are gone."""
    made = pack_scene(file, home / "x.scn", **options)
    options.pop("add", None)
    plan = compile_scene(file, **options)
    for folder in ("a", "b", "python"):
        (home / folder).rename(home / f"{folder}.gone")
    try:
        kept = {name: value for name, value in options.items() if name not in {"asset_roots", "allow_outside_assets"}}
        again = compile_scene(home / "x.scn", **kept)
        assert [one.sha256 for one in plan.files] == [one.sha256 for one in again.files]
        assert len(plan.entities) == len(again.entities)
    finally:
        for folder in ("a", "b", "python"):
            (home / f"{folder}.gone").rename(home / folder)
    assert all(one.code in {"SC429", "SC018"} for one in made.diagnostics), made.diagnostics
    return list(made.manifest.files)


OWN = ".scenecc"


def test_files_of_the_scene_folder_keep_their_paths_in_a_pack(home: Path) -> None:
    file = write(home, scene(a="parts/a.obj"))
    assert packed(file, home) == ["parts/a.mtl", "parts/a.obj", "scene.yaml"]


def test_files_of_robots_are_packed(home: Path) -> None:
    file = write(home, "scenecc: 1\nentities:\n  r: {urdf: robots/r.urdf}\n")
    assert packed(file, home) == ["parts/a.mtl", "parts/a.obj", "robots/r.urdf", "scene.yaml"]


def test_packages_and_asset_roots_are_packed(home: Path) -> None:
    file = write(home, scene(a="pkg://acme_parts/parts/a.obj", b="asset://parts/a.obj", c="parts/a.obj"))
    (home / "nothing").mkdir()
    names = packed(file, home, asset_roots=[home / "nothing", home / "b"])
    folders = (f"{OWN}/packages/acme_parts/parts", f"{OWN}/roots/0/parts", "parts")
    assert names == [*(f"{folder}/a.{end}" for folder in folders for end in ("mtl", "obj")), "scene.yaml"]


def test_an_asset_root_above_the_scene_keeps_its_tree(home: Path) -> None:
    file = write(home, scene(a="../b/parts/a.obj", c="asset://b/parts/a.obj"))
    assert packed(file, home, asset_roots=[home]) == ["a/scene.yaml", "b/parts/a.mtl", "b/parts/a.obj"]


def test_outside_files_are_packed(home: Path) -> None:
    file = write(home, scene(a="../b/parts/a.obj"))
    names = packed(file, home, allow_outside_assets=True)
    assert names == ["a/scene.yaml", "b/parts/a.mtl", "b/parts/a.obj"]


def test_files_behind_links_are_packed_as_files(home: Path) -> None:
    (home / "a/linked").symlink_to(home / "b/parts")
    file = write(home, scene(a="linked/a.obj"))
    names = packed(file, home, asset_roots=[home / "b"])
    assert {"linked/a.obj", "linked/a.mtl"} <= {*names}


def test_included_files_and_prefabs_are_packed(home: Path) -> None:
    write(home, scene(b="a.obj"), "a/parts/more.yaml")
    write(home, scene(c="a.obj"), "b/parts/prefab.yaml")
    text = scene(a="parts/a.obj") + "  p: {use: 'asset://parts/prefab.yaml'}\ninclude: [parts/more.yaml]\n"
    names = packed(write(home, text), home, asset_roots=[home / "b"])
    assert "parts/more.yaml" in names
    assert f"{OWN}/roots/0/parts/prefab.yaml" in names


def test_all_alternatives_of_draws_are_packed(home: Path) -> None:
    for name in "bcd":
        (home / f"a/parts/{name}.obj").write_text(f"{MESH}# {name}\n")
    text = scene(a="{choice: [parts/a.obj, parts/b.obj]}", e='"parts/${n}.obj"') + "draws: {n: {choice: [c, d]}}\n"
    made = pack_scene(write(home, text))
    assert {f"parts/{name}.obj" for name in "abcd"} <= made.manifest.files.keys()
    assert not made.diagnostics


def test_all_options_of_a_choice_are_packed(home: Path) -> None:
    (home / "a/parts/b.obj").write_text(MESH)
    text = "params:\n  n: {type: choice, options: [a, b], default: a}\n"
    text += scene(a='"parts/${n}.obj"').removeprefix("scenecc: 1\n")
    made = pack_scene(write(home, "scenecc: 1\n" + text), home / "x.scn")
    assert {"parts/a.obj", "parts/b.obj"} <= made.manifest.files.keys()
    assert not made.diagnostics
    assert not validate(home / "x.scn", params={"n": "b"})


def test_files_of_other_values_are_reported_and_can_be_added(home: Path) -> None:
    (home / "a/parts/b.obj").write_text(MESH)
    file = write(home, "scenecc: 1\nparams: {n: a}\n" + scene(a='"parts/${n}.obj"').removeprefix("scenecc: 1\n"))
    made = pack_scene(file, home / "x.scn")
    assert [(one.code, one.line) for one in made.diagnostics] == [("SC429", 4)]
    (error,) = validate(home / "x.scn", params={"n": "b"})
    assert (error.code, error.file, error.line) == ("SC401", f"{home / 'x.scn'}!/scene.yaml", 4)
    assert "--set" in (error.hint or "")
    cases: tuple[dict[str, Any], ...] = (
        {"params": {"n": "b"}},
        {"add": [home / "a/parts"]},
        {"add": home / "a/parts/b.obj"},
    )
    for options in cases:
        more = pack_scene(file, home / "x.scn", **options)
        assert {"parts/a.obj", "parts/b.obj"} <= more.manifest.files.keys()
        assert not validate(home / "x.scn", params={"n": "b"})
        assert not validate(home / "x.scn")


def test_files_behind_a_condition_are_reported(home: Path) -> None:
    (home / "a/parts/b.obj").write_text(MESH)
    text = "scenecc: 1\nparams: {k: 1}\n" + scene(a="parts/a.obj").removeprefix("scenecc: 1\n")
    text += '  e: {if: "${k > 2}", shapes: [{type: convex_mesh, file: parts/b.obj}]}\n'
    made = pack_scene(write(home, text))
    assert [(one.code, one.severity, one.line) for one in made.diagnostics] == [("SC429", "note", 5)]


def test_packing_a_scene_twice_gives_the_same_bytes(home: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    text = scene(a="pkg://acme_parts/parts/a.obj", b="asset://parts/a.obj", c="parts/a.obj")
    one = pack_scene(write(home, text), asset_roots=[home / "b"]).content
    other = tmp_path_factory.mktemp("elsewhere") / "deep"
    shutil.copytree(home, other)
    os.utime(other / "a/parts/a.obj", (10**9, 10**9))
    (home / "none").mkdir()
    assert pack_scene(other / "a/scene.yaml", asset_roots=[other / "b", home / "none"]).content == one


def test_an_unwritable_pack_is_reported_with_its_given_path(home: Path) -> None:
    target = home / "nofolder/x.scn"
    with pytest.raises(FileNotFoundError) as caught:
        pack_scene(write(home, scene(a="parts/a.obj")), target)
    assert caught.value.filename == str(target)


def test_other_programs_can_unpack_it(home: Path) -> None:
    pack_scene(write(home, scene(a="parts/a.obj")), home / "x.scn")
    with zipfile.ZipFile(home / "x.scn") as archive:
        assert archive.testzip() is None
        archive.extractall(home / "out")
    assert not compare_scenes(home / "out/scene.yaml", home / "x.scn")


REFUSED = {
    "an absolute path": (lambda home: scene(a=str(home / "a/parts/a.obj")), "absolute path"),
    "a scene at fault": (lambda _: scene(a="none.obj"), "no file"),
}


@pytest.mark.parametrize(("text", "words"), REFUSED.values(), ids=REFUSED)
def test_unpackable_scenes_are_refused(text: Any, words: str, home: Path) -> None:
    with pytest.raises(SceneError, match=words):
        pack_scene(write(home, text(home)), home / "x.scn")
    assert not (home / "x.scn").exists()


def test_packed_names_that_differ_only_in_case_are_refused(home: Path) -> None:
    (home / "a/parts/A.obj").write_text(MESH)
    with pytest.raises(SceneError, match=r"SC428.*differ only in case"):
        pack_scene(write(home, scene(a="parts/a.obj", b="parts/A.obj")))


def test_a_pack_of_a_pack_is_refused(home: Path) -> None:
    pack_scene(write(home, scene(a="parts/a.obj")), home / "x.scn")
    with pytest.raises(SceneError, match="a pack already"):
        pack_scene(home / "x.scn", home / "y.scn")
    with pytest.raises(ValueError, match=r"NAME\.scn"):
        pack_scene(home / "a/scene.yaml", home / "y.zip")


def test_parameters_and_diagnostics_of_a_pack_name_its_files(home: Path) -> None:
    text = "scenecc: 1\nparams: {n: 1}\nentities:\n  e: {shapes: [{type: sphere, radius: 0.1}]}\n"
    pack_scene(write(home, text), home / "x.scn")
    assert [row.name for row in list_params(home / "x.scn")] == ["n"]
    opened = open_scene(home / "x.scn")
    assert opened.plan.name == "scene"
    assert {one.file for one in opened.diagnostics} == {f"{home / 'x.scn'}!/scene.yaml"}


def test_the_command_that_shows_a_finding_names_the_pack(home: Path) -> None:
    pack_scene(write(home, "scenecc: 1\nentities:\n  e: {shapes: [{type: sphere, radius: 0.1}]}\n"), home / "x.scn")
    (falls,) = [one for one in check_scene(home / "x.scn", settle=0) if one.code == "SC852"]
    assert falls.hint is not None
    assert f"scenecc view {home / 'x.scn'} --seed 0 --scene 0" in falls.hint


PROGRAM = """
import os, pickle, sys
opened = []
READING = {"open", "os.scandir", "os.listdir"}
sys.addaudithook(lambda event, given: opened.append(given[0]) if event in READING else None)
import scenecc
with scenecc.load_scene(sys.argv[1], render=False) as batch:
    for _ in range(300):
        batch.step()
    state = batch.state()
names = {os.path.realpath(os.fsdecode(name)) for name in opened if isinstance(name, (str, bytes))}
with open(sys.argv[2], "wb") as file:
    pickle.dump((state.all, names), file)
"""


def test_a_packed_scene_builds_identically_without_outside_files(home: Path) -> None:
    text = scene(a="pkg://acme_parts/parts/a.obj", b="asset://parts/a.obj", c="parts/a.obj")
    text = text.replace("{shapes", "{pose: [{uniform: [0, 9]}, {uniform: [0, 9]}, 2], shapes")
    text += "  r: {urdf: robots/r.urdf}\n  ground: {body_type: static, shapes: [{type: plane}]}\nnum_scenes: 3\n"
    file = write(home, text)
    pack_scene(file, home / "x.scn", asset_roots=[home / "b"])
    with load_scene(file, render=False, asset_roots=[home / "b"]) as batch:
        for _ in range(300):
            batch.step()
        state = batch.state().all
    for folder in ("a", "b", "python", "cache"):
        (home / folder).rename(home / f"{folder}.gone")
    (home / "empty").mkdir()
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("SCENECC", "XDG", "PYTHON"))}
    paths = os.pathsep.join(path for path in sys.path if path and not path.startswith(str(home)))
    environment = {**kept, "HOME": str(home / "empty"), "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", PROGRAM, home / "x.scn", home / "out"]
    subprocess.run(command, env=environment, cwd=home / "empty", check=True)
    again, names = pickle.loads((home / "out").read_bytes())
    assert again == state
    assert again["c"] != state["a"], "what moves is compared"
    read = {name for name in names if name.startswith(str(home))}
    cache = str(home / "empty/.cache/scenecc/")
    # Python looks for modules in the folder where it is started.
    assert {name for name in read if not name.startswith(cache)} <= {str(home / "x.scn"), str(home / "empty")}
    assert any(name.startswith(cache) for name in read)
    installed = (sys.prefix, sys.base_prefix, *paths.split(os.pathsep), "/proc/", "/sys/", "/dev/", "/etc/", "/usr/")
    assert not {name for name in names - read if not name.startswith(installed)}
