"""Does what the pages of the tutorial say, in their order and in one folder, and compares what is printed.

    python assets/walkthrough.py [--render] [--update]

`--render` also runs what needs a device that renders; `--update` writes what was printed into the pages. A comment
above a block says what a reader does with it:

    <!-- file: NAME -->      saves the block as this file
    <!-- append: NAME -->    adds it to the end of this file
    <!-- change: NAME -->    replaces the lines with `-` by those with `+`
    <!-- render: REASON -->  runs it where a device renders
    <!-- not run: REASON -->
    <!-- picture: FILE -->   above an image: a command of the page has written it to this file

A block of the language `console` without a comment is run: lines with `$ ` are commands, and what follows is what they
print. `…` stands for what differs from machine to machine.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
FOLDER: Final = ROOT / "docs/tutorial"
PAGES: Final = tuple(
    FOLDER / f"{name}.md" for name in ("first-scene", "robot", "camera", "randomise", "checks", "training")
)

_STEP: Final = re.compile(
    r"(?:^<!-- (?P<mark>[a-z ]+): (?P<detail>[^\n]*?) -->\n)?"
    r"(?:^```(?P<language>\w+)\n(?P<text>.*?)^```$|^!\[[^\]]*\]\((?P<image>[^)]+)\))",
    re.MULTILINE | re.DOTALL,
)
_WORKS: Final = frozenset({"file", "append", "change", "render", "not run", "picture"})


@dataclass(frozen=True)
class Step:
    """A block or an image of a page.

    Attributes:
        page: where it stands.
        mark: the word of the comment above it; empty for none.
        detail: what the comment says.
        language: of the block; empty for an image.
        text: the block, or the path of the image as the page has it.
        start: where `text` begins in the page.
    """

    page: Path
    mark: str
    detail: str
    language: str
    text: str
    start: int

    def __str__(self) -> str:
        line = self.page.read_text("utf-8").count("\n", 0, self.start) + 1
        return f"{self.page.name}:{line}"

    @property
    def is_run(self) -> bool:
        """Whether it has commands for a reader to type."""
        return self.language in {"bash", "console"} and self.mark != "not run"


def steps(page: Path) -> list[Step]:
    """All blocks and images of a page."""
    found = _STEP.finditer(page.read_text("utf-8"))
    return [
        Step(
            page,
            each["mark"] or "",
            each["detail"] or "",
            each["language"] or "",
            each["text"] if each["language"] else each["image"],
            each.start("text" if each["language"] else "image"),
        )
        for each in found
    ]


def pictures() -> dict[str, str]:
    """Each picture that the tutorial makes: its name in `docs/pictures`, and the file that a command writes."""
    return {Path(step.text).name: step.detail for page in PAGES for step in steps(page) if step.mark == "picture"}


@dataclass(frozen=True)
class Printed:
    """A command, what the page says that it prints, and what it has printed."""

    command: str
    expected: str
    printed: str

    @property
    def is_right(self) -> bool:
        """Whether this was expected, `…` being anything within a line."""
        pattern = re.escape(_trimmed(self.expected)).replace("…", "[^\n]*")
        return re.fullmatch(pattern, _trimmed(self.printed)) is not None


def commands(text: str) -> Iterator[tuple[str, str]]:
    """The commands of a console block, each with what it prints."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, printed = part.partition("\n")
        yield command, printed


class Walk:
    """A reader with a folder, who has read the pages up to here.

    Args:
        clone: a folder with the repository's `scenes`; the reader works in `pick` below it.
        environment: in which `scenecc` is installed.
        wanted: which blocks of commands are run; files are always copied.
        seen: is told what the commands of each block have printed.
    """

    def __init__(
        self,
        clone: Path,
        environment: Mapping[str, str],
        *,
        wanted: Callable[[Step], bool],
        seen: Callable[[Step, list[Printed]], None],
    ) -> None:
        self.folder = clone / "pick"
        self.folder.mkdir()
        self.environment = {**environment, "PYTHONUNBUFFERED": "1", "NO_COLOR": "1"}
        self.wanted = wanted
        self.seen = seen

    def read(self, page: Path) -> None:
        """Does what the page says, from top to bottom.

        Raises:
            ValueError: a comment has no meaning, or a line that is to be changed is not there once.
        """
        for step in steps(page):
            if step.mark not in _WORKS and (step.mark or step.language == "bash"):
                raise ValueError(f"{step}: `{step.mark}` says nothing about what a reader does")
            path = self.folder / step.detail
            match step.mark:
                case "file":
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_text(step.text, "utf-8")
                case "append":
                    path.write_text(path.read_text("utf-8") + "\n" + step.text, "utf-8")
                case "change":
                    path.write_text(_changed(path.read_text("utf-8"), step), "utf-8")
                case _:
                    if step.is_run and (self.wanted(step) or step.text.startswith("$ cp ")):
                        found = [Printed(*each, self._run(each[0])) for each in commands(step.text)]
                        self.seen(step, found)

    def _run(self, command: str) -> str:
        done = subprocess.run(  # noqa: S603 - the commands of our own pages
            ["bash", "-c", command],  # noqa: S607
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return done.stdout


def _changed(text: str, step: Step) -> str:
    lines = step.text.splitlines(keepends=True)
    old = "".join(line[1:] for line in lines if line[:1] in "- ")
    new = "".join(line[1:] for line in lines if line[:1] in "+ ")
    if text.count(old) != 1:
        raise ValueError(f"{step}: {text.count(old)} places in {step.detail} have these lines")
    return text.replace(old, new)


def _trimmed(printed: str) -> str:
    return "\n".join(line.rstrip() for line in printed.strip("\n").splitlines()).strip()


def make_clone(folder: Path) -> Path:
    """What a reader has of the repository."""
    shutil.copytree(ROOT / "scenes", folder / "scenes")
    return folder


def main(arguments: list[str]) -> int:
    """1 if something else was printed than the pages say."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--render", action="store_true")
    parser.add_argument("--update", action="store_true")
    asked = parser.parse_args(arguments)
    found: list[tuple[Step, list[Printed]]] = []
    with tempfile.TemporaryDirectory() as folder:
        walk = Walk(
            make_clone(Path(folder)),
            os.environ,
            wanted=lambda step: asked.render or step.mark != "render",
            seen=lambda *each: found.append(each),
        )
        for page in PAGES:
            walk.read(page)
    wrong = [(step, each) for step, block in found for each in block if not each.is_right]
    for step, each in wrong:
        print(f"{step}: $ {each.command}\nexpected\n{each.expected}\nprinted\n{each.printed}\n")
    if asked.update:
        for page in PAGES:
            _update(page, [each for each in found if each[0].page == page])
    return 1 if wrong and not asked.update else 0


def _update(page: Path, found: list[tuple[Step, list[Printed]]]) -> None:
    text = page.read_text("utf-8")
    for step, block in reversed(found):
        new = "".join(f"$ {each.command}\n{_shown(each)}" for each in block)
        text = text[: step.start] + new + text[step.start + len(step.text) :]
    page.write_text(text, "utf-8")


def _shown(each: Printed) -> str:
    """What the page is to show below the command."""
    if each.is_right:
        return each.expected
    gap = "\n" if each.expected.endswith("\n\n") else ""
    return f"{_trimmed(each.printed)}\n{gap}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
