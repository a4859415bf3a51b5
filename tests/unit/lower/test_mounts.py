"""What names of bodies and links mean to what is mounted: the longest name, the root link, scopes, and guesses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from scenecc import compile_scene, validate
from scenecc.plan import Mount

BALL = [{"type": "sphere", "radius": 0.1}]


def arm(*links: str) -> dict[str, Any]:
    """A robot with a root called `base` and links on it."""
    joint = {"type": "fixed"}
    children = [{"name": link, "joint": {"name": f"to_{link}", **joint}, "shapes": BALL} for link in links]
    return {"root": {"name": "base", "shapes": BALL, "children": children}}


def mount_of(mount: str, entities: dict[str, Any], folder: Path | None = None, **top: Any) -> Mount | None:
    document: Any = {"scenecc": 1, "entities": entities, "cameras": {"eye": {"mount": mount}}, **top}
    if folder is not None:
        file = folder / "scene.yaml"
        file.write_text(yaml.safe_dump(document), encoding="utf-8")
        document = file
    (camera,) = compile_scene(document).cameras
    return camera.mount


def test_a_body_is_meant_by_its_name_and_a_robot_by_its_root() -> None:
    entities = {"ball": {"shapes": BALL}, "arm": arm("hand")}
    assert mount_of("ball", entities) == Mount("ball")
    assert mount_of("arm", entities) == Mount("arm", "base")
    assert mount_of("arm/hand", entities) == Mount("arm", "hand")


def test_the_longest_name_of_an_entity_is_meant(tmp_path: Path) -> None:
    """`pair/arm/hand` is a link of `pair/arm`, for there is no entity of the whole name; and then there is one."""
    (tmp_path / "pair.yaml").write_text(yaml.safe_dump({"scenecc": 1, "entities": {"arm": arm("hand")}}), "utf-8")
    entities: dict[str, Any] = {"pair": {"use": "pair.yaml"}}
    assert mount_of("pair/arm/hand", entities, tmp_path) == Mount("pair/arm", "hand")
    deeper = {"scenecc": 1, "entities": {"hand": {"shapes": BALL}}}
    (tmp_path / "deeper.yaml").write_text(yaml.safe_dump(deeper), "utf-8")
    entities["more"] = {"use": "deeper.yaml", "prefix": "pair/arm/"}
    assert mount_of("pair/arm/hand", entities, tmp_path) == Mount("pair/arm/hand")


def test_inside_a_prefab_names_mean_what_is_inside(tmp_path: Path) -> None:
    inner = {"scenecc": 1, "entities": {"ball": {"shapes": BALL}}, "cameras": {"eye": {"mount": "ball"}}}
    (tmp_path / "seen.yaml").write_text(yaml.safe_dump(inner), "utf-8")
    file = tmp_path / "scene.yaml"
    outer = {"scenecc": 1, "entities": {"ball": {"shapes": BALL}, "left": {"use": "seen.yaml"}}}
    file.write_text(yaml.safe_dump(outer), "utf-8")
    (camera,) = compile_scene(file).cameras
    assert (camera.name, camera.mount) == ("left/eye", Mount("left/ball"))


def robots_that_differ(folder: Path) -> dict[str, Any]:
    """An articulation that is one URDF in some scenes and another in others; both have `base` and `hand`."""
    for own in ("palm", "claw"):
        links = "".join(f'<link name="{name}"/>' for name in ("base", "hand", own))
        joints = "".join(
            f'<joint name="to_{name}" type="fixed"><parent link="base"/><child link="{name}"/></joint>'
            for name in ("hand", own)
        )
        (folder / f"{own}.urdf").write_text(f'<robot name="{own}">{links}{joints}</robot>', encoding="utf-8")
    return {"urdf": {"per_scene": ["palm.urdf", "claw.urdf"]}}


def test_a_link_of_robots_that_differ_is_in_all_of_them(tmp_path: Path) -> None:
    entities = {"either": robots_that_differ(tmp_path)}
    assert mount_of("either/hand", entities, tmp_path, num_scenes=2) == Mount("either", "hand")


@pytest.mark.parametrize(
    ("mount", "code", "words", "hint"),
    [
        ("bal", "SC330", "there is no entity `bal`", "did you mean `ball`?"),
        ("ball/hand", "SC331", "`ball` is a body and has no links", None),
        ("arm/hadn", "SC331", "no link of `arm` is called `hadn`", "did you mean `hand`?"),
        ("either/claw", "SC331", "not every robot of `either` has a link `claw`", "known here: base, hand"),
        ("some", "SC311", "`some` is not in scene 1, but this is", "write the `scene_idxs` of `some` here too"),
    ],
)
def test_a_mistake_is_told_at_the_name(mount: str, code: str, words: str, hint: str | None, tmp_path: Path) -> None:
    entities = {
        "ball": {"shapes": BALL},
        "arm": arm("hand"),
        "either": robots_that_differ(tmp_path),
        "some": {"scene_idxs": [0], "shapes": BALL},
    }
    head = yaml.safe_dump({"scenecc": 1, "num_scenes": 2, "entities": entities}, sort_keys=False)
    text = f"{head}cameras:\n  eye:\n    mount: {mount}\n"
    file = tmp_path / "scene.yaml"
    file.write_text(text, encoding="utf-8")
    found = [one for one in validate(file) if one.severity == "error"]
    assert [(one.code, one.path, one.line) for one in found] == [(code, "cameras.eye.mount", text.count("\n"))]
    assert found[0].message == words
    assert found[0].hint == hint


@pytest.mark.parametrize(
    ("written", "meant"),
    [("arm.hand", "arm/hand"), ("amr/hand", "arm/hand"), ("hand", "arm/hand"), ("bal", "ball")],
)
def test_a_name_of_no_entity_is_compared_with_links_too(written: str, meant: str) -> None:
    entities = {"ball": {"shapes": BALL}, "arm": arm("hand")}
    (found,) = validate({"scenecc": 1, "entities": entities, "cameras": {"eye": {"mount": written}}})
    assert (found.code, found.hint) == ("SC330", f"did you mean `{meant}`?")


def test_of_a_name_like_no_other_the_entities_are_listed() -> None:
    entities = {"ball": {"shapes": BALL}, "arm": arm("hand")}
    (found,) = validate({"scenecc": 1, "entities": entities, "cameras": {"eye": {"mount": "quux"}}})
    assert (found.code, found.hint) == ("SC330", "known here: ball, arm")


@pytest.mark.parametrize("name", ["ground", "ground/ground"])
def test_an_instance_that_holds_one_entity_means_that_entity(name: str) -> None:
    assert mount_of(name, {"ground": {"use": "scenecc:ground"}}) == Mount("ground/ground")
    cup = {"place": {"on": name, "at": [0, 0]}, "shapes": BALL}
    assert validate({"scenecc": 1, "entities": {"ground": {"use": "scenecc:ground"}, "cup": cup}}) == []


def test_of_an_instance_with_several_entities_they_are_listed(tmp_path: Path) -> None:
    part = tmp_path / "part.yaml"
    part.write_text("scenecc: 1\nentities:\n  a: &a {shapes: [{type: sphere, radius: 0.1}]}\n  b: *a\n")
    text = "scenecc: 1\nentities: {two: {use: part.yaml}}\ncameras: {eye: {mount: two}}\n"
    (tmp_path / "scene.yaml").write_text(text)
    found = [one for one in validate(tmp_path / "scene.yaml") if one.severity == "error"]
    assert [(one.code, one.hint) for one in found] == [("SC330", "known here: two/a, two/b")]
