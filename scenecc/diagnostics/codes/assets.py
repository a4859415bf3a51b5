"""Rows of the table of codes: assets."""

from scenecc.diagnostics.codes.row import Code


def _scene(shape: str, *, visual: bool = False) -> str:
    """A whole scene file around one shape."""
    kind = "visuals" if visual else "shapes"
    return f"scenecc: 1\nentities:\n  thing:\n    body_type: static\n    {kind}:\n      - {shape}\n"


ROWS: tuple[Code, ...] = (
    Code(
        "SC401",
        "error",
        "the file does not exist",
        "SAPIEN logs a missing mesh and goes on: the body gets no collision shape and a mass of one milligram.",
        _scene("{type: triangle_mesh, file: no_such_file.obj}"),
        "Write the path relative to the scene file that names it, in the letter case that the file has.",
    ),
    Code(
        "SC402",
        "error",
        "the path leaves the folders that the scene may read",
        "A scene reads the folder tree of the top scene file, the asset roots and the packages that `pkg://` names, "
        "links followed. This holds for the files that an asset names too. A scene from a stranger then learns nothing "
        "about the rest of the machine.",
        _scene("{type: triangle_mesh, file: ../../elsewhere/bowl.obj}"),
        "Move the file into the scene's folder, give its folder with `--asset-root` and write `asset://…`, or allow it "
        "with `--allow-outside-assets`.",
    ),
    Code(
        "SC403",
        "error",
        "not a path that a scene may name",
        "A path is relative or absolute, with `/` between folders, or starts with `pkg://` or `asset://`. Nothing is "
        "fetched from a network, and `~` and backslashes are not expanded.",
        _scene("{type: triangle_mesh, file: 'https://example.org/bowl.obj'}"),
        "Download the file, put it beside the scene and write its relative path.",
    ),
    Code(
        "SC404",
        "error",
        "not a regular file",
        "The path is a folder, a pipe or a device.",
        _scene("{type: triangle_mesh, file: .}"),
        "Name a file.",
    ),
    Code(
        "SC405",
        "error",
        "no such Python package",
        "`pkg://PACKAGE/PATH` is a file inside an installed Python package with an `__init__.py`. The package is found "
        "without importing it, so PACKAGE is a top-level name: a dotted one would run the code of its parents.",
        _scene("{type: triangle_mesh, file: pkg://no_such_package/bowl.obj}"),
        "Install the package into the Python that runs scenecc, or use `asset://` with `--asset-root`.",
    ),
    Code(
        "SC406",
        "error",
        "`asset://` without an asset root",
        "`asset://PATH` is looked up in the asset roots, and none was given.",
        _scene("{type: triangle_mesh, file: asset://bowl.obj}"),
        "Give `--asset-root FOLDER`, set `SCENECC_ASSET_PATH`, or pass `asset_roots=`.",
    ),
    Code(
        "SC407",
        "error",
        "the file may not be read",
        "The file is there, but its permissions or a link in a circle keep it from being read.",
        "$ chmod a-r bowl.obj && scenecc validate scene.yaml",
        "Change the permissions of the file and its folders, or mend the link.",
    ),
)
