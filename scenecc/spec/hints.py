"""What was probably meant by mistakes that people often make."""

from __future__ import annotations

_SHAPE = "a shape stands in one of the lists `shapes`, `collisions` and `visuals`: `shapes: [{type: box, …}]`"
_PHYSICAL = "it stands under `physical`: `material: {physical: {…}}`"
_VISUAL = "it stands under `visual`: `material: {visual: {…}}`"

_USED = "it stands beside `use`: `{use: FILE, with: {…}}`"
_USE = "did you mean `use`?"
_PICKED = "it stands beside `variants`: `{variants: [{…}, {…}], pick: …}`"

_ROBOT = "articulations are no variants; of a robot the file may vary: `urdf: {cycle: [a.urdf, b.urdf]}`"
_ONE_OF = "an articulation has one of `urdf`, `mjcf` and `root`"
_OF_LINKS = "a tree's links have shapes: `root: {shapes: […]}`; a file brings its own, and is an entity by itself"
_LINK = "it is said of links: `links: {NAME: {…: …}}`"
_FIXED = "did you mean `fix_root_link`?"
_DRIVE = "it is said of drives: `drives: {JOINT: {stiffness: …, damping: …}}`"
_AGENT = (
    "a robot is its file, `urdf: …` or `mjcf: …`; ManiSkill's come with `{use: scenecc:table_scene, with: {robot: …}}`"
)
_POSE = "did you mean `pose`?"
_AIMED = "it stands in the pose: `pose: {p: […], look_at: […]}`"
_HALF = "did you mean `half_length`? it is half of that"
_COMMON = "it stands beside `variants`, for all of them"

ALTERNATIVES = "what differs in structure from scene to scene is written as `variants` of the entity"
PARTS = "what may differ are the numbers, files, colours and materials in it, each alone"
SETTINGS = "the scenes share one simulation: nothing under `physics` differs between them"

EACH_ITS_OWN = "declare an entity for each value, with `scene_idxs` of its own"
OF_A_WHOLE_ROBOT = frozenset(
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

FORM_WORDS = {
    **dict.fromkeys(("range", "random", "rand", "between", "min", "low"), "uniform: [low, high]"),
    **dict.fromkeys(("randint", "integer", "int"), "integers: [low, high]"),
    **dict.fromkeys(("gauss", "gaussian", "mean"), "normal: [mean, std]"),
    **dict.fromkeys(("one_of", "any_of", "options", "random_choice"), "choice: [a, b]"),
    **dict.fromkeys(("values", "list"), "per_scene: [a, b]"),
}
"""What other languages call the forms of variation."""

WRITTEN_AS: dict[str, str] = {
    "include": "the files stand in a list: `include: [FILE]`",
    "repeat": "a number of copies is `{i: {count: 4}}`",
}
"""Key → how what stands there is written."""

LACKING: dict[str, str] = {
    "pick": "it says which variant each scene has: `pick: {cycle: [0, 1]}`, or any form over their indices",
}
"""Missing key → what it is for."""

RENAMED = {"filename": "file", "color": "base_color", "position": "p", "quaternion": "q", "friction": "static_friction"}
"""Unknown key → what it is called here, where letters alone would not tell."""

MISPLACED: dict[str, tuple[tuple[str, str], ...]] = {
    **dict.fromkeys(("type", "half_size", "radius", "half_length"), (("body_type", _SHAPE),)),
    **dict.fromkeys(("with", "prefix"), (("body_type", _USED),)),
    **dict.fromkeys(("uses", "using", "prefab"), (("body_type", _USE),)),
    "pick": (("body_type", _PICKED),),
    **dict.fromkeys(("urdf", "mjcf", "root"), (("body_type", _ROBOT), ("fix_root_link", _ONE_OF))),
    **dict.fromkeys(("shapes", "collisions", "visuals"), (("fix_root_link", _OF_LINKS),)),
    **dict.fromkeys(("mass", "inertial", "linear_damping", "angular_damping"), (("fix_root_link", _LINK),)),
    **dict.fromkeys(("fix_base", "fixed_base", "fixed", "use_fixed_base"), (("fix_root_link", _FIXED),)),
    **dict.fromkeys(("stiffness", "damping", "force_limit"), (("fix_root_link", _DRIVE), ("armature", _DRIVE))),
    **dict.fromkeys(("uid", "robot", "robot_uid", "robot_uids"), (("body_type", _AGENT), ("fix_root_link", _AGENT))),
    **dict.fromkeys(("position", "initial_pose"), (("body_type", _POSE), ("fix_root_link", _POSE))),
    "look_at": (("fovy", _AIMED),),
    **dict.fromkeys(("height", "length"), (("half_length", _HALF),)),
    **dict.fromkeys(("pose", "scene_idxs", "repeat", "if"), (("body_type", _COMMON),)),
    **dict.fromkeys(("static_friction", "dynamic_friction", "restitution"), (("physical", _PHYSICAL),)),
    **dict.fromkeys(("base_color", "roughness", "metallic", "specular", "emission"), (("visual", _VISUAL),)),
}
"""Unknown key → a key that is known where it stands, and what to say there."""

LISTED_ELSEWHERE: dict[str, str] = {
    "mesh": "a `mesh` is only seen: write it under `visuals`; a convex_mesh, convex_parts or triangle_mesh collides",
    "tiled_plane": "a `tiled_plane` is only seen: write it under `visuals`",
    "convex_parts": "`convex_parts` always collide: write them under `shapes` or `collisions`; a `mesh` is only seen",
    "triangle_mesh": "a `triangle_mesh` always collides: write it under `shapes` or `collisions`",
}
"""Shape type → where it may stand, for the lists that do not have it."""

ANGLES = frozenset(("fovy", "fovx", "inner_fov", "outer_fov"))
"""Keys in radians that have a twin in degrees, and a bound that degrees are beyond."""

LENGTH_HINTS: dict[tuple[str, int], str] = {
    ("pose", 7): "a position and a rotation are {p: [x, y, z], q: [w, x, y, z]}",
    ("pose", 4): "a matrix is {matrix: [[…], […], […], […]]}, a rotation {q: [w, x, y, z]}",
    ("pose", 6): "a position and three angles are {p: [x, y, z], rpy: [roll, pitch, yaw]}, or rpy_deg",
    ("half_size", 1): "one number an axis: [x, y, z]",
}
"""Key and the number of its values → what they were probably meant to be."""
