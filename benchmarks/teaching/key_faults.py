"""Faults of keys and of names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

import yaml

from benchmarks.teaching.scene_text import Edit, Entry, Fault, SceneText, numbers
from benchmarks.teaching.words import WORDS

if TYPE_CHECKING:
    from random import Random

_KEY: Final = "SC1(0[1-57]|1[0156])|SC21[04]|SC224|SC24"
_NAME: Final = "SC(20[12]|210|24|30[123]|3[235]|40[1-4]|410|453|10[1578]|25|56|330|9)"


def typo(word: str, draw: Random) -> str:
    """Returns a word with two letters exchanged, or one left out, doubled or hit beside its place on the keyboard."""
    letters = [at for at, letter in enumerate(word) if letter.isalpha()]
    at = draw.choice(letters)
    swapped = word[:at] + word[at + 1 : at + 2] + word[at] + word[at + 2 :]
    row = next((row for row in ("qwertyuiop", "asdfghjkl", "zxcvbnm") if word[at].lower() in row), "aa")
    near = row[row.index(word[at].lower()) - 1]
    made = [swapped, word[:at] + word[at + 1 :], word[:at] + word[at] * 2 + word[at + 1 :]]
    made.append(word[:at] + near + word[at + 1 :])
    return next((one for one in draw.sample(made, 4) if one != word and one), f"{word}x")


def _renamed(entry: Entry, what: str, new: str, codes: str = _KEY) -> Fault:
    assert entry.key is not None
    start = entry.key.start_mark.index
    return Fault(what, (Edit(start, entry.key.end_mark.index, new),), (start,), codes)


def misspelt_key(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of():
        key = str(entry.path[-1])
        if len(key) > 2:
            yield _renamed(entry, f"misspelt `{key}`", typo(key, draw))


def word_of_another_tool(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of(*WORDS):
        key = str(entry.path[-1])
        word, _, factor = draw.choice(WORDS[key]).partition("*")
        fault = _renamed(entry, f"`{word}` for `{key}`", word)
        if factor:
            found = numbers(_data(scene, entry))
            if not found:
                continue
            text = _flow([2 * one for one in found] if isinstance(_data(scene, entry), list) else 2 * found[0])
            edit = Edit(entry.value.start_mark.index, entry.value.end_mark.index, text)
            fault = fault._replace(edits=(*fault.edits, edit))
        yield fault


def camel_case(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of():
        key = str(entry.path[-1])
        if "_" in key:
            yield _renamed(entry, f"camelCase of `{key}`", re.sub(r"_(\w)", lambda found: found[1].upper(), key))


def wrong_number(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of():
        key = str(entry.path[-1])
        if key.endswith("ies"):
            yield _renamed(entry, f"singular of `{key}`", f"{key[:-3]}y")
        elif key.endswith("s") and key not in {"settled", "radius"}:
            yield _renamed(entry, f"singular of `{key}`", key[:-1])
        elif key in {"material", "color", "pose", "joint", "shape", "mass", "parent", "child", "variant", "file"}:
            yield _renamed(entry, f"plural of `{key}`", f"{key}s")


def level_up(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """An entry beside the mapping that should have it."""
    starts = {one.path: one for one in scene.entries}
    for entry in scene.entries_of():
        above = starts.get(entry.path[:-1])
        if above is None or not above.is_key or not scene.begins_line(above) or not scene.is_one_line(entry):
            continue
        assert above.key is not None
        if above.value.start_mark.index == entry.start and isinstance(entry.value, yaml.MappingNode):
            continue
        if len(scene.at_path(above.path)) < 2:
            continue
        line = scene.line_start(above.start)
        indent = " " * above.key.start_mark.column
        if "-" in scene.text[line : above.start]:
            continue
        text = f"{indent}{scene.text[entry.start : scene.end(entry.value)]}\n"
        yield Fault(
            f"`{entry.path[-1]}` beside `{above.path[-1]}`",
            (Edit(line, line, text), scene.without(entry)),
            (line,),
            _KEY,
        )


def level_down(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """An entry of a body in its first shape."""
    starts = {one.path: one for one in scene.entries}
    for entry in scene.entries_of("mass", "body_type", "linear_velocity", "gravity", "inertial", "place"):
        shape = starts.get((*entry.path[:-1], "shapes", 0))
        if shape is None or not isinstance(shape.value, yaml.MappingNode) or not shape.value.flow_style:
            continue
        if scene.is_one_line(entry) and scene.begins_line(entry):
            text, at = scene.text[entry.start : scene.end(entry.value)], shape.value.end_mark.index - 1
            yield Fault(
                f"`{entry.path[-1]}` in a shape", (scene.without(entry), Edit(at, at, f", {text}")), (at,), _KEY
            )


def _data(scene: SceneText, entry: Entry) -> object:
    return scene.at_path(entry.path)


def _flow(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    return f"{value:.10g}" if isinstance(value, int | float) else str(value)


_REFERENCES: Final = frozenset(
    ("material", "relative_to", "parent", "child", "on", "inside", "above", "of", "to", "mount", "facing", "near",
     "collision_group", "group", "a", "b")
)  # fmt: skip
_FILES: Final = re.compile(r"[\w./-]+\.(?:urdf|xml|obj|stl|glb|png|yaml)")


def _definitions(scene: SceneText) -> dict[str, Entry]:
    return {
        str(one.path[1]): one
        for one in scene.entries
        if len(one.path) == 2 and one.path[0] in {"entities", "materials", "frames", "params", "draws"} and one.key
    }


def _references(scene: SceneText) -> Iterator[Entry]:
    names = _definitions(scene)
    for entry in scene.entries:
        if isinstance(entry.value, yaml.ScalarNode) and entry.name in _REFERENCES and entry.value.value in names:
            yield entry


def _replaced(scene: SceneText, entry: Entry, what: str, new: str) -> Fault:
    start = entry.value.start_mark.index
    text = f'"{new}"' if scene.text[start] == '"' else new
    return Fault(what, (Edit(start, entry.value.end_mark.index, text),), (start,), _NAME)


def misspelt_reference(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in _references(scene):
        name = entry.value.value
        made = draw.choice([typo(name, draw), name.capitalize(), f"{name}s", f"the_{name}"])
        yield _replaced(scene, entry, f"`{made}` for `{name}` in `{entry.name}`", made)


def renamed_definition(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """What others refer to has another name."""
    references = list(_references(scene))
    for name, entry in _definitions(scene).items():
        users = [one.start for one in references if one.value.value == name]
        users += [found.start() for found in re.finditer(rf"\$\{{[^}}]*\b{name}\b", scene.text)]
        if users and entry.key is not None:
            new = draw.choice([f"{name}_1", f"my_{name}", f"{name}_old"])
            fault = _renamed(entry, f"`{name}` is defined as `{new}`", new, _NAME)
            yield fault._replace(at=(*fault.at, *users))


def misspelt_file(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries:
        found = entry.value.value if isinstance(entry.value, yaml.ScalarNode) else ""
        if entry.name in {"description", "that"} or not _FILES.fullmatch(found):
            continue
        path = PurePath(found)
        suffix = {".obj": ".stl", ".stl": ".obj", ".png": ".jpg", ".urdf": ".xacro", ".yaml": ".yml"}.get(
            path.suffix, ".txt"
        )
        typed, upper = path.with_stem(typo(path.stem, draw)), path.with_stem(path.stem.upper())
        made = draw.choice([str(typed), path.name, str(path.with_suffix(suffix)), f"../{path}", str(upper)])
        if made != found:
            yield _replaced(scene, entry, f"`{made}` for `{found}`", made)


def misspelt_prefab(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for entry in scene.entries_of("use"):
        if isinstance(entry.value, yaml.ScalarNode) and entry.value.value.startswith("scenecc:"):
            name = entry.value.value.removeprefix("scenecc:")
            made = draw.choice([f"scenecc:{typo(name, draw)}", name, f"scenecc/{name}", f"{name}.yaml"])
            yield _replaced(scene, entry, f"`use: {made}` for `scenecc:{name}`", made)


def misspelt_parameter(scene: SceneText, draw: Random) -> Iterator[Fault]:
    names = [str(one.path[1]) for one in scene.entries if len(one.path) == 2 and one.path[0] in {"params", "draws"}]
    for name in names:
        for found in re.finditer(rf"(?<=\$\{{){name}\b|(?<=\$\{{[\w ] ){name}\b", scene.text):
            made = typo(name, draw)
            edit = Edit(found.start(), found.end(), made)
            yield Fault(f"`{made}` for `{name}` in an expression", (edit,), (found.start(),), _NAME)


def misspelt_name(scene: SceneText, draw: Random) -> Iterator[Fault]:
    """A parameter of a prefab, a link, a joint or a drive."""
    for entry in scene.entries:
        name, key = entry.path[-1], entry.path[-2] if len(entry.path) > 3 else None
        is_name = key in {"with", "links", "joints", "drives", "qpos", "near", "override"}
        if is_name and isinstance(name, str) and entry.key is not None and re.fullmatch(r"\w{3,}", name):
            made = typo(name, draw)
            yield _renamed(entry, f"`{made}` for `{name}` in `{key}`", made, _NAME)


def name_with_a_blank(scene: SceneText, draw: Random) -> Iterator[Fault]:
    for name, entry in _definitions(scene).items():
        new = draw.choice([f"{name} 1", f"{name}#2", f"1st_{name}", f"{name}/a"])
        yield _renamed(entry, f"the name `{new}`", new, _NAME)


KEY: Final = (misspelt_key, word_of_another_tool, word_of_another_tool, camel_case, wrong_number, level_up, level_down)
NAME: Final = (
    misspelt_reference,
    renamed_definition,
    misspelt_file,
    misspelt_prefab,
    misspelt_parameter,
    misspelt_name,
    name_with_a_blank,
)
