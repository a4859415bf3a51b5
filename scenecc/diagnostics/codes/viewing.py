"""Rows of the table of codes: pages in the browser."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        "SC815",
        "error",
        "a page cannot be served",
        "`scenecc view` serves a page at an address and a port of this machine. The port is in use by another program, "
        "or the address is none of this machine's.",
        "$ scenecc view scene.yaml --port 8080    # where another program listens already",
        "Give another `--port`, or leave it out for one that is free.",
    ),
    Code(
        "SC816",
        "error",
        "the packages that a page needs are missing",
        "`scenecc view` shows scenes with viser and watches their files with watchfiles, which come with the extra "
        "`view`.",
        "$ scenecc view scene.yaml    # in an environment without viser",
        "`pip install 'scenecc[view]'`.",
    ),
    Code(
        "SC817",
        "error",
        "a reset that cannot be done",
        "A reset draws poses, velocities and drives anew, and with this seed something came out that the engine cannot "
        "hold; the message names it. The simulation stays as it was.",
        "$ scenecc view scene.yaml    # and a reset with a seed for which an expression divides by zero",
        "Change the expression, or take another seed.",
    ),
)
