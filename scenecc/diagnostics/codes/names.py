"""Rows of the table of codes: names and scene selections."""

from scenecc.diagnostics.codes.row import Code

_CUBE = "    shapes:\n      - {type: box, half_size: [0.1, 0.1, 0.1]}\n"

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
        "one may read draws of alternatives only, of at most 10 000 combinations in all, and must give a text.",
        "scenecc: 1\ndraws: {x: {uniform: [0, 1]}}\nmaterials:\n  oak: {physical: {density: 700}}\nentities:\n"
        '  cube:\n    material: "oak_${x}"\n' + _CUBE,
        "Read draws made by `choice`, `cycle` or `integers`, or write the names in a `choice` themselves.",
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
)
