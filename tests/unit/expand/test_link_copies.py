"""`repeat`, `if` and names of copies in trees of links."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from scenecc import compile_scene, validate
from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from plugins.expander import Expander

JOINT = "joint: {type: fixed}"
INNER = f"{{repeat: {{j: {{count: '${{i}}'}}}}, name: 'b${{i}}${{j}}', {JOINT}}}"


def tree(children: str) -> str:
    return f"params: {{n: 3, yes: true}}\nentities: {{a: {{root: {{name: base, children: [{children}]}}}}}}"


def names(links: list[dict[str, Any]]) -> list[Any]:
    """The names of links, each with those below it."""
    return [(link["name"], names(link["children"])) if "children" in link else link["name"] for link in links]


@pytest.mark.parametrize(
    ("children", "expected"),
    [
        (f"{{repeat: {{i: [5, 6]}}, name: leg, {JOINT}}}", ["leg_0", "leg_1"]),
        (f"{{repeat: {{i: [5, 6]}}, name: 'leg_${{i}}', {JOINT}}}, {{name: x, {JOINT}}}", ["leg_5", "leg_6", "x"]),
        (f"{{repeat: {{i: {{count: '${{n}}'}}, j: [0, 1]}}, name: 'l${{i}}${{j}}', if: '${{i > j}}', {JOINT}}}", 3),
        (f"{{if: false, name: x, {JOINT}}}, {{if: '${{yes}}', name: y, {JOINT}}}", ["y"]),
        (f"{{repeat: {{i: []}}, name: x, {JOINT}}}", []),
        (
            f"{{repeat: {{i: [1, 2]}}, name: 'a${{i}}', {JOINT}, children: [{INNER}]}}",
            [("a1", ["b10"]), ("a2", ["b20", "b21"])],
        ),
    ],
)
def test_links_are_repeated_and_left_out_as_entities_are(expanded: Expander, children: str, expected: Any) -> None:
    links = expanded.good(tree(children)).data["entities"]["a"]["root"]["children"]
    assert (len(links) if isinstance(expected, int) else names(links)) == expected
    assert all({"repeat", "if"}.isdisjoint(link) for link in links)


def test_places_of_copies(expanded: Expander) -> None:
    expansion = expanded.good(
        tree(
            f"{{name: x, {JOINT}}}, {{repeat: {{i: [1, 2, 3]}}, if: '${{i != 2}}', name: 'a${{i}}', {JOINT}, children: "
            f"[{INNER}, {{name: 'c${{i}}', {JOINT}}}]}}"
        )
    )
    top = str(expanded.folder / "scene.yaml")
    root = ("entities", "a", "root", "children")

    def traced(*path: str | int) -> tuple[tuple[str | int, ...], str]:
        found = expansion.trace(Origin(top, (*root, *path)))
        return found.path[4:], found.copy

    assert traced(0, "name") == ((0, "name"), "")
    assert traced(2, "joint") == ((1, "joint"), "i=3")
    assert traced(1, "children", 0, "joint") == ((1, "children", 0, "joint"), "i=1")
    assert traced(1, "children", 1, "joint") == ((1, "children", 1, "joint"), "i=1")
    assert traced(2, "children", 2, "joint") == ((1, "children", 0, "joint"), "i=3, j=2")
    assert traced(2, "children", 3, "joint") == ((1, "children", 1, "joint"), "i=3")


@pytest.mark.parametrize(
    ("children", "code", "message"),
    [
        (f"{{repeat: {{i: 3}}, name: x, {JOINT}}}", "SC103", "must be"),
        (f"{{if: 3, name: x, {JOINT}}}", "SC103", "`if` must be true or false"),
        (f"{{if: '${{n}}', name: x, {JOINT}}}", "SC223", "`if` must be true or false, not 3"),
        (f"{{if: '${{scene == 0}}', name: x, {JOINT}}}", "SC203", "`if`"),
        (f"{{repeat: {{i: '${{scene}}'}}, name: x, {JOINT}}}", "SC203", "`repeat`"),
        (f"{{repeat: {{i: [a b]}}, name: '${{i}}', {JOINT}}}", "SC107", "'a b' is not a name"),
        (f"{{repeat: {{i: [1, 1]}}, name: 'x${{i}}', {JOINT}}}", "SC326", "two links have the name `x1`"),
        (f"{{repeat: {{i: {{count: 200000}}}}, name: x, {JOINT}}}", "SC604", "objects"),
        (f"{{repeat: {{i: [1]}}, prefix: x, name: x, {JOINT}}}", "SC101", "unknown key `prefix`"),
    ],
)
def test_mistakes(tmp_path: Path, children: str, code: str, message: str) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text("scenecc: 1\n" + tree(children))
    found = [one for one in validate(file) if one.severity == "error"]
    # A tree without shapes weighs nothing, which is told of those that could be built.
    assert [(one.code, message in one.message) for one in found if one.code != "SC522"] == [(code, True)], found


def test_the_root_is_there_once(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text("scenecc: 1\nentities: {a: {root: {name: base, repeat: {i: [1]}}}}")
    assert [(one.code, one.message) for one in validate(file)][:1] == [("SC101", "unknown key `repeat`")]


def test_a_dict_is_read_alike() -> None:
    ball = {"shapes": [{"type": "sphere", "radius": 0.1}]}
    child = {"name": "leg", "joint": {"type": "fixed"}, **ball}
    for keys, expected in (({"repeat": {"i": [1, 2]}}, 3), ({"if": False}, 1)):
        root = {"name": "base", **ball, "children": [{**child, **keys}]}
        plan = compile_scene({"scenecc": 1, "entities": {"a": {"root": root}}})
        structure: Any = plan.entities[0].structures[0]
        assert len(structure.links) == expected


def test_items_of_a_list_are_overridden_as_they_are_built(expanded: Expander) -> None:
    files = {"p.yaml": tree(f"{{repeat: {{i: [1, 2]}}, name: leg, {JOINT}}}")}
    over = "entities: {{p: {{use: p.yaml, override: {{a: {{root: {{children: {{1: {keys}}}}}}}}}}}}}"
    data = expanded.good(over.format(keys="{mass: 3}"), files).data
    assert [link.get("mass") for link in data["entities"]["p/a"]["root"]["children"]] == [None, 3]
    found = expanded.one(over.format(keys="{repeat: {i: [1]}}"), files)
    assert (found.code, found.message) == ("SC244", "`repeat` cannot be overridden")
