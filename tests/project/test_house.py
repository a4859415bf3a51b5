"""The rules of the house that no linter holds."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODULES = sorted((ROOT / "scenecc").rglob("*.py"))


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def test_a_file_has_at_most_800_lines_and_a_function_60() -> None:
    found = []
    for path in MODULES:
        text = path.read_text(encoding="utf-8")
        functions = (
            node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        )
        sizes = [
            (name(path), len(text.splitlines()), 800),
            *((f"{name(path)}: {f.name}", _code_lines(f), 60) for f in functions),
        ]
        found += [f"{what} has {lines} lines" for what, lines, most in sizes if lines > most]
    assert not found, "\n".join(found)


def _code_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its docstring, which in an API may be long."""
    first = node.body[0]
    documented = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
    docstring = (first.end_lineno or 0) - first.lineno + 1 if documented else 0
    return (node.end_lineno or 0) - node.lineno + 1 - docstring


def test_every_folder_of_the_package_says_what_it_is_for() -> None:
    for path in MODULES:
        if path.name == "__init__.py":
            assert ast.get_docstring(ast.parse(path.read_text())), name(path)


def test_the_version_is_written_once() -> None:
    from scenecc import __version__

    text = (ROOT / "scenecc/version.py").read_text()
    assert f'VERSION: Final = "{__version__}"' in text
    assert not re.search(r"^version\b", (ROOT / "pyproject.toml").read_text(), re.MULTILINE)


def test_instructions_and_changelog_name_the_version() -> None:
    from scenecc import __version__

    pages = [ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("scenecc/templates/**/*.y*ml")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    named = re.findall(r"OWNER/scenecc(?:@v|\n *rev: v)([\w.]+)", text)
    assert len(named) >= 3
    assert {*named} == {__version__}
    assert "ADDRESS/OF" not in text
    sections = re.findall(r"^## \[(.*)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sections[0] == "Unreleased]"
    assert re.fullmatch(rf"{re.escape(__version__)}\] - \d{{4}}-\d\d-\d\d", sections[1])


def test_importing_scenecc_is_cheap() -> None:
    script = "import sys, scenecc; print(*{'numpy', 'sapien', 'trimesh', 'pydantic', 'rich'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, check=True, timeout=60)
    assert done.stdout == b"\n"


def test_public_names_are_documented() -> None:
    import scenecc

    for public in scenecc.__all__:
        if public != "__version__":
            assert getattr(scenecc, public).__doc__, public


_SAME_FUNCTIONS = (
    # The operations for one rotation and for arrays of them.
    {"geometry/rotations.py", "geometry/rotation_arrays.py"},
    # Both backends.
    {"backends/sapien/__init__.py", "backends/maniskill/__init__.py"},
    # The facade passes on what it names.
    {"scene.py", "spec/json_schema.py"},
    {"scene.py", "expand/listing.py"},
)
"""Modules that may have functions of the same names."""

_ENTRY_POINTS = {"main": "", "prepare": "", "render": "diagnostics/formats/", "write": "emit/"}
"""Functions that modules of a folder have under one name, because a table or an interpreter calls them by it."""


def _public_definitions() -> dict[str, set[str]]:
    """The public classes and functions of modules: name → the modules that define it. Those of `cli` are commands."""
    found: dict[str, set[str]] = {}
    for path in MODULES:
        module = str(path.relative_to(ROOT / "scenecc"))
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) or node.name[0] == "_":
                continue
            command = module.startswith("cli/") and path.stem.rstrip("_") == node.name
            entry = node.name in _ENTRY_POINTS and module.startswith(_ENTRY_POINTS[node.name])
            if not command and not entry:
                found.setdefault(node.name, set()).add(module)
    return found


def test_a_public_name_means_one_class_or_function() -> None:
    twice = {
        name: sorted(modules)
        for name, modules in _public_definitions().items()
        if len(modules) > 1 and not any(modules <= family for family in _SAME_FUNCTIONS)
    }
    assert twice == {}


def test_code_message_and_hint_are_one_exception() -> None:
    found = [
        f"{name(path)}: {node.name}"
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and node.name != "CodedError" and _takes_code_and_hint(node)
    ]
    assert found == []


def _takes_code_and_hint(node: ast.ClassDef) -> bool:
    """Whether it is an exception whose arguments are those of `CodedError`."""
    makers = [one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"]
    given = {arg.arg for maker in makers for arg in (*maker.args.args, *maker.args.kwonlyargs)}
    return bool(node.bases) and {"code", "message", "hint"} <= given
