"""Archives from strangers: whatever is wrong with one is told, and nothing of it is used."""

from __future__ import annotations

import io
import json
import random
import stat
import struct
import warnings
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from scenecc import Diagnostic, validate
from scenecc.source.pack import MANIFEST, pack_bytes

SCENE = b"scenecc: 1\nentities:\n  ball: {shapes: [{type: sphere, radius: 0.1}]}\n"
FILES = {"scene.yaml": SCENE, "parts/a.yaml": b"scenecc: 1\n"}


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "scenecc" / "packs"


def archive(files: dict[str, bytes] = FILES, entry: str = "scene.yaml") -> bytes:
    return pack_bytes(entry, files)[0]


def found(tmp_path: Path, content: bytes, **options: Any) -> list[Diagnostic]:
    file = tmp_path / "x.scn"
    file.write_bytes(content)
    return validate(file, **options)


Change = Callable[[zipfile.ZipInfo, bytes], tuple[zipfile.ZipInfo, bytes]]


def remade(change: Change, more: Iterator[tuple[str, bytes]] | tuple[tuple[str, bytes], ...] = ()) -> bytes:
    """The archive with changed members and further ones."""
    target = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(archive())) as source, zipfile.ZipFile(target, "w") as made:
        for info in source.infolist():
            made.writestr(*change(info, source.read(info)))
        for name, data in more:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of a name that is there
                made.writestr(name, data)
    return target.getvalue()


def same(info: zipfile.ZipInfo, data: bytes) -> tuple[zipfile.ZipInfo, bytes]:
    return info, data


def with_manifest(**changes: Any) -> bytes:
    def change(info: zipfile.ZipInfo, data: bytes) -> tuple[zipfile.ZipInfo, bytes]:
        if info.filename == MANIFEST:
            data = json.dumps({**json.loads(data), **changes}).encode()
        return info, data

    return remade(change)


def compressed(info: zipfile.ZipInfo, data: bytes) -> tuple[zipfile.ZipInfo, bytes]:
    info.compress_type = zipfile.ZIP_DEFLATED
    return info, data


def linked(info: zipfile.ZipInfo, data: bytes) -> tuple[zipfile.ZipInfo, bytes]:
    info.external_attr = (stat.S_IFLNK | 0o777) << 16
    return info, data


def named(name: str) -> bytes:
    """An archive whose manifest has a further file of this name, and its member too."""
    files = {**json.loads(zipfile.ZipFile(io.BytesIO(archive())).read(MANIFEST))["files"], name: "0" * 64}

    def change(info: zipfile.ZipInfo, data: bytes) -> tuple[zipfile.ZipInfo, bytes]:
        if info.filename == MANIFEST:
            data = json.dumps({**json.loads(data), "files": files}).encode()
        return info, data

    return remade(change, ((name, b"x"),))


def without_manifest() -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as made:
        made.writestr("scene.yaml", SCENE)
    return target.getvalue()


def encrypted() -> bytes:
    content = bytearray(archive())
    place = content.rindex(b"PK\x01\x02")
    content[place + 8] |= 1
    return bytes(content)


def overlapping() -> bytes:
    """All members are said to be as long as the whole archive."""
    content = bytearray(archive())
    place = content.index(b"PK\x01\x02")
    while place >= 0:
        struct.pack_into("<LL", content, place + 20, len(content), len(content))
        place = content.find(b"PK\x01\x02", place + 1)
    return bytes(content)


WORD = archive().index(b"sphere")
HOSTILE = {
    "truncated": archive()[:-30],
    "cut short": archive()[:200],
    "only a start": b"PK\x03\x04",
    "something after it": archive() + b"more",
    "something before it": b"PKmore" + archive(),
    "a changed byte": archive()[:WORD] + b"S" + archive()[WORD + 1 :],
    "no manifest": without_manifest(),
    "encrypted": encrypted(),
    "compressed": remade(compressed),
    "links": remade(linked),
    "overlapping": overlapping(),
    "a member that the manifest lacks": remade(same, (("other.yaml", b""),)),
    "a member twice": named("scene.yaml"),
    "climbs": named("../evil.yaml"),
    "climbs inside": named("parts/../../evil.yaml"),
    "absolute": named("/tmp/evil.yaml"),
    "a backslash": named("a\\b.yaml"),
    "a folder": named("empty/"),
    "a control character": named("a\x1bb.yaml"),
    "no character": named("a\u202eb.yaml"),
    "a long name": named("a" * 300),
    "a long path": named("a/" * 600 + "b"),
    "cases": named("Scene.YAML"),
    "a file as a folder": named("scene.yaml/x"),
    "another hash": with_manifest(files={"scene.yaml": "0" * 64, "parts/a.yaml": "0" * 64}),
    "a later format": with_manifest(scenecc_pack=2),
    "an unknown key": with_manifest(more=1),
    "a wrong type": with_manifest(files=[]),
    "a missing entry": with_manifest(entry="other.yaml"),
    "an entry outside": with_manifest(entry="../other.yaml"),
    "a root outside": with_manifest(asset_roots=["../.."]),
    "a package outside": with_manifest(packages={"numpy": "/usr/lib"}),
    "a package of no name": with_manifest(packages={"a b": "parts"}),
    "a folder that is a file": with_manifest(folders=["scene.yaml"]),
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE)
def test_an_invalid_pack_is_reported_without_leftovers(content: bytes, tmp_path: Path, cache: Path) -> None:
    (diagnostic,) = found(tmp_path, content)
    assert (diagnostic.code, diagnostic.file) == ("SC019", str(tmp_path / "x.scn"))
    assert diagnostic.hint
    assert diagnostic.message.isprintable()
    assert not cache.exists() or not list(cache.iterdir())
    assert not list(tmp_path.rglob("evil*"))


def test_random_damage_of_a_pack_is_reported_or_harmless(tmp_path: Path) -> None:
    generator = random.Random(5)
    for _ in range(400):
        content = bytearray(archive())
        for _ in range(generator.randint(1, 4)):
            content[generator.randrange(2, len(content))] = generator.randrange(256)
        assert {one.code for one in found(tmp_path, bytes(content)[: generator.choice([None, 900])])} <= {"SC019"}


def test_a_pack_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.source.pack.MAX_PACK_BYTES", 500)
    (diagnostic,) = found(tmp_path, archive())
    assert diagnostic.code == "SC019"
    assert "longer than 500 bytes" in diagnostic.message


def test_too_many_members_are_not_read(tmp_path: Path) -> None:
    assert [one.code for one in found(tmp_path, remade(same, tuple((f"f{i}", b"") for i in range(20_000))))] == [
        "SC019"
    ]


def test_files_in_too_many_folders_are_not_read(tmp_path: Path) -> None:
    deep = tuple((f"{i}/" + "/".join("x" * 400) + "/f", b"") for i in range(60))
    assert [one.code for one in found(tmp_path, remade(same, deep))] == ["SC019"]


def test_a_pack_is_extracted_once_and_repaired_if_files_are_missing_or_changed(tmp_path: Path, cache: Path) -> None:
    assert not found(tmp_path, archive())
    (folder,) = cache.iterdir()
    file = folder / "scene.yaml"
    assert file.read_bytes() == SCENE
    assert not file.stat().st_mode & 0o222
    before = file.stat()
    assert not found(tmp_path, archive())
    assert file.stat().st_ino == before.st_ino
    (folder / "parts" / "a.yaml").unlink()
    assert not found(tmp_path, archive())
    assert (folder / "parts" / "a.yaml").read_bytes() == FILES["parts/a.yaml"]
    file.chmod(0o644)
    file.write_bytes(SCENE[::-1])
    assert not found(tmp_path, archive())
    assert file.read_bytes() == SCENE
    assert list(cache.iterdir()) == [folder]


def test_a_changed_pack_is_refused_although_the_original_was_extracted(tmp_path: Path, cache: Path) -> None:
    assert not found(tmp_path, archive())
    changed = remade(lambda info, data: (info, data[::-1] if info.filename == "scene.yaml" else data))
    (diagnostic,) = found(tmp_path, changed)
    assert (diagnostic.code, "does not match the manifest" in diagnostic.message) == ("SC019", True)
    assert len(list(cache.iterdir())) == 1


def test_unused_packs_are_removed_from_the_cache(tmp_path: Path, cache: Path) -> None:
    import os

    assert not found(tmp_path, archive())
    (old,) = cache.iterdir()
    os.utime(old, (0, 0))
    assert not found(tmp_path, archive({"scene.yaml": SCENE}))
    (new,) = cache.iterdir()
    assert new != old


def test_an_unwritable_pack_cache_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    (diagnostic,) = found(tmp_path, archive())
    assert diagnostic.code == "SC818"
    assert "XDG_CACHE_HOME" in (diagnostic.hint or "")


def test_a_text_file_named_like_a_pack_is_read_as_text(tmp_path: Path) -> None:
    assert not found(tmp_path, SCENE)


OUTSIDE = {
    "/etc/passwd": "SC402",
    "../../../../x.yaml": "SC402",
    "pkg://numpy/x.yaml": "SC405",
    "asset://x.yaml": "SC406",
    "x.yaml": "SC401",
}


@pytest.mark.parametrize(("uri", "code"), OUTSIDE.items())
def test_a_scene_in_a_pack_reads_no_outside_files(uri: str, code: str, tmp_path: Path) -> None:
    scene = f"scenecc: 1\nentities:\n  e: {{use: '{uri}'}}\n".encode()
    (tmp_path / "x.yaml").write_bytes(SCENE)
    options = {"asset_roots": [tmp_path], "allow_outside_assets": True}
    (diagnostic,) = found(tmp_path, archive({"scene.yaml": scene}), **options)
    assert diagnostic.code == code
    assert diagnostic.file == f"{tmp_path / 'x.scn'}!/scene.yaml"
    assert diagnostic.line == 3
