// Starts `scenecc lsp` and connects it to the editor. All that is shown comes from there.

"use strict";

const { window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

async function activate() {
  const settings = workspace.getConfiguration("scenecc");
  const [command, ...first] = settings.get("command");
  const args = [...first, "lsp", ...settings.get("arguments")];
  client = new LanguageClient(
    "scenecc",
    "scenecc",
    { command, args },
    {
      // Of YAML in general, the server takes what has the key `scenecc` alone.
      documentSelector: [
        { scheme: "file", language: "scenecc" },
        { scheme: "file", language: "yaml" },
      ],
    },
  );
  try {
    await client.start();
  } catch (error) {
    const hint = "Install scenecc with its extra `lsp`, or set `scenecc.command` to where it is.";
    window.showErrorMessage(`\`${[command, ...args].join(" ")}\` does not start: ${error.message}. ${hint}`);
  }
}

async function deactivate() {
  await client?.stop();
}

module.exports = { activate, deactivate };
