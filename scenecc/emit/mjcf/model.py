"""The model that is being written: its sections, its names, the files beside it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.emit.xml import UniqueNames, XmlElement

if TYPE_CHECKING:
    from scenecc.emit.unsupported import UnsupportedFeatures
    from scenecc.emit.xml import AssetFolder
    from scenecc.geometry.rotations import Pose7
    from scenecc.meshes.builder import MeshBuilder
    from scenecc.meshes.surface import SurfaceMaterial
    from scenecc.plan import ScenePlan
    from scenecc.plan.body import Mount
    from scenecc.plan.snapshot import MeasuredBody, MeasuredScene

SECTIONS = ("asset", "worldbody", "contact", "equality", "tendon", "actuator", "keyframe")


@dataclass(frozen=True, slots=True)
class ModelBody:
    """A body of the model.

    Attributes:
        name: in the model.
        element: its element.
        pose: in the world, where the model starts.
        measured: what was measured of it.
        is_fixed: whether nothing moves it: it is static, moved by its pose alone, or fixed to what is.
    """

    name: str
    element: XmlElement
    pose: Pose7
    measured: MeasuredBody
    is_fixed: bool


@dataclass(frozen=True, slots=True)
class InitialState:
    """Where a joint, an actuator or a free body starts.

    Attributes:
        qpos, qvel: its numbers in these vectors of MuJoCo.
    """

    qpos: tuple[float, ...]
    qvel: tuple[float, ...]


@dataclass(slots=True)
class MjcfModel:
    """One scene on its way into a file.

    Attributes:
        sections: elements of the root, by their tags.
        bodies: of entities and of links, by (entity, link or None), in the order of the plan.
        joints: names of joints in the model, by (entity, joint's name).
        starts: by the `id` of the joint's element.
        controls: of each actuator, in order.
        looks, textures: names of materials, and of textures by the digests of their images.
        meshes: names of meshes.
    """

    plan: ScenePlan
    scene: MeasuredScene
    drawer: MeshBuilder
    assets: AssetFolder
    unsupported: UnsupportedFeatures
    root: XmlElement
    sections: dict[str, XmlElement] = field(init=False)
    bodies: dict[tuple[str, str | None], ModelBody] = field(default_factory=dict[tuple[str, "str | None"], ModelBody])
    joints: dict[tuple[str, str], str] = field(default_factory=dict[tuple[str, str], str])
    starts: dict[int, InitialState] = field(default_factory=dict[int, InitialState])
    controls: list[float] = field(default_factory=list[float])
    looks: dict[SurfaceMaterial, str] = field(default_factory=dict["SurfaceMaterial", str])
    textures: dict[str, str] = field(default_factory=dict[str, str])
    meshes: set[str] = field(default_factory=set[str])
    _names: dict[str, UniqueNames] = field(default_factory=dict[str, UniqueNames])

    def __post_init__(self) -> None:
        self.sections = {tag: XmlElement(tag) for tag in SECTIONS}

    @property
    def world(self) -> XmlElement:
        """The body of the world."""
        return self.sections["worldbody"]

    def name(self, kind: str, wish: str) -> str:
        """A name that nothing else of the kind has. "world" is the world's."""
        if kind not in self._names:
            self._names[kind] = UniqueNames("world")
        return self._names[kind].new(wish)

    def key(self, mount: Mount) -> tuple[str, str | None]:
        """The key in `bodies` of what a mount names, an articulation standing for its root."""
        key = (mount.entity, mount.link)
        return key if key in self.bodies else next(each for each in self.bodies if each[0] == mount.entity)

    def head(self, tag: str) -> XmlElement:
        """A section that stands before all bodies, made when it is first asked for."""
        for each in self.root.children:
            if each.tag == tag:
                return each
        return self.root.add(tag)
