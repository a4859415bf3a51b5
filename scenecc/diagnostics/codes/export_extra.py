"""Rows of the table of codes: what is missing of the extra `export`."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        "SC813",
        "error",
        "a package for files of other programs is missing",
        "Textures are read by Pillow, COLLADA by pycollada and USD is written by usd-core. They come with the extra "
        "`export`.",
        "$ scenecc emit scene.yaml --to usd -o scene.usda    # where usd-core is not installed",
        'Run `pip install "scenecc[export]"`.',
    ),
)
