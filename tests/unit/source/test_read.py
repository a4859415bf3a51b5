"""The ways in: files and streams."""

from __future__ import annotations

import io
import os
import threading
from pathlib import Path
from typing import IO, Any

import pytest
from plugins.diagnostics import TakingSink

from scenecc import compile_scene, validate
from scenecc.diagnostics.diagnostic import Origin
from scenecc.source import Document, Limits, read_file, read_text
from scenecc.source.text import read_from_stream


def read_stream(stream: IO[str] | IO[bytes], name: str | None, sink: TakingSink, limits: Limits) -> Document | None:
    content = read_from_stream(stream, name, sink, limits)
    return None if content is None else read_text(content, name, sink, limits)


def test_a_file_is_read(tmp_path: Path, sink: TakingSink, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scene.yaml").write_text("a: ü\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    document = read_file("scene.yaml", sink)
    assert document is not None
    assert (document.name, document.path, document.data) == ("scene.yaml", tmp_path / "scene.yaml", {"a": "ü"})
    assert document.locate(Origin("scene.yaml", ("a",)), "value").file == "scene.yaml"


def test_a_link_to_a_file_is_read(tmp_path: Path, sink: TakingSink) -> None:
    (tmp_path / "scene.yaml").write_text("a: 1\n")
    link = tmp_path / "link.yaml"
    link.symlink_to("scene.yaml")
    document = read_file(link, sink)
    assert document is not None
    assert document.path == link


@pytest.mark.parametrize("stream", [io.StringIO("a: 1"), io.BytesIO(b"a: 1")])
def test_streams_are_read(stream: IO[str] | IO[bytes], sink: TakingSink) -> None:
    document = read_stream(stream, "<stdin>", sink, Limits())
    assert document is not None
    assert (document.name, document.path, document.data) == ("<stdin>", None, {"a": 1})


class Endless(io.RawIOBase):
    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any, /) -> int:
        buffer[:] = b"#" * len(buffer)
        return len(buffer)


def test_an_endless_stream_is_refused(sink: TakingSink) -> None:
    assert read_stream(io.BufferedReader(Endless()), None, sink, Limits(text_bytes=10_000)) is None
    sink.take("SC601")
    assert read_stream(io.TextIOWrapper(io.BufferedReader(Endless())), None, sink, Limits(text_bytes=9000)) is None
    sink.take("SC601")


def test_a_text_stream_with_invalid_text_is_refused(sink: TakingSink) -> None:
    stream = io.TextIOWrapper(io.BytesIO(b"a: 1\nb: \xff"), encoding="utf-8")
    assert read_stream(stream, "<stdin>", sink, Limits()) is None
    assert sink.take("SC002").file == "<stdin>"


def test_a_closed_stream_raises(sink: TakingSink) -> None:
    stream = io.StringIO("a: 1")
    stream.close()
    with pytest.raises(ValueError, match="closed"):
        read_stream(stream, None, sink, Limits())


def test_an_unbuffered_pipe_is_read_to_its_end() -> None:
    body = b"  e%05d: {shapes: [{type: sphere, radius: 1}]}\n"
    text = b"scenecc: 1\nentities:\n" + b"".join(body % i for i in range(3000))
    read_end, write_end = os.pipe()

    def feed() -> None:
        with os.fdopen(write_end, "wb") as file:
            file.write(text)

    writer = threading.Thread(target=feed)
    writer.start()
    with os.fdopen(read_end, "rb", buffering=0) as stream:
        assert len(compile_scene(stream).entities) == 3000
    writer.join()


@pytest.mark.parametrize("written", [b"", b"scenecc: 1\n"], ids=["nothing", "a part"])
def test_a_non_blocking_stream_is_refused(written: bytes) -> None:
    read_end, write_end = os.pipe()
    os.write(write_end, written)
    os.set_blocking(read_end, False)
    with os.fdopen(read_end, "rb", buffering=0) as stream:
        assert [found.code for found in validate(stream)] == ["SC001"]
    os.close(write_end)
