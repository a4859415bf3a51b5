"""The browser by itself: where this fails, no other test in a browser can pass."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = [pytest.mark.browser, pytest.mark.quick]

DRAW = """
const gl = document.createElement('canvas').getContext('webgl2');
gl.clearColor(1, 0, 0.2, 1);
gl.clear(gl.COLOR_BUFFER_BIT);
const pixel = new Uint8Array(4);
gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
return [...pixel];
"""


def test_webgl_draws_without_a_gpu(browser: Any) -> None:
    browser.get("data:text/html,<title>a page</title>")
    assert browser.title == "a page"
    assert browser.execute_script(DRAW) == [255, 0, 51, 255]
