"""Rows of the table of codes: the shape of the data."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        "SC100",
        "error",
        "unknown version of the language",
        "A file says which version of the language it is written in, so that a later compiler can read it as it was "
        "meant. This compiler reads version 1.",
        "scenecc: 2\n",
        "Write `scenecc: 1`.",
    ),
    Code(
        "SC101",
        "error",
        "unknown key",
        "A key that nothing reads would be dropped without a word: `builder.inital_pose = …` builds at the origin. "
        "Keys that start with `x-` are yours: they are carried and ignored.",
        "scenecc: 1\nentities:\n  cube:\n    poze: [0, 0, 1]\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Write the key that the hint suggests, or start the key with `x-`.",
    ),
    Code(
        "SC102",
        "error",
        "missing key",
        "Some keys have no sensible default: the language's version, a shape's type and sizes, the mass in `inertial`.",
        "scenecc: 1\nentities:\n  ball:\n    shapes:\n      - {type: sphere}\n",
        "Add the key that the message names.",
    ),
    Code(
        "SC103",
        "error",
        "wrong kind of value",
        "Nothing is converted: a quoted number is a text, and a single number is no list.",
        "scenecc: 1\nentities:\n  ball:\n    shapes:\n      - {type: sphere, radius: '0.1'}\n",
        "Write the kind of value that the message asks for.",
    ),
    Code(
        "SC104",
        "error",
        "value out of range",
        "SAPIEN builds a body from a negative, zero or NaN size, or a negative density, and gives it a mass of a "
        "milligram or none.",
        "scenecc: 1\nentities:\n  ball:\n    shapes:\n      - {type: sphere, radius: -0.1}\n",
        "Give a value in the range that the message names.",
    ),
    Code(
        "SC105",
        "error",
        "unknown choice",
        "The key takes one of a few words, and this is none of them (in this list of shapes, at least: a `mesh` is "
        "only seen, a `triangle_mesh` always collides).",
        "scenecc: 1\nentities:\n  cube:\n    body_type: fixed\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Write one of the words that the hint lists.",
    ),
    Code(
        "SC106",
        "error",
        "wrong number of values",
        "Vectors, quaternions and matrices have a fixed length.",
        "scenecc: 1\nentities:\n  cube:\n    shapes:\n      - {type: box, half_size: [0.1, 0.1]}\n",
        "Give as many values as the message asks for.",
    ),
    Code(
        "SC107",
        "error",
        "not a name",
        "A name is a letter or `_`, then letters, digits, `_`, `.` and `-`, so that it can stand in paths, on the "
        "command line and in generated code.",
        "scenecc: 1\nentities:\n  red cube:\n    shapes:\n      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Write `red_cube`.",
    ),
    Code(
        "SC108",
        "error",
        "not a colour",
        "A colour is three or four numbers in 0..1, or `#rrggbb` or `#rrggbbaa`. Names of colours mean something else "
        "to everyone.",
        "scenecc: 1\nentities:\n  cube:\n    color: red\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        'Write `color: [1, 0, 0]` or `color: "#ff0000"` (in quotes: `#` starts a comment).',
    ),
    Code(
        "SC110",
        "error",
        "left out of version 1",
        "Tendons, stereo depth sensors, point clouds, vertices in the file, render properties by name and triggers are "
        "not part of the language. SAPIEN records `is_trigger` and never applies it.",
        "scenecc: 1\nentities:\n  zone:\n    collisions:\n"
        "      - {type: box, half_size: [1, 1, 1], is_trigger: true}\n    body_type: static\n",
        "Do it in Python on the built scene.",
    ),
    Code(
        "SC111",
        "error",
        "keys that exclude each other",
        "Two keys say the same thing, and only one of them could be meant: two rotations in a pose, `mass` beside "
        "`inertial`, `collision_bits` beside `collision_group`.",
        "scenecc: 1\nentities:\n  cube:\n    pose: {p: [0, 0, 1], rpy: [0, 0, 1], q: [1, 0, 0, 0]}\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Keep one of them.",
    ),
    Code(
        "SC112",
        "error",
        "quaternion not of unit length",
        "SAPIEN takes any four numbers as they are, zero and non-unit quaternions too, and simulates something. "
        "Within 1e-5 of length 1 a quaternion is passed on untouched, within 1e-3 normalised.",
        "scenecc: 1\nentities:\n  cube:\n    pose: {q: [1, 1, 0, 0]}\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Write [w, x, y, z] of length 1 with at least four digits (`[0.70711, 0.70711, 0, 0]`), or use `rpy`, "
        "`rpy_deg` or `axis_angle`.",
    ),
    Code(
        "SC113",
        "error",
        "matrix not rigid",
        "A pose moves and turns; it does not scale, shear or mirror.",
        "scenecc: 1\nentities:\n  cube:\n    pose:\n"
        "      matrix: [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Give an orthonormal rotation with determinant +1 (within 1e-3) and the last row [0, 0, 0, 1].",
    ),
    Code(
        "SC114",
        "error",
        "direction without a direction",
        "An axis or a normal of length 0 points nowhere, and a camera's `look_at` cannot keep z up when it looks "
        "straight up or down.",
        "scenecc: 1\nentities:\n  floor:\n    body_type: static\n    shapes:\n"
        "      - {type: plane, normal: [0, 0, 0]}\n",
        "Give a vector that is not zero; to look straight down write `rpy_deg: [0, 90, 0]`.",
    ),
    Code(
        "SC115",
        "error",
        "key that does nothing here",
        "SAPIEN takes a mass on a static body and a velocity on a kinematic one without a word and drops it, and a "
        "kinematic body's mass stays what its density gives.",
        "scenecc: 1\nentities:\n  table:\n    body_type: static\n    mass: 20\n    shapes:\n"
        "      - {type: box, half_size: [0.5, 0.5, 0.05]}\n",
        "Leave the key out, or set the `body_type` on which it means something.",
    ),
    Code(
        "SC116",
        "error",
        "nothing may vary here",
        "Numbers, vectors, positions, colours, files, materials and booleans of bodies may differ from scene to scene. "
        "What decides how a scene is put together may not, and a form that draws numbers stands only for numbers.",
        "scenecc: 1\nentities:\n  cube:\n    body_type: {choice: [dynamic, static]}\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Write a plain value; what differs in structure is written as `variants` of the entity.",
    ),
    Code(
        "SC117",
        "error",
        "not a form of variation",
        "A form is one of `per_scene`, `cycle`, `choice` (with `weights`), `uniform`, `integers`, `log_uniform` and "
        "`normal` (with `clip`), and has nothing else beside it.",
        "scenecc: 1\nentities:\n  cube:\n    mass: {uniform: [1, 2], weights: [1, 1]}\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Take out the key that the message names.",
    ),
    Code(
        "SC118",
        "error",
        "expression that cannot be read",
        "Between `${` and `}` stands arithmetic over parameters, loop variables and draws, and nothing else.",
        'scenecc: 1\nentities:\n  cube:\n    mass: "${1 +}"\n    shapes:\n'
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Mend the expression where the message points; `$${` is a literal `${`.",
    ),
    Code(
        "SC119",
        "error",
        "bounds the wrong way round",
        "The lower bound of a form stands first.",
        "scenecc: 1\nentities:\n  cube:\n    mass: {uniform: [2, 1]}\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Swap the bounds.",
    ),
    Code(
        "SC120",
        "error",
        "draw that can leave its range",
        "What is drawn is judged by its bounds, not by the luck of one seed: a normal distribution has none, and a "
        "scale drawn on both sides of 0 may come out as 0.",
        "scenecc: 1\nentities:\n  cube:\n    mass: {normal: [1, 0.1]}\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n",
        "Write `{normal: [1, 0.1], clip: [0.5, 1.5]}`.",
    ),
)
