"""Files that ask for more than a machine has, within what the default limits say: refused, or checked in bounds.

Each is validated in a process of its own, which may have 2 GiB of addresses and 90 seconds of a core.
"""

from __future__ import annotations

import json
import random
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.timeout(600)  # on a loaded machine; the processes have a limit of their own

GIB = 2**30
MIB = 2**20
BOX = "shapes: [{type: box, half_size: [1, 1, 1]}]"
_VALIDATE = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (2 * 2**30, 2 * 2**30))
share, seconds = int(sys.argv[2]), int(sys.argv[3])
resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
import scenecc
from scenecc.source import Limits
limits = {name: getattr(Limits(), name) // share for name in ("asset_bytes", "objects")}
print(*sorted({found.code for found in scenecc.validate(sys.argv[1], limits=limits)}))
# Not `ru_maxrss`, which begins with what the process had that started this one.
with open("/proc/self/status") as status:
    print(next(line.split()[1] for line in status if line.startswith("VmHWM")))
"""


def validated(path: Path, *, share: int = 1, seconds: int = 90) -> tuple[set[str], int]:
    """The codes of what is found, and the most memory that was in use [bytes].

    Args:
        path: of the scene.
        share: by which the limits of objects and of what assets take are divided.
        seconds: how long a core may be used.
    """
    command = [sys.executable, "-c", _VALIDATE, str(path), str(share), str(seconds)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    codes, peak = run.stdout.splitlines()
    return set(codes.split()), int(peak) * 1024


def scene(folder: Path, text: str, **files: str | bytes) -> Path:
    """A scene and the files that it names, whose names have `_` for the dot."""
    for name, content in files.items():
        data = content.encode() if isinstance(content, str) else content
        (folder / name.replace("_", ".")).write_bytes(data)
    path = folder / "scene.yaml"
    path.write_text("scenecc: 1\n" + text, encoding="utf-8")
    return path


def copies(count: int, keys: str = BOX) -> str:
    return f"entities: {{a: {{repeat: {{i: {{count: {count}}}}}, {keys}}}}}\n"


def uses(count: int) -> str:
    return f"entities: {{a: {{use: p0.yaml, repeat: {{i: {{count: {count}}}}}}}}}\n"


def prefabs_of_prefabs(folder: Path) -> Path:
    files: dict[str, str] = {f"p{i}_yaml": f"scenecc: 1\n{uses(10).replace('p0', f'p{i + 1}')}" for i in range(5)}
    return scene(folder, uses(9), p5_yaml=f"scenecc: 1\nentities: {{a: {{{BOX}}}}}\n", **files)


def chained_draws(folder: Path) -> Path:
    draws = "".join(f"  d{i}: '${{d{i - 1} * 0.99 + 0.01}}'\n" for i in range(1, 900))
    head = f"num_scenes: 65536\ndraws:\n  d0: {{uniform: [0, 1]}}\n{draws}"
    return scene(folder, head + f"entities: {{a: {{pose: ['${{d899}}', 0, 0], {BOX}}}}}\n")


def included(folder: Path) -> Path:
    text = "scenecc: 1\nx-a: '" + "a" * 9_000_000 + "'\n"
    return scene(folder, "include: [a.yaml, b.yaml]\n", a_yaml=text, b_yaml=text)


MESH = "entities: {a: {body_type: static, shapes: [{type: triangle_mesh, file: %s}]}}\n"


CORNERS = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}


def gltf(**keys: Any) -> bytes:
    """A glTF of one mesh of three vertices, which are the first bytes of its first buffer."""
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [CORNERS],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": f"data:application/octet-stream;base64,{'A' * 48}"}],
    }
    return json.dumps(document | keys).encode()


def sparse(kind: int, count: int, width: str) -> dict[str, Any]:
    """An accessor of any number of rows, of which a buffer holds but one."""
    one = {"count": 1, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}}
    return {"componentType": kind, "count": count, "type": width, "sparse": one}


def many_vertices(folder: Path) -> Path:
    return scene(folder, MESH % "m.gltf", m_gltf=gltf(accessors=[sparse(5126, 9_000_000, "VEC3")]))


def long_strip(folder: Path) -> Path:
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}
    accessors = [CORNERS, sparse(5121, 20_000_000, "SCALAR")]
    return scene(folder, MESH % "m.gltf", m_gltf=gltf(accessors=accessors, meshes=[{"primitives": [primitive]}]))


def lists_in_gltf(folder: Path) -> Path:
    return scene(folder, MESH % "m.gltf", m_gltf=gltf()[:-1] + b', "extras": [' + b"[]," * 15_000_000 + b"[]]}")


def one_image_often(folder: Path) -> Path:
    keys = {
        "buffers": [{"byteLength": 8 * MIB, "uri": "b.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 8 * MIB}],
        "images": [{"bufferView": 0, "mimeType": "image/png"}] * 400,
    }
    text = "entities: {a: {body_type: static, visuals: [{type: mesh, file: m.gltf}]}}\n"
    return scene(folder, text, m_gltf=gltf(**keys), b_bin=bytes(8 * MIB))


def large_obj(folder: Path) -> Path:
    with (folder / "m.obj").open("wb") as file:
        file.truncate(192 * MIB)
    return scene(folder, MESH % "m.obj")


TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def with_mtl(folder: Path, mtl: str) -> Path:
    text = "entities: {a: {body_type: static, visuals: [{type: mesh, file: m.obj}]}}\n"
    return scene(folder, text, m_obj="mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", m_mtl=mtl)


def meshes_together(folder: Path) -> Path:
    for i in range(10):
        with (folder / f"b{i}.bin").open("wb") as file:
            file.truncate(60 * MIB)
        keys = {
            "buffers": [{"byteLength": 60 * MIB, "uri": f"b{i}.bin"}],
        }
        (folder / f"m{i}.gltf").write_bytes(gltf(**keys))
    entities = (f"a{i}: {{body_type: static, shapes: [{{type: triangle_mesh, file: m{i}.gltf}}]}}" for i in range(10))
    return scene(folder, f"entities: {{{', '.join(entities)}}}\n")


def stl(triangles: int) -> bytes:
    return bytes(80) + struct.pack("<I", triangles) + random.Random(1).randbytes(50 * triangles)


REFUSED: dict[str, tuple[Callable[[Path], Path], str]] = {
    "copies of copies": (
        lambda folder: scene(folder, copies(1000).replace("}}, shapes", "}, j: {count: 1000}}, shapes")),
        "SC604",
    ),
    "values of one letter": (lambda folder: scene(folder, f"x-a: [{'1,' * 5_000_000}1]\n"), "SC601"),
    "prefabs of prefabs": (prefabs_of_prefabs, "SC604"),
    "empty prefabs": (lambda folder: scene(folder, uses(1_000_000), p0_yaml="scenecc: 1\n"), "SC604"),
    "lights": (
        lambda folder: scene(
            folder, "lights: {a: {repeat: {i: {count: 1000000}}, type: point, pose: [0, 0, 1], color: [1, 1, 1]}}\n"
        ),
        "SC604",
    ),
    "many forms in each copy": (
        lambda folder: scene(
            folder,
            copies(100_000, f"pose: {{p: [{', '.join(['{uniform: [0, 1]}'] * 3)}]}}, mass: {{uniform: [1, 2]}}, {BOX}"),
        ),
        "SC604",
    ),
    "written frames": (
        lambda folder: scene(folder, "frames:\n" + "".join(f" a{i}: {{pose: [0, 0, 0]}}\n" for i in range(140_000))),
        "SC604",
    ),
    "long names": (
        lambda folder: scene(
            folder, "params: {n: " + "b" * 9000 + "}\n" + copies(100_000, f"name: '${{n}}_${{i}}', {BOX}")
        ),
        "SC604",
    ),
    "robots": (
        lambda folder: scene(
            folder, copies(100_000, "urdf: r.urdf"), r_urdf='<robot name="r"><link name="a"/></robot>'
        ),
        "SC604",
    ),
    "texts together": (included, "SC601"),
    "chained draws": (chained_draws, "SC604"),
    "names that draws make": (
        lambda folder: scene(
            folder,
            "num_scenes: 4\ndraws: {" + ", ".join(f"d{i}: {{integers: [0, 9]}}" for i in range(4)) + "}\n"
            "materials: {m: {visual: {roughness: 1}}}\n"
            + copies(99, f"material: 'm${{d0}}${{d1}}${{d2}}${{d3}}_${{i}}', {BOX}"),
        ),
        "SC301",
    ),
    "vertices that no buffer holds": (many_vertices, "SC410"),
    "a strip of indices that no buffer holds": (long_strip, "SC607"),
    "lists in a glTF": (lists_in_gltf, "SC415"),
    "a large OBJ": (large_obj, "SC607"),
    "an OBJ of lines that are continued": (
        lambda folder: scene(folder, MESH % "m.obj", m_obj=TRIANGLE + b"v 0 0 0 \\\n" * 3_000_000),
        "SC412",
    ),
    "a long MTL": (lambda folder: with_mtl(folder, "map_Kd a.png\n" * 1_000_000), "SC418"),
    "options in an MTL": (lambda folder: with_mtl(folder, "map_Kd " + "-bm 1 " * 800_000 + "a.png\n"), "SC418"),
    "images in an MTL": (
        lambda folder: with_mtl(folder, "".join(f"map_Kd {i}.png\n" for i in range(3_000_000))),
        "SC607",
    ),
    "materials in an OBJ": (
        lambda folder: scene(folder, MESH % "m.obj", m_obj="".join(f"mtllib {i}\n" for i in range(1_000_000))),
        "SC607",
    ),
    "meshes together": (meshes_together, "SC415"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_exhausting_scenes_are_refused(name: str, tmp_path: Path) -> None:
    make, code = REFUSED[name]
    codes, peak = validated(make(tmp_path))
    assert code in codes
    assert peak < GIB


CLEAN: dict[str, Callable[[Path], Path]] = {
    "repeated, in 64 scenes": lambda folder: scene(
        folder, "num_scenes: 64\n" + copies(50_000, f"pose: ['${{i}}', 0, 0], {BOX}")
    ),
    "written out": lambda folder: scene(
        folder, "entities:\n" + "".join(f"  a{i}: {{pose: [{i}, 0, 0], {BOX}}}\n" for i in range(50_000))
    ),
    "by prefabs": lambda folder: scene(
        folder,
        uses(49_500).replace("use:", "pose: ['${i}', 0, 0], use:"),
        p0_yaml=f"scenecc: 1\nentities: {{a: {{{BOX}}}}}\n",
    ),
    "a chain of frames": lambda folder: scene(
        folder,
        "frames:\n  f0: {pose: [0, 0, 0]}\n"
        + "".join(f"  f{i}: {{pose: {{p: [0, 0, 0.1], relative_to: f{i - 1}}}}}\n" for i in range(1, 20_000)),
    ),
}
"""Files as large as half of the limit of objects lets them be."""


@pytest.mark.parametrize("name", CLEAN)
def test_large_scenes_pass_within_memory_and_time(name: str, tmp_path: Path) -> None:
    """In a quarter of the time: what grows by the square of its size takes all of it at twice the size."""
    codes, peak = validated(CLEAN[name](tmp_path), share=2, seconds=90 // 4)
    assert not codes
    assert peak < GIB // 2


IN_BOUNDS: dict[str, Callable[[Path], Path]] = {
    "one image named often": one_image_often,
    "empty lines": lambda folder: scene(folder, MESH % "m.obj", m_obj=TRIANGLE + b"\n" * 50_000_000),
    "lines that alternate": lambda folder: scene(
        folder, MESH % "m.obj", m_obj=TRIANGLE + b"v 0 0 0\nf 1 2 3\n" * 125_000
    ),
}


@pytest.mark.parametrize("name", IN_BOUNDS)
def test_a_mesh_is_read_within_memory_and_time(name: str, tmp_path: Path) -> None:
    codes, peak = validated(IN_BOUNDS[name](tmp_path))
    assert not codes
    assert peak < GIB


def test_a_large_mesh_is_read_within_memory_and_time(tmp_path: Path) -> None:
    codes, peak = validated(scene(tmp_path, MESH % "m.stl", m_stl=stl(400_000)))
    assert "SC607" not in codes
    assert peak < GIB
