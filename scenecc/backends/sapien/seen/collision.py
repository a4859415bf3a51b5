"""What collides, drawn in place of what is seen: from the engine's shapes, as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.backends.sapien.engine import physx, render
from scenecc.plan.rendering import COLLISION_COLORS

if TYPE_CHECKING:
    from collections.abc import Callable

ENDLESS: Final = 1e4
"""Half the side of a plane [m], as in SAPIEN's viewer."""


def _mesh(shape: Any, material: Any) -> Any:
    """Each face for itself, so that edges show: corners that faces share would make them look round."""
    corners = np.asarray(shape.vertices * shape.scale, np.float32)[shape.triangles]
    if np.prod(shape.scale) < 0:
        corners = corners[:, ::-1]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(np.float32).tiny)
    faces = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    return render.RenderShapeTriangleMesh(
        corners.reshape(-1, 3), faces, np.repeat(normals, 3, axis=0), np.zeros((0, 2), np.float32), material
    )


_DRAWN: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "PhysxCollisionShapeBox": lambda shape, material: render.RenderShapeBox(shape.half_size, material),
    "PhysxCollisionShapeSphere": lambda shape, material: render.RenderShapeSphere(shape.radius, material),
    "PhysxCollisionShapeCapsule": lambda shape, material: render.RenderShapeCapsule(
        shape.radius, shape.half_length, material
    ),
    "PhysxCollisionShapeCylinder": lambda shape, material: render.RenderShapeCylinder(
        shape.radius, shape.half_length, material
    ),
    "PhysxCollisionShapePlane": lambda shape, material: render.RenderShapePlane([1, ENDLESS, ENDLESS], material),  # noqa: ARG005
    "PhysxCollisionShapeConvexMesh": _mesh,
    "PhysxCollisionShapeTriangleMesh": _mesh,
}
"""SAPIEN's collision shapes by class: the render shape of the same form."""


class CollisionShown:
    """Draws bodies as they collide: a material a type of body, for all of them."""

    def __init__(self) -> None:
        self._materials = {kind: render.RenderMaterial(base_color=color) for kind, color in COLLISION_COLORS.items()}

    def show(self, entity: Any) -> None:
        """Replaces what is seen of a `sapien.Entity` by its collision shapes; nothing is seen where there are none."""
        for component in entity.components:
            if isinstance(component, render.RenderBodyComponent):
                entity.remove_component(component)
        for component in entity.components:
            if isinstance(component, physx.PhysxRigidBaseComponent) and component.collision_shapes:
                entity.add_component(self._body(component))

    def _body(self, component: Any) -> Any:
        body: Any = render.RenderBodyComponent()
        material = self._materials[_kind(component)]
        for shape in component.collision_shapes:
            drawn = _DRAWN[type(shape).__name__](shape, material)
            drawn.local_pose = shape.local_pose
            body.attach(drawn)
        body.name = component.name
        return body


def _kind(component: Any) -> str:
    if isinstance(component, physx.PhysxArticulationLinkComponent):
        return "link"
    if isinstance(component, physx.PhysxRigidStaticComponent):
        return "static"
    return "kinematic" if component.kinematic else "dynamic"
