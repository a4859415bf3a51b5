"""Materials, files and variants that differ from scene to scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.structures import bodies_of, body_of
from unit.assets.test_assets import png
from unit.lower.scenes import BALL, codes, compiled, entity, scene

from scenecc import SceneError, ScenePlan, compile_scene, validate

OAK = {"physical": {"static_friction": 0.5, "dynamic_friction": 0.4, "density": 700}, "visual": {"roughness": 0.7}}
ICE = {"physical": {"static_friction": 0.1, "dynamic_friction": 0.05}}
NAMED = {"oak": OAK, "ice": ICE}
BOX: dict[str, Any] = {"type": "box", "half_size": [0.1, 0.2, 0.3]}
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"


def frictions(plan: ScenePlan) -> list[float]:
    """The static friction of the first shape, scene by scene."""
    value = body_of(entity(plan)).collisions[0].material
    rows = range(plan.num_scenes)
    assert value is not None
    return [plan.physical_materials[int(value.row(row))].row(row).static_friction for row in rows]


def test_a_material_by_scene() -> None:
    plan = compiled({"material": {"cycle": ["oak", "ice", OAK]}}, materials=NAMED, num_scenes=4)
    assert frictions(plan) == [0.5, 0.1, 0.5, 0.5]
    collides = body_of(entity(plan)).collisions[0]
    assert collides.density is not None
    assert collides.density.data.tolist() == [700, 1000, 700, 700]
    seen = body_of(entity(plan)).visuals[0].material
    assert seen is not None
    assert [plan.visual_materials[i].roughness is not None for i in seen.data] == [True, False, True, True]


def test_a_material_by_expression() -> None:
    draws = {"kind": {"choice": ["oak", "ice"]}}
    plan = compiled({"material": "${kind}"}, materials=NAMED, draws=draws, num_scenes=16)
    assert set(frictions(plan)) == {0.5, 0.1}
    again = compiled({"material": "${'oak' if kind == 'oak' else 'ice'}"}, materials=NAMED, draws=draws, num_scenes=16)
    assert frictions(plan) == frictions(again)


def test_the_colour_stands_on_every_alternative() -> None:
    plan = compiled(
        {"shapes": [{**BOX, "material": {"cycle": ["oak", "ice"]}, "color": "#ff0000"}]}, materials=NAMED, num_scenes=2
    )
    seen = body_of(entity(plan)).visuals[0].material
    assert seen is not None
    for row, index in enumerate(seen.data):
        base = plan.visual_materials[index].base_color
        assert base is not None
        assert base.row(row).tolist() == [1, 0, 0, 1]


def test_a_material_that_varies_follows_the_scenes_of_what_has_it() -> None:
    slick = {"physical": {"static_friction": {"uniform": [0.5, 1]}, "restitution": {"per_scene": [0.1, 0.2, 0.3, 0.4]}}}
    document = scene({"material": "slick"}, materials={"slick": slick}, num_scenes=4)
    document["entities"]["some"] = {"shapes": BALL, "material": "slick", "scene_idxs": [1, 3]}
    document["entities"]["same"] = {"shapes": BALL, "material": "slick"}
    plan = compile_scene(document)
    every, some, same = (body_of(entity(plan, name)).collisions[0].material for name in ("body", "some", "same"))
    assert every is not None
    assert some is not None
    assert same is every
    of_all, of_some = (plan.physical_materials[int(value.data[0])] for value in (every, some))
    assert of_some.static_friction.data.tolist() == of_all.static_friction.data[[1, 3]].tolist()
    assert of_some.restitution.data.tolist() == [0.2, 0.4]


@pytest.mark.parametrize(
    "given", [{"choice": ["oak", "tin"]}, {"per_scene": ["oak", "tin"]}, {"cycle": ["oak", {"choice": ["tin"]}]}]
)
def test_every_name_is_looked_up(given: Any) -> None:
    found = codes(scene({"material": given}, materials={"oak": OAK}, num_scenes=2))
    assert [code for code, _ in found] == ["SC301"]
    assert found[0][1].startswith("entities.body.material.")


def test_every_name_that_an_expression_can_give_is_looked_up() -> None:
    draws = {"kind": {"choice": ["oak", "tin"]}}
    assert codes(scene({"material": "${kind}"}, materials={"oak": OAK}, draws=draws)) == [
        ("SC301", "entities.body.material")
    ]


def test_an_expression_gives_names_that_do_not_exist() -> None:
    draws = {"x": {"uniform": [0, 1]}}
    assert codes(scene({"material": "oak_${x}"}, draws=draws)) == [("SC301", "entities.body.material")]
    assert codes(scene({"material": "${scene}"}, num_scenes=2)) == [("SC317", "entities.body.material")]


def meshed(file: Any, tmp_path: Path, **more: Any) -> Any:
    body = {"shapes": [{"type": "convex_mesh", "file": file}], **more}
    document = scene(body, num_scenes=4, draws={"kind": {"choice": ["a", "b"]}})
    document["x-note"] = ""
    document["entities"]["reader"] = {"shapes": BALL, "mass": "${1 if kind == 'a' else 2}"}
    return document


def test_every_file_is_found_and_read(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.obj").write_text(TRIANGLE)
    files = [
        {"cycle": ["asset://a.obj", "asset://b.obj"]},
        "asset://${kind}.obj",
        {"choice": ["asset://b.obj", "asset://a.obj"]},
    ]
    for file in files:
        plan = compile_scene(meshed(file, tmp_path), asset_roots=[tmp_path])
        assert {asset.uri for asset in plan.files} == {"asset://a.obj", "asset://b.obj"}
        geometry: Any = body_of(entity(plan)).collisions[0].geometry
        assert set(geometry.file.numbers()) == {0, 1}
    (tmp_path / "b.obj").write_text("")
    for file in files:
        found = validate(meshed(file, tmp_path), asset_roots=[tmp_path])
        assert [diagnostic.code for diagnostic in found] == ["SC413"], found
    (tmp_path / "b.obj").unlink()
    for file in files:
        found = validate(meshed(file, tmp_path), asset_roots=[tmp_path])
        assert [diagnostic.code for diagnostic in found] == ["SC401"], found


def test_a_texture_by_scene(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.png").write_bytes(png())

    def textured(texture: Any) -> dict[str, Any]:
        return scene({"material": {"visual": {"base_color_texture": texture}}}, num_scenes=2)

    a, b = "asset://a.png", "asset://b.png"
    for texture in (
        {"cycle": [a, b]},
        {"file": {"cycle": [a, b]}, "srgb": False},
        {"cycle": [{"file": a, "srgb": False}, {"file": {"choice": [b]}, "srgb": False}]},
    ):
        plan = compile_scene(textured(texture), asset_roots=[tmp_path])
        (material,) = plan.visual_materials
        assert material.base_color_texture is not None
        assert [plan.files[i].uri for i in material.base_color_texture.file.data] == [a, b]
        assert material.base_color_texture.srgb is (None if texture == {"cycle": [a, b]} else False)
    for texture in (
        {"cycle": [a, {"file": b, "srgb": False}]},
        {"choice": [{"file": a, "mipmap_levels": 2}, {"file": b}]},
    ):
        found = validate(textured(texture), asset_roots=[tmp_path])
        assert [diagnostic.code for diagnostic in found] == ["SC321"]


def test_a_mesh_has_its_own_materials_in_all_scenes_or_in_none(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(TRIANGLE)
    body = {"shapes": [{"type": "convex_mesh", "file": "asset://a.obj", "material": {"choice": ["oak", "ice"]}}]}
    found = validate(scene(body, materials=NAMED), asset_roots=[tmp_path])
    assert [diagnostic.code for diagnostic in found] == ["SC321"]


def bins(pick: Any, *variants: Any, **top: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": {"bin": {"pick": pick, "variants": list(variants), "mass": 2}}, **top}


def test_variants_are_structures_that_share_what_stands_beside_them() -> None:
    document = bins({"cycle": [0, 1]}, {"shapes": [BOX]}, {"shapes": BALL, "gravity": False}, num_scenes=3)
    document["entities"]["bin"]["visuals"] = [{"type": "sphere", "radius": 0.2}]
    bin_ = entity(compile_scene(document), "bin")
    assert bin_.pick is not None
    assert bin_.pick.data.tolist() == [0, 1, 0]
    first, second = bodies_of(bin_)
    assert [len(structure.visuals) for structure in (first, second)] == [2, 2]
    assert first.disable_gravity is None
    assert second.disable_gravity is not None
    assert [structure.mass.data.tolist() for structure in (first, second) if structure.mass] == [[2], [2]]


def test_a_draw_of_a_variant_has_its_own_path() -> None:
    ball = {"shapes": [{"type": "sphere", "radius": {"uniform": [0.1, 0.2]}}]}
    bin_ = entity(compile_scene(bins({"choice": [0, 1]}, ball, ball, num_scenes=4)), "bin")
    first, second = (np.asarray(body.collisions[0].geometry.radius.data) for body in bodies_of(bin_))  # type: ignore[union-attr]
    assert not set(first) & set(second)


@pytest.mark.parametrize(
    "pick", [{"cycle": [0, 1, 2]}, {"choice": [0, 2]}, {"integers": [0, 2]}, {"per_scene": [0, 2]}, 2]
)
def test_there_is_no_such_variant(pick: Any) -> None:
    document = bins(pick, {"shapes": [BOX]}, {"shapes": BALL}, num_scenes=2)
    assert [(d.code, d.path) for d in validate(document)] == [("SC320", "entities.bin.pick")]


def test_a_pick_by_expression_is_judged_as_it_is_drawn() -> None:
    draws = {"n": {"integers": [0, 5]}}
    document = bins("${n // 3}", {"shapes": [BOX]}, {"shapes": BALL}, num_scenes=8, draws=draws)
    assert validate(document) == []
    assert set(entity(compile_scene(document), "bin").pick.data.tolist()) == {0, 1}  # type: ignore[union-attr]
    document["entities"]["bin"]["pick"] = "${n // 2}"
    with pytest.raises(SceneError, match="SC513"):
        compile_scene(document)


def test_a_variant_that_no_scene_has_is_checked_all_the_same() -> None:
    document = bins(0, {"shapes": [BOX]}, {"visuals": [BOX]})
    assert [d.code for d in validate(document)] == ["SC502"]
    document = bins(0, {"shapes": [BOX]}, {"shapes": BALL, "material": "tin"})
    assert [d.path for d in validate(document)] == ["entities.bin.variants[1].material"]


def meshes(folder: Path, count: int) -> None:
    for number in range(count):
        (folder / f"m_{number}.obj").write_text(TRIANGLE)


@pytest.mark.parametrize(
    ("file", "draw"),
    [
        ("asset://m_${k}.obj", {"integers": [0, 79]}),
        ("asset://m_${k // 100}.obj", {"integers": [0, 7999]}),
        ("${k}", {"choice": [f"asset://m_{i}.obj" for i in range(80)]}),
        ("${k}", {"choice": [*(f"asset://m_{i}.obj" for i in range(80)), "none.obj"], "weights": [*[1] * 80, 0]}),
        ({"choice": ["asset://m_${k}.obj", "asset://m_0.obj"]}, {"integers": [0, 79]}),
        ("asset://m_${scene % 80}.obj", 0),
        ("asset://m_${k % 80}.obj", "${scene}"),
    ],
    ids=str,
)
def test_more_names_than_a_few(file: Any, draw: Any, tmp_path: Path) -> None:
    meshes(tmp_path, 80)
    document = scene({"shapes": [{"type": "convex_mesh", "file": file}]}, draws={"k": draw}, num_scenes=20_000)
    document["entities"]["reader"] = {"shapes": BALL, "mass": "${1 if k == k else 2}"}
    assert codes(document, asset_roots=[tmp_path]) == []
    document["num_scenes"] = 100
    plan = compile_scene(document, asset_roots=[tmp_path])
    assert 70 < len(plan.files) <= 80
    geometry: Any = body_of(entity(plan)).collisions[0].geometry
    assert len(set(geometry.file.data.tolist())) > 20


def test_names_are_those_of_the_scenes_that_the_entity_is_in(tmp_path: Path) -> None:
    meshes(tmp_path, 3)
    body = {"shapes": [{"type": "convex_mesh", "file": "asset://m_${scene - 7}.obj"}], "scene_idxs": [7, 8, 9]}
    assert codes(scene(body, num_scenes=10), asset_roots=[tmp_path]) == []


def test_a_name_without_a_value_in_a_scene() -> None:
    (found,) = validate(scene({"material": "${['oak'][scene]}"}, materials={"oak": OAK}, num_scenes=3))
    assert (found.code, found.message) == ("SC202", "in scene 1: index 1 is out of range: the list has 1 items")


def test_all_missing_files_of_one_expression_are_one_error() -> None:
    document = scene({"shapes": [{"type": "convex_mesh", "file": "none_${scene}.obj"}]}, num_scenes=200)
    (found,) = validate(document)
    assert (found.code, found.message) == ("SC401", "there is no file `none_0.obj` (and 199 others like it)")
    (found,) = validate(scene({"material": "oak_${scene}"}, num_scenes=2))
    assert (found.code, found.message) == ("SC301", "there is no material `oak_0` (and 1 other like it)")
