"""The daily commands, in the environment at hand: `nox -s tests -- -k pose`.

`pip install -c constraints.txt -e '.[dev]'` makes one.
"""

from pathlib import Path

import nox

COVERAGE = ("--cov", "scenecc", "--cov-report", "term:skip-covered")

nox.options.default_venv_backend = "none"
nox.options.sessions = ["lint", "types", "tests"]


@nox.session
def tests(session: nox.Session) -> None:
    """The quick tests (`-- -m ""`: all that can run here); then how much of the package they run through."""
    session.run("pytest", "-n", "auto", *COVERAGE, *session.posargs)


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
def browser(session: nox.Session) -> None:
    """The tests in a browser; `.ci/chromium FOLDER` brings one, and `. FOLDER/env` turns it on."""
    session.run("pytest", "-m", "browser", "tests/browser", *session.posargs)


@nox.session
def docs(session: nox.Session) -> None:
    """The site of the documentation, in build/site: `nox -s docs -- serve` shows it while you write."""
    session.run("mkdocs", *(session.posargs or ("build", "--strict")), env={"NO_MKDOCS_2_WARNING": "1"})


@nox.session
def fuzz(session: nox.Session) -> None:
    """Mutated files, for a minute: `nox -s fuzz -- --seconds 600 --target mesh`."""
    session.run("python", "-m", "tests.fuzz", *(session.posargs or ("--seconds", "60")))


@nox.session
def mutation(session: nox.Session) -> None:
    """Changes of operators and numbers that no test notices: `nox -s mutation -- lower --sample 300 --seed 1`."""
    session.run("python", "-m", "tests.mutation", *session.posargs)


@nox.session
def snapshots(session: nox.Session) -> None:
    """Writes anew what tests compare with: golden files, frozen outputs, the schema, and pages of the documentation."""
    session.run("pytest", "tests/unit", "-n", "auto", "-q", env={"SCENECC_UPDATE_GOLDEN": "1"})
    session.run("python", "-m", "tests.frozen", "--update")
    session.run("python", "tests/plugins/diagnostics_pages.py", "docs/reference/diagnostics")
    for page in ("prefabs", "cli"):
        text = session.run("python", f"tests/plugins/{page.removesuffix('s')}_page.py", silent=True)
        Path(f"docs/reference/{page}.md").write_text(str(text), encoding="utf-8")
    schema = session.run("python", "-m", "scenecc", "schema", silent=True)
    Path("schemas/scene.v1.schema.json").write_text(str(schema), encoding="utf-8")
    session.run("python", "assets/walkthrough.py", "--update")


@nox.session
def bench(session: nox.Session) -> None:
    """What scenecc takes now over what it took in a commit: `nox -s bench -- main validate`."""
    session.run("python", "-m", "benchmarks.against", *session.posargs)
