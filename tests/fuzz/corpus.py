"""What is mutated: folders with a scene each, made of this repository's own scenes and of small files."""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fidelity import mjcf_cases, urdf_cases
from fuzz import import_corpus
from fuzz.import_corpus import Files
from fuzz.oracle import PACK, PASSPORT, SCENE, UNPACKED
from plugins.image_files import PICTURES, exr, ktx, ktx2, picture
from plugins.mesh_files import FACES, POINTS, TETRA, glb, gltf_document, ply, stl, stl_text

from scenecc import load_scene, pack_scene

_ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Seed:
    """A folder with a scene, a pack, a passport or what is imported, and the name of the file in it that is mutated."""

    folder: Path
    name: str


def make_corpus(target: str, folder: Path) -> list[Seed]:
    """The seeds of a target, in a folder each."""
    seeds: list[Seed] = []
    for i, (name, files) in enumerate(_CORPORA[target]()):
        home = folder / f"{target}-{i}"
        for path, data in files.items():
            (home / path).parent.mkdir(parents=True, exist_ok=True)
            if isinstance(data, Path):
                (shutil.copytree if data.is_dir() else shutil.copyfile)(data, home / path)
            else:
                (home / path).write_bytes(data.encode() if isinstance(data, str) else data)
        seeds.append(Seed(home, name))
    return seeds


def _scenes() -> Iterator[tuple[str, Files]]:
    folders = ("scenes", "scenes/recipes", *(f"tests/scenes/good/{one}" for one in ("", "articulations", "expansion")))
    for scene in sorted(path for folder in folders for path in (_ROOT / folder).glob("*.yaml")):
        beside = {path.name: path for path in scene.parent.iterdir() if path.name not in {"maniskill", "recipes"}}
        yield SCENE, {**beside, SCENE: scene}


_USES = ("convex_mesh", "convex_parts", "triangle_mesh", "mesh")


def _mesh_scene(name: str, use: str) -> str:
    more = ", decomposition: none" if use == "convex_parts" else ""
    shapes, body = ("visuals", "none") if use == "mesh" else ("collisions", "static")
    return f"scenecc: 1\nentities:\n  a: {{body_type: {body}, {shapes}: [{{type: {use}, file: {name}{more}}}]}}\n"


OBJ = """# a box with everything
mtllib a.mtl
o box
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1 0.5 0.5 1
v 1 -1 1
v 1 1 1
v -1 1 1 1.0
vt 0 0
vt 1 0 0
vt 1 1
vn 0 0 -1
vn 0 0 1
vn 1 0 0
usemtl red
s 1
f 1/1/1 3/3/1 2/2/1
f 1/1 4 3/3
f 5//2 6//2 7//2 8//2
g sides
f -8 -7 -3 -4
s off
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
l 1 2 3
p 4
"""
MTL = "newmtl red\nKa 0 0 0\nKd 0.8 0.1 0.1\nKs 0 0 0\nNs 10\nd 1\nillum 2\nmap_Kd -s 1 1 1 a.png\n"


def _gltf(points: np.ndarray, faces: np.ndarray, picture: bytes) -> bytes:
    """A GLB with normals, colours, texture coordinates, sparse values, a strided view, and a texture."""
    document, body = gltf_document(points, faces)
    count = len(points)

    def add(data: bytes, kind: int, width: str, rows: int = count, **more: object) -> int:
        nonlocal body
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(body), "byteLength": len(data)})
        view = len(document["bufferViews"]) - 1
        document["accessors"].append({"bufferView": view, "componentType": kind, "count": rows, "type": width, **more})
        body += data + bytes(-len(data) % 4)
        return len(document["accessors"]) - 1

    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    attributes["NORMAL"] = add(np.tile([0, 0, 1], (count, 1)).astype("<f4").tobytes(), 5126, "VEC3")
    attributes["TANGENT"] = add(np.tile([0, 1, 0, 1], (count, 1)).astype("<f4").tobytes(), 5126, "VEC4")
    attributes["TEXCOORD_0"] = add(np.zeros((count, 2), "<u2").tobytes(), 5123, "VEC2", normalized=True)
    attributes["COLOR_0"] = add(np.zeros((count, 4), "u1").tobytes(), 5121, "VEC4", normalized=True)
    where = add(np.arange(2, dtype="<u2").tobytes(), 5123, "SCALAR", 2)
    what = add(points[:2].astype("<f4").tobytes(), 5126, "VEC3", 2)
    document["accessors"][0]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": document["accessors"][where]["bufferView"], "componentType": 5123},
        "values": {"bufferView": document["accessors"][what]["bufferView"]},
    }
    view = document["accessors"][add(picture, 5121, "SCALAR", len(picture))]["bufferView"]
    document["images"] = [{"bufferView": view, "mimeType": "image/png"}]
    document["samplers"] = [{"magFilter": 9729, "wrapS": 10497}]
    document["textures"] = [{"source": 0, "sampler": 0}]
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.5}}]
    document["meshes"][0]["primitives"][0]["material"] = 0
    document["nodes"] = [
        {"children": [1], "translation": [0, 0, 1]},
        {"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 2, 1], "name": "a"},
    ]
    document["buffers"] = [{"byteLength": len(body)}]
    return glb(document, body)


def _meshes() -> Iterator[tuple[str, Files]]:
    from unit.assets.test_mesh_dae import DAE  # the COLLADA that its checks are held to

    points = POINTS * 10
    files: dict[str, str | bytes] = {
        "a.obj": OBJ,
        "small.obj": TETRA.replace("0.1", "1"),
        "a.stl": stl(points),
        "text.stl": stl_text(points),
        "a.ply": ply(points),
        "text.ply": ply(points, kind="ascii"),
        "big.ply": ply(points, kind="binary_big_endian"),
        "full.ply": _full_ply(),
        "a.glb": glb(*gltf_document(points)),
        "full.glb": _gltf(points, FACES, picture("PNG", "RGB", 4, 4)),
        "a.dae": DAE,
    }
    beside: Files = {"a.mtl": MTL, "a.png": picture("PNG", "RGB", 4, 4)}
    for name, data in files.items():
        for use in _USES:
            if use == "mesh" or not name.endswith(".dae"):
                yield name, {**(beside if name == "a.obj" else {}), name: data, SCENE: _mesh_scene(name, use)}
    yield "a.mtl", {**beside, "a.obj": OBJ, SCENE: _mesh_scene("a.obj", "mesh")}


def _full_ply() -> str:
    head = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "s", "t"))
    rows = "0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n0 0 1 0 0 1 1 1\n"
    return (
        f"ply\nformat ascii 1.0\ncomment x\nelement vertex 4\n{head}element face 3\n"
        f"property list uchar int vertex_indices\nproperty uchar red\nelement edge 1\nproperty int vertex1\n"
        f"end_header\n{rows}3 0 1 2 9\n4 0 1 2 3 8\n3 1 2 3 7\n0\n"
    )


def _images() -> Iterator[tuple[str, Files]]:
    kept = {"a.exr": exr(5, 3), "a.ktx": ktx(8, 4, levels=4), "2.ktx": ktx2(8, 4), "zlib.ktx": ktx2(8, 4, packed=True)}
    files = PICTURES | kept
    for name, data in files.items():
        scene = (
            f"scenecc: 1\nmaterials: {{m: {{visual: {{base_color_texture: {name}}}}}}}\n"
            "entities: {a: {body_type: none, visuals: [{type: sphere, radius: 1, material: m}]}}\n"
        )
        yield name, {name: data, SCENE: scene}


def _robots(key: str, suffix: str, cases: dict[str, str], paths: list[Path]) -> Iterator[tuple[str, Files]]:
    name = f"robot{suffix}"
    beside: Files = {"part.obj": TETRA, "pack/meshes/part.stl": stl(), "meshes/rock.obj": TETRA}
    beside |= dict.fromkeys(("wood.png", "maps/wood.png"), picture("PNG", "RGB"))
    scene = f"scenecc: 1\nentities: {{robot: {{{key}: {name}}}}}\n"
    for text in [*cases.values(), *(path.read_text() for path in paths)]:
        yield name, {**beside, name: text, SCENE: scene}


def _urdf() -> Iterator[tuple[str, Files]]:
    good = _ROOT / "tests/scenes/good/articulations"
    paths = [_ROOT / "scenes/robots/arm.urdf", *sorted(good.glob("*.urdf"))]
    yield from _robots("urdf", ".urdf", {name: urdf for name, (urdf, _) in urdf_cases.CASES.items()}, paths)


def _srdf() -> Iterator[tuple[str, Files]]:
    for urdf, srdf in urdf_cases.CASES.values():
        if srdf is not None:
            for name, files in _robots("urdf", ".urdf", {"": urdf}, []):
                yield "robot.srdf", {**files, "robot.srdf": srdf, name: urdf}


def _mjcf() -> Iterator[tuple[str, Files]]:
    yield from _robots("mjcf", ".xml", mjcf_cases.CASES, [_ROOT / "tests/scenes/good/articulations/swing.xml"])


_SMALL = [_ROOT / f"scenes/{name}.yaml" for name in ("stack", "tray", "robot_arm", "include", "variation")]
"""Scenes that are built in little time."""


def _packs() -> Iterator[tuple[str, Files]]:
    """Whole archives, which nearly any change breaks, and the files of one, of which an archive is made."""
    for scene in _SMALL:
        pack = pack_scene(scene).content
        yield PACK, {PACK: pack}
        with zipfile.ZipFile(io.BytesIO(pack)) as archive:
            files: Files = {f"{UNPACKED}/{name}": archive.read(name) for name in archive.namelist()}
        yield f"{UNPACKED}/.scenecc/manifest.json", files


def _passports() -> Iterator[tuple[str, Files]]:
    for scene in _SMALL:
        with load_scene(scene, num_scenes=2, render=False) as batch:
            passport = json.loads(batch.passport(1))
        beside = {path.name: path for path in scene.parent.iterdir() if path.name not in {"maniskill", "recipes"}}
        yield PASSPORT, {**beside, PASSPORT: json.dumps({**passport, "file": scene.name})}


_CORPORA: dict[str, Callable[[], Iterator[tuple[str, Files]]]] = {
    "yaml": _scenes,
    "mesh": _meshes,
    "image": _images,
    "urdf": _urdf,
    "srdf": _srdf,
    "mjcf": _mjcf,
    "sdf": import_corpus.sdf_worlds,
    "usd": import_corpus.usd_stages,
    "mjcf_import": import_corpus.mjcf_robots,
    "urdf_import": import_corpus.urdf_robots,
    "msh": import_corpus.mujoco_meshes,
    "pack": _packs,
    "passport": _passports,
}
TARGETS = tuple(_CORPORA)


def copy_of(seed: Seed, folder: Path, data: bytes) -> None:
    """A seed's folder with other data in its mutated file. No links: they change what they link."""
    shutil.copytree(seed.folder, folder, copy_function=shutil.copyfile)
    (folder / seed.name).write_bytes(data)
