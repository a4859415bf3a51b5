"""`patch_scene`: structured edits of a scene file, written only if the scene has no new error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typing_extensions import Unpack

from scenecc.diagnostics import Sink
from scenecc.diagnostics.diagnostic import Location, Origin
from scenecc.diagnostics.fixing import has_new_errors
from scenecc.errors import SceneError
from scenecc.files import replace_unchanged
from scenecc.options import CompileOptions, Options, check_types, path_argument
from scenecc.pipeline import compile_source
from scenecc.scene_file.json_patch import PatchError, patch_text
from scenecc.source import read_text
from scenecc.source.edits import text_diff
from scenecc.source.text import encoded_as, read_bytes

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.source import Document


@dataclass(frozen=True)
class Patched:
    """The result of a patch.

    Attributes:
        text: the text of the file with the patch, without a byte order mark.
        diff: the change in the format of `diff -u`; "" if nothing changes.
        written: whether the file was written.
        refused: whether it was not written because of new errors.
        diagnostics: diagnostics of the scene with the patch, as from `validate`.
    """

    text: str
    diff: str
    written: bool
    refused: bool
    diagnostics: list[Diagnostic]


def patch_scene(
    path: str | PathLike[str],
    operations: Sequence[Any],
    *,
    dry_run: bool = False,
    allow_errors: bool = False,
    **options: Unpack[CompileOptions],
) -> Patched:
    """Applies a JSON Patch (RFC 6902) to a scene file as written, and keeps comments and everything else in it.

    The operations apply in order, all or none. The result is compiled as by `validate` before it is written. Errors of
    stages that old errors had kept from running do not count as new.

    Args:
        path: a YAML scene file.
        operations: mappings with `op` (add, remove, replace, move, copy, test), `path`, and `value` or `from`. Paths
            are JSON Pointers such as `/entities/cube/pose/0`.
        dry_run: do not write the file.
        allow_errors: write the file also if it has new errors, for a scene that takes several patches.
        options: fields of `CompileOptions` for the compilation.

    Raises:
        SceneError: the file cannot be read, the patch cannot be applied (SC941), or the result has new errors and
            neither `dry_run` nor `allow_errors` is set. The file is unchanged.
        OSError: the file cannot be written, or changed meanwhile.
        ValueError: an option is out of range.
        TypeError: an argument has the wrong type.
    """
    asked = Options.of_call(patch_scene, options)
    given = {"operations": operations, "dry_run": dry_run, "allow_errors": allow_errors}
    check_types(patch_scene, given, {"operations": Sequence[Any], "dry_run": bool, "allow_errors": bool})
    path_argument(patch_scene, "path", path)
    made = patch_file(fspath(path), operations, asked, dry_run=dry_run, allow_errors=allow_errors)
    if made.refused and not dry_run:
        raise SceneError(made.diagnostics)
    return made


def patch_file(name: str, operations: Sequence[Any], options: Options, *, dry_run: bool, allow_errors: bool) -> Patched:
    """Returns the result of `patch_scene`, also if new errors prevent writing. Raises the same errors otherwise."""
    content, document = _read(name, options)
    before = document.text or ""
    try:
        text = patch_text(before, operations, options.limits)
    except PatchError as error:
        sink = Sink()
        place = document.locate(Origin(name, error.path), "key") if error.path else Location(name)
        sink.report("SC941", str(error), place, path=error.path, hint=error.hint)
        raise SceneError(sink.diagnostics()) from None
    found = _compile(text, name, options)
    has_errors = any(one.severity == "error" for one in found)
    refused = has_errors and not allow_errors and has_new_errors(found, _compile(before, name, options))
    written = not (refused or dry_run or text == before)
    if written:
        replace_unchanged(name, content, encoded_as(content, text))
    return Patched(text, text_diff(before, text, name), written, refused, found)


def _read(name: str, options: Options) -> tuple[bytes, Document]:
    """Returns the content of a scene file, and its document. Raises SceneError."""
    sink = Sink()
    content = read_bytes(name, sink, options.limits)
    document = None if content is None else read_text(content, name, sink, options.limits)
    if content is None or document is None:
        raise SceneError(sink.diagnostics())
    return content, document


def _compile(text: str, name: str, options: Options) -> list[Diagnostic]:
    """Returns the diagnostics of a text in place of a file, so that relative paths work."""
    sink = Sink()
    document = read_text(text, name, sink, options.limits, path=Path(name).absolute())
    if document is not None:
        compile_source(document, options, sink, placed=False)
    return sink.diagnostics()
