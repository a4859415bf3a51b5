"""Robots from a URDF file in many scenes, against the loop that people write."""

from __future__ import annotations

import importlib.util
import io
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from benchmarks.paired import Row, alternating, best, ratios, timed

if TYPE_CHECKING:
    from collections.abc import Callable

SCENES = 64
WHAT = f"{SCENES} Pandas in {SCENES} scenes"

SCENE = """
scenecc: 1
num_scenes: {scenes}
entities:
  panda:
    urdf: asset://{urdf}
    qpos: [0, 0.39, 0, -1.96, 0, 2.36, 0.79, 0.04, 0.04]
"""


def run(repetitions: int) -> list[Row]:
    """From the text of a scene to live ones, default audit, over `URDFLoader.load` in each; physics only.

    SAPIEN's loader raises for the visuals of a file where nothing renders, so both sides read a copy without them.
    """
    from scenecc import compile_scene

    found = importlib.util.find_spec("mani_skill")
    if found is None or found.origin is None:
        return [Row("robots", WHAT, (), note="mani_skill, which has the Panda's files, is not installed")]
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder, "panda.urdf")
        _copy(Path(found.origin).parent / "assets/robots/panda/panda_v2.urdf", urdf)
        text = SCENE.format(scenes=SCENES, urdf=urdf.name)
        plan = compile_scene(io.StringIO(text), asset_roots=[urdf.parent])
        sides = [
            timed(_ours(text, urdf.parent)),
            timed(_from(plan, audit=True)),
            timed(_from(plan, audit=False)),
            timed(_loader(urdf)),
            timed(_builder(urdf)),
        ]
        rounds = alternating(sides, repetitions)
    names = (
        "text to live scenes",
        "plan to live scenes",
        "the same, audit off",
        "URDFLoader.load",
        "one builder used again",
    )
    note = ", ".join(f"{best(rounds, side)} ({name})" for side, name in enumerate(names))
    return [
        Row("robots", f"{WHAT}, text to live / URDFLoader.load in a loop", ratios(rounds, 0, 3), 0.25, note=note),
        Row("robots", f"{WHAT}, plan to live, default audit / URDFLoader.load", ratios(rounds, 1, 3)),
        Row("robots", f"{WHAT}, plan to live, audit off / one builder used again", ratios(rounds, 2, 4)),
    ]


def _copy(urdf: Path, to: Path) -> None:
    root = ET.parse(urdf).getroot()
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        (to.parent / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(urdf.parent / name, to.parent / name)
    ET.ElementTree(root).write(to)
    srdf = urdf.with_suffix(".srdf")
    if srdf.is_file():
        to.with_suffix(".srdf").write_text(srdf.read_text())


def _ours(text: str, folder: Path) -> Callable[[], object]:
    from scenecc import load_scene

    return lambda: load_scene(io.StringIO(text), render=False, asset_roots=[folder]).articulations


def _from(plan: Any, *, audit: bool) -> Callable[[], object]:
    from scenecc.backends.sapien import instantiate
    from scenecc.diagnostics import Sink

    def work() -> object:
        batch = instantiate(plan, Sink(), render=False, audit=audit)
        assert batch is not None
        assert len(batch.articulations["panda"]) == SCENES
        return batch

    return work


def _loader(urdf: Path) -> Callable[[], object]:
    def work() -> object:
        made: list[Any] = []
        for _ in range(SCENES):
            scene = _scene()
            made.append((scene, scene.create_urdf_loader().load(str(urdf))))
        return made

    return work


def _builder(urdf: Path) -> Callable[[], object]:
    def work() -> object:
        scenes = [_scene() for _ in range(SCENES)]
        builder = scenes[0].create_urdf_loader().load_file_as_articulation_builder(str(urdf))
        return [(scene, builder.set_scene(scene).build()) for scene in scenes]

    return work


def _scene() -> Any:
    import sapien
    from sapien import physx

    return sapien.Scene([physx.PhysxCpuSystem()])
