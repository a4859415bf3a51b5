"""Files of other formats for an import: worlds in SDF, stages in USD, and robots and meshes that MuJoCo reads."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from plugins.image_files import picture
from plugins.mesh_files import FACES, POINTS, TETRA, stl

os.environ["PXR_WORK_THREAD_LIMIT"] = (
    "1"  # usd-core is loaded before workers are forked, which threads would not outlive
)

Files = dict[str, str | bytes | Path]
"""What a folder holds, by name; a path: a copy of it."""

_BESIDE: Files = {
    "part.obj": TETRA,
    "pack/meshes/part.stl": stl(),
    "meshes/rock.obj": TETRA,
    "wood.png": picture("PNG", "RGB"),
}


def sdf_worlds() -> Iterator[tuple[str, Files]]:
    from unit.importers.test_sdf import MANY_BOXES, joint, link, model, world

    axis = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>2</upper></limit></axis>"
    two = link("a") + link("b", "0 0 1 0 0 0.3")
    box = "<box><size>0.2 0.4 0.6</size></box>"
    solids = (
        "<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid>",
        "<capsule><radius>0.1</radius><length>0.3</length></capsule>",
        "<mesh><uri>meshes/rock.obj</uri><scale>-1 2 1</scale></mesh>",
        "<polyline><point>0 0</point><point>1 0</point><point>1 1</point><height>1</height></polyline>",
    )
    sensor = (
        '<sensor name="eye" type="camera"><camera><horizontal_fov>1.2</horizontal_fov><image><width>64</width>'
        "<height>48</height></image></camera></sensor></link>"
    )
    sun = '<light name="sun" type="spot"><direction>0 1 -1</direction><diffuse>1 1 0.5 1</diffuse></light>'
    cup = f'<sdf version="1.9"><model name="cup">{link("body")}</model></sdf>'
    inner = f'<model name="inner"><pose>0 1 0 0 0 0</pose>{link("b")}</model>'
    kinds = ("revolute", "prismatic", "fixed", "ball", "universal", "screw")
    texts = [
        *(model(two + joint(kind, "a", "b", axis + axis.replace("axis>", "axis2>"))) for kind in kinds),
        *(model(link("a").replace(box, solid)) for solid in solids),
        model(two + link("c") + "".join(joint("fixed", *ends, name="".join(ends)) for ends in ("ab", "bc", "ca"))),
        model(link("a") + inner + joint("fixed", "a", "inner::b"), rest='placement_frame="a"'),
        model('<frame name="f" attached_to="a"/>' + link("a") + link("b", frame='relative_to="f"')),
        world(sun + "<include><uri>model://cup</uri><name>x</name><pose>1 0 0 0 0 0</pose></include>"),
        model(link("a").replace("</link>", sensor)) + "<!-- a -- b -->",
        model(f"<static>true</static><link name='l'>{MANY_BOXES}</link>"),
    ]  # fmt: skip
    for text in texts:
        yield "source.sdf", {**_BESIDE, "source.sdf": text, "cup/cup.sdf": cup}


def usd_stages() -> Iterator[tuple[str, Files]]:
    from unit.importers import test_usd as usd

    box = f'def Cube "a" ({usd.BODY})\n{{\n{usd.at(0, 0, 1)}}}\n'
    other = box.replace('"a"', '"b"').replace("(0, 0, 1)", "(0, 2, 1)", 1)
    drive = (
        'uniform token physics:axis = "Z"\nfloat drive:angular:physics:stiffness = 5\n'
        "float drive:angular:physics:targetPosition = 90\nfloat physics:lowerLimit = -20\n"
    )
    driven = '"joint" (prepend apiSchemas = ["PhysicsDriveAPI:angular"])'
    mesh = f'def Mesh "m" ({usd.COLLIDER})\n{{\n{usd.TETRAHEDRON}uniform token physics:approximation = "%s"\n}}\n'
    said = "float physics:mass = 2\nfloat3 physics:diagonalInertia = (1, 2, 2.5)\n"
    paint = usd.MATERIALS.replace("FILE", "./wood.png") + box.replace("{", "{\nrel material:binding = </World/paint>\n")
    kinds = ("Revolute", "Prismatic", "Spherical", "Fixed", "Distance")
    texts = [
        *(box.replace("Cube", solid) for solid in ("Cube", "Sphere", "Capsule", "Cone")),
        *(box + other + usd.joint(f"Physics{kind}Joint", "a", "b", drive).replace('"joint"', driven) for kind in kinds),
        *(mesh % how for how in ("none", "convexHull", "boundingCube")),
        f'def Xform "a" ({usd.RIGID})\n{{\n{said}{box}}}\n',
        paint,
        f'def "w" (\ninstanceable = true\nprepend references = @./wheel.usda@\n)\n{{\n}}\n{other}',
    ]  # fmt: skip
    wheel = f'#usda 1.0\n(\ndefaultPrim = "wheel"\n)\ndef Xform "wheel"\n{{\n{mesh % "convexHull"}}}\n'
    for i, text in enumerate(texts):
        stage = f'#usda 1.0\n(\n{usd.HEAD}\n)\ndef Xform "World"\n{{\n{text}\n}}\n'
        yield "source.usda", {**_BESIDE, "wheel.usda": wheel, "source.usda": stage}
        if i % 2:
            layer: Any = import_module("pxr.Sdf").Layer.CreateAnonymous(".usda")
            assert layer.ImportFromString(stage)
            yield "source.usdc", {**_BESIDE, "wheel.usda": wheel, "source.usdc": _crate(layer)}


def _crate(layer: Any) -> bytes:
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        path = Path(folder, "a.usdc")
        layer.Export(str(path))
        return path.read_bytes()


def mjcf_robots() -> Iterator[tuple[str, Files]]:
    from fidelity import mjcf_cases

    for text in mjcf_cases.CASES.values():
        yield "source.xml", {**_BESIDE, "source.xml": text}


def urdf_robots() -> Iterator[tuple[str, Files]]:
    from fidelity import urdf_cases

    root = Path(__file__).parents[2]
    paths = [*root.glob("scenes/robots/*.urdf"), *root.glob("tests/scenes/good/articulations/*.urdf")]
    for text in [*(text for text, _ in urdf_cases.CASES.values()), *(path.read_text() for path in sorted(paths))]:
        yield "source.urdf", {**_BESIDE, "source.urdf": text}


def mujoco_meshes() -> Iterator[tuple[str, Files]]:
    """Meshes and heights that only MuJoCo reads."""
    points, corners = POINTS * 10, FACES.astype("<i4").tobytes()
    counts = len(points), 0, 0, len(FACES)
    msh = struct.pack("<4i", *counts) + points.astype("<f4").tobytes() + corners
    full = (
        struct.pack("<4i", 4, 4, 4, 4)
        + points.astype("<f4").tobytes() * 2
        + points[:, :2].astype("<f4").tobytes()
        + corners
    )
    heights = struct.pack("<2i", 3, 4) + bytes(range(48))
    files = {"a.msh": msh, "full.msh": full, "a.stl": stl(points), "a.obj": TETRA.replace("0.1", "1")}
    for name, data in files.items():
        for more in ("", 'inertia="shell"', 'scale="-1 2 1"', 'maxhullvert="4"'):
            mjcf = (
                f'<mujoco><asset><mesh name="m" file="{name}" {more}/></asset><worldbody><body><freejoint/>'
                '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
            )
            yield name, {name: data, "robot.xml": mjcf, "source.xml": mjcf}
    field = (
        '<mujoco><asset><hfield name="h" file="a.bin" size="1 1 1 .1"/></asset><worldbody>'
        '<geom type="hfield" hfield="h"/></worldbody></mujoco>'
    )
    yield "a.bin", {"a.bin": heights, "source.xml": field}
