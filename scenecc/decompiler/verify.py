"""Builds a decompiled scene file and compares the result with the live scene, object by object."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final

import numpy as np

from scenecc.backends.sapien.engine import physx
from scenecc.decompiler.bodies import flat_grid
from scenecc.decompiler.reading import LiveObject, Numbers, Plain, comparable_value, read_scene
from scenecc.decompiler.values import SEEN_TOLERANCE
from scenecc.diagnostics import Sink
from scenecc.geometry.rotations import IDENTITY_POSE, compose, rotate, to_pose
from scenecc.source import read_text


def differences(
    a: LiveObject,
    b: LiveObject,
    *,
    without: Collection[str] = (),
    tolerance: Callable[[LiveObject], float] = lambda _: 0.0,
) -> list[str]:
    """Compares two trees; returns one line per difference, with the object's path, the property and both values.

    Numbers must have the same bits, except for the sign of zero. Objects are compared in order; an object on one side
    only is one line.

    Args:
        a: a scene, an entity or any object in it.
        b: the expected tree.
        without: properties to skip, as `PROPERTY` or `KIND.PROPERTY`; `name` is one.
        tolerance: returns the largest difference of numbers in an object that counts as equal.
    """
    return list(_list_differences(_label(a), a, b, frozenset(without), tolerance))


def _list_differences(
    where: str, a: LiveObject, b: LiveObject, without: frozenset[str], tolerance: Callable[[LiveObject], float]
) -> Iterator[str]:
    if a.kind != b.kind:
        yield f"{where}: {a.kind} against {b.kind}"
        return
    if a.name != b.name and not _is_skipped(a.kind, "name", without):
        yield f"{where}.name: {a.name!r} against {b.name!r}"
    left, right = dict(a.values), dict(b.values)
    for name in dict.fromkeys((*left, *right)):
        if _is_skipped(a.kind, name, without):
            continue
        if name not in left or name not in right:
            yield f"{where}.{name}: only in the {'second' if name not in left else 'first'}"
        elif left[name] != right[name] and not _is_near(left[name], right[name], tolerance(a)):
            yield f"{where}.{name}: {_describe_change(left[name], right[name])}"
    yield from _parts(where, a.parts, b.parts, without, tolerance)


def _parts(
    where: str,
    a: tuple[LiveObject, ...],
    b: tuple[LiveObject, ...],
    without: frozenset[str],
    tolerance: Callable[[LiveObject], float],
) -> Iterator[str]:
    by_kind: dict[str, tuple[list[LiveObject], list[LiveObject]]] = {}
    for side, parts in enumerate((a, b)):
        for part in parts:
            by_kind.setdefault(_sort(part), ([], []))[side].append(part)
    for left, right in by_kind.values():
        for number, (x, y) in enumerate(_pair_parts(left, right)):
            if x is None or y is None:
                extra = x or y
                assert extra is not None
                yield f"{where}/{_label(extra, number)}: only in the {'first' if y is None else 'second'}"
            else:
                yield from _list_differences(f"{where}/{_label(x, number)}", x, y, without, tolerance)


def _is_near(a: Plain, b: Plain, tolerance: float) -> bool:
    if not tolerance or not isinstance(a, Numbers) or not isinstance(b, Numbers) or a.shape != b.shape:
        return False
    return "f" in a.dtype and bool((np.abs(a.array().astype(np.float64) - b.array()) <= tolerance).all())


def _sort(part: LiveObject) -> str:
    """Returns the list that a part is compared in: shapes and components share one, since their order matters."""
    return part.kind if part.kind in {"entity", "articulation", "joint", "material", "part"} else "ordered"


def _pair_parts(
    left: list[LiveObject], right: list[LiveObject]
) -> Iterator[tuple[LiveObject | None, LiveObject | None]]:
    """Pairs by position; if the lengths differ, by common names, so that each extra object is reported once."""
    sides = [part.name for part in left], [part.name for part in right]
    shared = set(sides[0]) & set(sides[1])
    if len(left) == len(right) or not shared or any(len(set(side)) < len(side) for side in sides):
        yield from zip_longest(left, right)
        return
    yield from zip([x for x in left if x.name in shared], [y for y in right if y.name in shared], strict=True)
    yield from ((x, None) for x in left if x.name not in shared)
    yield from ((None, y) for y in right if y.name not in shared)


def _is_skipped(kind: str, name: str, without: frozenset[str]) -> bool:
    return name in without or f"{kind}.{name}" in without


def _label(facts: LiveObject, number: int = 0) -> str:
    return f"{facts.kind}({facts.name})" if facts.name else f"{facts.kind}[{number}]"


def _describe_change(a: Plain, b: Plain) -> str:
    if isinstance(a, Numbers) and isinstance(b, Numbers) and a.shape == b.shape and a.array().size > 16:
        x, y = a.array(), b.array()
        unequal = (x != y) & ~(np.isnan(x) & np.isnan(y))
        if unequal.any():
            first = tuple(int(axis[0]) for axis in unequal.nonzero())
            return f"{int(unequal.sum())} of {x.size} numbers, first at {list(first)}: {x[first]} against {y[first]}"
    return f"{_format_value(a)} against {_format_value(b)}"


def _format_value(value: Plain) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_format_value(item) for item in value) + "]"
    return str(value) if isinstance(value, Numbers) else repr(value)


_SEEN: Final = ("Render", "material", "part")
"""Kinds of visual objects, for which the last bits of a pose do not matter."""


def rebuilt_differences(document: Mapping[str, Any], base: Path, live: list[LiveObject], *, render: bool) -> list[str]:
    """Builds a document and returns one line per difference from live scenes; empty if all is equal.

    Args:
        document: the scene file as plain data.
        base: folder of its relative paths.
        live: the scenes as read before, with the document's names, by index.
        render: whether visuals, lights and cameras were read.

    Raises:
        SceneError: the document does not build.
    """
    import scenecc  # noqa: PLC0415 - the facade is above this module's other users
    from scenecc.scene_file.layout import scene_text  # noqa: PLC0415 - as above

    # Parsed as if located in the base folder, for its relative paths; nothing is written.
    sink = Sink()
    file = read_text(scene_text(document), "scene.yaml", sink, path=base.absolute() / "scene.yaml")
    if file is None:
        raise scenecc.SceneError(sink.diagnostics())
    with default_engine_settings(), scenecc.load_scene(file, render=render, allow_outside_assets=True) as batch:
        found = [read_scene(scene) for scene in batch.scenes]
    lines: list[str] = []
    for index, (first, second) in enumerate(zip(live, found, strict=True)):
        changes = differences(tidy(first), tidy(second), tolerance=_tolerance)
        lines += changes if len(live) == 1 else [f"scene {index}: {line}" for line in changes]
    return lines


@contextmanager
def default_engine_settings() -> Generator[None]:
    """Resets the engine's process-wide settings to SAPIEN's defaults, and restores them afterwards."""
    kinds = ("scene", "shape", "body", "sdf")
    before = {kind: getattr(physx, f"get_{kind}_config")() for kind in kinds}
    material = physx.get_default_material()
    friction = (material.static_friction, material.dynamic_friction, material.restitution)
    classes = {"scene": "Scene", "shape": "Shape", "body": "Body", "sdf": "SDF"}
    try:
        for kind in kinds:
            getattr(physx, f"set_{kind}_config")(getattr(physx, f"Physx{classes[kind]}Config")())
        physx.set_default_material(0.3, 0.3, 0.1)
        yield
    finally:
        for kind, config in before.items():
            getattr(physx, f"set_{kind}_config")(config)
        physx.set_default_material(*friction)


def tidy(facts: LiveObject) -> LiveObject:
    """Removes irrelevant details: the order of an entity's components, settings of disabled shadows, how a camera's
    pose is split between entity and component, the tessellation of a flat floor, and whether a driven joint counts
    turns.
    """
    facts = _move_pose_to_entity(facts) if _is_visual_only(facts) else _grid_size(facts)
    if facts.kind.startswith("RenderShape"):
        facts = _normalize_pose(facts)
    # Entities without components have no content; a visual-only entity leaves one if nothing is rendered.
    parts = tuple(tidy(part) for part in facts.parts if part.kind != "entity" or part.parts)
    if facts.kind == "joint" and facts.value("type") == "revolute" and dict(facts.values).get("stiffness"):
        # The file builds it so if it can turn beyond 2π; below, both are equal to the bit.
        facts = replace(facts, values=(("type", "revolute_unwrapped"), *facts.values[1:]))
    if facts.kind == "entity":
        parts = tuple(sorted(parts, key=lambda part: part.kind))
    if facts.kind == "scene":
        # Lights and cameras are built last; their position among bodies is irrelevant.
        parts = tuple(sorted(parts, key=_is_visual_only))
    values = facts.values
    if ("shadow", False) in values:
        values = tuple((name, value) for name, value in values if not name.startswith("shadow_"))
    # Components have their own names, which nothing refers to.
    unnamed = facts.kind.startswith(("Physx", "RenderBody")) or "Light" in facts.kind or "Camera" in facts.kind
    name = "" if unnamed or _is_visual_only(facts) else facts.name
    return replace(facts, name=name, values=values, parts=parts)


def _normalize_pose(facts: LiveObject) -> LiveObject:
    """Normalizes a visual shape's rotation and file path."""
    pose = _array(facts, "local_pose").astype(np.float64)
    pose[3:] /= np.linalg.norm(pose[3:])
    _normalize_sign(pose)
    values = dict(facts.values)
    file = values.get("filename")
    path = {"filename": os.path.normpath(file)} if isinstance(file, str) and file else {}
    return _with_values(facts, local_pose=comparable_value(pose), **path)


def _move_pose_to_entity(facts: LiveObject) -> LiveObject:
    """Moves the local pose of a light's or camera's component to its entity."""
    (part,) = facts.parts[:1]
    if part.kind == "entity" or "local_pose" not in dict(part.values):
        return facts
    outer, inner = (to_pose(_array(each, key)) for each, key in ((facts, "pose"), (part, "local_pose")))
    moved = _with_values(part, local_pose=comparable_value(np.array(IDENTITY_POSE)))
    pose = np.array(compose(outer, inner))
    _normalize_sign(pose)
    return _with_values(replace(facts, parts=(moved, *facts.parts[1:])), pose=comparable_value(pose))


def _normalize_sign(pose: Any) -> None:
    """Chooses between the two quaternions of a rotation: the first number not near 0 is positive."""
    pose[3:] *= np.sign(next(number for number in pose[3:] if abs(number) > _NEAR_ZERO))


_NEAR_ZERO: Final = 1e-3


def _grid_size(facts: LiveObject) -> LiveObject:
    """Replaces a flat floor's mesh by its size; other meshes are unchanged."""
    if facts.kind != "RenderShapeTriangleMesh" or len(facts.parts) != 1:
        return facts
    (part,) = facts.parts
    vertices = _array(part, "vertices")
    grid = flat_grid(vertices, _array(part, "uvs"))
    if grid is None:
        return facts
    low, high, uv_low, uv_high = grid
    pose = _array(facts, "local_pose").astype(np.float64)
    pose[:3] += rotate(to_pose(pose)[3:], (*((low + high) / 2).tolist(), float(vertices[0, 2])))
    size = (("size", comparable_value(high - low)), ("repeat", comparable_value(uv_high - uv_low)))
    return replace(_with_values(facts, local_pose=comparable_value(pose)), parts=(replace(part, values=size),))


def _array(facts: LiveObject, name: str) -> Any:
    value = facts.value(name)
    assert isinstance(value, Numbers)
    return value.array()


def _with_values(facts: LiveObject, **changed: Plain) -> LiveObject:
    return replace(facts, values=tuple((name, changed.get(name, value)) for name, value in facts.values))


def _tolerance(facts: LiveObject) -> float:
    return 4 * SEEN_TOLERANCE if facts.kind.startswith(_SEEN) or _is_visual_only(facts) else 0.0


def _is_visual_only(facts: LiveObject) -> bool:
    return (
        facts.kind == "entity"
        and bool(facts.parts)
        and all("Light" in part.kind or "Camera" in part.kind for part in facts.parts)
    )
