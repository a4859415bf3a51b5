"""The files that a robot's file names: where they are looked for, and what they are called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.robots.files import FileReport, RobotFiles
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, resolve_path

if TYPE_CHECKING:
    from collections.abc import Callable

HERE = Location("robot.urdf", 3)


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A scene's folder with a robot in it, and a mesh outside of it."""
    for name in (
        "scene/robots/arm/robot.urdf",
        "scene/robots/arm/near.obj",
        "scene/robots/pack/mesh.obj",
        "scene/packs/pack/mesh.obj",
        "scene/packs/pack/only.obj",
        "outside/mesh.obj",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    return tmp_path


class Finder:
    """Finds files for the robot of the tree."""

    def __init__(self, tree: Path, uri: str = "robots/arm/robot.urdf", package: Callable[..., object] | None = None):
        self.tree = tree
        self.scope = AssetScope(tree / "scene", (tree / "scene" / "robots",))
        owner = resolve_path(uri, base=tree / "scene", scope=self.scope)
        assert isinstance(owner, ResolvedFile)
        self.files = RobotFiles(owner, self.scope, package)  # type: ignore[arg-type]

    def find(self, reference: str) -> tuple[str, str]:
        """The uri and where it lies; or the code and the hint of what is told."""
        sink = Sink()
        found = self.files.find(reference, HERE, FileReport(sink))
        if found is not None:
            assert not sink.diagnostics()
            return found.uri, found.path.relative_to(self.tree).as_posix()
        (told,) = sink.diagnostics()
        assert told.location == HERE
        return told.code, str(told.hint)


def test_relative_paths_start_in_the_robots_folder(tree: Path) -> None:
    finder = Finder(tree)
    assert finder.find("near.obj") == ("robots/arm/near.obj", "scene/robots/arm/near.obj")
    assert finder.find("../pack/./mesh.obj") == ("robots/pack/mesh.obj", "scene/robots/pack/mesh.obj")


def test_a_file_gets_the_uri_scheme_of_its_robot(tree: Path) -> None:
    finder = Finder(tree, "asset://arm/robot.urdf")
    assert finder.find("near.obj")[0] == "asset://arm/near.obj"
    assert finder.find("../pack/mesh.obj")[0] == "asset://pack/mesh.obj"
    assert finder.find("../../packs/pack/mesh.obj")[0] == "packs/pack/mesh.obj"


def test_a_file_in_a_package_gets_a_pkg_uri(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tree / "site" / "lamp_pack" / "robots"
    folder.mkdir(parents=True)
    (folder.parent / "__init__.py").write_text("raise AssertionError('imported')\n")
    for name in ("robots/lamp.urdf", "robots/bulb.obj", "shared.obj"):
        (folder.parent / name).write_text("")
    (tree / "site" / "beside.obj").write_text("")
    monkeypatch.syspath_prepend(tree / "site")
    finder = Finder(tree, "pkg://lamp_pack/robots/lamp.urdf")
    assert finder.find("bulb.obj")[0] == "pkg://lamp_pack/robots/bulb.obj"
    assert finder.find("package://../shared.obj")[0] == "pkg://lamp_pack/shared.obj"
    assert finder.find("package://robots/bulb.obj")[0] == "pkg://lamp_pack/robots/bulb.obj"
    assert finder.find("../../beside.obj")[0] == "SC402"


def test_a_ros_package_is_searched_for_upwards_within_the_allowed_folders(tree: Path) -> None:
    finder = Finder(tree)
    assert finder.find("package://pack/mesh.obj") == ("robots/pack/mesh.obj", "scene/robots/pack/mesh.obj")
    assert finder.find("package://near.obj")[1] == "scene/robots/arm/near.obj"
    assert finder.find("package:///pack/mesh.obj") == ("robots/pack/mesh.obj", "scene/robots/pack/mesh.obj")
    assert finder.find("package:///pack/none.obj") == ("SC403", "write package://PACKAGE/PATH")
    code, hint = finder.find("package://outside/mesh.obj")
    folder = tree / "scene" / "robots" / "arm"
    assert code == "SC401"
    assert hint == f"looked for `outside/mesh.obj` in {folder} and the folders above it that may be read"


def test_package_dir_of_the_scene_is_searched_first(tree: Path) -> None:
    def in_packs(inner: str) -> ResolvedFile | Refusal:
        return resolve_path(f"packs/{inner}", base=tree / "scene", scope=finder.scope)

    finder = Finder(tree, package=in_packs)
    assert finder.find("package://pack/mesh.obj")[1] == "scene/packs/pack/mesh.obj"
    assert finder.find("package://pack/only.obj")[1] == "scene/packs/pack/only.obj"
    assert finder.find("package://arm/near.obj")[1] == "scene/robots/arm/near.obj"
    assert "the package_dir of the scene" in finder.find("package://none.obj")[1]


@pytest.mark.parametrize(
    ("reference", "code"),
    [
        ("../../../outside/mesh.obj", "SC402"),
        ("/etc/passwd", "SC402"),
        ("package:///etc/passwd", "SC403"),
        ("package:////../../../../outside/mesh.obj", "SC403"),
        ("package://../../../../outside/mesh.obj", "SC402"),
        ("package://", "SC403"),
        ("package://near.obj\\x", "SC403"),
        ("file://near.obj", "SC403"),
        ("http://example.org/near.obj", "SC403"),
        ("", "SC403"),
        ("..", "SC404"),
        ("x" * 5000, "SC401"),
        ("package://" + "../" * 500 + "x", "SC402"),
    ],
)
def test_a_file_outside_the_roots_is_refused(tree: Path, reference: str, code: str) -> None:
    assert Finder(tree).find(reference)[0] == code


def test_symbolic_links_out_of_the_roots_are_refused(tree: Path) -> None:
    (tree / "scene" / "robots" / "arm" / "way").symlink_to(tree / "outside")
    assert Finder(tree).find("way/mesh.obj")[0] == "SC402"
    assert Finder(tree).find("package://way/mesh.obj")[0] == "SC402"
