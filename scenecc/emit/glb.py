"""Exports scenes to GLB: visual or collision geometry with materials, without physics.

The node tree is scene, entity, link, shape, below a root that turns z-up into y-up.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotation_arrays import pose_matrix
from scenecc.meshes.builder import MeshBuilder, build_scene_meshes, clip_to_scene, grid_cell
from scenecc.meshes.surface import convert_color_space, encode_png
from scenecc.names import UniqueNames

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet
    from io import BytesIO

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.emit import ExportOptions
    from scenecc.meshes import Image, Surface
    from scenecc.meshes.builder import BodyMeshes, GridCell, SceneMeshes
    from scenecc.meshes.surface import MeshPart, MeshShape, Suffix, SurfaceMaterial
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot


_UNSUPPORTED_SECTIONS: Final = {"lights": "light", "cameras": "camera"}


def report_unsupported_sections(plan: ScenePlan, scenes: AbstractSet[int], sink: Sink) -> None:
    """Warns of lights, cameras and the environment of the written scenes."""
    for section, word in _UNSUPPORTED_SECTIONS.items():
        for item in getattr(plan, section):
            if scenes & set(item.scene_idxs):
                sink.report("SC745", f"the {word} `{item.name}` is left out", item.origin or Location(None))
    around = plan.environment
    if around is not None:
        sink.report("SC745", "`environment` is left out", around.origin or Location(None))


def report_unsupported_material(look: SurfaceMaterial, origin: Origin | None, sink: Sink) -> None:
    """Warns of material properties that glTF does not support. `origin`: of the first shape with the material."""
    place = origin or Location(None)
    if look.transmission_image is not None:
        sink.report("SC745", f"`transmission_texture` ({look.transmission_image.name}) is left out", place)
    if look.transmission > 0 and look.transmission_roughness != look.roughness:
        sink.report("SC745", "`transmission_roughness` is left out: glTF uses `roughness`", place)
    rough, metal = look.roughness_image, look.metallic_image
    if rough is not None and metal is not None and _sampler_modes(rough) != _sampler_modes(metal):
        message = (
            f"`metallic_texture` ({metal.name}) uses the sampler of `roughness_texture`: glTF stores both in one image"
        )
        sink.report("SC745", message, place)
        metal = None
    for image in (look.base_color_image, look.normal_image, rough, metal, look.emission_image):
        if image is not None and image.address_mode == "border":
            sink.report("SC745", f"`address_mode: border` of {image.name} is written as `edge`", place)


def _sampler_modes(image: Image) -> tuple[str, str]:
    return image.filter_mode, image.address_mode


_FILTERS: Final = {"nearest": 9728, "linear": 9729}

_WRAPS: Final = {"repeat": 10497, "edge": 33071, "mirror": 33648, "border": 33071}

_SLOTS: Final = {
    "baseColorTexture": "base_color_image",
    "normalTexture": "normal_image",
    "metallicRoughnessTexture": "roughness_image",
    "emissiveTexture": "emission_image",
}

_SAPIEN_SPECULAR: Final = 2.0
"""glTF's default reflectance of 0.04 equals SAPIEN's at `specular` 0.5."""


class _EncodedImage:
    """An encoded image, with the interface that trimesh uses to save a Pillow image."""

    def __init__(self, data: bytes, suffix: Suffix) -> None:
        self.format = "JPEG" if suffix == ".jpg" else "PNG"
        self._data = data

    def save(self, file: BytesIO, **options: str) -> None:
        """Writes the image, always in its own format."""
        del options
        file.write(self._data)


def _encode_image(image: Image) -> _EncodedImage:
    return _EncodedImage(image.data, image.suffix)


class GltfMaterials:
    """The materials of a file, in order of first use."""

    def __init__(self) -> None:
        self._names: dict[SurfaceMaterial, str] = {}

    @property
    def looks(self) -> AbstractSet[SurfaceMaterial]:
        """All materials used so far."""
        return self._names.keys()

    def material(self, look: SurfaceMaterial) -> Any:
        """Returns the trimesh material of a `SurfaceMaterial`."""
        name = self._names.setdefault(look, f"material {len(self._names)}")
        images = {
            "baseColorTexture": (look.base_color_image, True),
            "normalTexture": (look.normal_image, False),
            "emissiveTexture": (look.emission_image, True),
        }
        given: dict[str, Any] = {
            slot: _encode_image(convert_color_space(image, srgb=srgb))
            for slot, (image, srgb) in images.items()
            if image is not None
        }
        packed = _metallic_roughness_image(look)
        if packed is not None:
            given["metallicRoughnessTexture"] = packed
        return import_module("trimesh.visual.material").PBRMaterial(name=name, **given)

    def finish(self, tree: dict[str, Any]) -> None:
        """Sets the factors of all materials and the samplers of their images in the JSON of a file."""
        found = {material["name"]: material for material in tree.get("materials", [])}
        samplers: list[dict[str, int]] = []
        used: set[str] = set()
        for look, name in self._names.items():
            material = found[name]
            material.pop("baseColorFactor", None)
            material["pbrMetallicRoughness"] = {**material.get("pbrMetallicRoughness", {}), **_material_factors(look)}
            material.update(_emissive_factor(look))
            if _is_transparent(look):
                material["alphaMode"] = "BLEND"
            extensions = _extensions(look)
            material["extensions"] = extensions
            used.update(extensions)
            _set_samplers(look, material, tree, samplers)
        if samplers:
            tree["samplers"] = samplers
        tree["extensionsUsed"] = sorted({*tree.get("extensionsUsed", []), *used})


def _material_factors(look: SurfaceMaterial) -> dict[str, Any]:
    """Returns factors without those that an image replaces, because glTF multiplies factor and image."""
    packed = look.roughness_image is not None or look.metallic_image is not None
    return {
        "baseColorFactor": list(look.tint),
        "roughnessFactor": 1.0 if packed else look.roughness,
        "metallicFactor": 1.0 if packed else look.metallic,
    }


def _emissive_factor(look: SurfaceMaterial) -> dict[str, Any]:
    """Returns the emissive factor, at most 1. An extension stores the strength of brighter emission."""
    strength = max(1.0, *look.emission)
    return {"emissiveFactor": [value / strength for value in look.emission]}


def _extensions(look: SurfaceMaterial) -> dict[str, Any]:
    bright = _SAPIEN_SPECULAR * look.specular
    specular: dict[str, Any] = {"specularFactor": min(bright, 1.0)}
    if bright > 1:
        specular["specularColorFactor"] = [bright] * 3
    found: dict[str, Any] = {"KHR_materials_specular": specular}
    strength = max(look.emission)
    if strength > 1:
        found["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    if look.transmission > 0:
        found["KHR_materials_transmission"] = {"transmissionFactor": min(look.transmission, 1.0)}
        found["KHR_materials_ior"] = {"ior": look.ior}
    return found


def _is_transparent(look: SurfaceMaterial) -> bool:
    image = look.base_color_image
    return look.tint[3] < 1 or (image is not None and image.pixels.mode in {"RGBA", "LA", "PA"})


def _set_samplers(
    look: SurfaceMaterial, material: dict[str, Any], tree: dict[str, Any], samplers: list[dict[str, int]]
) -> None:
    for slot, field in _SLOTS.items():
        holder = material if slot in material else material["pbrMetallicRoughness"]
        image: Image | None = getattr(look, field)
        if field == "roughness_image":
            image = image or look.metallic_image
        if image is None or slot not in holder:
            continue
        wrap = _WRAPS[image.address_mode]
        sampler = {"magFilter": _FILTERS[image.filter_mode], "wrapS": wrap, "wrapT": wrap}
        if image.filter_mode == "nearest":
            sampler["minFilter"] = _FILTERS["nearest"]
        if sampler not in samplers:
            samplers.append(sampler)
        tree["textures"][holder[slot]["index"]]["sampler"] = samplers.index(sampler)


def _metallic_roughness_image(look: SurfaceMaterial) -> Any:
    """Returns one image with roughness in green and metallic in blue, for glTF, or None if neither has an image."""
    images = look.roughness_image, look.metallic_image
    rough, metal = (None if image is None else convert_color_space(image, srgb=False) for image in images)
    if rough is None and metal is None:
        return None
    if (
        rough is not None
        and metal is not None
        and rough.digest == metal.digest
        and rough.channel + metal.channel == "gb"
    ):
        return _encode_image(rough)
    pillow: Any = import_module("PIL.Image")

    sizes = [image.pixels.size for image in (rough, metal) if image is not None]
    size = (max(width for width, _ in sizes), max(height for _, height in sizes))
    green, blue = (
        _uniform_image(number, size) if image is None else _channel_image(image).resize(size)
        for image, number in ((rough, look.roughness), (metal, look.metallic))
    )
    return _EncodedImage(encode_png(pillow.merge("RGB", (_uniform_image(1.0, size), green, blue))), ".png")


def _uniform_image(number: float, size: tuple[int, int]) -> Any:
    return import_module("PIL.Image").new("L", size, round(min(max(number, 0.0), 1.0) * 255))


def _channel_image(image: Image) -> Any:
    return image.pixels.convert("RGB").getchannel("RGB"["rgb".index(image.channel)])


def build_trimesh(part: MeshPart, materials: GltfMaterials, *, turned: bool) -> Any:
    """Returns the trimesh mesh of a part. `turned`: its triangles face the other side."""
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals

    surface = part.surface
    # trimesh counts v from the bottom of an image.
    uv = np.zeros((len(surface.vertices), 2)) if surface.uvs is None else surface.uvs * (1, -1) + (0, 1)
    sign = -1 if turned else 1
    return Trimesh(
        vertices=surface.vertices,
        faces=surface.faces[:, ::-1] if turned else surface.faces,
        vertex_normals=None if surface.normals is None else surface.normals * sign,
        visual=TextureVisuals(uv=uv, material=materials.material(part.look)),
        process=False,
        validate=False,
    )


def part_to_glb(part: MeshPart, *, turned: bool) -> bytes:
    """Returns one part as a GLB file, in the frame of its shape and unscaled, without rotating z to y up."""
    import trimesh

    scene: Any = trimesh.Scene()
    materials = GltfMaterials()
    scene.geometry["part"] = build_trimesh(part, materials, turned=turned)
    scene.graph.update(frame_to="node", frame_from=scene.graph.base_frame, matrix=np.eye(4), geometry="part")
    gltf: Any = import_module("trimesh.exchange.gltf")
    return bytes(gltf.export_glb(scene, tree_postprocessor=materials.finish))


_Y_UP: Final = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""From z up to glTF's y up: a rotation by -90° about x."""


def write(plan: ScenePlan, measured: EngineSnapshot, options: ExportOptions, sink: Sink) -> dict[str, bytes] | None:
    """Returns the file, or None after an error, which is reported to `sink`."""
    mesh_builder = MeshBuilder(plan, lambda problem, origin: problem.report(sink, origin), options.max_triangles)
    try:
        drawn = tuple(build_scene_meshes(mesh_builder, scene, options.show) for scene in measured.scenes)
    except AssetError as problem:
        problem.report(sink, mesh_builder.at)
        return None
    report_unsupported_sections(plan, {scene.index for scene in measured.scenes}, sink)
    writer = _GlbWriter(options.name, sink)
    writer.add(drawn, grid_cell(drawn) if options.grid else None)
    return {f"{options.name}.glb": writer.file()}


class _GlbWriter:
    """Fills a trimesh scene. Equal surfaces and materials are written once."""

    def __init__(self, name: str, sink: Sink) -> None:
        import trimesh

        self._scene: Any = trimesh.Scene()
        self._materials = GltfMaterials()
        self._sink = sink
        self._names = UniqueNames(str(self._scene.graph.base_frame), separator=" ")
        self._meshes: dict[tuple[Surface, SurfaceMaterial, bool], str] = {}
        self._root = self._node(name, None, _Y_UP)

    def add(self, scenes: tuple[SceneMeshes, ...], cell: GridCell | None) -> None:
        """Adds scenes, side by side if there is a grid cell."""
        if cell is None:
            for scene in scenes:
                self._add_scene(scene, self._root, "", None)
            return
        for scene, origin in zip(scenes, cell.origins(len(scenes)), strict=True):
            place = np.eye(4)
            place[:3, 3] = origin
            name = f"scene {scene.scene.index}"
            self._add_scene(scene, self._node(name, self._root, place), f"{name}/", cell.half)

    def file(self) -> bytes:
        """Returns the bytes of the file."""
        # `Scene.export` rejects a scene without geometry.
        gltf: Any = import_module("trimesh.exchange.gltf")
        return bytes(gltf.export_glb(self._scene, tree_postprocessor=self._materials.finish))

    def _add_scene(self, scene: SceneMeshes, above: str, prefix: str, half: float | None) -> None:
        for entity in scene.entities:
            root = entity.bodies[0]
            node = self._node(prefix + entity.measured.entity.name, above, root.place)
            nodes: list[str] = []
            for body in entity.bodies:
                parent = body.body.parent
                if parent is None:
                    is_single = len(entity.bodies) == 1 and body.body.name == entity.measured.entity.name
                    nodes.append(node if is_single else self._node(f"{node}/{body.body.name}", node, np.eye(4)))
                else:
                    place = np.linalg.inv(entity.bodies[parent].place) @ body.place
                    nodes.append(self._node(f"{node}/{body.body.name}", nodes[parent], place))
                for shape in body.shapes:
                    self._add_shape(self._clip_plane(shape, body, scene, half), nodes[-1])

    def _clip_plane(self, shape: MeshShape, body: BodyMeshes, scene: SceneMeshes, half: float | None) -> MeshShape:
        """Returns the shape; a plane is clipped to the space of its scene."""
        clipped = clip_to_scene(shape, body, scene, half)
        if clipped.scale != shape.scale:
            word = "infinite plane" if shape.endless else "plane"
            _, y, z = clipped.scale
            message = f"this {word} is written as {2 * y:.3g} m by {2 * z:.3g} m"
            self._sink.report("SC746", message, shape.origin or Location(None))
        return clipped

    def _add_shape(self, shape: MeshShape, above: str) -> None:
        place = pose_matrix(shape.pose) @ np.diag([*shape.scale, 1.0])
        name = f"{above}/{shape.name or shape.kind}"
        if len(shape.parts) == 1:
            self._node(name, above, place, self._mesh(shape, 0))
            return
        node = self._node(name, above, place)
        for number in range(len(shape.parts)):
            self._node(f"{node}/{number}", node, np.eye(4), self._mesh(shape, number))

    def _mesh(self, shape: MeshShape, number: int) -> str:
        """Returns the name of a part's mesh; equal parts share one."""
        part = shape.parts[number]
        key = (part.surface, part.look, shape.turned)
        if key not in self._meshes:
            if part.look not in self._materials.looks:
                report_unsupported_material(part.look, shape.origin, self._sink)
            self._meshes[key] = f"mesh {len(self._meshes)}"
            self._scene.geometry[self._meshes[key]] = build_trimesh(part, self._materials, turned=shape.turned)
        return self._meshes[key]

    def _node(self, name: str, above: str | None, place: NDArray[np.float64], mesh: str | None = None) -> str:
        """Adds a node and returns its unique name."""
        unique = self._names.new(name)
        graph = self._scene.graph
        shown = {} if mesh is None else {"geometry": mesh}
        graph.update(frame_to=unique, frame_from=above or graph.base_frame, matrix=place, **shown)
        return unique
