"""Work on a page of `scenecc view`: what is selected, hidden, dragged, and clicked faster than it can be done."""

from __future__ import annotations

import queue
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from plugins.browser import Viewer, soon
from plugins.nightly import assert_took
from plugins.page import Page

from scenecc.selection_link import Place, SelectionLink

pytestmark = pytest.mark.browser

SCENE = """\
scenecc: 1   # for drags
params: {height: 1}
cameras:
  front: {pose: {p: [4, 0, 1], look_at: [0, 0, 0.5]}, fovy_deg: 50, width: 320, height: 240}
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  box:
    pose: [0, 0,  0.5]  # where it stands
    shapes: [{type: box, half_size: [0.3, 0.3, 0.5]}]
  tall: {pose: [0, 2, "${height}"], shapes: [{type: box, half_size: [0.1, 0.2, 1]}]}
"""
OBJECTS = {"Scene 0 (3)": ["ground", "box", "tall"]}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "work.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def runtime(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Where the page and the editor of these tests find each other, and no others."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("run")))
        yield


@pytest.fixture(scope="module")
def opened(browser: Any, view: Callable[..., Viewer], file: Path, runtime: None) -> Iterator[Page]:
    yield Page(browser, view(file, "--no-shadows").url)
    browser.get("about:blank")


@pytest.fixture
def page(opened: Page, file: Path) -> Page:
    if file.read_text() != SCENE:
        file.write_text(SCENE)
    soon(opened.objects, OBJECTS.__eq__)
    opened.await_at("/scene 0/box", (0, 0, 0.5))
    return opened


def test_it_opens_at_the_camera_of_the_file_under_its_name(page: Page) -> None:
    assert "work" in page.browser.title
    front = pytest.approx((4, 0, 1), abs=1e-3)
    soon(page.eye, front.__eq__)
    page.press("See all")
    soon(page.eye, front.__ne__)
    page.press("front")
    soon(page.eye, front.__eq__)


def test_a_search_and_a_click_find_each_other(page: Page) -> None:
    page.write("Search", "tal")
    soon(page.objects, {"Scene 0 (3)": ["tall"]}.__eq__)
    page.press("tall")
    soon(lambda: page.place("/selected"), (0, 2, 1).__eq__)
    page.write("Search", "")
    page.field("Search").send_keys(" ")
    soon(page.objects, OBJECTS.__eq__)
    page.click_on("/scene 0/box/visual 0")
    soon(lambda: page.place("/selected"), (0, 0, 0.5).__eq__)
    assert page.facts().startswith("box")
    page.field("Hidden").click()
    soon(page.nodes, lambda nodes: "/scene 0/box" not in nodes)
    page.press("Show all")
    soon(page.nodes, lambda nodes: "/scene 0/box" in nodes)


@pytest.mark.quick
def test_a_drag_changes_the_file_and_an_undo_gives_its_bytes_back(page: Page, file: Path) -> None:
    page.press("See all")
    page.press("box")
    page.field("Move").click()
    soon(page.nodes, lambda nodes: "/gizmo" in nodes)
    page.await_at("/gizmo", (0, 0, 0.5))
    page.await_rest()
    # By the arrow along y.
    page.pull((0, 0.7, 0.5), (0, 1.5, 0.5))
    text = soon(file.read_text, lambda text: text != SCENE)
    found = re.search(r"pose: \[0, ([\d.]+),  0.5\]  # where it stands", text)
    assert found, text
    assert text == SCENE.replace("[0, 0,  0.5]", f"[0, {found[1]},  0.5]")
    assert 0.4 < float(found[1]) < 1.4
    page.await_at("/scene 0/box", (0, float(found[1]), 0.5))
    page.press("Undo move")
    soon(file.read_bytes, SCENE.encode().__eq__)
    page.await_at("/scene 0/box", (0, 0, 0.5))
    page.press("tall")
    soon(page.text, lambda text: "is an expression or a form" in text)


def test_a_browser_is_given_a_picture_and_a_video(page: Page, tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="needs the extra `pictures`")
    page.browser.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    page.press("Screenshot")
    soon((tmp_path / "scene.png").exists)
    assert (tmp_path / "scene.png").read_bytes().startswith(b"\x89PNG")
    page.write("Seconds", "0.1")
    page.press("Record")
    soon((tmp_path / "scene.mp4").exists, within=60)
    assert (tmp_path / "scene.mp4").read_bytes()[4:8] == b"ftyp"
    soon(page.steps, (10).__eq__)
    page.press("Reset")
    soon(page.steps, (0).__eq__)


def test_an_editor_hears_of_a_click_and_has_what_is_at_its_cursor_selected(page: Page, file: Path) -> None:
    heard: queue.Queue[list[Place]] = queue.Queue()
    editor = SelectionLink("editor", heard.put)
    page.click_on("/scene 0/box/visual 0")
    assert heard.get(timeout=30) == [Place(str(file.resolve()), ("entities", "box"))]
    editor.send([Place(str(file.resolve()), ("entities", "tall"))])
    soon(lambda: page.place("/selected"), (0, 2, 1).__eq__)
    assert page.facts().startswith("tall")
    assert heard.empty()
    editor.close()


def test_rapid_clicks_leave_it_at_work(page: Page) -> None:
    labels = ["Play", "Reset", "box", "tall", "Step", "Rebuild", "See all", "front", "Pause", "ground"]
    page.run(
        """
        const find = label => [...document.querySelectorAll('button')].find(one => one.innerText === label);
        for (let round = 0; round < 15; round++) for (const label of arguments[0]) find(label)?.click();
        for (let round = 0; round < 15; round++)
          for (const box of document.querySelectorAll('input[type=checkbox]')) box.click();
        """,
        labels,
    )
    soon(page.text, lambda text: "Play" in text or "Pause" in text)
    if "Pause" in page.text():
        page.press("Pause")
    page.press("Reset")
    soon(page.steps, (0).__eq__)
    page.press("Step")
    assert soon(page.steps, bool) == 1
    page.press("Reset")
    soon(page.steps, (0).__eq__)
    if not page.field("Visual shapes").is_selected():
        page.field("Visual shapes").click()
    for label in ("Collision shapes", "Frames", "Names", "Shadows", "Contacts"):
        if page.field(label).is_selected():
            page.field(label).click()
    if "Show all" in page.text():
        page.press("Show all")
    soon(page.nodes, lambda nodes: "/scene 0/box/visual 0" in nodes)


def crowd(count: int) -> str:
    return (
        "scenecc: 1\nentities:\n  box:\n"
        f"    repeat: {{i: {{count: {count}}}}}\n    pose: ['${{i % 71 * 0.3}}', '${{i // 71 * 0.3}}', 0.15]\n"
        "    shapes: [{type: box, half_size: [0.14, 0.14, 0.14]}]\n"
    )


def test_five_thousand_bodies_load_nearly_as_fast_as_fifty(
    browser: Any, view: Callable[..., Viewer], tmp_path: Path
) -> None:
    taken: dict[int, float] = {}
    for count in (50, 5000):
        (tmp_path / f"{count}.yaml").write_text(crowd(count))
        start = time.monotonic()
        page = Page(browser, view(tmp_path / f"{count}.yaml", "--no-shadows").url)
        taken[count] = time.monotonic() - start
        (copies,) = [path for path in page.nodes() if path.startswith("/copies/")]
        assert page.run("return __viserMutable.nodeRefFromName[arguments[0]] != null", copies)
        assert len(page.nodes()) < 20
        if count == 50:
            # On its top, before which no other one stands. Copies can be clicked once they are drawn.
            soon(lambda page=page: page.click_at((7.5, 0, 0.29)) or page.facts().startswith("box_25"))
        browser.get("about:blank")
    assert_took(taken[5000], most=5 * taken[50] + 5)
