"""Makes the pictures of the documentation by the commands that people run.

    python assets/make_pictures.py [NAME …]

Needs the extra `test`, ManiSkill for some of them, and a device that SAPIEN renders with; Mesa's lavapipe is one. Pages
need Chromium and its driver, too.
Another driver shades a little otherwise.
"""

from __future__ import annotations

import io
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

import numpy as np
from PIL import Image, ImageDraw
from walkthrough import PAGES as TUTORIAL
from walkthrough import Walk, make_clone, pictures

from scenecc.cli.app import main as command

ROOT: Final = Path(__file__).resolve().parents[1]
FOLDER: Final = ROOT / "docs/pictures"

LARGEST: Final = 200_000
"""Bytes of a picture in the repository."""

_TABLE: Final = "scenes/tabletop.yaml --eye 1.75,-1.45,0.95 --look-at 0.02,0.02,-0.33 --zoom 0.65"
_PREFABS: Final = "docs/pictures/prefabs.yaml --eye 2.5,-0.75,1.6 --look-at 0,0.02,0.38 --zoom 0.85"
_NINE: Final = "--num-scenes 9 --grid --samples 8"
_STACK: Final = "scenes/stack.yaml --samples 8"
_PANDA: Final = "scenes/maniskill/PickCube-v1.yaml --camera render_camera"

PICTURES: Final = {
    "stack.png": f"{_STACK} --size 640x420",
    "tabletop.png": f"{_TABLE} --samples 8 --size 640x400",
    "clutter.png": f"scenes/recipes/clutter.yaml --focus bin/bin --set count=30 --steps 250 {_NINE} --size 240x180",
    "variants.png": f"scenes/variants.yaml --zoom 0.8 --steps 100 {_NINE} --size 240x160",
    "prefabs.png": f"{_PREFABS} --samples 8 --size 720x440",
    "pick_cube.png": f"{_PANDA} --size 480x480",
}
"""The arguments of `scenecc render` for each picture, run in the root of the repository."""

SHEETS: Final = {
    "presets.png": {preset: f"{_STACK} --size 300x225 --preset {preset}" for preset in ("studio", "plain", "dark")},
    "overlays.png": {
        "--labels": f"{_STACK} --size 300x225 --labels",
        "--ground": f"{_STACK} --size 300x225 --ground",
        "--frames": f"{_STACK} --size 300x225 --frames",
        "--contacts --steps 100": f"{_STACK} --size 300x225 --steps 100 --contacts",
    },
    "legends.png": {
        "--what depth --legend": "scenes/clutter.yaml --size 320x240 --what depth --legend",
        "--what segmentation --legend": "scenes/clutter.yaml --size 320x240 --what segmentation --legend",
    },
    "what.png": {
        "color": f"{_PANDA} --size 240x240",
        "depth": f"{_PANDA} --size 240x240 --what depth",
        "segmentation": f"{_PANDA} --size 240x240 --what segmentation",
        "normal": f"{_PANDA} --size 240x240 --what normal",
        "collision": f"{_PANDA} --size 240x240 --show collision",
    },
}
"""Pictures side by side, under a word each."""

WALKED: Final = pictures()
"""What the commands of the tutorial write: the name of the picture, and the reader's file."""

PAGES: Final = {"view.png": ("scenes/clutter.yaml --port 0", ["object_0"])}
"""Pages in the browser: the arguments of `scenecc view`, and what is clicked on."""

_TITLE: Final = 20
"""Height of a word above a picture [px]."""

_DRAWN: Final = 15
"""After so long a browser has drawn everything on a CPU [s]."""


def main(names: list[str]) -> None:
    """Makes the pictures of these names, or all."""
    asked = names or [*PICTURES, *SHEETS, *PAGES, *WALKED]
    walked = walk() if WALKED.keys() & {*asked} else {}
    for name in asked:
        if name in walked:
            picture = walked[name]
        elif name in PICTURES:
            picture = render(PICTURES[name])
        elif name in PAGES:
            picture = page(*PAGES[name])
        else:
            picture = side_by_side({word: render(arguments) for word, arguments in SHEETS[name].items()})
        save(picture, FOLDER / name)
        print(f"{name}: {(FOLDER / name).stat().st_size} bytes")


def render(arguments: str) -> Image.Image:
    """What `scenecc render` writes, as colours for people. One process, so that shaders are compiled once."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "picture.png")
        os.chdir(ROOT)
        sys.argv = ["scenecc", "render", *shlex.split(arguments), "-o", str(path)]
        try:
            command()
        except SystemExit as end:
            if end.code:
                raise
        with Image.open(path) as picture:
            return seen(picture)


def walk() -> dict[str, Image.Image]:
    """What a reader of the tutorial sees."""
    with tempfile.TemporaryDirectory() as folder:
        reader = Walk(
            make_clone(Path(folder)),
            {**os.environ, "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])},
            wanted=lambda step: step.mark == "render",
            seen=lambda _, block: sys.stdout.writelines(each.printed for each in block),
        )
        for each in TUTORIAL:
            reader.read(each)
        return {name: Image.open(reader.folder / file).convert("RGB") for name, file in WALKED.items()}


def page(arguments: str, clicked: list[str]) -> Image.Image:
    """What a browser shows of `scenecc view`, after some buttons were clicked on."""
    viewing = [sys.executable, "-m", "scenecc", "view", *shlex.split(arguments)]
    with subprocess.Popen(viewing, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewer:  # noqa: S603 - our own command
        assert viewer.stdout is not None
        browser = _browser()
        try:
            browser.get(viewer.stdout.readline().strip())
            time.sleep(_DRAWN)
            # Software that draws is told of at the top of the page.
            for notice in browser.find_elements("css selector", ".mantine-Notification-closeButton"):
                notice.click()
            for text in clicked:
                browser.find_element("xpath", f"//button[normalize-space()='{text}']").click()
            time.sleep(_DRAWN)
            return Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
        finally:
            browser.quit()
            viewer.send_signal(signal.SIGINT)


def _browser() -> Any:
    from selenium import webdriver  # noqa: PLC0415 - for pages alone

    options = webdriver.ChromeOptions()
    for flag in ("headless=new", "no-sandbox", "window-size=1280,840", "use-angle=swiftshader"):
        options.add_argument(f"--{flag}")
    options.add_argument("--enable-unsafe-swiftshader")
    # As `.ci/chromium` names them, or those of the machine.
    options.binary_location = os.environ.get("SCENECC_TEST_CHROMIUM") or shutil.which("chromium") or ""
    driver = os.environ.get("SCENECC_TEST_CHROMEDRIVER") or shutil.which("chromedriver")
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))


def seen(picture: Image.Image) -> Image.Image:
    """A picture as eyes see it: a depth [mm] from white, near, to black, far; nothing is black too."""
    if not picture.mode.startswith("I"):
        return picture.convert("RGB")
    depth = np.asarray(picture, dtype=np.float64)
    known = depth[depth > 0]
    low, high = np.percentile(known, [0, 90])
    shade = np.where(depth > 0, 1 - np.clip((depth - low) / (high - low), 0, 1), 0)
    return Image.fromarray((shade * 255).astype(np.uint8)).convert("RGB")


def side_by_side(pictures: dict[str, Image.Image]) -> Image.Image:
    """Pictures of one height in a row, each under its word."""
    width = sum(picture.width for picture in pictures.values())
    sheet = Image.new("RGB", (width, next(iter(pictures.values())).height + _TITLE), "white")
    draw = ImageDraw.Draw(sheet)
    left = 0
    for word, picture in pictures.items():
        draw.text((left + 4, 3), word, fill="black", font_size=13)
        sheet.paste(picture, (left, _TITLE))
        left += picture.width
    return sheet


def save(picture: Image.Image, path: Path) -> None:
    """Writes a PNG of at most `LARGEST` bytes, in fewer colours where it takes that.

    Raises:
        ValueError: it is larger all the same.
    """
    picture.save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        picture.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path.name} has {path.stat().st_size} bytes, more than {LARGEST}")


if __name__ == "__main__":
    main(sys.argv[1:])
