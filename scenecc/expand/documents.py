"""Scene files that others name: finding, reading and checking them, each once."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
from scenecc.expand.contents import is_within_object_limit
from scenecc.source.paths import AssetScope, Refusal, has_package, resolve_path
from scenecc.source.read import read_text
from scenecc.source.text import read_bytes, text_size

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.source import Document, Limits

SHIPPED_PREFIX = "scenecc:"
"""What stands before the name of a prefab that ships with the package."""

PREFAB_FOLDER = Path(__file__).resolve().parents[1] / "prefabs"
"""Where they are."""

_SHIPPED_URI = "pkg://scenecc/prefabs"
_IN_TREE = re.compile(r"(pkg|asset)://")
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


@frozen
class SceneDocument:
    """A document, and what the paths in it are relative to.

    Attributes:
        document: what was read.
        folder: of the file; the current one for a stream or a dict.
        tree: `pkg://PACKAGE/FOLDER` or `asset://FOLDER` of a file that was named so, None of any other. What such a
            file names lies in that tree too.
        identity: of the file: the same however it is named.
    """

    document: Document
    folder: Path
    tree: str | None
    identity: str

    @property
    def name(self) -> str | None:
        """As origins have it."""
        return self.document.name

    @property
    def shown(self) -> str:
        """As messages have it."""
        return self.document.name or "<dict>"

    def reference(self, uri: str) -> str:
        """A path or uri that stands in this document, as `scenecc.source.paths.resolve_path` takes it with `folder`."""
        if self.tree is None or _SCHEME.match(uri) or uri.startswith("/"):
            return uri
        scheme, path = self.tree.split("://", 1)
        return f"{scheme}://{posixpath.normpath(posixpath.join(path, uri))}"

    def absolute(self, uri: str) -> str:
        """The same, to be read in any other document."""
        uri = self.reference(uri)
        return uri if _SCHEME.match(uri) or not uri else (self.folder / uri).as_posix()

    def shares_folder(self, other: SceneDocument) -> bool:
        """Whether a relative path means the same in both."""
        return self.folder == other.folder and self.tree == other.tree


def top_document(document: Document) -> SceneDocument:
    """The document that the others are reached from."""
    path = document.path
    folder = Path.cwd() if path is None else path.parent
    return SceneDocument(document, folder, None, str(path.resolve()) if path is not None else "")


Load = Callable[[str, SceneDocument, "Origin"], "SceneDocument | None"]
"""Reads the scene file that a document names (reference as written, the document, where it stands); None where that
was reported. The same file gives the same document."""


def scene_loader(scope: AssetScope, limits: Limits, sink: Sink) -> Load:
    """Reads scene files inside what a compilation may read.

    A reference is a path relative to the document's folder, `pkg://PACKAGE/PATH`, `asset://PATH`, or `scenecc:NAME`,
    which stands for the edition of that prefab that is used here; see `edition_here`.
    """
    read: dict[str, SceneDocument | None] = {}
    total = 0

    def load(reference: str, owner: SceneDocument, place: Origin) -> SceneDocument | None:
        """A `Load` that reads each file once, however it is named."""
        nonlocal total
        uri, shown = owner.reference(reference), None
        if reference.startswith(SHIPPED_PREFIX):
            name = reference[len(SHIPPED_PREFIX) :]
            if name not in shipped_names():
                message = f"no prefab `{cut(name)}` ships with scenecc"
                sink.report("SC240", message, place, hint=suggest(name, shipped_names()))
                return None
            file = shipped_file(name, edition_here(name, scope))
            uri, shown = f"{_SHIPPED_URI}/{file}", SHIPPED_PREFIX + file.removesuffix(".yaml")
        found = resolve_path(uri, base=owner.folder, scope=scope)
        if isinstance(found, Refusal):
            sink.report(found.code, found.message, place, hint=found.hint)
            return None
        identity = str(found.path.resolve())
        if identity not in read:
            tree = posixpath.dirname(uri) if _IN_TREE.match(uri) else None
            shown = shown or (uri if tree is not None else _shown_name(reference, owner))
            document = _read_document(found.path, shown, place, limits, sink)
            total += text_size(document.text or "") if document is not None else 0
            if total > limits.text_bytes:
                message = f"the files that are included and used are longer than {limits.text_bytes} bytes together"
                hint = "`--limit text_bytes=N` or `limits={'text_bytes': N}` raises the limit"
                sink.report("SC601", message, place, hint=hint)
                document = None
            read[identity] = document and SceneDocument(document, found.path.parent, tree, identity)
        return read[identity]

    return load


def shipped_names() -> list[str]:
    """The prefabs that ship, by name."""
    return sorted(file.stem for file in PREFAB_FOLDER.glob("*.yaml") if "." not in file.stem)


def editions(name: str) -> list[str]:
    """The Python packages with which a prefab that ships is another file, by name: `NAME.PACKAGE.yaml`."""
    return sorted(file.stem.removeprefix(f"{name}.") for file in PREFAB_FOLDER.glob(f"{name}.*.yaml"))


def edition_here(name: str, scope: AssetScope) -> str | None:
    """The first of these packages that is installed, None for the plain `NAME.yaml`. None of them is imported."""
    return next((package for package in editions(name) if has_package(package, scope)), None)


def shipped_file(name: str, edition: str | None) -> str:
    """The file in `FOLDER` that holds an edition of a prefab."""
    return f"{name}.yaml" if edition is None else f"{name}.{edition}.yaml"


def _read_document(path: Path, name: str, use: Origin, limits: Limits, sink: Sink) -> Document | None:
    sink.parent = use
    content = read_bytes(str(path), sink, limits)
    document = None if content is None else read_text(content, name, sink, limits, path=path)
    if document is not None and not is_within_object_limit(document, limits, sink):
        document = None
    sink.parent = None
    return document


def _shown_name(reference: str, owner: SceneDocument) -> str:
    """As the top file's name was given: beside that, or absolute."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(owner.name or ""), reference))
