"""Definitions, mentions, hovers and outlines, through includes, prefabs and robots' files."""

import re

import pytest
from plugins.editor import ARM, Editor

from scenecc.lsp.edits import RefusedError, applied, rename
from scenecc.lsp.symbols import symbols_of

HEAD = "scenecc: 1\n"
BOX = "shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]"

PREFAB = f"""scenecc: 1
description: A table with two parts.
params:
  length: 1
frames:
  spot: {{pose: [0, 0, "${{length}}"]}}
entities:
  top: {{body_type: static, {BOX}}}
  leg: {{pose: {{p: [0, 0, -1], relative_to: top}}, {BOX}}}
"""

PART = f"""scenecc: 1
params: {{gap: 0.2}}
materials: {{oak: {{physical: {{density: 700}}}}}}
entities:
  lamp: {{{BOX}}}
"""

SCENE = f"""scenecc: 1
include: [part.yaml]
entities:
  ground: {{body_type: static, shapes: [{{type: plane, material: oak}}]}}
  desk:
    use: table.yaml
    with: {{length: 2}}
    override: {{top: {{hidden: true}}}}
  arm: {{urdf: arm.urdf}}
  bulb:
    pose: {{p: ["${{gap}}", 0, 3], relative_to: lamp}}
    {BOX}
  dot:
    repeat: {{i: [1, 2]}}
    pose: ["${{i * gap}}", 0, 5]
    {BOX}
  one: {{pose: {{p: [9, 0, 9], relative_to: desk/top}}, {BOX}}}
  two: {{pose: {{p: [9, 9, 9], relative_to: desk/spot}}, {BOX}}}
  six: {{pose: {{p: [0, 9, 9], relative_to: dot_1}}, {BOX}}}
cameras:
  eye: {{mount: arm/hand}}
expect:
  holds:
    - that: "${{position('bulb')[2] > 0 and position('desk/leg')[2] > -9}}"
"""

FILES = {"a.yaml": SCENE, "part.yaml": PART}
CLOSED = {"table.yaml": PREFAB, "arm.urdf": ARM}


def opened(folder, word, *, file="a.yaml", count=1):
    """The scene with the cursor in a word, counted from 1."""
    texts = {**FILES, **CLOSED}
    places = [match.start() for match in re.finditer(re.escape(word), texts[file])]
    at = places[count - 1] + len(word) - 1
    marked = {name: text[:at] + "¦" + text[at:] if name == file else text for name, text in texts.items()}
    shown = {name: text for name, text in marked.items() if name in FILES or name == file}
    return Editor(folder, shown, {name: text for name, text in marked.items() if name not in shown})


DEFINITIONS = {
    "an entity of an included file": ("relative_to: lamp", "part.yaml", 4, "lamp"),
    "a material of one": ("material: oak", "part.yaml", 2, "oak"),
    "a parameter of one": ('p: ["${gap', "part.yaml", 1, "gap"),
    "a loop variable": ("${i", "a.yaml", 13, "i"),
    "what is inside of an instance": ("desk/top", "table.yaml", 7, "top"),
    "a frame inside of one": ("desk/spot", "table.yaml", 5, "spot"),
    "what is overridden": ("override: {top", "table.yaml", 7, "top"),
    "a parameter of a prefab": ("with: {length", "table.yaml", 3, "length"),
    "a prefab": ("use: table.yaml", "table.yaml", 0, ""),
    "an included file": ("[part.yaml", "part.yaml", 0, ""),
    "a link of a robot": ("arm/hand", "arm.urdf", 2, "<link"),
    "a robot's file": ("urdf: arm.urdf", "arm.urdf", 0, ""),
    "a copy": ("dot_1", "a.yaml", 12, "dot"),
    "an entity in an expectation": ("position('bulb", "a.yaml", 9, "bulb"),
    "one inside of an instance there": ("position('desk/leg", "table.yaml", 8, "leg"),
    "its own key": ("  bulb", "a.yaml", 9, "bulb"),
}


@pytest.mark.parametrize("case", DEFINITIONS)
def test_definitions_of_names_are_found(case, tmp_path):
    word, file, line, text = DEFINITIONS[case]
    assert opened(tmp_path, word).definition() == (file, line, text)


def test_a_prefab_is_followed_in_a_scene_that_never_had_a_plan(tmp_path):
    text = HEAD + "entities:\n  desk: {use: table.yaml}\n  a: {pose: {relative_to: desk/leg¦}, mas: 1}\n"
    assert Editor(tmp_path, {"a.yaml": text}, {"table.yaml": PREFAB}).definition() == ("table.yaml", 8, "leg")


def test_shipped_prefabs_are_followed(tmp_path):
    text = HEAD + "entities:\n  desk: {use: scenecc:table, with: {size¦: 1}}\n"
    found = Editor(tmp_path, {"a.yaml": text}).definition()
    assert found is not None
    assert found[::2] == ("table.yaml", "size")


def test_unknown_names_have_no_definition(tmp_path):
    for word in ("world", "nobody", "desk/nothing", "../secret"):
        text = HEAD + f"entities:\n  desk: {{use: table.yaml}}\n  a: {{pose: {{relative_to: {word}¦}}, {BOX}}}\n"
        assert Editor(tmp_path, {"a.yaml": text}, {"table.yaml": PREFAB}).definition() is None


def test_definitions_in_outside_files_are_not_found(tmp_path):
    (tmp_path / "secret.yaml").write_text(PREFAB)
    text = HEAD + "entities:\n  a: {use: ../secret.yaml¦}\n"
    assert Editor(tmp_path / "in", {"a.yaml": text}).definition() is None


def test_uses_of_a_name_are_found_in_all_files(tmp_path):
    found = opened(tmp_path, "  lamp", file="part.yaml").uses()
    assert found == [("part.yaml", 4, "lamp"), ("a.yaml", 10, "lamp")]
    inside = opened(tmp_path, "  top", file="table.yaml").uses()
    assert inside == [("table.yaml", 7, "top"), ("table.yaml", 8, "top"), ("a.yaml", 7, "top"), ("a.yaml", 16, "top")]
    gaps = opened(tmp_path, "{gap", file="part.yaml").uses()
    assert gaps == [("part.yaml", 1, "gap"), ("a.yaml", 10, "gap"), ("a.yaml", 14, "gap")]


def renamed(editor: Editor, new: str) -> dict[str, str]:
    view = editor.view
    return {file.name: text for file, text in applied(view, rename(view, *editor.cursor, new)).items()}


def test_a_rename_changes_every_use_of_a_name(tmp_path):
    changed = renamed(opened(tmp_path, "  top", file="table.yaml"), "board")
    assert changed["table.yaml"] == PREFAB.replace("top", "board")
    assert changed["a.yaml"] == SCENE.replace("top", "board")
    changed = renamed(opened(tmp_path, "position('bulb"), "light")
    assert changed == {"a.yaml": SCENE.replace("bulb", "light")}
    changed = renamed(opened(tmp_path, "${i"), "number")
    assert changed["a.yaml"] == SCENE.replace("{i: [", "{number: [").replace("${i ", "${number ")


REFUSED = {
    "a name that repetition makes": ("  dot", "spot", "generated by repetition"),
    "a copy": ("dot_1", "spot", "generated by repetition"),
    "a link": ("arm/hand", "palm", "must be changed where"),
    "a name that is taken": ("relative_to: lamp", "ground", "already among the entities"),
    "a name of a frame that is taken": ("relative_to: lamp", "eye", "already among the cameras"),
    "no name": ("relative_to: lamp", "a b", "is not a name"),
    "the world": ("relative_to: lamp", "world", "is not a name"),
    "a word of expressions": ('p: ["${gap', "sqrt", "a reserved word in expressions"),
    "where there is none": ("body_type: static", "fixed", "there is no name"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_impossible_renames_are_refused(case, tmp_path):
    word, new, reason = REFUSED[case]
    editor = opened(tmp_path, word)
    with pytest.raises(RefusedError, match=reason):
        rename(editor.view, *editor.cursor, new)


def test_a_scene_with_errors_is_not_renamed(tmp_path):
    editor = opened(tmp_path, "relative_to: lamp")
    editor.type("a.yaml", SCENE.replace("hidden", "hiden"))
    editor.check()
    with pytest.raises(RefusedError, match="has errors"):
        rename(editor.view, *editor.cursor, "torch")


def test_a_name_in_an_instance_without_a_prefix_is_resolved(tmp_path):
    instance = HEAD + "entities:\n  desk: {use: table.yaml, prefix: ''}\n"
    text = f"{instance}  a: {{pose: {{p: [5, 0, 0], relative_to: leg¦}}, {BOX}}}\n"
    editor = Editor(tmp_path, {"a.yaml": text}, {"table.yaml": PREFAB})
    assert editor.definition() == ("table.yaml", 8, "leg")
    assert renamed(editor, "foot")["a.yaml"].count("foot") == 1


def test_hover_describes_keys_names_and_parameters(tmp_path):
    def told(word, **choices):
        found = opened(tmp_path, word, **choices).hover()
        return found.text, found.entities

    assert told("body_type")[0].startswith("dynamic: moved by forces")
    assert told("hidden")[0].startswith("true: hidden from cameras of the file")
    assert told("  bulb") == ("entity `bulb`", ("bulb",))
    assert told("desk/top") == ("entity `desk/top` — table.yaml", ("desk/top",))
    assert told("relative_to: lamp") == ("entity `lamp` — part.yaml", ("lamp",))
    assert told("with: {length")[0] == "parameter `length` — table.yaml: default 1"
    assert "A table with two parts" in told("use: table.yaml")[0]
    assert told("desk") == ("entity `desk`", ("desk/top", "desk/leg"))
    assert told("override: {top") == ("entity `top` — table.yaml", ("desk/top",))
    assert told("dot") == ("entity `dot`", ("dot_0", "dot_1"))
    assert told("type: box")[0].startswith("A box. One of `box`, `sphere`, ")
    assert told("arm/hand") == ("link `arm/hand` — arm.urdf", ("arm",))


def test_names_inside_nested_prefabs_are_known(tmp_path):
    outer = HEAD + "entities: {set: {use: table.yaml}, bot: {urdf: arm.urdf}}\n"
    text = (
        HEAD + "entities:\n  a: {use: outer.yaml, override: {set/top: {hid¦den: true}, bot: {joints: {wrist: {}}}}}\n"
    )
    closed = {**CLOSED, "outer.yaml": outer}
    assert Editor(tmp_path, {"a.yaml": text}, closed).hover().text.startswith("true: hidden from cameras")
    editor = Editor(tmp_path, {"a.yaml": text.replace("¦", "").replace("set/top", "set/t¦op")}, closed)
    assert editor.definition() == ("table.yaml", 7, "top")
    assert editor.hover().entities == ("a/set/top",)


TREE = f"""{HEAD}entities:
  arm: {{urdf: arm.urdf, joints: {{wrist: {{friction: 1}}}}}}
  b:
    pose: [5, 0, 0]
    root: {{name: x, {BOX}, children: [{{name: y, {BOX}, joint: {{name: turn, type: continuous, axis: z}}}}]}}
expect: {{holds: [{{that: "${{qpos('arm', 'wrist') + qpos('b', 'turn') > -9}}"}}]}}
"""


@pytest.mark.parametrize(
    ("word", "found"),
    [
        ("{wrist", ("arm.urdf", 3, '<joint name="wrist"')),
        ("'wrist", ("arm.urdf", 3, '<joint name="wrist"')),
        ("'turn", ("a.yaml", 5, "turn")),
    ],
)
def test_joints_lead_to_the_robot_file_or_tree(tmp_path, word, found):
    text = TREE.replace(word, f"{word[:-1]}¦{word[-1]}")
    assert Editor(tmp_path, {"a.yaml": text}, CLOSED).definition() == found


def test_hover_escapes_text_of_a_scene(tmp_path):
    prefab = PREFAB.replace("A table with two parts.", "'![x](http://y) <b>'")
    editor = Editor(tmp_path, {"a.yaml": HEAD + "entities: {a: {use: table.yaml¦}}\n"}, {"table.yaml": prefab})
    assert "![x](http" not in editor.hover().text
    assert r"\<b\>" in editor.hover().text


def test_the_outline_lists_sections_and_names(tmp_path):
    editor = opened(tmp_path, "  bulb")
    outline = symbols_of(editor.view.texts[tmp_path / "a.yaml"])
    assert [one.name for one in outline] == ["entities", "cameras"]
    names = {one.name: (one.span[0], one.last, one.detail) for one in outline[0].below}
    assert names["ground"] == (3, 3, "static")
    assert names["desk"] == (4, 7, "use table.yaml")
    assert names["six"] == (18, 18, "")
