"""Makes packs: collects the files that a scene can name, lays them out, and tests that the pack is complete."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location, Origin, Severity
from scenecc.diagnostics.diagnostic import Path as KeyPath
from scenecc.errors import SceneError
from scenecc.expand.documents import SceneDocument
from scenecc.files import PACK_SUFFIX, TooLongError, read_at_most, replace_all
from scenecc.interrupt import temporary_folder
from scenecc.options import CompileOptions, Options, check_types, path_argument
from scenecc.pipeline import CompileResult, compile_source, list_result_params
from scenecc.plan.diff import diff_plans
from scenecc.source import Document, read_text
from scenecc.source.pack import MAX_PACK_BYTES, OWN_FOLDER, InvalidPackError, Manifest, Pack, open_pack, pack_bytes
from scenecc.source.paths import Lookup, PathCache, ResolvedFile, resolve_path
from scenecc.spec.nodes import is_mapping, is_sequence

if TYPE_CHECKING:
    from scenecc.expand.listing import ParamRow
    from scenecc.plan import ScenePlan

_MOST_VARIANTS: Final = 16
"""Maximum number of compilations with other options of the scene's parameters."""

_FILE_KEYS: Final = frozenset(
    ("file", "include", "map", "mjcf", "package_dir", "srdf", "starts", "texture", "urdf", "use")
)

_PROSE_KEYS: Final = frozenset(("description", "name"))

_EXPRESSION: Final = re.compile(r"\$\{[^}]*\}")

_SUFFIX: Final = re.compile(r"\.[A-Za-z]\w{1,4}$")

_PATH: Final = re.compile(r"[^\s\"'{}]*[/.][^\s\"'{}]*")
"""Text that may be a file path."""


@dataclass(frozen=True)
class Packed:
    """A new pack.

    Attributes:
        content: bytes of the archive.
        manifest: its manifest, with the SHA-256 of each file.
        diagnostics: diagnostics of the scene, and warnings about files that the pack may lack.
    """

    content: bytes
    manifest: Manifest
    diagnostics: list[Diagnostic]


def read_pack(path: str | PathLike[str]) -> Pack:
    """Reads a pack and verifies it against its manifest, unless an earlier call did.

    Raises:
        SceneError: it is not a pack, or damaged.
    """
    sink = Sink()
    pack = open_pack(os.fspath(path), sink)
    if pack is None:
        raise SceneError(sink.diagnostics())
    return pack


def pack_scene(
    source: str | PathLike[str],
    path: str | PathLike[str] | None = None,
    *,
    add: Iterable[str | PathLike[str]] = (),
    **options: Unpack[CompileOptions],
) -> Packed:
    """Packs a scene, what it includes, and its assets into one archive, which can be used in place of the scene.

    It holds the files for all seeds, for the parameters' defaults, for `params`, and, if file names depend on them, for
    each option of a `choice` and for both values of a boolean. A warning (SC429) reports names that other values could
    give.

    Args:
        source: path of the scene.
        path: where to write the pack, `.scn`; None: it is not written.
        add: further files, or folders with all their content, beside or below the scene or in an asset root.
        options: fields of `CompileOptions`. A pack itself needs no `asset_roots`.

    Raises:
        SceneError: the scene has errors, or cannot be packed.
        ValueError: an argument is out of range, or `path` does not end in `.scn`.
        OSError: a file cannot be read or written.
    """
    asked = Options.of_call(pack_scene, options)
    check_types(pack_scene, {"add": add}, {"add": Iterable[str | PathLike[str]]})
    scene = path_argument(pack_scene, "source", source)
    target = None if path is None else path_argument(pack_scene, "path", path)
    if target is not None and target.suffix.lower() != PACK_SUFFIX:
        raise ValueError(f"the name of a pack must be NAME{PACK_SUFFIX}, not {target.name!r}")
    sink = Sink()
    made = _Packer(scene, asked, sink).pack([add] if isinstance(add, str | PathLike) else [*add])
    if made is None:
        raise SceneError(sink.diagnostics())
    if target is not None:
        replace_all({target: made[0]})
    return Packed(*made, sink.diagnostics())


class _Packer:
    """Packs one scene.

    Args:
        scene: path of the scene.
        options: the requested options.
        sink: collects diagnostics.
    """

    def __init__(self, scene: Path, options: Options, sink: Sink) -> None:
        self._scene = scene
        self._place = Location(str(scene))
        self._options = options
        self._sink = sink
        self._memory = PathCache()
        self._plans: list[tuple[Options, ScenePlan]] = []

    def pack(self, add: list[str | PathLike[str]]) -> tuple[bytes, Manifest] | None:
        """Returns the archive and its manifest; None if that failed, which is reported."""
        result = self._compile(self._options, self._sink)
        if result is None:
            return None
        document = result.document
        if document is None or document.path is None or result.scope.packages is not None:
            return self._refuse("this is a pack already", "copy it")
        rows = list_result_params(result, self._options.limits)
        unknown = self._unknown(result, {row.name for row in rows})
        if unknown and rows:
            variants, are_all = _variants(rows, self._options)
            for variant in variants:
                self._compile(variant, Sink())
            enumerated = {row.name for row in rows if _choices(row)} if are_all else set[str]()
            unknown = self._unknown(result, {row.name for row in rows} - enumerated)
        for one in map(Path, add):
            for file in sorted(one.rglob("*")) if one.is_dir() else [one]:
                if not file.is_dir():
                    real = Path(os.path.realpath(file.parent)) / file.name
                    self._memory.lookups.append(Lookup(str(one), file.absolute(), real, None))
        made = self._archive(result, document.path)
        if made is None or not self._is_enough(made[0]):
            return None
        for severity, message, place in unknown:
            hint = "--set NAME=VALUE packs the files of other values, and --add FILE further files"
            self._sink.report("SC429", message, place, hint=hint, severity=severity)
        return made

    def _refuse(self, message: str, hint: str | None) -> None:
        self._sink.report("SC428", message, self._place, hint=hint)

    def _compile(self, options: Options, sink: Sink) -> CompileResult | None:
        """Compiles the scene and records what it looks up; None if it has errors."""
        result = compile_source(self._scene, options, sink, memory=self._memory)
        if result is not None:
            self._plans.append((options, result.plan))
        return result

    def _unknown(self, result: CompileResult, open_params: set[str]) -> list[tuple[Severity, str, Location]]:
        """Returns messages about file names that the pack may lack. `open_params`: parameters not tried with all
        values.
        """
        known = {lookup.path for lookup in self._memory.lookups}
        scope = replace(result.scope, memory=PathCache())
        found: list[tuple[Severity, str, Location]] = []
        texts = [(one, path, text) for one in self._documents(result) for path, text in _texts(one.document.data, ())]
        words = [set(re.findall(r"\w+", " ".join(_EXPRESSION.findall(text)))) for _, _, text in texts]
        if not open_params and not any("num_scenes" in one or "scene" in one for one in words):
            return []
        for (document, path, text), names in zip(texts, words, strict=True):
            place = document.document.locate(Origin(document.name, path), "value")
            is_top = document.document is result.document
            if names and (_is_file_key(path) or _SUFFIX.search(_EXPRESSION.sub("", text))):
                if not is_top or names & {*open_params, "scene", "num_scenes"}:
                    found.append(("warning", f"other values may name files that the pack lacks: `{text}`", place))
            elif not names and _PATH.fullmatch(text):
                file = resolve_path(document.reference(text), base=document.folder, scope=scope)
                if isinstance(file, ResolvedFile) and file.path not in known:
                    found.append(("note", f"`{text}` is not in the pack: it is used only under a condition", place))
        return found

    def _documents(self, result: CompileResult) -> Iterator[SceneDocument]:
        """Yields the scene's own file, and those that it includes and uses, read again."""
        top: Document = result.document  # pyright: ignore[reportAssignmentType] - it has one
        yield SceneDocument(top, top.path.parent, None, "")  # pyright: ignore[reportOptionalMemberAccess]
        for path, naming in self._memory.named.items():
            if naming.role in {"include", "prefab"} and not naming.uri.startswith("scenecc:"):
                document = read_text(path.read_bytes(), naming.uri, Sink(), self._options.limits, path)
                tree = naming.uri.rpartition("/")[0] if naming.uri.startswith(("pkg://", "asset://")) else None
                if document is not None:
                    yield SceneDocument(document, path.parent, tree, "")

    def _archive(self, result: CompileResult, entry: Path) -> tuple[bytes, Manifest] | None:
        """Reads all files and lays them out."""
        absolute = next((one.written for one in self._memory.lookups if _is_absolute(one, self._memory)), None)
        if absolute is not None:
            hint = "use a path relative to the file that names it, or asset://"
            return self._refuse(f"a pack cannot hold files named by an absolute path:  `{absolute}`", hint)
        layout = _Layout(entry, self._memory, result.scope.asset_roots)
        files: dict[str, bytes] = {}
        left = MAX_PACK_BYTES
        for member, path in layout.files.items():
            if member.startswith(OWN_FOLDER) and path.is_relative_to(entry.parent / OWN_FOLDER):
                return self._refuse(f"a folder `{OWN_FOLDER}` beside a scene cannot be packed", "rename it")
            try:
                files[member] = read_at_most(path, left)
            except TooLongError:
                return self._refuse(f"the files take more than {MAX_PACK_BYTES} bytes", "leave out large meshes")
            left -= len(files[member])
        try:
            return pack_bytes(
                layout.member(entry, None),
                files,
                asset_roots=layout.asset_roots,
                packages=layout.packages,
                folders=layout.folders,
            )
        except InvalidPackError as error:
            return self._refuse(f"the scene cannot be packed: {error.message}", error.hint)

    def _is_enough(self, content: bytes) -> bool:
        """Returns whether the pack gives the same plans as the scene; reports if not."""
        with temporary_folder() as folder:
            file = Path(folder, f"{self._scene.stem}{PACK_SUFFIX}")
            file.write_bytes(content)
            for options, plan in self._plans:
                sink = Sink()
                packed = compile_source(file, options, sink)
                error = next((one.message for one in sink.diagnostics() if one.severity == "error"), None)
                if packed is not None:
                    differences = diff_plans(_without_uris(plan), _without_uris(packed.plan))
                    error = None if not differences else f"{differences[0].name} {differences[0].path} differs"
                if error is not None:
                    hint = "use only paths inside the scene's folder, pkg:// or asset://"
                    self._refuse(f"the scene in the pack would not be the same: {error}", hint)
                    return False
        return True


def _without_uris(plan: ScenePlan) -> ScenePlan:
    """Returns a plan with file names without folders, because an absolute path differs in the pack."""
    return replace(plan, files=tuple(replace(file, uri=Path(file.uri).name) for file in plan.files))


def _is_absolute(lookup: Lookup, memory: PathCache) -> bool:
    return lookup.written.startswith("/") and any(uri == lookup.written for uri, _ in memory.found)


def _texts(node: Any, path: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    """Yields the texts of a document that may name files, with their paths in it."""
    if isinstance(node, str):
        yield path, node
    elif is_mapping(node):
        for key, item in node.items():
            if key not in _PROSE_KEYS and not key.startswith("x-"):
                yield from _texts(item, (*path, key))
    elif is_sequence(node):
        for index, item in enumerate(node):
            yield from _texts(item, (*path, index))


def _is_file_key(path: KeyPath) -> bool:
    """Returns whether a text names a file, by its key or that of the form or list around it."""
    return any(isinstance(key, str) and (key in _FILE_KEYS or key.endswith("_texture")) for key in path[-3:])


def _choices(row: ParamRow) -> tuple[Any, ...]:
    """Returns all values of a parameter; empty if they cannot be listed."""
    return row.options or ((False, True) if row.type == "boolean" else ())


def _variants(rows: list[ParamRow], options: Options) -> tuple[list[Options], bool]:
    """Returns options with other values of the parameters, and whether these are all."""
    lists = {row.name: _choices(row) for row in rows if _choices(row) and row.name not in options.params}
    values: list[dict[str, Any]] = [] if not options.params else [{}]
    are_all = prod(map(len, lists.values())) <= _MOST_VARIANTS
    if are_all:
        values += [{**options.params, **dict(zip(lists, row, strict=True))} for row in product(*lists.values())]
    else:
        each = [{**options.params, name: value} for name, row in lists.items() for value in row]
        values += each[:_MOST_VARIANTS]
    are_all = are_all and not any(_choices(row) for row in rows if row.name in options.params)
    return [replace(options, params=params) for params in values], are_all


class _Layout:
    """Decides the place of each file in the pack: files of the scene's folder keep theirs, others go below
    `OWN_FOLDER`.

    Args:
        entry: the scene file.
        memory: what was looked up.
        roots: the asset roots.

    Attributes:
        files: source path of each file, by its path in the pack.
        folders: folders that the scene names themselves.
        asset_roots: the used asset roots, in order.
        packages: folders of the packages that were found, by name.
    """

    def __init__(self, entry: Path, memory: PathCache, roots: tuple[Path, ...]) -> None:
        lookups = [Lookup("", entry, Path(os.path.realpath(entry.parent)) / entry.name, None), *memory.lookups]
        lookups += list(_through_links(lookups))
        shared = {one.path for one in lookups if one.package is None}
        real = {root: Path(os.path.realpath(root)) for root in roots}
        used = {root: path for root, path in real.items() if any(one.is_relative_to(path) for one in shared)}
        top = _top_folder(Path(os.path.realpath(entry.parent)), shared, {*used.values()})
        # The longest folder that contains a file decides its place.
        self._places = {top: "", entry.parent: _join_inside("", Path(os.path.realpath(entry.parent)), top)}
        for path in sorted({*used.values()}, key=lambda path: len(path.parts)):
            if not path.is_relative_to(top):
                number = [*used.values()].index(path)
                above = next((one for one in self._places if path.is_relative_to(one)), None)
                self._places[path] = f"{OWN_FOLDER}/roots/{number}" if above is None else self.member(path, None)
        for root, path in used.items():
            self._places.setdefault(root.absolute(), self.member(path, None))
        self._packages = {folder: name for name, folder in memory.package_folders().items()}
        self.asset_roots = [self.member(path, None) for path in used.values()]
        # Recorded even without a file: the edition of a prefab depends on whether the package exists.
        self.packages = {name: f"{OWN_FOLDER}/packages/{name}" for name in self._packages.values()}
        self.folders: list[str] = []
        self.files: dict[str, Path] = {}
        for one in lookups:
            for path in (Path(os.path.normpath(one.joined)), one.path):
                self._add(path, one)

    def _add(self, path: Path, one: Lookup) -> None:
        member = self.member(path, one.package)
        if one.path.is_dir():
            self.folders += [member] if member and member not in self.folders else []
        elif member:
            self.files.setdefault(member, one.path)

    def member(self, path: Path, package: Path | None) -> str:
        """Returns the path in the pack; "" if there is no place for it, or it is the pack's own folder."""
        if package is not None and path.is_relative_to(package):
            return _join_inside(self.packages[self._packages[package]], path, package)
        above = [folder for folder in self._places if path.is_relative_to(folder)]
        if not above:
            return ""
        folder = max(above, key=lambda folder: len(folder.parts))
        return _join_inside(self._places[folder], path, folder)


def _join_inside(prefix: str, path: Path, folder: Path) -> str:
    inner = path.relative_to(folder).as_posix()
    return "/".join(part for part in (prefix, inner) if part not in {"", "."})


def _top_folder(top: Path, files: set[Path], roots: set[Path]) -> Path:
    """Returns the pack's top folder: the scene's, or the nearest parent that contains all files it names."""
    outside = {one for one in files if not one.is_relative_to(top)}
    for root in sorted(roots, key=lambda path: len(path.parts)):
        if top.is_relative_to(root) and any(one.is_relative_to(root) for one in outside):
            top = root
            break
    far = [one for one in outside if not any(one.is_relative_to(root) for root in (top, *roots))]
    return Path(os.path.commonpath([top, *(one.parent for one in far)]))


def _through_links(lookups: list[Lookup]) -> Iterator[Lookup]:
    """Yields the files below linked folders under the paths through the links, because a pack has no links."""
    links: dict[tuple[Path, Path], None] = {}
    for one in lookups:
        link, folder = Path(os.path.normpath(one.joined)), one.path
        while link.name == folder.name and link != folder and link.name:
            link, folder = link.parent, folder.parent
        if link != folder:
            links[link, folder] = None
    for link, folder in links:
        for one in lookups:
            if one.package is None and one.path.is_relative_to(folder):
                yield Lookup(one.written, link / one.path.relative_to(folder), one.path, None)
