"""The asset checks against SAPIEN itself: what passes is cooked, what cannot be cooked does not pass.

SAPIEN runs in a process of its own, since some of these files end it.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from plugins.mesh_files import FACES, POINTS, TETRA, checked, codes, glb, gltf_document, ply, stl, stl_text, write

from scenecc import SceneError, load_scene
from scenecc.assets.meshes import checked_content, read_parts
from scenecc.diagnostics.codes import CODES

pytest.importorskip("sapien")

USES = ("hull", "triangles", "parts")
COOK = """
import json, sys
from sapien import physx
material = physx.PhysxMaterial(0.3, 0.3, 0.1)
for line in sys.stdin:
    path, use = json.loads(line)
    physx.clear_cache()
    try:
        if use == "hull":
            shapes = [physx.PhysxCollisionShapeConvexMesh(path, [1, 1, 1], material)]
        elif use == "triangles":
            shapes = [physx.PhysxCollisionShapeTriangleMesh(path, [1, 1, 1], material)]
        else:
            shapes = physx.PhysxCollisionShapeConvexMesh.load_multiple(path, [1, 1, 1], material)
        print(json.dumps([len(shape.vertices) for shape in shapes]), flush=True)
    except RuntimeError:
        print("null", flush=True)
"""


def cook(jobs: list[tuple[Path, str]]) -> list[list[int] | None]:
    """Vertices of each shape that SAPIEN cooks, None where it fails; shorter than `jobs` where it died."""
    text = "\n".join(json.dumps([str(path), use]) for path, use in jobs)
    done = subprocess.run([sys.executable, "-c", COOK], input=text, capture_output=True, text=True, check=False)
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith(("[", "null"))]


def passes(path: Path, use: str) -> bool:
    return all(CODES[code].severity == "warning" for code in codes(path, use))


def icosphere(count: int) -> np.ndarray:
    """Points all over a ball of 10 cm: more corners than a hull of PhysX may have."""
    turn = np.arange(count) * np.pi * (3 - 5**0.5)
    z = np.linspace(-1, 1, count)
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1) / 10


def corpus(folder: Path) -> list[Path]:
    files: dict[str, str | bytes] = {
        "good.obj": TETRA,
        "good.stl": stl(),
        "text.stl": stl_text(),
        "good.ply": ply(),
        "text.ply": ply(kind="ascii"),
        "big.ply": ply(kind="binary_big_endian"),
        "good.glb": glb(),
        "empty.obj": "",
        "one_triangle.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "flat.stl": stl(POINTS * [1, 1, 0]),
        "line.stl": stl(POINTS * [1, 0, 0]),
        "one_point.stl": stl(POINTS * 0),
        "nan.stl": stl(np.where(POINTS == 0.1, np.nan, POINTS)),
        "infinite.ply": ply(np.where(POINTS == 0.1, np.inf, POINTS)),
        "huge.stl": stl(POINTS * 1e12),
        "large.stl": stl(POINTS * 1e6),
        "micrometre.stl": stl(POINTS * 1e-5),
        "tenth_of_a_micrometre.stl": stl(POINTS * 1e-6),
        "nanometre.stl": stl(POINTS * 1e-8),
        "cut.stl": stl()[:150],
        "garbage.obj": bytes(random.Random(1).randbytes(3000)),
        "words.obj": "for\n",
        "missing_vertex.obj": TETRA.replace("f 3 1 4", "f 3 1 9"),
        "line_with_a_missing_vertex.obj": TETRA + "l 9 1\n",
        "no_material.obj": "mtllib gone.mtl\nusemtl a\n" + TETRA,
        "cut.glb": glb()[:300],
        "an_obj.stl": TETRA,
        "an_stl.obj": stl(),
        "cut.ply": ply()[:-20],
        "empty_faces.ply": ply(faces=np.zeros((0, 3), int)),
        "missing_vertex.ply": ply(faces=FACES + 100),
        "many_corners.stl": stl(
            icosphere(400), np.stack([np.arange(398), np.arange(398) + 1, np.arange(398) + 2], axis=1)
        ),
        "parts.obj": f"o a\n{TETRA}o b\n" + TETRA.replace("f 1 3 2", "f 5 7 6").replace("v 0 ", "v 1 "),
    }
    document, body = gltf_document()
    document["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}]
    document["scenes"] = [{"nodes": [0, 1]}]
    files["two_nodes.glb"] = glb(document, body)
    document, body = gltf_document()
    document["meshes"][0]["primitives"] *= 3
    files["three_primitives.glb"] = glb(document, body)
    return [write(folder, name, data) for name, data in files.items()] + [folder / "missing.obj"]


def test_meshes_that_pass_the_checks_can_be_cooked(tmp_path: Path) -> None:
    """What passes is cooked, but for the line with a missing vertex, which only SAPIEN's reader minds."""
    jobs = [(path, use) for path in corpus(tmp_path) for use in USES]
    passed = [job for job in jobs if passes(*job)]
    cooked = cook(passed)
    assert len(cooked) == len(passed)
    refused = {job[0].name for job, result in zip(passed, cooked, strict=True) if not result}
    assert refused == {"line_with_a_missing_vertex.obj"}
    names = {path.name for path, use in passed if use == "hull"}
    assert {"good.obj", "good.stl", "good.ply", "good.glb", "large.stl", "many_corners.stl", "two_nodes.glb"} <= names
    assert not {"one_triangle.obj", "flat.stl", "nan.stl", "huge.stl", "micrometre.stl", "missing.obj"} & names
    assert len(passed) > 35


def test_convex_parts_are_those_of_sapien(tmp_path: Path) -> None:
    paths = {path.name: path for path in corpus(tmp_path)}
    files = [paths[name] for name in ("parts.obj", "two_nodes.glb", "three_primitives.glb")]
    assert [len(parts or ()) for parts in cook([(path, "parts") for path in files])] == [2, 2, 1]
    assert [len(read_parts(checked_content(checked(path, "parts")))) for path in files] == [2, 2, 1]


def test_refused_meshes_cannot_be_cooked_correctly(tmp_path: Path) -> None:
    """The files whose refusal needs no other reason than SAPIEN's own failure."""
    failing = [
        "empty.obj",
        "huge.stl",
        "cut.stl",
        "garbage.obj",
        "words.obj",
        "missing_vertex.obj",
        "an_obj.stl",
        "cut.glb",
    ]
    paths = {path.name: path for path in corpus(tmp_path)}
    for name in failing:
        assert not passes(paths[name], "hull"), name
    assert cook([(paths[name], "hull") for name in failing if name != "huge.stl"]) == [None] * (len(failing) - 1)
    # A flat mesh comes out as a box that the file does not show.
    assert cook([(paths["one_triangle.obj"], "hull")]) == [[8]]


def mutated(data: bytes, how: random.Random) -> bytes:
    """A file as transmission, an editor or malice may leave it."""
    out = bytearray(data)
    at = how.randrange(len(out))
    match how.choice(["cut short", "bytes", "digits", "repeated", "cut out"]):
        case "cut short":
            return bytes(out[:at])
        case "bytes":
            for _ in range(how.choice([1, 1, 2, 5])):
                out[how.randrange(len(out))] = how.randrange(256)
        case "digits":
            digits = [i for i, byte in enumerate(out) if 48 <= byte <= 57]
            for _ in range(min(3, len(digits))):
                out[how.choice(digits)] = how.choice(b"0123456789.-e ")
        case "repeated":
            return bytes(out[:at] + out[max(0, at - 50) :])
        case _:
            return bytes(out[:at] + out[at + how.randrange(1, 60) :])
    return bytes(out)


def codes_of_build(scene: Path) -> set[str]:
    """The errors of a build."""
    try:
        load_scene(scene, render=False).close()
    except SceneError as error:
        return {one.code for one in error.diagnostics if one.severity == "error"}
    return set()


@pytest.mark.parametrize("seed", range(4))
def test_a_build_survives_mutated_files_that_pass(tmp_path: Path, seed: int) -> None:
    """SAPIEN reads each in a process of its own first; what it survives has the volume of the file."""
    sources = {
        "obj": [TETRA.encode()],
        "stl": [stl(), stl_text()],
        "ply": [ply(), ply(kind="ascii"), ply(kind="binary_big_endian")],
        "glb": [glb()],
    }
    how = random.Random(seed)
    built = refused = 0
    for i in range(80):
        suffix = how.choice(sorted(sources))
        path = write(tmp_path, f"{i}.{suffix}", mutated(how.choice(sources[suffix]), how))
        if not passes(path, "hull"):
            continue
        shape = f"{{type: convex_mesh, file: {path.name}}}"
        (tmp_path / "scene.yaml").write_text(f"scenecc: 1\nentities: {{a: {{body_type: static, shapes: [{shape}]}}}}")
        found = codes_of_build(tmp_path / "scene.yaml")
        assert found <= {"SC801", "SC423"}
        built, refused = built + (not found), refused + bool(found)
    assert built > 5
    assert built + refused > 8
