"""Rows of the table of codes: reading YAML."""

from scenecc.diagnostics.codes.row import Code

_BALL = "entities:\n  ball:\n    shapes: [{type: sphere, radius: 0.1}]\n"

ROWS: tuple[Code, ...] = (
    Code(
        code="SC001",
        severity="error",
        title="the file cannot be read",
        cause="It is not there, may not be read, or is a folder, a pipe or a device.",
        example="$ scenecc validate missing.yaml",
        cure="Check the path, which is relative to the folder where the command runs. For a pipe, give `-`.",
    ),
    Code(
        code="SC002",
        severity="error",
        title="the file is not text",
        cause=(
            "Scene files are UTF-8 (UTF-16 with a byte order mark is read too). This one holds bytes that are no text "
            "in that encoding, control characters that YAML does not allow, or U+0085, U+2028 or U+2029, which are "
            "line breaks to some programs and not to others, so that line numbers would differ."
        ),
        example='scenecc: 1\nname: "a\x7fb"\n' + _BALL,
        cure='Save the file as UTF-8. In double quotes such characters can be written with an escape: `"\\x7f"`.',
    ),
    Code(
        code="SC003",
        severity="error",
        title="bad YAML",
        cause="The text does not follow the syntax of YAML; what comes after this place could not be read.",
        example="scenecc: 1\nparams: {r: 0.1}\n" + _BALL.replace("ball:", "ball:\n    pose: [${r}, 0, 0]"),
        cure=(
            "Mend the place that is shown, or the line before it. An expression inside brackets is quoted: "
            '`["${r}", 0, 0]`. Indentation is of blanks, never tabs, and a colon is followed by a blank.'
        ),
    ),
    Code(
        code="SC004",
        severity="error",
        title="a key is written twice",
        cause="Most readers of YAML silently take the last of two equal keys: half of what was written would be lost.",
        example="scenecc: 1\nname: one\nname: two\n" + _BALL,
        cure="Take one of them away. Both places are shown.",
    ),
    Code(
        code="SC005",
        severity="error",
        title="a key is not a string",
        cause="A key that reads as a number, a boolean, null, a list or a mapping can name nothing in a scene.",
        example="scenecc: 1\nentities:\n  12:\n    shapes: [{type: sphere, radius: 0.1}]\n",
        cure='Quote it if it is a name: `"12":`. Only in the mapping of `per_scene` do integers stand for scenes.',
    ),
    Code(
        code="SC006",
        severity="error",
        title="a key without a value",
        cause="`mass:` with nothing after it is null in YAML. It could mean the default, zero, or an unfinished edit.",
        example="scenecc: 1\nentities:\n  ball:\n    mass:\n    shapes: [{type: sphere, radius: 0.1}]\n",
        cure="Give it a value, or take it away: a key that is left out has its default. An empty list is `[]`.",
    ),
    Code(
        code="SC007",
        severity="error",
        title="several documents in one file",
        cause="A line `---` starts another document; it is not clear which of them is the scene.",
        example="scenecc: 1\n" + _BALL + "---\nscenecc: 1\n" + _BALL,
        cure="Put each scene into a file of its own.",
    ),
    Code(
        code="SC008",
        severity="error",
        title="a tag that is unknown or does not fit",
        cause=(
            "Scene files are plain data: only the tags of YAML's core schema are known (`!!str`, `!!int`, `!!float`, "
            "`!!bool`, `!!null`, `!!map`, `!!seq`), on values that they fit. No tag ever constructs an object."
        ),
        example="scenecc: 1\nname: !!python/name:os.system x\n" + _BALL,
        cure="Take the tag away.",
    ),
    Code(
        code="SC009",
        severity="error",
        title="an alias to nothing",
        cause="`*name` stands for the node that was marked `&name` above it, and no node was.",
        example="scenecc: 1\nentities:\n  ball:\n    shapes: *shapes\n",
        cure="Mark the node with `&name`, above the alias. A string that starts with `*` is quoted.",
    ),
    Code(
        code="SC010",
        severity="error",
        title="data that holds itself",
        cause="An alias inside the node that it names (or a Python dict or list that holds itself) has no end.",
        example="scenecc: 1\nx-loop: &loop [*loop]\n" + _BALL,
        cure="Write out what is meant.",
    ),
    Code(
        code="SC011",
        severity="error",
        title="a merge of something that is no mapping",
        cause="`<<` merges the entries of a mapping, or of a list of mappings, into the one where it stands.",
        example="scenecc: 1\nx-list: &list [1, 2]\n" + _BALL.replace("ball:", "ball:\n    <<: *list"),
        cure="Write `<<: *anchor` or `<<: [*one, *other]`, where the anchors mark mappings.",
    ),
    Code(
        code="SC012",
        severity="error",
        title="an empty document",
        cause="There is nothing in the file but blanks and comments.",
        example="# nothing yet\n",
        cure="A scene file starts with `scenecc: 1`.",
    ),
    Code(
        code="SC013",
        severity="error",
        title="the document is not a mapping",
        cause="A scene file is a mapping, `key: value` lines at its top; this is a list or a single value.",
        example="- scenecc: 1\n",
        cure="Write the keys at the top of the file, without a dash, each with a blank after its colon.",
    ),
    Code(
        code="SC014",
        severity="error",
        title="a number that cannot be held",
        cause="It is beyond the range of a double (1.8e308), or an integer of more than 100 characters.",
        example="scenecc: 1\nentities:\n  ball:\n    mass: 1e400\n    shapes: [{type: sphere, radius: 0.1}]\n",
        cure="Write a number that can be held; infinity is `.inf`, where a key allows it.",
    ),
    Code(
        code="SC015",
        severity="error",
        title="a Python value that no scene can hold",
        cause=(
            "A scene given as a dict holds dicts with string keys, lists, tuples, strings, numbers, booleans, numpy "
            "scalars and arrays, and paths. Sets have no order, bytes no encoding, and other objects no one meaning."
        ),
        example="$ python -c \"import scenecc; scenecc.load_scene({'scenecc': 1, 'name': b'bytes'})\"",
        cure="Convert it: `list(values)`, `data.decode()`, `tensor.cpu().numpy()`.",
    ),
    Code(
        code="SC016",
        severity="error",
        title="too many errors",
        cause="Reading stops after 1000 errors in one file; what comes after was not looked at.",
        example="$ yes '- ' | head -n 2000 | sed '1i x-list:' | scenecc validate -",
        cure="Mend the first ones. A file with that many was probably not meant to be a scene.",
    ),
    Code(
        code="SC017",
        severity="error",
        title="a key that no scene can have",
        cause="A key may hold any character but U+0000, which marks what the compiler itself notes among the keys.",
        example='scenecc: 1\nx-note: {"a\\0b": 1}\n' + _BALL,
        cure="Take the character out of the key.",
    ),
)
