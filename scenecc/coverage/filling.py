"""Numbers that fill ranges evenly, and the words that draw them."""

from __future__ import annotations

import math
import warnings
from importlib import import_module
from random import Random
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.variation.chosen import DrawSource, SceneUnits

_BELOW_ONE = 1.0 - 2.0**-53


def range_units(source: DrawSource, quantiles: Sequence[float]) -> SceneUnits:
    """Returns the words for which a range or a rotation has these quantiles, one for each of its words.

    The quantiles of a `beta` are those of its proposals (`docs/reference/draws.md`), the first of which is taken.
    """
    if source.distribution == "normal":
        # Box-Muller: the second word gives the sign.
        z = NormalDist().inv_cdf(min(max(quantiles[0], 2.0**-53), _BELOW_ONE))
        return [(0, source.word, -math.expm1(-z * z / 2)), (1, source.word, 0.0 if z >= 0 else 0.5)]
    found: SceneUnits = [(0, source.word + j, u) for j, u in enumerate(quantiles)]
    return [*found, (1, source.word, _BELOW_ONE)] if source.distribution == "beta" else found


def latin_quantiles(source: DrawSource, scenes: Sequence[int], attempts: Sequence[int]) -> dict[int, list[float]]:
    """Returns the quantiles of a range for each of some scenes, each in another of as many equal parts.

    Together, the ranges are a Latin hypercube. The order of the parts depends only on the draw's key and the number of
    scenes.

    Args:
        source: the range.
        scenes: the scenes that draw it.
        attempts: of each scene; above 0 its quantiles are random, since others failed.
    """
    found: dict[int, list[float]] = {scene: [] for scene in scenes}
    for word in range(source.word, source.word + source.words):
        parts = list(range(len(scenes)))
        Random(f"{source.key} {word} {len(scenes)}").shuffle(parts)  # noqa: S311 - the same at every run
        for scene, attempt, part in zip(scenes, attempts, parts, strict=True):
            other = Random(f"{source.key} {word} {scene} {attempt}").random()  # noqa: S311 - see above
            found[scene].append(other if attempt else (part + 0.5) / len(scenes))
    return found


def sobol_points(dimensions: int, count: int) -> list[list[float]]:
    """Returns scrambled Sobol points (count, dimensions) in [0, 1), the same at every call.

    Raises:
        ImportError: scipy is not installed.
    """
    qmc: Any = import_module("scipy.stats.qmc")

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a number of points that is not a power of two is noted by the caller
        points = qmc.Sobol(dimensions, scramble=True, seed=0).random(count)
    return points.clip(0.0, _BELOW_ONE).tolist()
