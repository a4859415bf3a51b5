"""A scene is fixed and understood with the tools, as an agent does it, through the client of the official SDK."""

import base64
import os
import re
import sys
from pathlib import Path
from typing import Any

import anyio
import pytest
from mcp import Client, StdioServerParameters
from mcp_types import ImageContent

SCENE = """\
scenecc: 1
entities:
  ground: {use: scenecc:ground}
  table: {body_type: static, pose: [0, 0, 0.2], shapes: [{type: box, half_size: [0.3, 0.3, 0.2]}]}
  cube:                       # to be on the table
    pose: [0, 0, 0.6]
    mass: {uniform: [0.1, 0.2]}
    shapes: [{type: box, size: [0.1, 0.1, 0.1]}]
"""


class Agent:
    """A connection to a server. A call returns its document, and fails if the tool does."""

    def __init__(self, client: Client) -> None:
        self._client = client

    async def call(self, tool: str, **arguments: Any) -> dict[str, Any]:
        result = await self._client.call_tool(tool, {"file": "scene.yaml", **arguments})
        assert not result.is_error, result
        return result.structured_content

    async def cube(self) -> dict[str, Any]:
        (found,) = [one for one in (await self.call("describe"))["objects"] if one["name"] == "cube"]
        return found


def with_agent(folder: Path, work: Any) -> None:
    (folder / "scene.yaml").write_text(SCENE)
    command = ["-m", "scenecc", "mcp", "--root", str(folder)]

    async def run() -> None:
        async with Client(StdioServerParameters(command=sys.executable, args=command, env=dict(os.environ))) as client:
            assert {tool.name for tool in (await client.list_tools()).tools} >= {"validate", "describe", "patch"}
            await work(Agent(client))

    anyio.run(run)


async def correct(agent: Agent) -> None:
    """Applies the hint of the finding to its place."""
    (found,) = (await agent.call("validate"))["diagnostics"]
    hint = re.search(r"write `(\w+): \[(.*?)\]`", found["hint"])
    assert hint is not None
    at = "/" + re.sub(r"\[(\d+)\]", r".\1", found["path"]).replace(".", "/")
    value = [float(number) for number in hint[2].split(",")]
    edits = [
        {"op": "remove", "path": at},
        {"op": "add", "path": at.rpartition("/")[0] + f"/{hint[1]}", "value": value},
    ]
    assert (await agent.call("patch", edits=edits))["written"]


def test_an_agent_fixes_a_scene_by_its_hints(tmp_path):
    async def work(agent: Agent) -> None:
        await correct(agent)
        assert (await agent.call("validate"))["diagnostics"] == []
        cube = await agent.cube()
        assert (cube["size_m"], cube["stands_on"], cube["falls"]) == ([0.1, 0.1, 0.1], [], True)
        edit = {"op": "replace", "path": "/entities/cube/pose/2", "value": 0.45}
        assert (await agent.call("patch", edits=[edit]))["diagnostics"] == []
        assert (await agent.cube())["stands_on"] == ["table"]
        assert (await agent.call("check", seeds="0:2"))["diagnostics"] == []
        rows = (await agent.call("draws", seeds="0:2"))["draws"]
        assert [0.1 <= row["values"]["cube.mass"] <= 0.2 for row in rows] == [True, True]

    with_agent(tmp_path, work)
    fixed = SCENE.replace("size: [0.1, 0.1, 0.1]", "half_size: [0.05, 0.05, 0.05]").replace("0.6]", "0.45]")
    assert (tmp_path / "scene.yaml").read_text() == fixed


@pytest.mark.render
@pytest.mark.timeout(400)
def test_an_agent_looks_at_a_scene(tmp_path):
    async def work(agent: Agent) -> None:
        await correct(agent)
        result = await agent._client.call_tool("render", {"file": "scene.yaml", "width": 64, "height": 48})
        picture = result.content[0]
        assert isinstance(picture, ImageContent)
        assert base64.b64decode(picture.data).startswith(b"\x89PNG")
        assert result.structured_content["files"][0]["size"] == [64, 48]

    with_agent(tmp_path, work)
