"""`scenecc emit --to mjcf` and `--to urdf`, as processes."""

from __future__ import annotations

from pathlib import Path

from cli.running import CUBE

TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
SCENES = Path(__file__).parents[2] / "scenes"


def test_a_model_is_written_with_a_folder_of_meshes(run, tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text(TETRA)
    shape = "{type: convex_mesh, file: part.obj}"
    (tmp_path / "scene.yaml").write_text(CUBE.replace("{type: box, half_size: [0.1, 0.2, 0.3]}", shape))
    done = run("emit", "scene.yaml", "--to", "mjcf", "-o", "model.xml")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    text = (tmp_path / "model.xml").read_text()
    meshes = sorted(path.name for path in (tmp_path / "model.assets").iterdir())
    assert len(meshes) == 2  # what collides, and what is seen
    assert all(f'file="{name}"' in text for name in meshes)
    again = run("emit", "scene.yaml", "--to", "mjcf", "-o", "model.xml")
    assert again.returncode == 0
    assert sorted(path.name for path in (tmp_path / "model.assets").iterdir()) == meshes


def test_emit_refuses_several_files_on_standard_output(run, cube: Path, tmp_path: Path) -> None:
    done = run("emit", cube, "--to", "mjcf")
    assert done.returncode == 0
    assert done.stdout.startswith("<?xml")
    (tmp_path / "part.obj").write_text(TETRA)
    shape = "{type: convex_mesh, file: part.obj}"
    (tmp_path / "scene.yaml").write_text(CUBE.replace("{type: box, half_size: [0.1, 0.2, 0.3]}", shape))
    done = run("emit", "scene.yaml", "--to", "mjcf")
    assert (done.returncode, done.stdout) == (2, "")
    assert "SC904" in done.stderr
    assert "standard output can hold only one file, but there are 3" in done.stderr


def test_a_missing_scene_index_is_wrong_usage(run, cube: Path) -> None:
    done = run("emit", cube, "--to", "mjcf", "--scene", "7", "-o", "model.xml")
    assert (done.returncode, done.stdout) == (2, "")
    assert "SC908" in done.stderr


def test_options_of_other_targets_are_wrong_usage(run, cube: Path) -> None:
    for options, words in (
        (("--to", "python", "--scene", "0"), "python does not support `scene`"),
        (("--to", "mjcf", "--grid"), "mjcf does not support `grid`, which is only for glb"),
        (("--to", "mjcf", "--entity", "cube"), "mjcf does not support `entity`, which is only for urdf"),
        (("--to", "urdf", "--show", "collision"), "urdf does not support `show`"),
    ):
        done = run("emit", cube, *options)
        assert (done.returncode, done.stdout) == (2, "")
        assert words in " ".join(done.stderr.split()), done.stderr


def test_urdf_goes_to_a_file_or_a_folder(run, cube: Path, tmp_path: Path) -> None:
    arms = SCENES / "robot_arm.yaml"
    done = run("emit", arms, "--to", "urdf", "--entity", "arm", "-o", "arm.urdf")
    assert done.returncode == 0
    assert "warning SC740" in done.stderr
    assert (tmp_path / "arm.urdf").read_text().startswith("<?xml")
    assert run("emit", arms, "--to", "urdf", "-o", "robots").returncode == 0
    assert sorted(path.name for path in (tmp_path / "robots").iterdir()) == ["arm.urdf", "tumbling.urdf"]
    again = run("emit", arms, "--to", "urdf", "-o", "robots")
    assert again.returncode == 2
    assert "the folder `robots` is not empty" in again.stderr
    several = run("emit", arms, "--to", "urdf", "-o", "both.urdf")
    assert several.returncode == 2
    assert "SC915" in several.stderr
    assert not (tmp_path / "both.urdf").exists()
    assert "choose a body as `--entity`, as a one-link robot" in run("emit", cube, "-o", "cube.urdf").stderr


def test_the_output_suffix_must_fit_the_target(run, cube: Path, tmp_path: Path) -> None:
    for target, name, words in (
        ("glb", "out.xml", "'out.xml' must end in .glb"),
        ("glb", "out", "'out' must end in .glb"),
        ("mjcf", "out.urdf", "'out.urdf' must end in .xml or .mjcf"),
        ("usd", "out.usdz", "'out.usdz' must end in .usda or .usd or .usdc"),
        ("urdf", "out.glb", "'out.glb' must end in .urdf or .xml, or leave out --to: .glb is glb"),
        ("json", "out.png", "'out.png' must end in .json"),
        ("python", "out.txt", "'out.txt' must end in .py"),
        ("json", "out.py", "'out.py' must end in .json, or leave out --to: .py is python"),
    ):
        done = run("emit", cube, "--to", target, "-o", name)
        assert (done.returncode, done.stdout) == (2, "")
        assert words in " ".join(done.stderr.replace("│", " ").split()), done.stderr
        assert not (tmp_path / name).exists()
    for name in ((), ("-o", "out.txt"), ("-o", "robots")):
        assert (
            "give --to, or an output -o FILE with one of the suffixes .py (python)" in run("emit", cube, *name).stderr
        )
    assert run("emit", cube, "--to", "urdf", "--entity", "cube", "-o", "cubes").returncode == 2
    assert run("emit", cube, "--to", "mjcf", "-o", "OUT.XML").returncode == 0


def test_the_suffix_of_the_output_selects_the_target(run, cube: Path, tmp_path: Path) -> None:
    starts = {
        "a.py": b"# A script",
        "a.plan.json": b"{",
        "a.glb": b"glTF",
        "a.xml": b"<mujoco",
        "a.usda": b"#usda",
        "a.usdc": b"PXR-USDC",
    }
    for name, start in starts.items():
        assert run("emit", cube, "-o", name).returncode == 0
        assert start in (tmp_path / name).read_bytes()[:200]
