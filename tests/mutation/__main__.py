"""`python -m tests.mutation --sample 150`: changes one thing of the package at a time, and tells what no test notices.

A run of the tests under coverage says which of them pass through which line. A mutant is held to those alone, in a
forked process that loads the changed module in place of the file. mutmut changes nothing outside of functions and
nothing in decorated ones, and most of `variation/operations.py` is a table.
"""

from __future__ import annotations

import argparse
import ast
import importlib.machinery
import os
import random
import resource
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType

import coverage
import hypothesis  # noqa: F401 - loaded before processes are forked, as is all that is not of the package
import pytest
import sapien  # noqa: F401

ROOT = Path(__file__).parents[2]
TESTS = "tests/unit tests/property tests/test_scenes_tree.py tests/frozen"
COVERED = "-q -n auto -m '' --cov-context=test --cov-report="
RUN = "-x -q -m '' -p no:cacheprovider -p no:cov -p no:xdist --timeout=60 -W ignore::pytest.PytestAssertRewriteWarning"

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
    ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.Break: ast.Continue, ast.Continue: ast.Break,
}  # fmt: skip


def mutable(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes that are run; not annotations, decorators, assertions, imports, and what `zip` is told of lengths."""
    checked_only = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    if checked_only or isinstance(node, ast.Assert | ast.Import | ast.ImportFrom):
        return
    yield node
    alias = isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation) == "TypeAlias"
    for name, value in ast.iter_fields(node):
        if name not in {"annotation", "returns", "decorator_list"} and not (alias and name == "value"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST) and not (isinstance(child, ast.keyword) and child.arg == "strict"):
                    yield from mutable(child)


def mutate(node: ast.AST) -> bool:
    """Changes a node in place; False where there is nothing to change."""
    match node:
        case ast.BoolOp() | ast.BinOp() if type(node.op) in SWAPS:
            setattr(node, "op", SWAPS[type(node.op)]())  # noqa: B010 - its type depends on the node's
        case ast.Compare():
            setattr(node, "ops", [SWAPS[type(node.ops[0])](), *node.ops[1:]])  # noqa: B010
        case ast.Constant(bool()):
            node.value = not node.value
        case ast.Constant(int() | float() as number):
            node.value = number + 1
        case ast.If() | ast.IfExp() | ast.While():
            node.test = ast.UnaryOp(ast.Not(), node.test)
        case ast.UnaryOp(ast.USub()):
            node.op = ast.UAdd()
        case ast.UnaryOp(ast.Not()):
            node.operand = ast.UnaryOp(ast.Not(), node.operand)
        case ast.Return(ast.expr()) | ast.Expr(ast.Call() | ast.YieldFrom()) if ast.unparse(node) != "return None":
            node.value = ast.Constant(None)
        case ast.Break() | ast.Continue():
            setattr(node, "__class__", SWAPS[type(node)])  # noqa: B010
        case _:
            return False
    ast.fix_missing_locations(node)
    return True


def mutant(file: Path, site: int) -> tuple[CodeType, int, str]:
    """The module with another node of that number in the order of `mutable`, its line, and the change in words."""
    tree = ast.parse(file.read_text("utf-8"))
    node = list(mutable(tree))[site]
    before, line = ast.unparse(node).split("\n")[0], getattr(node, "test", node).lineno  # type: ignore[attr-defined]
    mutate(node)
    words = f"{before}  ->  {ast.unparse(node).splitlines()[0]}"
    return compile(tree, str(file), "exec", dont_inherit=True), line, words


class Selection:
    """Keeps of what pytest collects the tests that pass through a line; those of the file's own folder come first."""

    def __init__(self, contexts: set[str], folder: str) -> None:
        self.names = {context.rpartition("|")[0] for context in contexts}
        files = {name.partition("::")[0] for name in self.names}
        self.files = sorted(files, key=lambda file: (f"tests/unit/{folder}/" not in file, "frozen" in file, file))

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [item for item in items if item.nodeid in self.names]


def survives(file: Path, code: CodeType, selection: Selection) -> bool:
    """Whether all tests pass with this in place of the file."""
    if (pid := os.fork()) == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (600, 600))  # a mutant may loop where no test has begun
        loader, read = importlib.machinery.SourceFileLoader, importlib.machinery.SourceFileLoader.get_code
        setattr(loader, "get_code", lambda self, name: code if self.path == str(file) else read(self, name))  # noqa: B010
        null = os.open(os.devnull, os.O_WRONLY)
        _ = os.dup2(null, 1), os.dup2(null, 2)
        os._exit(int(pytest.main([*shlex.split(RUN), *selection.files], plugins=[selection])) if selection.files else 0)
    return os.waitpid(pid, 0)[1] == 0


def main() -> int:
    """1 where less than 85 % of the mutants are noticed."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("folders", nargs="*", default=["variation", "lower"], help="folders of the package")
    parser.add_argument("--sample", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--map", type=Path, default=ROOT / ".coverage.mutation", help="made where it is not there")
    asked = parser.parse_args()
    os.chdir(ROOT)
    os.environ |= {"CI": "1", "COVERAGE_FILE": str(asked.map)}  # Hypothesis draws the same examples each time
    if not asked.map.exists():
        covered = [f"--cov=scenecc/{folder}" for folder in asked.folders]
        subprocess.run([sys.executable, "-m", "pytest", *shlex.split(COVERED), *covered, *TESTS.split()], check=True)
    data = coverage.CoverageData(str(asked.map))
    data.read()
    files = [file for folder in asked.folders for file in sorted((ROOT / "scenecc" / folder).rglob("*.py"))]
    nodes = {file: list(mutable(ast.parse(file.read_text("utf-8")))) for file in files}
    every = [(file, site) for file in files for site, node in enumerate(nodes[file]) if mutate(node)]
    sample, alive = random.Random(asked.seed).sample(every, min(asked.sample, len(every))), 0
    for n, (file, site) in enumerate(sample, 1):
        code, line, words = mutant(file, site)
        contexts = {at: set(tests) - {""} for at, tests in data.contexts_by_lineno(str(file)).items()}
        # Not every line has code of its own: the one before it has, then. One that runs in no test runs in all.
        here = contexts.get(max((at for at in contexts if at <= line), default=line)) or set().union(*contexts.values())
        began, selection = time.monotonic(), Selection(here, file.relative_to(ROOT).parts[1])
        alive += (living := survives(file, code, selection))
        told = f"{'SURVIVED' if living else 'noticed'} after {time.monotonic() - began:.0f} s"
        print(f"{n} {told}: {file}:{line}: {words}", flush=True)
    score = 100 * (1 - alive / len(sample))
    print(f"{score:.0f} % of {len(sample)} mutants are noticed, of {len(every)} that there are")
    return int(score < 85)


if __name__ == "__main__":
    sys.exit(main())
