"""What the compiler gives for the scenes of this repository, as lines of text: plans and draws.

A change that must not change behaviour must not change these lines. Each holds two digests. The
first is of every bit. The second is of numbers rounded to six significant digits, with what is below 1e-12 as zero:
`sin`, `cos`, `exp` and `log`, and numpy's products of matrices, may differ in their last bits between processors, and
after them all that is computed from them. So each file begins with a digest of this machine's arithmetic, and the exact
digests count only where it is the same.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from plugins.expectations import GOOD, ROOT, file_id, scene_files

# All that is taken from the package: a move inside it must not break what tells whether the move changed anything.
from scenecc import Scene, SceneError, open_scene
from scenecc.placing.at_reset import place_anew, placed_members
from scenecc.plan import Value
from scenecc.variation.evaluation import Batch

HERE = Path(__file__).parent
SCENE_COUNTS, SEEDS = (1, 3), (0, 1, 7)
DRAWN_SCENES, RESET_SEEDS = 5, (11, 12)


def frozen_scenes() -> list[Path]:
    """The scenes that compile without ManiSkill's files: compiling the others takes seconds each, and its version."""
    maniskill = ROOT / "scenes" / "maniskill"
    shipped = [file for file in scene_files(ROOT / "scenes") if maniskill not in file.parents]
    return [*shipped, *sorted(maniskill.glob("MS-Cartpole*.yaml")), *scene_files(GOOD)]


def plan_lines() -> Iterator[str]:
    """Digests of each scene's plan as JSON, which holds all numbers that are drawn when it is compiled."""
    for scene in frozen_scenes():
        for count in SCENE_COUNTS:
            for seed in SEEDS:
                yield f"{file_id(scene)} scenes={count} seed={seed} {_digests(plan_data, scene, count, seed)}"


def draw_lines() -> Iterator[str]:
    """Digests of what five scenes draw, when they are compiled and at two resets."""
    for scene in frozen_scenes():
        for seed in SEEDS:
            yield f"{file_id(scene)} seed={seed} {_digests(drawn_data, scene, seed)}"


FILES: dict[str, Callable[[], Iterator[str]]] = {
    "plans.txt": plan_lines,
    "draws.txt": draw_lines,
}
"""Name of a file in this folder, and what makes its lines."""


def update(name: str) -> None:
    """Writes one of `FILES`."""
    (HERE / name).write_text("\n".join([arithmetic(), *FILES[name]()]) + "\n", encoding="utf-8")


def difference(name: str) -> list[str]:
    """Lines of one of `FILES` that are gone (-) and new (+); none where all is as it was."""
    return compared((HERE / name).read_text(encoding="utf-8").splitlines(), [arithmetic(), *FILES[name]()])


def compared(kept: list[str], made: list[str]) -> list[str]:
    """As `difference`, of lines; the first of each names the arithmetic."""
    exact = kept[0] == made[0]
    before, after = ([line if exact else _rounded_only(line) for line in lines[1:]] for lines in (kept, made))
    gone, new = Counter(before) - Counter(after), Counter(after) - Counter(before)
    signed = [("-", line) for line in gone.elements()] + [("+", line) for line in new.elements()]
    return [f"{sign} {line}" for sign, line in sorted(signed, key=_by_what)]


def plan_data(scene: Path, count: int, seed: int) -> str:
    """The canonical JSON of a scene's plan."""
    return _canonical(open_scene(scene, num_scenes=count, seed=seed))


def drawn_data(scene: Path, seed: int) -> str:
    """JSON of the plan of five scenes, with what two resets give, by the place in the plan."""
    opened = open_scene(scene, num_scenes=DRAWN_SCENES, seed=seed)
    return json.dumps({"plan": json.loads(_canonical(opened)), "resets": _resets(opened.plan)})


def _canonical(scene: Scene) -> str:
    # The version of MuJoCo is that of the environment.
    return re.sub(r',\s*"read_by": "mujoco [^"]*"', "", scene.emit("json").text)


def flat(node: Any, path: str = "") -> Iterator[str]:
    """A line for each innermost list or value of JSON, with its path."""
    children: list[tuple[str, Any]] = []
    if isinstance(node, dict):
        children = [(f"{path}.{key}".lstrip("."), child) for key, child in node.items()]
    elif isinstance(node, list) and any(isinstance(child, dict | list) for child in node):
        children = [(f"{path}[{index}]", child) for index, child in enumerate(node)]
    if not children:
        yield f"{path}: {json.dumps(node)}"
    for name, child in children:
        yield from flat(child, name)


def arithmetic() -> str:
    """A line that is the same where the functions that are not rounded correctly everywhere give the same bits."""
    x = np.linspace(0.001, 20, 4096)
    square = x.reshape(64, 64)
    by_numpy = [np.sin(x), np.cos(x), np.tan(x), np.exp(x), np.log(x), np.arctan2(x, x[::-1]), np.power(x, 0.3)]
    by_numpy += [square @ square, np.linalg.eigh(square + square.T)[0], np.einsum("ij,ij->i", square, square)]
    by_python = [function(number) for function in (math.sin, math.cos, math.exp, math.log) for number in x.tolist()]
    whole = b"".join(array.tobytes() for array in [*by_numpy, np.array(by_python)])
    return f"# arithmetic {_sha(whole)}"


def _digests(make: Callable[..., str], *arguments: Any) -> str:
    """The exact and the rounded digest of the JSON that a function gives, or the codes of the errors in its place."""
    try:
        text = make(*arguments)
    except SceneError as error:
        return "errors " + ",".join(sorted({d.code for d in error.diagnostics if d.severity == "error"}))
    rounded = json.dumps(json.loads(text, parse_float=_rounded))
    return f"exact={_sha(text.encode())} rounded={_sha(rounded.encode())}"


def _rounded(number: str) -> str:
    value = float(number)
    return "0" if abs(value) < 1e-12 else f"{value:.6g}"


def _rounded_only(line: str) -> str:
    return " ".join(word for word in line.split(" ") if not word.startswith("exact="))


def _by_what(signed: tuple[str, str]) -> tuple[str, str]:
    """What is gone right above what stands in its place."""
    sign, line = signed
    return re.split(" (?:exact|rounded|errors)", line)[0], "0" if sign == "-" else "1"


def _sha(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def _resets(plan: Any) -> dict[str, list[Any]]:
    """What every recipe of a plan gives at resets, by its place."""
    found: dict[str, list[Any]] = {}
    for seed in RESET_SEEDS:
        placed = _placed(plan, seed) if plan.placements else {}
        for path, recipe, scene_idxs in _recipes(plan, "", range(plan.num_scenes)):
            batch = Batch(np.array(scene_idxs), seed, plan.num_scenes, dict(plan.draws), {})
            batch.placed = placed
            found[f"{path} seed={seed}"] = batch.evaluate(recipe).tolist()
    return found


def _placed(plan: Any, seed: int) -> Any:
    """Where a reset places what it places."""
    batch = Batch(np.arange(plan.num_scenes), seed, plan.num_scenes, dict(plan.draws), {})
    members, poses = placed_members(plan), {}
    for entity in plan.entities:
        rows = np.broadcast_to(entity.pose.data, (len(entity.scene_idxs), 7))
        if entity.pose.recipe is not None and entity.name not in members:
            rows = batch.only(np.array(entity.scene_idxs)).evaluate(entity.pose.recipe)
        poses[entity.name] = (entity.scene_idxs, rows)
    place_anew(plan, batch, poses)
    return batch.placed


def _recipes(node: Any, path: str, scene_idxs: Any) -> Iterator[tuple[str, Any, Any]]:
    """Every recipe of a plan: its place, itself, and the scenes that have it."""
    if isinstance(node, Value):
        if node.recipe is not None:
            yield path, node.recipe, scene_idxs
    elif isinstance(node, tuple):
        for index, item in enumerate(node):
            yield from _recipes(item, f"{path}[{index}]", scene_idxs)
    elif is_dataclass(node):
        for field in fields(node):
            if field.compare and field.name != "draws":
                inner = getattr(node, "scene_idxs", scene_idxs)
                yield from _recipes(getattr(node, field.name), f"{path}.{field.name}".lstrip("."), inner)
