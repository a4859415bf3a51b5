"""Files that a scene refers to: syntax of their names, lookup, and permission to read them.

A scene file may come from a stranger. It sees the folder tree of the top scene file, the asset roots and what
`pkg://` names, and nothing else: it does not learn whether a file outside exists.
"""

from __future__ import annotations

import difflib
import errno
import importlib.util
import os
import re
import stat
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from scenecc.diagnostics.messages import keyboard_hint
from scenecc.files import State, state_now

if TYPE_CHECKING:
    from scenecc.source.document import Document

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*)://")


class Refusal(NamedTuple):
    """Why a file cannot be used: a code of band 4, a message and what to do."""

    code: str
    message: str
    hint: str | None = None


def check_uri(uri: str) -> Refusal | None:
    """Why a text can name no file here, whatever its scheme."""
    if not uri.strip():
        return Refusal("SC403", "the path is empty", "name a file")
    if any(ord(c) < 32 or c == "\x7f" for c in uri):
        return Refusal("SC403", f"the path {shorten_uri(uri)!r} holds a control character", "write `/` between folders")
    try:
        os.fsencode(uri)
    except UnicodeEncodeError:
        return Refusal("SC403", f"the path {shorten_uri(uri)!r} cannot be a file name")
    if "\\" in uri:
        return Refusal("SC403", f"the path `{shorten_uri(uri)}` holds a backslash", "write `/` between folders")
    if uri.startswith("~"):
        return Refusal(
            "SC403",
            f"`~` is not expanded in `{shorten_uri(uri)}`",
            "write a path relative to the scene, or use asset://",
        )
    return None


def check_scheme(uri: str, known: tuple[str, ...]) -> Refusal | None:
    """Why a uri's scheme is not read. `known`: those that are."""
    match = _SCHEME.match(uri)
    if match is None or match[1] in known:
        return None
    hints = {
        "http": "download the file and name it by its path",
        "https": "download the file and name it by its path",
        "file": "write the path alone, without file://",
        "package": "write asset://PATH with --asset-root, or pkg://PACKAGE/PATH of a Python package",
        "model": "write asset://PATH and give the model folder with --asset-root",
    }
    fallback = (
        "name a path relative to the scene, pkg://PACKAGE/PATH or asset://PATH" if known else "name a relative path"
    )
    hint = hints.get(match[1].lower(), fallback) if known else fallback
    if match[1].lower() in known:
        hint = f"write {match[1].lower()}://"
    return Refusal("SC403", f"`{match[1]}://` is not read, in `{shorten_uri(uri)}`", hint)


def check_inner_path(uri: str, inner: str) -> Refusal | None:
    """Why what follows a package or `asset://` names no file."""
    if not inner or inner.startswith("/"):
        return Refusal("SC403", f"`{shorten_uri(uri)}` names no file", "write pkg://PACKAGE/PATH or asset://PATH")
    return None


def shorten_uri(uri: str) -> str:
    """A uri as a message has it: of a long one the ends."""
    return uri if len(uri) <= 200 else uri[:120] + "…" + uri[-60:]


_MAX_LISTED_NAMES = 1000

_MAX_GUESSES = 20


class _FolderListing(NamedTuple):
    names: tuple[str, ...]
    by_lower: dict[str, str]
    by_stem: dict[str, str]


class NameSuggestions:
    """Suggestions for missing files. Lists each folder once, so it is for one compilation."""

    def __init__(self) -> None:
        self._listings: dict[Path, _FolderListing] = {}
        self._guesses_left = _MAX_GUESSES

    def hint(self, path: Path, written: str) -> str | None:
        """What to say about a missing file.

        Args:
            path: absolute, without links and `..`.
            written: how it is named, which the suggestion keeps but for the part that is missing.
        """
        folder = next((parent for parent in path.parents if parent.is_dir()), Path(path.anchor))
        missing, *rest = path.relative_to(folder).parts
        guess = self._guess(missing, self._listing(folder))
        if guess is not None:
            parts = written.split("/")
            before = parts[: -len(rest) - 1] if parts[-len(rest) - 1 :] == [missing, *rest] else []
            return f"did you mean `{shorten_uri('/'.join([*before, guess, *rest]))}`?"
        return f"there is no folder {folder / missing}" if rest else None

    def _guess(self, missing: str, listing: _FolderListing) -> str | None:
        alike = listing.by_lower.get(missing.lower()) or listing.by_stem.get(Path(missing).stem.lower())
        # Comparing letters costs milliseconds in a full folder: ten thousand slips get no ten thousand guesses.
        if alike is not None or self._guesses_left <= 0 or len(missing) > 255:
            return alike
        self._guesses_left -= 1
        # By stems: `a.png` and `b.png` have four letters of five in common, and are two files.
        stem, suffix = Path(missing).stem.lower(), Path(missing).suffix.lower()
        close = difflib.get_close_matches(stem, listing.by_stem, n=1, cutoff=0.75)
        if not close:
            return None
        same = (name for name in listing.names if name.lower() == close[0] + suffix)
        return next(same, listing.by_stem[close[0]])

    def _listing(self, folder: Path) -> _FolderListing:
        if folder not in self._listings:
            try:
                with os.scandir(folder) as entries:
                    names = sorted((entry.name for entry in islice(entries, _MAX_LISTED_NAMES)), reverse=True)
            except OSError:
                names = []
            # Reversed: of several alike the first in the alphabet stays.
            self._listings[folder] = _FolderListing(
                tuple(names), {name.lower(): name for name in names}, {Path(name).stem.lower(): name for name in names}
            )
        return self._listings[folder]


ASSET_PATH_VARIABLE = "SCENECC_ASSET_PATH"
"""Environment variable with asset roots, separated by `os.pathsep`; they come after `--asset-root`."""

_PACK_HINT = "`scenecc pack` takes the files of other values with --set, and further files with --add"

_OUTSIDE_HINT = (
    "move the file beside the scene, give its folder with --asset-root, or allow it with --allow-outside-assets"
)


class ResolvedFile(NamedTuple):
    """A file that is there and may be read.

    Attributes:
        path: absolute; its folder holds no links, its name may be one (an OBJ's MTL is sought beside the link).
        uri: `pkg://…` or `asset://…` as written, else the path relative to the top scene's folder (posix),
            else an absolute path.
    """

    path: Path
    uri: str


class _Package(NamedTuple):
    folder: Path
    name: str


@dataclass(slots=True)
class FileReference:
    """By what a file is named.

    Attributes:
        uri: of the file, as `ResolvedFile` has it.
        by: the files that name it, as messages have them, in the order in which they did.
        role: "include" or "prefab" for a scene file; "" for any other, whose role follows from the plan.
        state: of the file when it was first named; None where it is gone.
    """

    uri: str
    by: dict[str, None] = field(default_factory=dict[str, None])
    role: str = ""
    state: State | None = None


class Lookup(NamedTuple):
    """A file, or a folder of ROS packages, that was found.

    Attributes:
        written: as the scene or asset names it.
        joined: the same as a path, with all its links and `..`.
        path: where it is, as of `ResolvedFile`.
        package: the folder of the package in which it was looked for, None outside of packages.
    """

    written: str
    joined: Path
    path: Path
    package: Path | None


class PathCache:
    """What one compilation has looked up already.

    Attributes:
        named: every file that is used, by its path.
        missing: where a file was looked for and is none.
        lookups: what was found, as it was looked for.
        texts: scene files that are read from here, by their paths, whatever the disk has: what an editor holds.
    """

    def __init__(self, texts: Mapping[Path, str] | None = None) -> None:
        self.texts: Mapping[Path, str] = texts or {}
        self.found: dict[tuple[str, str], ResolvedFile | Refusal] = {}
        self.named: dict[Path, FileReference] = {}
        self.missing: set[Path] = set()
        self.lookups: list[Lookup] = []
        self.packages: dict[str, _Package | Refusal] = {}
        self.trees: tuple[Path, ...] | None = None
        self.near = NameSuggestions()

    def package_folders(self) -> dict[str, Path]:
        """The folders of the Python packages that were found, by name."""
        return {name: one.folder for name, one in self.packages.items() if isinstance(one, _Package)}

    def files_by_name(self, top: Document) -> dict[str, Path]:
        """The files that were used, by the names that origins give them. `top`: the document that was compiled."""
        found = {reference.uri: path for path, reference in self.named.items()}
        if top.name is not None and top.path is not None:
            found[top.name] = top.path
        return found

    def note(self, file: ResolvedFile, by: str, role: str = "") -> None:
        """Remembers that a file is used, and what names it."""
        naming = self.named.get(file.path)
        if naming is None:
            naming = self.named[file.path] = FileReference(file.uri, state=state_now(file.path))
        naming.by[by] = None
        naming.role = naming.role or role


@dataclass(frozen=True, slots=True)
class AssetScope:
    """Which files one compilation may read. It remembers what it found: make a new one for the next.

    Attributes:
        root: folder of the top scene file; None (a dict or a stream) is the current folder.
        asset_roots: where `asset://` looks, in order; see `asset_roots`.
        allow_outside: whether paths may leave the trees.
        memory: what was looked up.
        packages: folders of the Python packages that a pack holds, by name; None: those that are installed are used.
    """

    root: Path | None = None
    asset_roots: tuple[Path, ...] = ()
    allow_outside: bool = False
    memory: PathCache = field(default_factory=PathCache, repr=False, compare=False)
    packages: Mapping[str, Path] | None = None


def asset_roots(
    given: Iterable[str | os.PathLike[str]], environment: Mapping[str, str] | None = None
) -> tuple[Path, ...]:
    """The asset roots: those given, then those of `SCENECC_ASSET_PATH`.

    `environment`: in place of `os.environ`.
    """
    variable = (os.environ if environment is None else environment).get(ASSET_PATH_VARIABLE, "")
    return (*map(Path, given), *(Path(item) for item in variable.split(os.pathsep) if item))


def resolve_path(uri: str, *, base: Path, scope: AssetScope) -> ResolvedFile | Refusal:
    """Finds the file that a scene names.

    Args:
        uri: as written: a path relative to `base`, an absolute path, `pkg://PACKAGE/PATH` or `asset://PATH`.
        base: folder of the file in which it is written.
        scope: what may be read.
    """
    key = (uri, str(base))
    found = scope.memory.found.get(key)
    if found is None:
        found = scope.memory.found[key] = _resolve_uncached(uri, _root_folder(scope) / base, scope)
    return found


def has_package(name: str, scope: AssetScope) -> bool:
    """Whether `pkg://NAME/…` names files here. The package is looked for as `resolve` does, and not imported."""
    return isinstance(_cached_package(f"pkg://{name}", scope), _Package)


def resolve_asset_reference(
    reference: str, *, owner: Path, owner_uri: str, scope: AssetScope
) -> ResolvedFile | Refusal:
    """Finds a file that an asset names (an MTL of an OBJ, a texture of a glTF).

    Only a path relative to the asset is taken: no scheme, nothing absolute. It may lie where the asset itself may,
    in the asset's package too.

    Args:
        reference: as written in the asset, percent escapes decoded.
        owner: path of the asset.
        owner_uri: its uri, as `ResolvedFile` has it.
        scope: what may be read.
    """
    refusal = check_uri(reference) or check_scheme(reference, ())
    if refusal is not None:
        return refusal
    if reference.startswith("/"):
        return Refusal(
            "SC402", f"the path `{shorten_uri(reference)}` is absolute", "an asset names its files relative to itself"
        )
    package = _cached_package(owner_uri, scope) if owner_uri.startswith("pkg://") else None
    extra = (package.folder,) if isinstance(package, _Package) else ()
    return _check_path(owner.parent / reference, None, reference, extra, scope)


def _resolve_uncached(uri: str, base: Path, scope: AssetScope) -> ResolvedFile | Refusal:
    refusal = check_uri(uri) or check_scheme(uri, ("pkg", "asset"))
    if refusal is not None:
        return refusal
    if uri.startswith("pkg://"):
        package = _cached_package(uri, scope)
        if isinstance(package, Refusal):
            return package
        inner = uri[len("pkg://") + len(package.name) + 1 :]
        return check_inner_path(uri, inner) or _check_path(package.folder / inner, uri, uri, (package.folder,), scope)
    if uri.startswith("asset://"):
        return _resolve_in_roots(uri, scope)
    return _check_path(base / uri, None, uri, (), scope)


def _cached_package(uri: str, scope: AssetScope) -> _Package | Refusal:
    name = uri[len("pkg://") :].split("/", 1)[0]
    found = scope.memory.packages.get(name)
    if found is None:
        found = _find_package(name) if scope.packages is None else _find_packed(name, scope.packages)
        scope.memory.packages[name] = found
    return found


def _find_packed(name: str, packages: Mapping[str, Path]) -> _Package | Refusal:
    if name in packages:
        return _Package(_real_path(packages[name]), name)
    return Refusal("SC405", f"the pack holds no Python package `{shorten_uri(name)}`", _PACK_HINT)


def _find_package(name: str) -> _Package | Refusal:
    if "." in name and all(part.isidentifier() for part in name.split(".")):
        slashed = name.replace(".", "/")
        return Refusal(
            "SC405",
            f"`{name}` is not a top-level package",
            f"write pkg://{slashed}/… (a dotted name would be imported)",
        )
    if not name.isidentifier():
        return Refusal(
            "SC405", f"`{shorten_uri(name)}` is not the name of a Python package", "write pkg://PACKAGE/PATH"
        )
    try:
        # Of a name without dots this asks the finders and runs no code of the package.
        spec = importlib.util.find_spec(name)
    except (ValueError, ImportError) as error:
        return Refusal("SC405", f"the Python package `{name}` cannot be found: {error}")
    if spec is None:
        return Refusal(
            "SC405",
            f"there is no Python package `{name}` here",
            "install the package that holds the file into this Python, if you trust it",
        )
    if spec.origin is None or not spec.submodule_search_locations or not spec.has_location:
        # A folder without __init__.py is found wherever Python was started: `pkg://home/…` started in `/`.
        return Refusal("SC405", f"`{name}` is not a package with an __init__.py", "use asset:// and --asset-root")
    return _Package(_real_path(Path(spec.origin).parent), name)


def _resolve_in_roots(uri: str, scope: AssetScope) -> ResolvedFile | Refusal:
    inner = uri[len("asset://") :]
    refusal = check_inner_path(uri, inner)
    if refusal is not None:
        return refusal
    if not scope.asset_roots and scope.packages is not None:
        return Refusal("SC406", f"`{shorten_uri(uri)}` needs an asset root, and the pack has none", _PACK_HINT)
    if not scope.asset_roots:
        return Refusal(
            "SC406",
            f"`{shorten_uri(uri)}` needs an asset root, and none is given",
            f"give --asset-root FOLDER or set {ASSET_PATH_VARIABLE}",
        )
    refusals: list[Refusal] = []
    for folder in scope.asset_roots:
        found = _check_path(folder.absolute() / inner, uri, uri, (), scope)
        if isinstance(found, ResolvedFile) or found.code != "SC401":
            return found
        refusals.append(found)
    hint = next((refusal.hint for refusal in refusals if refusal.hint is not None), None)
    searched = ", ".join(map(str, scope.asset_roots))
    return Refusal("SC401", f"`{shorten_uri(uri)}` is in no asset root ({searched})", hint)


def _check_path(
    joined: Path, uri: str | None, written: str, extra: tuple[Path, ...], scope: AssetScope
) -> ResolvedFile | Refusal:
    """Checks a path that is spelled out. `uri`: the canonical one, None where it follows from the path."""
    try:
        real = _real_path(joined)
        if not scope.allow_outside and not any(
            real.is_relative_to(tree) for tree in (*_readable_folders(scope), *extra)
        ):
            places, hint = (
                ("folders that this scene may read", _OUTSIDE_HINT) if scope.packages is None else ("pack", None)
            )
            return Refusal("SC402", f"`{shorten_uri(written)}` leaves the {places}", hint)
        kept = real if joined.name == ".." else _real_path(joined.parent) / joined.name
        # As written: `nowhere/../mug.obj` is there in words alone, and SAPIEN would go and look elsewhere.
        status = joined.stat()
    except OSError as error:
        return _refuse_unreachable(error, joined, written, scope)
    scope.memory.lookups.append(Lookup(written, joined, kept, extra[0] if extra else None))
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "not a regular file"
        return Refusal("SC404", f"`{shorten_uri(written)}` is {kind}", "name a file")
    if written.endswith("/"):
        return Refusal("SC404", f"`{shorten_uri(written)}` ends in a slash", "name a file")
    if not os.access(kept, os.R_OK):
        return Refusal("SC407", f"`{shorten_uri(written)}` may not be read", "change the file's permissions")
    return ResolvedFile(kept, uri if uri is not None else _canonical_uri(kept, scope))


def _refuse_unreachable(error: OSError, joined: Path, written: str, scope: AssetScope) -> Refusal:
    if error.errno == errno.ELOOP:
        return Refusal("SC407", f"`{shorten_uri(written)}` is a link to itself", "fix the link")
    if error.errno in {errno.ENOENT, errno.ENOTDIR}:
        scope.memory.missing.add(_real_path(joined))
        hint = scope.memory.near.hint(_real_path(joined), written) if scope.packages is None else _PACK_HINT
        if written.startswith("$"):
            hint = "no variables are read: write a path relative to the scene, or use asset://"
        hint = keyboard_hint(written) or hint
        where = "" if scope.packages is None else " in the pack"
        return Refusal("SC401", f"there is no file `{shorten_uri(written)}`{where}", hint)
    if error.errno == errno.ENAMETOOLONG:
        return Refusal("SC401", f"there is no file `{shorten_uri(written)}`", "no file name is this long")
    return Refusal(
        "SC407", f"`{shorten_uri(written)}` may not be read: {error.strerror}", "change the file's permissions"
    )


def _canonical_uri(path: Path, scope: AssetScope) -> str:
    root = _readable_folders(scope)[0]
    return (path.relative_to(root) if path.is_relative_to(root) else path).as_posix()


def name_of_file(path: Path, scope: AssetScope) -> str:
    """A name of a file that does not depend on the machine; see `hash_files`. `path`: as of `ResolvedFile`."""
    for package in scope.memory.packages.values():
        if isinstance(package, _Package) and path.is_relative_to(package.folder):
            return f"pkg://{package.name}/{path.relative_to(package.folder).as_posix()}"
    root, *others = _readable_folders(scope)
    folder = None if path.is_relative_to(root) else next((one for one in others if path.is_relative_to(one)), None)
    if folder is None:
        return Path(os.path.relpath(path, root)).as_posix()
    return f"asset://{path.relative_to(folder).as_posix()}"


def _root_folder(scope: AssetScope) -> Path:
    return (scope.root if scope.root is not None else Path()).absolute()


def _readable_folders(scope: AssetScope) -> tuple[Path, ...]:
    """The folders that may be read, without links; the first is the top scene's."""
    if scope.memory.trees is None:
        scope.memory.trees = tuple(_real_path(folder) for folder in (_root_folder(scope), *scope.asset_roots))
    return scope.memory.trees


def _real_path(path: Path) -> Path:
    # Path.resolve raises RuntimeError for links in a circle up to Python 3.12; this leaves them to stat.
    return Path(os.path.realpath(path))
