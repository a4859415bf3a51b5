"""Files that a scene references: syntax of their names, lookup, and permission to read them.

A scene file is untrusted. It can read the folder tree of the top scene file, the asset roots and `pkg://` packages. It
cannot find out whether any other file exists.
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

from scenecc.diagnostics.messages import keyboard_hint, nearest
from scenecc.extras import ROBOTS_HINT, robot_hint
from scenecc.files import State, state_now

if TYPE_CHECKING:
    from scenecc.source.document import Document

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*)://")


class Refusal(NamedTuple):
    """Why a file cannot be used: a code of band 4, a message and a hint."""

    code: str
    message: str
    hint: str | None = None


def check_uri(uri: str) -> Refusal | None:
    """Returns why a text cannot name a file, whatever its scheme; None if it can."""
    if not uri.strip():
        return Refusal("SC403", "the path is empty", "name a file")
    if any(ord(c) < 32 or c == "\x7f" for c in uri):
        return Refusal("SC403", f"{shorten_uri(uri)!r} contains a control character", "write `/` between folders")
    try:
        os.fsencode(uri)
    except UnicodeEncodeError:
        return Refusal("SC403", f"the path {shorten_uri(uri)!r} cannot be a file name")
    if "\\" in uri:
        return Refusal(
            "SC403",
            f"the path `{shorten_uri(uri)}` contains a backslash",
            f"write `{shorten_uri(uri).replace(chr(92), '/')}`",
        )
    if uri.startswith("~"):
        return Refusal(
            "SC403",
            f"`~` is not expanded in `{shorten_uri(uri)}`",
            _portable(uri),
        )
    return None


def _portable(uri: str) -> str:
    """Returns a hint for a path that holds only on one machine."""
    folder, _, name = shorten_uri(uri).rpartition("/")
    return f"copy the file beside the scene and write `{name}`, or write `asset://{name}` with `--asset-root {folder}`"


def check_scheme(uri: str, known: tuple[str, ...]) -> Refusal | None:
    """Returns why a URI's scheme is not supported; None if it is. `known`: the supported schemes."""
    match = _SCHEME.match(uri)
    if match is None or match[1] in known:
        return None
    path = shorten_uri(uri[match.end() :]).lstrip("/")
    hints = {
        "http": "download the file and use its path",
        "https": "download the file and use its path",
        "file": f"write `{path}`",
        "package": f"write `asset://{path}` and give the folder of the packages with --asset-root, or `pkg://{path}`",
        "model": f"write `asset://{path}` and give the model folder with --asset-root",
    }
    fallback = (
        "name a path relative to the scene, pkg://PACKAGE/PATH or asset://PATH" if known else "name a relative path"
    )
    hint = hints.get(match[1].lower(), fallback) if known else fallback
    if match[1].lower() in known:
        hint = f"write {match[1].lower()}://"
    return Refusal("SC403", f"`{match[1]}://` is not supported, in `{shorten_uri(uri)}`", hint)


def check_inner_path(uri: str, inner: str) -> Refusal | None:
    """Returns why the path after a package or `asset://` names no file; None if it is valid."""
    if not inner or inner.startswith("/"):
        return Refusal("SC403", f"`{shorten_uri(uri)}` names no file", "write pkg://PACKAGE/PATH or asset://PATH")
    return None


def shorten_uri(uri: str) -> str:
    """Returns a URI for messages: only the ends of a long one."""
    return uri if len(uri) <= 200 else uri[:120] + "…" + uri[-60:]


_MAX_LISTED_NAMES = 1000

_MAX_GUESSES = 20

_ROBOTS = frozenset((".urdf", ".xml", ".mjcf", ".xacro", ".srdf", ".sdf"))


def _is_robot(name: str) -> bool:
    return Path(name).suffix.lower() in _ROBOTS


class _FolderListing(NamedTuple):
    names: tuple[str, ...]
    by_lower: dict[str, str]
    by_stem: dict[str, str]


class NameSuggestions:
    """Suggestions for missing files. Lists each folder once, so it is valid for one compilation."""

    def __init__(self) -> None:
        self._listings: dict[Path, _FolderListing] = {}
        self._guesses_left = _MAX_GUESSES

    def hint(self, path: Path, written: str) -> str | None:
        """Returns a hint for a missing file.

        Args:
            path: absolute, without links and `..`.
            written: the name as written; the suggestion replaces only its missing part.
        """
        folder = next((parent for parent in path.parents if parent.is_dir()), Path(path.anchor))
        missing, *rest = path.relative_to(folder).parts
        guess = self._guess(missing, self._listing(folder))
        if guess is None and not rest and self._guesses_left > 0:
            inside = (f"{name}/{missing}" for name in reversed(self._listing(folder).names) if "." not in name)
            guess = next((one for one in inside if (folder / one).is_file()), None)
        if guess is not None and (not rest or (folder / guess).is_dir()):
            parts = written.split("/")
            before = parts[: -len(rest) - 1] if parts[-len(rest) - 1 :] == [missing, *rest] else []
            return f"did you mean `{shorten_uri('/'.join([*before, guess, *rest]))}`?"
        return f"there is no folder {folder / missing}" if rest else None

    def _guess(self, missing: str, listing: _FolderListing) -> str | None:
        stem, suffix = Path(missing).stem.lower(), Path(missing).suffix.lower()
        alike = listing.by_lower.get(missing.lower())
        if alike is None and stem in listing.by_stem:
            same = [name for name in listing.names if Path(name).stem.lower() == stem]
            # A mesh cannot replace a robot.
            kinds = {Path(name).suffix.lower(): name for name in same if suffix not in _ROBOTS or _is_robot(name)}
            near = difflib.get_close_matches(suffix, kinds, n=1, cutoff=0)
            return kinds[near[0]] if near else None
        # Comparing names takes milliseconds in a full folder, so the number of guesses is limited.
        if alike is not None or self._guesses_left <= 0 or len(missing) > 255:
            return alike
        self._guesses_left -= 1
        # Compare stems: `a.png` and `b.png` differ in one letter of five, but are different files.
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
            # Reversed, so that the alphabetically first of equal matches stays.
            self._listings[folder] = _FolderListing(
                tuple(names), {name.lower(): name for name in names}, {Path(name).stem.lower(): name for name in names}
            )
        return self._listings[folder]


ASSET_PATH_VARIABLE = "SCENECC_ASSET_PATH"
"""Environment variable with asset roots, separated by `os.pathsep`; they follow those of `--asset-root`."""

_PACK_HINT = "`scenecc pack` adds the files of other values with --set, and further files with --add"


class ResolvedFile(NamedTuple):
    """A file that exists and may be read.

    Attributes:
        path: absolute; its folder has no links, but its name may be one (an OBJ's MTL is beside the link).
        uri: `pkg://…` or `asset://…` as written, else the path relative to the top scene's folder (posix), else an
            absolute path.
    """

    path: Path
    uri: str


class _Package(NamedTuple):
    folder: Path
    name: str


@dataclass(slots=True)
class FileReference:
    """The references to a file.

    Attributes:
        uri: URI of the file, as in `ResolvedFile`.
        by: the referencing files, by their names in messages, in order.
        role: "include" or "prefab" for a scene file; "" for any other file, whose role follows from the plan.
        state: state of the file at its first reference; None if it is missing.
    """

    uri: str
    by: dict[str, None] = field(default_factory=dict[str, None])
    role: str = ""
    state: State | None = None


class Lookup(NamedTuple):
    """A file, or a folder of ROS packages, that was found.

    Attributes:
        written: the name in the scene or asset.
        joined: the same as a path, with all its links and `..`.
        path: as in `ResolvedFile`.
        package: folder of the package that was searched; None outside packages.
    """

    written: str
    joined: Path
    path: Path
    package: Path | None


class PathCache:
    """Everything that one compilation has looked up.

    Attributes:
        named: all used files, by path.
        missing: paths that were searched but are not files.
        lookups: found files, in order.
        texts: texts of scene files by path, which replace those on the disk: an editor's texts.
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
        """Returns the folders of the Python packages that were found, by name."""
        return {name: one.folder for name, one in self.packages.items() if isinstance(one, _Package)}

    def files_by_name(self, top: Document) -> dict[str, Path]:
        """Returns the used files by their names in origins. `top`: the compiled document."""
        found = {reference.uri: path for path, reference in self.named.items()}
        if top.name is not None and top.path is not None:
            found[top.name] = top.path
        return found

    def note(self, file: ResolvedFile, by: str, role: str = "") -> None:
        """Records that a file is used, and what references it."""
        naming = self.named.get(file.path)
        if naming is None:
            naming = self.named[file.path] = FileReference(file.uri, state=state_now(file.path))
        naming.by[by] = None
        naming.role = naming.role or role


@dataclass(frozen=True, slots=True)
class AssetScope:
    """The files that one compilation may read. It caches what it finds, so each compilation needs a new one.

    Attributes:
        root: folder of the top scene file; None (a dict or a stream): the current folder.
        asset_roots: folders to search for `asset://` paths, in order; see `asset_roots`.
        allow_outside: whether paths may leave these folders.
        memory: what was looked up.
        packages: folders of the Python packages in a pack, by name; None: installed packages are used.
    """

    root: Path | None = None
    asset_roots: tuple[Path, ...] = ()
    allow_outside: bool = False
    memory: PathCache = field(default_factory=PathCache, repr=False, compare=False)
    packages: Mapping[str, Path] | None = None


def asset_roots(
    given: Iterable[str | os.PathLike[str]], environment: Mapping[str, str] | None = None
) -> tuple[Path, ...]:
    """Returns the asset roots: the given ones, then those of `SCENECC_ASSET_PATH`.

    `environment`: replaces `os.environ`.
    """
    variable = (os.environ if environment is None else environment).get(ASSET_PATH_VARIABLE, "")
    return (*map(Path, given), *(Path(item) for item in variable.split(os.pathsep) if item))


def resolve_path(uri: str, *, base: Path, scope: AssetScope) -> ResolvedFile | Refusal:
    """Finds the file that a scene names.

    Args:
        uri: as written: a path relative to `base`, an absolute path, `pkg://PACKAGE/PATH` or `asset://PATH`.
        base: folder of the file that contains it.
        scope: what may be read.
    """
    key = (uri, str(base))
    found = scope.memory.found.get(key)
    if found is None:
        found = scope.memory.found[key] = _resolve_uncached(uri, _root_folder(scope) / base, scope)
    return found


def has_package(name: str, scope: AssetScope) -> bool:
    """Returns whether the package of `pkg://NAME/…` exists. It is found as in `resolve_path`, and not imported."""
    return isinstance(_look_up_package(f"pkg://{name}", scope), _Package)


def resolve_asset_reference(
    reference: str, *, owner: Path, owner_uri: str, scope: AssetScope
) -> ResolvedFile | Refusal:
    """Finds a file that an asset names (an MTL of an OBJ, a texture of a glTF).

    Only paths relative to the asset are allowed, without a scheme. The file must be where assets of the scene are
    allowed, or in the asset's package.

    Args:
        reference: as written in the asset, with percent escapes decoded.
        owner: path of the asset.
        owner_uri: its URI, as in `ResolvedFile`.
        scope: what may be read.
    """
    refusal = check_uri(reference) or check_scheme(reference, ())
    if refusal is not None:
        return refusal
    if reference.startswith("/"):
        return Refusal("SC402", f"the path `{shorten_uri(reference)}` is absolute", "use a path relative to the asset")
    package = _look_up_package(owner_uri, scope) if owner_uri.startswith("pkg://") else None
    extra = (package.folder,) if isinstance(package, _Package) else ()
    return _check_path(owner.parent / reference, None, reference, extra, scope)


def _resolve_uncached(uri: str, base: Path, scope: AssetScope) -> ResolvedFile | Refusal:
    refusal = check_uri(uri) or check_scheme(uri, ("pkg", "asset"))
    if refusal is not None:
        return refusal
    if uri.startswith("pkg://"):
        package = _look_up_package(uri, scope)
        if isinstance(package, Refusal):
            return package
        inner = uri[len("pkg://") + len(package.name) + 1 :]
        return check_inner_path(uri, inner) or _check_path(package.folder / inner, uri, uri, (package.folder,), scope)
    if uri.startswith("asset://"):
        return _resolve_in_roots(uri, scope)
    return _check_path(base / uri, None, uri, (), scope)


def _look_up_package(uri: str, scope: AssetScope) -> _Package | Refusal:
    name = uri[len("pkg://") :].split("/", 1)[0]
    found = scope.memory.packages.get(name)
    if found is None:
        found = _find_package(name) if scope.packages is None else _find_packed(name, scope.packages)
        scope.memory.packages[name] = found
    return found


def _find_packed(name: str, packages: Mapping[str, Path]) -> _Package | Refusal:
    if name in packages:
        return _Package(_resolve_links(packages[name]), name)
    return Refusal("SC405", f"the pack contains no Python package `{shorten_uri(name)}`", _PACK_HINT)


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
        # For a name without dots, this runs no code of the package.
        spec = importlib.util.find_spec(name)
    except (ValueError, ImportError) as error:
        return Refusal("SC405", f"the Python package `{name}` cannot be found: {error}")
    if spec is None:
        return Refusal(
            "SC405",
            f"there is no Python package `{name}` here",
            ROBOTS_HINT
            if name == "mani_skill"
            else f"did you mean `pkg://{near}/…`?"
            if (near := nearest(name, ("mani_skill", "scenecc")))
            else "install the package that contains the file in this Python, if you trust it",
        )
    if spec.origin is None or not spec.submodule_search_locations or not spec.has_location:
        # A folder without __init__.py would depend on where Python was started: `pkg://home/…` in `/`.
        return Refusal("SC405", f"`{name}` is not a package with an __init__.py", "use asset:// and --asset-root")
    return _Package(_resolve_links(Path(spec.origin).parent), name)


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
    return Refusal("SC401", f"`{shorten_uri(uri)}` was not found in any asset root ({searched})", hint)


def _check_path(
    joined: Path, uri: str | None, written: str, extra: tuple[Path, ...], scope: AssetScope
) -> ResolvedFile | Refusal:
    """Checks an explicit path. `uri`: its canonical URI; None: the URI follows from the path."""
    try:
        real = _resolve_links(joined)
        if not scope.allow_outside and not any(real.is_relative_to(tree) for tree in (*_list_folders(scope), *extra)):
            places, hint = (
                ("folders that this scene may read", f"{_portable(written)}, or allow it with --allow-outside-assets")
                if scope.packages is None
                else ("pack", None)
            )
            return Refusal("SC402", f"`{shorten_uri(written)}` leaves the {places}", hint)
        kept = real if joined.name == ".." else _resolve_links(joined.parent) / joined.name
        # As written: `nowhere/../mug.obj` exists only after normalization, and SAPIEN would search elsewhere.
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
    return ResolvedFile(kept, uri if uri is not None else _format_uri(kept, scope))


def _refuse_unreachable(error: OSError, joined: Path, written: str, scope: AssetScope) -> Refusal:
    if error.errno == errno.ELOOP:
        return Refusal("SC407", f"`{shorten_uri(written)}` is a link to itself", "fix the link")
    if error.errno in {errno.ENOENT, errno.ENOTDIR}:
        scope.memory.missing.add(_resolve_links(joined))
        hint = scope.memory.near.hint(_resolve_links(joined), written) if scope.packages is None else _PACK_HINT
        if written.startswith(("$", "%")):
            hint = f"variables are not expanded: {_portable(written)}"
        hint = keyboard_hint(written) or hint or robot_hint(written)
        where = "" if scope.packages is None else " in the pack"
        return Refusal("SC401", f"there is no file `{shorten_uri(written)}`{where}", hint)
    if error.errno == errno.ENAMETOOLONG:
        return Refusal("SC401", f"there is no file `{shorten_uri(written)}`", "no file name is this long")
    return Refusal(
        "SC407", f"`{shorten_uri(written)}` may not be read: {error.strerror}", "change the file's permissions"
    )


def _format_uri(path: Path, scope: AssetScope) -> str:
    root = _list_folders(scope)[0]
    return (path.relative_to(root) if path.is_relative_to(root) else path).as_posix()


def name_of_file(path: Path, scope: AssetScope) -> str:
    """Returns a name of a file that does not depend on the machine; see `hash_files`. `path`: as in `ResolvedFile`."""
    for package in scope.memory.packages.values():
        if isinstance(package, _Package) and path.is_relative_to(package.folder):
            return f"pkg://{package.name}/{path.relative_to(package.folder).as_posix()}"
    root, *others = _list_folders(scope)
    folder = None if path.is_relative_to(root) else next((one for one in others if path.is_relative_to(one)), None)
    if folder is None:
        return Path(os.path.relpath(path, root)).as_posix()
    return f"asset://{path.relative_to(folder).as_posix()}"


def _root_folder(scope: AssetScope) -> Path:
    return (scope.root if scope.root is not None else Path()).absolute()


def _list_folders(scope: AssetScope) -> tuple[Path, ...]:
    """Returns the folders that may be read, without links; the first is the top scene's."""
    if scope.memory.trees is None:
        scope.memory.trees = tuple(_resolve_links(folder) for folder in (_root_folder(scope), *scope.asset_roots))
    return scope.memory.trees


def _resolve_links(path: Path) -> Path:
    # Up to Python 3.12, Path.resolve raises RuntimeError for circular links; here stat reports them.
    return Path(os.path.realpath(path))
