"""A compiled model: the arrays of `mjModel`, and the names and locations of its elements."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.robots.poses import compose_poses

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Location
    from scenecc.geometry.rotations import Pose7
    from scenecc.robots.description import DescribedFile
    from scenecc.robots.mujoco.source import MujocoSource

FREE, BALL, SLIDE, HINGE = range(4)
"""`mjtJoint`."""

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH, SDF = range(9)
"""`mjtGeom`."""

CONNECT_EQUALITY, WELD_EQUALITY, JOINT_EQUALITY = range(3)
"""`mjtEq`."""

WORLD: Final = 0
"""Index of the world body."""


@dataclass(frozen=True)
class CompiledModel:
    """The output of MuJoCo's compiler.

    Attributes:
        header: names and lines of elements, files of meshes and textures, options.
        arrays: fields of `mjModel`, by name.
        source: maps lines to the file.
    """

    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    source: MujocoSource

    @staticmethod
    def of(header: dict[str, Any], parts: Sequence[bytes], source: MujocoSource) -> CompiledModel:
        """Decodes the compiler process's answer."""
        pairs = zip(header["arrays"].items(), parts, strict=True)
        arrays = {name: np.frombuffer(part, dtype).reshape(shape) for (name, (dtype, shape)), part in pairs}
        return CompiledModel(header, arrays, source)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.arrays[name]

    @cached_property
    def _elements(self) -> dict[str, dict[int, list[Any]]]:
        return {kind: {row[0]: row for row in rows} for kind, rows in self.header["elements"].items()}

    def name(self, kind: str, number: int) -> str:
        """Returns an element's name, "" if it has none. `kind`: as in `mjModel`: "body", "jnt", …"""
        row = self._elements[kind].get(number)
        return "" if row is None else str(row[1])

    def names(self, kind: str) -> list[str]:
        """Returns the names of all elements of a kind."""
        return [str(row[1]) for row in self.header["elements"][kind]]

    def location(self, kind: str, number: int) -> Location:
        """Returns an element's location; the file's root for one that MuJoCo added."""
        row = self._elements[kind].get(number)
        # MuJoCo does not report lines of keyframes.
        found = None if row is None else self.source.element(row[2]) or self.source.named(kind, row[1])
        return (found or self.source.elements[0]).location

    def texture(self, number: int) -> DescribedFile | None:
        """Returns a texture's file; None if it is procedural or has several. `number`: negative for no texture."""
        row = self._elements["tex"].get(number)
        return None if row is None else self.source.textures.get(row[2])

    def body_name(self, body: int) -> str:
        """Returns a body's name; `body_N` if it has none."""
        return self.name("body", body) or self.free_name(f"body_{body}")

    def free_name(self, name: str) -> str:
        """Returns a name that no body of the file has."""
        while name in self._body_names:
            name += "_"
        return name

    @cached_property
    def _body_names(self) -> frozenset[str]:
        return frozenset(self.names("body"))

    def body_pose(self, body: int) -> Pose7:
        """Returns a body's pose in its parent."""
        return (*self["body_pos"][body].tolist(), *self["body_quat"][body].tolist())

    @cached_property
    def children(self) -> list[list[int]]:
        """The child bodies of each body."""
        # The world is its own parent.
        return [[one for one in bodies if one != WORLD] for bodies in self.rows_of_bodies("body_parentid")]

    def rows_of_bodies(self, array: str) -> list[list[int]]:
        """Returns the elements of each body. `array`: each element's body ("jnt_bodyid")."""
        found = [list[int]() for _ in range(len(self["body_parentid"]))]
        for number, body in enumerate(self[array].tolist()):
            found[int(body)].append(number)
        return found


def invert_pose(pose: Pose7) -> Pose7:
    """Returns the inverse of a pose."""
    w, x, y, z = pose[3:]
    turned = compose_poses((0.0, 0.0, 0.0, w, -x, -y, -z), (*pose[:3], 1.0, 0.0, 0.0, 0.0))
    return (-turned[0], -turned[1], -turned[2], w, -x, -y, -z)
