"""What a reader of another format is given and what it returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, resolve_path

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.source import Limits


@frozen
class LossKind:
    """One kind of content that a scene file does not hold.

    Attributes:
        what: in words, after a number: "3 plugins".
        changes_machine: whether masses, joints, contacts or poses differ without it. The import then stops, unless
            `--allow` names the kind.
    """

    what: str
    changes_machine: bool = False


LOSSES: Final[Mapping[str, LossKind]] = {
    "malformed-xml": LossKind("faults of the XML", changes_machine=True),
    "plugins": LossKind("plugins"),
    "sensors": LossKind("sensors"),
    "settings": LossKind("settings of the world"),
    "visuals": LossKind("visual shapes"),
    "missing-files": LossKind("missing files"),
    "material-scripts": LossKind("material scripts"),
    "mesh-looks": LossKind("materials of meshes"),
    "lights": LossKind("lights"),
    "light-falloff": LossKind("falloffs of lights"),
    "names": LossKind("changed names"),
    "empty-links": LossKind("links without shapes"),
    "ellipsoids": LossKind("ellipsoids as hulls"),
    "hulls": LossKind("meshes as hulls"),
    "ball-joints": LossKind("ball joints as hinges"),
    "joint-friction": LossKind("frictions of joints"),
    "effort-limits": LossKind("effort limits"),
    "friction-directions": LossKind("frictions that depend on the direction"),
    "saved-states": LossKind("saved states"),
    "worlds": LossKind("further worlds"),
    "actors": LossKind("actors"),
    "roads": LossKind("roads"),
    "particles": LossKind("particle emitters"),
    "projectors": LossKind("projectors"),
    "sounds": LossKind("sounds"),
    "wind": LossKind("winds"),
    "colliders": LossKind("colliding shapes", changes_machine=True),
    "contactless-shapes": LossKind("colliding shapes without contacts"),
    "collision-bitmasks": LossKind("bitmasks of collisions", changes_machine=True),
    "self-collisions": LossKind("models that collide with themselves", changes_machine=True),
    "inertias": LossKind("impossible inertias", changes_machine=True),
    "joint-limits": LossKind("missing limits of joints", changes_machine=True),
    "models": LossKind("models", changes_machine=True),
    "joints": LossKind("joints", changes_machine=True),
    "loops": LossKind("joints that close loops", changes_machine=True),
    "screw-joints": LossKind("screw joints", changes_machine=True),
    "gearbox-joints": LossKind("gearbox joints", changes_machine=True),
    "kinematic-links": LossKind("kinematic links", changes_machine=True),
    "populations": LossKind("populations of models", changes_machine=True),
    "drake-elements": LossKind("elements of Drake", changes_machine=True),
    "grippers": LossKind("grippers"),
    "fluids": LossKind("masses and forces of fluids", changes_machine=True),
    # Of MJCF.
    "tendons": LossKind("tendons", changes_machine=True),
    "contact-pairs": LossKind("pairs of contacts", changes_machine=True),
    "joint-springs": LossKind("springs of joints", changes_machine=True),
    "actuators": LossKind("actuators"),
    "gravity-shares": LossKind("bodies that a share of gravity pulls", changes_machine=True),
    "switches": LossKind("springs, limits and the like that the file switches off", changes_machine=True),
    "camera-modes": LossKind("cameras that follow something"),
    "sites": LossKind("sites"),
    "softness": LossKind("soft contacts and limits"),
    "contact-forces": LossKind("surfaces that stick or carry along", changes_machine=True),
    "surface-friction": LossKind("torsional and rolling frictions"),
    # Of USD.
    "mesh-simplification": LossKind("simplifications of colliding meshes"),
    "assumed-masses": LossKind("masses and inertias that the file leaves open"),
    "material-looks": LossKind("properties of materials"),
    "frictions": LossKind("static frictions below the dynamic ones"),
    "idle-joints": LossKind("joints without effect"),
    "joint-breaks": LossKind("joints that break"),
    "light-units": LossKind("units of lights"),
    "lenses": LossKind("lenses of cameras"),
    "animations": LossKind("motions over time"),
    "unknown-prims": LossKind("prims of unknown types"),
    "vendor-attributes": LossKind("attributes of other schemas"),
    "soft-bodies": LossKind("things that move in other ways than bodies and joints", changes_machine=True),
    "point-instancers": LossKind("point instancers", changes_machine=True),
    "physics-scenes": LossKind("further physics scenes"),
    "collision-filters": LossKind("filters of collisions", changes_machine=True),
    "swing-limits": LossKind("limits across the axis of joints", changes_machine=True),
    "joint-frames": LossKind("joints whose frames do not meet at the start"),
}
"""The name that `--allow` takes, and what it stands for."""


REPAIRED: Final = "SC488"
"""The code of notes about what is left out or replaced, so that a robot's file can be read."""


@frozen
class Loss:
    """One thing that the scene does not hold as the file does.

    Attributes:
        kind: a key of `LOSSES`.
        message: what is lost and what the scene holds in its place, without the place: "the plugin `libwind.so`".
        place: in the file.
        path: of the element or prim: `world/cart/wheel`.
    """

    kind: str
    message: str
    place: Location
    path: str = ""


@dataclass(frozen=True, slots=True)
class Asset:
    """A file that the scene names. It stands in the document in place of the path, wherever the language takes a file.

    The writer names it relative to the scene, by `pkg://` or by `asset://`; what cannot be named so is copied beside
    the scene.

    Attributes:
        name: of the copy, with its suffix. It need not be unique.
        source: the file, absolute and checked by `ImportContext.scope`; or the content of a file that the reader made.
    """

    name: str
    source: Path | bytes = field(repr=False)


@frozen
class ReferencePose:
    """Where the source's own library has a body, for formats without an engine.

    Attributes:
        pose: of the body's frame in the world, p [m] then q (wxyz).
        mass: [kg]; None: the file gives none, or the body does not move.
    """

    pose: tuple[float, ...]
    mass: float | None = None


@dataclass(frozen=True, slots=True)
class ImportedScene:
    """A file as a scene.

    Attributes:
        document: of a scene file, as plain data; `Asset`s stand for files.
        losses: in the order of the file.
        bodies: name in the scene (`ENTITY` or `ENTITY/LINK`) → name in the source (`model::link`, a prim's path), for
            the comparison of poses and masses.
        reference: name in the source → what the source's own library says of the body; empty where an engine is asked.
        judge: the library that `reference` is from.
        places: name in the scene, as in `bodies`, or of an entity → where it is in the file.
        codes_of_losses: codes of findings about the scene that `losses` lists already.
    """

    document: dict[str, Any]
    losses: tuple[Loss, ...] = ()
    bodies: Mapping[str, str] = field(default_factory=dict[str, str])
    reference: Mapping[str, ReferencePose] = field(default_factory=dict[str, ReferencePose])
    judge: str = ""
    places: Mapping[str, Location] = field(default_factory=dict[str, Location])
    codes_of_losses: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class ImportContext:
    """What a reader may use.

    Attributes:
        sink: takes errors. What is lost is no error: it belongs into `ImportedScene.losses`.
        scope: which files may be read: the folder of the file, the asset roots.
        limits: sizes of files.
        allow: the kinds of losses that the user allows.
    """

    sink: Sink
    scope: AssetScope
    limits: Limits
    allow: frozenset[str] = frozenset()

    def resolve(self, path: Path) -> ResolvedFile | None:
        """The imported file, shown by the path that the user gave; None after an error."""
        found = resolve_path(path.name, base=path.absolute().parent, scope=self.scope)
        if isinstance(found, Refusal):
            self.sink.report(found.code, found.message, Location(str(path)), hint=found.hint)
            return None
        return found._replace(uri=str(path))
