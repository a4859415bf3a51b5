"""An MJCF as passed to MuJoCo's compiler: one text without includes, and the content of every file that it names.

MuJoCo opens any file by itself, also by absolute paths, and creates as many bodies as a file asks for. So scenecc
parses the tree, resolves includes, finds each file inside the folders that the scene may read, renames it, and counts
what the compiler would multiply. Each element is on its own line, so that a line reported by MuJoCo leads back to the
original file.
"""

from __future__ import annotations

import math
import posixpath
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

from scenecc.diagnostics.messages import cut
from scenecc.robots.files import MAX_READ_MEMORY, read_robot_bytes
from scenecc.robots.mujoco.worker import MODEL_PREFIX
from scenecc.robots.xml import SourceElement, parse_number

if TYPE_CHECKING:
    from scenecc.robots.description import DescribedFile
    from scenecc.robots.mjcf_files import MjcfFiles, MjcfReport

_PICTURES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
"""Texture attributes that name files."""

_OF_PICTURES = (*_PICTURES, "content_type", "gridsize", "gridlayout", "hflip", "vflip", "nchannel")
"""Texture attributes that control how its files are read."""

_REFUSED = {
    "plugin": "plugins are code, which is not run",
    "flexcomp": "soft bodies are not built",
    "flex": "soft bodies are not built",
    "deformable": "soft bodies are not built",
}

_DROPPED_ATTRIBUTES = {
    "compiler": frozenset({"meshdir", "texturedir", "assetdir", "strippath"}),
    # Memory for simulation, which MuJoCo does not run here.
    "size": frozenset({"memory", "njmax", "nconmax", "nstack"}),
}
"""Attributes that are not passed to MuJoCo."""

_PNG = b"\x89PNG\r\n\x1a\n"

_ELSEWHERE = {
    "camera": "cameras belong to the scene: declare them under `cameras`, with `mount` if they move with a link",
    "light": "lights belong to the scene: declare them under `lights`",
    "option": "time step, gravity and solver belong under `physics` of the scene",
    "sensor": "sensors are read from the live scene",
    "site": "sites are not links: declare a frame, or mount on the link",
    "custom": "user data is not read",
    "extension": "plugins are code, which is not run",
    "visual": "settings of MuJoCo's viewer are not read",
    "statistic": "settings of MuJoCo's viewer are not read",
    "softness": "contacts and limits of PhysX are stiff: `solref`, `margin` and the like are not built",
    "hull": "meshes collide by their whole hull: `maxhullvert` is ignored",
    "sleep": "sleep settings belong under `physics` of the scene",
    "look/flip": "`hflip` and `vflip` of textures are not built",
}
"""Notes, reported with a count: set elsewhere in a scene, or irrelevant to the mechanism."""

_LEFT_OUT = {
    "tendon": ("tendons are not built", "use an `<equality>` of joints for a joint that follows another"),
    "pair": ("contact pairs are not built: use `contype` and `conaffinity`", None),
    "skin": ("skins are not shown", None),
    "actuator/plugin": ("actuators of plugins are not built: they drive no joint", "use `drives` in the scene"),
}
"""Warnings: these change the mechanism."""

_NO_DRIVE = {"gaintype": "fixed", "biastype": "none", "dyntype": "none"}
"""Attributes of the motor that replaces the actuator of a plugin, so that controls of keyframes keep their places."""

_TRANSMISSION = frozenset(
    ["name", "joint", "jointinparent", "tendon", "cranksite", "slidersite", "site", "refsite", "body", "cranklength"]
)
"""Attributes of such an actuator that the motor keeps: MuJoCo checks what it acts on."""

_SOFTNESS = """
solref solimp solmix margin gap priority solreflimit solimplimit solreffriction solimpfriction torquescale
"""

_ATTRIBUTES_ELSEWHERE = {
    "softness": _SOFTNESS.split(),
    "hull": ["maxhullvert"],
    "sleep": ["sleep"],
    "look/flip": ["hflip", "vflip"],
}
"""Attributes of any element that are reported as a note, by the note's key."""

_MOST = {"elements": 100_000, "bodies": 10_000}
"""Maximum numbers after MuJoCo's replicate and attach. MuJoCo's reader takes 10 s for 10 000 bodies, and four times as
long for twice as many."""

MAX_CELLS = 2**24
"""Maximum number of pixels of procedural textures and cells of height fields, together."""


@dataclass(slots=True)
class MujocoSource:
    """A model for MuJoCo's compiler.

    Attributes:
        elements: the element on each line.
        lines: lines of the text, then of attached models.
        length: number of lines of the text.
        assets: content of each file, by its name in the text.
        files: original file of each name.
        textures: image files, by the line of the texture.
    """

    elements: list[SourceElement] = field(default_factory=list["SourceElement"])
    lines: list[str] = field(default_factory=list[str])
    length: int = 0
    assets: dict[str, bytes] = field(default_factory=dict[str, bytes])
    files: dict[str, DescribedFile] = field(default_factory=dict[str, "DescribedFile"])
    textures: dict[int, DescribedFile] = field(default_factory=dict[int, "DescribedFile"])

    @property
    def text(self) -> str:
        """The text of the model."""
        return "\n".join(self.lines[: self.length])

    def first(self, tag: str) -> SourceElement:
        """Returns the first element with a tag; the file's root if there is none."""
        return next((element for element in self.elements if element.tag == tag), self.elements[0])

    def named(self, tag: str, name: str) -> SourceElement | None:
        """Returns the first element with a tag and a name."""
        found = (element for element in self.elements if element.tag == tag and element.attributes.get("name") == name)
        return next(found, None)

    def element(self, line: int | None) -> SourceElement | None:
        """Returns the element on a line, counted from 1."""
        return None if line is None or not 1 <= line <= len(self.elements) else self.elements[line - 1]


@dataclass(slots=True)
class SourceBuilder:
    """Writes the text of a model from its tree.

    Attributes:
        files: finds and reads the files that the model names.
        report: receives the errors.
    """

    files: MjcfFiles
    report: MjcfReport
    source: MujocoSource = field(default_factory=MujocoSource)
    _models: dict[Path, tuple[str, SourceBuilder, SourceElement]] = field(
        default_factory=dict[Path, "tuple[str, SourceBuilder, SourceElement]"]
    )
    _above: tuple[Path, ...] = ()
    _attached: dict[int, str] = field(default_factory=dict[int, str])
    _largest: dict[str, float] = field(default_factory=lambda: dict.fromkeys(_MOST, 1.0))
    _folders: dict[str, str] = field(default_factory=dict[str, str])
    _known: dict[Path, str] = field(default_factory=dict[Path, str])
    _cells: int = 0
    _has_unknown_states: bool = False
    _unbuilt: dict[str, tuple[SourceElement, int]] = field(default_factory=dict[str, "tuple[SourceElement, int]"])

    def build(self, root: SourceElement) -> MujocoSource | None:
        """Returns the source of a tree with resolved includes; None after an error."""
        self.read(root)
        if not self.report.failed:
            self.write(root)
            self.source.length = len(self.source.lines)
            for name, builder, model in self._models.values():
                # Blank lines before each model make line numbers unique.
                start = len(self.source.lines)
                builder.write(model)
                self.source.assets[name] = "\n".join([""] * start + self.source.lines[start:]).encode()
            self._report_notes()
        return None if self.report.failed else self.source

    def read(self, root: SourceElement) -> None:
        """Reads the attached models, and reports a model that is too large (SC452)."""
        # Only a plugin knows the number of its states, which keyframes list.
        self._has_unknown_states = any(each.find("plugin") is not None for each in root.all("actuator"))
        for compiler in root.all("compiler"):
            self._folders.update((name, value) for name, value in compiler.attributes.items())
        for asset in root.all("asset"):
            for element in asset.all("model"):
                if (model := self._read_model(element)) is not None:
                    builder, top = model
                    self._largest = {kind: max(most, builder.count(top, kind)) for kind, most in self._largest.items()}
        for kind, most in _MOST.items():
            if (count := self.count(root, kind)) > most:
                shown = f"{count:.0f}" if count < 1e15 else f"{count:.1g}"
                message = f"the model is too large: it has {shown} {kind}, and the limit is {most}"
                self.report.error("SC452", message, root.location, "replicate or attach less, or split it")
                return

    def _read_model(self, element: SourceElement) -> tuple[SourceBuilder, SourceElement] | None:
        """Returns the builder and the root of an attached model; None after an error."""
        place, files = element.at("file"), self.files
        found = files.find(element.attributes.get("file", ""), place)
        if found is None:
            return None
        above = (*self._above, files.named.owner.path)
        if found.path in above:
            self.report.error("SC486", f"`{cut(found.uri)}` attaches itself", place)
            return None
        if found.path not in self._models:
            if len(self._models) >= files.limits.depth:
                self.report.error("SC452", f"more than {files.limits.depth} models are attached", place)
                return None
            name = f"{MODEL_PREFIX}{len(self._models)}.xml"
            inner, root = files.attach(found, place)
            if root is None:
                return None
            builder = SourceBuilder(
                inner, self.report, self.source, self._models, above, _known=self._known, _unbuilt=self._unbuilt
            )
            self._models[found.path], self.source.files[name] = (name, builder, root), found
            builder.read(root)
        name, builder, root = self._models[found.path]
        self._attached[id(element)] = name
        return builder, root

    def count(self, element: SourceElement, kind: str) -> float:
        """Returns how many elements, or bodies, MuJoCo makes of an element and its children. `kind`: of `_MOST`."""
        own = kind == "elements" or element.tag in {"body", "composite"}
        inner = own + sum(self.count(child, kind) for child in element.children)
        if element.tag == "attach":
            return inner + self._largest[kind]
        if element.tag not in {"replicate", "composite"}:
            return inner
        counts = map(parse_number, element.attributes.get("count", "1").split())
        return inner * math.prod(max(1.0, count) for count in counts if count is not None and math.isfinite(count))

    def write(self, element: SourceElement, above: str = "") -> None:
        """Appends the lines of an element. `above`: tag of its parent."""
        if element.tag == "plugin" and above in {"actuator", "sensor"}:
            self._write_plugin(element, above)
            return
        reason = _REFUSED.get(element.tag)
        if reason is not None:
            self.report.error("SC483", f"`<{element.tag}>` cannot be built: {reason}", element.location)
            return
        self._note(element)
        if element.tag in {"skin", "extension"}:
            return
        self._check_cells(element)
        attributes = dict(element.attributes)
        dropped = _DROPPED_ATTRIBUTES.get(element.tag, frozenset())
        attributes = {name: value for name, value in attributes.items() if name not in dropped}
        if element.tag in {"mesh", "hfield", "texture"} and not attributes.get("name") and "file" in attributes:
            attributes["name"] = Path(attributes["file"]).stem
        if element.tag == "key" and self._has_unknown_states:
            attributes.pop("act", None)
        if element.tag == "texture":
            attributes = self._texture(element, attributes)
        elif element.tag in {"mesh", "hfield", "model"} and "file" in attributes:
            attributes["file"] = self._asset(element)
        self.source.elements.append(element)
        words = _written(attributes)
        if not element.children:
            self.source.lines.append(f"<{element.tag}{words}/>")
            return
        self.source.lines.append(f"<{element.tag}{words}>")
        for child in element.children:
            self.write(child, element.tag)
        self.source.elements.append(element)
        self.source.lines.append(f"</{element.tag}>")

    def _write_plugin(self, plugin: SourceElement, above: str) -> None:
        """Replaces an actuator's plugin by a motor, and leaves a sensor's out, which is noted with all sensors."""
        if above == "sensor":
            return
        first, before = self._unbuilt.get("actuator/plugin", (plugin, 0))
        self._unbuilt["actuator/plugin"] = first, before + 1
        kept = {name: value for name, value in plugin.attributes.items() if name in _TRANSMISSION}
        self.source.elements.append(plugin)
        self.source.lines.append(f"<general{_written(kept | _NO_DRIVE)}/>")

    def _note(self, element: SourceElement) -> None:
        kind, count = element.tag, int("site" not in element.attributes)
        if kind in {"tendon", "sensor", "custom"}:
            count = len(element.children)
        if (kind in _ELSEWHERE or kind in _LEFT_OUT) and count:
            first, before = self._unbuilt.get(kind, (element, 0))
            self._unbuilt[kind] = first, before + count
        for word, names in _ATTRIBUTES_ELSEWHERE.items():
            if any(element.attributes.get(name, "false") not in {"false", "-1"} for name in names):
                first, before = self._unbuilt.get(word, (element, 0))
                self._unbuilt[word] = first, before + 1

    def _report_notes(self) -> None:
        """Reports one finding per kind, at its first element."""
        for kind, (element, count) in self._unbuilt.items():
            more = f" (there are {count})" if count > 1 else ""
            if kind in _LEFT_OUT:
                words, hint = _LEFT_OUT[kind]
                self.report.leave_out(kind, words + more, element.location, hint)
                continue
            self.report.note_elsewhere(kind, _ELSEWHERE[kind] + more, element.location)

    def _check_cells(self, element: SourceElement) -> None:
        """Counts pixels and cells that MuJoCo would allocate."""
        if element.tag in {"texture", "hfield"}:
            names = ("width", "height") if element.tag == "texture" else ("nrow", "ncol")
            sizes = [parse_number(element.attributes.get(name, "0")) or 0 for name in names]
            cells = sizes[0] * sizes[1] * (6 if element.attributes.get("type") in {"cube", "skybox"} else 1)
            self._add_cells(cells, element)

    def _add_cells(self, cells: float, element: SourceElement) -> None:
        self._cells += int(min(cells, MAX_CELLS + 1)) if math.isfinite(cells) else MAX_CELLS + 1
        if self._cells > MAX_CELLS:
            message = f"the model is too large: its textures and height fields have more than {MAX_CELLS} cells"
            self.report.error("SC452", message, element.location)

    def _asset(self, element: SourceElement) -> str:
        if element.tag == "model":
            return self._attached.get(id(element), "")
        found = self._find(element, "file")
        if found is None:
            return ""
        if found.path not in self._known:
            name = f"file{len(self._known)}{found.path.suffix.lower()}"
            limit = self.files.limits.asset_bytes
            report = self.report.of(element.location)
            data = read_robot_bytes(found.path, found.uri, report, limit, is_xml=False)
            if data is None:
                return ""
            self._known[found.path] = name
            self.source.assets[name], self.source.files[name] = data, found
            if sum(map(len, self.source.assets.values())) > MAX_READ_MEMORY:
                message = f"the model's files have more than {MAX_READ_MEMORY} bytes together"
                self.report.error("SC452", message, element.location)
        name = self._known[found.path]
        if element.tag == "hfield":
            # A PNG header gives its size.
            head = self.source.assets[name][:24]
            if len(head) == 24 and head.startswith(_PNG):
                width, height = struct.unpack(">2I", head[16:])
                self._add_cells(width * height, element)
        return name

    def _texture(self, element: SourceElement, attributes: dict[str, str]) -> dict[str, str]:
        """Replaces a texture's files by a dummy: SAPIEN reads the images, not MuJoCo."""
        files = [self._find(element, name) for name in _PICTURES if name in attributes]
        if not files or attributes.get("builtin", "none") != "none":
            return attributes
        if files[0] is not None and "file" in attributes:
            self.source.textures[len(self.source.lines) + 1] = files[0]
        kept = {name: value for name, value in attributes.items() if name not in _OF_PICTURES}
        return {**kept, "builtin": "flat", "width": "1", "height": "1"}

    def _find(self, element: SourceElement, attribute: str) -> DescribedFile | None:
        """Returns the file that an attribute names; None after an error."""
        written = element.attributes[attribute]
        if self._folders.get("strippath") == "true":
            written = posixpath.basename(written.replace("\\", "/"))
        own = "texturedir" if element.tag == "texture" else "meshdir"
        folder = self._folders.get(own, self._folders.get("assetdir", ""))
        return self.files.find(posixpath.join(folder, written) if written else "", element.at(attribute))


def _written(attributes: dict[str, str]) -> str:
    """Returns attributes as XML, each after a space."""
    return "".join(f" {name}={quoteattr(value, {chr(10): ' '})}" for name, value in attributes.items())
