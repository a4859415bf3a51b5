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
environment: {ambient_light: [0.5, 0.5, 0.5]}
lights:
  sun: {type: directional, direction: [-1, -1, -2], color: [0.8, 0.8, 0.8], shadow: true}
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  box:
    pose: [0, 0,  0.5]  # where it stands
    shapes: [{type: box, half_size: [0.3, 0.3, 0.5]}]
  tall: {pose: [0, 2, "${height}"], shapes: [{type: box, half_size: [0.1, 0.2, 1]}]}
  chest:
    pose: [0, -1.5, 0]
    fix_root_link: true
    root:
      name: case
      shapes: [{type: box, half_size: [0.2, 0.2, 0.2], pose: [0, 0, 0.2]}]
      children:
        - name: drawer
          joint: {name: slide, type: prismatic, origin: [0.25, 0, 0.2], axis: x, limits: [0, 0.3]}
          shapes: [{type: box, half_size: [0.05, 0.15, 0.1]}]
"""
OBJECTS = {"Scene 0 (4)": ["ground", "box", "tall", "case", "drawer"]}
ROW = "[...document.querySelectorAll('button')].find(one => one.innerText === arguments[0])"
FOLDER = """
const titles = [...document.querySelectorAll('[data-with-border] > .mantine-Paper-root')];
titles.find(one => one.innerText === 'chest').click();
"""
IN_FRONT = """
let found = [];
__viserMutable.nodeRefFromName[arguments[0]]?.traverse(({material}) => { if (material) found.push(material) });
return found.some(one => one.userData.isNearer || one.depthTest === false);
"""
LIGHTS = """
let scene = __viserMutable.scene, found = [];
while (scene.parent) scene = scene.parent;
scene.traverse(one => {
  if (one.isLight) found.push([one.type, +one.intensity.toFixed(3), one.shadow?.normalBias ?? 0]);
});
return found;
"""


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
    soon(page.objects, {"Scene 0 (4)": ["tall"]}.__eq__)
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
    # By the arrow along y, whose length in pixels does not depend on the distance.
    reach = 105 / (page.pixel((0, 1, 0.5))[0] - page.pixel((0, 0, 0.5))[0])
    page.pull((0, reach, 0.5), (0, reach + 0.8, 0.5))
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


def test_what_is_selected_is_marked_in_the_tree_and_seen_through_others(page: Page) -> None:
    page.press("See all")
    page.press("ground")
    page.click_on("/scene 0/chest/drawer/visual 0")
    soon(lambda: "orange" in page.row("drawer"))
    assert "orange" not in page.row("ground")
    soon(lambda: page.run(IN_FRONT, "/selected"))
    # A closed folder shows the selected row and no other.
    page.run(FOLDER)
    soon(lambda: page.run(f"return {ROW}.offsetHeight", "case"), (0).__eq__)
    assert page.run(f"return {ROW}.offsetHeight", "drawer") > 10
    page.run(FOLDER)
    soon(lambda: page.run(f"return {ROW}.offsetHeight", "case"))


def test_a_slider_moves_a_joint_and_the_page_tells_where_the_link_is(page: Page, file: Path) -> None:
    page.press("drawer")
    soon(page.text, lambda text: "now at [0.25, -1.5, 0.2] m" in text)
    page.slide("slide", "END")
    page.await_at("/scene 0/chest/drawer", (0.55, -1.5, 0.2))
    soon(page.text, lambda text: "now at [0.55, -1.5, 0.2] m" in text)
    assert file.read_text() == SCENE
    page.press("Reset")
    page.await_at("/scene 0/chest/drawer", (0.25, -1.5, 0.2))


def test_names_of_links_are_those_of_the_selected_articulation(page: Page) -> None:
    def is_named(link: str) -> bool:
        return page.run("return __viserSceneTree.getState()[arguments[0]].visibility", f"/scene 0/chest/{link}/name")

    page.press("box")
    page.field("Names").click()
    soon(page.nodes, lambda nodes: nodes >= {f"/scene 0/{body}/name" for body in ("box", "chest/case", "chest/drawer")})
    assert is_named("case")
    assert not is_named("drawer")
    page.press("drawer")
    soon(lambda: is_named("drawer"))
    page.field("Names").click()


def test_collision_shapes_and_contacts_are_in_front_of_what_is_seen(page: Page) -> None:
    page.field("Collision shapes").click()
    soon(lambda: page.run(IN_FRONT, "/scene 0/box/collision 0"))
    assert not page.run(IN_FRONT, "/scene 0/box/visual 0")
    page.field("Collision shapes").click()
    page.field("Contacts").click()
    page.press("Step")
    soon(page.nodes, lambda nodes: "/contacts" in nodes)
    soon(lambda: page.run(IN_FRONT, "/contacts"))
    page.field("Contacts").click()
    page.press("Reset")
    soon(page.steps, (0).__eq__)


def test_overlaps_are_red_and_findings_are_links_to_lines(page: Page, file: Path) -> None:
    file.write_text(SCENE.replace("pose: [0, 2,", "pose: [0, 0.4,"))
    page.await_at("/scene 0/tall", (0, 0.4, 1))
    page.press("Check")
    soon(page.text, lambda text: "SC850" in text)
    soon(page.nodes, lambda nodes: nodes >= {"/overlap 0", "/overlap 1"})
    soon(lambda: page.run(IN_FRONT, "/overlap 0"))
    line = SCENE.splitlines().index("  box:") + 1
    links = page.run("return [...document.querySelectorAll('.scenecc-findings a')].map(one => one.href)")
    assert any(f"work.yaml:{line}:" in link for link in links), links
    file.write_text(SCENE.replace("0.3, 0.3, 0.5", "0.3, 0.3, -1"))
    soon(page.text, lambda text: "SC104" in text)
    error = "const told = document.querySelector('.scenecc-message'); return "
    assert "monospace" in page.run(f"{error} getComputedStyle(told).fontFamily")
    assert page.run(f"{error} told.querySelector('a').href").startswith("vscode://file/")


def test_lights_are_those_of_the_file_on_request_and_shadows_have_a_bias(page: Page) -> None:
    page.field("Lights of the file").click()
    soon(lambda: sorted(page.run(LIGHTS)), [["AmbientLight", 1.571, 0], ["DirectionalLight", 0.8, 0]].__eq__)
    page.field("Shadows").click()
    soon(lambda: [kind for kind, _, bias in page.run(LIGHTS) if bias > 0], lambda kinds: "DirectionalLight" in kinds)
    page.field("Lights of the file").click()
    soon(lambda: "AmbientLight" not in [kind for kind, _, _ in page.run(LIGHTS)])
    page.field("Shadows").click()
    soon(lambda: [kind for kind, *_ in page.run(LIGHTS)], ["DirectionalLight"].__eq__)


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
    for label in ("Collision shapes", "Frames", "Names", "Lights of the file", "Shadows", "Contacts"):
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
