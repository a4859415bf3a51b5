"""`scenecc view` in a browser: one page for all tests, whose file each of them writes anew, as an editor does."""

from __future__ import annotations

import http.server
import json
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from cli.running import plain_environment
from plugins.browser import ELSEWHERE, Viewer, console_errors, hosts_asked, soon
from plugins.command import scenecc
from plugins.page import Page

pytestmark = pytest.mark.browser

SCENES = Path(__file__).parents[2] / "scenes"
TABLETOP = (SCENES / "tabletop.yaml").read_text()
RESET = (SCENES / "reset.yaml").read_text()
BALL = """
  ball:
    pose: [0.3, 0.3, 0.05]
    shapes: [{type: sphere, radius: 0.05}]
"""
FALLING = """
scenecc: 1
entities:
  cube: {pose: [0, 0, 3], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""
ON_TABLETOP = {"Scene 0 (4)": ["ground", "table", "cube", "goal"]}
IN_RESET = ["ground", "post", "can", "ball", "marker"]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "demo.yaml"
    path.write_text(TABLETOP)
    return path


@pytest.fixture(scope="module")
def viewer(view: Callable[..., Viewer], file: Path) -> Viewer:
    return view(file)


@pytest.fixture(scope="module")
def opened(browser: Any, viewer: Viewer) -> Iterator[Page]:
    page = Page(browser, viewer.url)
    # A page that was loaded again would have forgotten it.
    page.run("window.loadedOnce = true")
    yield page
    # It would look for its server after that has ended.
    browser.get("about:blank")


@pytest.fixture
def page(opened: Page) -> Iterator[Page]:
    yield opened
    assert opened.run("return window.loadedOnce")


@pytest.fixture
def save(page: Page, file: Path) -> Callable[..., None]:
    """Saves the file and waits until the page has its objects."""

    def save(text: str, objects: dict[str, list[str]]) -> None:
        file.write_text(text)
        soon(page.objects, objects.__eq__)

    return save


@pytest.mark.quick
def test_a_page_names_its_file_and_shows_all_that_is_in_it(page: Page, save: Callable[..., None]) -> None:
    save(TABLETOP, ON_TABLETOP)
    assert "demo" in page.text()
    assert page.nodes() >= {f"/scene 0/{name}/visual 0" for name in ON_TABLETOP["Scene 0 (4)"]}
    page.await_at("/scene 0/cube", (-0.1, 0, 0.02))
    assert page.colours() > 20


def test_a_save_is_shown_where_the_camera_was_left(page: Page, save: Callable[..., None]) -> None:
    save(TABLETOP, ON_TABLETOP)
    at_first = page.camera()
    page.drag((90, -30))
    left = page.camera()
    assert left != pytest.approx(at_first, abs=0.01)
    save(TABLETOP + BALL, {"Scene 0 (5)": [*ON_TABLETOP["Scene 0 (4)"], "ball"]})
    page.await_at("/scene 0/ball", (0.3, 0.3, 0.05))
    assert page.camera() == pytest.approx(left, abs=1e-4)
    save(TABLETOP, ON_TABLETOP)
    soon(page.nodes, lambda nodes: "/scene 0/ball" not in nodes)
    assert page.camera() == pytest.approx(left, abs=1e-4)


def test_a_button_moves_the_camera_to_where_it_sees_all(page: Page, save: Callable[..., None]) -> None:
    save(TABLETOP + BALL.replace("[0.3, 0.3,", "[9, 9,"), {"Scene 0 (5)": [*ON_TABLETOP["Scene 0 (4)"], "ball"]})
    page.await_at("/scene 0/ball", (9, 9, 0.05))
    assert not page.is_in_picture("/scene 0/ball")
    page.press("See all")
    soon(lambda: page.is_in_picture("/scene 0/ball"))
    assert page.is_in_picture("/scene 0/cube")
    save(TABLETOP, ON_TABLETOP)
    page.press("See all")


def test_an_error_is_shown_over_the_last_scene_that_had_none(page: Page, file: Path, save: Callable[..., None]) -> None:
    save(TABLETOP + BALL, {"Scene 0 (5)": [*ON_TABLETOP["Scene 0 (4)"], "ball"]})
    before, objects = page.nodes(), page.objects()
    line = TABLETOP.splitlines().index("  cube:") + 4
    file.write_text(TABLETOP.replace("half_size: [0.02, 0.02,", "half_size: [0.02, -1,"))
    text = soon(page.text, lambda text: "SC104" in text)
    assert f"demo.yaml:{line}:" in text
    assert "must be greater than 0, not -1" in text
    assert (page.nodes(), page.objects()) == (before, objects)
    save(TABLETOP, ON_TABLETOP)
    soon(page.text, lambda text: "SC104" not in text)


@pytest.mark.parametrize("where", ["tree", "picture"])
def test_a_click_tells_mass_and_materials(page: Page, save: Callable[..., None], where: str) -> None:
    save(TABLETOP, ON_TABLETOP)
    page.press("goal")
    soon(page.facts, lambda facts: facts.startswith("goal"))
    if where == "tree":
        page.press("cube")
        facts = soon(page.facts, lambda facts: facts.startswith("cube"))
        assert "mass 0.0704 kg" in facts
        assert "static_friction 1\n" in facts
        assert "base_color #d62828" in facts
    else:
        page.click_on("/scene 0/table/visual 0")
        facts = soon(page.facts, lambda facts: facts.startswith("table"))
        assert "static_friction 0.6" in facts


def test_facts_go_with_what_they_are_about(page: Page, save: Callable[..., None]) -> None:
    save(FALLING, {"Scene 0 (1)": ["cube"]})
    page.press("cube")
    soon(page.facts, lambda facts: facts.startswith("cube"))
    save(FALLING.replace("cube:", "block:"), {"Scene 0 (1)": ["block"]})
    soon(page.text, lambda text: "Click a body" in text)
    assert page.facts() == ""


def test_what_a_file_says_is_text_and_nothing_else(page: Page, file: Path, save: Callable[..., None]) -> None:
    markup = "<img src=nowhere onerror='window.ran = true'>"
    shape = {"type": "box", "half_size": [1, 1, 1], "name": markup}
    params = {"text": {"type": "string", "default": markup, "description": markup}}
    save(
        json.dumps({"scenecc": 1, "params": params, "entities": {"box": {"shapes": [shape]}}}), {"Scene 0 (1)": ["box"]}
    )
    page.press("box")
    soon(page.facts, lambda facts: markup in facts)
    # An error, too, quotes what it is about.
    file.write_text(json.dumps({"scenecc": 1, "entities": {markup: {"shapes": [shape]}}}))
    soon(page.text, lambda text: f"error SC107: {markup!r}" in text)
    assert page.run("return document.querySelector(`img[src='nowhere']`) === null && window.ran === undefined")


def test_time_runs_stands_and_goes_by_steps(page: Page, save: Callable[..., None]) -> None:
    save(FALLING, {"Scene 0 (1)": ["cube"]})
    soon(page.steps, (0).__eq__)
    page.await_at("/scene 0/cube", (0, 0, 3))
    page.press("Step")
    soon(page.steps, (1).__eq__)
    # Semi-implicit Euler in steps of 10 ms.
    page.await_at("/scene 0/cube", (0, 0, 3 - 9.81e-4))
    page.press("Play")
    soon(page.steps, lambda steps: steps > 10)
    page.press("Pause")
    soon(lambda: "Play" in page.text())
    stopped = page.steps()
    height = page.place("/scene 0/cube")[2]
    assert height < 2.9
    page.press("Step")
    soon(page.steps, (stopped + 1).__eq__)
    page.press("Reset")
    soon(page.steps, (0).__eq__)
    page.await_at("/scene 0/cube", (0, 0, 3))


def test_a_reset_with_another_seed_moves_what_is_drawn_anew(page: Page, save: Callable[..., None]) -> None:
    save(RESET, {"Scene 0 (5)": IN_RESET})
    # It stands on the post, at x = 1.
    first = soon(lambda: page.place("/scene 0/can"), lambda place: place[:1] == (1,))
    post = soon(lambda: page.place("/scene 0/post"), lambda place: place[:1] == (1,))
    page.write("Seed", "7")
    page.press("Reset")
    moved = soon(lambda: page.place("/scene 0/can"), lambda place: place != first)
    assert moved[0] == first[0] == 1
    assert page.place("/scene 0/post") == post
    page.write("Seed", "0")
    page.press("Reset")
    soon(lambda: page.place("/scene 0/can"), first.__eq__)


def test_a_slider_goes_through_scenes_and_all_are_side_by_side(page: Page, save: Callable[..., None]) -> None:
    save(RESET, {"Scene 0 (5)": IN_RESET})
    page.slide("Scene", "END")
    soon(page.objects, {"Scene 3 (5)": IN_RESET}.__eq__)
    soon(page.nodes, lambda nodes: "/scene 3/can" in nodes and "/scene 0/can" not in nodes)
    page.field("Side by side").click()
    soon(page.objects, lambda objects: list(objects) == [f"Scene {number} (5)" for number in range(4)])
    soon(page.nodes, lambda nodes: nodes >= {f"/scene {number}/can" for number in range(4)})
    corners = soon(lambda: {page.place(f"/scene {number}") for number in range(4)}, lambda places: len(places) == 4)
    assert len({x for x, _, _ in corners}) == len({y for _, y, _ in corners}) == 2
    assert page.nodes() >= {f"/number {number}" for number in range(4)}
    page.field("Side by side").click()
    soon(page.objects, {"Scene 3 (5)": IN_RESET}.__eq__)
    page.slide("Scene", "HOME")
    soon(page.objects, {"Scene 0 (5)": IN_RESET}.__eq__)


def test_scenes_and_seeds_are_gone_through_with_their_draws(page: Page, save: Callable[..., None]) -> None:
    save(RESET, {"Scene 0 (5)": IN_RESET})

    def draws() -> list[str]:
        return page.run("return document.querySelector('.scenecc-draws')?.innerText ?? ''").split("\n")

    first = soon(draws, lambda lines: lines[0] == "Scene 0, seed 0" and any("post_height" in line for line in lines))
    page.press("can")
    # viser's page may update a row of the last tree after its removal, if both come together.
    soon(lambda: "orange" in page.row("can"))
    page.press("Next scene")
    soon(page.objects, {"Scene 1 (5)": IN_RESET}.__eq__)
    second = soon(draws, lambda lines: lines[0] == "Scene 1, seed 0")
    assert second[1:] != first[1:]
    assert soon(page.facts).startswith("can"), "it stays selected"
    page.press("Next seed")
    soon(draws, lambda lines: lines[0] == "Scene 1, seed 1" and lines[1:] != second[1:])
    page.press("Previous seed")
    soon(draws, second.__eq__)
    page.press("Previous scene")
    soon(draws, first.__eq__)
    page.write("Seed", "7")
    page.press("Reset")
    soon(draws, lambda lines: lines[0] == "Scene 0, seed 0, reset with seed 7" and lines[1:] != first[1:])
    page.write("Seed", "0")
    page.press("Rebuild")
    soon(draws, first.__eq__)


def test_parameters_build_the_scene_anew(page: Page, save: Callable[..., None]) -> None:
    save((SCENES / "parameters.yaml").read_text(), {"Scene 0 (4)": ["ground", "table", "block", "ball"]})
    page.await_at("/scene 0/table", (0, 0, 0.7))
    page.slide("size", "HOME")
    # So small a table has no ball.
    soon(page.objects, {"Scene 0 (3)": ["ground", "table", "block"]}.__eq__)
    soon(page.nodes, lambda nodes: "/scene 0/ball" not in nodes)
    page.write("height", "1.25")
    page.await_at("/scene 0/table", (0, 0, 1.25))
    page.write("color", "no colour")
    soon(page.text, lambda text: "no colour" in text)
    page.write("color", "'#00ff00'")
    soon(page.text, lambda text: "no colour" not in text)
    page.press("As in the file")
    soon(page.objects, {"Scene 0 (4)": ["ground", "table", "block", "ball"]}.__eq__)
    page.await_at("/scene 0/table", (0, 0, 0.7))
    assert "/scene 0/ball" in page.nodes()


def test_shapes_that_collide_are_shown_where_asked_for(page: Page, save: Callable[..., None]) -> None:
    save(TABLETOP, ON_TABLETOP)
    page.field("Collision shapes").click()
    soon(page.nodes, lambda nodes: "/scene 0/cube/collision 0" in nodes)
    assert "/scene 0/goal/collision 0" not in page.nodes()
    page.field("Collision shapes").click()
    soon(page.nodes, lambda nodes: "/scene 0/cube/collision 0" not in nodes)


CONNECT = """
const [url, protocol, done] = arguments;
const socket = new WebSocket(url, [protocol]);
socket.onopen = () => { socket.close(); done('open'); };
socket.onerror = () => done('refused');
"""


class _Empty(http.server.BaseHTTPRequestHandler):
    """Pages with nothing on them."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Keeps its words from standard error."""


@pytest.fixture
def empty_site() -> Iterator[int]:
    """The port of a site with nothing on it."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Empty) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.server_port
        server.shutdown()
        thread.join()


def test_a_page_of_another_site_cannot_talk_to_the_viewer(browser: Any, viewer: Viewer, empty_site: int) -> None:
    import viser

    address, said = viewer.url.replace("http:", "ws:"), {}
    for host in ("127.0.0.1", ELSEWHERE):
        browser.get(f"http://{host}:{empty_site}")
        assert browser.execute_script("return origin") == f"http://{host}:{empty_site}"
        said[host] = browser.execute_async_script(CONNECT, address, f"viser-v{viser.__version__}")
    assert said == {"127.0.0.1": "open", ELSEWHERE: "refused"}
    # What this test was about, and nothing else.
    assert hosts_asked(browser) <= {"127.0.0.1", ELSEWHERE, ""}
    assert all("WebSocket connection" in error for error in console_errors(browser))


def test_an_exported_page_needs_no_server(browser: Any, tmp_path: Path) -> None:
    (tmp_path / "demo.yaml").write_text(TABLETOP + BALL.replace("0.05]\n", "1]\n"))
    arguments = ["view", "demo.yaml", "-o", "page.html", "--steps", "60"]
    done = scenecc(arguments, cwd=tmp_path, stdin=b"", env=plain_environment())
    assert done.returncode == 0, done.stderr
    page = Page(browser, (tmp_path / "page.html").as_uri())
    page.await_at("/scene 0/cube", (-0.1, 0, 0.02))
    assert soon(page.colours, lambda colours: colours > 20)
    # Its looks are those of a served page: no notice of software rendering, and shadows without stripes.
    notice = "return document.getElementById('webgl-software-rendering')?.offsetHeight ?? 0"
    assert page.run(notice) == 0
    biases = (
        "return __viserMutable.scene.children.filter(one => one.isDirectionalLight).map(one => one.shadow.normalBias)"
    )
    soon(lambda: page.run(biases), lambda found: found and min(found) > 0)
    # It plays by itself.
    heights: set[float] = set()
    soon(
        lambda: heights.add(page.place("/scene 0/ball")[2]) or heights,
        lambda heights: max(heights) - min(heights) > 0.05,
    )
