"""Overrides of what an instance holds: names, merging, scopes, removal and places."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from scenecc import compile_scene, validate
from scenecc.diagnostics.diagnostic import Origin
from scenecc.variation.forms import Template

if TYPE_CHECKING:
    from plugins.expander import Expander

ASSETS = Path(__file__).resolve().parents[3] / "scenes" / "assets"
WORK = """
params: {n: 2}
draws: {d: {uniform: [1, 2]}}
materials: {wood: {physical: {static_friction: 0.5, dynamic_friction: 0.4}, visual: {roughness: 1}}}
collision_groups: {mine: {}}
frames: {spot: {pose: [0, 0, 1]}}
entities:
  leg:
    repeat: {i: {count: "${n}"}}
    pose: {p: ["${i}", 0, 0], rpy_deg: [0, 0, 90], relative_to: spot}
    mass: "${d}"
    shapes:
      - {type: box, half_size: [1, 1, 1], material: wood, pose: [1, 2, 3]}
      - {repeat: {k: [1, 2]}, type: sphere, radius: "${k}"}
  goal: {body_type: none, visuals: [{type: sphere, radius: 1}]}
  inner: {use: inner.yaml, with: {size: 3}}
  bare: {use: inner.yaml, prefix: ""}
lights: {lamp: {type: point, position: [0, 0, 1], color: [1, 1, 1]}}
cameras: {eye: {pose: [0, 0, 1], fovy_deg: 50, mount: inner/cube}}
constraints: {tie: {type: weld, parent: world, child: leg_0}}
"""
INNER = """
params: {size: 1, finish: {type: material, default: red}}
materials: {red: {visual: {base_color: [1, 0, 0]}}}
entities: {cube: {material: "${finish}", shapes: [{type: box, half_size: "${[size, size, size]}"}]}}
"""
FILES = {"work.yaml": WORK, "inner.yaml": INNER}


def overridden(expanded: Expander, override: str, more: str = "") -> Any:
    """The expansion of a file that uses `WORK` once."""
    return expanded.good(f"entities: {{work: {{use: work.yaml, override: {override}}}}}\n{more}", FILES)


def merged(expanded: Expander, override: str, more: str = "") -> dict[str, Any]:
    data: dict[str, Any] = overridden(expanded, override, more).data
    return data


def test_a_mistake_that_an_override_makes_is_told_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "work.yaml").write_text("scenecc: 1\nentities: {cup: {shapes: [{type: sphere, radius: 1}]}}\n")
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities:\n  a:\n    use: work.yaml\n    override:\n      cup: {shapes: []}\n")
    (found,) = validate(scene)
    assert (found.code, found.location.file) == ("SC502", str(tmp_path / "work.yaml"))
    assert [(one.message, one.location.line, one.location.column) for one in found.related] == [
        ("`shapes` is overridden here", 6, 13),
        ("used from here", 4, 10),
    ]


def test_names_are_those_of_the_prefab_by_itself(expanded: Expander) -> None:
    data = merged(
        expanded,
        "{leg_1: {mass: 5}, lights/lamp: {color: [2, 2, 2]}, cameras/eye: {width: 8}, frames/spot: {pose: [9, 9, 9]},"
        " constraints/tie: {pose_in_child: [1, 0, 0]}, materials/wood: {visual: {roughness: 0.5}},"
        " inner/cube: {mass: 6}, cube: {mass: 7}, materials/inner/red: {visual: {metallic: 1}}}",
    )
    assert data["entities"]["work/leg_0"]["mass"] == Template("${d}")
    assert data["entities"]["work/leg_1"]["mass"] == 5
    assert data["entities"]["work/inner/cube"]["mass"] == 6
    assert data["entities"]["work/cube"]["mass"] == 7
    assert data["lights"]["work/lamp"]["color"] == [2, 2, 2]
    assert data["cameras"]["work/eye"]["width"] == 8
    assert data["frames"]["work/spot"] == {"pose": [9, 9, 9]}
    assert data["constraints"]["work/tie"]["pose_in_child"] == [1, 0, 0]
    assert data["materials"]["work/wood"] == {
        "physical": {"static_friction": 0.5, "dynamic_friction": 0.4},
        "visual": {"roughness": 0.5},
    }
    assert data["materials"]["work/inner/red"]["visual"] == {"base_color": [1, 0, 0], "metallic": 1}


def test_the_prefix_of_the_instance_is_no_part_of_a_name(expanded: Expander) -> None:
    data = expanded.good(
        "entities: {a: {repeat: {i: [4, 5]}, use: work.yaml, prefix: 't${i}_',"
        " override: {goal: {color: [0, 0, '${i / 5}']}}}}",
        FILES,
    ).data
    assert data["entities"]["t4_goal"]["color"] == [0, 0, 0.8]
    assert data["entities"]["t5_goal"]["color"] == [0, 0, 1]


MERGES = [
    ("leg_0: {pose: {p: [1, 2, 3]}}", ("pose",), {"p": [1, 2, 3], "rpy_deg": [0, 0, 90], "relative_to": "spot"}),
    ("leg_0: {pose: {q: [0, 1, 0, 0]}}", ("pose",), {"p": [0, 0, 0], "q": [0, 1, 0, 0], "relative_to": "spot"}),
    ("leg_0: {pose: [7, 8, 9]}", ("pose",), [7, 8, 9]),
    ("leg_0: {pose: {uniform: [[0, 0, 0], [1, 1, 1]]}}", ("pose",), {"uniform": [[0, 0, 0], [1, 1, 1]]}),
    ("leg_0: {inertial: {mass: 2}}", ("mass",), None),
    ("leg_0: {shapes: {2: {radius: 9}}}", ("shapes", 2), {"type": "sphere", "radius": 9}),
    ("leg_0: {shapes: {0: {half_size: {1: 4}}}}", ("shapes", 0, "half_size"), [1, 4, 1]),
    ("leg_0: {shapes: {0: {material: {visual: {ior: 1}}}}}", ("shapes", 0, "material"), {"visual": {"ior": 1}}),
    (
        "leg_0: {shapes: {0: {type: sphere, radius: 2}}}",
        ("shapes", 0),
        {"type": "sphere", "radius": 2, "material": "wood", "pose": [1, 2, 3]},
    ),
    ("leg_0: {shapes: {0: {type: '${\"sphere\"}', radius: 2}}}", ("shapes", 0, "half_size"), None),
    ("leg_0: {shapes: [{type: sphere, radius: 2}]}", ("shapes",), [{"type": "sphere", "radius": 2}]),
    (
        "leg_0: {shapes: [{repeat: {r: [4, 5]}, type: sphere, radius: '${r}'}]}",
        ("shapes",),
        [{"type": "sphere", "radius": 4}, {"type": "sphere", "radius": 5}],
    ),
    ("leg_0: {x-note: {mass: 1}, mass: 2}", ("x-note",), None),
]


@pytest.mark.parametrize(("override", "path", "expected"), MERGES)
def test_merging(expanded: Expander, override: str, path: tuple[Any, ...], expected: Any) -> None:
    node = merged(expanded, f"{{{override}}}")["entities"]["work/leg_0"]
    found: Any = node
    for key in path:
        found = found.get(key) if isinstance(found, dict) else found[key]
    assert found == expected
    # The other copy is made of the same data, which stays as it is.
    other = merged(expanded, f"{{{override}}}")["entities"]["work/leg_1"]
    assert other["shapes"][0] == {"type": "box", "half_size": [1, 1, 1], "material": "wood", "pose": [1, 2, 3]}


@pytest.mark.parametrize(
    ("section", "name", "override", "gone"),
    [
        ("cameras", "eye", "{fovx: 1}", "fovy_deg"),
        ("lights", "lamp", "{pose: [1, 1, 1]}", "position"),
        ("cameras", "eye", "{pose: {matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}", "p"),
    ],
)
def test_a_key_takes_the_place_of_one_that_it_excludes(
    expanded: Expander, section: str, name: str, override: str, gone: str
) -> None:
    node = merged(expanded, f"{{{section}/{name}: {override}}}")[section][f"work/{name}"]
    assert gone not in node


ARM = """
entities:
  arm:
    drives: {".*": {stiffness: 1, damping: 2}, "j1": {stiffness: 3}}
    qpos: {choice: 1}
    root: {name: base}
"""


def test_patterns_of_an_override_come_last(expanded: Expander) -> None:
    def drives(override: str) -> list[tuple[str, Any]]:
        text = f"entities: {{a: {{use: arm.yaml, override: {{arm: {{drives: {override}}}}}}}}}"
        return list(expanded.good(text, {"arm.yaml": ARM}).data["entities"]["a/arm"]["drives"].items())

    first, last = (".*", {"stiffness": 1, "damping": 2}), ("j1", {"stiffness": 3})
    assert drives("{'j.': {damping: 9}}") == [first, last, ("j.", {"damping": 9})]
    assert drives("{'j1': {damping: 9}}") == [first, ("j1", {"stiffness": 3, "damping": 9})]
    # Whatever comes after the same pattern may match too, and is overridden all the same.
    assert drives("{'.*': {stiffness: 9}}") == [first, last, ("(?:.*)", {"stiffness": 9})]
    assert drives("{choice: {stiffness: 9}}") == [first, last, ("choice", {"stiffness": 9})]


def test_values_mean_what_they_mean_in_the_outer_file(expanded: Expander) -> None:
    expansion = overridden(
        expanded,
        "{leg_0: {mass: '${m + d}', density: '${m}', material: steel, collision_group: theirs,"
        " pose: {relative_to: post}},"
        " leg_1: {material: {choice: [steel, {visual: {ior: 1}}]}, pose: {relative_to: world}},"
        ' goal: {material: \'${["steel", "steel"][d]}\'},'
        " cameras/eye: {mount: post}, constraints/tie: {parent: post}}",
        "params: {m: 3}\ndraws: {d: {integers: [0, 1]}}\ncollision_groups: {theirs: {}}\n"
        "materials: {steel: {physical: {restitution: 0}}}\n",
    )
    data, names = expansion.data, expansion.names
    leg = data["entities"]["work/leg_0"]
    assert leg["mass"] == Template("${m + d}", {"m": 3}, "")
    assert (leg["density"], leg["material"], leg["collision_group"]) == (3, "/steel", "/theirs")
    assert leg["pose"]["relative_to"] == "/post"
    assert names.parent("work/leg_0", "/post") == "post"
    other = data["entities"]["work/leg_1"]
    assert other["material"] == {"choice": ["/steel", {"visual": {"ior": 1}}]}
    assert names.parent("work/leg_1", "world") is None
    assert names.parent("work/goal", "world") == "work"
    assert data["entities"]["work/goal"]["material"] == Template('/${["steel", "steel"][d]}', None, "")
    assert data["cameras"]["work/eye"]["mount"] == "/post"
    assert data["constraints"]["work/tie"]["parent"] == "/post"


def test_an_outer_override_wins_over_an_inner_one(expanded: Expander) -> None:
    middle = """
params: {k: 4}
materials: {steel: {physical: {restitution: 0}}}
entities:
  mid:
    use: work.yaml
    override:
      leg_0: {mass: "${k}", shapes: {0: {material: steel}}, pose: {relative_to: world}}
      goal: {color: [0, 0, 0]}
"""
    expansion = expanded.good(
        "entities:\n  top:\n    use: mid.yaml\n    override: {mid/leg_0: {mass: 8}, mid/goal: {color: [1, 1, 1]}}",
        {**FILES, "mid.yaml": middle},
    )
    leg = expansion.data["entities"]["top/mid/leg_0"]
    assert leg["mass"] == 8
    assert leg["shapes"][0]["material"] == "/top/steel"
    assert expansion.data["entities"]["top/mid/goal"]["color"] == [1, 1, 1]
    assert expansion.names.parent("top/mid/leg_0", "world") == "top"
    top, mid = (str(expanded.folder / name) for name in ("scene.yaml", "mid.yaml"))
    use = Origin(top, ("entities", "top", "use"))
    assert expansion.trace(Origin(top, ("entities", "top/mid/leg_0", "mass"))) == Origin(
        top, ("entities", "top", "override", "mid/leg_0", "mass")
    )
    assert expansion.trace(Origin(top, ("entities", "top/mid/leg_0", "shapes", 0, "material"))) == Origin(
        mid, ("entities", "mid", "override", "leg_0", "shapes", "0", "material"), "", use
    )


def test_places_lead_to_the_override(expanded: Expander) -> None:
    expansion = overridden(
        expanded,
        "{leg_1: {shapes: {2: {pose: {p: [0, 0, 0]}}}}, goal: {visuals: [{repeat: {r: [4, 5]}, type: sphere}]}}",
    )
    top = str(expanded.folder / "scene.yaml")

    def traced(name: str, *path: str | int) -> Origin:
        found: Origin = expansion.trace(Origin(top, ("entities", name, *path)))
        return found

    at = ("entities", "work", "override")
    assert traced("work/leg_1", "shapes", 2, "pose", "p", 0) == Origin(
        top, (*at, "leg_1", "shapes", "2", "pose", "p", 0)
    )
    assert traced("work/leg_1", "shapes", 2, "radius").file == str(expanded.folder / "work.yaml")
    assert traced("work/leg_1", "shapes", 2, "radius").copy == "i=1, k=2"
    assert traced("work/goal", "visuals", 1, "radius") == Origin(top, (*at, "goal", "visuals", 0, "radius"), "r=5")


def test_an_instance_inside(expanded: Expander) -> None:
    expansion = overridden(
        expanded,
        "{inner: {with: {size: '${s}', finish: steel}, pose: [1, 2, 3], scene_idxs: [1]}, bare: {hidden: true}}",
        "num_scenes: 2\nparams: {s: 5}\nmaterials: {steel: {physical: {restitution: 0}}}\n",
    )
    data = expansion.data
    assert data["entities"]["work/inner/cube"]["shapes"][0]["half_size"] == [5, 5, 5]
    assert data["entities"]["work/inner/cube"]["material"] == "/steel"
    assert data["frames"]["work/inner"] == {"pose": [1, 2, 3]}
    assert expansion.selections["work/inner/cube"] == (1,)
    assert data["entities"]["work/cube"]["hidden"] is True


PAINTED = """
params: {material: "#ffffff", parent: {type: string, default: none}, near: 1, on: 1}
entities: {cube: {color: "${material}", mass: "${on}", density: "${near}", shapes: [{type: sphere, radius: 1}]}}
"""


def test_a_parameter_that_is_called_like_a_key_that_names_something_is_given_as_it_is_written(
    expanded: Expander,
) -> None:
    given = "{material: '#00ff00', parent: green, near: '${d}', on: '${n}'}"
    data = expanded.good(
        f"draws: {{d: {{uniform: [1, 2]}}}}\nparams: {{n: 5}}\n"
        f"entities: {{outer: {{use: outer.yaml, override: {{inner: {{with: {given}}}}}}}}}",
        {"outer.yaml": "entities: {inner: {use: inner.yaml}}", "inner.yaml": PAINTED},
    ).data
    cube = data["entities"]["outer/inner/cube"]
    assert (cube["color"], cube["mass"]) == ("#00ff00", 5)
    assert data["draws"]["outer/inner/near"] == Template("${d}")


def test_scenes_of_what_is_inside(expanded: Expander) -> None:
    text = (
        "num_scenes: 4\nentities: {work: {use: work.yaml, scene_idxs: '0:2', override: {leg_0: {scene_idxs: [1, 3]}}}}"
    )
    expansion = expanded.good(text, FILES)
    assert expansion.selections["work/leg_0"] == (1,)
    assert expansion.selections["work/leg_1"] == (0, 1)
    assert "scene_idxs" not in expansion.data["entities"]["work/leg_0"]


def test_an_instance_that_is_called_like_what_is_in_it(expanded: Expander) -> None:
    files = {"outer.yaml": "entities: {cube: {use: inner.yaml, prefix: ''}}", "inner.yaml": INNER}
    text = "entities: {a: {use: outer.yaml, override: {cube: {mass: 2}, cube/instance: {pose: [1, 0, 0]}}}}"
    data = expanded.data(text, files)
    assert data["entities"]["a/cube"]["mass"] == 2
    assert data["frames"]["a/cube/instance"] == {"pose": [1, 0, 0]}


def test_removal(expanded: Expander) -> None:
    data = merged(expanded, "{goal: remove, inner: remove, cameras/eye: remove, lights/lamp: remove}")
    assert list(data["entities"]) == ["work/leg_0", "work/leg_1", "work/cube"]
    assert set(data["materials"]) == {"work/wood", "work/bare/red"}
    assert "cameras" not in data
    assert "lights" not in data
    assert set(data["frames"]) == {"work/spot", "work/bare", "work"}


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("{frames/spot: remove}", "`work/spot` cannot be removed: `work/leg_0`, `work/leg_1` refer to it"),
        ("{inner: remove}", "`work/inner/cube` cannot be removed: `work/eye` refers to it"),
        ("{leg_0: remove}", "`work/leg_0` cannot be removed: `work/tie` refers to it"),
        ("{materials/wood: remove, leg_0: {shapes: {0: {material: {visual: {ior: 1}}}}}}", "`work/leg_1` refers to it"),
    ],
)
def test_what_something_refers_to_is_not_removed(expanded: Expander, override: str, message: str) -> None:
    found = expanded.one(f"entities: {{work: {{use: work.yaml, override: {override}}}}}", FILES)
    assert found.code == "SC245"
    assert message in found.message
    assert str(found.file).endswith("scene.yaml")
    assert any(str(note.location.file).endswith("work.yaml") for note in found.related)


@pytest.mark.parametrize(
    "key",
    [
        "region: zone",
        "region: zone, near: {x-old: [0, 1]}",
        "relative_to: zone",
        "facing: zone",
        "near: {zone: [0, 1]}",
    ],
)
def test_a_frame_that_a_placement_names_is_not_removed(expanded: Expander, key: str) -> None:
    prefab = (
        "frames: {zone: {pose: [0, 0, 0], region: [[0, 0], [1, 1]]}}\n"
        f"entities: {{mug: {{place: {{on: table, {key}}}}}, table: {{}}}}"
    )
    found = expanded.one("entities: {a: {use: a.yaml, override: {frames/zone: remove}}}", {"a.yaml": prefab})
    assert (found.code, found.message) == ("SC245", "`a/zone` cannot be removed: `a/mug` refers to it")


def test_a_name_in_a_form_is_found(expanded: Expander) -> None:
    prefab = "materials: {red: {}, blue: {}}\nentities: {mug: {material: {choice: [red, {once: {cycle: [blue]}}]}}}"
    found = expanded.one("entities: {a: {use: a.yaml, override: {materials/blue: remove}}}", {"a.yaml": prefab})
    assert (found.code, found.message) == ("SC245", "`a/blue` cannot be removed: `a/mug` refers to it")


def test_what_is_inside_of_what_is_removed_is_not_overridden(expanded: Expander) -> None:
    text = "entities: {work: {use: work.yaml, override: {inner: remove, cameras/eye: remove, inner/cube: {mass: 2}}}}"
    found = expanded.one(text, FILES)
    assert (found.code, found.message) == ("SC243", "`inner/cube` is inside an object that is removed")


@pytest.mark.parametrize(
    ("override", "code", "column", "message", "hint"),
    [
        ("leg_2: {mass: 1}", "SC243", 7, "nothing inside `work` is called `leg_2`", "did you mean `leg_1`?"),
        ("zzz: remove", "SC243", 7, "nothing inside `work` is called `zzz`", "the nearest here: "),
        ("leg_0: {shapes: {3: {radius: 1}}}", "SC243", 24, "there is no item 3: the list has 3", "the last is 2"),
        ("leg_0: {if: true}", "SC244", 15, "`if` cannot be overridden", "with"),
        ("inner: {prefix: a}", "SC244", 15, "`prefix` cannot be overridden", "with"),
        ("inner: {mass: 1}", "SC101", 15, "unknown key `mass`", "it is an instance"),
        ("inner: {with: {sise: 1}}", "SC210", 22, "there is no parameter `sise`", "did you mean `size`?"),
        ("goal: {color: '${nope}'}", "SC201", 24, "unknown name `nope`", None),
    ],
)
def test_mistakes(expanded: Expander, override: str, code: str, column: int, message: str, hint: str | None) -> None:
    found = expanded.one(f"entities:\n  work:\n    use: work.yaml\n    override:\n      {override}", FILES)
    assert (found.code, found.line, found.column, found.message) == (code, 6, column, message)
    assert hint is None or hint in str(found.hint)


def test_one_name_for_two_things(expanded: Expander) -> None:
    files = {
        "p.yaml": "entities: {lights: {use: inner.yaml}}\n"
        "lights: {cube: {type: point, position: [0, 0, 1], color: [1, 1, 1]}}",
        "inner.yaml": INNER,
    }
    found = expanded.one("entities: {a: {use: p.yaml, override: {lights/cube: {mass: 1}}}}", files)
    assert found.code == "SC243"
    assert found.message == "`lights/cube` names two objects inside the prefab, one in `entities` and one in `lights`"


def test_an_expression_may_remove(expanded: Expander) -> None:
    for empty, expected in (("true", ["a/cube"]), ("false", None)):
        files = {"p.yaml": "entities: {cube: {mass: 1}, goal: {mass: 1}}"}
        text = (
            f"params: {{empty: {empty}}}\n"
            "entities: {a: {use: p.yaml, override: {goal: \"${'remove' if empty else 'keep'}\"}}}"
        )
        expansion = expanded(text, files)
        if expected is None:
            assert [(found.code, found.column) for found in expanded.found] == [("SC103", 46)]
        else:
            assert expansion is not None
            assert list(expansion.data["entities"]) == expected


def test_files_lie_beside_the_file_that_names_them(tmp_path: Path) -> None:
    for folder in ("outer", "outer/parts"):
        (tmp_path / folder).mkdir()
        for name in ("mesh.obj", "other.obj") if folder == "outer" else ("mesh.obj",):
            (tmp_path / folder / name).write_bytes((ASSETS / "mug.obj").read_bytes())
    (tmp_path / "outer" / "parts" / "p.yaml").write_text(
        "scenecc: 1\nparams: {file: {type: file, default: mesh.obj}}\nentities:\n"
        "  a: {shapes: [{type: convex_mesh, file: mesh.obj}]}\n  b: {shapes: [{type: convex_mesh, file: mesh.obj}]}\n"
        "  in: {use: q.yaml, with: {file: '${file}'}}\n"
    )
    (tmp_path / "outer" / "parts" / "q.yaml").write_text(
        "scenecc: 1\nparams: {file: {type: file}}\nentities: {c: {shapes: [{type: convex_mesh, file: '${file}'}]}}\n"
    )
    scene = tmp_path / "outer" / "scene.yaml"
    scene.write_text(
        "scenecc: 1\nentities:\n  x:\n    use: parts/p.yaml\n"
        "    override: {a: {shapes: {0: {file: other.obj}}}, in: {with: {file: other.obj}}}\n"
    )
    plan: Any = compile_scene(scene)
    shapes = [entity.structures[0].bodies[0].collisions[0] for entity in plan.entities]
    named = [plan.files[int(shape.geometry.file.data[0])].uri for shape in shapes]
    assert named == ["other.obj", "parts/mesh.obj", "other.obj"]
