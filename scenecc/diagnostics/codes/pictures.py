"""Rows of the table of codes: lights, surroundings and cameras."""

from scenecc.diagnostics.codes.row import Code

_BALL = "scenecc: 1\nentities:\n  ball: {shapes: [{type: sphere, radius: 0.1}]}\n"

ROWS: tuple[Code, ...] = (
    Code(
        "SC550",
        "error",
        "near plane not before the far one",
        "A camera sees, and a shadow is made of, what lies between two distances. SAPIEN takes them in any order, and "
        "the picture is empty or turned inside out.",
        _BALL + "cameras: {eye: {pose: [-1, 0, 0], near: 10, far: 1}}\n",
        "Lower the near one, or raise the far one.",
    ),
    Code(
        "SC551",
        "error",
        "inner cone wider than the outer one",
        "A spot is bright inside of `inner_fov`, and fades until it is dark outside of `outer_fov`. The other way "
        "round SAPIEN draws a ring.",
        _BALL
        + "lights:\n  spot: {type: spot, position: [0, 0, 1], direction: [0, 0, -1], color: [1, 1, 1], "
        + "inner_fov: 0.7, outer_fov: 0.5}\n",
        "Exchange the two.",
    ),
    Code(
        "SC552",
        "warning",
        "light that no camera shows",
        "SAPIEN's light of a rectangle is for ray tracing; every other shader pack leaves it out.",
        _BALL
        + "lights: {panel: {type: area, pose: [0, 0, 2], half_width: 1, half_height: 1, color: [4, 4, 4]}}\n"
        + "cameras: {eye: {pose: [-1, 0, 0]}}\n",
        "Give a camera `shader: rt`, or use a light of another type.",
    ),
    Code(
        "SC553",
        "error",
        "six pictures that do not fit together",
        "The pictures of a map are the sides of a cube: of one size, and of one kind of pixels.",
        "$ scenecc validate scene.yaml    # environment: {map: {px: a.png, …, nz: larger.png}}",
        "Scale the pictures to one size, and save them in one format.",
    ),
    Code(
        "SC554",
        "error",
        "map that does not go all around",
        "One picture of the surroundings holds all directions, a whole turn from left to right and half a turn from "
        "top to bottom; SAPIEN fails on another with the first picture that a camera takes. A KTX holds six "
        "sides of a cube, with smaller and smaller copies of them down to one pixel.",
        "$ scenecc validate scene.yaml    # environment: {map: square.png}",
        "Take a picture that is twice as wide as it is high, or name six, `{px: …, nx: …, py: …, ny: …, …}`.",
    ),
)
