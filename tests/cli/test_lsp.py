"""`scenecc lsp` as editors talk to it."""

import os
import queue
import signal
import time
from pathlib import Path

import pytest
import typer
from plugins.language_client import LanguageClient
from plugins.nightly import assert_took

from scenecc.cli.lsp import lsp
from scenecc.extras import EXTRAS, Extra
from scenecc.selection_link import Place, SelectionLink

BOX = "shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]"

SCENE = f"""scenecc: 1
entities:
  table: {{body_type: static, {BOX}}}
  cube:
    pose: {{p: [0, 0, 1], relative_to: table}}
    {BOX}
"""


@pytest.fixture(scope="module", autouse=True)
def runtime(tmp_path_factory):
    """Where servers and pages of these tests find one another, and no others."""
    above = tmp_path_factory.mktemp("run")  # the path of a socket is short
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(above))
        yield above


@pytest.fixture(scope="module")
def client(tmp_path_factory, runtime):
    folder = tmp_path_factory.mktemp("editor").resolve()
    made = LanguageClient(folder)
    made.initialize(folder, shows=True)
    yield made
    made.kill()


@pytest.fixture
def scene(client, tmp_path):
    """A file that is open."""
    path = tmp_path.resolve() / "a.scene.yaml"
    path.write_text(SCENE)
    assert client.open(path) == []
    yield path
    client.close(path)
    assert client.findings(path, None) == []


def checked(client, path, text):
    return client.findings(path, client.change(path, text))


def test_findings_follow_what_is_typed(client, scene):
    (found,) = checked(client, scene, SCENE.replace("relative_to: table", "relative_to: tabel"))
    assert (found["code"], found["severity"], found["source"]) == ("SC303", 1, "scenecc")
    assert "did you mean `table`?" in found["message"]
    assert found["range"]["start"]["line"] == 4
    assert scene.read_text() == SCENE
    assert checked(client, scene, SCENE) == []


def test_an_incomplete_file_has_one_error_at_its_place(client, scene):
    (found,) = checked(client, scene, SCENE + "  lamp: {pose: [0, 0, 2], ")
    assert found["code"] in {"SC003", "SC004", "SC007"}
    assert found["range"]["start"]["line"] >= 6
    assert checked(client, scene, SCENE) == []


def test_a_byte_order_mark_is_not_text(client, scene):
    (found,) = checked(client, scene, "\ufeff" + SCENE.replace("relative_to: table", "relative_to: tabel"))
    assert (found["code"], found["range"]["start"]["line"]) == ("SC303", 4)


def test_columns_count_utf_16_units(client, scene):
    text = SCENE.replace("p: [0, 0, 1]", 'p: [0, 0, 1], x-note: "😀😀"').replace("table}", "tabel}")
    (found,) = checked(client, scene, text)
    line = text.splitlines()[4]
    start = len(line[: line.index("tabel")].encode("utf-16-le")) // 2
    assert found["range"]["start"] == {"line": 4, "character": start}
    assert found["range"]["end"] == {"line": 4, "character": start + 5}


def test_a_name_after_utf_16_pairs_is_found(client, scene):
    text = SCENE.replace("p: [0, 0, 1]", 'p: [0, 0, 1], x-note: "😀😀"')
    assert checked(client, scene, text) == []
    line = text.splitlines()[4]
    column = len(line[: line.index("table")].encode("utf-16-le")) // 2
    assert client.at("definition", scene, 4, column)["range"]["start"] == {"line": 2, "character": 2}


def test_unsaved_text_of_another_file_counts(client, scene):
    part = scene.with_name("part.yaml")
    part.write_text(f"scenecc: 1\nmaterials: {{oak: {{}}}}\nentities:\n  lamp: {{{BOX}}}\n")
    client.open(part)
    text = "include: [part.yaml]\n" + SCENE.replace("relative_to: table", "relative_to: lamp").replace(
        "cube:\n", "cube:\n    material: oak\n"
    )
    assert checked(client, scene, text) == []
    client.change(part, part.read_text().replace("lamp", "torch"))
    (found,) = client.findings(scene, 2)
    assert "lamp" in found["message"]
    # What is wrong in a part shows in the part, and nothing that is only so without the whole.
    version = client.change(part, part.read_text().replace("half_size", "half_sise"))
    (found,) = client.findings(part, version)
    assert "half_sise" in found["message"]
    assert "included from here" in str(found["relatedInformation"])
    client.close(part)


def test_a_change_on_the_disk_updates_findings(client, scene):
    text = SCENE + "  arm: {urdf: arm.urdf, pose: [3, 0, 0]}\n"
    (found,) = checked(client, scene, text)
    assert found["code"] == "SC401"
    robot = scene.with_name("arm.urdf")
    robot.write_text('<robot name="arm"><link name="base"/></robot>')
    client.notify("workspace/didChangeWatchedFiles", changes=[{"uri": robot.as_uri(), "type": 1}])
    assert "SC401" not in {one["code"] for one in client.findings(scene, 2)}


def test_a_file_that_is_not_a_scene_has_no_findings(client, tmp_path):
    path = tmp_path / "b.yaml"
    assert client.open(path, "jobs: [build: 1") == []
    client.close(path)


def test_hover_shows_size_and_mass(client, scene):
    for _ in range(20):  # while the engine starts, the rest is told
        told = client.at("hover", scene, 3, 3)
        assert told["contents"]["kind"] == "markdown"
        assert "entity `cube`" in told["contents"]["value"]
        if "mass" in told["contents"]["value"]:
            break
    for part in ("entity `cube` (dynamic)", "mass 8 kg", "size 0.2 × 0.2 × 0.2 m"):
        assert part in told["contents"]["value"]
    assert client.at("hover", scene, 4, 6)["contents"]["value"].startswith("Pose in the world")
    assert client.at("hover", scene, 6, 0) is None


def test_completion_replaces_the_typed_text(client, scene):
    client.change(scene, SCENE + "    body_type: sta")
    items = client.at("completion", scene, 6, 18)["items"]
    edit = next(item["textEdit"] for item in items if item["label"] == "static")
    assert edit["range"] == {"start": {"line": 6, "character": 15}, "end": {"line": 6, "character": 18}}


def test_a_rename_changes_every_use(client, scene):
    column = SCENE.splitlines()[4].index("table")
    place = client.at("prepareRename", scene, 4, column)
    assert place["placeholder"] == "table"
    assert place["range"]["end"] == {"line": 4, "character": column + 5}
    changes = client.at("rename", scene, 4, column, newName="desk")["changes"][scene.as_uri()]
    assert sorted((one["range"]["start"]["line"], one["newText"]) for one in changes) == [(2, "desk"), (4, "desk")]
    refused = client.at("rename", scene, 4, column, newName="cube")
    assert refused["code"] == -32803
    assert "already among the entities" in refused["message"]


def test_a_rename_that_breaks_an_expression_is_refused(client, scene):
    text = SCENE.replace("relative_to: table", "relative_to: \"${'ta' + 'ble'}\"")
    assert checked(client, scene, text) == []
    refused = client.at("rename", scene, 2, 3, newName="desk")
    assert "it would cause an error in line 5" in refused["message"]


def quick_fixes(client, scene, text, line, **context):
    """Title of each quick fix of a 0-based line → the text after it."""
    checked(client, scene, text)
    place = {"start": {"line": line, "character": 0}, "end": {"line": line, "character": 0}}
    asked = {"textDocument": {"uri": scene.as_uri()}, "range": place, "context": {"diagnostics": [], **context}}
    found = {}
    for action in client.ask("textDocument/codeAction", asked):
        assert len(action["diagnostics"]) == 1
        edits = action["edit"]["changes"][scene.as_uri()]
        found[action["title"]] = with_edits(text, edits)
    return found


def with_edits(text, edits):
    """A text after edits in the protocol's notation."""
    lines = text.splitlines(keepends=True)

    def index(place):
        before = (
            lines[place["line"]].encode("utf-16-le")[: 2 * place["character"]] if place["line"] < len(lines) else b""
        )
        return sum(map(len, lines[: place["line"]])) + len(before.decode("utf-16-le"))

    for edit in sorted(edits, key=lambda one: -index(one["range"]["start"])):
        text = text[: index(edit["range"]["start"])] + edit["newText"] + text[index(edit["range"]["end"]) :]
    return text


def test_quick_fixes_come_from_findings(client, scene):
    wrong = SCENE.replace("relative_to: table", "relative_to: tabel")
    assert quick_fixes(client, scene, wrong, 4) == {"Change to `table`": SCENE}
    wrong = SCENE.replace("relative_to", "relativ_to")
    assert quick_fixes(client, scene, wrong, 4) == {"Write `relative_to`": SCENE}
    assert quick_fixes(client, scene, wrong, 4, only=["source.fixAll"]) == {}
    assert quick_fixes(client, scene, SCENE, 4) == {}


def test_quick_fixes_do_what_a_hint_says(client, scene):
    end = SCENE.count("\n")
    color = '    color: "#ff0000"  # 😀\n'
    found = quick_fixes(client, scene, SCENE + color.replace('"#ff0000"', "red"), end)
    assert found == {'Write `color: "#ff0000"`': SCENE + color}
    (after,) = quick_fixes(client, scene, SCENE + "    friction: 0.5\n", end).values()
    assert after == SCENE + "    material: {physical: {static_friction: 0.5, dynamic_friction: 0.5}}\n"
    (after,) = quick_fixes(client, scene, SCENE + "    num_envs: 4\n", end).values()
    assert after == SCENE.replace("entities", "num_scenes: 4\nentities")
    found = quick_fixes(client, scene, SCENE + "    mass: 0\n", end)
    assert found == {"Remove `mass`": SCENE, "Write `body_type: static`": SCENE + "    body_type: static\n"}
    wrong = SCENE.replace("relative_to: table", "relative_to: lamp")
    assert [*quick_fixes(client, scene, wrong, 4)] == ["Change to `table`"], "what is known"
    # What would only cause another error is not offered.
    assert quick_fixes(client, scene, SCENE + "    com: [[0, 0, 0]]\n", end) == {}


def test_uses_of_the_name_at_the_cursor_are_highlighted(client, scene):
    column = SCENE.splitlines()[4].index("table")
    found = client.at("documentHighlight", scene, 4, column)
    places = [(one["range"]["start"]["line"], one["range"]["start"]["character"], one["kind"]) for one in found]
    assert places == [(2, 2, 3), (4, column, 2)]
    assert client.at("documentHighlight", scene, 4, 4) == []


class Page:
    """The end of a page, and what it hears of where the cursor is."""

    def __init__(self):
        self.heard = queue.Queue()
        self.link = SelectionLink("page", self.heard.put)

    def names(self, client, path, line, character):
        """The entity of which it is told."""
        client.at("documentHighlight", path, line, character)
        ((file, (section, name)),) = self.heard.get(timeout=20)
        assert (file, section) == (str(path), "entities")
        return name


@pytest.fixture
def page(client):
    made = Page()
    yield made
    made.link.close()


def test_a_page_receives_the_entity_at_the_cursor(client, scene, page):
    text = SCENE + "\n  # a note\nnum_scenes: 2\n"
    assert checked(client, scene, text) == []
    assert [page.names(client, scene, line, 0) for line in (2, 3, 4, 5, 6, 7)] == ["table", *["cube"] * 5]
    assert page.names(client, scene, 5, 1000) == "cube"
    for line in (0, 1, 8, 1000):
        client.at("documentHighlight", scene, line, 9)
    assert page.names(client, scene, 2, 30) == "table"


def shown(client):
    """Where the editor is asked to show something."""
    asked = client.wait(lambda one: one.get("method") == "window/showDocument")
    client.send({"id": asked["id"], "result": {"success": True}})
    assert asked["params"]["takeFocus"] is False
    return asked["params"]["uri"], asked["params"]["selection"]["start"]


def test_a_click_on_a_page_shows_where_the_entity_is_written(client, scene, page):
    # As the editor holds it, which is not saved.
    assert checked(client, scene, "# a note\n" + SCENE) == []
    page.link.send([Place(str(scene), ("entities", "cube"))])
    assert shown(client) == (scene.as_uri(), {"line": 4, "character": 2})
    # In a prefab that is not open: where it is used.
    page.link.send([Place("/a/prefab.yaml", ("entities", "top")), Place(str(scene), ("entities", "table"))])
    assert shown(client) == (scene.as_uri(), {"line": 3, "character": 2})


def test_links_open_included_files(client, scene, page):
    part = scene.with_name("part.yaml")
    part.write_text(f"scenecc: 1\nentities:\n  lamp: {{pose: [4, 0, 0], {BOX}}}\n")
    assert checked(client, scene, "include: [part.yaml]\n" + SCENE) == []
    page.link.send([Place(str(part), ("entities", "lamp"))])
    assert shown(client) == (part.as_uri(), {"line": 2, "character": 2})


def test_a_click_on_an_entity_of_a_closed_file_shows_nothing(client, scene, page):
    for file, path in (
        ("/etc/passwd", ("entities", "cube")),
        (str(scene.with_name("b.yaml")), ("entities", "cube")),
        (str(scene), ("entities", "lamp")),
        (str(scene), ("entities", -1)),
        (str(scene), ()),
    ):
        page.link.send([Place(file, path)])
    page.link.send([Place(str(scene), ("entities", "table"))])
    assert shown(client) == (scene.as_uri(), {"line": 2, "character": 2})


def test_an_editor_without_show_document_gets_no_request(tmp_path, runtime):
    before = {*(runtime / "scenecc").glob("*")}
    client, page = LanguageClient(tmp_path), Page()
    client.initialize(tmp_path)
    path = tmp_path.resolve() / "a.scene.yaml"
    client.open(path, SCENE)
    page.link.send([Place(str(path), ("entities", "cube"))])
    assert page.names(client, path, 3, 2) == "cube"
    assert client.end() == 0
    assert not client.has_asked("window/showDocument")
    assert client.errors == b""
    page.link.close()
    assert {*(runtime / "scenecc").iterdir()} == before


def test_the_server_survives_an_invalid_message(client, scene):
    client.notify("textDocument/didSave", textDocument=3)
    assert client.wait(lambda one: one.get("method") == "window/showMessage")["params"]["type"] == 1
    assert client.ask("textDocument/hover", {"textDocument": 3})["code"] == -32602
    assert client.at("hover", scene, -1, 0)["code"] == -32602
    assert "code" in client.ask("textDocument/nonsense", {})
    assert client.at("hover", scene, 2**31 - 1, 2**31 - 1) is None
    assert client.at("hover", scene, 3, 3) is not None


def test_a_half_typed_scene_has_answers(client, scene):
    part = scene.with_name("part.yaml")
    part.write_text(f"scenecc: 1\ninclude: [{scene.name}]\n")
    text = SCENE.replace("entities", "include: [part.yaml]\nentities") + "    material: oak\n    friction: 0.5\n"
    for end in range(0, len(text), 7):
        client.change(scene, text[:end])
        line, column = text.count("\n", 0, end), end - (text.rfind("\n", 0, end) + 1)
        for method in ("completion", "hover", "definition", "documentHighlight"):
            answer = client.at(method, scene, line, column)
            assert answer is None or "code" not in answer
        assert isinstance(quick_fixes(client, scene, text[:end], line), dict)
    assert not client.has_asked("window/showMessage")


def test_a_storm_of_changes_and_cancelled_requests_leaves_answers_in_order(client, scene):
    for number in range(100):
        version = client.change(scene, SCENE.replace("to: table", f"to: t{number}"))
        asked = {"textDocument": {"uri": scene.as_uri()}, "position": {"line": 3, "character": 3}}
        client.send({"id": f"h{number}", "method": "textDocument/hover", "params": asked})
    for number in range(100):
        assert "result" in client.wait(lambda one, number=number: one.get("id") == f"h{number}")
    (found,) = client.findings(scene, version)
    assert "`t99`" in found["message"]
    place = {"start": {"line": 4, "character": 0}, "end": {"line": 4, "character": 0}}
    asked = {"textDocument": {"uri": scene.as_uri()}, "range": place, "context": {"diagnostics": []}}
    checked(client, scene, SCENE + "    num_envs: 4\n")
    for number in range(20):
        client.send({"id": f"c{number}", "method": "textDocument/codeAction", "params": asked})
        client.notify("$/cancelRequest", id=f"c{number}")
    for number in range(20):
        assert client.wait(lambda one, number=number: one.get("id") == f"c{number}")
    assert checked(client, scene, SCENE) == []


HOSTILE = {
    "brackets": "a: " + "[" * 20_000,
    "aliases": "a: &a [1]\n" + "".join(f"b{i}: &b{i} [*a, *a]\n" for i in range(2_000)),
    "an anchor in itself": "entities: &a {b: *a}\n",
    "control characters": "a: \x00\x07\u2028\ud800".encode("utf-8", "replace").decode(),
    "a long line": "a: '" + "x" * 300_000,
    "long names": "entities: {" + "a" * 100_000 + ": {pose: {relative_to: " + "b/" * 50_000 + "c}}}\n",
    "expressions": 'entities: {a: {mass: "' + "${" * 20_000 + '"}}\n',
    "a bomb": "entities:\n  a: {repeat: {i: {count: 999999999}, j: {count: 999999999}}}\n",
    "keys that are no keys": "? {a: b}\n: c\n? [d]\n: e\n",
}


@pytest.mark.parametrize("case", HOSTILE)
def test_the_server_survives_a_hostile_text(client, scene, case):
    text = SCENE + HOSTILE[case]
    before = time.monotonic()
    assert checked(client, scene, text)
    last = text.count("\n")
    for method in ("completion", "hover", "definition"):
        for line in (6, last):
            client.at(method, scene, line, 20)
    client.ask("textDocument/documentSymbol", {"textDocument": {"uri": scene.as_uri()}})
    assert_took(time.monotonic() - before, most=30)
    assert checked(client, scene, SCENE) == []


def children(process):
    file = Path(f"/proc/{process}/task/{process}/children")
    return [int(child) for child in file.read_text().split()]


def test_the_server_survives_a_crash_of_the_check_process(client, scene):
    for child in children(client.pid):
        os.kill(child, signal.SIGKILL)
    (found,) = checked(client, scene, SCENE.replace("table}", "tabel}"))
    assert found["code"] == "SC303"
    assert checked(client, scene, SCENE) == []


def test_requests_are_answered_during_a_check(client, scene, tmp_path):
    small = tmp_path.resolve() / "small.scene.yaml"
    client.open(small, SCENE)
    slow = SCENE + "".join(f"  b{i}: {{pose: [{i}, 0, 5], {BOX}}}\n" for i in range(10_000))
    first = client.change(scene, slow)
    assert {item["label"] for item in client.at("completion", small, 4, 11)["items"]} >= {"q", "anchor"}
    assert client.at("hover", small, 3, 3) is not None
    last = client.change(scene, SCENE + "  b: {mas: 1}\n")
    (found,) = client.findings(scene, last)
    assert found["code"] == "SC101"
    # Findings in an old text are not sent, unless its check ended before the change came.
    early = client.has_findings(scene, first)
    assert checked(client, scene, SCENE) == []
    assert client.has_findings(scene, first) == early
    client.close(small)


def test_the_server_exits_on_request(tmp_path):
    client = LanguageClient(tmp_path)
    client.initialize(tmp_path, ("utf-8",))
    path = tmp_path / "a.yaml"
    client.open(path, SCENE.replace("p: [0, 0, 1]", 'x-note: "é"').replace("table}", "tabel}"))
    below = children(client.pid)
    assert client.end() == 0
    assert client.errors == b""
    assert below
    assert not any(map(is_running, below))


def test_ctrl_c_ends_the_language_server(tmp_path):
    client = LanguageClient(tmp_path)
    client.initialize(tmp_path)
    os.kill(client.pid, signal.SIGINT)
    assert client.status() == 130
    assert client.errors == b""


def is_running(process):
    """Whether a process has not ended within a second."""
    for _ in range(20):
        file = Path(f"/proc/{process}/stat")
        if not file.exists() or file.read_text().rpartition(")")[2].split()[0] == "Z":
            return False
        time.sleep(0.05)
    return True


def test_lsp_without_its_extra_gives_an_install_hint(monkeypatch, capsys):
    monkeypatch.setitem(EXTRAS, "lsp", Extra("", ("no_such_module",)))
    with pytest.raises(typer.Exit) as end:
        lsp(limits=None, asset_roots=None)
    assert end.value.exit_code == 3
    assert "extra `lsp`: run `pip install" in capsys.readouterr().err
