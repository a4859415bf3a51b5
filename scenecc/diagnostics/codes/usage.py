"""Rows of the table of codes: use of the tool."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        code="SC901",
        severity="error",
        title="a path given to the command is not there, or is a folder and no file",
        cause=(
            "The command was told to read a file or folder that is not there. Nothing was read in its place. Folders "
            "are for `scenecc validate` alone: the other commands read one file."
        ),
        example="$ scenecc validate no_such_scene.yaml",
        cure="Correct the path. It is relative to the folder in which the command runs.",
    ),
    Code(
        code="SC902",
        severity="error",
        title="a folder holds no scene",
        cause=(
            "In a folder, the files that end in .yaml or .yml and have the key `scenecc` at the top are scenes. "
            "This folder has none, so a check of it would pass whatever is in it."
        ),
        example="$ mkdir empty && scenecc validate empty",
        cure=(
            "Name the folder in which the scenes are, or the files themselves: a file that is named is always checked."
        ),
    ),
    Code(
        code="SC903",
        severity="error",
        title="a file or folder under a given folder cannot be read",
        cause="A folder was given to be searched, and a part of it may not be read: scenes there would go unchecked.",
        example="$ mkdir locked && chmod 000 locked && scenecc validate .",
        cure="Change its permissions, or name the files that are meant.",
    ),
    Code(
        code="SC904",
        severity="error",
        title="an output file cannot be written",
        cause=(
            "The file named by -o is a folder, lies in a folder that is not there, or may not be written. "
            "A file that was there before is left as it was."
        ),
        example="$ scenecc build scene.yaml -o no_such_folder/plan.json",
        cure="Name a file in a folder that exists and may be written, or `-` for standard output.",
    ),
    Code(
        code="SC905",
        severity="error",
        title="no such diagnostic code",
        cause="`scenecc explain` was given a code that is not in the table.",
        example="$ scenecc explain SC999",
        cure="Run `scenecc explain` without a code: it lists them all.",
    ),
    Code(
        code="SC906",
        severity="error",
        title="standard output is asked to hold two things",
        cause=(
            "`-o -` writes the result to standard output, and --format json, github or sarif writes diagnostics "
            "there: a program could read neither."
        ),
        example="$ scenecc build scene.yaml -o - --format json",
        cure="Name a file after -o, or leave --format at text, which then goes to standard error.",
    ),
    Code(
        code="SC907",
        severity="error",
        title="a plan is asked to be another",
        cause=(
            "The source is a plan in JSON, in which the number of scenes and every draw are settled: it cannot be "
            "given another number of scenes or another seed."
        ),
        example="$ scenecc build scene.yaml -o plan.json && scenecc build plan.json --num-scenes 9",
        cure="Compile the scene file again with the number of scenes and the seed that are meant.",
    ),
    Code(
        code="SC908",
        severity="error",
        title="--scenes or --scene selects scenes that are not there",
        cause=(
            "`build --scenes` and `render --scene` take what `scene_idxs` takes in a file: indices and slices, with "
            "commas between them; `--scene` of other commands takes one index. This one is none of these, selects a "
            "scene twice or none, or goes beyond the number of scenes."
        ),
        example="$ scenecc build scene.yaml --num-scenes 4 --scenes 2:9",
        cure="Select scenes from 0 to one less than their number: `--scenes 2:4`, `--scenes 0,3` or `--scenes ::2`.",
    ),
    Code(
        code="SC909",
        severity="error",
        title="no prefab of that name ships",
        cause="`scenecc prefabs` was given a name that none of the prefabs of the package has.",
        example="$ scenecc prefabs tabel",
        cure="Run `scenecc prefabs` without a name: it lists them all. Of a file of your own: `scenecc params FILE`.",
    ),
    Code(
        code="SC910",
        severity="error",
        title="no entity of that name is there",
        cause="`--entity` names an entity of the scene, or several by a pattern, and nothing has such a name.",
        example="$ scenecc inspect scene.yaml --entity cub",
        cure="Name an entity as `scenecc inspect` lists it, or write a pattern: `--entity 'leg_*'`.",
    ),
    Code(
        code="SC911",
        severity="error",
        title="no such camera, or not in this scene",
        cause=(
            "`scenecc render --camera` was given a name that no camera of the file has, or --scene selects a scene in "
            "which the camera is not."
        ),
        example="$ scenecc render scene.yaml --camera eye -o eye.png",
        cure="Name a camera of the file, or leave --camera out: the picture is then of a camera that frames the scene.",
    ),
    Code(
        code="SC912",
        severity="error",
        title="a picture that is too large",
        cause=(
            "Pictures, and sheets of them, have at most 2²⁶ pixels, and the frames of a film 2²³: the renderer takes "
            "some 300 bytes for each pixel of a film."
        ),
        example="$ scenecc render scene.yaml --num-scenes 4096 --grid -o sheet.png",
        cure="Select fewer scenes (`--scene 0:64`), or take smaller pictures (`--size 160x120`).",
    ),
    Code(
        code="SC913",
        severity="error",
        title="a picture that the camera does not take",
        cause="SAPIEN's shader packs `minimal` and `trivial` have no picture of normals.",
        example=(
            "$ echo 'cameras: {eye: {shader: minimal}}' >> scene.yaml && "
            "scenecc render scene.yaml --camera eye --what normal -o normal.png"
        ),
        cure="Give the camera another `shader`, or leave --camera out.",
    ),
    Code(
        code="SC915",
        severity="error",
        title="nothing that can be written as a URDF, or too much for one",
        cause=(
            "A URDF is one robot. `--entity` names none that is in the scene, the scene has no articulation, or it has "
            "several and -o names one file."
        ),
        example="$ scenecc emit scene.yaml --to urdf -o scene.urdf    # which has no articulation",
        cure="Name an entity with --entity (a body becomes a robot of one link), or a folder after -o.",
    ),
)
