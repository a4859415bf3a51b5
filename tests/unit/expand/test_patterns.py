"""Repetition, and what of a copy is made only once."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import pytest
from plugins.nightly import assert_took

from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from plugins.expander import Expander


def test_entities_are_numbered_in_their_order(expanded: Expander) -> None:
    data = expanded.data(
        """
params: {n: 2}
entities:
  first: {mass: 1}
  leg: {repeat: {i: [-1, 1], j: {count: "${n + 1}"}}, pose: ["${i}", "${j}", 0]}
  last: {mass: 2}
"""
    )
    assert list(data["entities"]) == ["first", *(f"leg_{i}" for i in range(6)), "last"]
    assert [data["entities"][f"leg_{i}"]["pose"] for i in range(6)] == [
        [-1, 0, 0], [-1, 1, 0], [-1, 2, 0], [1, 0, 0], [1, 1, 0], [1, 2, 0],
    ]  # fmt: skip


def test_names_by_template(expanded: Expander) -> None:
    data = expanded.data("entities: {a: {repeat: {i: [x, y], j: [0, 1]}, name: 'leg_${i}${j}', mass: 1}}")
    assert list(data["entities"]) == ["leg_x0", "leg_x1", "leg_y0", "leg_y1"]


def test_shapes_are_repeated_in_place(expanded: Expander) -> None:
    expansion = expanded.good(
        """
entities:
  a:
    shapes:
      - {type: sphere, radius: 1}
      - {repeat: {i: [-1, 1], j: [5, 6]}, type: sphere, radius: "${i * j}"}
      - {repeat: {k: {count: 2}}, type: box}
      - {type: sphere, radius: 9}
"""
    )
    shapes = expansion.data["entities"]["a"]["shapes"]
    assert [shape.get("radius") for shape in shapes] == [1, -5, -6, 5, 6, None, None, 9]
    assert all("repeat" not in shape for shape in shapes)
    traced = [expansion.trace(Origin("s", ("entities", "a", "shapes", i, "radius"))) for i in range(8)]
    assert [(origin.path[3], origin.copy) for origin in traced] == [
        (0, ""), (1, "i=-1, j=5"), (1, "i=-1, j=6"), (1, "i=1, j=5"), (1, "i=1, j=6"), (2, "k=0"), (2, "k=1"), (3, ""),
    ]  # fmt: skip


def test_shapes_of_copies_are_traced_to_both_loops(expanded: Expander) -> None:
    expansion = expanded.good(
        """
entities:
  a:
    repeat: {i: [1, 2]}
    shapes:
      - {repeat: {j: {count: "${i}"}}, type: sphere, radius: "${i + j}"}
      - {type: box}
"""
    )
    assert [len(expansion.data["entities"][name]["shapes"]) for name in ("a_0", "a_1")] == [2, 3]
    traced = expansion.trace(Origin("s", ("entities", "a_1", "shapes", 1, "radius")))
    assert (traced.path, traced.copy) == (("entities", "a", "shapes", 0, "radius"), "i=2, j=1")
    assert expansion.trace(Origin("s", ("entities", "a_1", "shapes", 2))).path == ("entities", "a", "shapes", 1)


def test_a_wrong_copy_is_named(expanded: Expander) -> None:
    found = expanded.one(
        "entities:\n  a:\n    repeat: {i: [1, 0], j: [x, y]}\n    mass: '${1 / i}'\n    density: '${1}'"
    )
    assert (found.code, found.line, found.column) == ("SC202", 5, 14)
    assert found.message.endswith("(i=0, j='x'; and in 1 other copy)")


def test_clashes_show_both_places(expanded: Expander) -> None:
    found = expanded.one("entities:\n  a: {repeat: {i: [1, 2]}}\n  b: {repeat: {i: [1]}, name: a_1}\n")
    assert (found.code, found.line) == ("SC221", 4)
    assert [(related.location.line, related.message) for related in found.related] == [
        (3, "the first of this name (i=2)")
    ]


def test_copies_clash_with_one_another(expanded: Expander) -> None:
    found = expanded.one("entities: {a: {repeat: {i: [1, 2], j: [1, 2]}, name: 'a${i}'}}")
    assert found.code == "SC221"
    assert found.message.endswith("(i=1, j=2; and in 1 other copy)")


def test_conditions(expanded: Expander) -> None:
    text = "params: {on: true}\nentities: {a: {if: '${on}'}, b: {if: '${not on}'}, c: {if: false}, d: {if: true}}"
    assert list(expanded.data(text)["entities"]) == ["a", "d"]
    assert list(expanded.data(text, params={"on": False})["entities"]) == ["b", "d"]
    ring = "entities: {a: {repeat: {i: [-1, 0, 1]}, if: '${i != 0}', mass: '${i}'}}"
    assert expanded.data(ring)["entities"] == {"a_0": {"mass": -1}, "a_2": {"mass": 1}}


def test_an_empty_product_builds_nothing_and_says_so_where_it_is_written(expanded: Expander) -> None:
    assert expanded.good("entities: {a: {repeat: {i: []}}, b: {}}").data["entities"] == {"b": {}}
    assert [(found.code, found.severity) for found in expanded.found] == [("SC222", "note")]
    assert expanded.data("params: {n: 0}\nentities: {a: {repeat: {i: {count: '${n}'}}}, b: {}}")["entities"] == {
        "b": {}
    }
    data = expanded.data("params: {v: []}\nentities: {a: {shapes: [{repeat: {i: '${v}'}, type: box}]}}")
    assert data["entities"] == {"a": {"shapes": []}}


@pytest.mark.parametrize("axis", ["3", "{count: -1}", "{count: 1.5}", "{count: many}", "{cuont: 1}", "true", "'${1}'"])
def test_what_is_no_list(expanded: Expander, axis: str) -> None:
    assert expanded.one(f"entities: {{a: {{repeat: {{i: {axis}}}}}}}").code == "SC220"


def test_names_are_not_shadowed(expanded: Expander) -> None:
    for text in (
        "params: {i: 1}\nentities: {a: {repeat: {i: [1]}}}",
        "entities: {a: {repeat: {max: [1]}}}",
        "entities: {a: {repeat: {i: [1]}, shapes: [{repeat: {i: [2]}, type: box}]}}",
    ):
        assert expanded.one(text).code == "SC204"


def test_lists_of_one_product_do_not_read_one_another(expanded: Expander) -> None:
    assert expanded.one("entities: {a: {repeat: {i: [1], j: {count: '${i}'}}}}").code == "SC201"


def test_a_name_without_repetition(expanded: Expander) -> None:
    assert expanded.one("entities: {a: {name: b}}").code == "SC224"


def test_a_name_that_is_none(expanded: Expander) -> None:
    assert expanded.one("entities: {a: {repeat: {i: [1]}, name: 'a ${i}'}}").code == "SC107"


HOSTILE = [
    "repeat: {i: {count: 1000000000}}",
    "repeat: {i: {count: 999999999999999999999999999}}",
    "repeat: {" + ", ".join(f"i{k}: {{count: 1000000}}" for k in range(20)) + "}",
    "shapes: [{repeat: {i: {count: 1000000000}}, type: box}]",
    "repeat: {i: {count: 2000}}, shapes: [{repeat: {j: {count: 2000}}, type: box}]",
    "repeat: {i: {count: 1000000000}}, use: 'scenecc:box'",
    "repeat: {i: {count: 10000000000}, j: '${[]}'}",
]


@pytest.mark.parametrize("entity", HOSTILE)
def test_a_hostile_product_is_answered_at_once(expanded: Expander, entity: str) -> None:
    start = time.process_time()
    expanded(f"entities: {{a: {{{entity}}}}}")
    assert_took(time.process_time() - start, most=3)
    codes = {found.code for found in expanded.found}
    assert codes == (set() if "[]" in entity else {"SC604"})


def test_the_limit_counts_exactly(expanded: Expander) -> None:
    text = "entities: {a: {repeat: {i: {count: 3}}, shapes: [{repeat: {j: {count: 4}}, type: box}]}}"
    assert expanded(text, limits={"objects": 12}) is not None
    assert expanded(text, limits={"objects": 11}) is None


def test_what_is_long_counts_for_more(expanded: Expander) -> None:
    values = ", ".join(["'${i}'"] * 1000)
    text = f"entities: {{a: {{repeat: {{i: {{count: 1000}}}}, mass: {{cycle: [{values}]}}}}}}"
    assert expanded.one(text, limits={"objects": 5000}).code == "SC604"
    assert expanded(text, limits={"objects": 130_000}) is not None


BOX = """
params: {size: 0.1}
draws: {u: {uniform: [1, 2]}}
entities:
  box:
    repeat: {i: {count: 3}}
    pose: [0, 0, "${i}"]
    mass: "${u * size}"
    shapes:
      - {type: box, half_size: {uniform: ["${size}", "${[size, size, 2 * size][2]}"]}}
      - {type: sphere, radius: "${size + i}"}
"""


def entities(expanded: Expander, text: str, **options: Any) -> list[Any]:
    return list(expanded.data(text, **options)["entities"].values())


def test_what_reads_no_loop_variable_is_made_once(expanded: Expander) -> None:
    first, second, third = entities(expanded, BOX)
    assert first["shapes"][0] == {"type": "box", "half_size": {"uniform": [0.1, 0.2]}}
    assert first["shapes"][0] is second["shapes"][0] is third["shapes"][0]
    assert first["mass"] is third["mass"]


def test_what_reads_one_is_made_for_each_copy(expanded: Expander) -> None:
    found = entities(expanded, BOX)
    assert [copy["pose"] for copy in found] == [[0, 0, 0], [0, 0, 1], [0, 0, 2]]
    assert [copy["shapes"][1]["radius"] for copy in found] == [0.1, 1.1, 2.1]


def test_each_use_of_a_prefab_has_its_own(expanded: Expander) -> None:
    text = "entities: {a: {use: p.yaml, with: {size: 1}}, b: {use: p.yaml, with: {size: 2}}}"
    prefab = """
params: {size: 3}
entities:
  it: {repeat: {i: [0, 1]}, shapes: [{type: sphere, radius: "${size}"}]}
"""
    found = entities(expanded, text, files={"p.yaml": prefab})
    assert [copy["shapes"][0]["radius"] for copy in found] == [1, 1, 2, 2]


def test_lists_with_repeated_items_are_told_in_every_copy(expanded: Expander) -> None:
    text = """
params: {size: 1}
entities:
  it:
    repeat: {i: [0, 1]}
    shapes: [{repeat: {j: [3, 4]}, type: sphere, radius: "${j * size}", density: -1}]
"""
    expansion = expanded.good(text)
    records = [expansion.records["entities", name] for name in ("it_0", "it_1")]
    assert [list(record.lists or ()) for record in records] == [[(("shapes",), ())], [(("shapes",), ())]]


def test_a_failure_is_told_of_every_copy(expanded: Expander) -> None:
    text = 'params: {size: 0}\nentities: {it: {repeat: {i: [0, 1]}, mass: "${1 / size}", shapes: []}}'
    found = expanded.one(text)
    assert found.code == "SC202"
    assert found.message.endswith("(i=0; and in 1 other copy)")
