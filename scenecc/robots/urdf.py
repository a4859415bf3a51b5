"""Reads a URDF into a `RobotDescription`, in the numbers that SAPIEN's `URDFLoader` gives its builders, to the bit.

What the loader takes as it is and what is left to others:

- Its `scale` and `collision_is_visual` act here. `load_multiple_collisions_from_file`, the decomposition, materials,
  densities and patch radii are of what is built from a description, and `fix_root_link` is the scene's to say.
- `package_dir` is searched first (SAPIEN's loader takes it, but searches elsewhere only).
- `effort`, `velocity` and `friction`, which the loader drops, are in the description; so is `mimic`, by URDF's meaning.
- A link below a floating joint is a robot of its own; the loader does this for single links only.
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
    """What an element may hold.

    Attributes:
        attributes: names.
        left: names of attributes of other programs, which are ignored.
        single: children that may occur once; only the first is read.
        many: children that may be repeated.
        skipped: children that are irrelevant to rigid body simulation, and are not checked.
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
    """Warns of every kind of element and attribute that a URDF does not have (SC454), and of sensors (SC470)."""
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
                    what = f"a second <{child.tag}> in <{element.tag}> is not read"
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
                    f"<{cut(child.tag)}> in <{element.tag}> is not known and not read",
                    child.location,
                    hint,
                )


_XACRO_HINT = "the file is a xacro: make it a URDF by `xacro robot.urdf.xacro > robot.urdf`"


def _report_unknown(element: SourceElement, name: str, kind: _ElementSchema, findings: FileReport) -> None:
    near = findings.guess(f"{element.tag}@{name}", name, kind.attributes)
    findings.report_once(
        "SC454",
        f"{element.tag}@{name}",
        f"`{cut(name)}` of <{element.tag}> is not known and not read",
        element.at(name),
        near and f"did you mean `{near}`?",
    )


def _check_sensor(element: SourceElement, findings: FileReport) -> None:
    """Warns of a camera, of which SAPIEN's loader makes one, at the top or for Gazebo."""
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
    """Two links that do not collide, by name."""

    first: str
    second: str
    location: Location


def read_srdf(
    path: Path, file: str, links: Iterable[str], findings: FileReport, repair: frozenset[str] = frozenset()
) -> tuple[IgnoredPair, ...]:
    """The pairs that SAPIEN's loader uses: those with the reason `Default`.

    Pairs with the reasons `Adjacent` and `Never` are skipped, since they make no difference; any other reason is SC474.

    Args:
        path: of the SRDF.
        file: its name as shown to people.
        links: names of the robot's links; a pair of another is SC471.
        findings: where faults are reported.
        repair: with "files", a pair of another link is left out.
    """
    data = read_robot_bytes(path, file, findings, XmlBounds().size)
    root = None if data is None else parse_xml(data, file, findings)
    if root is None:
        return ()
    if root.tag != "robot":
        findings.report("SC453", f"an SRDF is a <robot>, and this is a <{cut(root.tag)}>", root.location)
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
        message = f"pairs of links that the robot does not have: {len(unknown)}, which are left out"
        findings.report("SC488", message, unknown[0].location)
    if others:
        findings.report(
            "SC474",
            f"pairs not to collide with another reason than `Default`: {len(others)}, and SAPIEN ignores them",
            others[0].location,
            hint='write reason="Default" where a pair is not to collide',
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
            hint = f"{near}; or" if near else "mend it, or"
            findings.report(
                "SC471",
                f"the robot has no link `{cut(name)}`",
                element.at(attribute),
                hint=f"{hint} let the scene say `repair: [files]`: the pair is then left out",
            )
    first, second = names
    if first is None or second is None or not is_good:
        return None
    if first == second:
        findings.report("SC471", f"the link `{cut(first)}` is paired with itself", element.at("link2"))
        return None
    return IgnoredPair(first, second, element.location)


def assign_ignore_bits(
    links: Sequence[str], parents: Sequence[int | None], pairs: Iterable[IgnoredPair], findings: FileReport
) -> tuple[list[int], tuple[Location, ...]]:
    """The bits of each link of one robot, and for each bit its pair.

    Each pair takes the next bit, except parent and child, which never collide.

    Args:
        links: names, in build order.
        parents: number of each one's parent.
        pairs: of the whole file; one of another robot's links is not looked at.
        findings: takes SC473, for more pairs than there are bits.
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
                f"more than {MAX_IGNORED_PAIRS} pairs of links are not to collide, and there is a bit for so many",
                pair.location,
                hint="leave out pairs that never meet, or say `disable_self_collisions: true`",
            )
            break
        bits[first] |= 1 << len(found)
        bits[second] |= 1 << len(found)
        found.append(pair.location)
    return bits, tuple(found)


MAX_SHAPES = 4096
"""How many links and joints a file has, in all its robots."""

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
    """The robots of a URDF; None where the file is wrong, all that is wrong having been reported.

    Args:
        file: the URDF, as `scenecc.source.paths.resolve_path` finds it.
        scope: what may be read; meshes, textures and the SRDF are looked for inside.
        sink: takes what is wrong, at the file's own lines: codes SC401 to SC407 for files that it names, SC450 to
            SC479 for the rest.
        origin: the node of the scene that names the file, reported with each finding.
        scale: of all lengths, with masses and inertias of the same densities; finite and above 0.
        collision_is_visual: whether collision shapes are visual shapes as well.
        srdf: pairs of links that do not collide; "sibling": from the file of the same name next to it, if any.
        srdf_origin: the node of the scene that names the SRDF; None: that of the URDF led to it.
        package: finds what follows `package://` in the folder that the scene gives; None: it gives none.
        repair: of "inertia", "limits", "files" and "shapes", what is repaired rather than refused; each repair is told
            (SC488).
        name: the file's name as shown to people; None: its uri.
        budget: of all files of the scene; None: it is read alone.
    """
    name = file.uri if name is None else name
    findings = FileReport(sink, origin, budget=budget)
    data = read_robot_bytes(file.path, name, findings, XmlBounds().size)
    root = None if data is None else parse_xml(data, name, findings)
    if root is None:
        return None
    if root.tag != "robot":
        message = f"a URDF is a <robot>, and this is a <{cut(root.tag)}>"
        findings.report("SC453", message, root.location, hint=OTHER_FORMAT_HINTS.get(root.tag))
        return None
    files = RobotFiles(file, scope, package, repairs="files" in repair)
    pairing = FileReport(sink, srdf_origin or origin)
    return _UrdfReader(root, files, findings, pairing, float(scale), repair, is_seen=collision_is_visual).read(srdf)


class _UrdfReader:
    """One reading. `pairing`: takes what is wrong with the SRDF."""

    def __init__(
        self,
        root: SourceElement,
        files: RobotFiles,
        findings: FileReport,
        pairing: FileReport,
        scale: float,
        repair: frozenset[str],
        *,
        is_seen: bool,
    ) -> None:
        self._root = root
        self._files = files
        self._findings = findings
        self._pairing = pairing
        self._scale = scale
        self._is_seen = is_seen
        self._repair = repair
        self._looks = UrdfMaterials(root, files, findings)

    def read(self, srdf: ResolvedFile | Literal["sibling"] | None) -> RobotDescription | None:
        """The whole, where nothing of it is wrong."""
        findings = self._findings
        for tag in ("link", "joint"):
            if (count := sum(1 for _ in self._root.all(tag))) > MAX_SHAPES:
                message = f"the file is too large: it has {count} {tag}s, and {MAX_SHAPES} are read"
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
        # Otherwise links of a wrong joint would be reported to have no parent.
        whole = not findings.errors
        # Of two with one name both are read, for what else is wrong with them.
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
        return (
            None
            if findings.errors or self._pairing.errors
            else RobotDescription(robots, tuple(self._files.found.values()))
        )

    def _index_by_name(self, tag: str) -> dict[str, SourceElement]:
        """The elements of a kind by name, in the order of the file; two of one name are SC460."""
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
        """A link without its place in the tree. What is wrong with it is left out and reported."""
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
                if self._is_seen:
                    visuals.append(DescribedVisual(*shape))
        inertial = read_inertial(element, len(collisions), self._scale, self._findings, self._repair)
        return DescribedLink(
            name,
            element.location,
            collisions=tuple(collisions),
            visuals=tuple(visuals),
            inertial=inertial,
        )

    def _shape(self, element: SourceElement, link: str) -> tuple[Geometry, Pose7, Location] | None:
        pose = read_origin(element, self._scale, self._findings)
        # A shape whose pose is wrong is read all the same, for what else is wrong with it.
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
                f"the robot has {len(branch.links)} links, and the engine counts {MAX_LINKS}",
                described[branch.links[MAX_LINKS]].location,
                hint="join links that are fixed to one another",
            )
        numbers = {name: index for index, name in enumerate(branch.links)}
        below = [row for row in branch.joints[1:] if row is not None]
        tree = move_over_fixed_joints(branch, joints, findings)
        joints = dict(tree.joints)
        parents = [None, *(numbers[tree.parents[row.child]] for row in below)]
        # A link does not collide with its parent: nor with that of the file.
        own = (IgnoredPair(name, parent, described[name].location) for name, parent in tree.moved.items())
        pairs = (*pairs, *own)
        bits, ignored = assign_ignore_bits(branch.links, parents, pairs, self._pairing)
        check_mimics([joints[row.name] for row in below], findings)
        return DescribedRobot(
            links=tuple(
                replace(described[name], parent=parent, joint=row and joints[row.name], ignore_bits=own_bits)
                for name, parent, row, own_bits in zip(branch.links, parents, [None, *below], bits, strict=True)
            ),
            body_type="dynamic" if len(branch.links) == 1 else None,
            fixed=None if is_first else False,
            pose=pose or IDENTITY_POSE,
            location=root.location,
            ignored=ignored,
        )
