"""Meshes, materials and textures of an MJCF, as its geoms use them. What no geom uses is not looked at."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.robots.description import Look, MeshGeometry
from scenecc.robots.mjcf.classes import Scope
from scenecc.robots.mjcf.rotations import NO_TURN
from scenecc.robots.reading import SMALLEST

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.robots.description import NamedFile
    from scenecc.robots.mjcf.attributes import Attributes
    from scenecc.robots.mjcf.classes import Classes
    from scenecc.robots.mjcf.compiler import Compiler
    from scenecc.robots.mjcf.files import Files
    from scenecc.robots.mjcf.report import Report
    from scenecc.robots.xml import Element

READ: dict[str, frozenset[str]] = {
    "mesh": frozenset({"name", "file", "scale", "refpos", "refquat"}),
    "material": frozenset({"name", "texture", "rgba", "emission", "specular", "shininess", "reflectance"}),
    "texture": frozenset({"name", "file", "type"}),
}
"""The attributes that are heeded, of each kind of asset that is."""

_GLOBAL = Scope()


@dataclass(slots=True)
class Assets:
    """The assets of a file."""

    compiler: Compiler
    classes: Classes
    files: Files
    report: Report
    _found: dict[tuple[str, str], Element] = field(default_factory=dict[tuple[str, str], "Element"])
    _looks: dict[tuple[str, tuple[float, ...] | None], Look | None] = field(
        default_factory=dict[tuple[str, "tuple[float, ...] | None"], "Look | None"]
    )

    def read(self, sections: Iterable[Element]) -> None:
        """Takes the assets of the sections `asset`, each by its name, or its file's where it has none."""
        for section in sections:
            for element in section.children:
                if element.tag not in READ:
                    self.report.unread_element(element)
                    continue
                name, file = element.attributes.get("name"), element.attributes.get("file")
                if name is None and file is not None:
                    name = posixpath.splitext(posixpath.basename(file))[0]
                if name is None:
                    # A skybox need have no name, and what has none is used by nothing.
                    self.report.unread_attributes(element, READ[element.tag] | {"class"})
                    continue
                first = self._found.setdefault((element.tag, name), element)
                if first is not element:
                    self.report.error("SC486", f"the {element.tag} `{cut(name)}` is defined twice", element.at("name"))

    def tell_unread(self) -> None:
        """Tells the attributes that are left out, of assets that nothing uses, too."""
        for (tag, _), element in self._found.items():
            self.report.unread_attributes(element, READ[tag] | {"class"})
            for child in element.children:
                self.report.unread_element(child)

    def mesh(self, geom: Attributes) -> MeshGeometry | None:
        """The mesh of a geom; None, reported, where it has none that can be used."""
        element = self._named("mesh", geom.text("mesh"), geom, "mesh")
        if element is None:
            return None
        given = self.classes.attributes(element, _GLOBAL, READ["mesh"])
        scale = given.singles("scale", (1.0, 1.0, 1.0))
        if min(map(abs, scale)) < SMALLEST:
            given.wrong("scale", "holds 0, which leaves nothing of the mesh")
            return None
        if any(given.numbers("refpos", (0.0, 0.0, 0.0))) or self._is_turned(given):
            self.report.error(
                "SC483",
                "a mesh that is moved or turned by `refpos` and `refquat` is not built",
                given.at("refpos" if "refpos" in given else "refquat"),
                "save the mesh as it is meant, or move and turn the geom",
            )
            return None
        if "file" not in given:
            self.report.error(
                "SC483", "a mesh without a file is not built", element.location, "save the vertices as OBJ or STL"
            )
            return None
        if "scale" in given and "scale" not in element.attributes:
            self.report.differs(
                "mesh class", "`scale` of a mesh is its class's; ManiSkill's loader takes 1", given.at("scale")
            )
        file = self._file(self.compiler.mesh_folder, given)
        return None if file is None else MeshGeometry(file.uri, file.path, (scale[0], scale[1], scale[2]))

    def look(self, name: str, geom: Attributes, rgba: tuple[float, ...] | None) -> Look | None:
        """The look of a material; None, reported, where there is none.

        Args:
            name: of the material.
            geom: what names it, in `material`.
            rgba: what takes the place of its colour; None: nothing does.
        """
        key = (name, rgba)
        if key not in self._looks:
            self._looks[key] = self._look(name, geom, rgba)
        return self._looks[key]

    def _look(self, name: str, geom: Attributes, rgba: tuple[float, ...] | None) -> Look | None:
        element = self._named("material", name, geom, "material")
        if element is None:
            return None
        given = self.classes.attributes(element, _GLOBAL, READ["material"])
        own = colour(given, (1.0, 1.0, 1.0, 1.0))
        if (
            given.given.keys()
            & {"rgba", "emission", "specular", "shininess", "reflectance"} - element.attributes.keys()
        ):
            self.report.differs(
                "material class",
                "a material has what its class says; ManiSkill's loader leaves that out",
                element.location,
            )
        base = own if rgba is None else rgba
        emission = np.float32(given.number("emission", 0.0, 0.0))
        glow = [float(np.float32(part) * emission) for part in base[:3]]
        texture = self._texture(given)
        return Look(
            base_color=(base[0], base[1], base[2], base[3]),
            texture=None if texture is None else texture.path,
            texture_uri=None if texture is None else texture.uri,
            emission=(glow[0], glow[1], glow[2], 1.0),
            specular=given.number("specular", 0.0, 0.0, 1.0),
            roughness=1 - given.number("reflectance", 0.0, 0.0, 1.0),
            metallic=given.number("shininess", 0.5, 0.0, 1.0),
        )

    def _texture(self, material: Attributes) -> NamedFile | None:
        if "texture" not in material:
            return None
        element = self._named("texture", material.text("texture"), material, "texture")
        if element is None:
            return None
        given = self.classes.attributes(element, _GLOBAL, READ["texture"])
        if "file" not in given:
            self.report.left_out(
                "texture file",
                f"the texture `{cut(material.text('texture'))}` has no file and is not shown",
                element.location,
                "paint it into a file",
            )
            return None
        if given.text("type", "cube") != "2d":
            self.report.left_out(
                "texture type", "a texture of a cube is laid on as a flat one", given.at("type"), 'write `type="2d"`'
            )
        if self.compiler.texture_folder != self.compiler.mesh_folder:
            self.report.differs(
                "texture folder",
                "textures are in `texturedir`; ManiSkill's loader looks in `meshdir`",
                given.at("file"),
            )
        return self._file(self.compiler.texture_folder, given)

    def _named(self, tag: str, name: str, user: Attributes, attribute: str) -> Element | None:
        found = self._found.get((tag, name)) or self._by_path(tag, name)
        if found is None:
            names = (name for kind, name in self._found if kind == tag)
            hint = suggest_name(name, names, self.report.findings.sink)
            self.report.error("SC482", f"there is no {tag} `{cut(name)}`", user.at(attribute), hint)
        return found

    def _by_path(self, tag: str, name: str) -> Element | None:
        """An asset that has no name of its own, by the one of ManiSkill's loader: its path without a suffix."""
        found = self._found.get((tag, posixpath.basename(name)))
        if found is None or "name" in found.attributes:
            return None
        return found if posixpath.splitext(found.attributes["file"])[0] == name else None

    def _file(self, folder: str, given: Attributes) -> NamedFile | None:
        written = given.text("file")
        if self.compiler.strip_path:
            written = posixpath.basename(written)
        return self.files.find(folder, written, given.at("file"))

    def _is_turned(self, given: Attributes) -> bool:
        if "refquat" not in given:
            return False
        w, x, y, z = given.numbers("refquat", NO_TURN)
        return any((x, y, z)) or not w


def colour(given: Attributes, default: tuple[float, ...]) -> tuple[float, ...]:
    """The `rgba` of an element, in single precision; all four between 0 and 1."""
    rgba = given.singles("rgba", default)
    if not all(0 <= part <= 1 for part in rgba):
        given.wrong("rgba", "holds a number that is not between 0 and 1")
        return default
    return rgba
