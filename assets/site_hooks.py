"""MkDocs hooks: files that pages link to become files of the site, and pages load nothing from elsewhere.

A page links to `../../scenes/stack.yaml`, which is right where the repository is read. On the site, the same file is at
`scenes/stack.yaml` beside the folders of pages. Folders and READMEs are only in the repository: on the site, their
names stand there without a link.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT: Final = Path(__file__).resolve().parents[1]
LOADED: Final = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*\b(?:src|href)=[\"']?(?:https?:)?//[^>]*>")
LINK: Final = re.compile(r"\[(?P<words>[^\[\]]*)\]\((?P<target>\.\.[^)#\s]*)(?:#[^)\s]*)?\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the files outside of `docs` that a page links to."""
    from mkdocs.structure.files import File  # noqa: PLC0415 - MkDocs is an extra

    linked = {
        outside
        for file in files.documentation_pages()
        for found in LINK.finditer(file.content_string)
        if (outside := _outside(file.src_uri, found["target"])) and _is_copied(outside)
    }
    for path in sorted(linked):
        files.append(File.generated(config, path, abs_src_path=str(ROOT / path)))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leads links out of `docs` to the site's copy."""
    del config, files
    here = page.file.src_uri

    def led(found: re.Match[str]) -> str:
        outside = _outside(here, found["target"])
        if not outside:
            return found[0]
        if not _is_copied(outside):
            return found["words"]
        return f"[{found['words']}]({posixpath.relpath(outside, posixpath.dirname(here) or '.')})"

    return LINK.sub(led, markdown)


def on_post_page(output: str, *, page: Page, config: MkDocsConfig | None) -> str:
    """Writes the page's Markdown beside it, for llms.txt. Stops the build at a page that would load a script, a font or
    a picture from another host.
    """
    if found := LOADED.search(output):
        from mkdocs.exceptions import PluginError  # noqa: PLC0415

        raise PluginError(f"{page.file.src_uri} would load from elsewhere: {found[0]}")
    if config is not None:
        source = Path(config.site_dir, page.file.src_uri)
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text(page.markdown or "", encoding="utf-8")
    return output


def _outside(page: str, target: str) -> str | None:
    """The path in the repository of what is there and not below `docs`, else None."""
    path = posixpath.normpath(posixpath.join("docs", posixpath.dirname(page), target))
    inside = path.startswith(("docs/", ".."))
    return None if inside or not (ROOT / path).exists() else path


def _is_copied(path: str) -> bool:
    return (ROOT / path).is_file() and not path.endswith(".md")
