"""URDFs with mistakes made at random: each gives a description or an error, and never an exception."""

from __future__ import annotations

import random
import re
from typing import TYPE_CHECKING

import pytest
from fidelity.urdf_cases import CASES

from scenecc.diagnostics import Sink
from scenecc.robots.urdf import read_urdf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

WORDS = (
    "0",
    "-1",
    "nan",
    "inf",
    "1e400",
    "",
    "  ",
    "x",
    "1 2",
    "&lt;",
    "<a/>",
    '"',
    "floating",
    "planar",
    "é",
    "../..",
)


def mistaken(text: str, generator: random.Random) -> str:
    """The text with a value replaced, an element left out, or letters overwritten."""
    kind = generator.choice(["value", "value", "element", "letters"])
    if kind == "letters":
        start = generator.randrange(len(text))
        return text[:start] + generator.choice(WORDS) + text[start + generator.randint(0, 3) :]
    found = list(re.finditer(r'"[^"]*"' if kind == "value" else r"<[^>]*/>", text))
    match = generator.choice(found)
    new = generator.choice([f'"{generator.choice(WORDS)}"', generator.choice(found)[0]]) if kind == "value" else ""
    return text[: match.start()] + new + text[match.end() :]


@pytest.mark.parametrize("name", CASES)
def test_a_mutated_robot_file_gives_a_description_or_an_error(name: str, tmp_path: Path) -> None:
    generator = random.Random(name)
    urdf, srdf = CASES[name]
    path = tmp_path / "robot.urdf"
    for _ in range(40):
        text = urdf
        for _ in range(generator.randint(1, 4)):
            text = mistaken(text, generator)
        path.write_text(text, encoding="utf-8")
        if srdf is not None:
            (tmp_path / "robot.srdf").write_text(mistaken(srdf, generator), encoding="utf-8")
        sink = Sink()
        description = read_urdf(ResolvedFile(path, path.name), scope=AssetScope(tmp_path), sink=sink)
        assert (description is None) == sink.failed, text
        assert all(found.line is not None for found in sink.diagnostics())
