"""Records, while a scene is built, what SAPIEN has no getter for: mesh and robot files, tendons, some limits."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial, wraps
from importlib import import_module
from typing import Any, cast
from weakref import WeakKeyDictionary


@dataclass(frozen=True)
class MeshSource:
    """Source of a collision mesh.

    Attributes:
        type: shape type in a scene file: "convex_mesh", "convex_parts" or "triangle_mesh".
        file: as passed to the engine; for CoACD parts, the original file.
        keys: `sdf`, `decomposition` and `decomposition_params`, unless default.
        parts: whether the shape is one of several parts of a file.
        load: number of the load; parts of one load share it.
    """

    type: str
    file: str
    keys: dict[str, Any] = field(default_factory=dict[str, Any])
    parts: bool = False
    load: int = 0


@dataclass(frozen=True)
class RobotSource:
    """The URDF of a robot.

    Attributes:
        file: as passed to the loader.
        options: other loader options, as keys of a scene file.
    """

    file: str
    options: dict[str, Any] = field(default_factory=dict[str, Any])


class Recording:
    """A recording. It keeps the engine's objects alive, since it identifies them by `id`."""

    def __init__(self) -> None:
        self._meshes: dict[int, tuple[Any, MeshSource]] = {}
        self._calls: dict[int, tuple[Any, dict[str, tuple[Any, ...]]]] = {}
        self._decomposed: dict[str, tuple[str, dict[str, Any]]] = {}
        self._loads = 0
        self._links: dict[int, tuple[Any, Any, RobotSource | None]] = {}
        self.cubemaps: dict[int, tuple[Any, tuple[str, ...]]] = {}
        self.tendons: dict[int, tuple[Any, list[tuple[Any, ...]]]] = {}
        self._joints: dict[frozenset[int], tuple[tuple[Any, Any], int]] = {}

    def mesh_of(self, shape: Any) -> MeshSource | None:
        """Returns the source of a live collision shape; None if it was not recorded."""
        found = self._meshes.get(id(shape))
        return None if found is None else found[1]

    def call_of(self, component: Any, name: str) -> tuple[Any, ...] | None:
        """Returns the arguments of the last call of a setter; None if there was no call."""
        found = self._calls.get(id(component))
        return None if found is None else found[1].get(name)

    def robot_of(self, root: Any) -> RobotSource | None:
        """Returns the file of a root link's articulation; None if it was not recorded or not built from a file."""
        found = self._links.get(id(root))
        return None if found is None else found[2]

    def builder_of(self, link: Any) -> Any:
        """Returns the `LinkBuilder` of a live link, with its original joint frames; None if unknown."""
        found = self._links.get(id(link))
        return None if found is None else found[1]

    def has_ended_joint(self, body: Any, parent: Any) -> bool:
        """Returns whether a joint between two bodies has ended, and none was made since: PhysX lets them collide."""
        found = self._joints.get(frozenset((id(body), id(parent))))
        return found is not None and _count_joints(body, parent) <= found[1]

    def keep_joint(self, body: Any, parent: Any) -> None:
        """Records the joints between two bodies before another one is added."""
        self._joints[frozenset((id(body), id(parent)))] = ((body, parent), _count_joints(body, parent))

    def keep_link(self, link: Any, builder: Any, source: RobotSource | None) -> None:
        """Records what a link was built from."""
        self._links[id(link)] = (link, builder, source)

    def keep_mesh(self, shape: Any, type_: str, file: str, **keys: Any) -> None:
        """Records the file of a shape."""
        self._meshes[id(shape)] = (shape, MeshSource(type_, file, keys))

    def keep_parts(self, shapes: list[Any], file: str) -> None:
        """Records the file of several shapes loaded together."""
        self._loads += 1
        source, params = self._decomposed.get(file, (file, None))
        keys: dict[str, Any] = {} if params is None else {"decomposition": "coacd"}
        if params:
            keys["decomposition_params"] = params
        for shape in shapes:
            self._meshes[id(shape)] = (shape, MeshSource("convex_parts", source, keys, parts=True, load=self._loads))

    def keep_decomposition(self, result: str, file: str, params: dict[str, Any]) -> None:
        """Records the source file of a CoACD result."""
        self._decomposed[result] = (file, params)

    def keep_call(self, component: Any, name: str, arguments: tuple[Any, ...]) -> None:
        """Records the arguments of a setter without a getter."""
        self._calls.setdefault(id(component), (component, {}))[1][name] = arguments


def _count_joints(body: Any, parent: Any) -> int:
    """Returns the number of components that connect two bodies."""
    return sum(
        getattr(component, "parent", None) is other
        for one, other in ((body, parent), (parent, body))
        for component in (() if one.entity is None else one.entity.components)
    )


@contextmanager
def record() -> Generator[Recording]:
    """Records values that SAPIEN has no getter for, of scenes built in the block.

        with scenecc.record() as recording:
            env = gymnasium.make("PickCube-v1")
            env.reset(seed=0)
        print(scenecc.decompile(env, recording=recording).text)

    SAPIEN's classes are restored after the block, also after an error.
    """
    recording = Recording()
    undo: list[Callable[[], None]] = []
    try:
        _record_meshes(recording, undo)
        _record_calls(recording, undo)
        _record_joints(recording, undo)
        _record_robots(recording, undo)
        yield recording
    finally:
        for step in reversed(undo):
            step()


def _replace(owner: Any, name: str, make: Callable[[Any], Any], undo: list[Callable[[], None]]) -> None:
    """Replaces an attribute of a class or module by a wrapper of it."""
    own = name in vars(owner)
    before: Any = cast("dict[str, Any]", vars(owner)).get(name)
    setattr(owner, name, make(getattr(owner, name)))
    undo.append(lambda: setattr(owner, name, before) if own else delattr(owner, name))


def _record_meshes(recording: Recording, undo: list[Callable[[], None]]) -> None:
    from scenecc.backends.sapien.engine import physx  # noqa: PLC0415 - importing this module loads no engine

    def one(kind: str, init: Any) -> Any:
        """Returns a constructor that records the mesh file of its shape."""

        @wraps(init)
        def recorded(self: Any, *args: Any, **options: Any) -> None:
            init(self, *args, **options)
            file = options.get("filename", args[0] if args else None)
            if isinstance(file, str):
                sdf = kind == "triangle_mesh" and options.get("sdf", args[3] if len(args) > 3 else False)
                recording.keep_mesh(self, kind, file, **({"sdf": True} if sdf else {}))

        return recorded

    def several(load: Any) -> Any:

        @wraps(load)
        def recorded(*args: Any, **options: Any) -> Any:
            shapes = load(*args, **options)
            recording.keep_parts(list(shapes), options["filename"] if "filename" in options else args[0])
            return shapes

        return staticmethod(recorded)

    _replace(physx.PhysxCollisionShapeConvexMesh, "__init__", partial(one, "convex_mesh"), undo)
    _replace(physx.PhysxCollisionShapeTriangleMesh, "__init__", partial(one, "triangle_mesh"), undo)
    _replace(physx.PhysxCollisionShapeConvexMesh, "load_multiple", several, undo)

    actor_builder: Any = import_module("sapien.wrapper.actor_builder")

    def decomposed(coacd: Any) -> Any:

        @wraps(coacd)
        def recorded(filename: str, **params: Any) -> str:
            result = coacd(filename, **params)
            recording.keep_decomposition(result, filename, params)
            return result

        return recorded

    _replace(actor_builder, "do_coacd", decomposed, undo)


_SETTERS = {
    "PhysxDistanceJointComponent": ("set_limit",),
    "PhysxDriveComponent": (
        "set_inv_mass_scales",
        "set_inv_inertia_scales",
        *(f"set_limit_{axis}" for axis in ("x", "y", "z", "twist")),
    ),
}
"""Setters without a getter. The engine's limits do not distinguish a locked axis from a free one."""


def _record_calls(recording: Recording, undo: list[Callable[[], None]]) -> None:
    from scenecc.backends.sapien.engine import physx, render  # noqa: PLC0415 - importing this module loads no engine

    def setter(name: str) -> Callable[[Any], Any]:
        """Returns a function that wraps a setter, so that its arguments are recorded."""

        def make(call: Any) -> Any:

            @wraps(call)
            def recorded(self: Any, *args: Any, **options: Any) -> Any:
                recording.keep_call(self, name, (*args, *options.values()))
                return call(self, *args, **options)

            return recorded

        return make

    for class_, names in _SETTERS.items():
        for name in names:
            owner = getattr(physx, class_)
            if hasattr(owner, name):
                _replace(owner, name, setter(name), undo)

    def cubemap(init: Any) -> Any:

        @wraps(init)
        def recorded(self: Any, *files: Any, **options: Any) -> None:
            init(self, *files, **options)
            recording.cubemaps[id(self)] = (self, (*files, *options.values()))

        return recorded

    def tendon(create: Any) -> Any:

        @wraps(create)
        def recorded(self: Any, *args: Any, **options: Any) -> Any:
            recording.tendons.setdefault(id(self), (self, []))[1].append((*args, *options.values()))
            return create(self, *args, **options)

        return recorded

    _replace(render.RenderCubemap, "__init__", cubemap, undo)
    _replace(physx.PhysxArticulation, "create_fixed_tendon", tendon, undo)


def _record_joints(recording: Recording, undo: list[Callable[[], None]]) -> None:
    from scenecc.backends.sapien.engine import physx  # noqa: PLC0415 - importing this module loads no engine

    bodies: WeakKeyDictionary[Any, Any] = WeakKeyDictionary()  # a joint that is kept alive would not end

    def made(init: Any) -> Any:

        @wraps(init)
        def recorded(self: Any, body: Any) -> None:
            init(self, body)
            bodies[self] = body

        return recorded

    def connected(call: Any) -> Any:

        @wraps(call)
        def recorded(self: Any, parent: Any) -> None:
            if parent is not None and self in bodies:
                recording.keep_joint(bodies.pop(self), parent)
            call(self, parent)

        return recorded

    for name in ("PhysxDriveComponent", "PhysxDistanceJointComponent", "PhysxGearComponent"):
        _replace(getattr(physx, name), "__init__", made, undo)
    _replace(physx.PhysxJointComponent, "set_parent", connected, undo)
    _replace(physx.PhysxJointComponent, "parent", lambda own: property(own.fget, connected(own.fset)), undo)


def _record_robots(recording: Recording, undo: list[Callable[[], None]]) -> None:
    actor_builder: Any = import_module("sapien.wrapper.actor_builder")
    urdf_loader: Any = import_module("sapien.wrapper.urdf_loader")

    def parse(call: Any) -> Any:
        """Returns a `parse` that keeps the robot's file at the builder of each link."""

        @wraps(call)
        def recorded(self: Any, file: Any, *args: Any, **options: Any) -> Any:
            parsed = call(self, file, *args, **options)
            source = RobotSource(str(file), _loader_options(self, args, options))
            for builder in parsed[0]:
                for link in builder.link_builders:
                    link.scenecc_source = source
            return parsed

        return recorded

    def physical(build: Any) -> Any:
        """Returns a `build_physx_component` that records how a link was built."""

        @wraps(build)
        def recorded(self: Any, *args: Any, **options: Any) -> Any:
            component = build(self, *args, **options)
            if getattr(self, "joint_record", None) is not None:
                recording.keep_link(component, self, getattr(self, "scenecc_source", None))
            return component

        return recorded

    _replace(actor_builder.ActorBuilder, "build_physx_component", physical, undo)
    _replace(urdf_loader.URDFLoader, "parse", parse, undo)


def _loader_options(loader: Any, args: tuple[Any, ...], options: dict[str, Any]) -> dict[str, Any]:
    """Returns a loader's options, as keys of a scene file."""
    srdf = options.get("srdf_file", args[0] if args else None)
    given = {
        "srdf": srdf,
        "scale": getattr(loader, "scale", 1.0),
        "fix_root_link": getattr(loader, "fix_root_link", True),
        "load_multiple_collisions": getattr(loader, "load_multiple_collisions_from_file", False),
        "disable_self_collisions": getattr(loader, "disable_self_collisions", False),
    }
    usual = {"srdf": None, "scale": 1.0, "load_multiple_collisions": False, "disable_self_collisions": False}
    return {key: value for key, value in given.items() if key not in usual or value != usual[key]}
