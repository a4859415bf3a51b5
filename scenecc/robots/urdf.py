"""Reads a URDF into a `RobotDescription` with exactly the numbers that SAPIEN's `URDFLoader` passes to its builders.

Differences from the loader:

- `scale` and `collision_is_visual` are applied here. `load_multiple_collisions_from_file`, decomposition, materials,
  densities and patch radii are applied when the description is built. `fix_root_link` is set in the scene.
- `package_dir` is searched first. SAPIEN's loader accepts it but does not search it.
- `effort`, `velocity` and `friction`, which the loader drops, are kept. So is `mimic`, with URDF's meaning.
- A link below a floating joint is a separate robot. The loader does this for single links only.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.plan.articulation import MAX_LINKS
from scenecc.plan.geometry import LYING_SOLIDS, SOLIDS
from scenecc.robots.description import (
    DescribedCollision,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
    Geometry,
    RobotDescription,
)
from scenecc.robots.files import OTHER_FORMAT_HINTS, FileReport, ReadBudget, RobotFiles, read_robot_bytes
from scenecc.robots.urdf_joints import (
    LinkTree,
    build_link_trees,
    check_mimics,
    move_over_fixed_joints,
    read_joint,
    read_joint_element,
    resolve_fixed_mimics,
    scale_mimics,
)
from scenecc.robots.urdf_links import UrdfMaterials, read_geometry, read_inertial, read_origin
from scenecc.robots.urdf_masses import has_mass, weigh_links
from scenecc.robots.xml import SourceElement, XmlBounds, parse_xml, read_text_attribute

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from pathlib import Path
    from typing import Literal

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location, Origin
    from scenecc.source.paths import AssetScope, Refusal, ResolvedFile


@frozen
class _ElementSchema:
    """Attributes and children that an element may have.

    Attributes:
        attributes: known attributes.
        left: attributes of other programs, which are ignored.
        single: children that may occur once; only the first is read.
        many: children that may be repeated.
        skipped: children that do not affect rigid bodies and are not checked.
    """

    attributes: tuple[str, ...] = ()
    single: tuple[str, ...] = ()
    many: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()
    left: tuple[str, ...] = ()


_ELEMENT_SCHEMAS: dict[str, _ElementSchema] = {
    "robot": _ElementSchema(
        ("name", "version"),
        many=("link", "joint", "material"),
        skipped=("transmission", "gazebo", "sensor", "mujoco"),
    ),
    "link": _ElementSchema(("name", "type"), ("inertial",), ("visual", "collision")),
    "inertial": _ElementSchema((), ("origin", "mass", "inertia")),
    "visual": _ElementSchema(("name",), ("origin", "geometry", "material")),
    "collision": _ElementSchema(("name",), ("origin", "geometry")),
    "origin": _ElementSchema(("xyz", "rpy")),
    "mass": _ElementSchema(("value",)),
    "inertia": _ElementSchema(("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    "geometry": _ElementSchema(many=(*SOLIDS, "mesh")),
    "box": _ElementSchema(("size",)),
    "sphere": _ElementSchema(("radius",)),
    **dict.fromkeys(LYING_SOLIDS, _ElementSchema(("radius", "length"))),
    "mesh": _ElementSchema(("filename", "scale")),
    "material": _ElementSchema(("name",), ("color", "texture")),
    "color": _ElementSchema(("rgba",)),
    "texture": _ElementSchema(("filename",)),
    "joint": _ElementSchema(
        ("name", "type"),
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
        skipped=("safety_controller", "calibration", "hardwareInterface"),
    ),
    "parent": _ElementSchema(("link",)),
    "child": _ElementSchema(("link",)),
    "axis": _ElementSchema(("xyz",)),
    "limit": _ElementSchema(("lower", "upper", "effort", "velocity")),
    "dynamics": _ElementSchema(("damping", "friction"), left=("D", "K", "mu_coulomb", "mu_viscous")),
    "mimic": _ElementSchema(("joint", "multiplier", "offset")),
}


def check_urdf_schema(robot: SourceElement, findings: FileReport) -> None:
    """Warns about unknown elements and attributes (SC454) and about cameras (SC470)."""
    stack = [robot]
    while stack:
        element = stack.pop()
        kind = _ELEMENT_SCHEMAS[element.tag]
        for name in element.attributes:
            if name not in kind.attributes + kind.left and ":" not in name and name != "xmlns":
                _report_unknown(element, name, kind, findings)
        found: set[str] = set()
        for child in element.children:
            if child.tag in kind.single or child.tag in kind.many:
                if child.tag in found and child.tag in kind.single:
                    what = f"a second <{child.tag}> in <{element.tag}> is ignored"
                    findings.report_once("SC454", f"second {element.tag}/{child.tag}", what, child.location)
                    continue
                found.add(child.tag)
                stack.append(child)
            elif child.tag in kind.skipped:
                _check_sensor(child, findings)
            else:
                known = kind.single + kind.many + kind.skipped
                near = findings.guess(f"{element.tag}/{child.tag}", child.tag, known)
                hint = _XACRO_HINT if child.tag.startswith("xacro:") else near and f"did you mean <{near}>?"
                findings.report_once(
                    "SC454",
                    f"{element.tag}/{child.tag}",
                    f"<{cut(child.tag)}> in <{element.tag}> is unknown and ignored",
                    child.location,
                    hint,
                )


_XACRO_HINT = "this is a xacro file: convert it with `xacro robot.urdf.xacro > robot.urdf`"


def _report_unknown(element: SourceElement, name: str, kind: _ElementSchema, findings: FileReport) -> None:
    near = findings.guess(f"{element.tag}@{name}", name, kind.attributes)
    findings.report_once(
        "SC454",
        f"{element.tag}@{name}",
        f"`{cut(name)}` of <{element.tag}> is unknown and ignored",
        element.at(name),
        near and f"did you mean `{near}`?",
    )


def _check_sensor(element: SourceElement, findings: FileReport) -> None:
    """Warns about a camera, at the top level or for Gazebo, that SAPIEN's loader would build."""
    sensors = [element] if element.tag == "sensor" else list(element.all("sensor"))
    for sensor in sensors:
        if sensor.find("camera") is not None:
            findings.report_once(
                "SC470",
                "camera",
                "cameras of a URDF are not built",
                sensor.location,
                "declare it under `cameras` of the scene, with `mount: ROBOT/LINK`",
            )


MAX_IGNORED_PAIRS = 31
"""Number of bits that SAPIEN's loader assigns."""


@frozen
class IgnoredPair:
    """Names of two links that do not collide."""

    first: str
    second: str
    location: Location


def read_srdf(
    path: Path, file: str, links: Iterable[str], findings: FileReport, repair: frozenset[str] = frozenset()
) -> tuple[IgnoredPair, ...]:
    """Returns the pairs that SAPIEN's loader uses: those with the reason `Default`.

    Pairs with the reasons `Adjacent` and `Never` are skipped, since they have no effect. Any other reason is SC474.

    Args:
        path: path of the SRDF.
        file: displayed file name.
        links: names of the robot's links; a pair with any other name is SC471.
        findings: receives the errors.
        repair: with "files", pairs with unknown links are left out.
    """
    data = read_robot_bytes(path, file, findings, XmlBounds().size)
    root = None if data is None else parse_xml(data, file, findings)
    if root is None:
        return ()
    if root.tag != "robot":
        findings.report("SC453", f"the root of an SRDF is <robot>, not <{cut(root.tag)}>", root.location)
        return ()
    known = dict.fromkeys(links)
    pairs: list[IgnoredPair] = []
    others: list[SourceElement] = []
    unknown: list[SourceElement] = []
    for element in root.all("disable_collisions"):
        reason = element.attributes.get("reason", "").lower()
        if reason != "default":
            if reason not in {"adjacent", "never"}:
                others.append(element)
        elif "files" in repair and _names_unknown_link(element, known):
            unknown.append(element)
        elif (pair := _read_pair(element, known, findings)) is not None:
            pairs.append(pair)
    if unknown:
        message = f"{len(unknown)} pairs with links that the robot does not have are left out"
        findings.report("SC488", message, unknown[0].location)
    if others:
        findings.report(
            "SC474",
            f"{len(others)} disabled pairs have a reason other than `Default`, so SAPIEN ignores them",
            others[0].location,
            hint='write reason="Default" for pairs that must not collide',
        )
    return tuple(pairs)


def _names_unknown_link(element: SourceElement, links: Mapping[str, None]) -> bool:
    names = (element.attributes.get(attribute, "") for attribute in ("link1", "link2"))
    return any(name.strip() and name not in links for name in names)


def _read_pair(element: SourceElement, links: Mapping[str, None], findings: FileReport) -> IgnoredPair | None:
    names = [read_text_attribute(element, attribute, findings) for attribute in ("link1", "link2")]
    is_good = True
    for attribute, name in zip(("link1", "link2"), names, strict=True):
        if name is not None and name not in links:
            is_good = False
            near = findings.near(name, links)
            hint = f"{near}; or" if near else "fix it, or"
            findings.report(
                "SC471",
                f"the robot has no link `{cut(name)}`",
                element.at(attribute),
                hint=f"{hint} set `repair: [files]` in the scene: the pair is then left out",
            )
    first, second = names
    if first is None or second is None or not is_good:
        return None
    if first == second:
        findings.report("SC471", f"link `{cut(first)}` is paired with itself", element.at("link2"))
        return None
    return IgnoredPair(first, second, element.location)


def assign_ignore_bits(
    links: Sequence[str], parents: Sequence[int | None], pairs: Iterable[IgnoredPair], findings: FileReport
) -> tuple[list[int], tuple[Location, ...]]:
    """Returns the ignore bits of each link of one robot, and the pair of each bit.

    Each pair gets one bit, except parent and child, which never collide.

    Args:
        links: link names in build order.
        parents: index of each link's parent.
        pairs: pairs of the whole file; pairs with links of other robots are skipped.
        findings: receives SC473 if there are more pairs than bits.
    """
    numbers = {name: index for index, name in enumerate(links)}
    bits = [0] * len(links)
    found: list[Location] = []
    for pair in pairs:
        first, second = numbers.get(pair.first), numbers.get(pair.second)
        if first is None or second is None or parents[first] == second or parents[second] == first:
            continue
        if len(found) == MAX_IGNORED_PAIRS:
            findings.report(
                "SC473",
                f"more than {MAX_IGNORED_PAIRS} pairs of links must not collide, but there are no more bits",
                pair.location,
                hint="remove pairs that never touch, or set `disable_self_collisions: true`",
            )
            break
        bits[first] |= 1 << len(found)
        bits[second] |= 1 << len(found)
        found.append(pair.location)
    return bits, tuple(found)


MAX_SHAPES = 4096
"""Maximum number of links, and of joints, in a file."""

_URDF_SUFFIX = ".urdf"


def read_urdf(
    file: ResolvedFile,
    *,
    scope: AssetScope,
    sink: Sink,
    origin: Origin | None = None,
    scale: float = 1.0,
    collision_is_visual: bool = False,
    srdf: ResolvedFile | Literal["sibling"] | None = "sibling",
    srdf_origin: Origin | None = None,
    package: Callable[[str], ResolvedFile | Refusal] | None = None,
    repair: frozenset[str] = frozenset(),
    name: str | None = None,
    budget: ReadBudget | None = None,
) -> RobotDescription | None:
    """Reads the robots of a URDF; returns None after errors, which are reported.

    Args:
        file: the URDF, as resolved by `scenecc.source.paths.resolve_path`.
        scope: folders that may be read; meshes, textures and the SRDF must be inside.
        sink: receives errors at the file's own lines: SC401 to SC407 for files that it names, SC450 to SC479 for the
            rest.
        origin: the scene node that names the file, reported with each finding.
        scale: factor of all lengths, finite and above 0; masses and inertias are scaled at constant density.
        collision_is_visual: whether collision shapes are also visual shapes.
        srdf: file with the pairs of links that do not collide; "sibling": the SRDF of the same name beside the URDF, if
            any.
        srdf_origin: the scene node that names the SRDF; default: `origin`.
        package: resolves a `package://` path in the folder that the scene gives; None: the scene gives none.
        repair: "inertia", "mass", "limits", "files" and "shapes": faults to repair (SC488) rather than refuse.
        name: displayed file name; default: its URI.
        budget: shared by all files of the scene; None: no budget.
    """
    name = file.uri if name is None else name
    findings = FileReport(sink, origin, budget=budget)
    data = read_robot_bytes(file.path, name, findings, XmlBounds().size)
    root = None if data is None else parse_xml(data, name, findings)
    if root is None:
        return None
    if root.tag != "robot":
        message = f"the root of a URDF is <robot>, not <{cut(root.tag)}>"
        findings.report("SC453", message, root.location, hint=OTHER_FORMAT_HINTS.get(root.tag))
        return None
    files = RobotFiles(file, scope, package, repairs="files" in repair)
    pairing = FileReport(sink, srdf_origin or origin)
    return _UrdfReader(
        root, files, findings, pairing, float(scale), repair, collision_is_visual=collision_is_visual
    ).read(srdf)


def _is_empty(robot: DescribedRobot) -> bool:
    root, *others = robot.links
    return not (others or root.collisions or root.visuals or root.inertial)


class _UrdfReader:
    """Reads one URDF. `pairing` receives the errors of the SRDF."""

    def __init__(
        self,
        root: SourceElement,
        files: RobotFiles,
        findings: FileReport,
        pairing: FileReport,
        scale: float,
        repair: frozenset[str],
        *,
        collision_is_visual: bool,
    ) -> None:
        self._root = root
        self._files = files
        self._findings = findings
        self._pairing = pairing
        self._scale = scale
        self._collision_is_visual = collision_is_visual
        self._repair = repair
        self._looks = UrdfMaterials(root, files, findings)
        self._massless: set[str] = set()

    def read(self, srdf: ResolvedFile | Literal["sibling"] | None) -> RobotDescription | None:
        """Returns the robot, or None after an error."""
        findings = self._findings
        for tag in ("link", "joint"):
            if (count := sum(1 for _ in self._root.all(tag))) > MAX_SHAPES:
                message = f"the file is too large: it has {count} {tag}s, and the limit is {MAX_SHAPES}"
                findings.report("SC452", message, self._root.location)
        if findings.errors:
            return None
        check_urdf_schema(self._root, findings)
        links = self._index_by_name("link")
        rows = [
            row
            for element in self._index_by_name("joint").values()
            if (row := read_joint_element(element, findings)) is not None
        ]
        if not links and not findings.errors:
            findings.report("SC455", "<robot> has no <link>", self._root.location)
        # Otherwise links below a faulty joint would be reported as having no parent.
        whole = not findings.errors
        # Both elements of a duplicate name are read, to report their other errors.
        read = [self._link(element) for element in self._root.all("link")]
        described = {link.name: link for link in reversed(read)}
        made = (read_joint(row, self._scale, findings, self._repair) for row in rows if row.kind != "floating")
        scaled = scale_mimics({joint.name: joint for joint in made if joint is not None}, self._scale)
        joints = resolve_fixed_mimics(scaled, findings)
        pairs = self._pairs(srdf, links)
        branches = build_link_trees(links, rows, findings) if whole else None
        if branches is None or findings.errors or self._pairing.errors:
            return None
        robots = tuple(
            self._robot(branch, described, joints, pairs, is_first=index == 0) for index, branch in enumerate(branches)
        )
        if findings.errors or self._pairing.errors:
            return None
        # Above a floating joint there is often a link `world` with nothing in it.
        robots = robots[1:] if _is_empty(robots[0]) and not all(map(_is_empty, robots)) else robots
        return RobotDescription(robots, tuple(self._files.found.values()))

    def _index_by_name(self, tag: str) -> dict[str, SourceElement]:
        """Returns the elements with a tag by name, in file order. Reports duplicate names (SC460)."""
        named: dict[str, SourceElement] = {}
        for element in self._root.all(tag):
            name = read_text_attribute(element, "name", self._findings)
            first = element if name is None else named.setdefault(name, element)
            if first is not element:
                self._findings.report(
                    "SC460",
                    f"there are two {tag}s named `{cut(element.attributes['name'])}`",
                    element.at("name"),
                    related=[("the first is here", first.at("name"), "value")],
                )
        return named

    def _pairs(
        self, srdf: ResolvedFile | Literal["sibling"] | None, links: dict[str, SourceElement]
    ) -> tuple[IgnoredPair, ...]:
        path = self._files.owner.path
        if srdf == "sibling":
            is_named = path.name.endswith(_URDF_SUFFIX)
            srdf = self._files.find_sibling(path.name.removesuffix(_URDF_SUFFIX) + ".srdf") if is_named else None
        if srdf is None:
            return ()
        named = self._files.add(srdf, self._root.location)
        return read_srdf(named.path, named.uri, links, self._pairing, self._repair)

    def _link(self, element: SourceElement) -> DescribedLink:
        """Returns a link without its parent, and without its faulty parts, which are reported."""
        collisions: list[DescribedCollision] = []
        visuals: list[DescribedVisual] = []
        name = element.attributes.get("name", "")
        for visual in element.all("visual"):
            shape = self._shape(visual, name)
            look = self._looks.of(visual)
            if shape is not None:
                geometry, pose, location = shape
                visuals.append(DescribedVisual(geometry, pose, location, visual.attributes.get("name", ""), look))
        for collision in element.all("collision"):
            shape = self._shape(collision, name)
            if shape is not None:
                collisions.append(DescribedCollision(*shape))
                if self._collision_is_visual:
                    visuals.append(DescribedVisual(*shape))
        inertial = read_inertial(element, len(collisions), self._scale, self._findings, self._repair)
        if not has_mass(element):
            self._massless.add(name)
        return DescribedLink(
            name,
            element.location,
            collisions=tuple(collisions),
            visuals=tuple(visuals),
            inertial=inertial,
        )

    def _shape(self, element: SourceElement, link: str) -> tuple[Geometry, Pose7, Location] | None:
        pose = read_origin(element, self._scale, self._findings)
        # A shape with a faulty pose is still read, to report its other errors.
        shape = read_geometry(
            element, pose or IDENTITY_POSE, self._scale, self._files, self._findings, link, self._repair
        )
        return None if pose is None else shape

    def _robot(
        self,
        branch: LinkTree,
        described: dict[str, DescribedLink],
        joints: dict[str, DescribedJoint],
        pairs: tuple[IgnoredPair, ...],
        *,
        is_first: bool,
    ) -> DescribedRobot:
        findings = self._findings
        root = described[branch.links[0]]
        floating = branch.joints[0]
        pose = None if floating is None else read_origin(floating.element, self._scale, findings)
        if len(branch.links) > MAX_LINKS:
            findings.report(
                "SC477",
                f"the robot has {len(branch.links)} links, and the engine's limit is {MAX_LINKS}",
                described[branch.links[MAX_LINKS]].location,
                hint="merge links that are fixed together",
            )
        numbers = {name: index for index, name in enumerate(branch.links)}
        below = [row for row in branch.joints[1:] if row is not None]
        tree = move_over_fixed_joints(branch, joints, findings)
        joints = dict(tree.joints)
        parents = [None, *(numbers[tree.parents[row.child]] for row in below)]
        # A link collides neither with its parent nor with its parent in the file.
        own = (IgnoredPair(name, parent, described[name].location) for name, parent in tree.moved.items())
        pairs = (*pairs, *own)
        bits, ignored = assign_ignore_bits(branch.links, parents, pairs, self._pairing)
        check_mimics([joints[row.name] for row in below], findings)
        links = [
            replace(described[name], parent=parent, joint=row and joints[row.name], ignore_bits=own_bits)
            for name, parent, row, own_bits in zip(branch.links, parents, [None, *below], bits, strict=True)
        ]
        return DescribedRobot(
            links=weigh_links(links, self._massless, findings, self._repair),
            body_type="dynamic" if len(branch.links) == 1 else None,
            fixed=None if is_first else False,
            pose=pose or IDENTITY_POSE,
            location=root.location,
            ignored=ignored,
        )
