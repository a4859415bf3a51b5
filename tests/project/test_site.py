"""What the site does with a page: links out of `docs` lead to copies, and nothing is loaded from elsewhere."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from site_hooks import LOADED, on_page_markdown, on_post_page


def page(name: str) -> Any:
    return SimpleNamespace(file=SimpleNamespace(src_uri=name))


@pytest.mark.parametrize(
    ("name", "link", "expected"),
    [
        ("how-to/a.md", "[x](../../scenes/stack.yaml)", "[x](../scenes/stack.yaml)"),
        ("index.md", "[x](../scenes/stack.yaml)", "[x](scenes/stack.yaml)"),
        ("how-to/a.md", "see [the scenes](../../scenes)", "see the scenes"),
        ("reference/b/c.md", "[Install](../../../README.md#install)", "Install"),
        ("how-to/a.md", "[x](../reference/language.md#poses)", "[x](../reference/language.md#poses)"),
        ("how-to/a.md", "[x](../../scenes/none.yaml)", "[x](../../scenes/none.yaml)"),
        ("a.md", "[x](../../../etc/passwd)", "[x](../../../etc/passwd)"),
    ],
)
def test_a_link_to_a_file_of_the_repository_leads_to_the_copy(name: str, link: str, expected: str) -> None:
    unused: Any = None
    assert on_page_markdown(link, page=page(name), config=unused, files=unused) == expected


@pytest.mark.parametrize(
    "loaded",
    [
        '<script src="https://cdn.example/x.js"></script>',
        '<link rel="stylesheet" href="//fonts.example/css">',
        "<img alt=x src=http://example.org/x.png>",
    ],
)
def test_a_page_that_loads_from_elsewhere_ends_the_build(loaded: str) -> None:
    assert LOADED.search(loaded)
    exceptions = pytest.importorskip("mkdocs.exceptions")
    unused: Any = None
    with pytest.raises(exceptions.PluginError, match=r"a\.md would load from elsewhere"):
        on_post_page(loaded, page=page("a.md"), config=unused)


def test_a_page_may_link_elsewhere_and_load_what_is_its_own() -> None:
    unused: Any = None
    own = '<a href="https://sapien.ucsd.edu">x</a><script src="../assets/x.js"></script>'
    assert on_post_page(own, page=page("a.md"), config=unused) == own


def test_a_pages_markdown_is_written_beside_it(tmp_path: Any) -> None:
    own: Any = SimpleNamespace(file=SimpleNamespace(src_uri="how-to/a.md"), markdown="# A\n")
    config: Any = SimpleNamespace(site_dir=str(tmp_path))
    assert on_post_page("<p>", page=own, config=config) == "<p>"
    assert (tmp_path / "how-to/a.md").read_text() == "# A\n"
