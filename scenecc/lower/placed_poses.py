"""Poses of what is placed, as they are built."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.diagnostics.diagnostic import Origin
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.meshes.surface import MeshError
from scenecc.placing.bodies import UnsupportedShapeError, rows_in, rows_of
from scenecc.placing.place import Placer, PlacingError
from scenecc.placing.proof import find_overlap
from scenecc.variation.evaluation import Batch
from scenecc.variation.nodes import NODES
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, ComputeLimitError, DrawError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.lower.fields import SamplingContext
    from scenecc.lower.frames import FrameGraph
    from scenecc.plan import Entity, ScenePlan

    Floats = NDArray[np.float64]


def place_as_built(plan: ScenePlan, sampling: SamplingContext, frames: FrameGraph, sink: Sink) -> None:
    """Finds the places of all placements of a plan, which values that follow them read from then on.

    Args:
        plan: whose placements have their recipes.
        sampling: of the document; takes the poses.
        frames: poses of the document.
        sink: takes what fits nowhere.
    """
    scenes = np.arange(plan.num_scenes)
    batch = Batch(scenes, sampling.seed, plan.num_scenes, sampling.draws, {}, sampling.computed)
    origin = plan.placements[0].origin or Origin(None)
    try:
        standing: dict[str, Floats] = {}
        local: dict[str, Floats] = {}
        for entity in plan.entities:
            (local if frames.placed_root(entity.name) else standing)[entity.name] = _pose(entity, frames, batch)
        still = {one.name for one in plan.placements if all(map(frames.is_fixed, one.entities))}
        drawn_anew = {one.name for one in plan.entities if not one.pose.known and not frames.is_fixed(one.name)}
        placer = Placer(plan, batch, standing, local, still, drawn_anew)
        for placement in plan.placements:
            origin = placement.origin or origin
            placer.place(placement)
            # Whatever stands relative to it reads its place while the next is placed.
            sampling.placed.update(batch.placed)
        overlap = find_overlap(plan, batch, placer.poses)
        if overlap is not None:
            sink.report("SC356", overlap, origin)
    except PlacingError as error:
        first = error.scenes[0]
        message = f"in scene {first}: {error.message}"
        if len(error.scenes) > 1:
            message += f", nor in {len(error.scenes) - 1} other scenes"
        message += f"; {error.why}" if error.why else ""
        hint = "make the region larger, `apart` or the things smaller, or place fewer"
        sink.report("SC354", message, origin, hint=hint)
    except UnsupportedShapeError as error:
        sink.report("SC357", f"nothing can be placed beside {error}", origin)
    except MeshError as error:
        sink.report(error.code, error.message, origin, hint=error.hint)
    except ComputeLimitError as error:
        sink.report("SC609", error.message, origin, hint=COMPUTE_LIMIT_HINT)
    except DrawError as error:
        sink.report("SC515", f"in scene {error.scene}: {error.message}", origin)


def _pose(entity: Entity, frames: FrameGraph, batch: Batch) -> Floats:
    """The pose of an entity in all scenes, (N, 7): in the world, or relative to what is placed of it."""
    rows, there = rows_in(entity.scene_idxs, batch.scenes)
    root = frames.placed_root(entity.name)
    if root is None:
        return np.asarray(rows_of(entity.pose, rows), np.float64)
    found = np.tile(np.array(IDENTITY_POSE), (len(rows), 1))
    world: Any = frames.frame_pose(entity.name).world
    if world.__class__ in NODES:
        part = Batch(batch.scenes[there], batch.seed, batch.num_scenes, batch.draws, batch.given, batch.work)
        part.placed = {root: np.tile(np.array(IDENTITY_POSE), (batch.num_scenes, 1))}
        found[there] = part.evaluate(world)
    return found
