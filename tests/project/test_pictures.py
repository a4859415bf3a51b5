"""The pictures of the documentation: each is there, small, and made by `assets/make_pictures.py`."""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from scenecc import validate

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs/pictures"
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
IMAGE = re.compile(r"!\[(?P<words>[^\]]*)\]\((?P<target>[^)]+)\)")


def shown() -> list[tuple[Path, str, str]]:
    return [
        (page, found["words"], found["target"]) for page in PAGES for found in IMAGE.finditer(page.read_text("utf-8"))
    ]


@pytest.fixture(scope="module")
def script() -> Any:
    return importlib.import_module("make_pictures")


def arguments(script: Any) -> list[str]:
    return [*script.PICTURES.values(), *(one for sheet in script.SHEETS.values() for one in sheet.values())]


def test_what_a_page_shows_is_there_and_says_what_it_shows(script: Any) -> None:
    assert shown()
    for page, words, target in shown():
        path = (page.parent / target).resolve()
        assert path.parent == FOLDER, f"{page.name}: {target}"
        assert path.is_file(), f"{page.name}: {target}"
        assert len(words.split()) > 2, f"{page.name}: {target} is shown without a word"


def test_every_picture_is_small_is_shown_and_is_made_by_the_script(script: Any) -> None:
    names = {path.name for path in FOLDER.glob("*.png")}
    assert names == {*script.PICTURES, *script.SHEETS, *script.PAGES, *script.WALKED}
    assert names == {Path(target).name for _, _, target in shown()}
    for name in names:
        data = (FOLDER / name).read_bytes()
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        assert len(data) <= script.LARGEST == 200_000


def test_what_the_script_renders_is_a_scene_without_fault(script: Any) -> None:
    scenes = {shlex.split(one)[0] for one in [*arguments(script), *(one for one, _ in script.PAGES.values())]}
    for scene in sorted(scenes):
        if "maniskill" in scene and importlib.util.find_spec("mani_skill") is None:
            continue
        found = validate(ROOT / scene, allow_outside_assets=True)
        assert [one for one in found if one.severity != "note"] == [], scene


def test_the_commands_take_what_the_script_gives_them(script: Any) -> None:
    import typer
    from typer.main import get_command

    from scenecc.cli.render import render
    from scenecc.cli.view import view

    pages = [one for one, _ in script.PAGES.values()]
    for function, given in ((render, [f"{one} -o picture.png" for one in arguments(script)]), (view, pages)):
        app = typer.Typer()
        app.command()(function)
        command = get_command(app)
        for one in given:
            scene, *_ = asked = shlex.split(one)
            params = command.make_context(function.__name__, asked).params
            assert scene in {params.get("scene"), *params.get("paths", ())}


def test_a_depth_is_seen_and_pictures_stand_side_by_side(script: Any, tmp_path: Path) -> None:
    import numpy as np
    from PIL import Image

    depth = np.array([[0, 1000], [2000, 65535]], dtype=np.uint16)
    picture = script.seen(Image.fromarray(depth))
    assert picture.mode == "RGB"
    rows = np.asarray(picture)[..., 0]
    assert (rows[0, 0], rows[0, 1], rows[1, 1]) == (0, 255, 0)
    assert 0 < rows[1, 0] < 255
    sheet = script.side_by_side({"one": picture, "two": picture})
    assert sheet.size == (4, 22)
    script.save(sheet, tmp_path / "sheet.png")
    noise = np.random.default_rng(0).integers(0, 255, (600, 600, 3)).astype(np.uint8)
    with pytest.raises(ValueError, match=r"noise\.png has \d+ bytes"):
        script.save(Image.fromarray(noise), tmp_path / "noise.png")
