"""Rows of the table of codes: names and scene selections."""

from scenecc.diagnostics.codes.row import Code

_CUBE = "    shapes:\n      - {type: box, half_size: [0.1, 0.1, 0.1]}\n"

_BALL = "scenecc: 1\nentities:\n  ball: {shapes: [{type: sphere, radius: 0.1}]}\n"

_DOOR = (
    "scenecc: 1\nentities:\n  door:\n    root:\n      name: frame\n"
    "      shapes: [{type: box, half_size: [0.1, 0.1, 1]}]\n"
    "      children:\n        - name: panel\n          joint: {name: hinge, type: revolute, limits_deg: [0, 90]}\n"
    "          shapes: [{type: box, half_size: [0.4, 0.02, 1]}]\n"
)

_TWO = (
    "scenecc: 1\nentities:\n  post: {body_type: static, shapes: [{type: box, half_size: [0.1, 0.1, 1]}]}\n"
    "  bob: {pose: [0.5, 0, 1], shapes: [{type: sphere, radius: 0.1}]}\nconstraints:\n"
)

ROWS: tuple[Code, ...] = (
    Code(
        "SC301",
        "error",
        "unknown material",
        "A material is named under `materials` or written inline; this name is neither.",
        "scenecc: 1\nmaterials:\n  rubber: {physical: {restitution: 0.9}}\nentities:\n  cube:\n    material: ruber\n"
        + _CUBE,
        "Write the name that the hint suggests, or add it under `materials`.",
    ),
    Code(
        "SC302",
        "error",
        "unknown collision group",
        "A group is named under `collision_groups`.",
        "scenecc: 1\nentities:\n  cube:\n    collision_group: debris\n" + _CUBE,
        "Add `collision_groups: {debris: {}}`, or write a group that is there.",
    ),
    Code(
        "SC303",
        "error",
        "unknown entity or frame",
        "`relative_to` names an entity, a frame or a camera of the file. (`world` is there too; it changes nothing.)",
        "scenecc: 1\nentities:\n  cube:\n    pose: {p: [0, 0, 1], relative_to: tabel}\n" + _CUBE,
        "Write the name that the hint suggests.",
    ),
    Code(
        "SC304",
        "error",
        "poses in a circle",
        "Each of them stands relative to the next, so none stands anywhere.",
        "scenecc: 1\nframes:\n  a: {pose: {relative_to: b}}\n  b: {pose: {relative_to: a}}\n",
        "Give one of them a pose in the world.",
    ),
    Code(
        "SC305",
        "error",
        "name taken twice",
        "Frames, entities and cameras share one namespace, so that `relative_to` is never in doubt. SAPIEN builds two "
        "actors of one name, ManiSkill raises an AssertionError.",
        "scenecc: 1\nframes:\n  cube: {pose: [0, 0, 1]}\nentities:\n  cube:\n" + _CUBE,
        "Rename one of them.",
    ),
    Code(
        "SC306",
        "error",
        "reserved name",
        "`world` is what poses and constraints call the world.",
        "scenecc: 1\nentities:\n  world:\n" + _CUBE,
        "Choose another name.",
    ),
    Code(
        "SC307",
        "error",
        "scene out of range",
        "Scenes count from 0 to `num_scenes` - 1. Unlike Python's, a slice is not cut short: its bounds must exist.",
        "scenecc: 1\nnum_scenes: 2\nentities:\n  cube:\n    scene_idxs: [0, 2]\n" + _CUBE,
        'Raise `num_scenes`, or select scenes that exist; `"::2"` and `"4:"` adapt themselves to the number.',
    ),
    Code(
        "SC308",
        "error",
        "scene selected twice",
        "An entity exists once in a scene.",
        'scenecc: 1\nnum_scenes: 4\nentities:\n  cube:\n    scene_idxs: ["0:2", 1]\n' + _CUBE,
        "Select each scene once.",
    ),
    Code(
        "SC309",
        "error",
        "no scene selected",
        "An entity that exists nowhere would be dropped without a word.",
        "scenecc: 1\nentities:\n  cube:\n    scene_idxs: []\n" + _CUBE,
        "Select a scene, or leave `scene_idxs` out to select every scene.",
    ),
    Code(
        "SC310",
        "error",
        "not a slice",
        'A selection is a list of indices, or a slice as Python writes it: `"0:8"`, `"::2"`, `"4:"`.',
        'scenecc: 1\nentities:\n  cube:\n    scene_idxs: "all"\n' + _CUBE,
        "Write a slice, or leave `scene_idxs` out to select every scene.",
    ),
    Code(
        "SC311",
        "error",
        "relative to what is not there",
        "In some scene the entity would stand relative to one that does not exist in it.",
        "scenecc: 1\nnum_scenes: 2\nentities:\n  table:\n    scene_idxs: [0]\n"
        + _CUBE
        + "  cube:\n    pose: {p: [0, 0, 1], relative_to: table}\n"
        + _CUBE,
        "Select for the outer one all scenes of the inner one, or stand relative to a frame: those are in every scene.",
    ),
    Code(
        "SC312",
        "error",
        "more collision groups than bits",
        "SAPIEN has 32 bits for the kinds of bodies, and one is for those without a group.",
        "scenecc: 1\ncollision_groups:\n" + "".join(f"  g{i}: {{}}\n" for i in range(32)),
        "Merge groups that ignore the same ones.",
    ),
    Code(
        "SC313",
        "warning",
        "material never used",
        "A material that no shape names is often a misspelt or forgotten one.",
        "scenecc: 1\nmaterials:\n  oak: {physical: {density: 700}}\nentities:\n  cube:\n" + _CUBE,
        "Name it in a `material`, or remove it. A key that starts with `x-` holds notes.",
    ),
    Code(
        "SC314",
        "error",
        "list by scene of another length",
        "A `per_scene` list has one value for each scene that the object is in, by ascending index; in a material or a "
        "shared draw, one for each scene of the batch.",
        "scenecc: 1\nnum_scenes: 3\nentities:\n  cube:\n    mass: {per_scene: [1, 2]}\n" + _CUBE,
        "Give as many values as scenes, or write `{per_scene: {0: 1, default: 2}}` or `{cycle: [1, 2]}`.",
    ),
    Code(
        "SC315",
        "error",
        "values by scene for other scenes",
        "A `per_scene` mapping has a value for each scene that the object is in, or a `default`, and none for another.",
        "scenecc: 1\nnum_scenes: 3\nentities:\n  cube:\n    mass: {per_scene: {0: 1, 2: 2}}\n" + _CUBE,
        "Add the scene or a `default`, and leave out the scenes that the object is not in.",
    ),
    Code(
        "SC316",
        "error",
        "alternatives of a pose that stand relative to something",
        "What an object stands relative to is the same in every scene: chains of poses are followed before anything is "
        "drawn.",
        "scenecc: 1\nframes:\n  table: {pose: [0, 0, 1]}\nentities:\n  cube:\n    pose:\n"
        "      choice: [[0, 0, 0], {p: [0, 0, 1], relative_to: table}]\n" + _CUBE,
        "Write one `relative_to`, and the alternatives in `p`, `rpy` or `axis_angle` beside it.",
    ),
    Code(
        "SC317",
        "error",
        "names that cannot be told",
        "Every file and material that may be named is looked up before anything is drawn, so an expression that names "
        "one may read draws of alternatives only, of at most 10 000 combinations in all, and must give a text. So "
        "it is of what an articulation is put together from: `scale` and `fix_root_link` give few values, none of a "
        "range.",
        "scenecc: 1\ndraws: {x: {uniform: [0, 1]}}\nmaterials:\n  oak: {physical: {density: 700}}\nentities:\n"
        '  cube:\n    material: "oak_${x}"\n' + _CUBE,
        "Read draws made by `choice`, `cycle` or `integers`, or write the names or values in a `choice` themselves.",
    ),
    Code(
        "SC318",
        "error",
        "bad array for a shared draw",
        "An array that takes the place of a shared draw has one row for each scene, of the kind and shape that the "
        "file declares: (num_scenes,) for a number, a flag or a text, (num_scenes, k) for a vector of k. Numbers are "
        "finite and may lie outside of what the form in the file gives; the fields that read them are checked "
        "on the rows.",
        "$ python -c \"import scenecc; scenecc.compile_scene('scene.yaml', num_scenes=4, draws={'half': [0.1]})\"",
        "Give one row for each scene of the batch, of the shape that the message names.",
    ),
    Code(
        "SC319",
        "warning",
        "draw never read",
        "A shared draw that no expression reads changes nothing; it is often a misspelt or forgotten one.",
        "scenecc: 1\ndraws: {half: {uniform: [0.1, 0.2]}}\nentities:\n  cube:\n" + _CUBE,
        "Read it in a `${…}`, or remove it. A key that starts with `x-` holds notes.",
    ),
    Code(
        "SC320",
        "error",
        "no such variant",
        "`pick` gives an index of `variants`, counted from 0, whatever is drawn.",
        "scenecc: 1\nentities:\n  bin:\n    pick: {cycle: [0, 1]}\n    variants:\n"
        "      - shapes:\n          - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Let every index be below the number of variants.",
    ),
    Code(
        "SC321",
        "error",
        "alternatives that cannot be told apart by an index",
        "A mesh keeps the materials of its own file where none is given, and a texture is sampled in one way: neither "
        "can be so in some scenes and otherwise in others.",
        "$ scenecc validate scene.yaml   # a {type: mesh} with material: {choice: [oak, rubber]}, where rubber has no "
        "`visual`",
        "Give every alternative a `visual`, and every texture the same sampling; or use `variants`.",
    ),
    Code(
        "SC322",
        "warning",
        "parameter never read",
        "A parameter that no expression reads changes nothing, whatever it is given; often its name is misspelt where "
        "it was to be read.",
        "scenecc: 1\nparams: {size: 0.1}\nentities:\n  cube:\n" + _CUBE,
        "Read it in a `${…}`, or remove it.",
    ),
    Code(
        "SC323",
        "error",
        "pattern of names that is not taken",
        "Links and joints are named by regular expressions that match whole names. They have at most 200 characters, "
        "and neither back-references, look-around, flags nor a repetition inside a repetition, so that matching takes "
        "no time whatever the names are.",
        _DOOR + '    drives: {"(hi+)+nge": {stiffness: 10}}\n',
        "Write it without what the message names; most need letters, `.*`, `[1-7]` and `|` alone.",
    ),
    Code(
        "SC324",
        "error",
        "pattern that matches nothing",
        "A pattern of names that matches no link, or no joint that moves, would be dropped silently. It matches whole "
        "names: `finger` is not `left_finger`, `.*finger` is.",
        _DOOR + "    drives: {wheel: {stiffness: 10}}\n",
        "Write a pattern that matches one of the names that the hint lists, or leave it out.",
    ),
    Code(
        "SC325",
        "error",
        "numbers that do not fit the joints",
        "`qpos` and `qvel` hold one number for each joint that moves, in SAPIEN's order (joints nearer to the root "
        "come first, of equally near ones those of the link that comes first), or name the joints.",
        _DOOR + "    qpos: [0, 0]\n",
        "Give as many numbers as the message says, or name the joints: `qpos: {hinge: 0.1}`.",
    ),
    Code(
        "SC326",
        "error",
        "name that an articulation has twice",
        "Links and joints are told apart by their names, so that none may be used twice in an articulation.",
        _DOOR.replace("name: panel", "name: frame"),
        "Rename one of them.",
    ),
    Code(
        "SC327",
        "error",
        "files that cannot stand for one another",
        "Where the file of an entity differs from scene to scene, or how it is read, each must hold one articulation, "
        "or each one body: what is one entity in one scene cannot be several in another.",
        "$ scenecc validate scene.yaml   # urdf: {cycle: [arm.urdf, two_arms.urdf]}",
        "Give each robot of such a file a file of its own.",
    ),
    Code(
        "SC330",
        "error",
        "nothing to hold on to",
        "A light or a camera is mounted on an entity, ENTITY, or on a link of one, ENTITY/LINK; constraints tie such "
        "together. Of an entity's name with slashes the longest that exists is meant.",
        _BALL + "cameras: {eye: {mount: bal}}\n",
        "Write the name that the hint suggests.",
    ),
    Code(
        "SC331",
        "error",
        "no such link",
        "After the name of an articulation follows one of its links. A body has none; and where the robot differs from "
        "scene to scene, it is a link that each of them has.",
        _BALL + "cameras: {eye: {mount: ball/hand}}\n",
        "Write the link that the hint suggests, or the entity alone.",
    ),
    Code(
        "SC340",
        "error",
        "world as the child of a constraint",
        "SAPIEN hangs a constraint on its child, which must be a body; the world can only be the parent.",
        _TWO + "  hold: {type: weld, parent: bob, child: world}\n",
        "Write `parent: world`, and as `child` what is fastened to it.",
    ),
    Code(
        "SC341",
        "error",
        "constraint in no scene",
        "A constraint without `scene_idxs` is in the scenes that both of its bodies are in, and there are none.",
        "scenecc: 1\nnum_scenes: 2\nentities:\n  a: {scene_idxs: [0], shapes: [{type: sphere, radius: 0.1}]}\n"
        "  b: {scene_idxs: [1], shapes: [{type: sphere, radius: 0.1}]}\nconstraints:\n"
        "  hold: {type: weld, parent: a, child: b}\n",
        "Let both exist in one scene at least, or leave the constraint out.",
    ),
    Code(
        "SC342",
        "error",
        "constraint whose place is not clear",
        "Without `pose_in_parent` a constraint holds its child where that starts. Where an entity is another robot in "
        "each scene, a link of it starts somewhere else in each.",
        "$ cat arms.yaml\nscenecc: 1\nnum_scenes: 2\nentities:\n  arm: {urdf: {cycle: [short.urdf, long.urdf]}}\n"
        "constraints:\n  hold: {type: weld, parent: world, child: arm/hand}\n",
        "Write `pose_in_parent`.",
    ),
    Code(
        "SC343",
        "warning",
        "constraint that a reset tears at",
        "Without `pose_in_parent` a constraint holds its child where that was built. A reset that draws the start of "
        "one of the bodies anew, and not that of the other, puts them elsewhere, and the constraint pulls them back.",
        "scenecc: 1\nentities:\n  bob:\n    pose: {uniform: [[0, 0, 1], [1, 1, 2]]}\n"
        "    shapes: [{type: sphere, radius: 0.1}]\n"
        "constraints:\n  hold: {type: weld, parent: world, child: bob}\n",
        "Write `pose_in_parent`, or let both bodies stand `relative_to` the same thing. Where nothing is reset, "
        "leave it.",
    ),
)
