"""Rows of the table of codes: limits."""

from scenecc.diagnostics.codes.row import Code

_RAISE = "`--limit {0}=N` on the command line or `limits={{'{0}': N}}` in Python raises the limit. "

ROWS: tuple[Code, ...] = (
    Code(
        code="SC601",
        severity="error",
        title="the text is too long",
        cause=(
            "A scene file is at most 16 MiB of text (limit text_bytes), and so are all files together that it "
            "includes and uses. Each comma and each line of YAML counts as four bytes at least. "
            "A dict is held to as many values."
        ),
        example="$ head -c 17000000 /dev/zero | tr '\\0' '#' | scenecc validate -",
        cure=_RAISE.format("text_bytes")
        + "A file that is this long was written by a program: `repeat` and variation say the same in a few lines.",
    ),
    Code(
        code="SC602",
        severity="error",
        title="the document is too deep",
        cause=(
            "At most 100 mappings and lists stand inside one another (limit depth), what aliases name counted where "
            "they are used. Every stage of a compiler walks the document, and a deeper one could exhaust its stack."
        ),
        example="scenecc: 1\nx-deep: " + "[" * 101 + "]" * 101 + "\n",
        cure=_RAISE.format("depth") + "No scene needs such depth.",
    ),
    Code(
        code="SC603",
        severity="error",
        title="too much is reached through aliases",
        cause=(
            "At most 10 000 nodes are reached through aliases and merge keys (limit alias_nodes), each use of an alias "
            "counted with all that is below its anchor: ten lines of aliases to lists of aliases would unfold to more "
            "nodes than any memory holds."
        ),
        example=(
            "scenecc: 1\n"
            "x-a: &a [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n"
            "x-b: &b [*a, *a, *a, *a, *a, *a, *a, *a, *a, *a]\n"
            "x-c: &c [*b, *b, *b, *b, *b, *b, *b, *b, *b, *b]\n"
            "x-d: &d [*c, *c, *c, *c, *c, *c, *c, *c, *c, *c]\n"
        ),
        cure="Use `repeat` for many copies. " + _RAISE.format("alias_nodes"),
    ),
    Code(
        code="SC604",
        severity="error",
        title="too many objects",
        cause=(
            "A scene holds at most 130 000 entities, shapes and other objects (limit objects). What is "
            "repeated, used as a prefab, or written in a long file counts for more where it is large, since "
            "this is what takes memory: once for every 8 values, of which a form is 4 more than it holds; a "
            "robot 8 times more."
        ),
        example="$ scenecc validate tabletop.yaml --limit objects=2",
        cure=_RAISE.format("objects"),
    ),
    Code(
        code="SC605",
        severity="error",
        title="too many scenes",
        cause="There are at most 65 536 parallel scenes (limit scenes).",
        example=(
            "scenecc: 1\nnum_scenes: 100000000000\nentities:\n  ball:\n    shapes: [{type: sphere, radius: 0.1}]\n"
        ),
        cure=_RAISE.format("scenes"),
    ),
    Code(
        code="SC606",
        severity="error",
        title="too many objects times scenes",
        cause=(
            "The objects, each counted once for every scene that it is in, are at most 10 000 000 "
            "(limit objects_times_scenes): this is what is built."
        ),
        example="$ scenecc validate tabletop.yaml --limit objects_times_scenes=4",
        cure=_RAISE.format("objects_times_scenes"),
    ),
    Code(
        code="SC607",
        severity="error",
        title="an asset is too large",
        cause=(
            "A mesh, texture or robot description has at most 64 MiB (limit asset_bytes), and what a mesh "
            "holds takes at most three times as much in memory, where a line that is not written plainly "
            "counts as 256 bytes. All meshes of a scene together, with the files that they name and what they "
            "take in memory, have at most 512 MiB (limit assets_bytes)."
        ),
        example="$ scenecc validate mesh.yaml --limit asset_bytes=100",
        cure=_RAISE.format("asset_bytes")
        + "So is `assets_bytes` raised. A mesh of that size is too fine for collision: simplify it.",
    ),
    Code(
        code="SC608",
        severity="error",
        title="too long a chain of files",
        cause="At most 32 files include or use one another in a chain (limit includes).",
        example="$ scenecc validate scene.yaml --limit includes=1",
        cure="Use fewer files in between, or raise the limit with `--limit includes=N`.",
    ),
    Code(
        code="SC609",
        severity="error",
        title="too much to compute for the scenes",
        cause=(
            "The values that differ from scene to scene take at most 20 000 000 operations in all scenes "
            "(limit computed). An expression counts as one for every 16 characters, in each scene; a form as "
            "one for every four scenes; each file or material that an expression may name as 100. A few lines "
            "can ask for any number: 900 draws that read one another, in 65 536 scenes."
        ),
        example="$ scenecc validate variation.yaml --limit computed=10",
        cure=_RAISE.format("computed") + "Let many fields read one draw in place of computing the same again.",
    ),
)
