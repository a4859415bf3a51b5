"""Packs: a scene, what it includes and its assets in one archive (`.scn`), extracted to a folder of the user's cache.

A pack is untrusted. It is a ZIP file of uncompressed members, so reading cannot expand it. Its manifest has the SHA-256
of each member. The hash of the manifest names the extracted folder. A scene in a pack may read no other files.
"""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import stat
import struct
import time
import unicodedata
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, BinaryIO, Final

from pydantic import BaseModel, ConfigDict, ValidationError

from scenecc.diagnostics.coded_error import CodedError
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.files import ARCHIVE, PACKS, cache_folder, open_regular
from scenecc.interrupt import interrupts_wait, temporary_folder
from scenecc.source.paths import AssetScope, PathCache
from scenecc.version import VERSION

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink

OWN_FOLDER: Final = ".scenecc"
"""Folder of a pack beside the scene's own files: its manifest, asset roots and packages."""

MANIFEST: Final = f"{OWN_FOLDER}/manifest.json"

_FORMAT: Final = 1

_KEPT: Final = 30 * 24 * 3600
"""[s] Unused packs are removed from the cache after this time."""

MAX_PACK_BYTES: Final = 512 * 2**20
"""Maximum size of a pack. Its files are not compressed."""

_MOST_FILES: Final = 20_000

_EXTRACTED: Final = 315_532_800
"""[s] Modification time of extracted files: 1980, the earliest year of the format."""

_MOST_CHARACTERS: Final = 1000
"""Maximum length of a member name."""

_MOST_MANIFEST: Final = 16 * 2**20
"""[bytes] Maximum size of the manifest, and of the archive's directory."""

_BLOCK: Final = 1 << 20

_END: Final = struct.Struct("<4s4H2LH")
"""The end record of a ZIP file without a comment (section 4.3.16 of its specification)."""

_AGAIN: Final = "recreate it with `scenecc pack`, or copy it again"


class Manifest(BaseModel):
    """The manifest of a pack. Paths are relative to the pack, with `/` between folders.

    Attributes:
        scenecc_pack: version of this format.
        scenecc: version of scenecc that made it.
        entry: the scene file.
        asset_roots: folders to search for `asset://` paths, in order.
        packages: folders of the Python packages for `pkg://` paths.
        folders: folders that must exist, even if empty.
        files: SHA-256 of every file.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    scenecc_pack: int
    scenecc: str
    entry: str
    asset_roots: list[str]
    packages: dict[str, str]
    folders: list[str]
    files: dict[str, str]


class InvalidPackError(CodedError):
    """An archive is no pack, or must not be used."""

    def __init__(self, message: str, hint: str | None) -> None:
        super().__init__("SC019", message, hint)


@frozen
class Pack:
    """A pack that was read.

    Attributes:
        folder: folder of its files.
        manifest: its manifest.
        digest: SHA-256 of the manifest, and thus of all content.
    """

    folder: Path
    manifest: Manifest
    digest: str

    @property
    def entry(self) -> Path:
        """The scene file."""
        return self.folder / self.manifest.entry

    def scope(self, memory: PathCache) -> AssetScope:
        """Returns what the scene may read: only the pack."""
        roots = tuple(self.folder / root for root in self.manifest.asset_roots)
        packages = {name: self.folder / path for name, path in self.manifest.packages.items()}
        memory.trees = tuple(Path(os.path.realpath(folder)) for folder in (self.entry.parent, *roots, self.folder))
        return AssetScope(self.entry.parent, roots, memory=memory, packages=packages)


def is_pack(name: str | os.PathLike[str]) -> bool:
    """Returns whether a file begins like an archive."""
    try:
        with open_regular(name) as stream:
            return stream.read(len(ARCHIVE)) == ARCHIVE
    except (OSError, ValueError):  # reported when it is read as a scene
        return False


def open_pack(name: str, sink: Sink) -> Pack | None:
    """Extracts a pack to the cache folder, unless it is there; None if an error was reported."""
    try:
        with open_regular(name) as stream:
            archive = _open_archive(stream)
            manifest, digest = _read_manifest(archive)
            try:
                folder = _find_or_extract(archive, manifest, digest)
            except OSError as error:
                hint = f"packs are extracted to '{cache_folder(PACKS)}'; set XDG_CACHE_HOME for another place"
                message = f"the pack cannot be extracted to the cache: {error.strerror or error}"
                sink.report("SC818", message, Location(name), hint=hint)
                return None
        return Pack(folder, manifest, digest)
    except InvalidPackError as error:
        error.report(sink, Location(name))
    except OSError as error:
        sink.report("SC001", f"cannot open the file: {error.strerror or error}", Location(name))
    return None


def _open_archive(stream: BinaryIO) -> zipfile.ZipFile:
    """Returns the archive, after checking that all its members may be read."""
    size = os.fstat(stream.fileno()).st_size
    if size > MAX_PACK_BYTES:
        raise InvalidPackError(f"the pack is longer than {MAX_PACK_BYTES} bytes", "extract it, and use the scene in it")
    stream.seek(max(0, size - _END.size))
    end = stream.read()
    if len(end) < _END.size or end[:4] != b"PK\x05\x06":
        raise InvalidPackError("the archive is truncated, or has extra data at its end", _AGAIN)
    _, disk, _, here, count, length, start, comment = _END.unpack(end)
    if disk or comment or here != count or start + length != size - _END.size or length > _MOST_MANIFEST:
        raise InvalidPackError("the archive has a comment, several parts, or extra data", _AGAIN)
    try:
        archive = zipfile.ZipFile(stream)
        infos = archive.infolist()
    except (zipfile.BadZipFile, NotImplementedError, ValueError, struct.error, EOFError, OSError) as error:
        raise InvalidPackError(f"the archive is damaged: {error}", _AGAIN) from None
    if len(infos) != count or count > _MOST_FILES:
        raise InvalidPackError(f"the pack lists {max(count, len(infos))} files; the maximum is {_MOST_FILES}", _AGAIN)
    if sum(info.file_size for info in infos) > size:
        raise InvalidPackError("the files of the pack overlap one another", _AGAIN)
    for info in infos:
        _check_member(info)
    if fault := name_fault([info.filename for info in infos]):
        raise InvalidPackError(fault, _AGAIN)
    return archive


def _check_member(info: zipfile.ZipInfo) -> None:
    shown = f"`{info.filename[:100]!a}`"
    kind = stat.S_IFMT(info.external_attr >> 16)
    if info.flag_bits & 0x1:
        raise InvalidPackError(f"{shown} is encrypted", "packs must not be encrypted: " + _AGAIN)
    if info.compress_type != zipfile.ZIP_STORED or info.compress_size != info.file_size:
        raise InvalidPackError(f"{shown} is compressed", "files in a pack must not be compressed: " + _AGAIN)
    if kind not in {0, stat.S_IFREG} or info.filename.endswith("/"):
        raise InvalidPackError(f"{shown} is a link or a folder, not a file", _AGAIN)
    if info.orig_filename != info.filename:
        raise InvalidPackError(f"{shown} has an invalid path as its name", _AGAIN)


def name_fault(names: Iterable[str]) -> str | None:
    """Returns why members of a pack must not have these names together; None if they work on every file system."""
    known: dict[str, str] = {}
    folders: set[str] = set()
    for name in names:
        parts = name.split("/")
        if not set(parts).isdisjoint({"", ".", ".."}) or "\\" in name or len(name) > _MOST_CHARACTERS:
            return f"`{name[:100]!a}` is not a path inside a pack"
        try:
            if not name.isprintable() or max(len(part.encode()) for part in parts) > 255:
                return f"`{name[:100]!a}` is not a valid file name"
        except UnicodeEncodeError:
            return f"`{name[:100]!a}` is not a valid file name"
        folded = unicodedata.normalize("NFC", name).casefold()
        if folded in known:
            return f"`{name}` and `{known[folded]}` differ only in case, and are one file on some systems"
        known[folded] = name
        folders.update(str(folder) for folder in PurePosixPath(folded).parents)
        if len(folders) > _MOST_FILES:
            return f"the files are in more than {_MOST_FILES} folders"
    clash = next((name for folded, name in known.items() if folded in folders), None)
    return None if clash is None else f"`{clash}` is both a file and a folder"


def _read_manifest(archive: zipfile.ZipFile) -> tuple[Manifest, str]:
    """Returns the manifest and its SHA-256."""
    try:
        info = archive.getinfo(MANIFEST)
        if info.file_size > _MOST_MANIFEST:
            raise InvalidPackError(f"`{MANIFEST}` is longer than {_MOST_MANIFEST} bytes", _AGAIN)
        data = b"".join(_blocks(archive, info))
        manifest = Manifest.model_validate_json(data)
    except KeyError:
        raise InvalidPackError(
            f"the archive has no `{MANIFEST}`: it is not a pack", "make one with `scenecc pack`"
        ) from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part)[:50] for part in first["loc"])
        raise InvalidPackError(f"`{MANIFEST}` is invalid: {place}: {first['msg']}", _AGAIN) from None
    if manifest.scenecc_pack != _FORMAT:
        message = f"the pack has format {manifest.scenecc_pack}, made by scenecc {manifest.scenecc[:40]!a}"
        raise InvalidPackError(f"{message}; this scenecc reads format {_FORMAT}", "install a newer scenecc")
    lacking = manifest.files.keys() ^ {name for name in archive.namelist() if name != MANIFEST}
    if lacking or manifest.entry not in manifest.files:
        name = min(lacking, default=manifest.entry)
        raise InvalidPackError(f"the manifest and the archive list different files: `{name[:100]!a}`", _AGAIN)
    folders = [path for path in (*manifest.asset_roots, *manifest.packages.values(), *manifest.folders) if path]
    # Each with a file inside, so that none of them is a file.
    if fault := name_fault([*manifest.files, *{f"{path}/-" for path in folders}]):
        raise InvalidPackError(fault, _AGAIN)
    if not all(name.isidentifier() for name in manifest.packages):
        raise InvalidPackError("the manifest names an invalid package", _AGAIN)
    return manifest, hashlib.sha256(data).hexdigest()


def _blocks(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Iterator[bytes]:
    try:
        with archive.open(info) as stream:
            while block := stream.read(_BLOCK):
                yield block
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, ValueError, EOFError, struct.error) as error:
        raise InvalidPackError(f"the archive is damaged: {error}", _AGAIN) from None


def _find_or_extract(archive: zipfile.ZipFile, manifest: Manifest, digest: str) -> Path:
    """Returns the folder of an extracted pack, and extracts it if it is missing or incomplete.

    A changed archive with the manifest of another has other checksums, so it is not taken for that one.
    """
    above = cache_folder(PACKS)
    checksums = "".join(f"{one.CRC:08x}" for one in archive.infolist())
    folder = above / hashlib.sha256(f"{digest}{checksums}".encode()).hexdigest()
    if not _is_whole(folder, archive):
        above.mkdir(parents=True, exist_ok=True)
        _prune(above)
        with temporary_folder(".", above) as name:
            part = Path(name)
            _extract(archive, manifest, part / folder.name)
            with interrupts_wait():
                if folder.exists() and not _is_whole(folder, archive):
                    folder.rename(part / "old")
                with suppress(OSError):  # another process made it meanwhile
                    (part / folder.name).rename(folder)
    with suppress(OSError):
        os.utime(folder)
    return folder


def _is_whole(folder: Path, archive: zipfile.ZipFile) -> bool:
    """Returns whether every file is as it was extracted, by size and time. Its content was compared then."""
    try:
        found = [((folder / one.filename).stat(), one.file_size) for one in archive.infolist()]
    except OSError:
        return False
    return all(status.st_size == size and status.st_mtime == _EXTRACTED for status, size in found)


def _extract(archive: zipfile.ZipFile, manifest: Manifest, folder: Path) -> None:
    for path in (*manifest.asset_roots, *manifest.packages.values(), *manifest.folders):
        (folder / path).mkdir(parents=True, exist_ok=True)
    for info in archive.infolist():
        file, digest = folder / info.filename, hashlib.sha256()
        file.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(file, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o444)
        with os.fdopen(handle, "wb") as target:
            for block in _blocks(archive, info):
                digest.update(block)
                target.write(block)
        os.utime(file, (_EXTRACTED, _EXTRACTED))
        if info.filename != MANIFEST and digest.hexdigest() != manifest.files[info.filename]:
            raise InvalidPackError(f"`{info.filename}` does not match the manifest: its SHA-256 differs", _AGAIN)


def _prune(above: Path) -> None:
    """Removes packs that were not used for a long time."""
    oldest = time.time() - _KEPT
    with suppress(OSError):
        for path in above.iterdir():
            if path.stat().st_mtime < oldest:
                shutil.rmtree(path, ignore_errors=True)


def pack_bytes(
    entry: str,
    files: Mapping[str, bytes],
    *,
    asset_roots: Iterable[str] = (),
    packages: Mapping[str, str] | None = None,
    folders: Iterable[str] = (),
) -> tuple[bytes, Manifest]:
    """Returns the archive and its manifest. The same files give the same bytes on any machine. Arguments are those of
    `Manifest`.

    Raises:
        InvalidPackError: there are too many files, or two of them cannot be in one pack.
    """
    if len(files) >= _MOST_FILES:
        raise InvalidPackError(f"{len(files)} files are too many; a pack may have {_MOST_FILES}", None)
    if fault := name_fault(files):
        raise InvalidPackError(fault, "rename one of them")
    manifest = Manifest(
        scenecc_pack=_FORMAT,
        scenecc=VERSION,
        entry=entry,
        asset_roots=list(asset_roots),
        packages=dict(sorted((packages or {}).items())),
        folders=sorted(folders),
        files={name: hashlib.sha256(files[name]).hexdigest() for name in sorted(files)},
    )
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in [(MANIFEST, (manifest.model_dump_json(indent=1) + "\n").encode()), *sorted(files.items())]:
            info = zipfile.ZipInfo(name)  # of 1980, the earliest year of the format
            info.create_system, info.external_attr = 3, (stat.S_IFREG | 0o444) << 16
            archive.writestr(info, data)
    return target.getvalue(), manifest
