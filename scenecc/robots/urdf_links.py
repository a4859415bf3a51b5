"""URDF links as SAPIEN's loader passes them to its builders: poses, shapes, inertials and materials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3
from scenecc.plan.geometry import LYING_SOLIDS, SOLIDS
from scenecc.plan.properties import FLOAT32_MAX, FLOAT32_MIN
from scenecc.robots.description import (
    DescribedInertial,
    DescribedMaterial,
    DescribedTexture,
    Geometry,
    MeshGeometry,
    SolidGeometry,
    ball_moment,
)
from scenecc.robots.poses import compose_poses, pose_numbers, pose_of_matrix
from scenecc.robots.xml import (
    SourceElement,
    read_number_attribute,
    read_numbers,
    read_text_attribute,
    read_vector3,
    warn_if_degrees,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.files import FileReport, RobotFiles

GEOMETRY_TAGS = (*SOLIDS, "mesh")

_Z_TO_X_POSE = pose_numbers((0.0, 0.0, 0.0), (0.7071068, 0.0, 0.7071068, 0.0))
"""Rotates SAPIEN's round solids (axis x) to URDF's (axis z)."""


def read_origin(element: SourceElement, scale: float, findings: FileReport) -> Pose7 | None:
    """Returns the pose in an element's <origin>, the identity if it has none; None after an error."""
    origin = element.find("origin")
    if origin is None:
        return IDENTITY_POSE
    xyz = read_vector3(origin, "xyz", findings) if "xyz" in origin.attributes else (0.0, 0.0, 0.0)
    rpy = read_vector3(origin, "rpy", findings) if "rpy" in origin.attributes else None
    if xyz is None or (rpy is None and "rpy" in origin.attributes):
        return None
    matrix: NDArray[np.float64] = np.eye(4)
    matrix[:3, 3] = np.array(xyz) * scale
    if rpy is not None:
        warn_if_degrees(rpy, "a rotation", origin.at("rpy"), findings)
        matrix[:3, :3] = _rpy_matrix(rpy)
    return pose_of_matrix(matrix)


def _rpy_matrix(rpy: Vec3) -> list[list[Any]]:
    """Returns the rotation by roll about x, then pitch about y, then yaw about z."""
    # With arrays: NumPy's sines of arrays and of scalars may differ in the last bit.
    cosines, sines = np.cos(np.array(rpy)), np.sin(np.array(rpy))
    c3, c2, c1 = cosines
    s3, s2, s1 = sines
    return [
        [c1 * c2, (c1 * s2 * s3) - (c3 * s1), (s1 * s3) + (c1 * c3 * s2)],
        [c2 * s1, (c1 * c3) + (s1 * s2 * s3), (c3 * s1 * s2) - (c1 * s3)],
        [-s2, c2 * s3, c2 * c3],
    ]


def read_geometry(
    element: SourceElement,
    pose: Pose7,
    scale: float,
    files: RobotFiles,
    findings: FileReport,
    link: str,
    repair: frozenset[str],
) -> tuple[Geometry, Pose7, Location] | None:
    """Returns the shape of a <visual> or <collision>, its pose, and the location of its geometry; None after an error.

    An empty <visual> is left out (SC491). `repair`: with "shapes", a <collision> without volume is left out (SC488).
    `link`: the link's name, for messages.
    """
    holder = element.find("geometry")
    if holder is None:
        findings.report("SC455", f"<{element.tag}> has no <geometry>", element.location)
        return None
    kinds = [child for child in holder.children if child.tag in GEOMETRY_TAGS]
    if len(kinds) != 1:
        what = "none" if not kinds else "more than one"
        names = ", ".join(f"<{name}>" for name in GEOMETRY_TAGS)
        place = kinds[1].location if kinds else holder.location
        findings.report("SC455", f"<geometry> contains {what} of {names}", place, hint="write one")
        return None
    kind = kinds[0]
    if kind.tag == "mesh":
        mesh = _read_mesh(kind, scale, files, findings, is_visual=element.tag == "visual")
        return None if mesh is None else (mesh, pose, kind.at("filename"))
    solid = _read_solid(element, kind, scale, findings, link, repair)
    # URDF's round solids point along z.
    own = compose_poses(pose, _Z_TO_X_POSE) if kind.tag in LYING_SOLIDS else pose
    return None if solid is None else (solid, own, kind.location)


def _read_solid(
    element: SourceElement,
    kind: SourceElement,
    scale: float,
    findings: FileReport,
    link: str,
    repair: frozenset[str],
) -> SolidGeometry | None:
    if kind.tag == "box":
        read = [("size", size) for size in read_vector3(kind, "size", findings) or ()]
    else:
        names = ("radius",) if kind.tag == "sphere" else ("radius", "length")
        read = [(name, read_number_attribute(kind, name, findings)) for name in names]
    sizes = [size for _, size in read if size is not None]
    hint = None
    if sizes and len(sizes) == len(read) and _is_empty(kind.tag, sizes, is_visual=element.tag == "visual"):
        message = f"<{kind.tag}> of `{cut(link)}` has size {' '.join(f'{size:g}' for size in sizes)}"
        if element.tag == "visual":
            message = f"{message} and is invisible: the <visual> is left out"
            findings.report("SC491", message, kind.location)
            return None
        if "shapes" in repair:
            message = f"{message} and no volume: the <collision> is left out"
            findings.report("SC488", message, kind.location)
            return None
        hint = "fix its size, or set `repair: [shapes]` in the scene: the <collision> is then left out"
    good: dict[str, bool] = {}
    for name, size in read:
        is_read = good.get(name, True) and size is not None
        good[name] = is_read and _check_size(kind, name, size or 0.0, scale, findings, hint)
    if not good or not all(good.values()):
        return None
    scaled = [size * scale for size in sizes]
    return SolidGeometry(
        kind.tag, (scaled[0] / 2.0 if kind.tag == "box" else scaled[0], *(size / 2.0 for size in scaled[1:]))
    )


def _is_empty(kind: str, sizes: Sequence[float], *, is_visual: bool) -> bool:
    """Returns whether sizes of 0 make a visual solid invisible or a collision solid empty."""
    if min(sizes) < 0:
        return False
    if kind == "box":
        return sizes.count(0) >= (2 if is_visual else 1)
    # A capsule of length 0 is a sphere; a visual cylinder of length 0 is a disc.
    return sizes[0] == 0 or (kind == "cylinder" and not is_visual and sizes[1] == 0)


def _check_size(
    kind: SourceElement, attribute: str, size: float, scale: float, findings: FileReport, hint: str | None
) -> bool:
    if FLOAT32_MIN <= size * scale <= FLOAT32_MAX:
        return True
    why = "is not above 0" if size <= 0 else "does not fit in single precision"
    message = f"the `{attribute}` of <{kind.tag}> contains {size:g}, which {why}"
    findings.report("SC466", message, kind.at(attribute), hint=hint)
    return False


def _read_mesh(
    kind: SourceElement,
    scale: float,
    files: RobotFiles,
    findings: FileReport,
    *,
    is_visual: bool,
) -> MeshGeometry | None:
    reference = read_text_attribute(kind, "filename", findings)
    repaired = "the <visual> is left out" if is_visual else None
    file = reference and files.find(reference, kind.at("filename"), findings, repaired=repaired)
    scales = read_vector3(kind, "scale", findings) if "scale" in kind.attributes else (1.0, 1.0, 1.0)
    if scales is not None and not all(FLOAT32_MIN <= abs(one * scale) <= FLOAT32_MAX for one in scales):
        why = "0" if 0.0 in scales else "a number that does not fit in single precision"
        findings.report("SC466", f"the `scale` of <mesh> contains {why}", kind.at("scale"))
        return None
    if not file or scales is None:
        return None
    factors = (scales[0] * scale, scales[1] * scale, scales[2] * scale)
    return MeshGeometry(file.uri, file.path, factors, optional_names=files.repairs)


def read_inertial(
    link: SourceElement, collisions: int, scale: float, findings: FileReport, repair: frozenset[str] = frozenset()
) -> DescribedInertial | None:
    """Returns a link's mass and inertia; None if it has none, if they are faulty, or if SAPIEN ignores them.

    Principal axes come from NumPy's LAPACK, as in SAPIEN's loader.

    Args:
        link: <link> element.
        collisions: number of its collision shapes.
        scale: factor of all lengths.
        findings: receives the errors.
        repair: with "inertia", a missing or impossible inertia is replaced by that of the collision shapes.
    """
    element = link.find("inertial")
    if element is None:
        return None
    before = findings.errors
    mass_element, tensor = element.find("mass"), element.find("inertia")
    name = cut(link.attributes.get("name", ""))
    repaired = (name, collisions) if "inertia" in repair else None
    if mass_element is None and repaired is not None:
        message = f"<inertial> of `{name}` has no <mass>: it is left out"
        findings.report("SC488", message, element.location)
        return None
    if mass_element is None:
        hint = "write it, or set `repair: [inertia]` in the scene: mass and inertia are then computed from the shapes"
        findings.report("SC455", "<inertial> has no <mass>", element.location, hint=hint)
    if tensor is None and repaired is None:
        findings.report("SC455", "<inertial> has no <inertia>", element.location, hint=_INERTIA_HINT)
    mass = None if mass_element is None else read_number_attribute(mass_element, "value", findings)
    pose = read_origin(element, scale, findings)
    inertia = _read_tensor(tensor, findings)
    if mass_element is not None and mass is not None and mass < 0:
        findings.report("SC467", f"the mass is {mass:g} kg, but cannot be negative", mass_element.at("value"))
    if mass is None or pose is None or findings.errors > before:
        return None
    if mass and not inertia.any() and repaired is not None:
        why = "there is no <inertia>" if tensor is None else "the inertia is 0"
        return _inertial_from_shapes(mass, pose, scale, why, tensor or element, repaired, findings)
    if mass and inertia.any() and tensor is not None:
        return _principal_inertia(mass, pose, inertia, scale, tensor, findings, repaired)
    if mass or inertia.any():
        kept = f"; with `repair: [inertia]` in the scene, the link keeps its {mass:.4g} kg" if mass else ""
        findings.report(
            "SC475",
            f"the inertia is 0, so SAPIEN ignores the whole <inertial>, with its mass of {mass:.4g} kg"
            if mass
            else "the mass is 0, so SAPIEN ignores the whole <inertial>",
            element.location,
            hint=f"mass and inertia are computed from the shapes and their densities{kept}",
        )
    return None


def _read_tensor(tensor: SourceElement | None, findings: FileReport) -> NDArray[np.float64]:
    """Returns the (3, 3) inertia tensor [kg·m²]; a missing or faulty number is 0."""
    read = [0.0 if tensor is None else read_number_attribute(tensor, name, findings) for name in _INERTIA_KEYS]
    # -0.0 is kept, to match SAPIEN to the bit.
    xx, xy, xz, yy, yz, zz = (0.0 if number is None else number for number in read)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64)


_INERTIA_HINT = "write it, or set `repair: [inertia]` in the scene: it is then computed from the collision shapes"


def _inertial_from_shapes(
    mass: float,
    pose: Pose7,
    scale: float,
    why: str,
    element: SourceElement,
    repaired: tuple[str, int],
    findings: FileReport,
) -> DescribedInertial:
    """Returns mass and centre of mass with the inertia of the collision shapes, or of a water sphere if none (SC488).

    `repaired`: the link's name and number of collision shapes.
    """
    mass *= scale**3
    name, count = repaired
    moments = None
    source = f"of its {count} collision shape{'s' if count > 1 else ''}, scaled to {mass:.4g} kg"
    if not count:
        moment = ball_moment(mass)
        moments, source = (moment, moment, moment), f"of a sphere of water of {mass:.4g} kg, {moment:.4g} kg·m²"
    message = f"{why}: the inertia of `{name}` becomes that {source}"
    findings.report("SC488", message, element.location)
    return DescribedInertial(mass, pose, moments, element.location, keeps_com=True)


_INERTIA_KEYS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _principal_inertia(
    mass: float,
    pose: Pose7,
    inertia: NDArray[np.float64],
    scale: float,
    tensor: SourceElement,
    findings: FileReport,
    repaired: tuple[str, int] | None,
) -> DescribedInertial | None:
    """Returns the inertial in principal axes. `repaired`: the link's name and number of collision shapes."""
    moments: Any
    axes: Any
    if np.array_equal(np.diag(np.diag(inertia)), inertia):
        moments, axes = np.diag(inertia), np.eye(3)
    else:
        moments, axes = np.linalg.eigh(inertia)
        if np.linalg.det(axes) < 0:
            axes[:, 2] = -axes[:, 2]
    shown = ", ".join(f"{moment:.4g}" for moment in moments)
    ordered = sorted(moments)
    breaks_triangle = ordered[0] + ordered[1] < ordered[2] * (1 - 1e-6)
    if repaired is not None and (ordered[0] <= 0 or breaks_triangle):
        why = f"principal moments of inertia {shown} are impossible"
        return _inertial_from_shapes(mass, pose, scale, why, tensor, repaired, findings)
    if not all(moment > 0 for moment in moments):
        findings.report(
            "SC467",
            f"the principal moments of inertia are {shown}, but all must be above 0",
            tensor.location,
            hint="SAPIEN refuses it: " + _INERTIA_HINT,
        )
        return None
    if breaks_triangle:
        findings.report_once(
            "SC468",
            "inertia",
            f"the principal moments of inertia are {shown}, but none may exceed the sum of the other two",
            tensor.location,
            "it is built as written, and so are others like it in this file, unless the scene sets `repair: [inertia]`",
        )
    matrix: NDArray[np.float64] = np.eye(4)
    matrix[:3, :3] = axes
    scaled = [float(moment) for moment in scale**5 * moments]
    return DescribedInertial(
        mass * scale**3, compose_poses(pose, pose_of_matrix(matrix)), (scaled[0], scaled[1], scaled[2]), tensor.location
    )


class UrdfMaterials:
    """Materials of one URDF."""

    def __init__(self, robot: SourceElement, files: RobotFiles, findings: FileReport) -> None:
        self._files = files
        self._findings = findings
        self._elements: dict[str, SourceElement] = {}
        self._read: dict[int, DescribedMaterial | None] = {}
        for element in robot.all("material"):
            self._add_shared(element)
        for link in robot.all("link"):
            for visual in link.all("visual"):
                element = visual.find("material")
                if element is not None and element.attributes.get("name"):
                    self._elements.setdefault(element.attributes["name"], element)

    def of(self, visual: SourceElement) -> DescribedMaterial | None:
        """Returns the material of a <visual>; None if it names none, or after an error.

        A material without colour and texture still overrides the mesh's own.
        """
        element = visual.find("material")
        if element is None:
            return None
        name = element.attributes.get("name", "")
        first = self._elements.get(name, element) if name else element
        if first is not element:
            self._compare(element, first)
        if id(first) not in self._read:
            self._read[id(first)] = self._look(first)
        return self._read[id(first)]

    def _add_shared(self, element: SourceElement) -> None:
        name = read_text_attribute(element, "name", self._findings)
        if name is None:
            return
        first = self._elements.setdefault(name, element)
        if first is not element:
            self._findings.report(
                "SC460",
                f"there are two materials named `{name}`",
                element.at("name"),
                related=[("the first is here", first.at("name"), "value")],
            )

    def _compare(self, element: SourceElement, first: SourceElement) -> None:
        """Warns about a material that differs from the first one of its name."""
        own, shared = _material_key(element), _material_key(first)
        if any(own) and own != shared:
            name = element.attributes["name"]
            self._findings.report_once(
                "SC476",
                name,
                f"material `{name}` differs from the first one of this name, which is used everywhere",
                element.location,
                hint=f"the first is on line {first.line + 1}; give this one a different name",
            )

    def _look(self, element: SourceElement) -> DescribedMaterial | None:
        color, texture = element.find("color"), element.find("texture")
        if color is not None:
            rgba = read_numbers(color, "rgba", 4, self._findings)
            if rgba is None:
                return None
            red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in rgba)
            return DescribedMaterial(base_color=(red, green, blue, alpha))
        if texture is None:
            return DescribedMaterial()
        reference = read_text_attribute(texture, "filename", self._findings)
        if reference is None:
            return None
        before = self._findings.errors
        place = texture.at("filename")
        file = self._files.find(reference, place, self._findings, repaired="the texture is left out")
        if file is None:
            return DescribedMaterial() if self._findings.errors == before else None
        return DescribedMaterial(base_color_texture=DescribedTexture(file.uri, file.path))


def _material_key(element: SourceElement) -> tuple[str | None, str | None]:
    color, texture = element.find("color"), element.find("texture")
    rgba = None if color is None else " ".join(color.attributes.get("rgba", "").split())
    return rgba, None if texture is None else texture.attributes.get("filename")
