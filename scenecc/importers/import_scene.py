"""Imports a file of another format as a scene file: reads, checks, writes, builds and compares it."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import MARKER, Location
from scenecc.diagnostics.messages import suggest
from scenecc.errors import SceneError
from scenecc.extras import install_hint
from scenecc.files import open_regular, replace_all, replace_set
from scenecc.importers import FORMATS, SourceFormat, suffix_of
from scenecc.importers.assets import IMPORTED_FROM, AssetNames, assets_of, check_output_files, map_assets, output_fault
from scenecc.importers.imported_scene import ALL_LOSSES, LOSSES, REPAIRED, Asset, ImportContext, ImportedScene, Loss
from scenecc.importers.prefabs import Prefabs, find_prefabs
from scenecc.interrupt import temporary_folder, undoing
from scenecc.options import Options, check_types, path_argument
from scenecc.pipeline import CompileResult, compile_or_raise
from scenecc.scene_file import is_list_node, is_mapping_node
from scenecc.scene_file.layout import Comments, scene_text
from scenecc.scene_file.simplify import simplify
from scenecc.source.paths import AssetScope

if TYPE_CHECKING:
    from os import PathLike

    from scenecc.importers import Reader
    from scenecc.importers.certificate import Certificate

_ROOT_ELEMENT: Final = re.compile(rb"<([A-Za-z_][\w.-]*)")
_COMMENT: Final = re.compile(rb"<!--.*?(?:-->|\Z)|<[?!][^>]*>", re.DOTALL)
_HEAD_BYTES: Final = 65536
_SHOWN_PLACES: Final = 5
_PACKAGE_LEVELS: Final = 6
_STEPS: Final = 4


@dataclass(frozen=True, slots=True)
class Imported:
    """An imported scene.

    Attributes:
        files: path relative to the output's folder → content; the scene file first.
        losses: content of the source that the scene does not have.
        diagnostics: warnings about the file and the scene.
        paths: paths of the written files.
        certificate: comparison of the built scene with the source's own engine.
    """

    files: Mapping[str, bytes] = field(repr=False)
    losses: tuple[Loss, ...]
    diagnostics: list[Diagnostic]
    paths: tuple[Path, ...]
    certificate: Certificate


def import_scene(
    file: str | PathLike[str],
    output: str | PathLike[str],
    *,
    allow: Iterable[str] = (),
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    keep_file: bool = False,
    limits: Mapping[str, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Imported:
    """Writes a scene file from a file of another format, builds it and compares it with the source.

    Args:
        file: an SDF world or model, a USD stage, an MJCF, a URDF, a `.dmd.yaml` of Drake or a layout of EmbodiedGen.
        output: the scene file. Files that it cannot reference by a relative path, `pkg://` or `asset://` are copied to
            the folder `NAME_assets` beside it.
        allow: losses that may change the dynamics; keys of `scenecc.importers.imported_scene.LOSSES`, or `all`.
        asset_roots: as for `validate`; the file and the scene may read them.
        allow_outside_assets: as for `validate`.
        keep_file: whether the scene names an MJCF, whose bodies and robots otherwise become entities.
        limits: as for `validate`.
        progress: called with (steps done, total steps): read, compile and write, build.

    Raises:
        SceneError: the file cannot be imported, or not without a loss that is not allowed. Nothing is written.
        OSError: the output cannot be written.
        TypeError: an argument has the wrong type.
        ValueError: unknown loss or limit, or the output's name cannot be part of a path in a scene file.
    """
    check_types(import_scene, {"allow": allow, "keep_file": keep_file, "progress": progress}, _TYPES)
    allowed = _allowed_losses({allow} if isinstance(allow, str) else {*allow})
    source, target = (path_argument(import_scene, key, path) for key, path in (("file", file), ("output", output)))
    options = Options.of(asset_roots=asset_roots, allow_outside_assets=allow_outside_assets, limits=limits)
    if (fault := output_fault(target)) is not None:
        raise ValueError(f"import_scene(): output: {fault}")
    sink, target = Sink(), target.absolute()
    scope = AssetScope(_root_of(source), options.asset_roots, options.allow_outside_assets)
    context = ImportContext(sink, scope, options.limits, allowed, keep_file)
    _report_progress(progress, 0)
    found = _read(source, context)
    _report_losses(() if found is None else found.losses, context)
    if found is None or sink.failed:
        raise SceneError(sink.diagnostics())
    _report_progress(progress, 1)
    compiled, silenced = _compile(found, source, context, options)
    _report_progress(progress, 2)
    names = AssetNames(target, scope, _companions(compiled), _folders_passed(compiled))
    files, prefabs = _encode_files(found, source, target, names, _silencing_comments(found, silenced))
    found = replace(found, bodies={prefabs.name(mine): own for mine, own in found.bodies.items()})
    stale = check_output_files(target, files)
    with _write_files(target, files) as paths:
        _report_progress(progress, 3)
        certificate = import_module("scenecc.importers.certificate").certificate_of(found, source, target, options)
    for path in stale:
        path.unlink(missing_ok=True)
    return Imported(files, found.losses, sink.diagnostics(), tuple(paths), certificate)


def _allowed_losses(allow: set[str]) -> frozenset[str]:
    """Returns the kinds of losses that a caller allows. Raises ValueError for one that does not exist."""
    unknown = next((kind for kind in allow if kind not in {*LOSSES, ALL_LOSSES}), None)
    if unknown is not None:
        raise ValueError(f"there is no loss `{unknown}`; {suggest(unknown, (ALL_LOSSES, *LOSSES))}")
    return frozenset(LOSSES if ALL_LOSSES in allow else allow)


def _report_progress(progress: Callable[[int, int], None] | None, done: int) -> None:
    if progress is not None:
        progress(done, _STEPS)


def _silencing_comments(found: ImportedScene, codes: Collection[str]) -> Comments:
    """Returns the comment at the scene's only robot file that silences what the import has listed as losses."""
    entities = found.document.get("entities", {})
    robots = [(name, key) for name, keys in entities.items() for key in ("mjcf", "urdf") if key in keys]
    if not codes or len(robots) != 1:
        return {}
    kinds = _allowed_kinds(found)
    allowed = f"; allowed: {', '.join(kinds)}" if kinds else ""
    return {("entities", *robots[0]): f"{MARKER} {', '.join(sorted(codes))} -- listed by the import{allowed}"}


def _allowed_kinds(found: ImportedScene) -> list[str]:
    """Returns the kinds of losses that `--allow` has accepted; others would have been errors."""
    return [*dict.fromkeys(loss.kind for loss in found.losses if LOSSES[loss.kind].changes_machine)]


def _encode_files(
    found: ImportedScene, source: Path, target: Path, names: AssetNames, comments: Comments
) -> tuple[dict[str, bytes], Prefabs]:
    """Returns the scene file, its prefabs and its assets, by paths relative to the scene's folder."""
    document = simplify(map_assets(found.document, lambda asset: _FILE_MARK + names.name(asset)))
    taken = (Path(path).stem for path in names.copies if path.endswith(".yaml"))
    prefabs = find_prefabs(document, taken, lambda name: f"{_FILE_MARK}{assets_of(target).name}/{name}.yaml")
    head = {(): f"{IMPORTED_FROM} {source.name} by scenecc."}
    kinds = _allowed_kinds(found)
    more = {(): f"{head[()]}\nNot as in the file, accepted by --allow: {', '.join(kinds)}."} if kinds else {}
    texts = {target.name: scene_text(_resolve_marks(prefabs.document, "."), comments={**head, **more, **comments})}
    for path, content in prefabs.files.items():
        name = path.removeprefix(_FILE_MARK)
        texts[name] = scene_text(_resolve_marks(content, str(Path(name).parent)), comments=head)
    return {**{path: text.encode("utf-8") for path, text in texts.items()}, **names.copies}, prefabs


_TYPES: Final[Mapping[str, Any]] = {
    "allow": Iterable[str],
    "keep_file": bool,
    "progress": Callable[[int, int], None] | None,
}

_FILE_MARK: Final = "\0"
"""Marks a path relative to the scene's folder, or a URI."""


def _resolve_marks(node: Any, folder: str) -> Any:
    """Returns the data with paths relative to a folder below the scene's."""
    if isinstance(node, str) and node.startswith(_FILE_MARK):
        path = node.removeprefix(_FILE_MARK)
        return path if "://" in path else Path(os.path.relpath(path, folder)).as_posix()
    if is_mapping_node(node):
        return {key: _resolve_marks(value, folder) for key, value in node.items()}
    return [_resolve_marks(item, folder) for item in node] if is_list_node(node) else node


@contextmanager
def _write_files(target: Path, files: Mapping[str, bytes]) -> Generator[list[Path]]:
    """Writes the files, and restores everything if the block fails or is interrupted."""
    targets = [target.parent / name for name in files]
    before = {path: path.read_bytes() for path in targets if path.is_file()}
    folders = {each for path in targets for each in path.parents if not each.exists()}
    paths = replace_set(target, files, folder=False)
    with undoing() as undo:
        undo.callback(_restore_files, targets, before, folders)
        yield paths
        undo.pop_all()


def _restore_files(paths: list[Path], before: Mapping[Path, bytes], folders: Collection[Path]) -> None:
    for path in paths:
        path.unlink(missing_ok=True)
    for folder in sorted(folders, reverse=True):
        folder.rmdir()
    if before:
        replace_all(before)


def _root_of(source: Path) -> Path:
    """Returns the folder that a file may read: its ROS or Python package's or its model's, else its own."""
    folder = source.absolute().parent
    for each in (folder, *folder.parents[:_PACKAGE_LEVELS]):
        if any((each / name).is_file() for name in ("package.xml", "model.config")):
            return each
        if (each / "__init__.py").is_file():
            # A subpackage may use the files of the whole package.
            return next(one for one in (each, *each.parents) if not (one.parent / "__init__.py").is_file())
    return folder


def _read(source: Path, context: ImportContext) -> ImportedScene | None:
    try:
        with open_regular(source) as stream:
            head = stream.read(_HEAD_BYTES)
            if not _root_element(head) and _may_be_xml(source):
                head += stream.read(context.limits.asset_bytes)
    except OSError as error:
        context.sink.report("SC430", f"the file cannot be read: {error.strerror or error}", Location(str(source)))
        return None
    chosen = _format_of(source, head, context.sink)
    if chosen is None:
        return None
    if chosen.module and not _is_installed(chosen, context.sink):
        return None
    module, _, name = chosen.reader.partition(":")
    reader: Reader = getattr(import_module(module), name)
    return reader(source, context)


def _format_of(source: Path, head: bytes, sink: Sink) -> SourceFormat | None:
    """Returns the format that matches a file's suffix and content; None after an error."""
    suffix, place = suffix_of(source), Location(str(source))
    takers = [one for one in FORMATS if suffix in one.suffixes]
    if not takers:
        known = ", ".join(dict.fromkeys(suffix for one in FORMATS for suffix in one.suffixes))
        message = f"no format has the suffix `{suffix}`" if suffix else "the file has no suffix"
        sink.report("SC430", message, place, hint=f"the suffixes are {known}")
        return None
    tag = _root_element(head)
    found = next((one for one in takers if not one.root or one.root == tag), None)
    if found is None:
        expected = " or ".join(f"<{one.root}> ({one.name})" for one in takers)
        seen = f"its root element is <{tag}>" if tag else "it has no XML element"
        sink.report("SC430", f"the content does not match the suffix: {seen}, not {expected}", place)
    return found


def is_source(file: Path) -> bool:
    """Returns whether a file can be imported, by its suffix, and for `.xml` and `.json` by its content.

    Raises:
        OSError: it cannot be read.
    """
    suffix = suffix_of(file)
    if suffix not in {".xml", ".json"}:
        return any(suffix in one.suffixes for one in FORMATS)
    with open_regular(file) as stream:
        head = stream.read(_HEAD_BYTES)
    if suffix == ".json":
        return file.name.lower().endswith("layout.json") and b'"relation"' in head
    return _root_element(head) in {one.root for one in FORMATS} - {""}


def _may_be_xml(source: Path) -> bool:
    return any(one.root and suffix_of(source) in one.suffixes for one in FORMATS)


def _root_element(head: bytes) -> str:
    """Returns the name of the root element; "" if none is found. Long comments may precede it."""
    root = _ROOT_ELEMENT.search(_COMMENT.sub(b"", head))
    return "" if root is None else root[1].decode("ascii", "replace")


def _is_installed(chosen: SourceFormat, sink: Sink) -> bool:
    try:
        import_module(chosen.module)
    except ImportError as error:
        message = f"{chosen.name} files need {chosen.module}: {error}"
        sink.report("SC813", message, Location(None), hint=install_hint("import"))
        return False
    return True


def _folders_passed(compiled: CompileResult) -> dict[Path, Path]:
    """Returns file → the highest folder in a reference to it: /a for `../b/mesh.obj` in /a/c."""
    found: dict[Path, Path] = {}
    for lookup in compiled.scope.memory.lookups:
        parts, top = list[str](), len(lookup.path.parts) - 1
        for part in lookup.joined.parts:
            if part == "..":
                parts.pop()
                top = min(top, len(parts))
            else:
                parts.append(part)
        highest = Path(*parts[:top])
        found[lookup.path] = min(highest, found.get(lookup.path, highest), key=lambda folder: len(folder.parts))
    return found


def _report_losses(losses: Sequence[Loss], context: ImportContext) -> None:
    """Reports one finding per kind; an error if the kind changes the dynamics and is not allowed."""
    counts = Counter(loss.kind for loss in losses)
    for kind, count in counts.items():
        row, first, *others = LOSSES[kind], *(loss for loss in losses if loss.kind == kind)
        refused = row.changes_machine and kind not in context.allow
        message = f"{row.what} ({count}): {first.message}" + (f", and {count - 1} more" if count > 1 else "")
        related = [(loss.message, loss.place, "value") for loss in others[:_SHOWN_PLACES]]
        context.sink.report(
            "SC431" if refused else "SC432",
            message,
            first.place,
            hint=f"allow it with --allow {kind}" if refused else None,
            related=related,  # pyright: ignore[reportArgumentType] - a literal
        )


def _compile(
    found: ImportedScene, source: Path, context: ImportContext, options: Options
) -> tuple[CompileResult, set[str]]:
    """Compiles the document before anything is written, with the original assets.

    Returns the result, and the codes of findings about robot files that the losses cover. Raises SceneError.
    """
    sink = Sink()
    with temporary_folder() as folder:

        def name(asset: Asset) -> str:
            if isinstance(asset.source, Path):
                return str(asset.source)
            path = Path(folder, f"{len(made)}_{asset.name.replace('/', '_')}")
            if asset not in made:
                path.write_bytes(asset.source)
                made[asset] = str(path)
            return made[asset]

        made: dict[Asset, str] = {}
        # Uses absolute paths, restricted to what the reader may read: this also reads the files that assets name.
        root = context.scope.root or Path.cwd()
        inside = replace(options, asset_roots=(*options.asset_roots, root, Path(folder)))
        try:
            compiled = compile_or_raise(map_assets(found.document, name), inside, sink)
        except SceneError as error:
            moved = [_move_to_source(each, found, source) for each in error.diagnostics]
            raise SceneError([*context.sink.diagnostics(), *moved]) from None
    reported = sink.diagnostics()
    placed = [_move_to_source(each, found, source) for each in reported if each.code not in found.codes_of_losses]
    listed = {loss.message for loss in found.losses}
    repairs = [each for each in placed if each.code == REPAIRED and each.message not in listed]
    _report_losses([Loss("missing-files", each.message, each.location) for each in repairs], context)
    for each in placed:
        if each.code != REPAIRED:
            context.sink.report(each.code, each.message, each.location, hint=each.hint)
    covered = {*found.codes_of_losses, REPAIRED}
    return compiled, {one.code for one in reported if one.code in covered and one.file is not None}


def _move_to_source(finding: Diagnostic, found: ImportedScene, source: Path) -> Diagnostic:
    """Moves a finding about the scene to the place in the imported file that caused it."""
    if finding.location.file is not None:
        return replace(finding, related=())
    section, _, rest = finding.path.partition(".")
    names = [name for name in found.places if section == "entities" and f"{rest}.".startswith(f"{name}.")]
    place = found.places[max(names, key=len)] if names else Location(str(source))
    return replace(finding, location=place, related=())


def _companions(compiled: CompileResult) -> dict[Path, tuple[Path, ...]]:
    """Returns file → all files that it refers to, directly or indirectly, as found by the compilation."""
    named = compiled.scope.memory.named
    by: dict[str, list[Path]] = {}
    for path, reference in named.items():
        for owner in reference.by:
            by.setdefault(owner, []).append(path)
    found: dict[Path, tuple[Path, ...]] = {}
    for path, reference in named.items():
        todo, seen = [reference.uri], dict[Path, None]()
        while todo:
            for each in by.get(todo.pop(), ()):
                if each not in seen and each != path:
                    seen[each] = None
                    todo.append(named[each].uri)
        found[path] = tuple(seen)
    return found
