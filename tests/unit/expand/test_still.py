"""What is the same in every copy is one object in all of them, and means what it would mean by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plugins.expander import Expander

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
    assert [list(record.lists or ()) for record in records] == [[("shapes",)], [("shapes",)]]


def test_a_failure_is_told_of_every_copy(expanded: Expander) -> None:
    text = 'params: {size: 0}\nentities: {it: {repeat: {i: [0, 1]}, mass: "${1 / size}", shapes: []}}'
    found = expanded.one(text)
    assert found.code == "SC202"
    assert found.message.endswith("(i=0; and in 1 other copy)")
