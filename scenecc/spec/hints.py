"""Hints for common mistakes: unknown keys, misplaced keys, and values of a wrong kind."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, nearest
from scenecc.spec.nodes import is_mapping
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics.diagnostic import Path


_SHAPE = "write shapes in one of the lists `shapes`, `collisions` and `visuals`: `shapes: [{type: box, …}]`"

_TYPE = f"of a body it is `body_type: static`; {_SHAPE}"

_PHYSICAL = "write it under `physical`: `material: {physical: {…}}`"

_VISUAL = "write it under `visual`: `material: {visual: {…}}`"

_USE_ARGUMENTS = "write it beside `use`: `{use: FILE, with: {…}}`"

_USE = "did you mean `use`?"

_PICK = "write it beside `variants`: `{variants: [{…}, {…}], pick: …}`"

_ROBOT = "`variants` takes bodies only; the file of a robot can vary: `urdf: {cycle: [a.urdf, b.urdf]}`"

_ONE_OF = "an articulation has one of `urdf`, `mjcf` and `root`"

_OF_LINKS = "the links of a tree have shapes: `root: {shapes: […]}`; the shapes of a robot come from its file"

_LINK = "set it on links: `links: {NAME: {…: …}}`"

_FIX_ROOT_LINK = "did you mean `fix_root_link`?"

_DRIVE = "set it on drives: `drives: {JOINT: {stiffness: …, damping: …}}`"

_AGENT = (
    "give the robot's file, `urdf: …` or `mjcf: …`, or use ManiSkill's robots: "
    "`{use: scenecc:table_scene, with: {robot: …}}`"
)

_POSE = "did you mean `pose`?"

_LINK_POSE = "write it as the `origin` of its joint: `joint: {origin: …}`; of the root, beside `root`"

_LOOK_AT = "write it in the pose: `pose: {p: […], look_at: […]}`"

_HALF_LENGTH = "did you mean `half_length`? it is half of that"

_RADII = "a ring has an `inner_radius` and an `outer_radius`"

_COMMON_TO_VARIANTS = "write it beside `variants`, for all of them"

INSTANCE_HINT = (
    "a prefab may hold many objects: write `override: {{NAME: {{{key}: …}}}}` for one of them, or `with: {{{key}: …}}` "
    "where it has such a parameter"
)

VARIANTS_HINT = "use `variants` of the entity for differences in structure"

PARTS_HINT = "only the numbers, files, colours and materials inside it can vary, one by one"

PHYSICS_HINT = "settings under `physics` are the same in all scenes"

SEPARATE_ENTITIES_HINT = "declare an entity for each value, with `scene_idxs` of its own"

SHARED_ROBOT_KEYS = frozenset(
    (
        "beyond_limits",
        "disable_self_collisions",
        "sapien_bits",
        "collision_is_visual",
        "load_multiple_collisions",
        "decomposition",
    )
)
"""Keys of an articulation that are the same in all of its scenes."""

FORM_SYNONYMS = {
    **dict.fromkeys(("range", "random", "rand", "between", "min", "low"), "uniform: [low, high]"),
    **dict.fromkeys(("randint", "integer", "int"), "integers: [low, high]"),
    **dict.fromkeys(("gauss", "gaussian", "mean"), "normal: [mean, std]"),
    **dict.fromkeys(("one_of", "any_of", "options", "random_choice"), "choice: [a, b]"),
    **dict.fromkeys(("values", "list"), "per_scene: [a, b]"),
}
"""What other languages call the forms of variation."""

SYNTAX_HINTS: dict[str, str] = {
    "include": "write the files as a list: `include: [FILE]`",
    "repeat": "a number of copies is `{i: {count: 4}}`",
}
"""Key → how what stands there is written."""

MISSING_KEY_HINTS: dict[str, str] = {
    "pick": "it says which variant each scene has: `pick: {cycle: [0, 1]}`, or any form over their indices",
}
"""Missing key → what it is for."""

KEY_SYNONYMS = {
    "filename": "file",
    "color": "base_color",
    "position": "p",
    "quaternion": "q",
    "friction": "static_friction",
}
"""Unknown key → what it is called here, where letters alone would not tell."""

MISPLACED_KEY_HINTS: dict[str, tuple[tuple[str, str], ...]] = {
    "type": (("body_type", _TYPE),),
    **dict.fromkeys(("half_size", "half_length"), (("body_type", _SHAPE),)),
    "radius": (("body_type", _SHAPE), ("outer_radius", _RADII)),
    "thickness": (("outer_radius", _RADII),),
    **dict.fromkeys(("with", "prefix"), (("body_type", _USE_ARGUMENTS),)),
    **dict.fromkeys(("uses", "using", "prefab"), (("body_type", _USE),)),
    "pick": (("body_type", _PICK),),
    **dict.fromkeys(("urdf", "mjcf", "root"), (("body_type", _ROBOT), ("fix_root_link", _ONE_OF))),
    **dict.fromkeys(("shapes", "collisions", "visuals"), (("fix_root_link", _OF_LINKS),)),
    **dict.fromkeys(("mass", "inertial", "linear_damping", "angular_damping"), (("fix_root_link", _LINK),)),
    **dict.fromkeys(("fix_base", "fixed_base", "fixed", "use_fixed_base"), (("fix_root_link", _FIX_ROOT_LINK),)),
    **dict.fromkeys(("stiffness", "damping", "force_limit"), (("fix_root_link", _DRIVE), ("armature", _DRIVE))),
    **dict.fromkeys(("uid", "robot", "robot_uid", "robot_uids"), (("body_type", _AGENT), ("fix_root_link", _AGENT))),
    **dict.fromkeys(("position", "initial_pose"), (("body_type", _POSE), ("fix_root_link", _POSE))),
    "look_at": (("fovy", _LOOK_AT),),
    **dict.fromkeys(("height", "length"), (("half_length", _HALF_LENGTH),)),
    **dict.fromkeys(("scene_idxs", "repeat", "if"), (("body_type", _COMMON_TO_VARIANTS),)),
    "pose": (("body_type", _COMMON_TO_VARIANTS), ("children", _LINK_POSE)),
    **dict.fromkeys(("static_friction", "dynamic_friction", "restitution"), (("physical", _PHYSICAL),)),
    **dict.fromkeys(("base_color", "roughness", "metallic", "specular", "emission"), (("visual", _VISUAL),)),
}
"""Unknown key → a key that is known where it stands, and what to say there."""

SHAPE_LIST_HINTS: dict[str, str] = {
    "mesh": "a `mesh` is only visible: write it under `visuals`; a convex_mesh, convex_parts or triangle_mesh collides",
    "tiled_plane": "a `tiled_plane` is only visible: write it under `visuals`",
    "convex_parts": "`convex_parts` always collide: write them under `shapes` or `collisions`, or use a visible `mesh`",
    "triangle_mesh": "a `triangle_mesh` always collides: write it under `shapes` or `collisions`",
}
"""Shape type → where it may stand, for the lists that do not have it."""

ANGLE_KEYS = frozenset(("fovy", "fovx", "inner_fov", "outer_fov"))
"""Keys in radians that have a twin in degrees, and a bound that degrees are beyond."""

LENGTH_HINTS: dict[tuple[str, int], str] = {
    ("pose", 7): "a position and a rotation are {p: [x, y, z], q: [w, x, y, z]}",
    ("pose", 4): "a matrix is {matrix: [[…], […], […], […]]}, a rotation {q: [w, x, y, z]}",
    ("pose", 6): "a position and three angles are {p: [x, y, z], rpy: [roll, pitch, yaw]}, or rpy_deg",
    ("half_size", 1): "one number an axis: [x, y, z]",
}
"""Key and the number of its values → what they were probably meant to be."""


def kind_hint(expected: str, path: Path, found: Any) -> str | None:
    """A hint; None where nothing is known.

    Args:
        expected: what a user may write there, as the message has it.
        path: of the value in the document.
        found: the value.
    """
    if is_mapping(found):
        return _form_hint(expected, found)
    if path[-1:] == ("repeat",) or (path[-2:-1] == ("repeat",) and isinstance(found, int)):
        return SYNTAX_HINTS["repeat"]
    if found.__class__ in {int, float} and path:
        # A number alone is meant as a list of one.
        return LENGTH_HINTS.get((str(path[-1]), 1))
    return _text_hint(expected, path, found) if isinstance(found, str) else None


def _text_hint(expected: str, path: Path, text: str) -> str | None:
    if expected in {"a number", "a whole number"} and _reads_as_number(text):
        return "remove the quotes"
    if expected == "true or false":
        is_condition = path[-1:] == ("if",)
        expression = f"an expression is written `${{{cut(text)}}}`"
        return expression if is_condition else "YAML 1.2 has only `true` and `false`, without quotes"
    if len(text) <= _MAX_EXPRESSION_LENGTH and (other := _FOREIGN_EXPRESSION.fullmatch(text)):
        return f'an expression is written `"${{{cut(next(filter(None, other.groups())))}}}"`'
    if len(path) == 2 and path[0] == "entities":
        return f"another scene file is used by `{{use: {cut(text)}}}`"
    if path[-1:] == ("repair",):
        return f"repairs are a list: `repair: [{cut(text)}]`"
    return SYNTAX_HINTS["include"] if path == ("include",) else None


_MAX_EXPRESSION_LENGTH = 200

_FOREIGN_EXPRESSION = re.compile(r"\$([A-Za-z_]\w*)|\{\{ *([^{}]*[^{} ]) *\}\}|\$\(([^()]+)\)")
"""How other languages write expressions."""


def _form_hint(expected: str, found: Mapping[str, Any]) -> str | None:
    """What form of variation an unknown mapping was probably meant to be."""
    near = next((near for key in found if (near := nearest(key, FORM_KEYS))), None)
    if near is not None:
        return f"did you mean `{near}`?"
    other = next((FORM_SYNONYMS[key] for key in found if key in FORM_SYNONYMS), None)
    if other is not None:
        return f"did you mean `{{{other}}}`?"
    if expected in {"a number", "a whole number", "true or false"} or expected.startswith("["):
        return f"values that differ from scene to scene use one of the forms {', '.join(sorted(FORM_KEYS))}"
    return None


def _reads_as_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    # Python reads 1_000, YAML does not.
    return "_" not in text


UNSUPPORTED_KEYS: dict[str, str] = {
    "tendons": "tendons",
    "stereo": "stereo depth sensors",
    "point_clouds": "point clouds",
    "point_cloud": "point clouds",
    "vertices": "vertices in the file",
    "triangles": "vertices in the file",
    "faces": "vertices in the file",
    "properties": "render properties by name",
    "cone": "cone limits (SAPIEN records them and never applies them)",
    "pyramid": "pyramid limits (SAPIEN records them and never applies them)",
    "is_trigger": "triggers (SAPIEN records `is_trigger` and never applies it)",
    "trigger": "triggers (SAPIEN records `is_trigger` and never applies it)",
}
