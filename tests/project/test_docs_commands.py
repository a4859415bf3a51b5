"""Every command and every piece of code in the documentation does what it is said to do."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from walkthrough import Step, commands, steps

from scenecc import compile_scene, validate

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    page
    for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    if not page.is_relative_to(ROOT / "docs/reference/diagnostics")  # examples of mistakes
    if not page.is_relative_to(ROOT / "docs/tutorial")  # from one page to the next: test_tutorial.py
    if page.name != "cli.md"  # examples of the help: test_cli_page.py
)
SHELLS = {"bash", "console", "sh", "shell"}
KNOWN = {"diff", "json", "lua", "python", "text", "toml", "yaml", *SHELLS}


def blocks() -> list[Step]:
    return [step for page in PAGES for step in steps(page) if step.language]


SHELL = [block for block in blocks() if block.language in SHELLS]
RUN = [block for block in SHELL if not block.mark]
SERVED = [block for block in SHELL if block.mark == "serves"]
RENDERED = [block for block in SHELL if block.mark == "render"]
SCENES = [block for block in blocks() if block.language == "yaml" and block.text.startswith("scenecc: 1\n")]
README = [block for block in blocks() if block.page.name == "README.md"]


def script(block: Step) -> str:
    """The commands of a block; a console block also shows what they print."""
    return "\n".join(command for command, _ in commands(block.text)) or block.text


def block_id(block: Step) -> str:
    """A page and the first words of a block: unlike its line, it stays what `tests/slow_tests.txt` says."""
    return f"{block.page.name} " + re.sub(r"[^\w.-]+", " ", script(block).removeprefix("scenecc: 1"))[:48].strip()


def shell(text: str, cwd: Path, environment: dict[str, str], timeout: float = 100) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", text],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=timeout,
    )


def test_every_block_says_what_it_is() -> None:
    assert {block.language for block in blocks()} <= KNOWN
    for page in PAGES:
        fences = re.findall(r"^```", page.read_text(), re.MULTILINE)
        assert len(fences) == 2 * sum(block.page == page for block in blocks()), page


@pytest.mark.parametrize("block", SHELL, ids=block_id)
def test_a_command_is_run_or_says_why_not(block: Step) -> None:
    assert block.mark in {"", "command", "not run", "render", "serves"}
    if block.mark == "command":
        assert f".ci/readme-command {block.detail}" in (ROOT / ".ci/run").read_text()
    if block.mark == "not run":
        assert len(block.detail.split()) > 2, "a reason"


@pytest.mark.parametrize("block", RUN, ids=block_id)
def test_the_commands_succeed(block: Step, clone: Path, forking_environment: dict[str, str]) -> None:
    assert script(block).strip()
    done = shell(script(block), clone, forking_environment)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("block", SERVED, ids=block_id)
def test_the_commands_serve_until_they_are_interrupted(block: Step, clone: Path, environment: dict[str, str]) -> None:
    for command in script(block).splitlines():
        with subprocess.Popen(
            ["bash", "-c", f"exec {command}"], cwd=clone, env=environment, stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            try:
                assert process.stdout.readline().startswith("http://127.0.0.1:")
            finally:
                process.send_signal(signal.SIGINT)
            assert process.wait(30) == 130


@pytest.mark.render
@pytest.mark.timeout(900)  # a software driver shares the processor with other tests
@pytest.mark.parametrize("block", RENDERED, ids=block_id)
def test_the_commands_succeed_where_a_device_renders(block: Step, clone: Path, environment: dict[str, str]) -> None:
    done = shell(script(block), clone, environment, timeout=880)
    assert done.returncode == 0, done.stderr
    following = blocks()[blocks().index(block) + 1]
    if following.page == block.page and following.language == "text":
        assert done.stdout.startswith(following.text)


def test_the_main_job_prints_what_the_readme_shows(clone: Path, environment: dict[str, str]) -> None:
    (job,) = [block for block in README if (block.mark, block.detail) == ("command", "build")]
    command = job.text.split(" && ")[-1]
    assert command.startswith("scenecc build scenes/tabletop.yaml --num-scenes 4")
    done = shell(command, clone, environment)
    assert done.returncode == 0, done.stderr
    assert _text_after(job) in done.stdout


@pytest.mark.quick
def test_the_readmes_scene_builds_and_its_slip_is_told_as_shown(tmp_path: Path, environment: dict[str, str]) -> None:
    scene = next(block for block in README if block.language == "yaml")
    (tmp_path / "scene.yaml").write_text(scene.text)
    built = shell("scenecc build scene.yaml", tmp_path, environment)
    assert built.returncode == 0, built.stderr
    (tmp_path / "scene.yaml").write_text(scene.text.replace("half_size:", "half_sizes:"))
    told = shell("scenecc validate scene.yaml", tmp_path, environment)
    (shown,) = [block.text for block in README if block.text.startswith("scene.yaml:")]
    assert told.returncode == 1
    assert shown in told.stdout


@pytest.mark.parametrize("block", SCENES, ids=block_id)
def test_every_scene_in_the_pages_compiles_without_a_word(block: Step, tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(block.text)
    assert validate(file) == []
    assert compile_scene(file).entities


NEEDS = {"maniskill.md": pytest.mark.maniskill, "thousands.md": pytest.mark.maniskill}


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=NEEDS.get(page.name, ()), id=str(page.relative_to(ROOT))) for page in PAGES],
)
def test_a_pages_python_runs_from_top_to_bottom(page: Path, clone: Path, environment: dict[str, str]) -> None:
    code = "\n".join(block.text for block in blocks() if block.page == page and block.language == "python")
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=clone,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=100,
    )
    assert done.returncode == 0, done.stderr


def _text_after(block: Step) -> str:
    following = README[README.index(block) + 1]
    assert following.language == "text"
    return following.text
