"""Expressions evaluated scene by scene, as Python computes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.values import columns
from scenecc.values.failure import DrawError, ExpressionError
from scenecc.values.operations import SEQUENCES, kind, unlike
from scenecc.values.work import of_expression, of_result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.values.evaluate import Batch
    from scenecc.values.nodes import Computed

_INT64 = 2**63


def compute(batch: Batch, node: Computed) -> NDArray[Any]:
    """What the expression gives in each scene (B, *shape)."""
    template, reads = node.template, dict(node.reads)
    names = sorted(template.names - {"num_scenes"})
    inputs = [_input(batch, reads.get(name, name) if name != "scene" else None) for name in names]
    environment: dict[str, Any] = {"num_scenes": batch.num_scenes, **dict(template.constants)}
    run = template.run
    results: list[Any] = []
    work = batch.work
    if work is not None:
        work.take(of_expression(template.text, len(batch.scenes) if inputs else 1), node)
    try:
        # What reads no draw is the same in every scene.
        for values in zip(*inputs, strict=True) if inputs else [()]:
            environment.update(zip(names, values, strict=True))
            result = run(environment)
            results.append(result)
            if work is not None and result.__class__ in SEQUENCES:
                work.take(of_result(result), node)
    except ExpressionError as error:
        scene = int(batch.scenes[len(results)])
        raise DrawError(error.message, scene, node, error) from error
    column = _column(batch, node, results)
    return column if inputs else np.broadcast_to(column, (len(batch.scenes), *column.shape[1:]))


def _input(batch: Batch, name: str | None) -> list[Any]:
    """The values of a shared draw, or the scenes' indices, as Python's own numbers and lists."""
    return (batch.scenes if name is None else batch.shared(name)).tolist()


def _column(batch: Batch, node: Computed, results: list[Any]) -> NDArray[Any]:
    if node.shape is None:
        return columns.kept(results)
    if node.shape == ():
        for row, result in enumerate(results):
            if type(result) in {list, tuple, dict}:
                raise _wrong(batch, node, row, f"it gives {kind(result)} where one value is wanted")
            if type(result) is int and not -_INT64 <= result < _INT64:
                raise _wrong(batch, node, row, "it gives an integer of more than 64 bits")
        return columns.table(results)
    return _lists(batch, node, results, node.shape)


def _lists(batch: Batch, node: Computed, results: list[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    for row, result in enumerate(results):
        wrong = unlike(result, shape, node.template.text)
        if wrong is not None:
            raise _wrong(batch, node, row, wrong)
    return np.array(results, dtype=np.float64).reshape(len(results), *shape)


def _wrong(batch: Batch, node: Computed, row: int, message: str) -> DrawError:
    return DrawError(message, int(batch.scenes[row]), node)
