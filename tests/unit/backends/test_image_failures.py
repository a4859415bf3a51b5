"""Images that Pillow reads and SAPIEN does not: the build reports them at the line that names the file."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from plugins.image_files import exr

import scenecc

ARITHMETIC_JPEG = (
    b"\xff\xd8\xff\xdb\0\x43\0" + b"\1" * 64  # one quantization table
    + b"\xff\xc9\0\x0b\x08\0\x08\0\x10\1\1\x11\0"  # 16 × 8 pixels, arithmetic coding
    + b"\xff\xda\0\x08\1\1\0\0\x3f\0" + b"\0\0\xff\xd9"
)  # fmt: skip
RUNS_BMP = (
    struct.pack("<2sIHHI", b"BM", 1088, 0, 0, 1078)
    + struct.pack("<IiiHHIIiiII", 40, 4, 2, 1, 8, 1, 10, 0, 0, 256, 0)  # 4 × 2 pixels, RLE8
    + b"".join(bytes([i, i, i, 0]) for i in range(256))
    + b"\4\5\0\0\4\6\0\0\0\1"
)
IMAGES = {
    "arithmetic.jpg": ARITHMETIC_JPEG,
    "runs.bmp": RUNS_BMP,
    "name.exr": exr(8, 4).replace(b"n\0compression", b"n\0compr\xddssion"),  # whose report is not UTF-8
}
SCENE = """\
scenecc: 1
materials:
  paint:
    visual:
      metallic: 0.5
      roughness_texture: IMAGE
entities:
  ball:
    body_type: none
    visuals: [{type: sphere, radius: 0.1, material: paint}]
"""
LIGHT = """\
scenecc: 1
lights:
  beamer:
    type: textured
    color: [1, 1, 1]
    position: [0, 0, 1]
    direction: [0, 0, -1]
    inner_fov: 0.5
    outer_fov: 0.6
    texture: IMAGE
"""
SKY = """\
scenecc: 1
environment:
  ambient_light: [0.1, 0.1, 0.1]
  map: IMAGE
"""


@pytest.mark.render
@pytest.mark.parametrize("name", IMAGES)
@pytest.mark.parametrize(("scene", "line"), [(SCENE, 6), (LIGHT, 10), (SKY, 4)], ids=["texture", "light", "map"])
def test_an_image_that_only_sapien_refuses_is_reported_where_it_is_named(
    tmp_path: Path, scene: str, line: int, name: str
) -> None:
    (tmp_path / name).write_bytes(IMAGES[name])
    file = tmp_path / "scene.yaml"
    file.write_text(scene.replace("IMAGE", name))
    assert not scenecc.validate(file)
    with pytest.raises(scenecc.SceneError) as caught:
        scenecc.load_scene(file, render=True)
    (found,) = caught.value.diagnostics
    assert (found.code, found.location.line) == ("SC807", line)
    assert str(tmp_path / name) in found.message
    assert found.hint is not None
