"""The tools: each runs the command of its name with `--format json`, and returns what it prints."""

from __future__ import annotations

import base64
import json
import logging
from inspect import getdoc
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import anyio
from mcp.server import MCPServer
from mcp.server.mcpserver import Context
from mcp.server.mcpserver.exceptions import ToolError
from mcp_types import CallToolResult, ContentBlock, ImageContent, InputRequiredResult, TextContent, ToolAnnotations
from pydantic import Field, ValidationError

from scenecc.interrupt import temporary_folder
from scenecc.mcp.commands import CallRefused, CommandRunner, Document, shorten
from scenecc.scene_file.layout import value_text
from scenecc.version import VERSION

MOST_CHARACTERS: Final = 40_000
"""Longest JSON of a result."""

_MOST_TEXT: Final = 1 << 20
"""Longest text of a scene [characters]."""

_INSTRUCTIONS: Final = """\
scenecc compiles scenes for robot simulation: one YAML file becomes one or many SAPIEN scenes. Work in a loop: write or
patch the file, `validate` until there are no errors, `describe` to see sizes and what stands on what, `check` to
simulate it. Each finding has a code, a line and mostly a hint: apply the hint, or use `explain` for the code. Units:
metres, kilograms, seconds; +z is up; a box has half sizes. Read the resource scenecc://language before you write a
scene."""

File = Annotated[str, Field(description="Path of a scene file, relative to the root folder, such as scenes/table.yaml")]
Text = Annotated[
    str, Field(description="YAML of a scene, instead of `file`. Files that it names are relative to the root folder")
]
Params = Annotated[
    dict[str, Any],
    Field(description='Values of the file\'s parameters by name, overriding their defaults. Example: {"size": 0.6}'),
]
NumScenes = Annotated[int, Field(ge=0, description="Number of parallel scenes, overriding the file; 0: as in the file")]
Scenes = Annotated[str, Field(description="Indices of the scenes to use: 3, or 0:4, or 0,2, or ::2. Empty: all scenes")]
Scene = Annotated[int, Field(ge=0, description="Index of the parallel scene to use")]
Seed = Annotated[int | None, Field(ge=0, description="Seed of all draws, overriding the file")]
Seeds = Annotated[str, Field(description="Seeds A to B-1 as A:B. Example: 0:20. Empty: the seed in the file")]

_READS: Final = ToolAnnotations(
    read_only_hint=True, destructive_hint=False, idempotent_hint=True, open_world_hint=False
)

_WRITES: Final = ToolAnnotations(
    read_only_hint=False, destructive_hint=True, idempotent_hint=False, open_world_hint=False
)


class SceneTools:
    """The tools. Their docstrings are descriptions for models.

    Args:
        runner: what they may use.
    """

    def __init__(self, runner: CommandRunner) -> None:
        self._runner = runner
        self._editing = anyio.Lock()

    async def validate(
        self,
        file: File = "",
        text: Text = "",
        params: Params = {},  # noqa: B006 - never changed
    ) -> CallToolResult:
        """Check a scene without building it: YAML, keys, names, files and plausible physics. Takes about a second.

        Returns `diagnostics`, each with code, severity, message, line, column, path and hint. The scene is valid if
        none has the severity `error`. `unchecked` lists what could not be checked because of errors.
        Example: {"file": "scenes/table.yaml"}
        """
        status, document = await self._run("validate", file, text, _settings(params))
        return _result(document, failed=status > 1)

    async def check(
        self,
        file: File = "",
        text: Text = "",
        params: Params = {},  # noqa: B006
        seconds: Annotated[float, Field(ge=0, le=60, description="Time to simulate [s]")] = 1.0,
        seeds: Seeds = "",
        scenes: Scenes = "",
        num_scenes: NumScenes = 0,
    ) -> CallToolResult:
        """Check a scene as `validate` does, then build it and simulate it on the CPU.

        Also finds bodies that overlap at the start, lack support, topple, sink or fly away, robot links that collide,
        robots that sag, and unmet conditions of `expect`. Returns `diagnostics`, and in `simulated` what was simulated.
        Takes from one second to minutes. Example: {"file": "scenes/table.yaml", "seeds": "0:20"}
        """
        options = [
            f"--settle={seconds}",
            *_choice(seeds=seeds, scene=scenes, num_scenes=num_scenes or None),
            *_settings(params),
        ]
        status, document = await self._run("check", file, text, options)
        return _result(document, failed=status > 1)

    async def describe(
        self,
        file: File = "",
        text: Text = "",
        params: Params = {},  # noqa: B006
        scene: Scene = 0,
        seed: Seed = None,
    ) -> CallToolResult:
        """Describe a scene as it is built, in its initial poses: what is where, and what stands on what.

        Returns `objects` with size, position, mass, `stands_on`, `is_in`, `touches`, `overlaps`, gaps below (`above`)
        and whether it `falls`. Units are in the names: _m, _kg, _deg. Example: {"file": "scenes/table.yaml"}
        """
        options = [f"--scene={scene}", *_choice(seed=seed), *_settings(params)]
        status, document = await self._run("describe", file, text, options)
        return _result(document, failed=status > 0)

    async def patch(
        self,
        file: File,
        edits: Annotated[
            list[dict[str, Any]],
            Field(
                description="Operations of JSON Patch (RFC 6902): add, remove, replace, move, copy, test. `path` is a "
                'JSON Pointer into the file as it is written; `/-` appends to a list. Example: [{"op": "replace", '
                '"path": "/entities/cube/pose/0", "value": 0.2}]'
            ),
        ],
        dry_run: Annotated[bool, Field(description="Return the change, but do not write the file")] = False,
        allow_errors: Annotated[bool, Field(description="Write the file even if the scene has new errors")] = False,
    ) -> CallToolResult:
        """Edit a scene file. Comments and layout are kept; all operations apply, or none.

        The result is validated first: if it has errors that the file did not have, the file stays unchanged. Returns
        `written`, the change as `diff`, and the `diagnostics` of the result.
        """
        options = [*self._runner.options, *(["--dry-run"] * dry_run), *(["--allow-errors"] * allow_errors)]
        arguments = [*options, "--", self._runner.check_file(file), "-"]
        async with self._editing:  # two edits of one file at once would lose one
            status, document = await self._document("patch", arguments, json.dumps(edits))
        return _result(document, failed=status > 1 or (status == 1 and not document["written"] and not dry_run))

    async def draws(
        self,
        file: File = "",
        text: Text = "",
        params: Params = {},  # noqa: B006
        seeds: Seeds = "",
        scenes: Scenes = "",
        num_scenes: NumScenes = 0,
    ) -> CallToolResult:
        """List the values that are drawn at random or differ between parallel scenes, exactly as a build draws them.

        Returns `draws`: a row per seed and scene, with `values` by path, in SI units. No engine is started.
        Example: {"file": "scenes/clutter.yaml", "seeds": "0:5", "scenes": "0"}
        """
        options = [*_choice(seeds=seeds, scene=scenes, num_scenes=num_scenes or None), *_settings(params)]
        status, document = await self._run("draws", file, text, options)
        return _result(document, failed=status > 0)

    async def render(
        self,
        file: File = "",
        text: Text = "",
        params: Params = {},  # noqa: B006
        scene: Scene = 0,
        camera: Annotated[str, Field(description="Name of a camera in the file. Empty: frames all that moves")] = "",
        view: Annotated[
            Literal["", "iso", "front", "back", "left", "right", "top", "bottom"],
            Field(description="Side to look from, without `camera`; front is +x, left is +y. Empty: iso"),
        ] = "",
        focus: Annotated[str, Field(description="Entity or ENTITY/LINK to point at, without `camera`")] = "",
        show: Annotated[Literal["visual", "collision"], Field(description="Shapes to draw")] = "visual",
        labels: Annotated[bool, Field(description="Write the names of entities")] = False,
        steps: Annotated[int, Field(ge=0, description="Simulation steps before the picture")] = 0,
        width: Annotated[int, Field(ge=16, le=1536, description="Width [px]")] = 640,
        height: Annotated[int, Field(ge=16, le=1536, description="Height [px]")] = 480,
        seed: Seed = None,
    ) -> CallToolResult:
        """Render a picture of a scene (PNG). Needs a GPU or a software Vulkan driver; the error says how to get one.

        Example: {"file": "scenes/table.yaml", "view": "front", "labels": true}
        """
        choice = _choice(camera=camera, view=view, focus=focus, show=show, seed=seed)
        options = [*choice, f"--scene={scene}", f"--steps={steps}", f"--size={width}x{height}", *_settings(params)]
        options += ["--labels"] if labels else []
        with temporary_folder("scenecc-") as folder:
            picture = anyio.Path(folder, "picture.png")
            status, document = await self._run("render", file, text, [*options, f"--output={picture}"])
            data = await picture.read_bytes() if status == 0 else b""
        for row in document.get("files", ()):
            del row["file"]  # it exists no longer
        result = _result(document, failed=status > 0)
        if data:
            image = ImageContent(type="image", data=base64.b64encode(data).decode(), mime_type="image/png")
            result.content.insert(0, image)
        return result

    async def explain(self, code: Annotated[str, Field(description="A code, such as SC101")]) -> CallToolResult:
        """Explain the code of a finding: its cause, an example, and how to fix it."""
        status, document = await self._document("explain", ["--", code], "")
        return _result(document, failed=status > 0)

    async def prefabs(self) -> str:
        """Prefabs that ship with scenecc, with their parameters."""
        _, document = await self._runner.run("prefabs", [], "")
        return json.dumps(document)

    async def _run(self, command: str, file: str, text: str, options: list[str]) -> tuple[int, Document]:
        """Runs a command on a scene, which is a file or a text. Returns its exit status and its document."""
        if bool(file) == bool(text):
            raise CallRefused("give either `file` or `text`", 'for example {"file": "scenes/table.yaml"}')
        if len(text) > _MOST_TEXT:
            raise CallRefused(f"`text` has {len(text)} characters; {_MOST_TEXT} are allowed", "write it to a file")
        scene = self._runner.check_file(file) if file else "-"
        arguments = [*self._runner.options, *options, "--", scene]
        return await self._document(command, arguments, text)

    async def _document(self, command: str, arguments: list[str], text: str) -> tuple[int, Document]:
        """Runs a command. Returns its exit status and its document, shortened."""
        if any("\0" in argument for argument in arguments):
            raise CallRefused("an argument contains the character NUL", "remove it")
        status, document = await self._runner.run(command, arguments, text)
        return status, shorten(document, MOST_CHARACTERS)


def _language() -> str:
    """The language on two pages, with examples and frequent mistakes."""
    packaged = Path(__file__).with_name("SKILL.md")  # in a wheel; in a clone it is in the documentation
    return (packaged if packaged.exists() else Path(__file__).parents[2] / "docs/skill/SKILL.md").read_text("utf-8")


def _settings(params: dict[str, Any]) -> list[str]:
    # JSON's escapes of characters beyond U+FFFF are not YAML's.
    return [f"--set={name}={value_text(value, (), 0, 'json')}" for name, value in params.items()]


def _choice(**options: str | int | None) -> list[str]:
    """Returns options of a command, without those that are empty."""
    return [f"--{name.replace('_', '-')}={value}" for name, value in options.items() if value not in {None, ""}]


def _result(document: Document, *, failed: bool) -> CallToolResult:
    text: list[ContentBlock] = [TextContent(type="text", text=json.dumps(document, ensure_ascii=False))]
    return CallToolResult(content=text, structured_content=document, is_error=failed)


def _error(message: str, hint: str) -> CallToolResult:
    return _result({"error": message, "hint": hint}, failed=True)


class AgentServer(MCPServer[Any]):
    """The server. A call that fails returns `error` and `hint`, whatever the reason."""

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[Any, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        """Calls a tool. Unknown arguments are refused."""
        tools = {tool.name: tool.input_schema["properties"] for tool in await self.list_tools()}
        if name not in tools:
            return _error(f"there is no tool {name[:80]!r}", f"the tools are {', '.join(tools)}")
        if unknown := [key for key in arguments if key not in tools[name]]:
            return _error(f"unknown argument {unknown[0][:80]!r}", f"{name} takes {', '.join(tools[name])}")
        try:
            return await super().call_tool(name, arguments, context)
        except ToolError as error:
            cause = error.__cause__
            if isinstance(cause, CallRefused):
                return _error(str(cause), cause.hint)
            if isinstance(cause, ValidationError):
                faults = [f"`{'.'.join(map(str, one['loc']))}`: {one['msg']}" for one in cause.errors()]
                return _error("; ".join(faults[:5]), f"the input schema of {name} has the types")
            logging.getLogger(__name__).exception("the tool %s failed", name)
            return _error(f"{name} failed because of a bug in scenecc", "the log of the client has the traceback")


def make_agent_server(runner: CommandRunner) -> AgentServer:
    """Returns a server with all tools and resources."""
    server = AgentServer("scenecc", instructions=_INSTRUCTIONS, version=VERSION, log_level="WARNING")
    tools = SceneTools(runner)
    for tool in (tools.validate, tools.describe, tools.check, tools.draws, tools.render, tools.explain):
        server.add_tool(tool, description=getdoc(tool), annotations=_READS, structured_output=False)
    server.add_tool(tools.patch, description=getdoc(tools.patch), annotations=_WRITES, structured_output=False)
    for name, read, form in (("language", _language, "text/markdown"), ("prefabs", tools.prefabs, "application/json")):
        server.resource(f"scenecc://{name}", name=name, description=getdoc(read), mime_type=form)(read)
    return server


def serve_agents(root: Path, options: tuple[str, ...], seconds: float) -> None:
    """Serves a client on standard input and output until the input ends.

    Args:
        root: folder of the scene files.
        options: options of all commands that compile a scene.
        seconds: time limit of a command [s].
    """
    logging.basicConfig(level=logging.WARNING)
    make_agent_server(CommandRunner(root.resolve(), options, seconds, anyio.Semaphore(_SLOTS))).run("stdio")


_SLOTS: Final = 4
"""Commands that run at once; further calls wait."""
