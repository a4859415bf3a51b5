"""`scenecc mcp` as agents' clients talk to it."""

import json
import os
import signal
import time
from pathlib import Path

import pytest
from cli.running import CUBE, plain_environment
from plugins.agent_client import SECONDS, AgentClient, document
from plugins.command import scenecc

BROKEN = CUBE.replace("entities", "objects")
LONG = CUBE.replace("scenecc: 1\n", "scenecc: 1\nnum_scenes: 2000\n")
READING = {"validate", "describe", "check", "draws", "render", "explain"}


@pytest.fixture(scope="module")
def root(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("root").resolve()
    (folder / "cube.yaml").write_text(CUBE)
    (folder / "broken.yaml").write_text(BROKEN)
    (folder / "-").write_text(CUBE)
    (folder / "long.yaml").write_text(LONG)
    (folder / "yaml.py").write_text("raise SystemExit('imported from the root')")
    outside = tmp_path_factory.mktemp("outside")
    (outside / "cube.yaml").write_text(CUBE)
    (folder / "link.yaml").symlink_to(outside / "cube.yaml")
    (folder / "linked").symlink_to(outside)
    (folder / "loop").symlink_to("loop")
    (folder / "includes.yaml").write_text("scenecc: 1\ninclude: [linked/cube.yaml]\n")
    return folder


@pytest.fixture(scope="module")
def client(root):
    with AgentClient(root) as made:
        yield made
        assert made.end() == 0
        assert made.errors == b""


def plain(root: Path, *arguments: str, stdin: bytes = b"") -> dict:
    return json.loads(scenecc([*arguments, "--format", "json"], cwd=root, stdin=stdin, env=plain_environment()).stdout)


def test_tools_say_what_they_take_and_change(client):
    tools = {tool["name"]: tool for tool in client.ask("tools/list")["tools"]}
    assert tools.keys() >= READING
    for name, tool in tools.items():
        assert tool["annotations"]["readOnlyHint"] == (name in READING)
        assert not tool["annotations"]["openWorldHint"]
        assert 50 < len(tool["description"]) < 900
        assert "  " not in tool["description"]
        for key, value in tool["inputSchema"]["properties"].items():
            assert value.get("description"), (name, key)
    assert "validate" in client.started["instructions"]


@pytest.mark.parametrize(
    ("tool", "arguments", "command"),
    [
        ("validate", {"file": "cube.yaml"}, ["validate", "cube.yaml"]),
        ("validate", {"file": "broken.yaml"}, ["validate", "broken.yaml"]),
        ("validate", {"file": "-"}, ["validate", "./-"]),
        ("validate", {"file": "includes.yaml"}, ["validate", "includes.yaml"]),
        ("validate", {"text": BROKEN}, ["validate", "-"]),
        (
            "validate",
            {"file": "cube.yaml", "params": {"size": [1, "🤖"]}},
            ["validate", "--set=size=[1, 🤖]", "cube.yaml"],
        ),
        ("check", {"file": "cube.yaml", "seconds": 0.1}, ["check", "--no-cache", "--settle", "0.1", "cube.yaml"]),
        ("draws", {"text": CUBE, "seeds": "0:2", "num_scenes": 2}, ["draws", "--seeds", "0:2", "-n", "2", "-"]),
        ("describe", {"text": CUBE, "seed": 0}, ["describe", "--seed", "0", "-"]),
        ("describe", {"file": "broken.yaml"}, ["describe", "broken.yaml"]),
        ("draws", {"file": "broken.yaml"}, ["draws", "broken.yaml"]),
        ("explain", {"code": "sc101"}, ["explain", "SC101"]),
    ],
)
def test_a_tool_returns_what_its_command_prints(client, root, tool, arguments, command):
    expected = plain(root, *command, stdin=arguments.get("text", "").encode())
    found = client.answer(client.begin_call(tool, **arguments))
    assert document(found) == expected
    failed = any(one["severity"] == "error" for one in expected["diagnostics"])
    assert found["isError"] == (failed and (tool in {"draws", "describe"} or "params" in arguments))


@pytest.mark.parametrize(
    "file",
    ["../cube.yaml", "/etc/passwd", "link.yaml", "linked/cube.yaml", "linked/../cube.yaml", "a/../../cube.yaml"],
)  # fmt: skip
def test_files_outside_of_the_root_are_refused(client, root, file):
    said = client.refusal("validate", file=file)
    assert said["error"] in {f"`file` is outside of the root folder {root}", "there is no such file"}
    assert said["hint"]


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({}, "give either `file` or `text`"),
        ({"file": "cube.yaml", "text": CUBE}, "give either `file` or `text`"),
        ({"file": "absent.yaml"}, "there is no such file"),
        ({"file": "."}, "`file` is a folder"),
        ({"file": "a\0b"}, "`file` is not a valid path"),
        ({"file": "a" * 5000}, "`file` is not a valid path"),
        ({"file": 3}, "`file`: Input should be a valid string"),
        ({"file": ["cube.yaml"]}, "`file`: Input should be a valid string"),
        ({"files": "cube.yaml"}, "unknown argument 'files'"),
        ({"text": "# " + "a" * (1 << 20)}, "`text` has 1048578 characters; 1048576 are allowed"),
        ({"text": CUBE, "params": {"a": "x" * 200_000}}, "the command cannot be started: Argument list too long"),
        ({"file": "cube.yaml", "params": [1]}, "`params`: Input should be a valid dictionary"),
        ({"file": "cube.yaml", "params": {"a\0": 1}}, "an argument contains the character NUL"),
    ],
)
def test_wrong_arguments_are_refused_with_a_hint(client, arguments, error):
    said = client.refusal("validate", **arguments)
    assert said["error"] == error
    assert said["hint"]


def test_a_loop_of_links_is_refused(client):
    assert client.refusal("validate", file="loop")["hint"]  # Python 3.13 finds no error in it


def test_what_a_command_says_of_wrong_options_is_the_error(client):
    said = client.refusal("validate", file="cube.yaml", params={"": 1})
    assert said["error"] == "Invalid value for '--set': '=1': it must be name=value, as in size=0.5"


def test_an_absolute_path_in_the_root_is_allowed(client, root):
    assert client.call("validate", file=str(root / "cube.yaml")) == {"diagnostics": []}


def test_an_unknown_tool_is_an_error_that_names_the_tools(client):
    said = client.refusal("x" * 1000)
    assert len(said["error"]) < 200
    assert "validate, describe" in said["hint"]


@pytest.mark.parametrize(
    "line",
    [
        b"", b"{", b"null", b"3", b"[]", b'"text"', b"\xff\xfe\x00", b'{"jsonrpc": "2.0"}', b"[" * 100_000,
        b'{"jsonrpc": "2.0", "id": {}, "method": "tools/list"}', b'{"jsonrpc": "2.0", "id": 1e999, "method": "ping"}',
        b'{"jsonrpc": "1.0", "id": 900, "method": "ping"}', b'{"id": 901, "method": "ping"}',
        b'{"jsonrpc": "2.0", "id": 902, "method": "ping", "params": {"_meta": {"progressToken": "\\ud800"}}}',
        b'{"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": 12345}}',
        b'{"jsonrpc": "2.0", "method": "notifications/cancelled", "params": 3}',
        b'{"jsonrpc": "2.0", "id": 903, "result": {}}',
    ],
    ids=lambda line: line[:40].decode(errors="replace"),
)  # fmt: skip
def test_a_line_that_is_no_request_stops_nothing(client, line):
    client.write(line)
    assert client.ask("ping") == {}


@pytest.mark.parametrize(
    "params",
    [{}, {"name": 3}, {"name": "validate", "arguments": []}, {"name": "validate", "arguments": "cube.yaml"}],
)
def test_a_call_of_the_wrong_form_is_a_protocol_error(client, params):
    assert client.ask("tools/call", params)["code"] == -32602


def test_an_unknown_method_is_a_protocol_error(client):
    assert client.ask("tools/destroy")["code"] == -32601


def test_resources_describe_the_language_and_the_prefabs(client, root):
    listed = client.ask("resources/list")["resources"]
    assert {one["uri"] for one in listed} == {"scenecc://language", "scenecc://prefabs"}
    assert all(one["description"] for one in listed)
    (language,) = client.ask("resources/read", {"uri": "scenecc://language"})["contents"]
    assert language["text"].startswith("---\nname: scenecc\n")
    (prefabs,) = client.ask("resources/read", {"uri": "scenecc://prefabs"})["contents"]
    assert json.loads(prefabs["text"]) == plain(root, "prefabs")
    assert client.ask("resources/read", {"uri": "file:///etc/passwd"})["code"] < 0


SCENE = """\
scenecc: 1
entities:
  cube:    # red
    pose: [0, 0, 0.1]
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
"""


def test_patches_of_one_file_at_once_are_all_kept(client, root):
    (root / "edited.yaml").write_text(SCENE)
    edits = [
        {"op": "add", "path": f"/entities/{name}", "value": {"shapes": [{"type": "sphere", "radius": 0.1}]}}
        for name in "abc"
    ]
    numbers = [client.begin_call("patch", file="edited.yaml", edits=[edit]) for edit in edits]
    assert not [one for one in map(client.answer, numbers) if one["isError"]]
    text = (root / "edited.yaml").read_text()
    assert text.startswith(SCENE.rstrip("\n"))
    assert [f"  {name}:" in text for name in "abc"] == [True] * 3


def test_a_patch_with_new_errors_is_refused(client, root):
    (root / "kept.yaml").write_text(SCENE)
    edit = {"op": "replace", "path": "/entities/cube/pose", "value": "high"}
    assert client.refusal("patch", file="kept.yaml", edits=[edit])["written"] is False
    assert client.call("patch", file="kept.yaml", edits=[edit], dry_run=True)["diff"]
    assert client.refusal("patch", file="kept.yaml", edits=[{"op": "replace"}])["diagnostics"]
    assert "outside" in client.refusal("patch", file="link.yaml", edits=[edit])["error"]
    assert (root / "kept.yaml").read_text() == SCENE
    assert client.call("patch", file="kept.yaml", edits=[edit], allow_errors=True)["written"] is True


def test_long_results_are_cut_and_counted(client):
    lines = "".join(f"  a{number}: {{shapes: [{{type: box, half_size: [1, 1, -1]}}]}}\n" for number in range(300))
    said = client.call("validate", text=f"scenecc: 1\nentities:\n{lines}")
    assert len(json.dumps(said)) <= 40_100
    assert len(said["diagnostics"]) > 20
    assert said["omitted"]["diagnostics"] > 0


def wait_until_gone(process: int) -> None:
    deadline = time.monotonic() + SECONDS
    while Path(f"/proc/{process}").exists():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_a_cancelled_call_ends_its_command_and_no_other(client):
    number = client.begin_call("check", file="long.yaml", seconds=60)
    (command,) = client.wait_for_commands(1)
    other = client.begin_call("validate", file="cube.yaml")
    assert not client.answer(other)["isError"]
    assert command in client.commands()
    client.send({"method": "notifications/cancelled", "params": {"requestId": number}})
    wait_until_gone(command)
    assert client.ask("ping") == {}


@pytest.mark.parametrize(
    ("number", "status"),
    [(None, 0), (signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129), (signal.SIGKILL, -9)],
)
def test_the_end_of_the_server_ends_its_commands(root, number, status):
    with AgentClient(root) as client:
        for _ in range(3):
            client.begin_call("check", file="long.yaml", seconds=60)
        commands = client.wait_for_commands(3)
        if number is None:
            assert client.end() == status
        else:
            os.kill(client.process.pid, number)
            assert client.wait_until_ended() == status
        for command in commands:
            wait_until_gone(command)
        assert b"Traceback" not in client.errors


def test_a_command_that_takes_too_long_is_stopped(root):
    with AgentClient(root, "--timeout", "1") as client:
        said = client.refusal("check", file="long.yaml", seconds=60)
        assert said["error"] == "`check` took longer than 1 s and was stopped"
        assert client.commands() == []
        assert client.end() == 0


def test_a_command_that_crashes_ends_only_its_call(root):
    with AgentClient(root) as client:
        number = client.begin_call("check", file="long.yaml", seconds=60)
        os.kill(client.wait_for_commands(1)[0], signal.SIGSEGV)
        result = client.answer(number)
        assert result["isError"]
        assert result["structuredContent"]["error"].startswith("`scenecc check` ended without a result: signal 11")
        assert client.call("validate", file="cube.yaml") == {"diagnostics": []}
        assert client.end() == 0


def test_options_apply_to_every_command(root, tmp_path):
    (tmp_path / "cube.yaml").write_text(CUBE)
    text = "scenecc: 1\ninclude: [asset://cube.yaml]\n"
    with AgentClient(root, "--asset-root", str(tmp_path), "--limit", "objects=2") as client:
        assert client.call("validate", text=text) == {"diagnostics": []}
        assert client.call("validate", text=text + "entities: {b: {use: 'scenecc:bin'}}\n")["diagnostics"]
        assert client.end() == 0


def test_a_root_that_is_no_folder_is_wrong_usage(run):
    done = run("mcp", "--root", "absent")
    assert (done.returncode, done.stdout) == (2, "")
    assert "absent" in done.stderr


def test_the_end_of_the_input_ends_it(run):
    done = run("mcp")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
