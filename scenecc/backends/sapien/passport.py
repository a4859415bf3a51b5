"""Passports: a line of JSON from which `scenecc replay` rebuilds a scene's initial state and reports differences."""

from __future__ import annotations

import json
import platform
import sys
from bisect import bisect_left
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from scenecc.plan.geometry import ConvexParts
from scenecc.version import VERSION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from scenecc.backends.sapien.drawn_fields import DrawnFieldSet, FieldWrite
    from scenecc.backends.sapien.reset import ResetSampler
    from scenecc.backends.sapien.state import AnyState
    from scenecc.plan import ScenePlan
    from scenecc.source.provenance import Provenance
    from scenecc.variation.evaluation import Batch

PASSPORT_VERSION: Final = 1

HASH_LENGTH: Final = 32
"""Hexadecimal digits of a SHA-256 in a passport. 128 bits distinguish files and keep the text short."""


class Sampled(NamedTuple):
    """The initial states of some scenes: states of entities, all other values that a reset draws, and the batch that
    drew them.
    """

    states: Mapping[str, AnyState]
    writes: Sequence[FieldWrite]
    drawing: Batch


@dataclass(frozen=True)
class Start:
    """The inputs of the draws for the initial state of a scene.

    Attributes:
        seed: of the build or the reset.
        draws: values that replaced shared draws: name → the scene's row.
        sampled: what was drawn, for the scenes that were reset together. None: nothing yet.
    """

    seed: int
    draws: Mapping[str, Any]
    sampled: Sampled | None = field(default=None, compare=False, repr=False)


class Passport:
    """The passport of an initial state of a scene. `str` writes the text when it is first needed."""

    def __init__(self, write: Callable[[], str]) -> None:
        self._write = write

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<passport {self._text}>"

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        return str, (self._text,)  # a copy or a pickle is the text

    @cached_property
    def _text(self) -> str:
        return self._write()


class PassportWriter:
    """Remembers the inputs of each scene's last reset, and writes passports.

    Attributes:
        provenance: what the batch was built from. None: no passport can be written.
    """

    def __init__(self, plan: ScenePlan) -> None:
        self._plan = plan
        self._starts: dict[int, Start] = {}
        self.provenance: Provenance | None = None

    def note_reset(
        self, scene_idxs: Sequence[int], seeds: Sequence[int], draws: Mapping[str, Any] | None, sampled: Sampled
    ) -> None:
        """Records a reset. Call it afterwards. `seeds`, `draws`: one row for each of these scenes."""
        rows = {name: np.asarray(values).tolist() for name, values in (draws or {}).items()}
        for number, (index, seed) in enumerate(zip(scene_idxs, seeds, strict=True)):
            self._starts[index] = Start(seed, {name: values[number] for name, values in rows.items()}, sampled)

    @cached_property
    def _versions(self) -> dict[str, str]:
        return build_versions(self._plan)

    def start(self, index: int) -> Start:
        """Returns the last start of a scene."""
        return self._starts.get(index) or Start(self._plan.seed, {})

    def drawings(self, scene_idxs: Iterable[int]) -> list[Batch | None]:
        """Returns the batches that the last resets of some scenes drew from. None: the scene is as built."""
        starts = map(self.start, scene_idxs)
        return [None if one.sampled is None else one.sampled.drawing for one in starts]

    def text(self, index: int, start: Start, sampler: ResetSampler, fields: DrawnFieldSet) -> str:
        """Returns the passport of a scene at a start.

        Raises:
            ValueError: the batch was built from a plan object, without a file.
            OSError: a file of the scene cannot be read, or has changed since it was compiled.
        """
        known = self.provenance
        if known is None:
            raise ValueError("a batch built from a plan object has no passport: build it from the scene file")
        plan = self._plan
        again = start != Start(plan.seed, {})
        draws = {name: np.asarray(rows)[index].tolist() for name, rows in known.draws.items()}
        content = {
            "scenecc_passport": PASSPORT_VERSION,
            "file": known.file,
            "sha256": known.source_hash[:HASH_LENGTH],
            "files": {name: digest[:HASH_LENGTH] for name, digest in known.file_hashes.items()},
            "params": known.params,
            "defaults": known.defaults,
            "draws": draws,
            "num_scenes": plan.num_scenes,
            "scene": index,
            "seed": plan.seed,
            "reset": {"seed": start.seed, "draws": start.draws} if again else None,
            "versions": self._versions,
            "state": start_hash(index, start, sampler, fields),
        }
        return json.dumps({key: value for key, value in content.items() if value not in ({}, None)})


def start_hash(index: int, start: Start, sampler: ResetSampler, fields: DrawnFieldSet) -> str:
    """Returns a hash of `SceneBatch.state` for the initial state of a scene, without visual fields.

    The start is sampled again, because the engine may have simulated since. Each array is
    hashed by name in float32 and is independent of the other scenes of the batch.
    """
    states, writes, _ = start.sampled or _sample(index, start, sampler, fields)
    rows: dict[tuple[str, str], Any] = {}
    for name, state in states.items():
        row = bisect_left(state.scene_idxs, index)
        if state.scene_idxs[row : row + 1] == (index,):
            rows |= {(name, array): getattr(state, array)[row] for array in state.WIDTHS}
    for write in writes:
        if index in write.scenes and not write.field.is_visual:
            rows["drawn", write.field.key] = write.rows[write.scenes.index(index)]
    digest = sha256()
    for key in sorted(rows):
        numbers = np.asarray(rows[key], "<f4").ravel()
        numbers = numbers[~np.isnan(numbers)]  # without the columns of joints that only other scenes have
        digest.update(json.dumps([*key, len(numbers)]).encode())
        digest.update(numbers.tobytes())
    return digest.hexdigest()[:HASH_LENGTH]


def _sample(index: int, start: Start, sampler: ResetSampler, fields: DrawnFieldSet) -> Sampled:
    drawing = sampler.batch((index,), (start.seed,), {name: [row] for name, row in start.draws.items()})
    return Sampled(sampler.drawn(drawing), fields.draw(drawing), drawing)


def build_versions(plan: ScenePlan) -> dict[str, str]:
    """Returns what determines the bits of a build besides files: versions of programs, platform and C library."""
    found = {
        "scenecc": VERSION,
        "sapien": _version("sapien"),
        "numpy": np.__version__,
        "python": ".".join(map(str, sys.version_info[:2])),
        "platform": f"{platform.system()} {platform.machine()}",
    }
    for file in plan.files:
        if file.read_by is not None:
            name, _, number = file.read_by.partition(" ")
            found[name] = number
        if file.path.suffix.lower() == ".dae":
            found["pycollada"] = _version("pycollada")
    shapes = (shape.geometry for entity in plan.entities for body in entity.bodies for shape in body.collisions)
    if any(isinstance(geometry, ConvexParts) and geometry.coacd is not None for geometry in shapes):
        found |= {package: _version(package) for package in ("coacd", "trimesh")}
    return found


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
