"""Rows of the table of codes: scenes as GLB and USD."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        "SC745",
        "warning",
        "something that a GLB cannot hold",
        "A GLB is what people look at: shapes and their materials. Lights, cameras and surroundings are left out, and "
        "so are the few things of a material that glTF has no word for. That physics is not in it goes without saying.",
        "$ scenecc emit scenes/cameras.yaml --to glb -o cameras.glb",
        "Nothing, if shapes are what is wanted. SAPIEN's own pictures, with the scene's lights and cameras, are those "
        "of `scenecc render`.",
    ),
    Code(
        "SC746",
        "note",
        "a plane is drawn as a square",
        "A colliding plane has no end, and a file holds triangles: what is drawn reaches a little beyond everything "
        "that stands on it. In a grid a plane takes no more than its scene's own place, so that no two overlap.",
        "$ scenecc emit scenes/tabletop.yaml --to glb --show collision -o tabletop.glb",
        "Nothing. The scene itself is as it was.",
    ),
    Code(
        "SC747",
        "error",
        "a mesh file that cannot be drawn",
        "Files for other programs hold the triangles of what is seen, which trimesh reads. It refuses this file, or "
        "finds no triangles in it.",
        "$ scenecc emit scene.yaml --to glb -o scene.glb    # where a mesh is replaced by something unreadable",
        "Export the mesh again, as GLB or OBJ.",
    ),
    Code(
        "SC748",
        "warning",
        "an image that other programs do not read",
        "Textures of GLB and USD are PNG and JPEG. Others that Pillow reads become PNG; HDR, EXR and KTX are left out, "
        "and the material's own numbers stand in their place.",
        "$ scenecc emit scene.yaml --to glb -o scene.glb    # with `base_color_texture: sky.hdr`",
        "Save the image as PNG or JPEG.",
    ),
    Code(
        "SC750",
        "warning",
        "something that USD has not",
        "UsdPhysics holds bodies, colliders, masses, joints and drives. What only one engine has (damping, the "
        "solver's settings, contact offsets), joints that follow others, lights and cameras are left out of the file.",
        "$ scenecc emit scenes/knobs.yaml --to usd -o knobs.usda",
        "Nothing has to be done where it does not matter; otherwise set it in the program that reads the file.",
    ),
)
