"""Fields of what is seen: visual materials, images, render bodies, lights, cameras and surroundings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fidelity.setter_rows import Changes, Hooks, Row, RowKey, Setting

from scenecc.plan import BodyStructure, Box, Entity, Mount, Physics, ScenePlan, VisualShape, constant
from scenecc.plan.body import AssetFile, Texture, VisualMaterial
from scenecc.plan.rendering import (
    AreaLight,
    Camera,
    DirectionalLight,
    Environment,
    Intrinsic,
    Light,
    Orthographic,
    Perspective,
    Shadow,
    SpotLight,
    TexturedLight,
)

ASSETS = Path(__file__).parents[2] / "scenes" / "assets"
IMAGES = (ASSETS / "checker.png", ASSETS / "bumps.png")
HALF_SIZE = [0.1, 0.06, 0.03]
WIDTH, HEIGHT = 16, 12
COLOR = [0.1, 0.7, 3.0]
NEAR, FAR = 0.02, 40.0
MATRIX = {"fx": 11.0, "fy": 12.0, "cx": 8.0, "cy": 6.0, "skew": 0.0}
INNER, OUTER = 0.4, 0.7
TOP = 1.1
BUMPS = Texture(constant(1, np.int64))


def plan(changes: Changes) -> ScenePlan:
    """A box that is seen, a light and a camera, of which some fields are replaced."""
    material: Any = {**changes.get(VisualMaterial, {})}
    if Texture in changes:
        texture: Any = {"file": constant(0, np.int64), **changes[Texture]}
        material = {"base_color_texture": Texture(**texture)}
    shape: Any = {
        "geometry": Box(constant(HALF_SIZE)),
        "material": constant(0, np.int64),
        **changes.get(VisualShape, {}),
    }
    body: Any = {**changes.get(BodyStructure, {})}
    box = BodyStructure("none", visuals=(VisualShape(**shape),), **body)
    around: Any = {**changes.get(Environment, {})}
    return ScenePlan(
        "row",
        1,
        (Entity("body", (0,), constant([0, 0, 0, 1, 0, 0, 0]), (box,)),),
        Physics(),
        files=tuple(AssetFile(path.name, path) for path in IMAGES),
        visual_materials=(VisualMaterial(**material), VisualMaterial(base_color=constant([0.1, 0.2, 0.3, 1]))),
        environment=Environment(**around) if Environment in changes else None,
        lights=(_light(changes),),
        cameras=(_camera(changes),),
    )


def _light(changes: Changes) -> Light:
    cone: Any = {"inner_fov": constant(INNER), "outer_fov": constant(OUTER)}
    kind: Any = DirectionalLight()
    if SpotLight in changes:
        kind = SpotLight(**{**cone, **changes[SpotLight]})
    if AreaLight in changes:
        edges: Any = {"half_width": constant(0.3), "half_height": constant(0.2)}
        kind = AreaLight(**{**edges, **changes[AreaLight]})
    if TexturedLight in changes:
        kind = TexturedLight(**{**cone, "texture": Texture(constant(0, np.int64)), **changes[TexturedLight]})
    shadow: Any = {"on": constant(1, np.bool_), **changes.get(Shadow, {})}
    given: Any = {"pose": constant([0, 0, 2, 1, 0, 0, 0]), "color": constant(COLOR), **changes.get(Light, {})}
    return Light("lamp", (0,), kind, shadow=Shadow(**shadow) if Shadow in changes else None, **given)


def _camera(changes: Changes) -> Camera:
    lens: Any = Perspective(fovy=constant(0.9))
    if Perspective in changes:
        lens = Perspective(**changes[Perspective])
    if Intrinsic in changes:
        lens = Intrinsic(**{**{name: constant(number) for name, number in MATRIX.items()}, **changes[Intrinsic]})
    if Orthographic in changes:
        lens = Orthographic(**changes[Orthographic])
    given: Any = {
        "pose": constant([-1, 0, 0, 1, 0, 0, 0]),
        "near": constant(NEAR),
        "far": constant(FAR),
        "width": WIDTH,
        "height": HEIGHT,
        **changes.get(Camera, {}),
    }
    return Camera("eye", (0,), lens=lens, **given)


def by_hand(hooks: Hooks) -> Any:
    """The same with SAPIEN's components."""
    import sapien
    from sapien import physx, render

    scene: Any = sapien.Scene([physx.PhysxCpuSystem(), render.RenderSystem()])
    material: Any = render.RenderMaterial()
    if Texture in hooks:
        material.base_color_texture = hooks[Texture](None) or render.RenderTexture2D(str(IMAGES[0]))
    shape: Any = render.RenderShapeBox(HALF_SIZE, material)
    if VisualShape in hooks:
        hooks[VisualShape](shape)
    look: Any = render.RenderBodyComponent()
    look.attach(shape)
    look.name = "body"
    _entity(scene, "body", [0, 0, 0], look)

    kinds = {SpotLight: "Spot", AreaLight: "Parallelogram", TexturedLight: "Textured"}
    kind = next((name for cls, name in kinds.items() if cls in hooks), "Directional")
    light: Any = getattr(render, f"Render{kind}LightComponent")()
    light.color = COLOR
    if kind in {"Spot", "Textured"}:
        light.inner_fov, light.outer_fov = INNER, OUTER
    if kind == "Textured":
        light.texture = render.RenderTexture2D(str(IMAGES[0]))
    if kind == "Parallelogram":
        light.set_shape(0.3, 0.2)
    _shadows(light, kind, on=Shadow in hooks)
    light.name = "lamp"
    _entity(scene, "lamp", [0, 0, 2], light)

    camera: Any = render.RenderCameraComponent(WIDTH, HEIGHT)
    if Orthographic in hooks:
        _orthographic(camera, TOP)
    else:
        camera.set_fovy(0.9, True)
        camera.near, camera.far = NEAR, FAR
    if Intrinsic in hooks:
        camera.set_perspective_parameters(NEAR, FAR, *MATRIX.values())
    camera.name = "eye"
    _entity(scene, "eye", [-1, 0, 0], camera)
    for cls, change in hooks.items():
        if cls not in {Texture, VisualShape}:
            change(find(scene, cls))
    return scene


def _shadows(light: Any, kind: str, *, on: bool) -> None:
    """SAPIEN's numbers of a shadow, as its `Scene.add_…_light` sets them."""
    if kind == "Parallelogram":
        return
    light.shadow = on
    light.shadow_near, light.shadow_far = (-10.0 if kind == "Directional" else 0.1), 10.0
    if kind == "Directional":
        light.shadow_half_size = 10.0
    light.shadow_map_size = 2048


def _entity(scene: Any, name: str, at: list[float], *components: Any) -> None:
    import sapien

    entity: Any = sapien.Entity()
    for component in components:
        entity.add_component(component)
    entity.name = name
    entity.pose = sapien.Pose(at)
    scene.add_entity(entity)


def find(scene: Any, cls: type) -> Any:
    """The object of a dataclass in a live scene."""
    body, lamp, eye = scene.entities
    shape = body.components[0].render_shapes[0]
    if cls is Environment:
        return scene.render_system
    if cls is VisualMaterial:
        return shape.parts[0].material
    if cls is BodyStructure:
        return body.components[0]
    return (lamp if cls in {Light, Shadow, SpotLight, AreaLight, TexturedLight} else eye).components[0]


def _pose(numbers: list[float]) -> Any:
    import sapien

    return sapien.Pose(numbers[:3], numbers[3:])


def _other_material(shape: Any, _number: int) -> None:
    shape.parts[0].material.base_color = [0.1, 0.2, 0.3, 1]


def _move(component: Any, numbers: list[float]) -> None:
    component.get_entity().set_pose(_pose(numbers))


def _image(number: int) -> Any:
    from sapien import render

    return render.RenderTexture2D(str(IMAGES[number]))


def _sampled(**sampling: Any) -> Any:
    from sapien import render

    return render.RenderTexture2D(str(IMAGES[0]), **sampling)


def _orthographic(camera: Any, top: float, near: float = NEAR, far: float = FAR) -> None:
    right = top * WIDTH / HEIGHT
    camera.set_orthographic_parameters(near, far, -right, right, -top, top)


_MATERIAL: dict[str, Row] = {
    "base_color": Row([0.2, 0.4, 0.6, 0.8], lambda material, rgba: material.set_base_color(rgba), [1.0, 0.5, 0.1, 1.0]),
    "emission": Row([0.3, 0.1, 0.7, 1.0], lambda material, rgba: material.set_emission(rgba), [0.1, 0.5, 0.1, 1.0]),
    "specular": Row(0.13, lambda material, number: material.set_specular(number), 0.9),
    "roughness": Row(0.27, lambda material, number: material.set_roughness(number), 0.8),
    "metallic": Row(0.39, lambda material, number: material.set_metallic(number), 0.7),
    "transmission": Row(0.45, lambda material, number: material.set_transmission(number)),
    "ior": Row(1.8, lambda material, number: material.set_ior(number)),
    "transmission_roughness": Row(0.56, lambda material, number: material.set_transmission_roughness(number), 0.6),
    "base_color_texture": Row(BUMPS, lambda material, _: material.set_base_color_texture(_image(1)), dtype=None),
    "normal_texture": Row(BUMPS, lambda material, _: material.set_normal_texture(_image(1)), dtype=None),
    "roughness_texture": Row(BUMPS, lambda material, _: material.set_roughness_texture(_image(1)), dtype=None),
    "metallic_texture": Row(BUMPS, lambda material, _: material.set_metallic_texture(_image(1)), dtype=None),
    "emission_texture": Row(BUMPS, lambda material, _: material.set_emission_texture(_image(1)), dtype=None),
    "transmission_texture": Row(BUMPS, lambda material, _: material.set_transmission_texture(_image(1)), dtype=None),
}

_TEXTURE: dict[str, Row] = {
    "file": Row(1, lambda _, number: _image(number), dtype=np.int64),
    "mipmap_levels": Row(3, lambda _, levels: _sampled(mipmap_levels=levels), dtype=None),
    "filter_mode": Row("nearest", lambda _, mode: _sampled(filter_mode=mode), dtype=None),
    "address_mode": Row("border", lambda _, mode: _sampled(address_mode=mode), dtype=None),
    "srgb": Row(False, lambda _, srgb: _sampled(srgb=srgb), dtype=None),
}

_SHAPE: dict[str, Row] = {
    "pose": Row([0.02, 0.01, 0.0, 0.6, 0.8, 0.0, 0.0], lambda shape, pose: shape.set_local_pose(_pose(pose))),
    "material": Row(1, _other_material, None, np.int64),
    "name": Row("lid", lambda shape, name: shape.set_name(name), dtype=None),
    "front_face": Row("clockwise", lambda shape, face: shape.set_front_face(face), dtype=None),
}

_LOOK: dict[str, Row] = {
    "visibility": Row(0.25, lambda look, number: setattr(look, "visibility", number)),
    "shading_mode": Row(1, lambda look, number: setattr(look, "shading_mode", number), None, np.int64),
}

_LIGHT: dict[str, Row] = {
    "pose": Row([0.5, 0.1, 1.0, 0.6, 0.8, 0.0, 0.0], _move, [0.5, 0.1, 1.5, 1.0, 0.0, 0.0, 0.0]),
    "color": Row([0.4, 1.5, 0.2], lambda light, color: light.set_color(color), [1.0, 2.0, 3.0]),
}

_SHADOW: dict[str, Row] = {
    "on": Row(False, lambda light, on: setattr(light, "shadow", on), None, np.bool_),
    "near": Row(-3.0, lambda light, near: setattr(light, "shadow_near", near)),
    "far": Row(7.0, lambda light, far: setattr(light, "shadow_far", far)),
    "half_size": Row(4.0, lambda light, half_size: setattr(light, "shadow_half_size", half_size)),
    "map_size": Row(512, lambda light, size: setattr(light, "shadow_map_size", size), None, np.int64),
}

_LENS: dict[str, Row] = {
    "pose": Row([-2.0, 0.1, 1.0, 0.6, 0.8, 0.0, 0.0], _move, [-3.0, 0.1, 1.5, 1.0, 0.0, 0.0, 0.0]),
    "near": Row(0.11, lambda camera, near: setattr(camera, "near", near), 0.3),
    "far": Row(23.0, lambda camera, far: setattr(camera, "far", far), 30.0),
}

ROWS: dict[RowKey, Row] = {
    (cls, field): row
    for cls, rows in (
        (VisualMaterial, _MATERIAL),
        (Texture, _TEXTURE),
        (VisualShape, _SHAPE),
        (BodyStructure, _LOOK),
        (Light, _LIGHT),
        (Shadow, _SHADOW),
        (Camera, _LENS),
    )
    for field, row in rows.items()
} | {
    **{
        (SpotLight, name): Row(0.55, lambda light, fov, name=name: setattr(light, name, fov))
        for name in ("inner_fov", "outer_fov")
    },
    **{
        (TexturedLight, name): Row(0.55, lambda light, fov, name=name: setattr(light, name, fov))
        for name in ("inner_fov", "outer_fov")
    },
    (AreaLight, "half_width"): Row(0.7, lambda light, width: light.set_shape(width, 0.2)),
    (AreaLight, "half_height"): Row(0.7, lambda light, height: light.set_shape(0.3, height)),
    (Environment, "ambient_light"): Row(
        [0.2, 0.3, 0.5], lambda system, color: setattr(system, "ambient_light", color), [0.1, 0.1, 0.1]
    ),
    (Perspective, "fovx"): Row(1.3, lambda camera, angle: camera.set_fovx(angle, True), 0.8),
    (Perspective, "fovy"): Row(0.6, lambda camera, angle: camera.set_fovy(angle, True), 0.8),
    (Intrinsic, "fx"): Row(17.0, lambda camera, fx: camera.set_focal_lengths(fx, MATRIX["fy"]), 14.0),
    (Intrinsic, "fy"): Row(18.0, lambda camera, fy: camera.set_focal_lengths(MATRIX["fx"], fy), 15.0),
    (Intrinsic, "cx"): Row(6.5, lambda camera, cx: camera.set_principal_point(cx, MATRIX["cy"]), 9.0),
    (Intrinsic, "cy"): Row(5.5, lambda camera, cy: camera.set_principal_point(MATRIX["cx"], cy), 7.0),
    (Intrinsic, "skew"): Row(0.7, lambda camera, skew: setattr(camera, "skew", skew), 0.1),
    (Orthographic, "top"): Row(0.8, _orthographic, 1.5),
}

LOOKS = Setting(plan, by_hand, find, ROWS, rendered=True)


def _mounted_plan(changes: Changes) -> ScenePlan:
    """With the light and the camera on the box."""
    given = plan(changes)
    mount = Mount("body")
    lights, cameras = ((replace(one, mount=mount) for one in held) for held in (given.lights, given.cameras))
    return replace(given, lights=tuple(lights), cameras=tuple(cameras))


def _mounted_by_hand(hooks: Hooks) -> Any:
    scene = by_hand({})
    body, *others = scene.entities
    for entity in others:
        (component,) = entity.components
        scene.remove_entity(entity)
        entity.remove_component(component)
        body.add_component(component)
        component.local_pose = entity.pose
    for cls, change in hooks.items():
        change(_find_mounted(scene, cls))
    return scene


def _find_mounted(scene: Any, cls: type) -> Any:
    return scene.entities[0].components[1 if cls is Light else 2]


def _move_mounted(component: Any, numbers: list[float]) -> None:
    component.set_local_pose(_pose(numbers))


MOUNTED = Setting(
    _mounted_plan,
    _mounted_by_hand,
    _find_mounted,
    {
        (Light, "pose"): replace(_LIGHT["pose"], by_hand=_move_mounted),
        (Camera, "pose"): replace(_LENS["pose"], by_hand=_move_mounted),
    },
    rendered=True,
)


def _flat_plan(changes: Changes) -> ScenePlan:
    """With a camera without perspective, of which a row says near or far."""
    return plan({Orthographic: {"top": constant(TOP)}, **changes})


def _flat_by_hand(hooks: Hooks) -> Any:
    scene = by_hand({Orthographic: lambda camera: _orthographic(camera, TOP)})
    for change in hooks.values():
        change(find(scene, Camera))
    return scene


FLAT = Setting(
    _flat_plan,
    _flat_by_hand,
    find,
    {
        (Camera, "near"): replace(_LENS["near"], by_hand=lambda camera, near: _orthographic(camera, TOP, near=near)),
        (Camera, "far"): replace(_LENS["far"], by_hand=lambda camera, far: _orthographic(camera, TOP, far=far)),
    },
    rendered=True,
)
