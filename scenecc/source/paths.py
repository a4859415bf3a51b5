"""Files that a scene names: where they are, and whether they may be read.

A scene file may come from a stranger. It sees the folder tree of the top scene file, the asset roots and
what `pkg://` names, and nothing else: whether a file outside exists is not told either.
"""

from __future__ import annotations

import errno
import importlib.util
import os
import stat
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from scenecc.source.near_names import NearNames
from scenecc.source.uris import Refusal, foreign_scheme, inner_malformed, malformed, shown

ASSET_PATH_VARIABLE = "SCENECC_ASSET_PATH"
"""Environment variable with asset roots, separated by `os.pathsep`; they come after `--asset-root`."""

_OUTSIDE_HINT = (
    "move the file beside the scene, give its folder with --asset-root, or allow it with --allow-outside-assets"
)


class Resolved(NamedTuple):
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
class Naming:
    """By what a file is named.

    Attributes:
        uri: of the file, as `Resolved` has it.
        by: the files that name it, as messages have them, in the order in which they did.
        role: of a scene file, "include" or "prefab"; "" of any other, which the plan tells.
    """

    uri: str
    by: dict[str, None] = field(default_factory=dict[str, None])
    role: str = ""


class Memory:
    """What one compilation has looked up already.

    Attributes:
        named: every file that is used, by its path.
        missing: where a file was looked for and is none.
    """

    def __init__(self) -> None:
        self.found: dict[tuple[str, str], Resolved | Refusal] = {}
        self.named: dict[Path, Naming] = {}
        self.missing: set[Path] = set()
        self.packages: dict[str, _Package | Refusal] = {}
        self.trees: tuple[Path, ...] | None = None
        self.near = NearNames()

    def note(self, file: Resolved, by: str, role: str = "") -> None:
        """Remembers that a file is used, and what names it."""
        naming = self.named.setdefault(file.path, Naming(file.uri))
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
    """

    root: Path | None = None
    asset_roots: tuple[Path, ...] = ()
    allow_outside: bool = False
    memory: Memory = field(default_factory=Memory, repr=False, compare=False)


def asset_roots(
    given: Iterable[str | os.PathLike[str]], environment: Mapping[str, str] | None = None
) -> tuple[Path, ...]:
    """The asset roots: those given, then those of `SCENECC_ASSET_PATH`.

    `environment`: in place of `os.environ`.
    """
    variable = (os.environ if environment is None else environment).get(ASSET_PATH_VARIABLE, "")
    return (*map(Path, given), *(Path(item) for item in variable.split(os.pathsep) if item))


def resolve(uri: str, *, base: Path, scope: AssetScope) -> Resolved | Refusal:
    """Finds the file that a scene names.

    Args:
        uri: as written: a path relative to `base`, an absolute path, `pkg://PACKAGE/PATH` or `asset://PATH`.
        base: folder of the file in which it is written.
        scope: what may be read.
    """
    key = (uri, str(base))
    found = scope.memory.found.get(key)
    if found is None:
        found = scope.memory.found[key] = _resolve(uri, _root(scope) / base, scope)
    return found


def has_package(name: str, scope: AssetScope) -> bool:
    """Whether `pkg://NAME/…` names files here. The package is looked for as `resolve` does, and not imported."""
    return isinstance(_package(f"pkg://{name}", scope), _Package)


def resolve_named(reference: str, *, owner: Path, owner_uri: str, scope: AssetScope) -> Resolved | Refusal:
    """Finds a file that an asset names (an MTL of an OBJ, a texture of a glTF).

    Only a path relative to the asset is taken: no scheme, nothing absolute. It may lie where the asset itself may,
    in the asset's package too.

    Args:
        reference: as written in the asset, percent escapes decoded.
        owner: path of the asset.
        owner_uri: its uri, as `Resolved` has it.
        scope: what may be read.
    """
    refusal = malformed(reference) or foreign_scheme(reference, ())
    if refusal is not None:
        return refusal
    if reference.startswith("/"):
        return Refusal(
            "SC402", f"the path `{shown(reference)}` is absolute", "an asset names its files relative to itself"
        )
    package = _package(owner_uri, scope) if owner_uri.startswith("pkg://") else None
    extra = (package.folder,) if isinstance(package, _Package) else ()
    return _finish(owner.parent / reference, None, reference, extra, scope)


def _resolve(uri: str, base: Path, scope: AssetScope) -> Resolved | Refusal:
    refusal = malformed(uri) or foreign_scheme(uri, ("pkg", "asset"))
    if refusal is not None:
        return refusal
    if uri.startswith("pkg://"):
        package = _package(uri, scope)
        if isinstance(package, Refusal):
            return package
        inner = uri[len("pkg://") + len(package.name) + 1 :]
        return inner_malformed(uri, inner) or _finish(package.folder / inner, uri, uri, (package.folder,), scope)
    if uri.startswith("asset://"):
        return _from_roots(uri, scope)
    return _finish(base / uri, None, uri, (), scope)


def _package(uri: str, scope: AssetScope) -> _Package | Refusal:
    name = uri[len("pkg://") :].split("/", 1)[0]
    found = scope.memory.packages.get(name)
    if found is None:
        found = scope.memory.packages[name] = _find_package(name)
    return found


def _find_package(name: str) -> _Package | Refusal:
    if "." in name and all(part.isidentifier() for part in name.split(".")):
        slashed = name.replace(".", "/")
        return Refusal(
            "SC405",
            f"`{name}` is not a top-level package",
            f"write pkg://{slashed}/… (a dotted name would be imported)",
        )
    if not name.isidentifier():
        return Refusal("SC405", f"`{shown(name)}` is not the name of a Python package", "write pkg://PACKAGE/PATH")
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
    return _Package(_real(Path(spec.origin).parent), name)


def _from_roots(uri: str, scope: AssetScope) -> Resolved | Refusal:
    inner = uri[len("asset://") :]
    refusal = inner_malformed(uri, inner)
    if refusal is not None:
        return refusal
    if not scope.asset_roots:
        return Refusal(
            "SC406",
            f"`{shown(uri)}` needs an asset root, and none is given",
            f"give --asset-root FOLDER or set {ASSET_PATH_VARIABLE}",
        )
    refusals: list[Refusal] = []
    for folder in scope.asset_roots:
        found = _finish(folder.absolute() / inner, uri, uri, (), scope)
        if isinstance(found, Resolved) or found.code != "SC401":
            return found
        refusals.append(found)
    hint = next((refusal.hint for refusal in refusals if refusal.hint is not None), None)
    searched = ", ".join(map(str, scope.asset_roots))
    return Refusal("SC401", f"`{shown(uri)}` is in no asset root ({searched})", hint)


def _finish(
    joined: Path, uri: str | None, written: str, extra: tuple[Path, ...], scope: AssetScope
) -> Resolved | Refusal:
    """Checks a path that is spelled out. `uri`: the canonical one, None where it follows from the path."""
    try:
        real = _real(joined)
        if not scope.allow_outside and not any(real.is_relative_to(tree) for tree in (*_trees(scope), *extra)):
            return Refusal("SC402", f"`{shown(written)}` leaves the folders that this scene may read", _OUTSIDE_HINT)
        kept = real if joined.name == ".." else _real(joined.parent) / joined.name
        # As written: `nowhere/../mug.obj` is there in words alone, and SAPIEN would go and look elsewhere.
        status = joined.stat()
    except OSError as error:
        return _unreachable(error, joined, written, scope)
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "not a regular file"
        return Refusal("SC404", f"`{shown(written)}` is {kind}", "name a file")
    if written.endswith("/"):
        return Refusal("SC404", f"`{shown(written)}` ends in a slash", "name a file")
    if not os.access(kept, os.R_OK):
        return Refusal("SC407", f"`{shown(written)}` may not be read", "change the file's permissions")
    return Resolved(kept, uri if uri is not None else _canonical(kept, scope))


def _unreachable(error: OSError, joined: Path, written: str, scope: AssetScope) -> Refusal:
    if error.errno == errno.ELOOP:
        return Refusal("SC407", f"`{shown(written)}` is a link to itself", "mend the link")
    if error.errno in {errno.ENOENT, errno.ENOTDIR}:
        scope.memory.missing.add(_real(joined))
        return Refusal("SC401", f"there is no file `{shown(written)}`", scope.memory.near.hint(_real(joined)))
    if error.errno == errno.ENAMETOOLONG:
        return Refusal("SC401", f"there is no file `{shown(written)}`", "no file name is this long")
    return Refusal("SC407", f"`{shown(written)}` may not be read: {error.strerror}", "change the file's permissions")


def _canonical(path: Path, scope: AssetScope) -> str:
    root = _trees(scope)[0]
    return (path.relative_to(root) if path.is_relative_to(root) else path).as_posix()


def _root(scope: AssetScope) -> Path:
    return (scope.root if scope.root is not None else Path()).absolute()


def _trees(scope: AssetScope) -> tuple[Path, ...]:
    """The folders that may be read, without links; the first is the top scene's."""
    if scope.memory.trees is None:
        scope.memory.trees = tuple(_real(folder) for folder in (_root(scope), *scope.asset_roots))
    return scope.memory.trees


def _real(path: Path) -> Path:
    # Path.resolve raises RuntimeError for links in a circle up to Python 3.12; this leaves them to stat.
    return Path(os.path.realpath(path))
