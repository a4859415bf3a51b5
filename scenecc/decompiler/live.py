"""Reads a live scene as a scene document, entity by entity in build order."""

from __future__ import annotations

import math
from collections import Counter
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from scenecc.backends.sapien.engine import physx, render
from scenecc.decompiler.articulations import ArticulationReader
from scenecc.decompiler.bodies import (
    LiveBodyReader,
    SceneDefaults,
    friction_of,
    physical_material,
    plain_value,
    untouched,
)
from scenecc.decompiler.names import SceneNames
from scenecc.decompiler.rendering import LIGHTS, camera, environment, light
from scenecc.decompiler.values import FileNamer, Node, language_name, pose_value, same_single, to_number, to_numbers
from scenecc.names import UniqueNames
from scenecc.plan.body import groups_collide
from scenecc.plan.properties import FLOAT32_MAX
from scenecc.plan.scene import SCENE_CONFIG_FIELDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.decompiler.record import Recording

_BODY_DEFAULTS: Final = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")

_SHAPE_DEFAULTS: Final = ("contact_offset", "rest_offset")


class LiveSceneReader:
    """Reads one live scene.

    Attributes:
        problems: content that a scene file cannot represent, one sentence each.
        names: names of the scene's objects in the document.
    """

    def __init__(
        self, recording: Recording | None, files: FileNamer, rename: Callable[[str], str], hidden: Iterable[str]
    ) -> None:
        self._recording = recording
        self._files = files
        self.names = SceneNames(rename)
        self._hidden = frozenset(hidden)
        self.problems: list[str] = []
        self._taken = UniqueNames()
        self._mounts: dict[int, tuple[Any, str]] = {}
        self._many_robots = False

    def document(self, scene: Any) -> Node:
        """Returns a `sapien.Scene` as a document with one scene."""
        components = [component for entity in scene.entities for component in entity.components]
        defaults = self._defaults([c for c in components if isinstance(c, physx.PhysxRigidBaseComponent)])
        bodies = LiveBodyReader(self._recording, self._files, defaults)
        document: Node = {"scenecc": 1}
        physics = _physics(scene, defaults)
        document |= {"physics": physics} if physics else {}
        self._many_robots = _ignoring_articulations(components) > 1
        robots = ArticulationReader(self._recording, self._files, bodies, self.names, physics)
        entities: Node = {}
        found = [each for each in map(_find_named_object, scene.entities) if each is not None]
        self.names.replace("entity", [each for each, _ in found], [name for _, name in found], self._taken)
        for entity in scene.entities:
            self._entity(entity, bodies, robots, entities)
        system = _render_system(scene)
        surroundings = {} if system is None else environment(system, self._recording, self._files, self.problems)
        document |= {"environment": surroundings} if surroundings else {}
        document["entities"] = entities
        ties = self._constraints(components)
        document |= {"constraints": ties} if ties else {}
        document |= self._read_lights_and_cameras(components)
        self.problems += [*self.names.problems, *bodies.problems]
        return document

    def _defaults(self, bodies: list[Any]) -> SceneDefaults:
        """Returns the most common values, which the document contains once."""
        shapes = [shape for body in bodies for shape in body.collision_shapes]
        fresh = untouched()
        friction = _most_common([friction_of(shape.physical_material) for shape in shapes], SceneDefaults.friction)
        moved = [body for body in bodies if isinstance(body, physx.PhysxRigidDynamicComponent)]
        moved += [body.articulation for body in bodies if isinstance(body, physx.PhysxArticulationLinkComponent)]

        def common(owners: list[Any], kind: str, names: tuple[str, ...]) -> Node:
            return {name: _most_common([getattr(each, name) for each in owners], fresh[kind][name]) for name in names}

        return SceneDefaults(
            friction=tuple(friction),
            shape=common(shapes, "shape", _SHAPE_DEFAULTS),
            body=common(moved, "body", _BODY_DEFAULTS),
        )

    def _entity(self, entity: Any, bodies: LiveBodyReader, robots: ArticulationReader, entities: Node) -> None:
        body: Any = None
        look: Any = None
        for component in entity.components:
            if isinstance(component, physx.PhysxRigidBaseComponent):
                body = component
            elif isinstance(component, render.RenderBodyComponent):
                look = component
        if isinstance(body, physx.PhysxArticulationLinkComponent):
            if body.is_root:
                self._articulation(body.articulation, robots, entities)
            return
        if body is None and look is None:
            return
        name = self.names.of(entity)
        self._mounts[id(entity)] = (entity, name)
        node = bodies.body(name, body, look)
        pose = pose_value(entity.pose)
        node |= {} if pose is None else {"pose": pose}
        node |= {"hidden": True} if self.names.rename(entity.name) in self._hidden else {}
        entities[name] = node

    def _articulation(self, articulation: Any, robots: ArticulationReader, entities: Node) -> None:
        name = self.names.of(articulation)
        entities[name] = robots.entity(name, articulation, is_only=not self._many_robots)
        for link in articulation.links:
            entity = link.entity
            self._mounts[id(entity)] = (entity, f"{name}/{self.names.of(entity)}")

    def _constraints(self, components: list[Any]) -> Node:
        found: Node = {}
        for component in components:
            if isinstance(component, COMPONENTS):
                parent = None if component.parent is None else self._mount(component.parent.entity)
                name = self._name(component.name, "constraint")
                child = self._mount(component.entity) or ""
                node = read_constraint(component, parent or "world", child, self._recording, name, self.problems)
                if node is not None:
                    found[name] = {**node, "collide": True} if self._collide(component, name) else node
        return found

    def _collide(self, component: Any, name: str) -> bool:
        """Returns whether both bodies of a component collide. The engine has no getter for it."""
        parent = component.parent
        bodies = (each for each in component.entity.components if isinstance(each, physx.PhysxRigidBaseComponent))
        body: Any = next(bodies, None)
        if parent is None or body is None:
            return False
        if self._recording is not None:
            return self._recording.has_ended_joint(body, parent)
        groups = [[shape.get_collision_groups() for shape in each.collision_shapes] for each in (body, parent)]
        if any(groups_collide(a, b) for a in groups[0] for b in groups[1]):
            self.problems.append(
                f"whether the bodies of the constraint `{name}` collide with each other;"
                " build the scene in `scenecc.record()`"
            )
        return False

    def _read_lights_and_cameras(self, components: list[Any]) -> Node:
        found: dict[str, Node] = {"lights": {}, "cameras": {}}
        for component in components:
            kind = type(component).__name__
            if kind in LIGHTS:
                mount = self._mount(component.entity)
                name = self._name(component.name or component.entity.name, LIGHTS[kind])
                found["lights"][name] = light(component, self._files, mount)
            elif isinstance(component, render.RenderCameraComponent):
                name = self._name(component.name or component.entity.name, "camera")
                found["cameras"][name] = camera(component, self._mount(component.entity))
        return {section: nodes for section, nodes in found.items() if nodes}

    def _mount(self, entity: Any) -> str | None:
        found = self._mounts.get(id(entity))  # the entities are kept alive, so that ids stay unique
        return None if found is None else found[1]

    def _name(self, given: str, otherwise: str) -> str:
        plain = language_name(self.names.rename(given)) or otherwise
        if plain != (self.names.rename(given) or otherwise):
            self.problems.append(f"the name {given!r} is not valid in a scene file: it becomes `{plain}`")
        return self._taken.new(plain)


def _find_named_object(entity: Any) -> tuple[Any, str] | None:
    """Returns the object named after an entity, and a default name; None if there is no such object."""
    bodies: list[Any] = [each for each in entity.components if isinstance(each, physx.PhysxRigidBaseComponent)]
    component: Any = bodies[0] if bodies else None
    if isinstance(component, physx.PhysxArticulationLinkComponent):
        return (component.articulation, "articulation") if component.is_root else None
    seen = any(isinstance(each, render.RenderBodyComponent) for each in entity.components)
    return (entity, "body") if component is not None or seen else None


def _ignoring_articulations(components: list[Any]) -> int:
    links = [each for each in components if isinstance(each, physx.PhysxArticulationLinkComponent)]
    ignoring = [link for link in links if any(shape.get_collision_groups()[2] for shape in link.collision_shapes)]
    return len({link.articulation.name for link in ignoring})


def has_render_system(scene: Any) -> bool:
    """Returns whether a scene has a render system."""
    return _render_system(scene) is not None


def _render_system(scene: Any) -> Any:
    try:
        return scene.render_system
    except RuntimeError:  # a scene without one
        return None


def _most_common(values: list[Any], otherwise: Any) -> Any:
    return Counter(values).most_common(1)[0][0] if values else otherwise


def _physics(scene: Any, defaults: SceneDefaults) -> Node:
    node: Node = {}
    if not same_single([scene.timestep], [0.01]):
        node["timestep"] = float(scene.timestep)
    fresh, config = physx.PhysxSceneConfig(), scene.physx_system.config
    for name in SCENE_CONFIG_FIELDS:
        value = plain_value(getattr(config, name))
        if value != plain_value(getattr(fresh, name)):
            node[name] = value
    if not same_single(defaults.friction, SceneDefaults.friction):
        node["default_material"] = physical_material(defaults.friction)["physical"]
    own = untouched()
    for part, given in (("shape", defaults.shape), ("body", defaults.body)):
        node |= {name: plain_value(value) for name, value in given.items() if value != own[part][name]}
    return node


COMPONENTS: Final = (physx.PhysxDriveComponent, physx.PhysxDistanceJointComponent, physx.PhysxGearComponent)
"""SAPIEN's components that connect two bodies."""

_AXES: Final = ("x", "y", "z", "twist")

_DRIVES: Final = (*_AXES, "swing", "slerp")


def read_constraint(
    component: Any, parent: str, child: str, recording: Recording | None, name: str, problems: list[str]
) -> Node | None:
    """Returns a component that connects two bodies. `parent`, `child`: ENTITY or ENTITY/LINK, or "world".

    None: a drive without limits and drives, which has no effect.
    """
    node: Node = {}
    if isinstance(component, physx.PhysxDriveComponent):
        node |= _drive(component, recording)
        if not node.keys() & {"limits", "drive"}:
            unknown = "; build the scene in `scenecc.record()` if it locks axes" if recording is None else ""
            problems.append(f"the drive `{name}` between `{parent}` and `{child}`, which has no effect{unknown}")
            return None
    elif isinstance(component, physx.PhysxGearComponent):
        node |= {"type": "gear", "ratio": to_number(component.gear_ratio)}
        node |= {"enable_hinges": True} if component.is_hinges_enabled else {}
    else:
        limit = recording.call_of(component, "set_limit") if recording is not None else None
        if limit is None:
            problems.append(f"the limits of the distance joint `{name}`; build the scene in `scenecc.record()`")
            limit = (0.0, 0.0)
        low, high, stiffness, damping = (*to_numbers(limit), 0.0, 0.0)[:4]
        node |= {"type": "distance", "limits": [low, high]}
        node |= {key: value for key, value in (("stiffness", stiffness), ("damping", damping)) if value}
    node |= {"parent": parent, "child": child}
    node["pose_in_parent"] = pose_value(component.pose_in_parent) or [0.0, 0.0, 0.0]
    in_child = pose_value(component.pose_in_child)
    node |= {} if in_child is None else {"pose_in_child": in_child}
    return node | ({} if component.is_enabled else {"enabled": False})


def _drive(component: Any, recording: Recording | None) -> Node:
    node: Node = {"type": "drive"}
    limits: Node = {}
    springs: Node = {}
    for axis in _AXES:
        given = recording.call_of(component, f"set_limit_{axis}") if recording is not None else None
        found = getattr(component, f"get_limit_{axis}")()
        if given is None and found == _fresh_limits()[axis]:
            continue
        low, high, stiffness, damping = (*(given or found), 0.0, 0.0)[:4]
        limits[axis] = [to_number(low), to_number(high)]
        spring = {key: to_number(value) for key, value in (("stiffness", stiffness), ("damping", damping)) if value}
        springs |= {axis: spring} if spring else {}
    node |= {"limits": limits} if limits else {}
    node |= {"limit_springs": springs} if springs else {}
    drives = {axis: found for axis in _DRIVES if (found := _axis_drive(component, axis))}
    node |= {"drive": drives} if drives else {}
    target = pose_value(component.get_drive_target())
    node |= {} if target is None else {"target": target}
    velocities = {
        key: to_numbers(value)
        for key, value in zip(("linear", "angular"), component.get_drive_velocity_target(), strict=True)
        if any(value)
    }
    node |= {"velocity_target": velocities} if velocities else {}
    for name in ("inv_mass_scales", "inv_inertia_scales"):
        given = recording.call_of(component, f"set_{name}") if recording is not None else None
        if given is not None and not same_single(given, (1, 1)):
            node[name] = to_numbers(given)
    return node


@cache
def _fresh_limits() -> dict[str, Any]:
    fresh = physx.PhysxDriveComponent(physx.PhysxRigidDynamicComponent())
    return {axis: getattr(fresh, f"get_limit_{axis}")() for axis in _AXES}


def _axis_drive(component: Any, axis: str) -> Node:
    stiffness, damping, force_limit, mode = getattr(component, f"get_drive_property_{axis}")()
    node: Node = {key: to_number(value) for key, value in (("stiffness", stiffness), ("damping", damping)) if value}
    if not node:
        return {}
    if not same_single([force_limit], [FLOAT32_MAX]) and not math.isinf(force_limit):
        node["force_limit"] = to_number(force_limit)
    return node if str(mode) == "force" else {**node, "mode": str(mode)}
