"""Instances of prefabs: names, values, scenes and clashes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from scenecc import validate
from scenecc.diagnostics.diagnostic import Origin
from scenecc.variation.forms import Template

if TYPE_CHECKING:
    from plugins.expander import Expander

    from scenecc.diagnostics import Diagnostic


LEG = """
params: {length: {type: number, default: 0.4, min: 0.1}, finish: {type: material, default: oak}}
draws: {bend: {uniform: [0, "${length}"]}}
materials: {oak: {physical: {restitution: "${bend}"}}}
collision_groups: {legs: {ignore: [legs]}}
frames: {foot: {pose: [0, 0, "${-length}"]}}
entities:
  leg:
    collision_group: legs
    material: "${finish}"
    pose: {p: ["${bend}", 0, 0], relative_to: foot}
    shapes: [{type: box, half_size: [0.1, 0.1, "${length}"]}]
"""


def test_everything_inside_has_the_instance_before_its_name(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities: {a: {mass: 1}, left: {use: leg.yaml, with: {length: 1}, pose: [1, 2, 3]}, b: {mass: 2}}",
        {"leg.yaml": LEG},
    )
    data = expansion.data
    assert list(data["entities"]) == ["a", "left/leg", "b"]
    assert data["frames"] == {"left/foot": {"pose": [0, 0, -1]}, "left": {"pose": [1, 2, 3]}}
    assert data["draws"] == {"left/bend": {"uniform": [0, 1]}}
    assert data["materials"] == {"left/oak": {"physical": {"restitution": Template("${bend}")}}}
    assert data["collision_groups"] == {"left/legs": {"ignore": ["legs"]}}
    assert data["entities"]["left/leg"]["material"] == "oak"
    assert data["entities"]["left/leg"]["pose"]["relative_to"] == "foot"
    assert expansion.names.scopes == {"left/leg": "left", "left/foot": "left"}
    assert (expansion.names.prefixes, expansion.names.anchors) == ({"left": "left/"}, {"left": "left"})


def test_what_is_written_is_found_again(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities:\n  left: {repeat: {i: [5, 6]}, use: leg.yaml, pose: [1, 2, 3], with: {length: '${i}'}}",
        {"leg.yaml": LEG},
    )
    top = str(expanded.folder / "scene.yaml")
    inner = expansion.trace(Origin(top, ("entities", "left_1/leg", "mass")))
    assert inner.file == str(expanded.folder / "leg.yaml")
    assert (inner.path, inner.copy) == (("entities", "leg", "mass"), "")
    assert inner.parent == Origin(top, ("entities", "left", "use"), "i=6")
    frame = expansion.trace(Origin(top, ("frames", "left_1", "pose", 0)))
    assert frame == Origin(top, ("entities", "left", "pose", 0), "i=6")
    assert expansion.trace(Origin(top, ("draws", "left_0/bend", "uniform"))).path == ("draws", "bend", "uniform")


def test_prefixes(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities: {a: {use: leg.yaml, prefix: ''}, leg: {use: other.yaml, prefix: ''}, "
        "c: {use: leg.yaml, prefix: c_}}",
        {"leg.yaml": LEG, "other.yaml": "entities: {it: {mass: 1}}"},
    )
    assert list(expansion.data["entities"]) == ["leg", "it", "c_leg"]
    assert expansion.names.scopes["leg"] == "a"
    assert expansion.names.scopes["c_foot"] == "c"
    assert set(expansion.data["materials"]) == {"a/oak", "c/oak"}
    assert expansion.names.prefixes == {"a": "", "leg": "", "c": "c_"}


def test_an_instance_may_be_called_like_what_is_in_it(expanded: Expander) -> None:
    expansion = expanded.good('entities: {leg: {use: leg.yaml, prefix: "", pose: [1, 0, 0]}}', {"leg.yaml": LEG})
    assert list(expansion.data["entities"]) == ["leg"]
    assert expansion.names.anchors == {"leg": "leg/instance"}
    assert expansion.data["frames"]["leg/instance"] == {"pose": [1, 0, 0]}
    assert expansion.trace(Origin(None, ("frames", "leg/instance", "pose"))).path == ("entities", "leg", "pose")


def test_prefabs_in_prefabs(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities: {desk: {use: sub/desk.yaml, with: {h: 2}, scene_idxs: [0, 1]}}",
        {
            "sub/desk.yaml": "params: {h: 1}\nentities:\n  l: {use: ../leg.yaml, with: {length: '${h * 2}'}, "
            "scene_idxs: [1, 2]}\n  r: {use: ../leg.yaml, scene_idxs: [2]}\n  top: {mass: 1, scene_idxs: '0:2'}",
            "leg.yaml": LEG,
        },
        num_scenes=3,
    )
    assert list(expansion.data["entities"]) == ["desk/l/leg", "desk/top"]
    assert expansion.data["entities"]["desk/l/leg"]["shapes"][0]["half_size"] == [0.1, 0.1, 4]
    assert expansion.data["entities"]["desk/top"] == {"mass": 1}
    assert expansion.selections == {
        "desk/l/foot": (1,),
        "desk/l/leg": (1,),
        "desk/l": (1,),
        "desk/top": (0, 1),
        "desk": (0, 1),
    }
    assert expansion.names.scopes["desk/l"] == "desk"
    assert expansion.names.scopes["desk/l/leg"] == "desk/l"
    assert expansion.trace(Origin(None, ("entities", "desk/l/leg"))).parent == Origin(
        str(expanded.folder / "sub/desk.yaml"),
        ("entities", "l", "use"),
        "",
        Origin(str(expanded.folder / "scene.yaml"), ("entities", "desk", "use")),
    )


def test_varying_arguments_are_one_draw_of_the_instance(expanded: Expander) -> None:
    expansion = expanded.good(
        "draws: {u: {uniform: [0, 1]}}\nentities:\n"
        "  a: {use: leg.yaml, with: {length: {uniform: [1, 2]}}}\n"
        "  b: {use: leg.yaml, with: {length: '${u + 1}'}}\n"
        "  c: {use: leg.yaml, with: {length: {per_scene: [1, {choice: [2, 3]}]}}, scene_idxs: [1, 3]}\n",
        {"leg.yaml": LEG},
        num_scenes=4,
    )
    draws = expansion.data["draws"]
    assert draws["a/length"] == {"uniform": [1, 2]}
    assert draws["b/length"] == Template("${u + 1}")
    assert draws["c/length"] == {"per_scene": {"1": 1, "3": {"choice": [2, 3]}, "default": 1}}
    assert draws["a/bend"] == {"uniform": [0, Template("${length}")]}
    assert expansion.names.given == {"a/length": "", "b/length": "", "c/length": ""}
    traced = expansion.trace(Origin(None, ("draws", "c/length", "per_scene", "3", "choice")))
    assert traced.path == ("entities", "c", "with", "length", "per_scene", 1, "choice")
    default = expansion.trace(Origin(None, ("draws", "c/length", "per_scene", "default")))
    assert default.path == ("entities", "c", "with", "length", "per_scene", 0)


def test_a_map_by_scene_is_traced_to_its_own_keys(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities: {a: {use: leg.yaml, with: {length: {per_scene: {3: 1, 0: 3, default: 2}}}, scene_idxs: [1, 3]}}",
        {"leg.yaml": LEG},
        num_scenes=4,
    )
    for key in ("0", "3", "default"):
        traced = expansion.trace(Origin(None, ("draws", "a/length", "per_scene", key)))
        assert traced.path == ("entities", "a", "with", "length", "per_scene", key)


def test_a_list_of_another_length_than_the_scenes(expanded: Expander) -> None:
    found = expanded.one(
        "entities: {a: {use: leg.yaml, with: {length: {per_scene: [1, 2]}}, scene_idxs: [1, 2, 3]}}",
        {"leg.yaml": LEG},
        num_scenes=4,
    )
    assert (found.code, found.line) == ("SC106", 2)


def test_a_material_means_that_of_the_file_that_names_it(expanded: Expander) -> None:
    expansion = expanded.good(
        """
materials: {oak: {physical: {density: 1}}, pine: {physical: {density: 2}}}
entities:
  a: {use: leg.yaml, with: {finish: oak}}
  b: {use: leg.yaml, with: {finish: {visual: {base_color: [1, 0, 0]}}}}
  c: {use: leg.yaml, with: {finish: {choice: [oak, pine]}}}
  d: {use: desk.yaml, with: {wood: pine}}
""",
        {
            "leg.yaml": LEG,
            "desk.yaml": "params: {wood: {type: material}}\nentities: {l: {use: leg.yaml, with: {finish: '${wood}'}}}",
        },
    )
    data = expansion.data
    assert data["entities"]["a/leg"]["material"] == "/oak"
    assert data["entities"]["b/leg"]["material"] == "/b.with.finish"
    assert data["materials"]["b.with.finish"] == {"visual": {"base_color": [1, 0, 0]}}
    assert data["draws"]["c/finish"] == {"choice": ["/oak", "/pine"]}
    assert data["entities"]["d/l/leg"]["material"] == "/pine"
    assert expansion.names.used_materials >= {"oak", "pine", "b.with.finish", "a/oak"}
    traced = expansion.trace(Origin(None, ("materials", "b.with.finish", "visual")))
    assert traced.path == ("entities", "b", "with", "finish", "visual")


def test_an_unknown_material_is_suggested(expanded: Expander) -> None:
    found = expanded.one(
        "materials: {oak: {physical: {density: 1}}}\nentities: {a: {use: leg.yaml, with: {finish: oka}}}",
        {"leg.yaml": LEG},
    )
    assert (found.code, found.line, found.hint) == ("SC301", 3, "did you mean `oak`?")


def test_files_are_those_of_the_file_that_names_them(expanded: Expander) -> None:
    prefab = (
        "params: {mesh: {type: file, default: own.obj}}\n"
        "entities: {it: {shapes: [{type: convex_mesh, file: '${mesh}'}]}}"
    )
    expansion = expanded.good(
        "entities: {a: {use: sub/p.yaml}, b: {use: sub/p.yaml, with: {mesh: m/a.obj}}, "
        "c: {use: p.yaml, with: {mesh: m/a.obj}}, d: {use: sub/p.yaml, with: {mesh: 'pkg://scenecc/a.obj'}}, "
        "e: {use: sub/p.yaml, with: {mesh: {choice: [m/a.obj, /b.obj]}}}}",
        {"sub/p.yaml": prefab, "p.yaml": prefab},
    )
    values = {name: entity["shapes"][0]["file"] for name, entity in expansion.data["entities"].items()}
    folder = expanded.folder.as_posix()
    assert values["a/it"] == "own.obj"
    assert values["b/it"] == f"{folder}/m/a.obj"
    assert values["c/it"] == "m/a.obj"
    assert values["d/it"] == "pkg://scenecc/a.obj"
    assert expansion.data["draws"]["e/mesh"] == {"choice": [f"{folder}/m/a.obj", "/b.obj"]}
    uri, document = expansion.reference("own.obj", Origin(None, ("entities", "a/it", "shapes", 0, "file")))
    assert (uri, document.folder) == ("own.obj", expanded.folder / "sub")


def test_prefabs_that_ship(expanded: Expander) -> None:
    expansion = expanded.good("entities: {t: {use: 'scenecc:table_workspace', prefix: ''}}")
    assert {"table-workspace", "ground"} <= set(expansion.data["entities"])
    origin = expansion.trace(Origin(None, ("entities", "ground", "shapes")))
    assert origin.file == "scenecc:ground"
    uri, _ = expansion.reference("x.png", Origin(None, ("entities", "ground")))
    assert uri == "pkg://scenecc/prefabs/x.png"


@pytest.mark.parametrize(
    ("text", "code", "line", "column"),
    [
        ("entities: {a: {use: 'scenecc:tabel'}}", "SC240", 2, 21),
        ("entities: {a: {use: missing.yaml}}", "SC401", 2, 21),
        ("entities: {a: {use: ../../outside.yaml}}", "SC402", 2, 21),
        ("entities: {a: {use: leg.yaml, with: {lenght: 1}}}", "SC210", 2, 38),
        ("entities: {a: {use: leg.yaml, with: {length: x}}}", "SC211", 2, 46),
        ("entities: {a: {use: leg.yaml, with: {length: 0}}}", "SC212", 2, 46),
        ("entities: {a: {use: needs.yaml}}", "SC213", 2, 21),
        ("entities: {a: {use: lists.yaml}}", "SC242", 3, 43),
        ("entities: {a: {use: broken.yaml}}", "SC101", 2, 16),
        ("entities: {a: {use: wrong.yaml}}", "SC202", 2, 25),
    ],
)
def test_what_is_wrong_with_a_use(expanded: Expander, text: str, code: str, line: int, column: int) -> None:
    files = {
        "leg.yaml": LEG,
        "needs.yaml": "params: {size: {type: number}}",
        "lists.yaml": "params: {size: 1}\nentities: {a: {mass: 1, pose: {per_scene: [[0, 0, 0]]}}}",
        "broken.yaml": "entities: {a: {mas: 1}}",
        "wrong.yaml": "entities: {a: {mass: '${1 / 0}'}}",
    }
    found = expanded.one(text, files)
    assert (found.code, found.line, found.column) == (code, line, column)
    if not str(found.file).endswith("scene.yaml"):
        assert [(related.message, related.location.line) for related in found.related] == [("used from here", 2)]


def test_an_option_that_was_probably_meant(expanded: Expander) -> None:
    options = "params: {robot: {type: choice, options: [panda, fetch, 1], default: panda}}"
    found = expanded.one("entities: {a: {use: robot.yaml, with: {robot: pandas}}}", {"robot.yaml": options})
    assert (found.code, found.hint) == ("SC211", "did you mean `panda`?")
    found = expanded.one("entities: {a: {use: robot.yaml, with: {robot: x}}}", {"robot.yaml": options})
    assert (found.code, found.hint) == ("SC211", None)


def test_circles_print_the_chain(expanded: Expander) -> None:
    found = expanded.one(
        "entities: {x: {use: a.yaml}}",
        {"a.yaml": "entities: {y: {use: b.yaml}}", "b.yaml": "entities: {z: {use: a.yaml}}"},
    )
    assert found.code == "SC232"
    assert found.message.endswith(": scene.yaml → a.yaml → b.yaml → a.yaml")
    assert [Path(str(related.location.file)).name for related in found.related] == ["a.yaml", "scene.yaml"]
    assert expanded.one("entities: {x: {use: scene.yaml}}").code == "SC232"


def test_chains_have_a_limit(expanded: Expander) -> None:
    files = {f"p{i}.yaml": f"entities: {{x: {{use: p{i + 1}.yaml}}}}" for i in range(100)}
    found = expanded.one("entities: {x: {use: p0.yaml}}", files)
    assert found.code == "SC602"
    assert "p0.yaml" in found.message
    assert expanded.one("entities: {x: {use: p0.yaml}}", files, limits={"depth": 20}).code == "SC602"
    files["p98.yaml"] = "entities: {x: {mass: 1}}"
    assert expanded("entities: {x: {use: p0.yaml}}", files) is not None


def test_a_tree_of_uses_has_a_limit(expanded: Expander) -> None:
    files = {f"p{i}.yaml": f"entities: {{x: {{use: p{i + 1}.yaml}}, y: {{use: p{i + 1}.yaml}}}}" for i in range(30)}
    files["p30.yaml"] = "entities: {x: {mass: 1}}"
    assert expanded.one("entities: {x: {use: p0.yaml}}", files, limits={"objects": 1000}).code == "SC604"


def test_settings_of_a_prefab_are_left_out_with_a_note(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities: {a: {use: p.yaml}, b: {use: p.yaml}}",
        {"p.yaml": "seed: 3\nphysics: {timestep: 0.1}\nentities: {it: {mass: 1}}"},
    )
    assert [(found.code, found.severity, found.line) for found in expanded.found] == [
        ("SC241", "note", 2),
        ("SC241", "note", 3),
    ]
    assert "physics" not in expansion.data
    assert "seed" not in expansion.data


def test_instances_clash(expanded: Expander) -> None:
    found = expanded.one(
        'entities: {a: {use: p.yaml, prefix: ""}, b: {use: p.yaml, prefix: ""}}',
        {"p.yaml": "entities: {it: {mass: 1}}"},
    )
    assert (found.code, found.line) == ("SC221", 2)
    assert [related.message for related in found.related] == ["the first of this name"]


def test_repeated_conditional_instances(expanded: Expander) -> None:
    expansion = expanded.good(
        "entities: {a: {use: '${f}.yaml', repeat: {i: [1, 2, 3], f: [p]}, if: '${i != 2}', name: '${f}${i}', "
        "scene_idxs: ['${i}']}}",
        {"p.yaml": "entities: {it: {mass: 1}}"},
        num_scenes=4,
    )
    assert list(expansion.data["entities"]) == ["p1/it", "p3/it"]
    assert expansion.selections["p3/it"] == (3,)


def test_a_pose_that_varies_is_the_frame_s(expanded: Expander) -> None:
    expansion = expanded.good(
        "frames: {f: {pose: [0, 0, 1]}}\n"
        "entities: {a: {use: p.yaml, pose: {p: {uniform: [[0, 0, 0], [1, 1, 1]]}, relative_to: f}}}",
        {"p.yaml": "entities: {it: {mass: 1}}"},
    )
    assert expansion.data["frames"]["a"] == {"pose": {"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}, "relative_to": "f"}}
    assert "a" not in expansion.names.scopes


def test_a_thousand_uses_read_a_prefab_once(expanded: Expander, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.expand import documents

    read: list[str] = []
    original = documents._read_document
    monkeypatch.setattr(
        documents, "_read_document", lambda path, *rest: read.append(path.name) or original(path, *rest)
    )
    data = expanded.data("entities: {a: {repeat: {i: {count: 1000}}, use: leg.yaml}}", {"leg.yaml": LEG})
    assert len(data["entities"]) == 1000
    assert read == ["leg.yaml"]


@pytest.mark.parametrize("link", ["entities: {x: {use: FILE}}", "include: [FILE]"], ids=["uses", "includes"])
def test_a_chain_beyond_the_stack_is_told(link: str, tmp_path: Path) -> None:
    for i in range(1200):
        (tmp_path / f"p{i}.yaml").write_text(f"scenecc: 1\n{link.replace('FILE', f'p{i + 1}.yaml')}\n")
    (tmp_path / "p1200.yaml").write_text("scenecc: 1\nentities: {x: {shapes: [{type: sphere, radius: 1}]}}\n")
    (found,) = validate(tmp_path / "p0.yaml", limits={"depth": 1000})
    assert found.code == "SC602"


@pytest.mark.parametrize("given", ["[[0]]", "[1.5]", "'${v}'", "['${v}']"])
def test_scenes_of_an_instance_are_indices(expanded: Expander, given: str) -> None:
    text = f"params: {{v: [[0]]}}\nentities: {{a: {{use: p.yaml, scene_idxs: {given}}}}}"
    assert expanded.one(text, {"p.yaml": "entities: {it: {mass: 1}}"}).code == "SC103"


def test_a_file_that_is_no_yaml_tells_what_led_there(expanded: Expander) -> None:
    files = {"outer.yaml": "include: [part.yaml]", "part.yaml": "entities: {b: {use: inner.yaml}}"}
    found = expanded.one("entities: {a: {use: outer.yaml}}", {**files, "inner.yaml": "entities: [\n"})
    assert (found.file or "").endswith("inner.yaml")
    places = [((place.location.file or "").rpartition("/")[2], place.message) for place in found.related[-3:]]
    assert places == [
        ("part.yaml", "used from here"),
        ("outer.yaml", "included from here"),
        ("scene.yaml", "used from here"),
    ]
    # What is reported later is not told to come from there.
    assert expanded.sink.parent is None


def test_a_file_that_cannot_be_read_tells_what_led_there(expanded: Expander) -> None:
    (expanded.folder / "inner.yaml").write_bytes(b"\xff\xfe\xff")
    found = expanded.one("entities: {a: {use: inner.yaml}}")
    assert [place.message for place in found.related] == ["used from here"]


def test_what_has_no_place_beside_a_list_by_scene_is_told() -> None:
    form = {"per_scene": [0.1, 0.2], "weights": [1, 2], "radius": 1}
    entity = {"use": "scenecc:cube", "scene_idxs": [0, 2], "with": {"half_size": form}}
    found = validate({"scenecc": 1, "num_scenes": 3, "entities": {"a": entity}})
    assert [(one.code, one.path) for one in found] == [
        ("SC117", "entities.a.with.half_size.weights"),
        ("SC117", "entities.a.with.half_size.radius"),
    ]


PART = "scenecc: 1\nentities:\n  cube: {body_type: static, shapes: [{type: sphere, radius: 0.1}]}\n"


def clash(folder: Path, *entities: str) -> Diagnostic:
    (folder / "part.yaml").write_text(PART)
    (folder / "top.yaml").write_text("scenecc: 1\nentities:\n  " + "\n  ".join(entities) + "\n")
    (found,) = validate(folder / "top.yaml")
    assert found.code == "SC221"
    return found


def places(found: Diagnostic) -> list[tuple[str, int]]:
    locations = [found.location, *(related.location for related in found.related)]
    return [(str(location.file).rpartition("/")[2], location.line or 0) for location in locations]


def test_two_uses_without_prefix_are_told_at_both(tmp_path: Path) -> None:
    found = clash(tmp_path, 'a: {use: part.yaml, prefix: ""}', 'b: {use: part.yaml, prefix: ""}')
    assert places(found) == [("top.yaml", 4), ("top.yaml", 3)]
    assert "another `prefix`" in (found.hint or "")


def test_a_use_without_prefix_and_an_entity(tmp_path: Path) -> None:
    cube = "cube: {body_type: static, shapes: [{type: sphere, radius: 0.1}]}"
    for entities in ((cube, 'b: {use: part.yaml, prefix: ""}'), ('b: {use: part.yaml, prefix: ""}', cube)):
        found = clash(tmp_path, *entities)
        assert places(found) == [("top.yaml", 4), ("top.yaml", 3)]
        assert 'other than ""' in (found.hint or "")
