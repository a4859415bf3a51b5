"""Reader for MJCF: robots and bodies as MuJoCo's compiler understands them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, nearest
from scenecc.robots.description import RobotDescription
from scenecc.robots.files import FileReport, ReadBudget, RobotFiles
from scenecc.robots.mjcf_files import MjcfFiles, MjcfReport
from scenecc.robots.mujoco.compiler import check_mujoco, compile_source, mujoco_version
from scenecc.robots.mujoco.equalities import read_constraints
from scenecc.robots.mujoco.links import ModelReader
from scenecc.robots.mujoco.model import FREE
from scenecc.robots.mujoco.shapes import VISUAL_GROUPS
from scenecc.robots.mujoco.source import SourceBuilder
from scenecc.robots.mujoco.unbuilt import report_unbuilt
from scenecc.source.limits import Limits

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location, Origin
    from scenecc.robots.description import LinkName
    from scenecc.robots.mujoco.model import CompiledModel
    from scenecc.source.paths import AssetScope, ResolvedFile

_DEFAULT_LIMITS = Limits()


@frozen
class ReadModel:
    """A file with all that MuJoCo's compiler made of it.

    Attributes:
        description: its robots.
        model: compiled.
        links: root and link that bodies became, by the bodies' numbers.
        losses: kind, message and place of everything that is not built from the file.
    """

    description: RobotDescription
    model: CompiledModel
    links: Mapping[int, LinkName]
    losses: tuple[tuple[str, str, Location], ...]


def read_mjcf(file: ResolvedFile, **options: Any) -> RobotDescription | None:
    """The robots and bodies of an MJCF, as `read_model` reads them; None after an error."""
    found = read_model(file, **options)
    return None if found is None else found.description


def read_model(
    file: ResolvedFile,
    *,
    scope: AssetScope,
    sink: Sink,
    origin: Origin | None = None,
    keyframe: tuple[str, Origin | None] | None = None,
    visual_groups: Collection[int] = VISUAL_GROUPS,
    limits: Limits = _DEFAULT_LIMITS,
    budget: ReadBudget | None = None,
) -> ReadModel | None:
    """The robots and bodies of an MJCF; None where the file is wrong, all that is wrong having been reported.

    First come the articulations, then bodies without joints, then the world's own geoms, with MuJoCo's names; what has
    none is `body_N` or `geom_N`, and a root that a file does not have is `dummy_root_N`.

    Args:
        file: the MJCF, as `scenecc.source.paths.resolve_path` finds it.
        scope: what may be read; meshes, textures and included files are looked for inside.
        sink: takes what is wrong, at the file's own lines: codes SC401 to SC407 for files that it names, SC450 to SC458
            where it cannot be read, SC480 to SC490 for the rest.
        origin: the node of the scene that names the file, reported with each finding.
        keyframe: the name of the keyframe that gives initial positions, and where the scene says it.
        visual_groups: the groups of geoms that are seen.
        limits: `includes`: how many files include one another; `asset_bytes`: size of each.
        budget: of all files of the scene; None: it is read alone.
    """
    report = MjcfReport(FileReport(sink, origin, budget=budget))
    files = MjcfFiles(RobotFiles(file, scope), file.uri, limits, report)
    root = files.read_model()
    if root is None or not check_mujoco(report, root.location):
        return None
    source = SourceBuilder(files, report).build(root)
    model = None if source is None else compile_source(source, report)
    if model is None:
        return None
    number = None if keyframe is None else _keyframe(keyframe, model, report)
    if number is not None and FREE in model["jnt_type"]:
        message = "the pose of a free root is that of the scene, and not that of the keyframe"
        report.elsewhere("keyframe", message, model.location("key", number))
    report_unbuilt(model, report, number)
    reader = ModelReader(model, report, number, visual_groups)
    robots = reader.robots()
    constraints = read_constraints(model, reader.links_of_bodies, report)
    if not robots and not report.failed:
        report.nothing(root)
    report.report_unread()
    if report.failed:
        return None
    description = RobotDescription(
        tuple(robots), tuple(files.named.found.values()), tuple(constraints), f"mujoco {mujoco_version()}"
    )
    return ReadModel(description, model, reader.links_of_bodies, tuple(report.losses))


def _keyframe(keyframe: tuple[str, Origin | None], model: CompiledModel, report: MjcfReport) -> int | None:
    """The number of a keyframe; None, reported (SC482), where there is none of the name."""
    name, origin = keyframe
    names = model.names("key")
    if name in names:
        return names.index(name)
    near = nearest(name, names)
    known = f"it has {', '.join(f'`{cut(one)}`' for one in names[:12])}" if names else "it has none: leave the key out"
    hint = f"did you mean `{near}`?" if near else known
    message = f"the file has no keyframe `{cut(name)}`"
    findings = report.findings
    findings.errors += 1
    findings.sink.report("SC482", message, origin or findings.place(model.source.elements[0].location), hint=hint)
    return None
