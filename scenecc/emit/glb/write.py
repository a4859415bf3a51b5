"""A file of scenes: a node for each scene of a grid, entity, link and shape, below one that turns z up to y up."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics import Location
from scenecc.emit.glb.lost import tell_lost, tell_lost_look
from scenecc.emit.glb.materials import Materials
from scenecc.emit.glb.part import geometry
from scenecc.emit.problems import tell_problem
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.meshes import Drawer, MeshProblem
from scenecc.meshes.drawing import bounded, cell_of, draw_scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.emit.choice import Choice
    from scenecc.meshes import Look, Shape, Surface
    from scenecc.meshes.drawing import Cell, DrawnBody, DrawnScene
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot

_Y_UP: Final = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""From a frame with z up to glTF's, in which y is up: a quarter turn about x."""


def write(plan: ScenePlan, measured: EngineSnapshot, choice: Choice, sink: Sink) -> dict[str, bytes] | None:
    """The file; None after an error, which `sink` then tells."""
    drawer = Drawer(plan, lambda problem, origin: tell_problem(problem, origin, sink))
    try:
        drawn = tuple(draw_scene(drawer, scene, choice.show) for scene in measured.scenes)
    except MeshProblem as problem:
        tell_problem(problem, drawer.at, sink)
        return None
    tell_lost(plan, {scene.index for scene in measured.scenes}, sink)
    writer = _Writer(choice.name, sink)
    writer.add(drawn, cell_of(drawn) if choice.grid else None)
    return {f"{choice.name}.glb": writer.file()}


class _Writer:
    """Fills a scene of trimesh's: surfaces and looks that are the same are written once."""

    def __init__(self, name: str, sink: Sink) -> None:
        import trimesh

        self._scene: Any = trimesh.Scene()
        self._materials = Materials()
        self._sink = sink
        self._names = {str(self._scene.graph.base_frame)}
        self._meshes: dict[tuple[Surface, Look, bool], str] = {}
        self._root = self._node(name, None, _Y_UP)

    def add(self, scenes: tuple[DrawnScene, ...], cell: Cell | None) -> None:
        """Adds scenes, side by side where they have a cell each."""
        if cell is None:
            for scene in scenes:
                self._add_scene(scene, self._root, "", None)
            return
        for scene, origin in zip(scenes, cell.origins(len(scenes)), strict=True):
            place = np.eye(4)
            place[:3, 3] = origin
            name = f"scene {scene.scene.index}"
            self._add_scene(scene, self._node(name, self._root, place), f"{name}/", cell.half)

    def file(self) -> bytes:
        """The bytes of the file."""
        # `Scene.export` refuses a scene that shows nothing.
        gltf: Any = import_module("trimesh.exchange.gltf")
        return bytes(gltf.export_glb(self._scene, tree_postprocessor=self._materials.finish))

    def _add_scene(self, scene: DrawnScene, above: str, prefix: str, half: float | None) -> None:
        for entity in scene.entities:
            root = entity.bodies[0]
            node = self._node(prefix + entity.measured.entity.name, above, root.place)
            nodes: list[str] = []
            for body in entity.bodies:
                parent = body.body.parent
                if parent is None:
                    alone = len(entity.bodies) == 1 and body.body.name == entity.measured.entity.name
                    nodes.append(node if alone else self._node(f"{node}/{body.body.name}", node, np.eye(4)))
                else:
                    place = np.linalg.inv(entity.bodies[parent].place) @ body.place
                    nodes.append(self._node(f"{node}/{body.body.name}", nodes[parent], place))
                for shape in body.shapes:
                    self._add_shape(self._bounded(shape, body, scene, half), nodes[-1])

    def _bounded(self, shape: Shape, body: DrawnBody, scene: DrawnScene, half: float | None) -> Shape:
        """The shape; of a plane as much as there is room for."""
        seen = bounded(shape, body, scene, half)
        if seen.scale != shape.scale:
            word = "endless plane" if shape.endless else "plane"
            _, y, z = seen.scale
            message = f"this {word} is drawn {2 * y:.3g} m by {2 * z:.3g} m"
            self._sink.report("SC746", message, shape.origin or Location(None))
        return seen

    def _add_shape(self, shape: Shape, above: str) -> None:
        place = pose_matrix(shape.pose) @ np.diag([*shape.scale, 1.0])
        name = f"{above}/{shape.name or shape.kind}"
        if len(shape.parts) == 1:
            self._node(name, above, place, self._mesh(shape, 0))
            return
        node = self._node(name, above, place)
        for number in range(len(shape.parts)):
            self._node(f"{node}/{number}", node, np.eye(4), self._mesh(shape, number))

    def _mesh(self, shape: Shape, number: int) -> str:
        """The name of a mesh, which shapes that show the same share."""
        part = shape.parts[number]
        key = (part.surface, part.look, shape.turned)
        if key not in self._meshes:
            if part.look not in self._materials.looks:
                tell_lost_look(part.look, shape.origin, self._sink)
            self._meshes[key] = f"mesh {len(self._meshes)}"
            self._scene.geometry[self._meshes[key]] = geometry(part, self._materials, turned=shape.turned)
        return self._meshes[key]

    def _node(self, name: str, above: str | None, place: NDArray[np.float64], mesh: str | None = None) -> str:
        """Adds a node by a name that no other has, which is returned."""
        unique, count = name, 1
        while unique in self._names:
            count += 1
            unique = f"{name} {count}"
        self._names.add(unique)
        graph = self._scene.graph
        shown = {} if mesh is None else {"geometry": mesh}
        graph.update(frame_to=unique, frame_from=above or graph.base_frame, matrix=place, **shown)
        return unique
