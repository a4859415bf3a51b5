"""Builds the robot files of other people, and compares each with the program that it was written for.

    python tests/plugins/robot_corpus.py FOLDER... [--kind mjcf|urdf|import] [--out results.jsonl] [--pinocchio PYTHON]

MJCF is judged by MuJoCo (masses, moments, centres of mass, limits, numbers of colliding geoms, and positions at a
random pose), URDF by pinocchio (the same without geoms), which may be in another Python. `import` runs `scenecc import`
with the losses allowed that its hints name. Files that the judge does not read count as parts of others.
"""

from __future__ import annotations

import argparse
import importlib
import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

SECONDS, MEMORY = 150, 24 * 2**30
"""Limits of one file."""

PART = "part of another file"
TOLERANCE, LEAST_MASS = 1e-3, 1.1e-6


def files_in(folder: Path, kind: str) -> list[Path]:
    """Returns the MJCF or URDF files in a folder."""
    if kind == "urdf":
        return sorted(path for path in folder.rglob("*.urdf") if path.is_file())
    return sorted(path for path in folder.rglob("*.xml") if path.is_file() and b"<mujoco" in path.read_bytes()[:65536])


def prepare() -> Any:
    """Returns the function that judges one file, for `scenecc.worker`."""
    held: dict[str, Any] = {}

    def answer(header: dict[str, Any], parts: list[bytes]) -> Any:
        judge = {"mjcf": judge_mjcf, "urdf": judge_urdf, "import": judge_import}[header["kind"]]
        try:
            return {"result": judge(Path(header["file"]), Path(header["root"]), header, held)}, []
        except AssertionError as error:
            return {"result": "differs: " + " ".join(str(error).split())[:600]}, []
        except Exception as error:  # noqa: BLE001 - a bug, which the table shows
            return {"result": f"crash: {type(error).__name__}: {error}"[:600]}, []

    return answer


def refusal(error: Any) -> str:
    """Returns the first error of a scene, as text."""
    errors = [one for one in error.diagnostics if one.severity == "error"]
    first = errors[0]
    hint = f" [{first.hint}]" if first.hint else ""
    return f"refused: {first.code} {first.message[:300]}{hint[:200]} ({len(errors)})"


def judge_mjcf(file: Path, root: Path, header: dict[str, Any], held: dict[str, Any]) -> str:
    """Returns "right" or why the file is not built as MuJoCo has it."""
    from plugins.mujoco_judge import assert_same_machine, moving_bodies

    import scenecc

    mujoco = importlib.import_module("mujoco")
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        return f"{PART}: {error}"[:300]
    if not model.ngeom and not model.njnt:
        return f"{PART}: nothing in it"
    scene = {"scenecc": 1, "entities": {"robot": {"mjcf": str(file)}}}
    try:
        batch = scenecc.load_scene(scene, render=False, asset_roots=[root])
    except scenecc.SceneError as error:
        return refusal(error)
    with batch:
        assert_same_machine(mujoco, model, batch)
        missing = moving_bodies(model) - _built_bodies(mujoco, model, batch)
        assert not missing, f"bodies {sorted(missing)} are missing"
        _step(batch)
    return "right"


def _built_bodies(mujoco: Any, model: Any, batch: Any) -> set[int]:
    from plugins.mujoco_judge import number_of

    names = {link.name for held in batch.articulations.values() for link in held.objs[0].links}
    names |= {name.rpartition("/")[2] for name in batch.entities}
    if len(batch.entities) == 1 and "robot" in batch.entities:
        names |= {mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, 1) or "body_1"}
    return {number_of(mujoco, model, "BODY", name) for name in names}


def _step(batch: Any) -> None:
    for _ in range(10):
        batch.step()
    for held in batch.articulations.values():
        assert np.isfinite(held.objs[0].qpos).all(), "NaN in qpos after 10 steps"


def lacking(file: Path, root: Path) -> str | None:
    """Returns a mesh that a URDF names and that its corpus lacks; None if it has all."""
    for name in re.findall(r'<mesh[^>]*filename="([^"]+)"', file.read_text(errors="replace")):
        parts = name.removeprefix("package://").strip("/").split("/")
        ends = [parts[start:] for start in range(max(1, len(parts) - 1))] if name.startswith("package:") else [parts]
        above = [folder for folder in file.parents if folder.is_relative_to(root)] if len(ends) > 1 else [file.parent]
        if not any(folder.joinpath(*end).is_file() for end in ends for folder in above):
            return name
    return None


def judge_urdf(file: Path, root: Path, header: dict[str, Any], held: dict[str, Any]) -> str:
    """Returns "right" or why the file is not built as pinocchio has it."""
    import scenecc

    read = _ask_pinocchio(file, {}, header["pinocchio"], held)
    if "error" in read:
        return f"{PART}: {read['error']}"[:300]
    entity: dict[str, Any] = {"urdf": str(file), "repair": []}
    scene = {"scenecc": 1, "entities": {"robot": entity}}
    while hinted := _hinted_repairs(scenecc.validate(scene, asset_roots=[root])) - {*entity["repair"]}:
        entity["repair"] += sorted(hinted)
    try:
        batch = scenecc.load_scene(scene, render=False, asset_roots=[root])
    except scenecc.SceneError as error:
        name = lacking(file, root) if any(one.code == "SC401" for one in error.diagnostics) else None
        return refusal(error) if name is None else f"{PART}: the corpus lacks {name}"
    repaired = f" (with repair: {', '.join(entity['repair'])})" if entity["repair"] else ""
    with batch:
        if not batch.articulations:
            return "right" + repaired
        robot: Any = batch.articulations["robot"].objs[0]
        rng, positions = np.random.default_rng(0), dict[str, float]()
        for joint in robot.active_joints:
            low, high = np.clip(joint.limits[0], -1.5, 1.5)
            positions[joint.name] = float(rng.uniform(low, high))
        robot.qpos = np.array(list(positions.values()))
        wanted = _ask_pinocchio(file, positions, header["pinocchio"], held)
        found = scenecc.validate(scene, asset_roots=[root])
        replaced = {name for one in found for name in re.findall(r"the inertia of `(.+?)` becomes", one.message)}
        try:
            _assert_urdf(robot, wanted, "limits" in entity["repair"], replaced)
        except AssertionError as error:
            codes = sorted({one.code for one in found})
            raise AssertionError(f"{error}; findings: {codes}{repaired}") from None
        _step(batch)
    return "right" + repaired


def _hinted_repairs(found: list[Any]) -> set[str]:
    """Returns the repairs that hints name, but for an inertia that is impossible and built as written."""
    hints = [re.search(r"`repair: \[(\w+)\]", one.hint or "") for one in found if one.code != "SC468"]
    return {hint[1] for hint in hints if hint}


def _ask_pinocchio(file: Path, positions: dict[str, float], python: str, held: dict[str, Any]) -> dict[str, Any]:
    process: Any = held.get("pinocchio")
    if process is None or process.poll() is not None:
        command = [python, str(ROOT / "tests/plugins/pinocchio_judge.py")]
        process = held["pinocchio"] = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
    process.stdin.write(json.dumps({"file": str(file), "qpos": positions}) + "\n")
    process.stdin.flush()
    line = process.stdout.readline()
    return json.loads(line) if line else {"error": "pinocchio ended"}


def _assert_urdf(robot: Any, wanted: dict[str, Any], free: bool, replaced: set[str]) -> None:
    """Compares with pinocchio.

    `free`: joints without limits move freely, as the repair says, not between 0 and 0. `replaced`: links whose
    inertia is that of their shapes, as the repair says.
    """
    links = {link.name: link for link in robot.links}
    size = max((float(np.linalg.norm(place)) for place in wanted["links"].values()), default=0) + 1e-3
    for name, place in wanted["links"].items():
        if name not in links and not any(place):
            continue  # an empty root above a floating joint
        assert name in links, f"link {name} is missing"
        off = float(np.linalg.norm(links[name].entity_pose.p - place))
        assert off < 1e-5 * size + 1e-6, f"link {name} is {off:.3g} m off"
    joints = {joint.name: joint for joint in robot.joints}
    for name, joint in wanted["joints"].items():
        assert name in joints or joint["limits"] is None, f"joint {name} is missing"
        if joint["limits"] is not None and joints[name].dof and not (free and joint["limits"] == [0, 0]):
            low, high = joints[name].limits[0]
            for is_, be in ((low, joint["limits"][0]), (high, joint["limits"][1])):
                assert abs(is_ - be) < 1e-4 * max(1, abs(be)) or (abs(is_) > 1e3 and abs(be) > 1e3), (
                    f"limits of {name}: {low}, {high}, not {joint['limits']}"
                )
        mass, com, inertia = _moved_together([links[link] for link in joint["links"]])
        if joint["mass"] == 0:
            continue  # it gets the mass of its shapes, which is told
        # A link without mass gets little.
        assert abs(mass - joint["mass"]) < TOLERANCE * joint["mass"] + LEAST_MASS, (
            f"mass of {joint['links'][:3]}: {mass:.6g}, not {joint['mass']:.6g}"
        )
        if mass < 2 * LEAST_MASS:
            continue
        off = float(np.linalg.norm(com - joint["com"]))
        assert off < TOLERANCE * size, f"centre of mass of {joint['links'][:3]} is {off:.3g} m off"
        error = float(np.abs(inertia - joint["inertia"]).max())
        scale = float(np.abs(joint["inertia"]).max())
        if scale == 0 or not replaced.isdisjoint(joint["links"]):
            continue  # the file has no inertia
        assert error < 0.025 * scale + 1e-12, f"inertia of {joint['links'][:3]} is {error / scale:.3g} off"


def _moved_together(links: list[Any]) -> tuple[float, Any, Any]:
    """Returns mass, centre of mass and inertia of rigidly connected links, in the world."""
    parts: list[tuple[float, Any, Any]] = []
    for link in links:
        pose = link.entity_pose * link.cmass_local_pose
        turn = pose.to_transformation_matrix()[:3, :3]
        parts.append((float(link.mass), np.asarray(pose.p, float), turn @ np.diag(link.inertia) @ turn.T))
    mass = sum(part[0] for part in parts)
    com = sum(m * p for m, p, _ in parts) / mass
    total = np.zeros((3, 3))
    for m, p, inertia in parts:
        d = p - com
        total += inertia + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, com, total


def judge_import(file: Path, root: Path, header: dict[str, Any], held: dict[str, Any]) -> str:
    """Returns "right" if the file is imported with its masses, after hints were followed."""
    from plugins.mujoco_judge import moving_bodies

    import scenecc

    mujoco = importlib.import_module("mujoco")
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        return f"{PART}: {error}"[:300]
    if not model.ngeom and not model.njnt:
        return f"{PART}: nothing in it"
    allowed, roots = list[str](), list[Path]()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(8):
            try:
                made = scenecc.import_scene(file, Path(folder, "out/scene.yaml"), allow=allowed, asset_roots=roots)
                break
            except scenecc.SceneError as error:
                kinds = [
                    found[1] for one in error.diagnostics if (found := re.search(r"--allow (\S+)", one.hint or ""))
                ]
                if not roots and any("--asset-root" in (one.hint or "") for one in error.diagnostics):
                    roots = [root]
                elif not kinds:
                    return refusal(error)
                allowed += kinds
        else:
            return "refused: the hints lead nowhere"
        found = made.certificate
        moving = [*moving_bodies(model)]
        assert max(found.position, found.relative_mass) < TOLERANCE, f"{found.lines()}"
        assert found.masses >= sum(model.body_mass[moving] > 0), f"only {found.masses} of {len(moving)} masses"
        left = [
            one
            for one in scenecc.validate(Path(folder, "out/scene.yaml"), asset_roots=roots)
            if one.severity != "error"
        ]
        later = Counter(one.code for one in left)
        return "right" + (f" (later findings: {dict(later)})" if later else "")


def main() -> None:
    """Judges the files and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--kind", default="mjcf", choices=["mjcf", "urdf", "import"])
    parser.add_argument("--out", type=Path)
    parser.add_argument("--pinocchio", default=sys.executable)
    parser.add_argument("--match", default="", help="only files whose path contains this")
    parser.add_argument("--every", type=int, default=1, help="only every n-th file of a folder")
    chosen = parser.parse_args()
    from scenecc.worker import Worker, WorkerError

    worker = Worker("plugins.robot_corpus", memory=MEMORY, seconds=SECONDS, name="scenecc", opens_files=True)
    results: dict[str, dict[str, str]] = {}
    for folder in chosen.folders:
        rows = results[folder.name] = {}
        for number, file in enumerate(files_in(folder, chosen.kind)[:: chosen.every]):
            if chosen.match not in str(file):
                continue
            if number % 100 == 99:
                worker.stop()
            header = {"file": str(file), "root": str(folder.resolve())}
            header |= {"kind": chosen.kind, "pinocchio": chosen.pinocchio}
            try:
                result = worker.ask(header, [])[0]["result"]
            except WorkerError as error:
                result = f"crash: {error}"
            rows[str(file.relative_to(folder))] = result
            if chosen.out is not None:
                with chosen.out.open("a") as stream:
                    stream.write(json.dumps([folder.name, str(file.relative_to(folder)), result]) + "\n")
    print_table(results)


def print_table(results: dict[str, dict[str, str]]) -> None:
    """Prints the share of files built right in each folder, and the causes of the others by frequency."""
    total = Counter[str]()
    for name, rows in results.items():
        judged = [result for result in rows.values() if not result.startswith(PART)]
        right = sum(result.startswith("right") for result in judged)
        total.update(right=right, judged=len(judged))
        repaired = sum(" (with repair" in result for result in judged if result.startswith("right"))
        print(f"{name:24} {right:5} of {len(judged):5}  {100 * right / max(1, len(judged)):.1f} %, {repaired} repaired")
    print(
        f"{'all':24} {total['right']:5} of {total['judged']:5}  {100 * total['right'] / max(1, total['judged']):.1f} %"
    )
    causes = Counter(
        re.sub(r"[`'][^`']*[`']|-?\d+(\.\d+)?(e-?\d+)?", "…", result)[:90]
        for rows in results.values()
        for result in rows.values()
        if not result.startswith((PART, "right"))
    )
    for cause, count in causes.most_common():
        print(f"{count:5} {cause}")


if __name__ == "__main__":
    main()
