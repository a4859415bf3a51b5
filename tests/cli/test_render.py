"""`scenecc render` as a process: with a device, and without one."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from plugins.videos import decoded

SCENE = """\
scenecc: 1
num_scenes: 3
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  cube: {pose: [0, 0, 0.5], shapes: [{type: box, half_size: [0.1, 0.2, 0.3], color: [1, 0, 0]}]}
cameras:
  eye: {pose: {p: [-2, 0, 1], look_at: [0, 0, 0.5]}, width: 64, height: 48, scene_idxs: [0, 1]}
"""
NOWHERE = {"VK_DRIVER_FILES": "/no/driver.json", "VK_ICD_FILENAMES": "/no/driver.json"}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_render_without_a_device_gives_an_install_hint(run, scene: Path, tmp_path: Path) -> None:
    done = run("render", scene, "-o", "out.png", **NOWHERE)
    assert (done.returncode, done.stdout) == (3, "")
    assert "error SC803: visuals were requested, but there is no render device" in done.stderr
    hint = done.stderr.partition("hint: ")[2].splitlines()
    assert hint[0].startswith("with a GPU, install its Vulkan driver")
    assert hint[1].strip().startswith("without one, Mesa's lavapipe")
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("form", ["text", "json", "github", "gitlab", "junit", "sarif"])
def test_a_fault_of_the_machine_names_no_line_of_the_scene(run, scene: Path, form: str) -> None:
    scene.rename(stage := scene.with_name("stage.yaml"))
    for command in (("build", stage, "--render"), ("render", stage, "-o", "out.png")):
        done = run(*command, "--format", form, **NOWHERE)
        assert done.returncode == 3
        assert "SC803" in done.stdout + done.stderr
        assert "stage.yaml" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "an output is needed"),
        (["-o", "out.jpg"], "'out.jpg' must end in .png"),
        (["-o", "out.avi", "--steps", "2"], "'out.avi' must end in .png, .mp4 or .gif"),
        (["-o", "out.mp4"], "a video needs --steps"),
        (["-o", "a.png", "--every", "2", "--steps", "4"], "it needs a video"),
        (["-o", "a.gif", "--every", "5", "--steps", "4"], "and at least as many --steps"),
        (["-o", "out.png", "--size", "640"], "'640' must be WIDTHxHEIGHT"),
        (["-o", "out.png", "--size", "0x5"], "'0x5' must be WIDTHxHEIGHT"),
        (["-o", "out.png", "--size", "16385x5"], "'16385x5' must be WIDTHxHEIGHT"),
        (["-o", "out.png", "--camera", "eve"], "SC911"),
        (["-o", "out.png", "--camera", "eye", "--scene", "2"], "SC911"),
        (["-o", "out.png", "--scene", "3"], "SC908"),
        (["-o", "out.png", "--grid", "--size", "16384x16384"], "SC912"),
        (["-o", "out.mp4", "--steps", "2", "--size", "4096x4096"], "SC912"),
        (["-o", "no/out.png"], "SC904"),
        (["-o", "no/out.gif", "--steps", "2"], "SC904"),
        (["-o", "scene.yaml"], "must end in .png"),
    ],
)
def test_contradictory_render_options_are_wrong_usage(run, scene: Path, arguments: list[str], told: str) -> None:
    done = run("render", scene, *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert told in done.stderr
    assert scene.read_text() == SCENE


def test_errors_of_a_scene_are_reported_before_a_missing_device(run, scene: Path) -> None:
    scene.write_text(SCENE.replace("half_size", "half_sizes"))
    done = run("render", scene, "-o", "out.png", **NOWHERE)
    assert done.returncode == 1
    assert "SC101" in done.stderr


def test_a_failed_render_keeps_the_old_file(run, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "out.png").write_bytes(b"before")
    assert run("render", scene, "-o", "out.png", **NOWHERE).returncode == 3
    assert (tmp_path / "out.png").read_bytes() == b"before"


@pytest.mark.render
@pytest.mark.quick
def test_a_picture_is_written_and_described(run, scene: Path, tmp_path: Path) -> None:
    done = run("render", scene, "--camera", "eye", "-o", "out.png", "--scene", "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "out.png: color, 64 × 48, scene 1 of 3\n"
    picture = np.asarray(Image.open(tmp_path / "out.png"))
    assert picture.shape == (48, 64, 3)
    assert picture[24, 32, 0] > 2 * picture[24, 32, 1]


@pytest.mark.render
@pytest.mark.quick
def test_a_segmentation_comes_with_its_legend(run, scene: Path, tmp_path: Path) -> None:
    done = run("render", scene, "--camera", "eye", "--what", "segmentation", "-o", "out.png")
    head, floor, cube, blank, file = done.stdout.splitlines()
    assert head.split() == ["id", "color", "name", "scenes"]
    assert [line.split() for line in (floor, cube)] == [["1", "#800000", "floor", "0"], ["2", "#008000", "cube", "0"]]
    assert (blank, file) == ("", "out.png: segmentation, 64 × 48, scene 0 of 3")
    image = Image.open(tmp_path / "out.png")
    assert np.unique(np.asarray(image)).tolist() == [0, 1, 2]
    assert image.convert("RGB").getpixel((32, 24)) == (0, 128, 0)


@pytest.mark.render
def test_an_encoder_crash_is_an_error_of_the_machine(run, scene: Path, tmp_path: Path) -> None:
    arguments = ["--camera", "eye", "--steps", "200", "--every", "1", "-o", "video.mp4"]
    done = run("render", scene, *arguments, IMAGEIO_FFMPEG_EXE="/bin/true")
    assert (done.returncode, done.stdout) == (3, "")
    assert "error SC814" in done.stderr
    assert not (tmp_path / "video.mp4").exists()


@pytest.mark.render
def test_the_suffix_chooses_a_sheet_or_a_video(run, scene: Path, tmp_path: Path) -> None:
    asked = ["render", scene, "--camera", "eye", "--grid", "--steps", "9"]
    done = run(*asked, "-o", "out.png", "--timings")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "out.png: color, 64 × 48, scenes 0, 1 of 3\n"
    assert "pictures " in done.stderr
    done = run(*asked, "--every", "3", "-o", "video.mp4", "--format", "json")
    (written,) = json.loads(done.stdout)["files"]
    wanted = {"file": "video.mp4", "what": "color", "size": [64, 48], "scene_idxs": [0, 1], "frames": 4, "legend": []}
    assert written == wanted
    sheet = np.asarray(Image.open(tmp_path / "out.png"))
    _, frames = decoded(tmp_path / "video.mp4")
    assert [frame.shape for frame in frames] == [sheet.shape] * 4


@pytest.mark.render
def test_a_picture_on_standard_output_is_described_on_standard_error(scene: Path, tmp_path: Path) -> None:
    import subprocess
    import sys

    command = [sys.executable, "-m", "scenecc", "render", str(scene), "--size", "8x6", "--what", "depth", "-o", "-"]
    done = subprocess.run(command, capture_output=True, check=True, timeout=200, cwd=Path(__file__).parents[2])
    (tmp_path / "out.png").write_bytes(done.stdout)
    picture = np.asarray(Image.open(tmp_path / "out.png"))
    assert (picture.shape, picture.dtype) == ((6, 8), np.uint16)
    assert "-: depth, 8 × 6, scene 0 of 3" in done.stderr.decode()


@pytest.mark.render
@pytest.mark.parametrize("output", [("-o", "out.png"), ("-o", "out.gif")])
def test_a_diverging_simulation_gives_no_picture(run, scene: Path, tmp_path: Path, output: tuple[str, str]) -> None:
    falls = SCENE.replace("  floor: {body_type: static, shapes: [{type: plane}]}\n", "")
    scene.write_text(f"physics: {{gravity: [0, 0, -1.0e+6], timestep: 1}}\n{falls}")
    done = run("render", scene, *output, "--steps", "20")
    assert (done.returncode, done.stdout) == (1, "")
    assert "error SC820: `cube` is beyond" in done.stderr
    assert not (tmp_path / output[1]).exists()


@pytest.mark.render
def test_rendering_many_scenes_gives_the_pictures_of_each(run, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    (tmp_path / "more/blue.yaml").write_text(SCENE.replace("[1, 0, 0]", "[0, 0, 1]"))
    (tmp_path / "more/bad.yaml").write_text(SCENE.replace("half_size", "half_sizes"))
    options = ("--camera", "eye", "--scene", "0")
    done = run("render", scene, "more", "-o", "out", "--jobs", "2", *options)
    assert done.returncode == 1
    assert done.stderr.count("error SC101") == 1
    assert [line.split(":")[0] for line in done.stdout.splitlines() if ".png" in line] == [
        "out/scene.png",
        "out/more/blue.png",
    ]
    assert run("render", "more/blue.yaml", "-o", "blue.png", *options).returncode == 0
    assert (tmp_path / "out/more/blue.png").read_bytes() == (tmp_path / "blue.png").read_bytes()
    assert not (tmp_path / "out/more/bad.png").exists()


def test_a_missing_device_is_reported_for_each_scene(run, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "other.yaml").write_text(SCENE)
    done = run("render", scene, "other.yaml", "-o", "out", **NOWHERE)
    assert (done.returncode, done.stdout, done.stderr.count("error SC803")) == (3, "", 2)


def test_only_changed_scenes_of_a_part_are_rendered(run, tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    for number in range(4):
        (tmp_path / f"scenes/s{number}.yaml").write_text(SCENE)
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", "scenes")
    git(tmp_path, "commit", "-qm", "one")
    for number in (1, 3):
        (tmp_path / f"scenes/s{number}.yaml").write_text(f"{SCENE}# changed\n")
    done = run("render", "scenes", "-o", "out", "--changed-since", "HEAD", "--shard", "1/2", **NOWHERE)
    assert done.stderr.startswith("1 of 4 files: 2 unchanged, 1 in other parts\n")
    assert done.stderr.count("error SC803") == 1
    for option in (("--shard", "1/2"), ("--changed-since", "HEAD")):
        done = run("render", "scenes/s1.yaml", "-o", "x.png", *option)
        assert f"'{option[0]}': it needs several files, or a folder" in done.stderr


def git(folder: Path, *arguments: str) -> None:
    who = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    subprocess.run(["git", *who, *arguments], cwd=folder, check=True, capture_output=True)


@pytest.mark.parametrize("arguments", [("-o", "a.gif", "--steps", "2"), ("-o", "out.png"), ("-o", "-")])
def test_many_pictures_need_a_folder(run, scene: Path, arguments: tuple[str, ...]) -> None:
    done = run("render", scene, "other.yaml", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert "-o FOLDER" in done.stderr or "name a folder after -o" in done.stderr
