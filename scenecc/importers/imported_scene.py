"""Input and output of the readers of other formats."""

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
    """A kind of content that a scene file cannot represent.

    Attributes:
        what: plural noun for messages, such as "plugins".
        changes_machine: whether masses, joints, contacts or poses differ without it. The import then stops, unless
            `--allow` names the kind.
    """

    what: str
    changes_machine: bool = False


LOSSES: Final[Mapping[str, LossKind]] = {
    "malformed-xml": LossKind("XML faults", changes_machine=True),
    "plugins": LossKind("plugins"),
    "sensors": LossKind("sensors"),
    "settings": LossKind("world settings"),
    "visuals": LossKind("visual shapes"),
    "missing-files": LossKind("missing files"),
    "material-scripts": LossKind("material scripts"),
    "mesh-looks": LossKind("mesh materials"),
    "lights": LossKind("lights"),
    "light-falloff": LossKind("light falloffs"),
    "names": LossKind("changed names"),
    "empty-links": LossKind("links without shapes"),
    "ellipsoids": LossKind("ellipsoids as hulls"),
    "hulls": LossKind("meshes as hulls"),
    "ball-joints": LossKind("ball joints as hinges"),
    "joint-friction": LossKind("joint frictions and dampings"),
    "effort-limits": LossKind("effort limits"),
    "friction-directions": LossKind("direction-dependent frictions"),
    "saved-states": LossKind("saved states"),
    "worlds": LossKind("additional worlds"),
    "actors": LossKind("actors"),
    "roads": LossKind("roads"),
    "particles": LossKind("particle emitters"),
    "projectors": LossKind("projectors"),
    "sounds": LossKind("sounds"),
    "wind": LossKind("winds"),
    "colliders": LossKind("collision shapes", changes_machine=True),
    "contactless-shapes": LossKind("collision shapes without contacts"),
    "inertias": LossKind("impossible inertias", changes_machine=True),
    "joint-limits": LossKind("missing joint limits", changes_machine=True),
    "models": LossKind("models", changes_machine=True),
    "joints": LossKind("joints", changes_machine=True),
    "loops": LossKind("joints that close loops", changes_machine=True),
    "screw-joints": LossKind("screw joints", changes_machine=True),
    "gearbox-joints": LossKind("gearbox joints", changes_machine=True),
    "kinematic-links": LossKind("kinematic links", changes_machine=True),
    "populations": LossKind("model populations", changes_machine=True),
    "drake-elements": LossKind("Drake elements", changes_machine=True),
    "grippers": LossKind("grippers"),
    "fluids": LossKind("fluid masses and forces", changes_machine=True),
    # Of MJCF.
    "tendons": LossKind("tendons", changes_machine=True),
    "joint-couplings": LossKind("joints that follow others", changes_machine=True),
    "parent-contacts": LossKind("contacts of bodies with their parents"),
    "inactive-equalities": LossKind("inactive equalities"),
    "contact-pairs": LossKind("contact pairs", changes_machine=True),
    "joint-springs": LossKind("joint springs", changes_machine=True),
    "actuators": LossKind("actuators"),
    "gravity-shares": LossKind("bodies with partial gravity", changes_machine=True),
    "switches": LossKind("disabled springs, limits and the like", changes_machine=True),
    "camera-modes": LossKind("tracking cameras and lights"),
    "sites": LossKind("sites"),
    "softness": LossKind("soft contacts and limits"),
    "contact-forces": LossKind("adhesive surfaces", changes_machine=True),
    "moving-surfaces": LossKind("moving surfaces", changes_machine=True),
    "surface-friction": LossKind("torsional and rolling frictions"),
    # Of USD.
    "mesh-simplification": LossKind("collision mesh simplifications"),
    "assumed-masses": LossKind("assumed masses and inertias"),
    "material-looks": LossKind("material properties"),
    "frictions": LossKind("static frictions below dynamic friction"),
    "idle-joints": LossKind("joints without effect"),
    "joint-breaks": LossKind("joints that break"),
    "light-units": LossKind("light units"),
    "lenses": LossKind("camera lenses"),
    "animations": LossKind("animations"),
    "unknown-prims": LossKind("prims of unknown types"),
    "vendor-attributes": LossKind("attributes of other schemas"),
    "contact-materials": LossKind("materials with other contacts", changes_machine=True),
    "soft-bodies": LossKind("soft bodies and other dynamics", changes_machine=True),
    "point-instancers": LossKind("point instancers", changes_machine=True),
    "physics-scenes": LossKind("additional physics scenes"),
    "collision-filters": LossKind("collision filters", changes_machine=True),
    "swing-limits": LossKind("swing limits of joints", changes_machine=True),
    # Of Drake's directives and EmbodiedGen's layouts.
    "robots": LossKind("robots"),
    "joint-positions": LossKind("joint positions beyond their limits", changes_machine=True),
    "joint-frames": LossKind("joints whose frames do not coincide at the start"),
}
"""Kind of loss, as named by `--allow` → its description."""

ALL_LOSSES: Final = "all"
"""Allows all kinds of losses."""


REPAIRED: Final = "SC488"
"""Code of notes about content that is left out or replaced when a robot file is repaired."""


@frozen
class Loss:
    """Content of the file that the scene lacks or replaces.

    Attributes:
        kind: a key of `LOSSES`.
        message: what is lost, and its replacement, without the place: "the plugin `libwind.so`".
        place: location in the file.
        path: of the element or prim: `world/cart/wheel`.
    """

    kind: str
    message: str
    place: Location
    path: str = ""


@dataclass(frozen=True, slots=True)
class Asset:
    """A file of the scene, which the document holds instead of a path.

    The writer refers to it by a relative path, `pkg://` or `asset://`, or else copies it beside the scene.

    Attributes:
        name: file name of a copy, with suffix. It need not be unique.
        source: the file, absolute and checked by `ImportContext.scope`; or the content of a generated file.
    """

    name: str
    source: Path | bytes = field(repr=False)


@frozen
class ReferencePose:
    """Pose and mass of a body according to the source's own library.

    Attributes:
        pose: of the body's frame in the world, p [m] then q (wxyz).
        mass: [kg]; None: not in the file, or the body does not move.
    """

    pose: tuple[float, ...]
    mass: float | None = None


@dataclass(frozen=True, slots=True)
class ImportedScene:
    """An imported file as a scene.

    Attributes:
        document: a scene document, as plain data with `Asset`s for files; {} after an error, when only
            the losses are used.
        losses: in file order.
        bodies: name in the scene (`ENTITY` or `ENTITY/LINK`) → name in the source (`model::link`, a prim's path), for
            the comparison of poses and masses; without added links.
        reference: name in the source → pose and mass from the source's own library; empty if an engine is used instead.
        engine: name of the library that gave `reference`.
        places: name in the scene, as in `bodies`, or of an entity → location in the file.
        codes_of_losses: codes of findings about the scene that `losses` already covers.
    """

    document: dict[str, Any]
    losses: tuple[Loss, ...] = ()
    bodies: Mapping[str, str] = field(default_factory=dict[str, str])
    reference: Mapping[str, ReferencePose] = field(default_factory=dict[str, ReferencePose])
    engine: str = ""
    places: Mapping[str, Location] = field(default_factory=dict[str, Location])
    codes_of_losses: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class ImportContext:
    """Resources of a reader.

    Attributes:
        sink: receives errors. Losses are not errors: they go into `ImportedScene.losses`.
        scope: files that may be read: the file's folder and the asset roots.
        limits: size limits.
        allow: kinds of losses that the user allows.
        keep_file: whether an MJCF stays a file that the scene names.
    """

    sink: Sink
    scope: AssetScope
    limits: Limits
    allow: frozenset[str] = frozenset()
    keep_file: bool = False

    def resolve(self, path: Path) -> ResolvedFile | None:
        """Returns the imported file, displayed by the user's path; None after an error."""
        found = resolve_path(path.name, base=path.absolute().parent, scope=self.scope)
        if isinstance(found, Refusal):
            self.sink.report(found.code, found.message, Location(str(path)), hint=found.hint)
            return None
        return found._replace(uri=str(path))
