"""Rows of the table of codes: assets."""

from scenecc.diagnostics.codes.row import Code


def _scene(shape: str) -> str:
    """A whole scene file around one shape."""
    return f"scenecc: 1\nentities:\n  thing:\n    body_type: static\n    shapes:\n      - {shape}\n"


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
        "A scene reads the folder tree of the top scene file, the asset roots and the packages that `pkg://` "
        "names, links followed. This holds for the files that an asset names too. A scene from a stranger then "
        "learns nothing about the rest of the machine.",
        _scene("{type: triangle_mesh, file: ../../elsewhere/bowl.obj}"),
        "Move the file into the scene's folder, give its folder with `--asset-root` and write `asset://…`, or "
        "allow it with `--allow-outside-assets`.",
    ),
    Code(
        "SC403",
        "error",
        "not a path that a scene may name",
        "A path is relative or absolute, with `/` between folders, or starts with `pkg://` or `asset://`. Nothing "
        "is fetched from a network, and `~` and backslashes are not expanded.",
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
        "`pkg://PACKAGE/PATH` is a file inside an installed Python package with an `__init__.py`. The package is "
        "found without importing it, so PACKAGE is a top-level name: a dotted one would run the code of its "
        "parents.",
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
    Code(
        "SC410",
        "error",
        "not a format that is read",
        "Meshes are OBJ, glTF (`.gltf`, `.glb`), STL or PLY, and COLLADA (`.dae`) where they are only seen; "
        "textures PNG, JPEG, BMP, TGA, HDR, EXR or KTX, by the suffix of the file. Other formats, glTF with compressed "
        "meshes, and COLLADA with skins could not be checked before "
        "the engine gets them, and SAPIEN drops in silence what it cannot load.",
        _scene("{type: triangle_mesh, file: pkg://scenecc/py.typed}"),
        "Convert the mesh to GLB or OBJ, the image to PNG.",
    ),
    Code(
        "SC411",
        "error",
        "USD is not read",
        "SAPIEN converts a USD file and writes the result beside it. Nothing is ever written beside an asset here.",
        "$ scenecc validate scene.yaml  # with `file: bowl.usdz`",
        "Convert it to GLB once and name that.",
    ),
    Code(
        "SC412",
        "error",
        "the mesh file is broken",
        "The file is not what its suffix says, or it is cut short. SAPIEN builds a body without a shape from it; a "
        "PLY that is cut short ends the whole process.",
        "$ head -c 300 whole.stl > bowl.stl && scenecc validate scene.yaml",
        "Export or download the file again, and give it the suffix of its format.",
    ),
    Code(
        "SC413",
        "error",
        "the mesh has no triangles",
        "The file holds points or lines, or nothing.",
        "$ grep '^v' whole.obj > bowl.obj && scenecc validate scene.yaml",
        "Export the mesh with its faces.",
    ),
    Code(
        "SC414",
        "error",
        "coordinates that are not finite",
        "A NaN or an infinity among the vertices (also numbers above 3e38, which single precision cannot hold) "
        "makes the whole hull wrong, or kills it.",
        "$ sed 's/^v 0 /v nan /' whole.obj > bowl.obj && scenecc validate scene.yaml",
        "Export the mesh again.",
    ),
    Code(
        "SC415",
        "error",
        "a mesh without volume or area",
        "A hull needs four points that do not lie in one plane: PhysX turns a flat one into a shape that the file "
        "does not show. A triangle mesh needs a triangle with an area.",
        "$ scenecc validate scene.yaml  # with `type: convex_mesh` of a flat square",
        "Give the mesh a thickness, use a `box`, or let it only be seen (`visuals`, `type: mesh`).",
    ),
    Code(
        "SC416",
        "warning",
        "a hull so small that its corners are lost",
        "When PhysX cooks a hull it leaves out the corners that are within 0.7 mm of it, before the shape is "
        "scaled: a cube of 1 mm becomes a tetrahedron, a ball of 1 cm loses 15 % of its volume.",
        "$ scenecc validate scene.yaml  # with `type: convex_mesh` of a screw of 4 mm",
        "Store the mesh ten or a hundred times larger and write `scale: 0.1` or `scale: 0.01`, or collide with a "
        "primitive.",
    ),
    Code(
        "SC417",
        "error",
        "a mesh with coordinates beyond reason",
        "A vertex lies more than a thousand kilometres from the origin of the mesh. PhysX loses precision there, "
        "and at a thousand times that it no longer computes a mass.",
        "$ sed 's/^v 0 /v 1e9 /' whole.obj > bowl.obj && scenecc validate scene.yaml",
        "Export the mesh in metres, about its own centre.",
    ),
    Code(
        "SC418",
        "error",
        "a file that an asset names is missing",
        "An OBJ names its materials, these, a glTF and a COLLADA their images, a `.gltf` its buffers. SAPIEN shows a "
        "mesh in white where they are missing. For shapes that only collide, materials and images are not asked for.",
        "$ rm bowl.mtl && scenecc validate scene.yaml",
        "Put the file where the asset says, relative to the asset, or take the line that names it out of the asset.",
    ),
    Code(
        "SC419",
        "error",
        "an asset names a file outside",
        "What holds for the paths of a scene holds for those in its assets: relative, and inside the folders that "
        "the scene may read.",
        "$ echo 'mtllib ../../secret.mtl' >> bowl.obj && scenecc validate scene.yaml",
        "Export the asset with relative paths, or give the folder with `--asset-root`.",
    ),
    Code(
        "SC420",
        "error",
        "the image is broken",
        "The texture is no image, is cut short, or is of a kind that SAPIEN does not load. EXR and KTX are told by "
        "their suffix, and of KTX it loads R8G8B8A8 alone.",
        "$ echo hello > checker.png && scenecc validate scene.yaml",
        "Save it again as PNG or JPEG.",
    ),
    Code(
        "SC421",
        "warning",
        "convex parts of an STL",
        "An STL is a list of triangles without parts. SAPIEN guesses: triangles that touch are one part.",
        "$ scenecc validate scene.yaml  # with `{type: convex_parts, file: bowl.stl}`",
        "Export the parts as objects of an OBJ or as meshes of a GLB, or write `type: convex_mesh`.",
    ),
    Code(
        "SC422",
        "error",
        "a file changed while the scene was built",
        "What is checked is what is built: the engine opens files by their names, and between the check and that "
        "another program wrote into one, or put another in its place.",
        "$ while true; do cp whole.obj bowl.obj; done & scenecc build scene.yaml",
        "Build again when everything is written.",
    ),
)
