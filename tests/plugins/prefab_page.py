"""The page on prefabs: `python tests/plugins/prefab_page.py > docs/reference/prefabs.md` writes it."""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from scenecc.diagnostics import Sink
from scenecc.source import make_limits, read_text

PREFABS = Path(__file__).resolve().parents[2] / "scenecc" / "prefabs"

GROUPS = {
    "ManiSkill's builders": (
        """\
The bodies of ManiSkill's convenience builders (`mani_skill.utils.building`), with the same parameters, shapes, colours
and defaults. If ManiSkill has no default, the default is ours. Tests compare each prefab with plain SAPIEN code to the
last bit. ManiSkill need not be installed. ManiSkill's `name`, `scene_idxs` and `initial_pose` are the name,
`scene_idxs` and `pose` of an instance. A dynamic body with `add_collision: false` would fall forever, which is an error
(`SC502`).""",
        (
            "ground",
            "cube",
            "box",
            "sphere",
            "cylinder",
            "red_white_target",
            "twocolor_peg",
            "fourcolor_peg",
            "colorful_cube",
            "table_workspace",
        ),
    ),
    "ManiSkill's scenes": (
        """\
The robots need ManiSkill's files (`pip install --no-deps mani_skill`). ManiSkill is not imported. Tests compare the
built scene with the result of ManiSkill's own builder, name by name and to the last bit. The scenes of
[ManiSkill's tasks](maniskill-tasks.md) use this prefab.""",
        ("table_scene",),
    ),
    "Furniture": (
        """\
The table is from SAPIEN's tutorial "Create Actors"; the others are ours. All consist of boxes.""",
        ("table", "bin", "shelf", "stairs"),
    ),
    "Ropes": (
        """\
A rope is a chain of capsules, which [Ropes and chains](../how-to/ropes.md) explains.""",
        ("rope",),
    ),
    "Clutter": (
        "This prefab differs from scene to scene without any distribution in your file.",
        ("random_clutter",),
    ),
}

HEAD = """\
# Prefabs

<!-- Generated from scenecc/prefabs/ by `python tests/plugins/prefab_page.py > docs/reference/prefabs.md`. -->

A prefab is a reusable scene file. These ship with the package:

```yaml
scenecc: 1
num_scenes: 4
entities:
  workspace: {use: scenecc:table_workspace, prefix: ""}
  cube:
    use: scenecc:cube
    with: {half_size: {uniform: [0.015, 0.03]}, color: "#0c2aa0"}
    pose: [0, 0, 0.03]
```

![Built-in prefabs: a table, a shelf, stairs, a bin and objects as in ManiSkill's tasks](../pictures/prefabs.png)

`scenecc prefabs` lists them. The entities of an instance are named INSTANCE/NAME: the cube above is the entity
`cube/cube`. `prefix: ""` leaves the names unchanged. A body has the name of its prefab; the bodies of `random_clutter`
are `object_0`, `object_1`, …, those of `rope` are `piece_0`, `piece_1`, …

A parameter of type `number`, `vector` or `color` can be a form (`{uniform: …}`, `{choice: …}`, `{cycle: …}`, …). Each
scene then has its own value, which is the same everywhere in the prefab. The other parameters determine the structure,
which is the same in every scene.

A prefab can have an edition for a Python package. `scenecc:NAME` is then `NAME.PACKAGE.yaml` if this package is
installed, and `NAME.yaml` otherwise; the package is not imported for this. Editions differ in their defaults. This page
gives the defaults of both; `scenecc prefabs NAME` shows which edition your machine uses.
"""


def page() -> str:
    """The whole page."""
    parts = [HEAD, *_table()]
    for title, (text, names) in GROUPS.items():
        parts += [f"\n## {title}\n", text]
        for name in names:
            parts += _section(name)
    return "\n".join(parts) + "\n"


def prefab(name: str) -> dict[str, Any]:
    """What stands in a prefab's file."""
    file = PREFABS / f"{name}.yaml"
    sink = Sink()
    document = read_text(file.read_text(encoding="utf-8"), file.name, sink, make_limits(), file)
    assert document is not None, sink.diagnostics()
    return document.data


def params(name: str) -> dict[str, dict[str, Any]]:
    """The parameters of a prefab as they are written, those of what it includes first."""
    data = prefab(name)
    included = (params(reference.removesuffix(".yaml")) for reference in data.get("include", []))
    return {key: given for part in (*included, data["params"]) for key, given in part.items()}


def _table() -> Iterable[str]:
    yield "| prefab | what it is |"
    yield "|---|---|"
    for _, names in GROUPS.values():
        for name in names:
            yield f"| [`{name}`](#{name}) | {prefab(name)['description']} |"


def _section(name: str) -> Iterable[str]:
    yield f"\n### {name}\n"
    yield f"{_comment(name)}\n"
    yield "| parameter | type | default | range | meaning |"
    yield "|---|---|---|---|---|"
    for parameter, given in params(name).items():
        default = _default(name, parameter)
        yield f"| `{parameter}` | {given['type']} | {default} | {_range(given)} | {given['description']} |"


def _default(name: str, parameter: str) -> str:
    """Of a prefab and of those of its editions where it is another."""
    plain = _shown(params(name)[parameter].get("default"))
    editions = {file.stem: file.stem.partition(".")[2] for file in sorted(PREFABS.glob(f"{name}.*.yaml"))}
    others = {package: _shown(params(stem)[parameter]["default"]) for stem, package in editions.items()}
    told = [f"{shown} with `{package}`" for package, shown in others.items() if shown != plain]
    return "; ".join([plain, *told])


def _shown(default: Any) -> str:
    if default is None:
        return "required"
    return f"`{default if isinstance(default, str) else json.dumps(default, ensure_ascii=False)}`"


def _comment(name: str) -> str:
    """What a prefab's file begins with, without the marks."""
    lines = (PREFABS / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    return "\n".join(line[1:].strip() for line in itertools.takewhile(lambda line: line.startswith("#"), lines))


def _range(given: dict[str, Any]) -> str:
    if "options" in given:
        return " ".join(f"`{option}`" for option in given["options"])
    bounds = [f"{sign} {given[key]}" for key, sign in (("min", "≥"), ("max", "≤")) if key in given]
    return ", ".join(bounds) or "–"


if __name__ == "__main__":
    sys.stdout.write(page())
