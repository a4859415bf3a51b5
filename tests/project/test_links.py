"""Every link leads to a file and a heading that exist, in pages and wherever code, help and messages name a page."""

from __future__ import annotations

import re
import subprocess
from functools import cache
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), ROOT / "benchmarks/README.md"])
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?P<path>[^)#\s]*)(?:#(?P<anchor>[^)\s]+))?\)")
NAMED = re.compile(r"\bdocs/[\w/-]+\.md(?:#[\w-]+)?")


@cache
def text(page: Path) -> str:
    return FENCED.sub("", page.read_text("utf-8"))


@cache
def anchors(page: Path) -> set[str]:
    """As GitHub makes them; those of a site are held to the same links by `mkdocs build --strict`."""
    headings = re.findall(r"^#+ (.+)$", text(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def missing(page: Path, path: str, anchor: str | None) -> bool:
    target = (page.parent / path).resolve() if path else page
    return not target.exists() or (anchor is not None and anchor not in anchors(target))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    found = [match for match in LINK.finditer(text(page)) if "://" not in match["path"]]
    assert [match[0] for match in found if missing(page, match["path"], match["anchor"])] == []


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="git lists the files")
def test_a_page_that_code_names_exists() -> None:
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, check=True)
    files = [ROOT / name for name in listed.stdout.decode().splitlines()]
    found = [
        (str(file), *named.partition("#")[::2])
        for file in files
        if file.suffix in {".py", ".yaml", ".yml", ".md", ".toml", ".json"} and file.is_file()
        for named in NAMED.findall(file.read_text("utf-8", errors="ignore"))
    ]
    assert len(found) > 20
    assert [each for each in found if missing(ROOT / "README.md", each[1], each[2] or None)] == []


def test_the_site_has_every_page() -> None:
    listed = re.findall(r"[\w/-]+\.md", yaml.dump(yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]))
    pages = [str(page.relative_to(ROOT / "docs")) for page in PAGES if page.is_relative_to(ROOT / "docs")]
    assert sorted(listed) == sorted(pages)
