"""The daily commands, in the environment at hand (`pip install -e ".[dev]"`): `nox -s tests -- -k pose`."""

from pathlib import Path

import nox

nox.options.default_venv_backend = "none"
nox.options.sessions = ["lint", "types", "tests"]


@nox.session
def tests(session: nox.Session) -> None:
    """The tests that need neither a device nor ManiSkill."""
    session.run("pytest", "-n", "auto", *session.posargs)


@nox.session
def render(session: nox.Session) -> None:
    """The tests that render; `.ci/lavapipe FOLDER` brings a software driver, and `. FOLDER/env` turns it on."""
    session.run("pytest", "-n", "auto", "-m", "render", *session.posargs)


@nox.session
def maniskill(session: nox.Session) -> None:
    """The tests with ManiSkill."""
    session.run("pytest", "-n", "auto", "-m", "maniskill", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, and what each folder may import."""
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("lint-imports")


@nox.session
def types(session: nox.Session) -> None:
    """Types."""
    session.run("pyright")


@nox.session
def coverage(session: nox.Session) -> None:
    """How much of the package the tests run through; needs pytest-cov."""
    session.run("pytest", "-n", "auto", "--cov", "scenecc", "--cov-report", "term:skip-covered", *session.posargs)


@nox.session
def snapshots(session: nox.Session) -> None:
    """Writes anew what tests compare with: golden files, frozen outputs, the schema and the page of diagnostics."""
    session.run("pytest", "tests/unit", "-n", "auto", "-q", env={"SCENECC_UPDATE_GOLDEN": "1"})
    session.run("python", "-m", "tests.frozen", "--update")
    session.run("python", "-m", "scenecc.diagnostics.reference", "docs/diagnostics.md")
    schema = session.run("python", "-m", "scenecc", "schema", silent=True)
    Path("schemas/scene.v1.schema.json").write_text(str(schema), encoding="utf-8")


@nox.session
def bench(session: nox.Session) -> None:
    """What scenecc takes now over what it took in a commit: `nox -s bench -- main validate`."""
    session.run("python", "-m", "benchmarks.against", *session.posargs)
