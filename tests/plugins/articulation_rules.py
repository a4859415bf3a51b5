"""The rules across the fields of articulations: what of a tree, of its joints and of what is said of them is valid."""

from __future__ import annotations

import math
import re
from random import Random
from typing import NamedTuple

from plugins.scene_nodes import (
    FALLBACK,
    SHAPE_LISTS,
    Node,
    articulations,
    ascending,
    colliding,
    drop,
    keep_one,
    links,
    shapes,
    units,
)

from scenecc.spec.references import MAX_PATTERN_LENGTH

LINK_NAMES = ("base", "l.1", "L-2", "_tip", "arm_3")
JOINT_NAMES = ("j0", "j.1", "J-2", "_wrist", "hinge_4")
"""By the number of the link; names that patterns have to match as they are, and by their beginnings."""


class Joint(NamedTuple):
    """A joint that moves; `name` is "" where it has none."""

    name: str
    limits: tuple[float, float]
    is_hinge: bool = True


class Robot(NamedTuple):
    """What may be named of an articulation: `joints` in SAPIEN's order, and the links that hang on hinges."""

    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    hinged: tuple[str, ...]


_ARM = (Joint("shoulder", (-1.5, 1.5)), Joint("elbow", (0.1, 2.5)))
FILES: dict[str, Robot] = {
    "articulations/arm.urdf": Robot(("base", "upper", "lower", "tip"), _ARM, ("upper", "lower")),
    "articulations/long_arm.urdf": Robot(
        ("base", "upper", "lower", "tip"),
        (*_ARM, Joint("wrist", (-math.inf, math.inf))),
        ("upper", "lower", "tip"),
    ),
    "articulations/swing.xml": Robot(("stand", "bob"), (Joint("swing", (-1, 1)),), ("bob",)),
}
"""The robots' files of the good scenes that hold one robot each."""


def robot_of(entity: Node) -> Robot:
    """What may be named of an articulation or a part whose tree is mended, with all that is attached to it."""
    robot = _alone(entity)
    for name, part in entity.get("attach", {}).items():
        prefix, inner = part.get("prefix", f"{name}/"), robot_of(part)
        held = [_limited(joint, part) for joint in inner.joints]
        joints = [joint._replace(name=joint.name and prefix + joint.name) for joint in held]
        robot = Robot(
            (*robot.links, *(prefix + link for link in inner.links)),
            (*robot.joints, *joints),
            (*robot.hinged, *(prefix + link for link in inner.hinged)),
        )
    return robot


def _alone(entity: Node) -> Robot:
    """The same without what is attached to it, but with the joint by which it is attached itself."""
    robot, joint = _file_or_tree(entity), entity.get("joint")
    if joint is None or joint["type"] == "fixed":
        return robot
    hinged = (robot.links[0], *robot.hinged) if joint_turns(joint) else robot.hinged
    return Robot(robot.links, (_joint_of(joint), *robot.joints), hinged)


def _file_or_tree(entity: Node) -> Robot:
    file = entity.get("urdf", entity.get("mjcf"))
    if file is not None:
        return FILES[file]
    tree = links(entity)
    deep: list[tuple[int, Joint]] = []
    depths = {id(tree[0][0]): 0}
    for link, parent in tree[1:]:
        depths[id(link)] = depths[id(parent)] + 1
        joint = link["joint"]
        if joint["type"] != "fixed":
            deep.append((depths[id(link)], _joint_of(joint)))
    deep.sort(key=lambda one: one[0])
    hinged = tuple(link["name"] for link, parent in tree if parent is not None and joint_turns(link["joint"]))
    return Robot(tuple(link["name"] for link, _ in tree), tuple(joint for _, joint in deep), hinged)


def _joint_of(joint: Node) -> Joint:
    degrees = joint.get("limits_deg", (-math.inf, math.inf))
    limits = joint.get("limits", [math.radians(side) for side in degrees])
    return Joint(joint.get("name", ""), tuple(limits), joint["type"] != "prismatic")


def joint_turns(joint: Node) -> bool:
    return joint["type"] not in {"fixed", "prismatic"}


def tree_links(document: Node, random: Random) -> None:
    """Links and joints of a tree are called otherwise, each; a joint may have no name."""
    for entity in units(document):
        if "joint" in entity:
            _one_joint(entity["joint"], random)
            entity["joint"]["name"] = "mount"
            drop(entity, "pose")
            drop(entity["joint"], "mimic")
        for number, (link, parent) in enumerate(links(entity)):
            link["name"] = LINK_NAMES[number]
            if parent is None:
                continue
            joint = link["joint"]
            drop(joint, "name")
            if "mimic" in joint or random.random() < 0.8:
                joint["name"] = JOINT_NAMES[number]
            _one_joint(joint, random)
        _followers(entity, random)


def _one_joint(joint: Node, random: Random) -> None:
    """A joint is placed in URDF's way or in SAPIEN's, and has no key that does nothing on one of its type."""
    keep_one(joint, random, ("origin", "axis"), ("pose_in_parent", "pose_in_child"))
    keep_one(joint, random, ("limits",), ("limits_deg",))
    keep_one(joint, random, ("damping",), ("friction_force",))
    for key in ("limits", "limits_deg"):
        if key in joint:
            joint[key] = ascending(joint[key], random)
    match joint["type"]:
        case "fixed":
            drop(joint, "friction", "friction_force", "damping", "armature", "max_velocity", "axis", "limits", "mimic")
            drop(joint, "limits_deg")
        case "continuous":
            drop(joint, "limits", "limits_deg")
        case "prismatic":
            drop(joint, "limits_deg")


def _followers(entity: Node, random: Random) -> None:
    """A joint follows one that it hangs on, or an earlier one of the same link's, with no fixed one between them."""
    tree = links(entity)
    parents = {id(link): parent for link, parent in tree}
    for number, (link, parent) in enumerate(tree):
        if parent is None or "mimic" not in link["joint"]:
            continue
        above: list[Node] = [one for one, other in tree[:number] if other is parent]
        at: Node | None = parent
        while at is not None and at.get("joint", {"type": "fixed"})["type"] != "fixed":
            above.append(at)
            at = parents[id(at)]
        joints = [one["joint"] for one in above]
        names = [joint["name"] for joint in joints if "name" in joint and joint["type"] != "fixed"]
        if not names:
            del link["joint"]["mimic"]
            continue
        mimic = link["joint"]["mimic"]
        mimic["joint"] = random.choice(names)
        if mimic.get("multiplier") == 0:
            mimic["multiplier"] = -0.5


def attachments(document: Node, random: Random) -> None:
    """Parts are attached to links that there are, of the whole or of parts before them; no two names are the same."""
    for entity in units(document):
        parts = entity.pop("attach", {})
        for name, part in parts.items():
            known = robot_of(entity).links
            part["to"] = random.choice(known)
            if "ignore" in part:
                part["ignore"] = random.sample(known, 1)
            if "prefix" in part:
                part["prefix"] = random.choice([f"{name}_", f"{name}/x/", f"{name}.{name}-"])
            entity.setdefault("attach", {})[name] = part


def files(document: Node, random: Random) -> None:
    """What is said of a file's meshes does something."""
    for entity in units(document):
        if "decomposition_params" in entity or entity.get("decomposition") == "coacd":
            entity["load_multiple_collisions"] = True


def single_bodies(document: Node, random: Random) -> None:
    """What is one body has no key of an articulation that moves, nor any link of its own to name."""
    for entity in articulations(document):
        if "attach" in entity:
            drop(entity, "body_type")
        if "body_type" in entity:
            drop(entity, *_OF_MOVING)
            for link, _ in links(entity):
                drop(link, "visibility")


_OF_MOVING = (
    *("qvel", "drives", "fix_root_link", "linear_velocity", "angular_velocity", "gravity", "sleep_threshold"),
    *("solver_position_iterations", "solver_velocity_iterations", "disable_self_collisions", "sapien_bits"),
    *("links", "joints"),
)


def link_bodies(document: Node, random: Random) -> None:
    """No plane moves, what moves weighs something, and no key of a link means nothing."""
    for entity in units(document):
        tree = links(entity)
        for link, _ in tree:
            for shape in colliding(link):
                if shape["type"] == "plane":
                    shape.clear()
                    shape.update(FALLBACK)
        weighs = {id(link): bool(colliding(link)) or "inertial" in link for link, _ in tree}
        for link, parent in reversed(tree):
            moves = (
                "to" in entity or not entity.get("fix_root_link")
                if parent is None
                else link["joint"]["type"] != "fixed"
            )
            if moves and not weighs[id(link)]:
                link["shapes"] = [dict(FALLBACK)]
                weighs[id(link)] = True
            if parent is not None and weighs[id(link)]:
                weighs[id(parent)] = True
        for link, _ in tree:
            _link_keys(link)


def _link_keys(link: Node) -> None:
    if not shapes(link, "shapes", "visuals"):
        drop(link, "visibility")
    if not colliding(link):
        drop(link, "collision_bits", "collision_group", "density", "patch_radius", "min_patch_radius")
    if not shapes(link, *SHAPE_LISTS):
        drop(link, "material")
    if not _weighs(link):
        drop(link, "mass", "com")


def whole(document: Node, random: Random) -> None:
    """No key of the whole means nothing: where no joint moves, where the root is fixed, where nothing collides."""
    for entity in units(document):
        if not robot_of(entity).joints:
            drop(entity, "qpos", "qvel")
    for entity in articulations(document):
        tree = [link for link, _ in links(entity)]
        if entity.get("fix_root_link", "root" not in entity):
            drop(entity, "linear_velocity", "angular_velocity")
        if "qpos" not in entity:
            drop(entity, "beyond_limits")
        if tree and not any(shapes(link, "shapes", "visuals") for link in tree):
            drop(entity, "visibility")
        if tree and not any(map(colliding, tree)):
            drop(entity, *_OF_COLLIDING)
        if tree and not any(shapes(link, *SHAPE_LISTS) for link in tree):
            drop(entity, "material")


def _weighs(link: Node) -> bool:
    """Whether a mass has something that it scales."""
    return bool(colliding(link)) or "inertial" in link


_OF_COLLIDING = ("density", "patch_radius", "min_patch_radius", "collision_group", "disable_self_collisions")


def patterns(document: Node, random: Random) -> None:
    """Patterns match something that there is."""
    for entity in units(document):
        robot = robot_of(entity)
        joints = [joint.name for joint in robot.joints if joint.name]
        for section, names in (("links", list(robot.links)), ("joints", joints), ("drives", joints)):
            said = entity.pop(section, {})
            if said and names:
                entity[section] = {_pattern(names, random): keys for keys in said.values()}
        heavy = _heavy(entity)
        for pattern, keys in entity.get("links", {}).items():
            if any(re.fullmatch(pattern, name) and name not in heavy for name in robot.links):
                drop(keys, "mass", "com")
        for pattern, keys in entity.get("joints", {}).items():
            keep_one(keys, random, ("limits",), ("limits_deg",))
            slide = any(not joint.is_hinge and re.fullmatch(pattern, joint.name) for joint in robot.joints)
            if slide:
                drop(keys, "limits_deg")
            if "attach" in entity:  # the positions that a part gives are within the limits that it gives
                drop(keys, "limits", "limits_deg")
            for key in {"limits", "limits_deg"} & set(keys):
                keys[key] = ascending(keys[key], random)


def _heavy(entity: Node) -> set[str]:
    """The links that weigh something; of a file's it is not known."""
    found = {link["name"] for link, _ in links(entity) if _weighs(link)}
    for name, part in entity.get("attach", {}).items():
        found |= {part.get("prefix", f"{name}/") + link for link in _heavy(part)}
    return found


def _pattern(names: list[str], random: Random) -> str:
    name = random.choice(names)
    forms = [".*", name, f"{name[:2]}.*", "|".join(names), f"({name})?", f"[^x]{{{len(name)}}}"]
    short = [form for form in forms if len(form) <= MAX_PATTERN_LENGTH]
    return random.choice([form for form in short if any(re.fullmatch(form, one) for one in names)])


def joint_numbers(document: Node, random: Random) -> None:
    """As many numbers as there are joints that move, or some by name; positions within the limits that hold."""
    for entity in units(document):
        joints = [_limited(joint, entity) for joint in robot_of(entity).joints]
        for key in ("qpos", "qvel"):
            if key not in entity:
                continue
            bound = key == "qpos" and not entity.get("beyond_limits")
            numbers = [_number(joint, random, bound=bound) for joint in joints]
            named = {joint.name: number for joint, number in zip(joints, numbers, strict=True) if joint.name}
            some = random.sample(list(named), random.randint(0, len(named)))
            listed = random.random() < 0.5 and "attach" not in entity
            entity[key] = numbers if listed else {name: named[name] for name in some}


def _limited(joint: Joint, entity: Node) -> Joint:
    """A joint with the limits that patterns give it, the last that has any."""
    for pattern, keys in entity.get("joints", {}).items():
        if not re.fullmatch(pattern, joint.name):
            continue
        if "limits" in keys:
            joint = joint._replace(limits=tuple(keys["limits"]))
        elif "limits_deg" in keys:
            joint = joint._replace(limits=tuple(map(math.radians, keys["limits_deg"])))
    return joint


def _number(joint: Joint, random: Random, *, bound: bool) -> float:
    number = random.choice([0, random.uniform(-3, 3), round(random.uniform(-3, 3), 2)])
    return min(max(number, joint.limits[0]), joint.limits[1]) if bound else number


def link_copies(document: Node, random: Random) -> None:
    """A link is there once; one on which nothing hangs, and that no joint moves, may be there twice."""
    for entity in units(document):
        for number, (link, _) in enumerate(links(entity)):
            if "if" in link:
                link["if"] = random.choice([True, "${true}"])
            if "repeat" in link:
                idle = link["joint"]["type"] == "fixed" and "name" not in link["joint"] and not link.get("children")
                link["repeat"] = {f"k{number}": random.choice([[""], ["", "_again"]]) if idle else [""]}
                link["name"] += f"${{k{number}}}"
