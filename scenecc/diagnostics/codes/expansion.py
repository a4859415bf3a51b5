"""Rows of the table of codes: parameters, expressions, repetition, includes, prefabs and shared draws."""

from scenecc.diagnostics.codes.row import Code

_BOX = "    shapes:\n      - {type: box, half_size: [0.1, 0.1, 0.1]}\n"


ROWS: tuple[Code, ...] = (
    Code(
        "SC201",
        "error",
        "unknown name in an expression",
        "An expression reads parameters of its file, loop variables around it, shared draws, `scene` and "
        "`num_scenes`. A draw reads those above it, and so does a parameter's default.",
        'scenecc: 1\nparams: {size: 0.1}\nentities:\n  cube:\n    shapes:\n      - {type: sphere, radius: "${sise}"}\n',
        "Write the name that the hint suggests, or add it under `params` or `draws`.",
    ),
    Code(
        "SC202",
        "error",
        "expression without a value",
        "A division by zero, an index beyond a list, a text where a number is needed, a result that is too large.",
        'scenecc: 1\nparams: {n: 0}\nentities:\n  cube:\n    mass: "${1 / n}"\n' + _BOX,
        "Let the expression have a value: `1 / n if n > 0 else 1`.",
    ),
    Code(
        "SC203",
        "error",
        "structure that would differ from scene to scene",
        "What is repeated, left out, used, named or selected is the same in every scene, so it cannot read a draw, "
        "`scene`, or a parameter that is given a form of variation.",
        'scenecc: 1\ndraws: {n: {integers: [1, 3]}}\nentities:\n  cube:\n    repeat: {i: {count: "${n}"}}\n' + _BOX,
        "Let a parameter decide, or use `variants` with `pick`.",
    ),
    Code(
        "SC204",
        "error",
        "name that means something else",
        "A parameter, draw or loop variable is called neither like another of them nor like a word of expressions.",
        "scenecc: 1\nparams: {size: 0.1}\nentities:\n  cube:\n    repeat: {size: [1, 2]}\n" + _BOX,
        "Choose another name.",
    ),
    Code(
        "SC210",
        "error",
        "unknown parameter",
        "A file takes the parameters that it declares.",
        "scenecc: 1\nentities:\n  box: {use: scenecc:box, with: {sise: 1}}\n",
        "Write the name that the hint suggests; `scenecc params FILE` lists them.",
    ),
    Code(
        "SC211",
        "error",
        "value of another type than the parameter's",
        "A parameter has a type; one that is written as its default alone has that of the default.",
        "scenecc: 1\nparams:\n  n: {type: integer, default: 1.5}\n",
        "Give a value of the type, or change the type.",
    ),
    Code(
        "SC212",
        "error",
        "parameter out of its range",
        "The value, an alternative of it or a bound of what is drawn lies outside `min` and `max`.",
        "scenecc: 1\nparams:\n  size: {type: number, default: 0.05, min: 0.1}\n",
        "Give a value within the range.",
    ),
    Code(
        "SC213",
        "error",
        "parameter without a value",
        "A parameter that has no `default` must be given.",
        "scenecc: 1\nparams:\n  size: {type: number}\n",
        "Give it: `with: {size: 1}`, `--set size=1`, `params={'size': 1}`.",
    ),
    Code(
        "SC214",
        "error",
        "bad declaration of a parameter",
        "The keys do not go together: a range for a text, a choice without options, no type and no default that tells "
        "it.",
        "scenecc: 1\nparams:\n  kind: {type: choice, default: a}\n",
        "Mend the declaration: `{type: choice, options: [a, b], default: a}`.",
    ),
    Code(
        "SC220",
        "error",
        "not something to repeat over",
        "A loop variable takes a list, or `{count: n}` for the numbers 0 to n - 1.",
        'scenecc: 1\nparams: {n: 3}\nentities:\n  cube:\n    repeat: {i: "${n}"}\n' + _BOX,
        "Write a list, or `{count: n}` with a whole number.",
    ),
    Code(
        "SC221",
        "error",
        "name of two",
        "Copies, instances and what is written must have different names: one of them would be lost.",
        'scenecc: 1\nentities:\n  leg:\n    repeat: {i: [0, 1], j: [0, 1]}\n    name: "leg_${i}"\n' + _BOX,
        "Let the name tell the copies apart (`leg_${i}_${j}`), or give instances a prefix.",
    ),
    Code(
        "SC222",
        "note",
        "empty repetition",
        "A product with an empty list is empty, so nothing is built. A list that an expression makes empty is no note.",
        "scenecc: 1\nentities:\n  cube:\n    repeat: {i: []}\n" + _BOX,
        "Give the list a value, or take the entity away.",
    ),
    Code(
        "SC223",
        "error",
        "condition that is neither true nor false",
        "`if` takes a boolean, or an expression over parameters that gives one.",
        'scenecc: 1\nparams: {n: 2}\nentities:\n  cube:\n    if: "${n}"\n' + _BOX,
        "Compare: `${n > 0}`.",
    ),
    Code(
        "SC224",
        "error",
        "name that names nothing",
        "An entity is called as its key says; `name` names the copies of one that is repeated.",
        "scenecc: 1\nentities:\n  cube:\n    name: box\n" + _BOX,
        "Rename the key, or add `repeat`.",
    ),
    Code(
        "SC230",
        "error",
        "key of the whole in an included file",
        "`name`, `description`, `num_scenes` and `seed` are those of the file that includes.",
        "$ cat parts.yaml\nscenecc: 1\nnum_scenes: 4\n$ cat scene.yaml\nscenecc: 1\ninclude: [parts.yaml]\n",
        "Take the key away, or use the file as a prefab: `{use: parts.yaml}`.",
    ),
    Code(
        "SC231",
        "error",
        "name in two files",
        "An included file shares the names of the file that includes it; of two settings one would be lost.",
        "$ cat parts.yaml\nscenecc: 1\nphysics: {timestep: 0.01}\n"
        "$ cat scene.yaml\nscenecc: 1\ninclude: [parts.yaml]\nphysics: {timestep: 0.02}\n",
        "Rename one, or use the file as a prefab: what is in it then has a prefix.",
    ),
    Code(
        "SC232",
        "error",
        "files in a circle",
        "A file that leads back to itself has no end.",
        "scenecc: 1\nentities:\n  again: {use: scene.yaml}\n",
        "Leave one of the uses out.",
    ),
    Code(
        "SC240",
        "error",
        "no such prefab ships",
        "`scenecc:NAME` is a prefab that comes with the package.",
        "scenecc: 1\nentities:\n  box: {use: scenecc:bux}\n",
        "Write the name that the hint suggests; `scenecc prefabs` lists them.",
    ),
    Code(
        "SC241",
        "note",
        "setting of a prefab",
        "Physics, environment, number of scenes and seed are those of the scene, so that a prefab can also be compiled "
        "by itself.",
        "$ cat desk.yaml\nscenecc: 1\nphysics: {timestep: 0.001}\n"
        "$ cat scene.yaml\nscenecc: 1\nentities:\n  desk: {use: desk.yaml}\n",
        "Nothing, if that is meant; otherwise give the setting in the scene.",
    ),
    Code(
        "SC242",
        "error",
        "list by scene in a prefab",
        "A `per_scene` list has a value for each scene that its entity is in, and a prefab does not know in which it "
        "will be.",
        "$ cat pair.yaml\nscenecc: 1\nframes:\n  left: {pose: {per_scene: [[0, 0, 0], [1, 0, 0]]}}\n"
        "$ cat scene.yaml\nscenecc: 1\nnum_scenes: 2\nentities:\n  pair: {use: pair.yaml}\n",
        "Write `{per_scene: {0: …, default: …}}`, `cycle`, or a parameter that the user gives as a form.",
    ),
    Code(
        "SC250",
        "error",
        "unknown shared draw",
        "`draws=` takes the place of draws that the file declares.",
        "$ python -c \"import scenecc; scenecc.compile_scene('scene.yaml', draws={'haf': [0.1]})\"",
        "Write the name that the hint suggests, or declare it under `draws`.",
    ),
)
