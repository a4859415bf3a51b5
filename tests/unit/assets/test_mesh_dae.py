"""COLLADA: what is read as the engine reads it, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from plugins.mesh_files import codes, diagnose, named, write
from unit.assets.test_assets import png

from scenecc.assets.files import AssetFiles
from scenecc.plan.body import AssetFile

TRIANGLES = '<triangles count="4">{input}<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles>'
INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'
EFFECT = (
    '<library_images><image id="i"><init_from>a b.png</init_from></image></library_images><library_effects>'
    '<effect id="e"><profile_COMMON><newparam sid="surface"><surface type="2D"><init_from>i</init_from></surface>'
    '</newparam><newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>'
    '<technique sid="common"><phong><diffuse><texture texture="sampler" texcoord="uv"/></diffuse></phong></technique>'
    '</profile_COMMON></effect></library_effects><library_materials><material id="m"><instance_effect url="#e"/>'
    "</material></library_materials>"
)
DAE = (
    '<?xml version="1.0" encoding="utf-8"?>\n'
    '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
    '<asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>'
    '<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">'
    "0 0 0 10 0 0\n0 20 0 0 0 30</float_array><technique_common>"
    '<accessor source="#a" count="4" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor>'
    '</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
    + TRIANGLES.format(input=INPUT)
    + '</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n">'
    '<translate>1 0 0</translate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>'
    '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
)


def triangles_of(path: Path) -> list[np.ndarray]:
    """The corners (n, 3, 3) of each part of a file [m]."""
    parts = AssetFiles(lambda name, _: ("SC401", name, None), 2**20).triangles(AssetFile(path.name, path))
    return [vertices[faces] for vertices, faces in parts]


def dae(*changes: tuple[str, str]) -> str:
    text = DAE
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def primitive(tag: str, count: int, inside: str) -> tuple[str, str]:
    return TRIANGLES.format(input=INPUT), f'<{tag} count="{count}">{INPUT}{inside}</{tag}>'


NODE = '<instance_geometry url="#g"/></node></visual'
LIBRARY = "<library_visual_scenes>"
READ: dict[str, tuple[str, int]] = {
    "triangles": (DAE, 4),
    "a newer version": (dae(("1.4.1", "1.5.0")), 4),
    "no leading digit": (dae(("10 0 0\n", "10. .0 1e-3\n")), 4),
    "polylist": (dae(primitive("polylist", 2, "<vcount>4 3</vcount><p>0 1 2 3 0 1 2</p>")), 3),
    "polygons": (dae(primitive("polygons", 2, "<p>0 1 2 3</p><p>0 1 3</p>")), 3),
    "strips": (dae(primitive("tristrips", 1, "<p>0 1 2 3</p>")), 2),
    "fans": (dae(primitive("trifans", 1, "<p>0 1 2 3</p>")), 2),
    "a node of the library": (
        dae(
            (NODE, '<instance_node url="#q"/><instance_node url="#q"/></node></visual'),
            (
                LIBRARY,
                f'<library_nodes><node id="q"><instance_geometry url="#g"/></node></library_nodes>{LIBRARY}',
            ),
        ),
        8,
    ),
}


@pytest.mark.parametrize("name", READ)
def test_valid_collada_files_are_read(tmp_path: Path, name: str) -> None:
    text, triangles = READ[name]
    path = write(tmp_path, "a.dae", text)
    assert codes(path, "visual") == []
    assert sum(map(len, triangles_of(path))) == triangles


def test_collada_poses_and_units_are_applied_but_not_the_up_axis(tmp_path: Path) -> None:
    """As SAPIEN has the vertices of the same file."""
    turn = "<rotate>0 0 1 90</rotate><scale>1 2 1</scale><matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</matrix>"
    (part,) = triangles_of(write(tmp_path, "a.dae", dae(("</translate>", "</translate>" + turn))))
    corners = np.array([[0.01, 0.05, 0], [0.01, 0.15, 0], [-0.39, 0.05, 0], [0.01, 0.05, 0.3]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    assert np.allclose(part, corners[faces], atol=1e-7)
    (plain,) = triangles_of(write(tmp_path, "b.dae", DAE))
    corners = np.array([[0.01, 0, 0], [0.11, 0, 0], [0.01, 0.2, 0], [0.01, 0, 0.3]])
    assert np.allclose(plain, corners[faces], atol=1e-7)


def nested(depth: int) -> str:
    """Nodes of the library that each place the next one twice."""
    nodes = "".join(
        f'<node id="n{i}"><instance_node url="#n{i + 1}"/><instance_node url="#n{i + 1}"/></node>' for i in range(depth)
    )
    last = f'<node id="n{depth}"><instance_geometry url="#g"/></node>'
    return dae(
        (NODE, '<instance_node url="#n0"/></node></visual'),
        (LIBRARY, f"<library_nodes>{nodes}{last}</library_nodes>{LIBRARY}"),
    )


CIRCLE = dae(
    (NODE, '<instance_node url="#q"/></node></visual'),
    (LIBRARY, f'<library_nodes><node id="q"><instance_node url="#q"/></node></library_nodes>{LIBRARY}'),
)
SCENE = '<scene><instance_visual_scene url="#s"/></scene>'
BROKEN: dict[str, tuple[str, str]] = {
    "empty": ("", "SC412"),
    "words": ("a mesh", "SC412"),
    "another root": ("<robot/>", "SC412"),
    "cut": (DAE[:700], "SC412"),
    "document type": (dae(("<COLLADA", "<!DOCTYPE COLLADA [<!ENTITY a 'b'>]><COLLADA")), "SC412"),
    "a word": (dae(("10 0 0", "x 0 0")), "SC412"),
    "comma": (dae(("10 0 0", "1,0 0 0")), "SC412"),
    "infinite": (dae(("10 0 0", "-INF 0 0")), "SC414"),
    "beyond float32": (dae(("10 0 0", f"1{'0' * 17}e29 0 0")), "SC414"),
    "far away": (dae(("10 0 0", "1e10 0 0")), "SC417"),
    "too few numbers": (dae(("0 0 30<", "0 0<")), "SC412"),
    "two coordinates": (dae(('<param name="Z"/>', "")), "SC412"),
    "index": (dae(("2 0 3<", "2 0 9<")), "SC412"),
    "negative index": (dae(("2 0 3<", "2 0 -1<")), "SC412"),
    "lines": (dae(primitive("lines", 2, "<p>0 1 2 3</p>")), "SC413"),
    "nothing shown": (dae(('<instance_geometry url="#g"/>', "")), "SC413"),
    "no scene": (dae((SCENE, "")), "SC412"),
    "another file's geometry": (dae(('"#g"', '"../b.dae#g"')), "SC412"),
    "geometry that is not there": (dae(('"#g"', '"#h"')), "SC412"),
    "itself": (dae((NODE, '<instance_node url="#n"/>' + NODE)), "SC412"),
    "circle": (CIRCLE, "SC412"),
    "two of one id": (dae(('<geometry id="g">', '<geometry id="g"/><geometry id="g">')), "SC412"),
    "no unit": (dae(('"0.01"', '"0"')), "SC412"),
    "unit": (dae(('"0.01"', '"x"')), "SC412"),
    "place": (dae(("<translate>1 0 0", "<translate>NaN 0 0")), "SC414"),
    "short place": (dae(("<translate>1 0 0", "<translate>1 0")), "SC412"),
    "skew": (dae(("<translate>1 0 0</translate>", "<skew>1 0 0 0 0 1 0</skew>")), "SC412"),
    "skin": (dae(('<instance_geometry url="#g"/>', '<instance_controller url="#g"/>')), "SC412"),
    "doubling": (nested(40), "SC607"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_invalid_collada_files_are_refused(tmp_path: Path, name: str) -> None:
    text, code = BROKEN[name]
    assert codes(write(tmp_path, "a.dae", text), "visual") == [code]


def test_a_collada_can_collide(tmp_path: Path) -> None:
    path = write(tmp_path, "a.DAE", DAE)
    for use in ("hull", "parts", "triangles", "decomposed"):
        assert codes(path, use) == [], use
    flat = write(tmp_path, "flat.dae", dae(("0 0 30<", "5 5 0<")))
    for use in ("hull", "parts"):
        assert codes(flat, use) == ["SC415"], use
    (told,) = diagnose(flat, "hull", "visual")
    assert told.path == "bodies[0].file"


def test_collada_parts_with_equal_vertices_are_merged(tmp_path: Path) -> None:
    """Each triangle has corners of its own, and the four enclose a solid."""
    points = dict(enumerate(["0 0 0", "10 0 0", "0 20 0", "0 0 30"]))
    corners = " ".join(points[i] for i in (0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3))
    loose = dae(
        ("0 0 0 10 0 0\n0 20 0 0 0 30", corners),
        ('count="12"', 'count="36"'),
        ('count="4" stride', 'count="12" stride'),
        ("0 2 1 0 1 3 1 2 3 2 0 3<", " ".join(map(str, range(12))) + "<"),
    )
    assert codes(write(tmp_path, "a.dae", loose), "parts") == []


def painted(folder: Path, *changes: tuple[str, str]) -> Path:
    return write(folder, "a.dae", dae(("<library_geometries>", EFFECT + "<library_geometries>"), *changes))


def test_collada_images_are_found(tmp_path: Path) -> None:
    write(tmp_path, "secret.png", png())
    folder = tmp_path / "scene"
    folder.mkdir()
    assert codes(painted(folder), "visual") == ["SC418"]
    image = write(folder, "a b.png", b"hello")
    assert codes(painted(folder), "visual") == ["SC420"]
    write(folder, "a b.png", png())
    path = painted(folder)
    assert codes(path, "visual") == []
    assert named(path) == {"a b.png": image}
    # SAPIEN decodes the escapes of a COLLADA.
    assert codes(painted(folder, ("a b.png", "a%20b.png")), "visual") == []
    assert named(path) == {"a b.png": image}
    for outside in ("../secret.png", "%2e%2e/secret.png", "file:///etc/a.png", "/etc/a.png"):
        assert codes(painted(folder, ("a b.png", outside)), "visual") == ["SC419"], outside
    for name in ("100%.png", "a%00b.png"):
        assert codes(painted(folder, ("a b.png", name)), "visual") == ["SC412"], name


def test_a_collada_texture_must_lead_to_an_image(tmp_path: Path) -> None:
    """Else SAPIEN opens a file of the texture's name, wherever that is."""
    write(tmp_path, "a b.png", png())
    write(tmp_path, "stray.jpg", b"")
    for change in (
        ('texture="sampler"', 'texture="../stray"'),
        ("<source>surface<", "<source>stray<"),
        ("<source>surface<", "<source>sampler<"),
        ("profile_COMMON", "profile_GLSL"),
        ('version="1.4.1"', 'version="1.5.0"'),
        # What follows leads to an image here, and to another file in SAPIEN's reader.
        ('version="1.4.1"', 'version="1.7.0"'),
        ('version="1.4.1"', ""),
        ("</surface>", '</surface><surface type="2D"><init_from>../stray</init_from></surface>'),
        ("<source>surface</source>", '<source>surface</source><instance_image url="#../stray"/>'),
        ("</profile_COMMON>", '<extra><newparam sid="sampler"/></extra></profile_COMMON>'),
        ('<newparam sid="surface">', '<newparam sid="surface"><init_from>i</init_from></newparam><newparam sid="x">'),
        ("<init_from>i</init_from>", "<init_from> i </init_from>"),
        (
            '<newparam sid="sampler">',
            '<x:newparam xmlns:x="http://www.collada.org/2005/11/COLLADASchema" sid="sampler">',
        ),
    ):
        assert codes(painted(tmp_path, change), "visual") == ["SC412"], change
    assert codes(painted(tmp_path, ('texture="sampler"', 'texture="i"')), "visual") == []
    assert codes(painted(tmp_path, ("<init_from>a b.png<", "<init_from><")), "visual") == ["SC410"]
    newer = (
        ('version="1.4.1"', 'version="1.5.0"'),
        ("<init_from>a b.png</init_from>", "<init_from><ref>a b.png</ref></init_from>"),
        ("<source>surface</source>", '<instance_image url="#i"/>'),
        ('<newparam sid="surface"><surface type="2D"><init_from>i</init_from></surface></newparam>', ""),
    )
    assert codes(painted(tmp_path, *newer), "visual") == []


def test_a_collada_in_another_encoding_is_refused(tmp_path: Path) -> None:
    write(tmp_path, "\xe9.png", png())
    for encoding, code in (("utf-8", []), ("latin1", ["SC412"])):
        path = painted(tmp_path, ('encoding="utf-8"', f'encoding="{encoding}"'), ("a b.png", "\xe9.png"))
        assert codes(path, "visual") == code


def test_collada_geometry_with_unreadable_effects_is_kept(tmp_path: Path) -> None:
    """pycollada leaves out a node whose effect it cannot read."""
    path = painted(tmp_path, ('<surface type="2D">', '<surface type="CUBE">'))
    write(tmp_path, "a b.png", png())
    assert [len(part) for part in triangles_of(path)] == [4]


@pytest.mark.render
@pytest.mark.parametrize("name", READ)
def test_sapien_shows_the_triangles_of_a_collada(tmp_path: Path, name: str) -> None:
    sapien = pytest.importorskip("sapien")
    path = write(tmp_path, "a.dae", READ[name][0])
    shown = [part.vertices[part.triangles] for part in sapien.render.RenderShapeTriangleMesh(str(path)).parts]
    mine, engines = (
        sorted(map(sorted, np.concatenate(each).round(5).tolist())) for each in (triangles_of(path), shown)
    )
    assert np.allclose(mine, engines, atol=1e-5)
