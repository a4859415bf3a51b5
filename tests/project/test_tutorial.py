"""A reader of the tutorial who types what stands there gets what stands there."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from walkthrough import PAGES, Printed, Step, Walk, pictures, steps

ROOT = Path(__file__).parents[2]


def wrong(found: list[tuple[Step, list[Printed]]]) -> list[str]:
    return [
        f"{step}: $ {each.command}\nexpected\n{each.expected}\nprinted\n{each.printed}"
        for step, block in found
        for each in block
        if not each.is_right
    ]


@pytest.mark.timeout(600)
def test_the_commands_print_what_the_pages_show(clone: Path, environment: dict[str, str]) -> None:
    found: list[tuple[Step, list[Printed]]] = []
    walk = Walk(clone, environment, wanted=lambda step: step.mark != "render", seen=lambda *each: found.append(each))
    for page in PAGES:
        walk.read(page)
    assert len(found) > 10
    assert not wrong(found), "run `python assets/walkthrough.py --render --update`, and read the diff"


@pytest.mark.render
@pytest.mark.timeout(600)
def test_the_commands_that_render_print_what_the_pages_show(clone: Path, environment: dict[str, str]) -> None:
    found: list[tuple[Step, list[Printed]]] = []
    walk = Walk(clone, environment, wanted=lambda step: step.mark == "render", seen=lambda *each: found.append(each))
    for page in PAGES:
        walk.read(page)
    assert found
    assert not wrong(found)
    assert {file for file in pictures().values() if not (walk.folder / file).is_file()} == set()


def test_the_walk_reads_every_page_in_the_order_in_which_they_follow() -> None:
    assert set(PAGES) == set((ROOT / "docs/tutorial").glob("*.md"))
    for page, following in itertools.pairwise(PAGES):
        assert f"]({following.name})." in page.read_text("utf-8").splitlines()[-1]


def test_what_is_shown_differs_only_where_the_page_has_an_ellipsis() -> None:
    assert Printed("", "step … in all\n", "step 3 ms, build 1 s; 1 s in all\n").is_right
    assert Printed("", "a\nb\n", "a  \nb\n").is_right
    assert not Printed("", "a … c\n", "a b\nc\n").is_right
    assert not Printed("", "", "Traceback\n").is_right


def page(folder: Path, text: str) -> Path:
    path = folder / "page.md"
    path.write_text(text)
    return path


def test_a_page_is_done_from_top_to_bottom(tmp_path: Path, environment: dict[str, str]) -> None:
    found: list[Printed] = []
    walk = Walk(tmp_path, environment, wanted=lambda _: True, seen=lambda _, block: found.extend(block))
    walk.read(
        page(
            tmp_path,
            "<!-- file: a.txt -->\n```yaml\none: 1\ntwo: 2\n```\n\n<!-- append: a.txt -->\n```yaml\nthree: 3\n```\n\n"
            "<!-- change: a.txt -->\n```diff\n one: 1\n-two: 2\n+two: 22\n```\n\n"
            "```console\n$ cat a.txt\none: 1\ntwo: 22\n\nthree: 3\n$ cat b.txt\nnothing\n```\n\n"
            "<!-- not run: it harms -->\n```bash\nrm a.txt\n```\n",
        )
    )
    assert [each.is_right for each in found] == [True, False]
    assert "No such file" in found[1].printed


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<!-- change: a.txt -->\n```diff\n-one\n+two\n```\n", "0 places in a.txt"),
        ("<!-- serves: a.txt -->\n```console\n$ true\n```\n", "`serves` says nothing"),
        ("```bash\ntrue\n```\n", "`` says nothing"),
    ],
)
def test_a_page_that_cannot_be_followed_is_an_error(tmp_path: Path, text: str, message: str) -> None:
    walk = Walk(tmp_path, {}, wanted=lambda _: True, seen=lambda *_: None)
    (walk.folder / "a.txt").write_text("three\n")
    with pytest.raises(ValueError, match=message):
        walk.read(page(tmp_path, text))


def test_a_block_is_where_it_stands(tmp_path: Path) -> None:
    (step,) = steps(page(tmp_path, "# A page\n\n```console\n$ true\n```\n"))
    assert str(step) == "page.md:4"
