"""A page of `scenecc view` as somebody has it who sits before the browser."""

from __future__ import annotations

import base64
import io
import re
import time
from typing import Any

import pytest
from plugins.browser import soon

# viser's folders are frames around a title and what is in them.
_TREE = r"""
const tree = {};
for (const frame of document.querySelectorAll('[data-with-border]')) {
  const title = frame.firstElementChild.innerText.trim();
  if (/^Scene \d+ \(\d+\)$/.test(title)) tree[title] = [...frame.querySelectorAll('button')].map(b => b.textContent);
}
return tree;
"""
# Of the object that three.js draws, in the frame of scenes.
_PLACE = """
const drawn = __viserMutable.nodeRefFromName[arguments[0]], root = __viserMutable.nodeRefFromName[''];
return drawn ? root.worldToLocal(drawn.getWorldPosition(drawn.position.clone())).toArray() : [];
"""
_PIXEL = """
const drawn = __viserMutable.nodeRefFromName[arguments[0]], box = __viserMutable.canvas.getBoundingClientRect();
if (!drawn) return null;
const seen = drawn.getWorldPosition(drawn.position.clone()).project(__viserMutable.camera);
const [x, y] = [seen.x * box.width / 2, -seen.y * box.height / 2];
return {x, y, inside: Math.abs(seen.x) < 1 && Math.abs(seen.y) < 1 && Math.abs(seen.z) < 1};
"""
_EYE = """
const root = __viserMutable.nodeRefFromName[''];
return root.worldToLocal(__viserMutable.camera.position.clone()).toArray();
"""
# Of a point of the page's world.
_POINT = """
const root = __viserMutable.nodeRefFromName[''], box = __viserMutable.canvas.getBoundingClientRect();
const seen = root.localToWorld(root.position.clone().fromArray(arguments[0])).project(__viserMutable.camera);
return [seen.x * box.width / 2, -seen.y * box.height / 2];
"""
_BUTTON = """
return [...document.querySelectorAll('button')].find(one => one.innerText === arguments[0]);
"""
# Of a field for text, viser's label names nothing: it stands in the same row.
_BY_LABEL = """
const label = [...document.querySelectorAll('label')].find(one => one.innerText === arguments[0]);
let row = label;
while (row && !row.querySelector('input')) row = row.parentElement;
return row && (document.getElementById(label.htmlFor) ?? row.querySelector('input'));
"""


class Page:
    """What is on it, and what can be done there.

    It asks viser's page by what viser's own tests ask it. `browser`: Selenium's driver.
    """

    def __init__(self, browser: Any, url: str) -> None:
        self.browser = browser
        browser.get(url)
        # The first picture takes seconds: shaders are compiled for the CPU, and the light around a scene is made.
        soon(lambda: self.run("return window.__viserTestpoints?.rendererInfo.render.frame"), within=60)
        soon(self.nodes, lambda nodes: len(nodes) > 3, within=60)

    def run(self, script: str, *arguments: Any) -> Any:
        """What a script returns."""
        return self.browser.execute_script(script, *arguments)

    def text(self) -> str:
        """All text that can be seen."""
        return self.run("return document.body.innerText")

    def objects(self) -> dict[str, list[str]]:
        """The tree of objects: names under the titles of their scenes."""
        return self.run(_TREE)

    def row(self, label: str) -> str:
        """Style of a button."""
        return self.run(f"{_BUTTON.strip().rstrip(';')}?.style.cssText ?? ''", label)

    def facts(self) -> str:
        """What is said of the object that was chosen, as it can be seen."""
        return self.run("return document.querySelector('.scenecc-facts')?.innerText") or ""

    def nodes(self) -> set[str]:
        """Paths of all that is drawn."""
        return set(self.run("return Object.keys(window.__viserSceneTree?.getState() ?? {})"))

    def place(self, path: str) -> tuple[float, ...]:
        """Where something is drawn [m]; () if it is not."""
        return tuple(round(number, 6) for number in self.run(_PLACE, path))

    def await_at(self, path: str, place: tuple[float, ...]) -> None:
        """Waits until something is drawn at a place [m]."""
        soon(lambda: self.place(path), lambda drawn: drawn == pytest.approx(place, abs=1e-5))

    def camera(self) -> list[float]:
        """Pose of the camera, as a matrix."""
        return self.run("return __viserMutable.camera.matrixWorld.elements")

    def eye(self) -> tuple[float, ...]:
        """Where the camera stands [m]."""
        return tuple(self.run(_EYE))

    def is_in_picture(self, path: str) -> bool:
        """Whether the middle of something lies in the picture."""
        pixel = self.run(_PIXEL, path)
        return pixel is not None and pixel["inside"]

    def steps(self) -> int:
        """How many steps were simulated, as the page says it."""
        found = re.search(r"[\d.]+ s, (\d+) step", self.text())
        assert found
        return int(found[1])

    def colours(self) -> int:
        """How many colours the picture has."""
        from PIL import Image

        # A screenshot waits for a picture of the whole page, which takes seconds while one is played.
        content = self.run("return __viserMutable.canvas.toDataURL()").partition(",")[2]
        picture = Image.open(io.BytesIO(base64.b64decode(content))).convert("RGB")
        return len(picture.getcolors(picture.width * picture.height) or ())

    def press(self, label: str) -> None:
        """Presses a button, once it stands still: the page lays its buttons out anew while a scene loads."""
        from selenium.common.exceptions import ElementNotInteractableException, StaleElementReferenceException

        def is_pressed() -> bool:
            button = self.run(_BUTTON, label)
            if button is None:
                return False
            try:
                button.click()
            except (ElementNotInteractableException, StaleElementReferenceException):
                return False
            return True

        soon(is_pressed)

    def field(self, label: str) -> Any:
        """The control that has a label."""
        return soon(lambda: self.run(_BY_LABEL, label))

    def slide(self, label: str, key: str) -> None:
        """Moves a slider by a key: HOME, END, ARROW_RIGHT."""
        from selenium.webdriver.common.keys import Keys

        self.field(label).find_element("css selector", "[role=slider]").send_keys(getattr(Keys, key))

    def write(self, label: str, text: str) -> None:
        """Writes into a field in place of what is there."""
        from selenium.webdriver.common.keys import Keys

        self.field(label).send_keys(Keys.CONTROL, "a")
        self.field(label).send_keys(text, Keys.ENTER)

    def click_on(self, path: str) -> None:
        """Clicks in the picture, on the middle of something."""
        pixel = self.run(_PIXEL, path)
        self._mouse(pixel["x"], pixel["y"]).click().perform()

    def pixel(self, point: tuple[float, ...]) -> tuple[float, float]:
        """Where a point [m] is in the picture, from its middle [px]."""
        x, y = self.run(_POINT, point)
        return x, y

    def click_at(self, point: tuple[float, ...]) -> None:
        """Clicks in the picture, on a point [m]."""
        self._mouse(*self.pixel(point)).click().perform()

    def pull(self, start: tuple[float, ...], end: tuple[float, ...]) -> None:
        """Drags what is at a point of the picture to where another one is [m]."""
        (x, y), (to_x, to_y) = self.pixel(start), self.pixel(end)
        mouse = self._mouse(x, y).click_and_hold()
        for _ in range(4):
            mouse = mouse.move_by_offset(round((to_x - x) / 4), round((to_y - y) / 4)).pause(0.2)
        mouse.release().perform()

    def drag(self, by: tuple[int, int]) -> None:
        """Drags the picture with the mouse [px], and waits until the camera has moved and come to rest."""
        before = self.camera()
        self._mouse(0, 200).click_and_hold().move_by_offset(*by).release().perform()
        soon(lambda: self.camera() != before)
        self.await_rest()

    def await_rest(self) -> None:
        """Waits until the camera stands still."""
        since, pose = time.monotonic(), self.camera()

        def rests() -> bool:
            nonlocal since, pose
            if self.camera() != pose:
                since, pose = time.monotonic(), self.camera()
            # Pictures are drawn some times a second.
            return time.monotonic() - since > 0.5

        soon(rests)

    def _canvas(self) -> Any:
        return self.browser.find_element("css selector", "canvas[data-engine]")

    def _mouse(self, x: float, y: float) -> Any:
        """The mouse at a place of the picture, from its middle [px]."""
        from selenium.webdriver import ActionChains

        return ActionChains(self.browser).move_to_element_with_offset(self._canvas(), round(x), round(y))
