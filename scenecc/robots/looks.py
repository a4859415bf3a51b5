"""Materials of a URDF. Of one name the first that is met counts everywhere, as in SAPIEN's loader."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.robots.description import Look
from scenecc.robots.reading import several, word

if TYPE_CHECKING:
    from scenecc.robots.files import RobotFiles
    from scenecc.robots.findings import Findings
    from scenecc.robots.xml import Element


class Looks:
    """The materials of one URDF."""

    def __init__(self, robot: Element, files: RobotFiles, findings: Findings) -> None:
        self._files = files
        self._findings = findings
        self._elements: dict[str, Element] = {}
        self._read: dict[int, Look | None] = {}
        for element in robot.all("material"):
            self._add_shared(element)
        for link in robot.all("link"):
            for visual in link.all("visual"):
                element = visual.find("material")
                if element is not None and element.attributes.get("name"):
                    self._elements.setdefault(element.attributes["name"], element)

    def of(self, visual: Element) -> Look | None:
        """The look of a <visual>; None where it names no material, or what it names is reported as wrong.

        A material without colour and texture is one all the same, and hides the mesh's own.
        """
        element = visual.find("material")
        if element is None:
            return None
        name = element.attributes.get("name", "")
        meant = self._elements.get(name, element) if name else element
        if meant is not element:
            self._compare(element, meant)
        if id(meant) not in self._read:
            self._read[id(meant)] = self._look(meant)
        return self._read[id(meant)]

    def _add_shared(self, element: Element) -> None:
        name = word(element, "name", self._findings)
        if name is None:
            return
        first = self._elements.setdefault(name, element)
        if first is not element:
            self._findings.report(
                "SC460",
                f"there are two materials named `{name}`",
                element.at("name"),
                related=[("the first is here", first.at("name"), "value")],
            )

    def _compare(self, element: Element, meant: Element) -> None:
        """Warns of a material that says something and is not the one that counts."""
        said, counts = _said(element), _said(meant)
        if any(said) and said != counts:
            name = element.attributes["name"]
            self._findings.report_once(
                "SC476",
                name,
                f"the material `{name}` is another here than where it is first met, which counts everywhere",
                element.location,
                hint=f"the first is in line {meant.line + 1}; give this one a name of its own",
            )

    def _look(self, element: Element) -> Look | None:
        color, texture = element.find("color"), element.find("texture")
        if color is not None:
            rgba = several(color, "rgba", 4, self._findings)
            if rgba is None:
                return None
            red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in rgba)
            return Look(base_color=(red, green, blue, alpha))
        if texture is None:
            return Look()
        reference = word(texture, "filename", self._findings)
        place = texture.at("filename")
        file = None if reference is None else self._files.find(reference, place, self._findings)
        return None if file is None else Look(texture=file.path, texture_uri=file.uri)


def _said(element: Element) -> tuple[str | None, str | None]:
    color, texture = element.find("color"), element.find("texture")
    rgba = None if color is None else " ".join(color.attributes.get("rgba", "").split())
    return rgba, None if texture is None else texture.attributes.get("filename")
