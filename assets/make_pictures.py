"""Makes the pictures of the documentation by the commands that people run.

    python assets/make_pictures.py [NAME …]

Needs the extra `test`, ManiSkill for some of them, and a device that SAPIEN renders with; Mesa's lavapipe is one. Pages
need Chromium and its driver, too.
The scenes in `docs/pictures/` give examples of `scenes/` light and a camera. Another driver shades a little otherwise.
"""

from __future__ import annotations

import io
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

ROOT: Final = Path(__file__).resolve().parents[1]
FOLDER: Final = ROOT / "docs/pictures"

LARGEST: Final = 200_000
"""Bytes of a picture in the repository."""

_SHOWN: Final = "--allow-outside-assets --camera view"
_PANDA: Final = "scenes/maniskill/PickCube-v1.yaml --camera render_camera"

PICTURES: Final = {
    "tabletop.png": f"docs/pictures/tabletop.yaml {_SHOWN}",
    "clutter.png": f"docs/pictures/clutter.yaml {_SHOWN} --grid --steps 250",
    "variants.png": f"docs/pictures/variants.yaml {_SHOWN} --grid",
    "prefabs.png": f"docs/pictures/prefabs.yaml {_SHOWN}",
    "pick_cube.png": f"{_PANDA} --size 480x480",
}
"""The arguments of `scenecc render` for each picture, run in the root of the repository."""

SHEETS: Final = {
    "what.png": {
        "color": f"{_PANDA} --size 240x240",
        "depth": f"{_PANDA} --size 240x240 --what depth",
        "segmentation": f"{_PANDA} --size 240x240 --what segmentation",
        "normal": f"{_PANDA} --size 240x240 --what normal",
        "collision": f"{_PANDA} --size 240x240 --show collision",
    },
}
"""Pictures side by side, under a word each."""

PAGES: Final = {"view.png": ("scenes/clutter.yaml --port 0", ["things/object_0"])}
"""Pages in the browser: the arguments of `scenecc view`, and what is clicked on."""

_TITLE: Final = 20
"""Height of a word above a picture [px]."""

_DRAWN: Final = 15
"""After so long a browser has drawn everything on a CPU [s]."""


def main(names: list[str]) -> None:
    """Makes the pictures of these names, or all."""
    for name in names or [*PICTURES, *SHEETS, *PAGES]:
        if name in PICTURES:
            picture = render(PICTURES[name])
        elif name in PAGES:
            picture = page(*PAGES[name])
        else:
            picture = side_by_side({word: render(arguments) for word, arguments in SHEETS[name].items()})
        save(picture, FOLDER / name)
        print(f"{name}: {(FOLDER / name).stat().st_size} bytes")


def render(arguments: str) -> Image.Image:
    """What `scenecc render` writes, as colours for people."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "picture.png")
        command = [sys.executable, "-m", "scenecc", "render", *shlex.split(arguments), "-o", str(path)]
        subprocess.run(command, cwd=ROOT, check=True)  # noqa: S603 - our own command
        with Image.open(path) as picture:
            return seen(picture)


def page(arguments: str, clicked: list[str]) -> Image.Image:
    """What a browser shows of `scenecc view`, after some buttons were clicked on."""
    command = [sys.executable, "-m", "scenecc", "view", *shlex.split(arguments)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as viewer:  # noqa: S603 - our own command
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
    options.binary_location = shutil.which("chromium") or ""
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))


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
    """Pictures of one size in a row, each under its word."""
    width, height = next(iter(pictures.values())).size
    sheet = Image.new("RGB", (width * len(pictures), height + _TITLE), "white")
    draw = ImageDraw.Draw(sheet)
    for number, (word, picture) in enumerate(pictures.items()):
        draw.text((number * width + 4, 3), word, fill="black", font_size=13)
        sheet.paste(picture, (number * width, _TITLE))
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
