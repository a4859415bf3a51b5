"""What editors are set up with starts a server that answers."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from plugins.language_client import LanguageClient

from scenecc.version import VERSION

ROOT = Path(__file__).parents[2]
VSCODE = ROOT / "editors" / "vscode"
MANIFEST = json.loads((VSCODE / "package.json").read_text())

RUN = """
const Module = require("module");
const load = Module._load;
const started = [];
const vscode = {
  window: { showErrorMessage: (text) => started.push(text) },
  workspace: { getConfiguration: () => ({ get: (name) => JSON.parse(process.argv[2])[name] }) },
};
class LanguageClient {
  constructor(id, name, server, options) { started.push(server, options); }
  async start() { if (process.argv[3]) throw new Error(process.argv[3]); }
  async stop() { started.push("stopped"); }
}
Module._load = (name, ...rest) =>
  name === "vscode" ? vscode : name === "vscode-languageclient/node" ? { LanguageClient } : load(name, ...rest);
const extension = require(process.argv[1]);
extension.activate().then(extension.deactivate).then(() => console.log(JSON.stringify(started)));
"""


def extension(settings: dict, fault: str = "") -> list:
    """What the extension starts, with stubs for the editor and its library."""
    if shutil.which("node") is None:
        pytest.skip("there is no node")
    command = ["node", "-e", RUN, str(VSCODE / MANIFEST["main"]), json.dumps(settings), fault]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return json.loads(done.stdout)


def defaults() -> dict:
    properties = MANIFEST["contributes"]["configuration"]["properties"]
    return {name.removeprefix("scenecc."): row["default"] for name, row in properties.items()}


def test_the_extension_starts_the_server_with_its_settings() -> None:
    server, options, end = extension(defaults())
    assert server == {"command": "scenecc", "args": ["lsp"]}
    assert {row["language"] for row in options["documentSelector"]} == {"scenecc", "yaml"}
    assert end == "stopped"
    server, *_ = extension({"command": ["python3", "-m", "scenecc"], "arguments": ["--asset-root", "/a"]})
    assert server == {"command": "python3", "args": ["-m", "scenecc", "lsp", "--asset-root", "/a"]}


def test_the_extension_says_why_the_server_does_not_start() -> None:
    *_, told, _ = extension(defaults(), "no such file")
    assert told == (
        "`scenecc lsp` does not start: no such file. "
        "Install scenecc with its extra `lsp`, or set `scenecc.command` to where it is."
    )


def test_the_extension_takes_scene_files() -> None:
    (language,) = MANIFEST["contributes"]["languages"]
    assert {".scene.yaml", ".scene.yml"} == set(language["extensions"])
    first = re.compile(language["firstLine"])
    assert all(first.match(line) for line in ("scenecc: 1", '"scenecc": 1', "{scenecc: 1}"))
    assert not any(first.match(line) for line in ("name: scenecc: 1", "# scenecc: 1", "scenecc_plan: 1"))
    (grammar,) = MANIFEST["contributes"]["grammars"]
    for file in (MANIFEST["main"], language["configuration"], grammar["path"]):
        assert (VSCODE / file).is_file()
    assert json.loads((VSCODE / grammar["path"]).read_text())["scopeName"] == grammar["scopeName"]
    json.loads((VSCODE / language["configuration"]).read_text())


def test_the_extension_has_the_version_of_the_package() -> None:
    assert MANIFEST["version"] == VERSION
    readme = (VSCODE / "README.md").read_text()
    assert re.findall(r"scenecc-([\d.]+)\.vsix", readme) == [VERSION]
    # vsce refuses links to files outside of the folder.
    assert "](../" not in readme


def test_a_folder_that_is_not_trusted_chooses_no_program() -> None:
    restricted = MANIFEST["capabilities"]["untrustedWorkspaces"]["restrictedConfigurations"]
    assert set(restricted) == set(MANIFEST["contributes"]["configuration"]["properties"])


def test_what_neovim_is_told_to_start_answers(tmp_path: Path) -> None:
    page = (ROOT / "docs/how-to/editor.md").read_text()
    snippet, following = re.findall(r"^```lua\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (listed,) = re.findall(r"cmd = \{(.*?)\}", snippet)
    command = [json.loads(word) for word in listed.split(",")]
    assert command == ["scenecc", "lsp"]
    client = LanguageClient(tmp_path, command=command)
    # As Neovim asks: columns in UTF-8 first.
    answer = client.initialize(tmp_path, ("utf-8", "utf-16", "utf-32"))
    assert answer["capabilities"]["positionEncoding"] == "utf-8"
    assert "vim.lsp.buf.document_highlight" in following
    assert answer["capabilities"]["documentHighlightProvider"]
    path = tmp_path / "a.yaml"
    (found,) = client.open(path, 'scenecc: 1\nentities: {x-é: 1, a: {mas: 2, urdf: "é"}}\n')
    assert found["range"]["start"] == {"line": 1, "character": len("entities: {x-é: 1, a: {".encode())}
    assert client.end() == 0
