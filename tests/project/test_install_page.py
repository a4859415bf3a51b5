"""`docs/install.md` lists the extras of `pyproject.toml`, for the purposes that `scenecc doctor` prints."""

from __future__ import annotations

import re
import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # pytest brings it there

from scenecc.extras import EXTRAS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/install.md").read_text("utf-8")
DECLARED = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
FOR_DEVELOPERS = {"test", "dev", "docs", "all"}


def packages(extra: str) -> list[str]:
    return [re.split(r"[\[>=<]", requirement)[0] for requirement in DECLARED[extra]]


def test_the_page_lists_every_extra_with_its_purpose_and_packages() -> None:
    assert DECLARED.keys() == EXTRAS.keys() | FOR_DEVELOPERS
    rows = [row for row in PAGE.splitlines() if re.match(r"\| `", row)]
    assert rows == [f"| `{name}` | {extra.purpose} | {', '.join(packages(name))} |" for name, extra in EXTRAS.items()]
    assert all(f"`{name}`" in PAGE for name in FOR_DEVELOPERS)
