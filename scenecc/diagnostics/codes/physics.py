"""Rows of the table of codes: physics."""

from scenecc.diagnostics.codes.row import Code

_BOX = "      - {type: box, half_size: [0.1, 0.1, 0.1]}\n"

_DOOR = (
    "scenecc: 1\nentities:\n  door:\n    root:\n      name: frame\n"
    "      shapes: [{type: box, half_size: [0.1, 0.1, 1]}]\n"
    "      children:\n        - name: panel\n          joint: {name: hinge, type: revolute, limits_deg: [0, 90]}\n"
    "          shapes: [{type: box, half_size: [0.4, 0.02, 1]}]\n"
)

ROWS: tuple[Code, ...] = (
    Code(
        "SC501",
        "error",
        "body without a shape",
        "SAPIEN builds an actor without shapes: a body of one milligram that nothing collides with.",
        "scenecc: 1\nentities:\n  ghost:\n    pose: [0, 0, 1]\n",
        "Give it `shapes`, `collisions` or `visuals`. A place with no body is a frame: "
        "`frames: {ghost: {pose: [0, 0, 1]}}`.",
    ),
    Code(
        "SC502",
        "error",
        "dynamic body that nothing collides with",
        "Without a colliding shape and without `inertial` SAPIEN gives it a mass of one milligram, and it falls for "
        "ever.",
        "scenecc: 1\nentities:\n  marker:\n    visuals:\n" + _BOX,
        "Write `body_type: kinematic` (or static, or none) for a marker, `shapes` for an object, or give `inertial`.",
    ),
    Code(
        "SC503",
        "error",
        "plane on a dynamic body",
        "A plane is endless and has no mass; SAPIEN builds a body of one milligram.",
        "scenecc: 1\nentities:\n  floor:\n    shapes:\n      - {type: plane}\n",
        "Write `body_type: static`, or use a box.",
    ),
    Code(
        "SC504",
        "error",
        "dynamic friction above static friction",
        "What slides would be held more strongly than what sticks. SAPIEN takes it.",
        "scenecc: 1\nentities:\n  cube:\n    material: {physical: {static_friction: 0.2, dynamic_friction: 0.5}}\n"
        "    shapes:\n" + _BOX,
        "Lower `dynamic_friction`, or raise `static_friction`. What is left out is the default material's (0.3, 0.3).",
    ),
    Code(
        "SC505",
        "error",
        "restitution outside 0..1",
        "Above 1 every bounce adds energy, and the scene explodes. SAPIEN takes 5.",
        "scenecc: 1\nentities:\n  ball:\n    material: {physical: {restitution: 5}}\n    shapes:\n" + _BOX,
        "Give a restitution from 0 (no bounce) to 1 (no loss).",
    ),
    Code(
        "SC506",
        "error",
        "inertia that no body has",
        "Each principal moment of a real body is at most the sum of the other two. SAPIEN takes [1, 1, 5].",
        "scenecc: 1\nentities:\n  cube:\n    inertial: {mass: 1, inertia: [1, 1, 5]}\n    shapes:\n" + _BOX,
        "Mend the moments, or leave `inertial` out and give `mass`.",
    ),
    Code(
        "SC507",
        "error",
        "contact offset not above rest offset",
        "Contacts must begin to be made before shapes rest on each other. SAPIEN takes a negative or smaller one.",
        "scenecc: 1\nentities:\n  cube:\n    shapes:\n"
        "      - {type: box, half_size: [0.1, 0.1, 0.1], contact_offset: 0.001, rest_offset: 0.002}\n",
        "Raise `contact_offset` or lower `rest_offset` (left out: 0.01 and 0, or those of `physics`).",
    ),
    Code(
        "SC508",
        "error",
        "triangle mesh on a dynamic body",
        "PhysX moves no plain triangle mesh; a dynamic body needs a convex shape or a signed distance field.",
        "$ scenecc validate crate.yaml   # a dynamic body with {type: triangle_mesh, file: crate.obj}",
        "Use `convex_mesh` or `convex_parts`, or set `sdf: true`.",
    ),
    Code(
        "SC509",
        "error",
        "signed distance field over a plane",
        "On the CPU, PhysX lets a signed distance field fall through a plane (it lies on boxes).",
        "$ scenecc validate crate.yaml   # {type: triangle_mesh, file: crate.obj, sdf: true} over a {type: plane}",
        "Make the ground a box, or keep the two apart by scenes or collision groups.",
    ),
    Code(
        "SC510",
        "error",
        "mass with nothing to scale",
        "`mass` scales the mass and inertia that follow from the densities, and these are all 0. A link without "
        "colliding shapes and without an inertia has none either.",
        "scenecc: 1\nentities:\n  cube:\n    mass: 1\n    density: 0\n    shapes:\n" + _BOX,
        "Give a density, or `inertial` in place of `mass`.",
    ),
    Code(
        "SC511",
        "error",
        "dynamic body without mass",
        "All its shapes have a density of 0, or they are so small that together they weigh less than a milligram. "
        "SAPIEN makes of it a body of one milligram. Of meshes this is told once the engine has read them.",
        "scenecc: 1\nentities:\n  cube:\n    density: 0\n    shapes:\n" + _BOX,
        "Give a density, or `inertial`. (`mass` scales what the densities give, so it needs one, too.)",
    ),
    Code(
        "SC512",
        "error",
        "mass or inertia beyond single precision",
        "The engine computes in single precision: a mass above 3.4e38 kg, or a moment of inertia above 3.4e38 "
        "kg·m², is infinite there, and the centre of mass nowhere. Of a mass or a moment that is given the engine "
        "keeps the inverse, which must be a number, too; and it loses where a body is, whose shapes or centre of mass "
        "are more than 10 km from it, or joints a million. Of meshes this is told once the engine has read them.",
        "scenecc: 1\nentities:\n  cube:\n    density: 1.0e+38\n    shapes:\n"
        "      - {type: box, half_size: [1.0e+10, 1.0e+10, 1.0e+10]}\n",
        "Mend the sizes, the coordinates or the densities: lengths are in metres, densities in kg/m³.",
    ),
    Code(
        "SC513",
        "error",
        "drawn value out of its range",
        "An expression gives a value that its field cannot have, in one of the scenes or whatever is drawn.",
        '$ scenecc build scene.yaml --dry-run   # draws: {x: {uniform: [-1, 1]}} and radius: "${x}"',
        "Narrow the draws that it reads, or keep it in its range: `${max(0.01, x)}`.",
    ),
    Code(
        "SC514",
        "warning",
        "expression that may leave its range",
        "By the bounds of what it reads, an expression may give a value that its field cannot have. It is judged scene "
        "by scene once it is drawn.",
        "scenecc: 1\ndraws: {x: {uniform: [-1, 1]}}\nentities:\n  ball:\n    shapes:\n"
        '      - {type: sphere, radius: "${0.5 + x}"}\n',
        "Narrow the draws that it reads, or keep it in its range: `${max(0.01, x)}`.",
    ),
    Code(
        "SC515",
        "error",
        "value that is none in some scene",
        "A rotation that varies has no value in one of the scenes: an axis of length 0, a quaternion that is not of "
        "length 1, a point looked at that is the pose itself or straight above it. Or an expression gives another kind "
        "of value than is wanted: one number for three. Or a form draws between bounds that are none in that scene: "
        "the lower one is above the upper one.",
        "scenecc: 1\nnum_scenes: 2\nentities:\n  cube:\n    pose: {p: {per_scene: [[0, 0, 0], [1, 0, 0]]}, "
        "look_at: [1, 0, 0]}\n" + "    shapes:\n" + _BOX,
        "Keep what is drawn away from there.",
    ),
    Code(
        "SC516",
        "warning",
        "value that may be none in some scene",
        "By the bounds of what it reads, an expression may divide by zero, take the root of a negative number or read "
        "beyond a list, and the bounds of a form that draws may change places. A scene in which they do is an error "
        "once it is drawn.",
        'scenecc: 1\ndraws: {x: {uniform: [-1, 1]}}\nentities:\n  cube:\n    mass: "${1 + sqrt(x)}"\n    shapes:\n'
        + _BOX,
        "Narrow the draws that it reads, or choose another value there: `${sqrt(x) if x > 0 else 0}`. `min` and `max` "
        'keep a bound in its range: `{uniform: ["${min(a, 0.5)}", 0.5]}`.',
    ),
    Code(
        "SC517",
        "error",
        "joint that starts outside of its limits",
        "PhysX would push the joint back with whatever force that takes. What is drawn is held within the limits; what "
        "is written must be within them, to 1e-6.",
        _DOOR + "    qpos: [3]\n",
        "Mend the position, or the limits.",
    ),
    Code(
        "SC518",
        "warning",
        "joint that starts at a limit",
        "A joint of which `qpos` says nothing starts at 0, or at the nearest limit where its limits leave 0 out.",
        _DOOR.replace("[0, 90]", "[10, 90]"),
        "Give it a position in `qpos`.",
    ),
    Code(
        "SC519",
        "error",
        "more links or articulations than PhysX counts",
        "On the CPU PhysX counts the links of an articulation in eight bits: with 257 it would have no degrees of "
        "freedom. Articulations whose links ignore one another it tells apart in sixteen bits: links of the 65 537th "
        "would ignore those of the first.",
        "$ scenecc validate scene.yaml   # a robot of 300 links",
        "Make one link of links that are fixed to one another, or two articulations.",
    ),
    Code(
        "SC520",
        "error",
        "limits the wrong way round",
        "The limits of a joint are its lowest and its highest position, and nothing is between them otherwise.",
        _DOOR.replace("[0, 90]", "[90, 0]"),
        "Write the lower one first.",
    ),
    Code(
        "SC521",
        "error",
        "joint that cannot follow another",
        "A joint that mimics another is coupled with it by a tendon of PhysX, which cannot run over a fixed joint, and "
        "which does not hold still where the other one hangs on the joint that follows.",
        _DOOR.replace("limits_deg: [0, 90]", "mimic: {joint: other}"),
        "Name a joint that moves, with none that is fixed between, or leave `mimic` out and drive both.",
    ),
    Code(
        "SC522",
        "error",
        "link that moves and has no mass",
        "SAPIEN makes a milligram of what has neither a colliding shape nor an `inertial`. A link that moves needs a "
        "mass, its own or of what hangs on it.",
        _DOOR.replace("shapes: [{type: box, half_size: [0.4", "visuals: [{type: box, half_size: [0.4"),
        "Give it `shapes`, `collisions` or `inertial`; a link that is only a place is `fixed`.",
    ),
    Code(
        "SC523",
        "warning",
        "drive that pulls beyond a limit",
        "The joint stops at its limit and the drive goes on pulling, with all of its force where that is far beyond. "
        "Of a target that is drawn its bounds are judged.",
        _DOOR + "    drives: {hinge: {stiffness: 10, target: 90}}\n",
        "Mend the target, or the limits: both are in radians, or metres of a prismatic joint. Where the joint is meant "
        "to press against its limit, as a gripper does that closes, say `beyond_limits: true` of the articulation.",
    ),
    Code(
        "SC524",
        "warning",
        "links that collide by their bits",
        "`collision_bits` are taken as they are: what `disable_self_collisions`, an SRDF or an MJCF says of the links "
        "that have them does not hold then, unless the bits say the same.",
        _DOOR.replace(
            "          shapes: [{type: box, half_size: [0.4, 0.02, 1]}]\n",
            "          shapes: &door [{type: "
            "box, half_size: [0.4, 0.02, 1]}]\n          collision_bits: [1, 1, 0, 0]\n        - name: shutter\n"
            "          joint: {name: other, type: revolute}\n          shapes: *door\n",
        )
        + "    disable_self_collisions: true\n",
        "Say `collision_group` instead, which keeps what is ignored, or give the links a bit in common in the third "
        "integer and the same fourth one.",
    ),
    Code(
        "SC525",
        "warning",
        "URDF of one link, which is not fixed",
        "A link without a joint is no articulation in SAPIEN: its loader builds a body that moves freely, whatever is "
        "said of the root of a robot. So does this one, and `fix_root_link` is not true of it though it is left out.",
        "$ scenecc validate scene.yaml   # a URDF with one link",
        "Say `fix_root_link: false` where it is to move. Where it is not, fasten it to the world by a constraint of "
        "`type: weld`, or declare it in the scene as a body of `body_type: static`.",
    ),
    Code(
        "SC526",
        "warning",
        "angle that looks like degrees",
        "`rpy`, `angle` of `axis_angle`, `limits` of joints that turn and positions of joints without limits are in "
        "radians, as in a robot's file, and these are beyond two turns. Of what varies all alternatives or "
        "bounds are; what is computed from "
        "draws is not judged.",
        _DOOR.replace("limits_deg", "limits"),
        "Write `rpy_deg`, `angle_deg` or `limits_deg`, or `${radians(90)}`; in a robot's file, radians. What "
        "is meant is written within two turns, "
        "of limits as `limits_deg: [0, 3600]`; positions of a joint without limits may be anything where the "
        "articulation says `beyond_limits: true`.",
    ),
    Code(
        "SC527",
        "warning",
        "link of a robot's file that moves and has no mass",
        "The file gives it neither an inertia nor a colliding shape, nor to a link that hangs on it. SAPIEN makes a "
        "milligram of it, which any drive throws about.",
        "$ scenecc validate scene.yaml   # a URDF whose last link is empty and hangs on a revolute joint",
        "Give it an `<inertial>` in the file, or `links: {NAME: {inertial: …}}` in the scene; a link that is "
        "only a place "
        "hangs on a fixed joint.",
    ),
)
