"""Reads the files that a scene includes and uses, each once, and measures their contents."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.diagnostic import Path as KeyPath
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, nearest
from scenecc.source.paths import AssetScope, Refusal, has_package, resolve_path
from scenecc.source.read import read_text
from scenecc.source.text import read_bytes, text_size
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import EXPRESSION_START, is_mapping, is_sequence
from scenecc.variation.forms import FORM_KEYS, Template

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.source import Document, Limits

SHIPPED_PREFIX = "scenecc:"
"""Prefix of the name of a built-in prefab."""

PREFAB_FOLDER = Path(__file__).resolve().parents[1] / "prefabs"
"""Folder of the built-in prefabs."""

_NAME_A_SCENE = "name a scene file, or a prefab that `scenecc prefabs` lists; a robot is `urdf: …` or `mjcf: …`"

_SHIPPED_URI = "pkg://scenecc/prefabs"

_IN_TREE = re.compile(r"(pkg|asset)://")

_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


@frozen
class SceneDocument:
    """A document, and the base of its relative paths.

    Attributes:
        document: the parsed document.
        folder: folder of the file; the current one for a stream or a dict.
        tree: `pkg://PACKAGE/FOLDER` or `asset://FOLDER` if the file was named by such a URI, else None. Relative
            paths in the file are then relative to this URI.
        identity: canonical path of the file, independent of how it was named.
    """

    document: Document
    folder: Path
    tree: str | None
    identity: str

    @property
    def name(self) -> str | None:
        """Name of the document in origins."""
        return self.document.name

    @property
    def shown(self) -> str:
        """Name of the document in messages."""
        return self.document.name or "<dict>"

    def reference(self, uri: str) -> str:
        """Converts a path or URI in this document for `scenecc.source.paths.resolve_path` with `folder` as base."""
        if self.tree is None or _SCHEME.match(uri) or uri.startswith("/"):
            return uri
        scheme, path = self.tree.split("://", 1)
        return f"{scheme}://{posixpath.normpath(posixpath.join(path, uri))}"

    def absolute(self, uri: str) -> str:
        """Converts a path or URI in this document to one that is valid in every document."""
        uri = self.reference(uri)
        return uri if _SCHEME.match(uri) or not uri else (self.folder / uri).as_posix()

    def shares_folder(self, other: SceneDocument) -> bool:
        """Whether relative paths have the same base in both documents."""
        return self.folder == other.folder and self.tree == other.tree


def top_document(document: Document) -> SceneDocument:
    """Wraps the top document."""
    path = document.path
    folder = Path.cwd() if path is None else path.parent
    return SceneDocument(document, folder, None, str(path.resolve()) if path is not None else "")


Load = Callable[[str, SceneDocument, "Origin"], "SceneDocument | None"]
"""Takes a reference, the document that holds it, and its origin. Returns the scene file, or None after an error. The
same file returns the same document."""


def scene_loader(scope: AssetScope, limits: Limits, sink: Sink) -> Load:
    """Returns a function that loads scene files within `scope`.

    A reference is a path relative to the document's folder, `pkg://PACKAGE/PATH`, `asset://PATH` or `scenecc:NAME`.
    The last is a built-in prefab; `edition_here` selects its edition.
    """
    read: dict[str, SceneDocument | None] = {}
    total = 0

    def load(reference: str, owner: SceneDocument, place: Origin) -> SceneDocument | None:
        """Loads a scene file, each file once."""
        nonlocal total
        uri, shown = owner.reference(reference), None
        if reference.startswith(SHIPPED_PREFIX):
            name = reference[len(SHIPPED_PREFIX) :]
            if name not in shipped_names():
                message = f"no prefab `{cut(name)}` ships with scenecc"
                near = nearest(name.lower().lstrip(":"), shipped_names())
                hint = f"did you mean `{SHIPPED_PREFIX}{near}`?" if near else _NAME_A_SCENE
                sink.report("SC240", message, place, hint=hint)
                return None
            file = shipped_file(name, edition_here(name, scope))
            uri, shown = f"{_SHIPPED_URI}/{file}", SHIPPED_PREFIX + file.removesuffix(".yaml")
        found = resolve_path(uri, base=owner.folder, scope=scope)
        if isinstance(found, Refusal):
            hint = found.hint
            word = reference.lower().removeprefix("scenecc").strip(":/. ").removesuffix(".yaml").replace("-", "_")
            if "/" not in word and (near := nearest(word, shipped_names(), 0.8)):
                hint = f"did you mean `{SHIPPED_PREFIX}{near}`?"
            elif word in {"panda", "fetch", "robot"}:
                hint = f"write `use: {SHIPPED_PREFIX}table_scene, with: {{robot: panda}}`; another robot is `urdf: …`"
            elif hint is None and "." not in reference:
                hint = _NAME_A_SCENE
            sink.report(found.code, found.message, place, hint=hint)
            return None
        identity = str(found.path.resolve())
        if identity not in read:
            tree = posixpath.dirname(uri) if _IN_TREE.match(uri) else None
            shown = shown or (uri if tree is not None else _format_name(reference, owner))
            document = _read_document(found.path, shown, place, limits, sink, scope.memory.texts)
            total += text_size(document.text or "") if document is not None else 0
            if total > limits.text_bytes:
                message = f"the included and used files together are longer than {limits.text_bytes} bytes"
                hint = "`--limit text_bytes=N` or `limits={'text_bytes': N}` raises the limit"
                sink.report("SC601", message, place, hint=hint)
                document = None
            read[identity] = document and SceneDocument(document, found.path.parent, tree, identity)
        return read[identity]

    return load


def shipped_names() -> list[str]:
    """Returns the names of the built-in prefabs, sorted."""
    return sorted(file.stem for file in PREFAB_FOLDER.glob("*.yaml") if "." not in file.stem)


def editions(name: str) -> list[str]:
    """Returns the Python packages for which a built-in prefab has an edition, `NAME.PACKAGE.yaml`, sorted."""
    return sorted(file.stem.removeprefix(f"{name}.") for file in PREFAB_FOLDER.glob(f"{name}.*.yaml"))


def edition_here(name: str, scope: AssetScope) -> str | None:
    """Returns the first of these packages that is installed, without importing it; None for the plain edition."""
    return next((package for package in editions(name) if has_package(package, scope)), None)


def shipped_file(name: str, edition: str | None) -> str:
    """Returns the file name, in `PREFAB_FOLDER`, of an edition of a prefab."""
    return f"{name}.yaml" if edition is None else f"{name}.{edition}.yaml"


def _read_document(
    path: Path, name: str, use: Origin, limits: Limits, sink: Sink, texts: Mapping[Path, str]
) -> Document | None:
    sink.parent = use
    content = texts.get(path)
    if content is None:
        content = read_bytes(str(path), sink, limits)
    document = None if content is None else read_text(content, name, sink, limits, path=path)
    if document is not None and not is_within_object_limit(document, limits, sink):
        document = None
    sink.parent = None
    return document


def _format_name(reference: str, owner: SceneDocument) -> str:
    """Returns a file's name relative to the owner's name, or the absolute path."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(owner.name or ""), reference))


SHAPE_LISTS = frozenset(("shapes", "collisions", "visuals"))
"""Keys of the lists whose items may be repeated."""

LINK_LIST = "children"
"""Key of the list of child links, which may be repeated or conditional."""

VALUES_PER_OBJECT = 8
"""Number of values that count as one object."""

VALUES_PER_FORM = 4
"""Values that a form counts as, in addition to the values in it."""

ROBOT_KEYS = frozenset(("root", "urdf", "mjcf"))

OBJECTS_PER_ROBOT = 8
"""Objects that a robot counts as, in addition to its shapes."""

CHARACTERS_PER_OBJECT = 64
"""Number of characters of generated text that count as one object."""

_CHARACTERS_PER_VALUE = 8
"""Number of characters of an expression that count as one more value: each may be an operation."""


class FailedValue(str):
    """Placeholder for a scalar that failed, or reads a failed value. It causes no further diagnostics."""

    __slots__ = ()


def count_values(node: Any, most: int | None = None) -> int:
    """Counts the values in a node. Repeated items count once, long expressions several times.

    Counting stops at `most`, since nested lists made by expressions may be too large to walk.
    """
    waiting, count = [node], 0
    while waiting and (most is None or count + len(waiting) <= most):
        item = waiting.pop()
        if is_mapping(item):
            waiting += item.values()
            if not FORM_KEYS.isdisjoint(item):
                count += VALUES_PER_FORM
        elif is_sequence(item):
            waiting += item
        else:
            count += 1 + (len(item) // _CHARACTERS_PER_VALUE if isinstance(item, str) and "${" in item else 0)
    return count + len(waiting)


def count_node_objects(node: Any) -> int:
    """Returns the number of objects that a named node counts as: its shapes, or more if it has many values."""
    if not is_mapping(node):
        return max(1, count_values(node) // VALUES_PER_OBJECT)
    robot = OBJECTS_PER_ROBOT * _count_robots(node)
    return max(1, count_values(node) // VALUES_PER_OBJECT, _count_shapes(node)) + robot


def count_added_objects(made: Any) -> int:
    """Returns the number of objects that the text or list result of an expression adds to its node."""
    return len(made) // CHARACTERS_PER_OBJECT if made.__class__ is str else count_values(made) // VALUES_PER_OBJECT


def _count_robots(node: dict[str, Any]) -> int:
    """Counts the robots in an entity: itself and the attached ones."""
    attached = node.get("attach")
    parts = filter(is_mapping, attached.values()) if is_mapping(attached) else ()
    return (not ROBOT_KEYS.isdisjoint(node)) + sum(map(_count_robots, parts))


def _count_shapes(node: dict[str, Any]) -> int:
    """Counts the shapes of an unexpanded entity, in all its variants or links."""
    return sum(map(len, _shape_lists(node)))


def _shape_lists(entity: dict[str, Any]) -> Iterator[Sequence[Any]]:
    """Yields the shape lists of an unexpanded entity, with those of its variants or links."""
    for body in _bodies(entity):
        for key in SHAPE_LISTS:
            if is_sequence(shapes := body.get(key)):
                yield shapes


def _bodies(entity: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yields an unexpanded entity and all its variants, links and attached parts."""
    waiting = [entity]
    while waiting:
        body = waiting.pop()
        yield body

        parts, attached = body.get("variants", body.get(LINK_LIST)), body.get("attach")
        waiting += filter(is_mapping, (body.get("root"), *(parts if is_sequence(parts) else ())))
        waiting += filter(is_mapping, attached.values() if is_mapping(attached) else ())


def iterate_texts(node: Any) -> Iterator[str]:
    """Yields the strings in a node, in any order."""
    todo = [node]
    while todo:
        item = todo.pop()
        if isinstance(item, str):
            yield item
        elif is_mapping(item):
            todo += item.values()
        elif is_sequence(item):
            todo += item


def has_varying(value: Any) -> bool:
    """Returns whether an expanded value differs between scenes: whether it holds a template or a form."""
    if isinstance(value, Template):
        return True
    if is_mapping(value):
        return not FORM_KEYS.isdisjoint(value) or any(map(has_varying, value.values()))
    return is_sequence(value) and any(map(has_varying, value))


def has_failed(value: Any) -> bool:
    """Returns whether an expanded value holds a `FailedValue`."""
    return any(isinstance(text, FailedValue) for text in iterate_texts(value))


def find_per_scene_lists(node: Any, path: KeyPath) -> list[KeyPath]:
    """Returns the paths of the `per_scene` lists in a node."""
    found: list[KeyPath] = []
    if is_mapping(node):
        for key, item in node.items():
            if key == "per_scene" and is_sequence(item):
                found.append((*path, key))
            elif not key.startswith(NOTE_PREFIX):
                found += find_per_scene_lists(item, (*path, key))
    elif is_sequence(node):
        for index, item in enumerate(node):
            found += find_per_scene_lists(item, (*path, index))
    return found


_MIN_OBJECT_CHARACTERS = 10
"""Shortest text of an object [characters]."""


def is_within_object_limit(document: Document, limits: Limits, sink: Sink) -> bool:
    """Returns whether a document has at most `limits.objects` objects. If not, it is reported."""
    text = document.text or ""
    if len(text) < _MIN_OBJECT_CHARACTERS * limits.objects or _bound_objects(text, document.data) <= limits.objects:
        return True
    sections = (node for key, node in document.data.items() if not key.startswith(NOTE_PREFIX))
    count = sum(
        sum(map(count_node_objects, node.values())) if is_mapping(node) else count_node_objects(node)
        for node in sections
    )
    if count <= limits.objects:
        return True
    message = f"{count} objects, or an equal amount of data, are more than the limit of {limits.objects}"
    hint = "raise it with --limit objects=N or limits={'objects': N}"
    sink.report("SC604", message, Origin(document.name), hint=hint)
    return False


def _bound_objects(text: str, data: dict[str, Any]) -> float:
    """Returns an upper bound of a text's objects by counting characters: walking the data is far slower."""
    if "\\" in text:  # a key may be written in escapes
        return inf
    values = sum(map(text.count, (",", "\n", "[", "{", "- ")))
    forms, robots, shapes = (sum(map(text.count, keys)) for keys in (FORM_KEYS, ROBOT_KEYS, ("type",)))
    named = sum(len(node) for node in data.values() if is_mapping(node))
    expressions = len(text) / CHARACTERS_PER_OBJECT if "${" in text else 0
    return (
        named
        + shapes
        + OBJECTS_PER_ROBOT * robots
        + (values + VALUES_PER_FORM * forms) / VALUES_PER_OBJECT
        + expressions
    )


_TOP_LEVEL_KEYS = ("params", "draws", "include")

_ENTITY_KEYS = frozenset(("use", "if", "repeat", "name"))

_COPY_KEYS = frozenset(("if", "repeat", "name"))

_EXPANDED_KEYS = {"entities": _ENTITY_KEYS, "constraints": _COPY_KEYS, "lights": _COPY_KEYS, "cameras": _COPY_KEYS}


def needs_expansion(data: dict[str, Any], text: str | None) -> bool:
    """Returns whether a document uses parameters, draws, includes, repetition, conditions, prefabs or expressions.

    With a text this is fast, because a substring search answers it.

    Args:
        data: data of the document.
        text: the source text; None for a dict.
    """
    if any(key in data for key in _TOP_LEVEL_KEYS):
        return True
    entities = data.get("entities")
    for section, keys in _EXPANDED_KEYS.items():
        nodes = data.get(section)
        if is_mapping(nodes):
            for node in nodes.values():
                if is_mapping(node) and not keys.isdisjoint(node):
                    return True
    # A backslash may escape any character.
    if text is None or "\\" in text:
        return any(EXPRESSION_START in one for one in iterate_texts(data)) or _repeats(entities)
    # The word is not enough: textures have a `repeat` key too.
    return "${" in text or (("repeat" in text or LINK_LIST in text) and _repeats(entities))


def _repeats(entities: Any) -> bool:
    """Whether any entity has a repeated shape, or a repeated or conditional link."""
    nodes = entities.values() if is_mapping(entities) else ()
    return any(_repeats_parts(node) for node in nodes if is_mapping(node))


def _repeats_parts(entity: dict[str, Any]) -> bool:
    if any("repeat" in shape for shapes in _shape_lists(entity) for shape in shapes if is_mapping(shape)):
        return True
    return any("repeat" in link or "if" in link for link in _bodies(entity) if link is not entity)
