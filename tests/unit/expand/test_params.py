"""Parameters and expressions, and parameters that nothing reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc import validate
from scenecc.variation.forms import Template

if TYPE_CHECKING:
    from plugins.expander import Expander


def test_constants_are_filled_in_and_keep_their_type(expanded: Expander) -> None:
    data = expanded.data(
        """
params: {size: 2, name_of: oak, on: true, v: [1, 2, 3]}
entities:
  a:
    gravity: "${on}"
    mass: "${size * 1.5}"
    pose: "${v}"
    material: "${name_of}_wood"
    x-note: "${left} as it is"
    shapes: [{type: box, half_size: ["${size}", 1, "${v[2]}"]}]
""",
        num_scenes=3,
    )
    assert data["entities"]["a"] == {
        "gravity": True,
        "mass": 3.0,
        "pose": [1, 2, 3],
        "material": "oak_wood",
        "x-note": "${left} as it is",
        "shapes": [{"type": "box", "half_size": [2, 1, 3]}],
    }
    assert data["num_scenes"] == 3


def test_what_differs_from_scene_to_scene_stays_with_its_constants(expanded: Expander) -> None:
    data = expanded.data(
        """
params: {size: 2}
draws: {half: {uniform: [0.1, "${size}"]}, both: "${half * size}", area: "${size * size}"}
entities:
  a: {mass: "${half + size}", density: "${scene + num_scenes}", pose: ["${area}", 0, 0]}
""",
        num_scenes=4,
    )
    assert data["draws"] == {
        "half": {"uniform": [0.1, 2]},
        "both": Template("${half * size}", {"size": 2}),
    }
    entity = data["entities"]["a"]
    assert entity["mass"] == Template("${half + size}", {"size": 2})
    assert entity["density"] == Template("${scene + num_scenes}", {"num_scenes": 4})
    assert entity["pose"] == [4, 0, 0]


def test_a_constant_draw_that_is_given_stays_a_draw(expanded: Expander) -> None:
    data = expanded.data('draws: {a: 3}\nentities: {e: {mass: "${a}"}}', draws=("a",))
    assert data["draws"] == {"a": 3}
    assert data["entities"]["e"]["mass"] == Template("${a}")


def test_a_literal_dollar_brace(expanded: Expander) -> None:
    assert expanded.data('entities: {e: {material: "$${a}"}}')["entities"]["e"]["material"] == "${a}"


def test_what_is_not_filled_in_is_the_same_object(expanded: Expander) -> None:
    data = expanded.data(
        "params: {n: 1}\nentities:\n  a: {repeat: {i: [1, 2]}, mass: '${i}', shapes: [{type: sphere, radius: 1}]}\n"
        "  b: {mass: 1}"
    )
    assert data["entities"]["a_0"]["shapes"] is data["entities"]["a_1"]["shapes"]


@pytest.mark.parametrize(
    ("declared", "given", "value"),
    [
        ("{type: number, default: 1}", 2.5, 2.5),
        ("{type: integer, default: 1, min: 1, max: 3}", 3, 3),
        ("{type: string, default: a}", "b", "b"),
        ("{type: boolean, default: true}", False, False),
        ("{type: vector, default: [1, 2], min: 0, max: [3, 4]}", [3, 4], [3, 4]),
        ("{type: vector}", [1.0], [1.0]),
        ('{type: color, default: "#ffffff"}', [0, 0.5, 1], [0, 0.5, 1]),
        ("{type: choice, options: [a, 2, true], default: a}", 2, 2),
        ("{type: list, default: []}", ["a", [1]], ["a", [1]]),
        ("{type: file}", "a/b.obj", "a/b.obj"),
        ("{type: material}", "oak", "oak"),
        ("0.1", 7, 7),
        ("true", False, False),
        ("text", "other", "other"),
        ("[1, 2]", [3, 4], [3, 4]),
    ],
)
def test_values_that_fit(expanded: Expander, declared: str, given: Any, value: Any) -> None:
    text = f"params: {{p: {declared}}}\nentities: {{e: {{x: '${{p}}'}}}}"
    assert expanded.data(text, params={"p": given})["entities"]["e"]["x"] == value


@pytest.mark.parametrize(
    ("declared", "given", "code"),
    [
        ("{type: number, default: 1}", "2", "SC211"),
        ("{type: number, default: 1}", True, "SC211"),
        ("{type: number, default: 1}", float("inf"), "SC211"),
        ("{type: integer, default: 1}", 1.0, "SC211"),
        ("{type: integer, default: 1, max: 3}", 4, "SC212"),
        ("{type: string, default: a}", 1, "SC211"),
        ("{type: boolean, default: true}", 1, "SC211"),
        ("{type: vector, default: [1, 2]}", [1, 2, 3], "SC211"),
        ("{type: vector, default: [1, 2], max: [3, 4]}", [3, 5], "SC212"),
        ("{type: vector, default: [1, 2], min: 0}", [3, -1], "SC212"),
        ('{type: color, default: "#ffffff"}', "red", "SC211"),
        ("{type: color, default: [0, 0, 0]}", [0, 0, 2], "SC211"),
        ("{type: choice, options: [a, 1], default: a}", True, "SC211"),
        ("{type: list, default: []}", "a", "SC211"),
        ("{type: file, default: a}", "", "SC211"),
        ("0.1", "a", "SC211"),
        ("{type: number, default: 1, min: 0}", {"uniform": [-1, 1]}, "SC212"),
        ("{type: number, default: 1, min: 0}", {"cycle": [1, {"uniform": [0, 1]}, {"choice": [-1, 1]}]}, "SC212"),
        ("{type: number, default: 1, min: 0}", {"cycle": [1, {"uniform": [-1, 1]}]}, "SC212"),
        ("{type: number, default: 1, min: 0}", {"normal": [1, 0.1]}, "SC212"),
        ("{type: number, default: 1, min: 0}", {"normal": [1, 0.1], "clip": [-1, 2]}, "SC212"),
        ("{type: number, default: 1}", {"per_scene": {"0": 1, "default": "a"}}, "SC211"),
        ("{type: vector, default: [0, 0], min: [0, -1]}", {"uniform": [[0, -2], [1, 1]]}, "SC212"),
        ("{type: vector, default: [0, 0], min: [0, -1]}", {"uniform": [-0.5, [1, 1]]}, "SC212"),
        ("{type: vector, default: [0, 0]}", {"uniform": [[0, 0, 0], [1, 1, 1]]}, "SC211"),
        ("{type: vector, default: [0, 0]}", {"uniform": [0, 1]}, "SC211"),
        ("{type: vector, default: [0, 0]}", {"uniform": ["a", [1, 1]]}, "SC211"),
        ("{type: vector, default: [0, 0]}", [{"uniform": [0, 1]}, 1, 1], "SC211"),
        ("{type: vector, default: [0, 0], max: [1, 2]}", [{"uniform": [0, 2]}, 1], "SC212"),
        ("{type: vector, default: [0, 0]}", {"cycle": [[0, 0], ["a", {"uniform": [0, 1]}]]}, "SC211"),
        ("{type: number, default: 1}", {"uniform": [[0, 0], [1, 1]]}, "SC211"),
        ("{type: number, default: 1}", {"uniform": [0, "a"]}, "SC211"),
        ("{type: number, default: 1, min: 0}", {"uniform": [{"choice": [-1, 0]}, 1]}, "SC212"),
        ("{type: number, default: 1}", [1, {"uniform": [0, 1]}], "SC211"),
        ("{type: number, default: 1}", {"cycle": [1, {"x": {"uniform": [0, 1]}}]}, "SC211"),
        ("{type: integer, default: 1}", {"uniform": [0, 1]}, "SC211"),
        ("{type: integer, default: 1}", {"cycle": [1, {"normal": [0, 1]}]}, "SC211"),
        ("{type: integer, default: 1}", {"choice": [1, 1.5]}, "SC211"),
        ("{type: integer, default: 1, max: 3}", {"integers": [1, 4]}, "SC212"),
        ("{type: string, default: a}", {"uniform": [0, 1]}, "SC211"),
        ("{type: boolean, default: true}", {"integers": [0, 1]}, "SC211"),
        ("{type: boolean, default: true}", {"per_scene": [True, 1]}, "SC211"),
        ("{type: file, default: a}", {"log_uniform": [1, 2]}, "SC211"),
        ("{type: choice, options: [1, 2], default: 1}", {"integers": [1, 2]}, "SC211"),
        ("{type: choice, options: [1, 2], default: 1}", {"cycle": [1, 3]}, "SC211"),
        ("{type: list, default: []}", {"uniform": [[0, 0], [1, 1]]}, "SC211"),
        ("{type: material, default: oak}", {"uniform": [0, 1]}, "SC211"),
        ("{type: color, default: [0, 0, 0]}", {"uniform": [[0, 0, 0], [1, 1, 2]]}, "SC212"),
        ("{type: color, default: [0, 0, 0]}", {"uniform": [[0, 0], [1, 1]]}, "SC211"),
        ("{type: color, default: [0, 0, 0]}", {"uniform": [0, 1]}, "SC211"),
        ("{type: color, default: [0, 0, 0]}", {"normal": [[0, 0, 0], [1, 1, 1]]}, "SC212"),
        ("{type: color, default: [0, 0, 0]}", [{"uniform": [0, 2]}, 0, 0], "SC212"),
    ],
)
def test_values_that_do_not_fit(expanded: Expander, declared: str, given: Any, code: str) -> None:
    found = expanded.one(f"params: {{p: {declared}}}\nentities: {{e: {{x: '${{p}}'}}}}", params={"p": given})
    assert found.code == code
    assert found.file == "params"
    assert [related.location.line for related in found.related] == [2]


@pytest.mark.parametrize(
    ("declared", "given"),
    [
        ("{type: number, default: 1, min: 0}", {"normal": [-1, 0.1], "clip": [0, 2]}),
        ("{type: number, default: 1}", {"integers": [0, 3]}),
        (
            "{type: number, default: 1, min: 0}",
            {"per_scene": {"x-note": "of it", "0": 1, "default": {"uniform": [0, 1]}}},
        ),
        ("{type: integer, default: 1}", {"choice": [1, {"integers": [2, 3]}]}),
        ("{type: vector, default: [0, 0], min: 0}", {"uniform": [0, [1, 1]]}),
        ("{type: vector, default: [0, 0], min: 0}", {"uniform": [{"cycle": [0, [0, 1]]}, [1, 1]]}),
        ("{type: vector, default: [0, 0], min: [0, -1]}", [{"uniform": [0, 1]}, -1]),
        ("{type: color, default: [0, 0, 0]}", {"uniform": [[0, 0, 0], [1, 1, 1]]}),
        ("{type: color, default: [0, 0, 0]}", {"choice": ["#ff0000", [0, 0, {"uniform": [0, 1]}]]}),
        ("{type: list, default: []}", [{"uniform": [0, 1]}, "a"]),
        ("{type: boolean, default: true}", {"cycle": [True, False]}),
        ("{type: file, default: a}", {"choice": ["a", "b"]}),
    ],
)
def test_varying_values_that_fit(expanded: Expander, declared: str, given: Any) -> None:
    text = f"params: {{p: {declared}}}\nentities: {{e: {{x: '${{p}}'}}}}"
    assert expanded.data(text, params={"p": given})["draws"]["p"] == given


def test_values_from_python_become_plain(expanded: Expander) -> None:
    text = "params: {v: [0, 0], p: {type: file}}\nentities: {e: {x: '${v}', y: '${p}'}}"
    entity = expanded.data(text, params={"v": np.array([1.0, 2.0]), "p": Path("a") / "b"})["entities"]["e"]
    assert entity == {"x": [1.0, 2.0], "y": "a/b"}
    assert expanded.one(text, params={"v": object(), "p": "a"}).code == "SC015"


def test_parameters_that_vary_are_draws(expanded: Expander) -> None:
    data = expanded.data(
        "params: {p: {type: number, default: 1, min: 0}}\nentities: {e: {x: '${p + 1}'}}",
        params={"p": {"uniform": [0, 1]}},
    )
    assert data["draws"] == {"p": {"uniform": [0, 1]}}
    assert data["entities"]["e"]["x"] == Template("${p + 1}")


def test_defaults_read_earlier_parameters(expanded: Expander) -> None:
    text = "params:\n  a: 2\n  b: {type: number, default: '${a * 3}'}\n  c: '${[a, b]}'\nentities: {e: {x: '${c}'}}"
    assert expanded.data(text)["entities"]["e"]["x"] == [2, 6]
    assert expanded.data(text, params={"a": 1})["entities"]["e"]["x"] == [1, 3]
    assert expanded.one(text, params={"c": "x"}).code == "SC211"


def test_a_default_cannot_read_a_later_parameter(expanded: Expander) -> None:
    found = expanded.one("params:\n  a: '${b}'\n  b: 1\n")
    assert (found.code, found.line, found.column) == ("SC201", 3, 9)
    assert "further down" in found.message


@pytest.mark.parametrize(
    ("text", "code", "column"),
    [
        ("params: {p: {type: nubmer, default: 1}}", "SC214", 20),
        ("params: {p: {default: {a: 1}}}", "SC214", 13),
        ("params: {p: {type: choice, default: 1}}", "SC214", 13),
        ("params: {p: {type: choice, options: [], default: 1}}", "SC214", 37),
        ("params: {p: {type: string, default: a, min: 1}}", "SC214", 45),
        ("params: {p: {type: number, default: 1, options: [1]}}", "SC214", 49),
        ("params: {p: {type: number, default: 1, min: a}}", "SC214", 45),
        ("params: {p: {type: number, default: 1, min: 2, max: 0}}", "SC214", 53),
        ("params: {p: {type: vector, default: [1, 2], min: [1]}}", "SC214", 50),
        ("params: {p: {type: vector, default: [3, 3], min: [0, 2], max: [9, 1]}}", "SC214", 63),
        ("params: {p: {type: vector, default: [3, 3], min: [0, 2], max: 1}}", "SC214", 63),
        ("params: {p: {type: vector, default: [3, 3], min: 2, max: [9, 1]}}", "SC214", 58),
        ("params: {p: {type: number, default: a}}", "SC211", 37),
        ("params: {p: {type: number}}", "SC213", 13),
        ("params: {p: {type: {a: 1}, default: 1}}", "SC214", 20),
        ("params: {p: {type: choice, options: 1, default: 1}}", "SC214", 37),
        ("params: {p: {type: number, default: 1, description: 1}}", "SC214", 53),
        ("params: {sqrt: 1}", "SC204", 10),
        ("params: {scene: 1}", "SC204", 10),
        ("params: {lambda: 1}", "SC204", 10),
    ],
)
def test_bad_declarations(expanded: Expander, text: str, code: str, column: int) -> None:
    found = expanded.one(text)
    assert (found.code, found.line, found.column) == (code, 2, column)


def test_parameters_and_draws_share_their_names(expanded: Expander) -> None:
    found = expanded.one("params: {a: 1}\ndraws: {a: {uniform: [0, 1]}}")
    assert (found.code, found.line, found.column) == ("SC204", 3, 9)


def test_unknown_parameters_and_draws_are_suggested(expanded: Expander) -> None:
    expanded("params: {size: 1}\ndraws: {half: {uniform: [0, 1]}}", params={"sise": 1}, draws=("haf",))
    assert [(found.code, found.file, found.hint) for found in expanded.found] == [
        ("SC250", "draws", "did you mean `half`?"),
        ("SC210", "params", "did you mean `size`?"),
    ]


def test_errors_in_expressions_stand_where_they_are(expanded: Expander) -> None:
    codes = expanded.codes(
        """
params: {n: 0}
entities:
  a:
    mass: "1 and ${sise} and ${1 / n}"
    density: '${n / n}'
    material: x${m}
"""
    )
    assert codes == [("SC201", 6, 20), ("SC202", 7, 17), ("SC201", 8, 18)]


def test_a_draw_reads_those_above_it(expanded: Expander) -> None:
    found = expanded.one("draws:\n  a: '${b}'\n  b: {uniform: [0, 1]}\n")
    assert (found.code, found.line, found.column) == ("SC201", 3, 9)
    assert found.hint == "a draw may read those above it"


@pytest.mark.parametrize(
    "entity",
    [
        "repeat: {i: {count: '${d}'}}",
        "repeat: {i: ['${d}']}",
        "if: '${scene == 0}'",
        "scene_idxs: ['${d}']",
        "{repeat: {i: [1]}, name: 'a${d}'}",
        "use: '${d}'",
        "shapes: [{repeat: {i: '${d}'}, type: box}]",
    ],
)
def test_structure_cannot_read_what_varies(expanded: Expander, entity: str) -> None:
    found = expanded.one(
        f"draws: {{d: {{integers: [1, 2]}}}}\nentities:\n  e: {entity if entity[0] == '{' else '{' + entity + '}'}"
    )
    assert (found.code, found.line) == ("SC203", 4)
    varying = f"params: {{d: 1}}\nentities:\n  e: {entity if entity[0] == '{' else '{' + entity + '}'}"
    if "scene ==" not in entity and "scene_idxs" not in entity:
        assert expanded.one(varying, params={"d": {"integers": [1, 2]}}).code == "SC203"


def test_the_head_reads_parameters(expanded: Expander) -> None:
    data = expanded.data(
        "name: 'n${n}'\nnum_scenes: '${n}'\nparams: {n: 3, m: '${num_scenes + 1}'}\nentities: {e: {x: '${m}'}}"
    )
    assert (data["name"], data["num_scenes"], data["entities"]["e"]["x"]) == ("n3", 3, 4)


def test_every_error_is_told_at_once(expanded: Expander) -> None:
    codes = expanded.codes(
        "params: {a: 1, b: {type: integer, default: 1.5}}\nentities:\n"
        "  x: {mass: '${1 / 0}', density: '${c}'}\n  y: {if: '${a}', repeat: {a: [1]}}\n"
    )
    assert sorted(code for code, *_ in codes) == ["SC201", "SC202", "SC204", "SC211", "SC223"]


@pytest.mark.parametrize(
    ("top", "code", "message"),
    [
        ({"draws": {"a": "${a + 1}"}}, "SC201", "`a` reads itself"),
        ({"params": {"a": "${a + 1}"}}, "SC201", "`a` reads itself"),
        ({"draws": {"a": "${b}", "b": 1}}, "SC201", "the draw `b` is defined further down"),
        ({"params": {"a": "${d}"}, "draws": {"d": 1}}, "SC203", "`d` is a draw: a parameter cannot read it"),
        (
            {"params": {"a": "${scene}"}},
            "SC203",
            "a default is the same in every scene, so it cannot read the scene's index",
        ),
    ],
    ids=str,
)
def test_what_a_draw_or_a_default_cannot_read(top: dict[str, Any], code: str, message: str) -> None:
    (found,) = [one for one in validate({"scenecc": 1, **top}) if one.severity == "error"]
    assert (found.code, found.message) == (code, message)


def test_a_loop_cannot_read_another_of_the_same_repeat() -> None:
    body = {"shapes": [{"type": "sphere", "radius": 0.1}], "repeat": {"i": [1, 2], "j": {"count": "${i}"}}}
    (found,) = validate({"scenecc": 1, "entities": {"ball": body}})
    assert (found.code, found.message) == ("SC201", "`i` is a loop variable of the same `repeat`")


def test_the_scene_is_not_offered_where_it_is_refused() -> None:
    body = {"shapes": [{"type": "sphere", "radius": 0.1}], "if": "${wxyz > 1}", "mass": "${wxyz}"}
    hints = {one.path: str(one.hint) for one in validate({"scenecc": 1, "entities": {"ball": body}})}
    assert "known here: " in hints["entities.ball.if"]
    assert "scene" not in hints["entities.ball.if"].replace("num_scenes", "")
    assert "scene" in hints["entities.ball.mass"].replace("num_scenes", "")


PART = 'scenecc: 1\nparams: {inner: {type: number, default: 1}}\nentities: {%s: {mass: "${%s}", shapes: [%s]}}\n'
BALL = "{type: sphere, radius: 0.1}"


def unread(folder: Path, top: str) -> list[str]:
    (folder / "part.yaml").write_text(PART % ("a", "outer", BALL))
    (folder / "prefab.yaml").write_text(f"scenecc: 1\nparams: {{outer: 1}}\nentities: {{b: {{shapes: [{BALL}]}}}}\n")
    (folder / "top.yaml").write_text(f"scenecc: 1\n{top}\n")
    found = validate(folder / "top.yaml")
    assert {one.code for one in found} <= {"SC322"}
    return [one.path for one in found]


def test_what_an_included_file_reads_is_read_and_what_it_declares_may_not_be(tmp_path: Path) -> None:
    assert unread(tmp_path, "params: {outer: 1}\ninclude: [part.yaml]") == ["params.inner"]


def test_a_prefab_reads_its_own(tmp_path: Path) -> None:
    top = "params: {outer: 1, given: 2}\nentities: {p: {use: prefab.yaml, with: {outer: '${given}'}}}"
    assert unread(tmp_path, top) == ["params.outer"]


def test_a_draw_that_is_the_same_in_every_scene_is_read_like_any_other(tmp_path: Path) -> None:
    top = tmp_path / "top.yaml"
    top.write_text(
        "scenecc: 1\ndraws: {one: 1, two: 2, three: {uniform: [0, 1]}, four: {uniform: [1, 2]}}\n"
        f"entities: {{a: {{mass: '${{two + four}}', shapes: [{BALL}]}}}}\n"
    )
    assert [(found.code, found.path) for found in validate(top)] == [("SC319", "draws.one"), ("SC319", "draws.three")]
