"""What agents read: the skill's table of mistakes, the clients' settings, and llms.txt."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from walkthrough import steps

from scenecc import check_scene, validate

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
SKILL = (DOCS / "skill/SKILL.md").read_text("utf-8")
PAGE = DOCS / "how-to/agents.md"
CONFIGURATIONS = [json.loads(step.text) for step in steps(PAGE) if step.language == "json"]
BOX = "shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]"

OF_CHECK = {"SC533", "SC534", "SC850"}
"""Codes that only `scenecc check` reports."""


def rows(heading: str) -> list[list[str]]:
    """The rows of the table below a heading, without its head."""
    section = SKILL.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    table = [line for line in section.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table[1:]]


def test_the_skill_has_the_head_that_clients_read() -> None:
    _, head, text = SKILL.split("---\n", 2)
    head = yaml.safe_load(head)
    assert head.keys() == {"name", "description"}
    assert re.fullmatch("[a-z0-9-]{1,64}", head["name"])
    assert len(head["description"]) <= 1024
    assert 80 < len(text.splitlines()) < 120  # two pages


@pytest.mark.parametrize(
    ("written", "code"), [row[:2] for row in rows("Frequent mistakes") if row[1] not in OF_CHECK], ids=str
)
def test_a_frequent_mistake_has_its_code(written: str, code: str, tmp_path: Path) -> None:
    keys = written.strip("`")
    scene = tmp_path / "scene.yaml"
    body = keys if re.match("shapes?:|visuals:", keys) else f"{keys}\n    {BOX}"
    scene.write_text(f"scenecc: 1\nentities:\n  cube:\n    {body}\n")
    assert code in [one.code for one in validate(scene)]
    corrected = re.fullmatch(r"`(\w+: [^`]*)`", next(row[2] for row in rows("Frequent mistakes") if row[0] == written))
    if corrected and keys.partition(":")[0] == corrected[1].partition(":")[0]:
        scene.write_text(scene.read_text().replace(keys, corrected[1]))
        assert not [one for one in validate(scene) if one.severity == "error"]


@pytest.mark.parametrize(("written", "code"), [row[:2] for row in rows("Frequent mistakes") if row[1] in OF_CHECK])
def test_check_reports_a_frequent_mistake(written: str, code: str, tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    keys = written.partition("` on the ground")[0].strip("`")
    body = keys if keys.startswith("shapes:") else f"{keys}, {BOX}"
    scene.write_text(f"scenecc: 1\nentities:\n  ground: {{use: scenecc:ground}}\n  cube: {{{body}}}\n")
    assert code in [one.code for one in check_scene(scene)]


def test_each_key_in_the_skill_is_in_the_schema() -> None:
    schema = (ROOT / "schemas/scene.v1.schema.json").read_text("utf-8")
    keys = [key for row in rows("The language") for key in re.findall(r"`(\w+)`", row[0])]
    assert len(keys) >= 20
    assert [key for key in keys if f'"{key}"' not in schema] == []


@pytest.mark.parametrize("configuration", CONFIGURATIONS, ids=["VS Code", "Cursor"])
def test_what_clients_are_set_up_with_starts_a_server(configuration: dict, tmp_path: Path) -> None:
    (servers,) = configuration.values()
    (server,) = servers.values()
    assert server["command"] == "scenecc"
    arguments = [argument.replace("${workspaceFolder}", str(tmp_path)) for argument in server["args"]]
    about = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}
    request = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": about})
    with subprocess.Popen(
        [sys.executable, "-m", "scenecc", *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(request + "\n")
        process.stdin.flush()
        assert json.loads(process.stdout.readline())["result"]["serverInfo"]["name"] == "scenecc"
        process.stdin.close()
        assert process.wait(30) == 0


def test_llms_txt_lists_the_pages() -> None:
    text = (DOCS / "llms.txt").read_text("utf-8")
    title, _, quote, *_ = text.splitlines()
    assert title == "# scenecc"
    assert quote.startswith("> ")
    links = set(re.findall(r"\]\(([^)]*)\)", text))
    assert [link for link in links if not (DOCS / link).is_file()] == []
    pages = {str(page.relative_to(DOCS)) for page in [*DOCS.glob("how-to/*.md"), *DOCS.glob("reference/*.md")]}
    assert pages - links == {"reference/api.md"}  # made from docstrings when the site is built
