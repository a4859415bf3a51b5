"""Rows of the table of codes: constraints."""

from scenecc.diagnostics.codes.row import Code

_TWO = (
    "scenecc: 1\nentities:\n  post: {body_type: static, shapes: [{type: box, half_size: [0.1, 0.1, 1]}]}\n"
    "  bob: {pose: [0.5, 0, 1], shapes: [{type: sphere, radius: 0.1}]}\nconstraints:\n"
)

ROWS: tuple[Code, ...] = (
    Code(
        "SC560",
        "error",
        "limits the wrong way round",
        "SAPIEN takes limits whose lowest is above the highest; PhysX then applies none, or exchanges them.",
        _TWO + "  leash: {type: distance, parent: post, child: bob, limits: [2, 1]}\n",
        "Write the lower one first.",
    ),
    Code(
        "SC561",
        "error",
        "twist that is never reached",
        "PhysX measures the turn about x from -π to π. Limits beyond that are taken and never apply.",
        _TWO + "  turn: {type: drive, parent: post, child: bob, limits: {twist: [-4, 4]}}\n",
        "Write limits within -π and π [rad], or `-.inf` and `.inf` where there is none.",
    ),
    Code(
        "SC562",
        "error",
        "body tied to itself",
        "PhysX takes a constraint between a body and itself, and throws the body out of the scene.",
        _TWO + "  hold: {type: weld, parent: bob, child: bob}\n",
        "Name two bodies, or `parent: world`.",
    ),
    Code(
        "SC563",
        "error",
        "body that nothing can be tied to",
        "SAPIEN hangs a constraint on its child, which must be a body that can move; a body of type none is not part "
        "of the simulation at all.",
        _TWO + "  hold: {type: weld, parent: bob, child: post}\n",
        "Exchange `parent` and `child`, or give the body another `body_type`.",
    ),
    Code(
        "SC564",
        "error",
        "constraint that does nothing",
        "PhysX applies constraints to dynamic bodies and to links. Between two bodies that forces do not move there is "
        "nothing to constrain, and a drive without limits and drives leaves everything free.",
        _TWO + "  hold: {type: drive, parent: post, child: bob}\n",
        "Make one of the bodies dynamic, or give the drive `limits` or `drive`.",
    ),
)
