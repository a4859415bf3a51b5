"""Which entities of a measured scene become URDFs, and the files of these."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from scenecc.diagnostics import Location
from scenecc.emit.problems import tell_problem
from scenecc.emit.urdf.robot import Robot, write_robot
from scenecc.emit.xml.elements import Element, document
from scenecc.emit.xml.lost import Lost
from scenecc.emit.xml.meshes import Beside
from scenecc.emit.xml.names import Names
from scenecc.meshes import Drawer, MeshProblem
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Sink
    from scenecc.emit.choice import Choice
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot, MeasuredEntity, MeasuredScene


def write(plan: ScenePlan, measured: EngineSnapshot, choice: Choice, sink: Sink) -> dict[str, bytes] | None:
    """A URDF, `NAME.urdf`, or one for each articulation; None after an error. See `scenecc.emit.export`."""
    chosen = _chosen(measured.scenes[0], choice, sink)
    lost = Lost(sink, left_out="SC740", otherwise="SC741")
    drawer = Drawer(plan, lambda problem, place: lost.leave_out(plan.name, str(problem), place))
    names, files, beside = Names(), dict[str, bytes](), dict[str, bytes]()
    for entity in chosen:
        wish = re.sub(r"[^A-Za-z0-9_.-]+", "_", entity.entity.name) if choice.folder else choice.name
        name = names.new(wish)
        robot = Robot(entity, Element("robot", name=entity.entity.name), drawer, Beside(name), lost)
        try:
            write_robot(robot)
        except MeshProblem as problem:
            tell_problem(problem, drawer.at, sink)
            return None
        files[f"{name}.urdf"] = document(robot.root)
        beside |= robot.beside.files
    lost.tell()
    return None if sink.failed else files | beside


def _chosen(scene: MeasuredScene, choice: Choice, sink: Sink) -> Sequence[MeasuredEntity]:
    """The entities to write; none after an error."""
    named = {each.entity.name: each for each in scene.entities}
    robots = {name: each for name, each in named.items() if isinstance(each.structure, ArticulationStructure)}
    words = ", ".join(f"`{name}`" for name in robots) or "none"
    if choice.entity is not None:
        if choice.entity in named:
            return (named[choice.entity],)
        message = f"there is no entity `{choice.entity}` in scene {scene.index}; its articulations: {words}"
        sink.report("SC915", message, Location("--entity"))
    elif not robots:
        hint = "name a body with --entity: it becomes a robot of one link"
        sink.report("SC915", f"scene {scene.index} has no articulation", Location("--to"), hint=hint)
    elif len(robots) > 1 and not choice.folder:
        hint = "name one with --entity, or a folder after -o"
        sink.report("SC915", f"one file is one robot, and scene {scene.index} has {words}", Location("-o"), hint=hint)
    else:
        return tuple(robots.values())
    return ()
