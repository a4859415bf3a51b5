"""Words that users must not meet in messages, help, prefabs and docs, with what to write instead."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import scenecc

PACKAGE = Path(scenecc.__file__).parent
ROOT = PACKAGE.parent

WORDS = {
    r"alone": "only, by itself",
    r"anew": "again; for `draws anew` redraws",
    r"anyhow": "always, in any case",
    r"hangs? on": "is attached to",
    r"in a circle": "circular",
    r"(?<!there )is (?-i:none)": "is not one of",
    r"(?<!there )(?:is|are) no(?! longer)": "is not a, cannot have",
    r"(?:is|are) said": "is written, is set",
    r"(?:is|are) wanted": "is needed, is expected",
    r"(?:is|are|be|been|only) seen": "is visible; for `what is seen` visual shapes",
    r"(?:is|are|was|were) meant(?! (?:as|to)\b)": "is intended",
    r"judge[sd]?": "checks, tests",
    r"likewise": "also, the same",
    r"mend(?:s|ed)?": "fix",
    r"no body has": "is physically impossible",
    r"nothing but": "only",
    r"nothing of": "no part of",
    r"(?:one|row|value|number|object)s? an? (?:scene|axis|choice|item|joint|pixel)": "one for each, per",
    r"parted by": "separated by",
    r"rubs?": "has friction",
    r"(?:some|no)body": "another program, no user",
    r"stands? (?:alone|around|as|beside|before|below|for|in|inside|relative|there|twice|under)": "is, is written",
    r"tells?": "gives, reports, determines",
    r"tie[sd]?": "connects",
    r"told": "reported, given",
    r"torn": "violated",
    r"wants": "needs",
    r"whoever": "anyone who",
}
"""Pattern of a word or a phrase → what to write instead."""

KINDS = {".py", ".yaml", ".yml"}

_BANNED = re.compile(rf"(?<![\w-])(?:{'|'.join(f'({word})' for word in WORDS)})(?![\w-])", re.IGNORECASE)
_INSTEAD = tuple(WORDS.values())
_CODE = re.compile(r"^ *```.*?^ *```|`[^`\n]*`|\]\([^)\n]*\)", re.MULTILINE | re.DOTALL)


def faults(text: str, line: int = 1) -> Iterator[tuple[int, str]]:
    """(line, complaint) for each banned phrase of a text, outside `code` and fenced blocks."""
    plain = _CODE.sub(lambda code: "`" * len(code[0]), text).replace("\n", " ")
    for found in _BANNED.finditer(plain):
        instead = _INSTEAD[(found.lastindex or 1) - 1]
        yield line + text.count("\n", 0, found.start()), f"`{found[0].lower()}`: write `{instead}`"


def strings(node: ast.AST, command: str = "") -> Iterator[tuple[int, str]]:
    """(line, text) of each string literal below a node that is prose: no docstring except the help of a command."""
    for child in ast.iter_child_nodes(node):
        is_docstring = isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)
        is_help = isinstance(node, ast.FunctionDef) and node.name == command
        if is_docstring and not is_help:
            continue
        if isinstance(child, ast.JoinedStr):
            parts = [part.value if isinstance(part, ast.Constant) else "{}" for part in child.values]
            yield child.lineno, "".join(map(str, parts))
            for part in child.values:
                yield from strings(part, command)
        elif isinstance(child, ast.Constant):
            if isinstance(child.value, str) and " " in child.value:
                yield child.lineno, child.value
        else:
            yield from strings(child, command)


def complaints(file: Path) -> list[str]:
    """`FILE:LINE: WORD` for each banned word that a user of this file can meet."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".json":
        text = re.sub(r'^ *(?!"description"|\s)[^\n]*', "", text, flags=re.MULTILINE)
    if file.suffix == ".py" and _BANNED.search(text):
        literals = strings(ast.parse(text), file.stem if file.parent.name == "cli" else "")
        found = [fault for line, literal in literals for fault in faults(literal, line)]
    else:
        found = [] if file.suffix == ".py" else list(faults(text))
    return [f"{file.relative_to(ROOT)}:{line}: {message}" for line, message in found]


FOLDERS = sorted({file.parent.relative_to(PACKAGE).as_posix() for file in PACKAGE.rglob("*.*") if file.suffix in KINDS})


@pytest.mark.parametrize("folder", FOLDERS)
def test_messages_are_plain_english(folder: str) -> None:
    files = sorted(file for file in (PACKAGE / folder).iterdir() if file.suffix in KINDS)
    assert [fault for file in files for fault in complaints(file)] == []


PAGES = {
    file.relative_to(ROOT).as_posix() if file.parent == ROOT else file.parent.relative_to(ROOT).as_posix()
    for pattern in (
        "README.md",
        "CONTRIBUTING.md",
        "docs/**/*.md",
        "scenes/**/*.yaml",
        "examples/*.py",
        "schemas/*.json",
    )
    for file in ROOT.glob(pattern)
}


@pytest.mark.parametrize("page", sorted(PAGES))
def test_docs_and_scenes_are_plain_english(page: str) -> None:
    path = ROOT / page
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    pages = [file for file in files if file.suffix in {".md", ".yaml", ".py", ".json"}]
    assert [fault for file in pages for fault in complaints(file)] == []


SOURCE = """\
'no message'
report("SC101", f"the {'man told' if x else y} told")
def f():
    'the help'
    "a b"
"""


def test_what_is_found_names_line_and_word() -> None:
    text = "The mass is told\nat `told` and there is no mesh;\nthis is\nno mesh, and stands inside."
    assert [(line, said.split(":")[0]) for line, said in faults(text, 5)] == [
        (5, "`told`"),
        (7, "`is no`"),
        (8, "`stands inside`"),
    ]
    source = ast.parse(SOURCE)
    assert [line for line, _ in strings(source)] == [2, 2]
    assert [line for line, _ in strings(source, "f")] == [2, 2, 4, 5]
