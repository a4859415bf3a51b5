"""`python -m tests.fuzz.hulls 0 2000`: builds random colliding meshes and lets them touch the ground, one line a case.

A line is the number and the kind of a case, then how it ends: the code that refuses it, or `built`, the number of
contacts, and its mass by that of the solid in the file (`-` where no solid is known, or a warning says that PhysX cooks
another one).
"""

from __future__ import annotations

import contextlib
import io
import os
import resource
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

sys.path.insert(0, str(Path(__file__).parents[1]))

from plugins.mesh_files import ply, stl

KINDS = ("plain", "oblong", "sliver", "huge", "tiny", "far", "doubled", "degenerate", "words", "parts", "few", "solids")
USES = ("convex_mesh", "convex_parts", "urdf", "urdf parts", "mjcf", "triangle_mesh", "sdf", "static", "coacd")
_CHANCES = np.array([4, 3, 4, 2, 4, 1, 1, 1, 0.1])
STEPS = 20


def solid(draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Corners and triangles of a convex solid of about 1 m."""
    match draw.integers(4):
        case 0:
            made = trimesh.creation.box()
        case 1:
            made = trimesh.creation.cylinder(0.5, 1, sections=int(draw.integers(3, 70)))
        case 2:
            made = trimesh.creation.cone(0.5, 1, sections=int(draw.integers(3, 70)))
        case _:
            made = trimesh.creation.icosphere(int(draw.integers(0, 3)), 0.5)
    return np.array(made.vertices), np.array(made.faces)


def bent(kind: str, points: np.ndarray, faces: np.ndarray, draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """What a kind makes of a solid."""
    aspects = 10 ** draw.uniform(0, 4, 2) if kind == "oblong" else 10 ** draw.uniform(0, 0.5, 2)
    points = points / np.array([1, *aspects])
    if kind == "sliver":
        points[:, 2] *= 10 ** draw.uniform(-9, -1)
    if draw.random() < 0.7:
        points = points @ np.linalg.qr(draw.normal(size=(3, 3)))[0]
    low, high = {"huge": (2, 14), "tiny": (-10, -2)}.get(kind, (-1.5, 1.5))
    points = points * 10 ** draw.uniform(low, high)
    if kind == "far":
        points = points + draw.normal(size=3) * 10 ** draw.uniform(0, 7)
    if kind == "doubled":
        points = np.concatenate([points, points * (1 - 10 ** draw.uniform(-9, -4))])
        faces = np.concatenate([faces, faces + len(points) // 2])
    if kind == "degenerate":
        faces = np.concatenate(
            [faces, np.repeat(draw.integers(0, len(points), (5, 1)), 3, axis=1), faces[:2, [0, 1, 1]]]
        )
    if kind == "few":
        points, faces = points[:3], np.array([[0, 1, 2]] * int(draw.integers(1, 3)))
    return points, faces


def obj(points: np.ndarray, faces: np.ndarray, more: str = "") -> str:
    corners = "".join("v {:.9g} {:.9g} {:.9g}\n".format(*point) for point in points)
    return more + corners + "".join("f {} {} {}\n".format(*face) for face in faces + 1)


def mesh_file(kind: str, points: np.ndarray, faces: np.ndarray, draw: np.random.Generator) -> tuple[str, bytes]:
    """Name and content."""
    with np.errstate(all="ignore"):
        form = "obj" if kind in {"words", "parts"} else str(draw.choice(["obj", "stl", "ply"]))
        if form == "stl":
            return "mesh.stl", stl(points.astype(np.float32), faces)
        if form == "ply":
            return "mesh.ply", ply(points, faces, kind="ascii")
    text = obj(points, faces)
    if kind == "words":
        lines = text.splitlines()
        words = lines[(at := int(draw.integers(len(lines))))].split()
        hostile = ("nan", "inf", "-inf", "1e400", "1e38", "1e20", "-1e-45", "0", "-7", "99999999999", "")
        words[int(draw.integers(1, 4))] = str(draw.choice(hostile))
        text = "\n".join([*lines[:at], " ".join(words), *lines[at + 1 :]]) + "\n"
    if kind == "parts":
        piece = ("", "v 0 0 0\n", "v 0 0 0\nv 1 0 0\nf 1 1 2\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -3\n", "f\n")
        text = f"o a\n{text}o b\n{draw.choice(piece)}"
    return "mesh.obj", text.encode()


def scale_of(use: str, draw: np.random.Generator) -> np.ndarray:
    chance = draw.random()
    if chance < 0.03:
        return np.array([draw.choice([0.0, 1e-30, 1e30, 1e-8, 1e8]), 1, 1])
    scale = np.full(3, 10 ** draw.uniform(-2, 2)) if chance < 0.6 else 10 ** draw.uniform(-1, 1, 3)
    return scale * draw.choice([1, -1], 3) if use in {"urdf", "urdf parts", "mjcf"} or chance < 0.1 else scale


def scene_of(use: str, name: str, scale: np.ndarray, height: float, draw: np.random.Generator) -> dict[str, str]:
    """The files of a scene in which the mesh touches the ground."""
    words = " ".join(f"{one:.9g}" for one in scale)
    listed = words.replace(" ", ", ")
    files: dict[str, str] = {}
    if use.startswith("urdf"):
        mesh = f'<geometry><mesh filename="{name}" scale="{words}"/></geometry>'
        files["r.urdf"] = f'<robot name="r"><link name="l"><collision>{mesh}</collision></link></robot>'
        body = f"urdf: r.urdf, fix_root_link: false{', load_multiple_collisions: true' * use.endswith('parts')}"
    elif use == "mjcf":
        files["r.xml"] = (
            f'<mujoco><asset><mesh name="m" file="{name}" scale="{words}"/></asset><worldbody><body name="b">'
            '<freejoint/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
        )
        body = "mjcf: r.xml"
    else:
        kind = {
            "triangle_mesh": "triangle_mesh",
            "sdf": "triangle_mesh",
            "coacd": "convex_parts",
            "static": "convex_mesh",
        }
        more = {"sdf": ", sdf: true", "coacd": ", decomposition: coacd", "convex_parts": ", decomposition: none"}
        shape = f"{{type: {kind.get(use, use)}, file: {name}, scale: [{listed}]{more.get(use, '')}}}"
        fixed = "body_type: kinematic, " * (use in {"triangle_mesh", "static"})
        body = f"{fixed}collisions: [{shape}]"
    box = f"{{pose: [0, 0, {2 * height + 0.1:.9g}], shapes: [{{type: box, half_size: [0.1, 0.1, 0.1]}}]}}"
    ground = "{body_type: static, shapes: [{type: plane}]}"
    files["scene.yaml"] = (
        f"scenecc: 1\nentities:\n  ground: {ground}\n  a: {{{body}, pose: [0, 0, {height:.9g}]}}\n  box: {box}\n"
    )
    return files


def solids_scene(draw: np.random.Generator) -> dict[str, str]:
    """A cone, a ring or a heightfield, which are cooked meshes too."""
    a, b, c = (10 ** draw.uniform(-7, 4, 3)).tolist()
    shape = (
        f"{{type: cone, radius: {a:.9g}, half_length: {b:.9g}}}",
        f"{{type: ring, inner_radius: {a * draw.random():.9g}, outer_radius: {a:.9g}, half_length: {b:.9g}}}",
        f"{{type: heightfield, size: [{a:.9g}, {b:.9g}, {c:.9g}], heights: [[0, 1, 0], [1, 0, 1]]}}",
    )[which := int(draw.integers(3))]
    fixed = "body_type: static, " * (which == 2)
    return {
        "scene.yaml": f"scenecc: 1\nentities:\n  ground: {{body_type: static, shapes: [{{type: plane}}]}}\n"
        f"  a: {{{fixed}shapes: [{shape}], pose: [0, 0, {b:.9g}]}}\n"
    }


def case(number: int) -> tuple[str, dict[str, str | bytes], float | None]:
    """What it is, its files, and the mass of the solid in its mesh [kg]; None: of what has none, or may be broken."""
    draw = np.random.default_rng([7, number])
    kind = KINDS[number % len(KINDS)]
    if kind == "solids":
        return kind, dict(solids_scene(draw)), None
    use = str(draw.choice(USES, p=_CHANCES / _CHANCES.sum()))
    points, faces = bent(kind, *solid(draw), draw)
    scale = scale_of(use, draw)
    name, data = mesh_file(kind, points, faces, draw)
    height = float(-(points * scale)[:, 2].min())
    files: dict[str, str | bytes] = {name: data, **scene_of(use, name, scale, max(-1e5, min(height, 1e5)), draw)}
    volume = abs(trimesh.Trimesh(points - points.mean(axis=0), faces, process=False).volume * np.prod(scale))
    known = kind not in {"words", "parts", "few"} and use not in {"triangle_mesh", "coacd", "static"}
    if kind == "doubled":
        # Two parts, or one where a format joins vertices. MuJoCo weighs both.
        known &= use not in {"convex_parts", "urdf parts", "mjcf"}
        volume /= 2
    return f"{kind}, {use}", files, 1000 * volume if known else None


def outcome(folder: Path, mass: float | None) -> str:
    """How a case ends that ends no process."""
    import scenecc

    try:
        with scenecc.load_scene(folder / "scene.yaml", render=False) as batch:
            scene: Any = batch.scenes[0]
            bodies = [*scene.physx_system.rigid_dynamic_components, *scene.physx_system.articulation_link_components]
            found = [float(body.mass) for body in bodies if body.name in {"a", "l", "b"}]
            contacts = 0
            for _ in range(STEPS):
                batch.step()
                contacts += len(scene.physx_system.get_contacts())
    except scenecc.SceneError as error:
        return next((one.code for one in error.diagnostics if one.severity == "error"), "no code")
    ratio = found[0] / mass if mass and found else 1
    if not mass or not found:
        return f"built {contacts} -"
    return f"built {contacts} {ratio}"


def main() -> None:
    first, end = map(int, sys.argv[1:3])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    lines = os.fdopen(os.dup(1), "w")
    warnings.simplefilter("ignore")
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    for number in range(first, end):
        with tempfile.TemporaryDirectory() as home:
            kind, files, mass = case(number)
            for name, data in files.items():
                (Path(home) / name).write_bytes(data.encode() if isinstance(data, str) else data)
            print(number, kind, sep="\t", end="\t", file=lines, flush=True)
            try:
                told = outcome(Path(home), mass)
            except Exception as error:  # noqa: BLE001 - any at all is a failure
                told = f"{type(error).__name__}: {error}".replace("\n", " ")[:300]
            print(told, file=lines, flush=True)


if __name__ == "__main__":
    with contextlib.redirect_stderr(io.StringIO()):
        main()
