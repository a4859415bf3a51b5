"""Which files a scene can name, and which it cannot."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from plugins.nightly import assert_took

from scenecc.diagnostics.codes import CODES
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, asset_roots, resolve_asset_reference, resolve_path


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A scene's folder with a bowl and a texture, and a secret outside it."""
    scene = tmp_path / "scene"
    (scene / "meshes" / "textures").mkdir(parents=True)
    (scene / "meshes" / "Bowl.obj").write_text("v 0 0 0\n")
    (scene / "meshes" / "mug.stl").write_text("solid\n")
    (scene / "meshes" / "textures" / "oak.png").write_text("")
    (tmp_path / "secret.obj").write_text("")
    (tmp_path / "scene2").mkdir()
    (tmp_path / "scene2" / "bowl.obj").write_text("")
    return scene


def refused(found: ResolvedFile | Refusal) -> Refusal:
    assert isinstance(found, Refusal), found
    assert found.code in CODES
    return found


def file_of(found: ResolvedFile | Refusal) -> ResolvedFile:
    assert isinstance(found, ResolvedFile), found
    assert found.path.is_absolute()
    assert found.path.is_file()
    return found


def test_paths_are_relative_to_the_file_that_contains_them(tree: Path) -> None:
    scope = AssetScope(root=tree)
    assert file_of(resolve_path("meshes/Bowl.obj", base=tree, scope=scope)).uri == "meshes/Bowl.obj"
    assert file_of(resolve_path("Bowl.obj", base=tree / "meshes", scope=scope)).uri == "meshes/Bowl.obj"
    assert file_of(resolve_path("../Bowl.obj", base=tree / "meshes" / "textures", scope=scope)).uri == "meshes/Bowl.obj"
    assert file_of(resolve_path(str(tree / "meshes" / "Bowl.obj"), base=tree, scope=scope)).uri == "meshes/Bowl.obj"


@pytest.mark.parametrize("uri", ["../secret.obj", "meshes/../../secret.obj", "../scene2/bowl.obj", "/etc/passwd"])
def test_paths_that_leave_the_scene_folder_are_refused(tree: Path, uri: str) -> None:
    assert refused(resolve_path(uri, base=tree, scope=AssetScope(root=tree))).code == "SC402"
    found = file_of(resolve_path(uri, base=tree, scope=AssetScope(root=tree, allow_outside=True)))
    assert found.uri == os.path.realpath(tree / uri)


def test_the_existence_of_outside_files_is_not_revealed(tree: Path) -> None:
    scope = AssetScope(root=tree)
    there = refused(resolve_path("../secret.obj", base=tree, scope=scope))
    absent = refused(resolve_path("../nothing.obj", base=tree, scope=scope))
    hint = (absent.hint or "").replace("nothing", "secret")
    assert there == Refusal(absent.code, absent.message.replace("nothing", "secret"), hint)


def test_links_are_resolved_before_the_permission_check(tree: Path) -> None:
    (tree / "out.obj").symlink_to(tree.parent / "secret.obj")
    (tree / "up").symlink_to(tree.parent)
    (tree / "in.obj").symlink_to(tree / "meshes" / "Bowl.obj")
    (tree / "loop").symlink_to(tree / "loop")
    scope = AssetScope(root=tree)
    assert refused(resolve_path("out.obj", base=tree, scope=scope)).code == "SC402"
    assert refused(resolve_path("up/secret.obj", base=tree, scope=scope)).code == "SC402"
    assert refused(resolve_path("loop", base=tree, scope=scope)).code == "SC407"
    # The link's own name stays: an OBJ's MTL is sought beside it.
    assert file_of(resolve_path("in.obj", base=tree, scope=scope)).uri == "in.obj"


def test_the_scene_folder_may_be_a_link(tree: Path, tmp_path: Path) -> None:
    (tmp_path / "alias").symlink_to(tree)
    scope = AssetScope(root=tmp_path / "alias")
    assert file_of(resolve_path("meshes/Bowl.obj", base=tmp_path / "alias", scope=scope)).uri == "meshes/Bowl.obj"


def test_without_a_root_paths_are_relative_to_the_current_folder(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tree)
    assert file_of(resolve_path("meshes/Bowl.obj", base=Path(), scope=AssetScope())).uri == "meshes/Bowl.obj"
    assert refused(resolve_path("../secret.obj", base=Path(), scope=AssetScope())).code == "SC402"


@pytest.mark.parametrize(
    "uri",
    [
        "",
        "  ",
        "a\0b.obj",
        "a\nb.obj",
        "\udcff\ud800.obj",
        "meshes\\Bowl.obj",
        "~/bowl.obj",
        "~root/bowl.obj",
        "http://example.org/a.obj",
        "https://example.org/a.obj",
        "file:///etc/passwd",
        "package://panda/a.obj",
        "PKG://scenecc/a.obj",
        "s3://bucket/a.obj",
        "asset://",
        "asset:///etc/passwd",
        "pkg://scenecc",
        "pkg://scenecc/",
        "pkg://scenecc//etc/passwd",
    ],
)
def test_invalid_paths_are_refused(tree: Path, uri: str) -> None:
    scope = AssetScope(root=tree, asset_roots=(tree,), allow_outside=True)
    assert refused(resolve_path(uri, base=tree, scope=scope)).code == "SC403"


def test_only_regular_files_are_accepted(tree: Path) -> None:
    scope = AssetScope(root=tree, allow_outside=True)
    os.mkfifo(tree / "pipe.obj")
    for uri in ("meshes", "meshes/", ".", "..", "pipe.obj", "/dev/zero"):
        assert refused(resolve_path(uri, base=tree, scope=scope)).code == "SC404", uri
    assert refused(resolve_path("meshes/Bowl.obj/", base=tree, scope=scope)).code in {"SC401", "SC404"}


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_unreadable_files_are_refused(tree: Path) -> None:
    (tree / "meshes" / "Bowl.obj").chmod(0)
    found = refused(resolve_path("meshes/Bowl.obj", base=tree, scope=AssetScope(root=tree)))
    assert found.code == "SC407"


@pytest.mark.parametrize(
    ("uri", "meant"),
    [
        ("meshes/bowl.obj", "meshes/Bowl.obj"),
        ("meshes/Bowl.stl", "meshes/Bowl.obj"),
        ("./meshes/../meshes/Bowll.obj", "./meshes/../meshes/Bowl.obj"),
        ("mesh/Bowl.obj", "meshes/Bowl.obj"),
        ("meshes/texture/oak.png", "meshes/textures/oak.png"),
        ("Meshes/textures/oak.png", "meshes/textures/oak.png"),
    ],
)
def test_a_missing_file_gives_the_nearest_name(tree: Path, uri: str, meant: str) -> None:
    found = refused(resolve_path(uri, base=tree, scope=AssetScope(root=tree)))
    assert found.code == "SC401"
    assert found.hint == f"did you mean `{meant}`?"


@pytest.mark.parametrize(
    ("missing", "there"), [("gone.mtl", "xhuge.mtl"), ("nothere.png", "tr.png"), ("cup.obj", "cub.obj")]
)
def test_file_suggestions_compare_stems(missing: str, there: str, tmp_path: Path) -> None:
    (tmp_path / there).touch()
    found = refused(resolve_path(missing, base=tmp_path, scope=AssetScope(root=tmp_path)))
    assert (found.code, found.hint) == ("SC401", None)


def test_a_missing_folder_is_never_meant_to_be_a_file(tmp_path: Path) -> None:
    (tmp_path / "tray.json").touch()
    found = refused(resolve_path("tray.assets/mug.obj", base=tmp_path, scope=AssetScope(root=tmp_path)))
    assert found.hint == f"there is no folder {tmp_path / 'tray.assets'}"


def test_file_suggestions_prefer_the_same_suffix(tmp_path: Path) -> None:
    for name in ("wood.jpg", "wood.obj", "wood.png"):
        (tmp_path / name).touch()
    found = refused(resolve_path("wod.obj", base=tmp_path, scope=AssetScope(root=tmp_path)))
    assert found.hint == "did you mean `wood.obj`?"


def test_a_missing_file_without_similar_names_has_no_suggestion(tree: Path) -> None:
    scope = AssetScope(root=tree)
    assert refused(resolve_path("quux.dae", base=tree, scope=scope)).hint is None
    assert (
        refused(resolve_path("zzz/quux.dae", base=tree, scope=scope)).hint
        == f"there is no folder {tree.resolve() / 'zzz'}"
    )
    assert refused(resolve_path("x" * 5000, base=tree, scope=scope)).code == "SC401"
    assert refused(resolve_path("meshes/Bowl.obj/deeper", base=tree, scope=scope)).code == "SC401"


def test_asset_roots_are_searched_in_order(tree: Path, tmp_path: Path) -> None:
    other = tmp_path / "scene2"
    first = AssetScope(root=tree, asset_roots=(tree / "meshes", other))
    assert (
        file_of(resolve_path("asset://Bowl.obj", base=tree, scope=first)).path
        == (tree / "meshes" / "Bowl.obj").resolve()
    )
    found = file_of(resolve_path("asset://bowl.obj", base=tree, scope=first))
    assert (found.path, found.uri) == ((other / "bowl.obj").resolve(), "asset://bowl.obj")
    assert refused(resolve_path("asset://../secret.obj", base=tree, scope=first)).code == "SC402"
    missing = refused(resolve_path("asset://bowl.stl", base=tree, scope=first))
    assert (missing.code, missing.hint) == ("SC401", "did you mean `asset://Bowl.obj`?")
    assert str(other) in missing.message
    assert refused(resolve_path("asset://bowl.obj", base=tree, scope=AssetScope(root=tree))).code == "SC406"
    # What lies in an asset root may be named by a plain path too.
    assert file_of(resolve_path("../scene2/bowl.obj", base=tree, scope=first)).uri == str(
        (other / "bowl.obj").resolve()
    )


def test_asset_roots_from_the_environment() -> None:
    environment = {"SCENECC_ASSET_PATH": os.pathsep.join(["/a", "", "b"])}
    assert asset_roots([Path("/c")], environment) == (Path("/c"), Path("/a"), Path("b"))
    assert asset_roots([], {}) == ()


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Packages that must not be imported."""
    site = tmp_path / "site"
    for name in ("robot_pkg", "robot_pkg/inner", "plain_folder"):
        (site / name).mkdir(parents=True)
        (site / name / "arm.obj").write_text("")
    for name in ("robot_pkg", "robot_pkg/inner"):
        (site / name / "__init__.py").write_text("raise SystemError('imported')")
    (site / "single_module.py").write_text("raise SystemError('imported')")
    monkeypatch.syspath_prepend(str(site))
    return site


def test_packages_are_found_and_not_imported(tree: Path, packages: Path) -> None:
    scope = AssetScope(root=tree)
    found = file_of(resolve_path("pkg://robot_pkg/inner/arm.obj", base=tree, scope=scope))
    assert found == ResolvedFile(
        (packages / "robot_pkg" / "inner" / "arm.obj").resolve(), "pkg://robot_pkg/inner/arm.obj"
    )
    assert "robot_pkg" not in sys.modules


@pytest.mark.parametrize(
    ("uri", "code"),
    [
        ("pkg://robot_pkg.inner/arm.obj", "SC405"),
        ("pkg://robot_pkg/../plain_folder/arm.obj", "SC402"),
        ("pkg://robot_pkg/arm.stl", "SC401"),
        ("pkg://plain_folder/arm.obj", "SC405"),
        ("pkg://single_module/arm.obj", "SC405"),
        ("pkg://sys/arm.obj", "SC405"),
        ("pkg://__main__/arm.obj", "SC405"),
        ("pkg://no_such_package/arm.obj", "SC405"),
        ("pkg://../arm.obj", "SC405"),
        ("pkg://./arm.obj", "SC405"),
        ("pkg:///etc/passwd", "SC405"),
        ("pkg://robot-pkg/arm.obj", "SC405"),
        ("pkg://" + "x" * 300 + "/arm.obj", "SC405"),
    ],
)
def test_missing_and_invalid_packages_are_refused(tree: Path, packages: Path, uri: str, code: str) -> None:
    del packages
    assert refused(resolve_path(uri, base=tree, scope=AssetScope(root=tree))).code == code
    assert not {"robot_pkg", "single_module"} & set(sys.modules)


def test_files_referenced_by_an_asset_are_checked(tree: Path, packages: Path) -> None:
    scope = AssetScope(root=tree)
    bowl = file_of(resolve_path("meshes/Bowl.obj", base=tree, scope=scope))

    def named(reference: str, owner: ResolvedFile = bowl) -> ResolvedFile | Refusal:
        return resolve_asset_reference(reference, owner=owner.path, owner_uri=owner.uri, scope=scope)

    assert file_of(named("textures/oak.png")).uri == "meshes/textures/oak.png"
    assert refused(named("../../secret.obj")).code == "SC402"
    assert refused(named(str(bowl.path))).code == "SC402"
    for scheme in ("http", "file", "pkg", "asset"):
        assert refused(named(f"{scheme}://robot_pkg/arm.obj")).code == "SC403"
    arm = file_of(resolve_path("pkg://robot_pkg/inner/arm.obj", base=tree, scope=scope))
    assert file_of(named("../arm.obj", arm)).path == (packages / "robot_pkg" / "arm.obj").resolve()
    assert refused(named("../../plain_folder/arm.obj", arm)).code == "SC402"


def test_lookups_are_cached_for_one_compilation(tree: Path) -> None:
    scope = AssetScope(root=tree)
    assert refused(resolve_path("late.obj", base=tree, scope=scope)).code == "SC401"
    (tree / "late.obj").write_text("")
    assert refused(resolve_path("late.obj", base=tree, scope=scope)).code == "SC401"
    assert file_of(resolve_path("late.obj", base=tree, scope=AssetScope(root=tree))).uri == "late.obj"


def test_ten_thousand_missing_files_in_a_full_folder_are_fast(tree: Path) -> None:
    for i in range(1000):
        (tree / f"part_{i:04d}_of_the_machine.obj").touch()
    scope = AssetScope(root=tree)
    start = time.process_time()
    for i in range(10_000):
        refused(resolve_path(f"part-{i:05d}-of-the-machine.stl", base=tree, scope=scope))
    assert_took(time.process_time() - start, most=10)


def test_looking_up_paths_imports_no_heavy_module() -> None:
    code = "import sys, scenecc.source.paths; print(sorted({'numpy', 'trimesh', 'sapien'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "[]\n"
