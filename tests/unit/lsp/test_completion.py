"""What may be typed, by the place of the cursor."""

import pytest
from plugins.editor import ARM, Editor

HEAD = "scenecc: 1\n"

TABLE = (
    HEAD + "params: {length: {type: number, default: 1, description: 'of a side [m]'}}\nentities: {top: {}, leg: {}}\n"
)

SCENE = """scenecc: 1
params: {size: 0.1, count: {type: integer, default: 2}}
draws: {shift: {uniform: [0, 1]}}
materials: {oak: {physical: {density: 700}}}
collision_groups: {debris: {}}
frames: {corner: {pose: [1, 0, 0]}}
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  cube:
    pose: [0, 0, 1]
    shapes: [{type: box, half_size: [1, 1, 1], material: oak}]
"""

CASES = {
    "sections": (HEAD + "enti¦", {"entities", "frames"}, {"scenecc", "half_size"}),
    "keys of a body": (SCENE + "    ¦", {"mass", "linear_damping", "if"}, {"pose", "use", "half_size"}),
    "keys of a new entity": (SCENE + "  b:\n    ¦", {"mass", "use", "urdf", "variants"}, {"with"}),
    "keys of an instance": (SCENE + "  one:\n    use: table.yaml\n    ¦", {"with", "override"}, {"mass"}),
    "keys of a shape": (SCENE + "    visuals:\n      - type: sphere\n        ¦", {"radius"}, {"half_size", "type"}),
    "keys in braces": (SCENE + "    visuals: [{type: capsule, ¦", {"radius", "half_length", "axis"}, {"half_size"}),
    "keys of a pose": (SCENE + "  b:\n    pose:\n      ¦", {"rpy_deg", "relative_to", "uniform"}, {"mass"}),
    "types of shapes": (SCENE + "    visuals: [{type: ¦", {"box", "mesh"}, {"convex_parts"}),
    "types of bodies": (SCENE + "    body_type: ¦", {"static", "kinematic"}, {"box"}),
    "true and false": (SCENE + "    hidden: ¦", {"true", "false"}, set()),
    "frames to stand in": (SCENE + "  b:\n    pose: {relative_to: ¦", {"cube", "corner", "world"}, {"b", "oak"}),
    "entities to stand on": (SCENE + "  b:\n    place: {on: ¦", {"cube", "ground"}, {"world", "oak"}),
    "materials": (SCENE + "    material: ¦", {"oak"}, {"cube"}),
    "groups": (SCENE + "    collision_group: ¦", {"debris"}, {"oak"}),
    "variables": (SCENE + '    mass: "${s¦', {"size", "count", "shift", "scene", "sqrt"}, {"cube", "mass"}),
    "loop variables": (SCENE + '  b:\n    repeat: {i: [1, 2]}\n    mass: "${¦', {"i", "size"}, set()),
    "prefabs and files": (SCENE + "  b:\n    use: ¦", {"scenecc:table", "table.yaml"}, {"arm.urdf", "a.yaml"}),
    "files of a folder": (SCENE + "  b:\n    use: parts/¦", {"parts/leg.yaml"}, {"table.yaml", "parts/notes.yaml"}),
    "robots": (SCENE + "  b:\n    urdf: ¦", {"arm.urdf", "parts/"}, {"table.yaml"}),
    "robots that differ": (SCENE + "  b:\n    urdf: {cycle: [¦", {"arm.urdf"}, {"table.yaml"}),
    "meshes": (SCENE + "    visuals: [{type: mesh, file: ¦", {"mug.obj"}, {"oak.png", "arm.urdf"}),
    "images": (HEAD + "environment: {map: ¦", {"oak.png"}, {"mug.obj"}),
    "images of a material": (HEAD + "materials: {a: {visual: {normal_texture: {file: ¦", {"oak.png"}, {"mug.obj"}),
    "materials of shapes without a type": (SCENE + "    visuals: [{material: ¦", {"oak"}, {"cube"}),
    "regions": (SCENE + "  b:\n    place: {on: ground, region: ¦", {"corner"}, {"cube"}),
    "what a placed entity is near": (SCENE + "  b:\n    place: {near: {¦", {"cube"}, {"oak"}),
    "groups to ignore": (HEAD + "collision_groups:\n  a: {}\n  b: {ignore: [¦", {"a"}, set()),
    "names that vary": (SCENE + "    material: {choice: [¦", {"oak"}, {"cube"}),
    "exceptions": (SCENE + "expect: {no_overlap: {except: [[cube, ¦", {"ground"}, {"oak"}),
    "an overridden material": (
        SCENE + "  b:\n    use: scenecc:bin\n    override: {bin: {shapes: {0: {material: ¦",
        {"oak"},
        {"cube"},
    ),
    "what leaves an object out": (SCENE + "  b: {use: table.yaml, override: {leg: ¦", {"remove"}, {"cube"}),
    "words in a form": (SCENE + "    body_type: {choice: [static, ¦", {"kinematic"}, {"oak"}),
    "words by scene": (SCENE + "    body_type: {per_scene: {0: ¦", {"kinematic"}, {"oak"}),
    "joints of a robot that was never built": (SCENE + "  b: {urdf: arm.urdf, joints: {¦", {"wrist"}, {"hand"}),
    "links of a robot that was never built": (
        SCENE + "  b: {urdf: arm.urdf}\n  c: {pose: {relative_to: b/¦",
        {"b/hand"},
        {"b/wrist"},
    ),
    "joints of a tree": (
        SCENE + "  b:\n    root: {name: x, children: [{name: y, joint: {name: z}}]}\n    qpos: {¦",
        {"z"},
        {"y"},
    ),
    "links of an overridden robot": (
        SCENE + "  b:\n    use: robot.yaml\n    override:\n      r:\n        links:\n          ¦",
        {"hand"},
        {"wrist"},
    ),
    "keys of a part": (SCENE + "  b: {urdf: arm.urdf, attach: {g: {¦", {"to", "urdf", "root"}, {"mass"}),
    "where a part is attached": (SCENE + "  b: {urdf: arm.urdf, attach: {g: {to: ¦", {"hand"}, {"wrist"}),
    "joints of a part": (
        SCENE + "  b: {urdf: x.urdf, attach: {g: {urdf: arm.urdf, to: x, qpos: {¦",
        {"wrist"},
        {"hand"},
    ),
    "functions of an expectation": (SCENE + 'expect: {holds: [{that: "${¦', {"position", "tilt", "sqrt"}, {"cube"}),
    "names in an expectation": (SCENE + "expect: {holds: [{that: \"${touching('cube', '¦", {"ground"}, {"size"}),
    "joints in an expectation": (
        SCENE + "  b: {urdf: arm.urdf}\nexpect: {holds: [{that: \"${qpos('b', 'w¦",
        {"wrist"},
        {"cube"},
    ),
    "arguments of any name": (SCENE + "  b:\n    use: table.yaml\n    with: {parent: ¦", set(), {"cube"}),
    "parameters of a prefab": (SCENE + "  b:\n    use: table.yaml\n    with: {¦", {"length"}, {"size"}),
    "words of a parameter": (SCENE + "  b:\n    use: scenecc:table\n    with: {body_type: ¦", {"static"}, {"box"}),
    "inside of a prefab": (SCENE + "  b:\n    use: table.yaml\n    override: {¦", {"top", "leg"}, {"cube"}),
    "keys of what is overridden": (
        SCENE + "  b:\n    use: table.yaml\n    override: {top: {mass: 1, ¦",
        {"color", "linear_damping"},
        {"mass", "top"},
    ),
    "keys of an overridden shape": (
        SCENE + "  b:\n    use: scenecc:bin\n    override: {bin: {shapes: {0: {¦",
        {"material", "half_size"},
        {"mass"},
    ),
    "nothing in a comment": (SCENE + "    # ¦", set(), {"mass"}),
    "nothing in text": (HEAD + "description: |\n  enti¦", set(), {"entities"}),
}


def editor(folder, text):
    closed = {
        "table.yaml": TABLE,
        "parts/leg.yaml": HEAD,
        "parts/notes.yaml": "notes: 1\n",
        "robot.yaml": HEAD + "entities: {r: {urdf: arm.urdf}}\n",
        "arm.urdf": ARM,
        "mug.obj": "",
        "oak.png": "",
    }
    return Editor(folder, {"a.yaml": text}, closed)


@pytest.mark.parametrize("case", CASES)
def test_completions_fit_the_position(case, tmp_path):
    text, offered, others = CASES[case]
    labels = set(editor(tmp_path, text).labels())
    assert offered <= labels
    assert not others & labels


def test_keys_come_with_their_description_and_default(tmp_path):
    offers = {offer.label: offer for offer in editor(tmp_path, SCENE + "    linear¦").offers()}
    assert offers["linear_velocity"].text == "linear_velocity: "
    assert "[m/s]" in offers["linear_velocity"].description
    assert "Default: `[0, 0, 0]`" in offers["linear_velocity"].description


def test_a_completion_replaces_the_typed_text(tmp_path):
    offers = editor(tmp_path, SCENE + "    body_type: sta¦").offers()
    assert {offer.start for offer in offers} == {len("    body_type: ")}


def test_a_value_after_a_colon_gets_its_space(tmp_path):
    assert " static" in {offer.text for offer in editor(tmp_path, SCENE + "    body_type:¦").offers()}


def test_parameters_come_with_type_and_default(tmp_path):
    offers = editor(tmp_path, SCENE + "  b:\n    use: table.yaml\n    with: {¦").offers()
    described = next(offer.description for offer in offers if offer.label == "length")
    assert described == "number, default 1: of a side [m]"


def test_links_and_joints_are_those_of_the_last_scene_without_errors(tmp_path):
    text = SCENE + "  robot: {urdf: arm.urdf}\n"
    made = editor(tmp_path, text)
    made.type("a.yaml", text + "cameras:\n  eye: {mount: robot/¦")
    assert {"robot/base", "robot/hand"} <= set(made.labels())
    made.type("a.yaml", text.replace("arm.urdf}", "arm.urdf, drives: {¦"))
    assert "wrist" in made.labels()
    made.type("a.yaml", text.replace("arm.urdf}", "arm.urdf, links: {¦"))
    assert "hand" in made.labels()


def test_names_come_from_included_files_as_they_are_typed(tmp_path):
    part = HEAD + "entities: {lamp: {shapes: [{type: box, half_size: [1, 1, 1]}]}}\n"
    text = HEAD + "include: [part.yaml]\nentities:\n  b:\n    pose: {relative_to: ¦"
    made = Editor(tmp_path, {"a.yaml": text, "part.yaml": part})
    assert "lamp" in made.labels()
    made.type("part.yaml", part.replace("lamp", "torch"))
    assert "torch" in made.labels()
    assert "lamp" not in made.labels()


def test_completion_lists_no_outside_folders(tmp_path):
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "hidden.yaml").write_text(HEAD)
    (tmp_path / "in").mkdir()
    for reference in ("../secret/", "/", "~/", "../"):
        assert Editor(tmp_path / "in", {"a.yaml": SCENE + f"  b:\n    use: {reference}¦"}).labels() == []


def test_names_with_the_typed_prefix_come_first(tmp_path):
    many = "".join(f"  b{i}: {{pose: [0, 0, {i}]}}\n" for i in range(1500))
    offers = editor(tmp_path, SCENE + many + "  x: {pose: {relative_to: b149¦").labels()
    assert offers[0] == "b149"
    assert set(offers[:11]) == {"b149", *(f"b149{i}" for i in range(10))}


def test_a_long_text_gets_no_completions(tmp_path):
    text = SCENE + "# " + "x" * 2**20 + "\n" + "    ¦"
    assert editor(tmp_path, text).labels() == []
