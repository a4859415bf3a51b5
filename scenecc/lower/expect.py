"""Lowers expectations: resolves names and selects scenes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.fields import fields_of
from scenecc.lower.mounts import MountLookup
from scenecc.lower.value_checks import report_draw_failure
from scenecc.plan import BodyStructure
from scenecc.plan.expect import BodyPair, Condition, Expectation, NoOverlap, Reading, Settled
from scenecc.plan.scene import find_body, has_joint
from scenecc.spec.references import NameScopes, qualified_name, resolve_scene_idxs
from scenecc.variation.forms import Template
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Container, Iterator, Mapping, Sequence

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan import Entity
    from scenecc.spec.expect import ConditionSpec, ExpectSpec, NoOverlapSpec, SettledSpec


def lower_expectations(
    expect: ExpectSpec | Mapping[str, ExpectSpec],
    entities: tuple[Entity, ...],
    unread: Container[str],
    sampling: SamplingContext,
    names: NameScopes,
    selections: Mapping[str, tuple[int, ...]],
    origin: Origin,
) -> tuple[Expectation, ...]:
    """Lowers the expectations of a document, in order.

    Args:
        expect: from the model; in an expanded document, the parts by name.
        entities: all entities of the plan.
        unread: see `MountLookup`.
        sampling: of the document.
        names: resolves names.
        selections: the scenes of instances that are in some scenes only.
        origin: of `expect`.
    """
    if not isinstance(expect, dict):
        return tuple(_PartLowerer("", entities, unread, sampling, names, sampling.all_scenes).lower(expect, origin))  # pyright: ignore[reportArgumentType]
    found: list[Expectation] = []
    used: set[str] = set()
    for part, spec in expect.items():
        key = qualified_name("expect", part)
        scenes = selections.get(key, sampling.all_scenes)
        lowerer = _PartLowerer(names.scopes.get(key, ""), entities, unread, sampling, names, scenes)
        for one in lowerer.lower(spec, origin.child(part)):
            name, number = one.name, 2
            while name in used:
                name, number = f"{one.name}.{number}", number + 1
            used.add(name)
            found.append(one if name == one.name else _with_name(one, name))
    return tuple(found)


def _with_name(one: Expectation, name: str) -> Expectation:
    from dataclasses import replace  # noqa: PLC0415 - files that are included seldom expect anything

    return replace(one, name=name)


class _PartLowerer:
    """Lowers the expectations of one file, or of one instance.

    Args:
        scope: of the instance; "" for the document.
        entities: all entities of the plan.
        unread: see `MountLookup`.
        sampling: of the document.
        names: resolves names.
        scenes: of the instance.
    """

    def __init__(
        self,
        scope: str,
        entities: tuple[Entity, ...],
        unread: Container[str],
        sampling: SamplingContext,
        names: NameScopes,
        scenes: tuple[int, ...],
    ) -> None:
        self._scope = scope
        self._entities = {entity.name: entity for entity in entities}
        self._sampling = sampling
        self._names = names
        self._scenes = scenes
        self._mounts = MountLookup(entities, unread, names, sampling.sink)

    def lower(self, spec: ExpectSpec, origin: Origin) -> Iterator[Expectation]:
        """Lowers all expectations. Reports errors."""
        prefix = f"{self._scope}/" if self._scope else ""
        inside = self._inside()
        if spec.settled is not None:
            yield self._lower_settled(spec.settled, f"{prefix}settled", inside, origin.child("settled"))
        if spec.no_overlap is not None:
            yield self._no_overlap(spec.no_overlap, f"{prefix}no_overlap", inside, origin.child("no_overlap"))
        for number, one in enumerate(spec.holds):
            condition = self._condition(one, f"{prefix}holds[{number}]", origin.child("holds", number))
            if condition is not None:
                yield condition

    def _inside(self) -> tuple[str, ...] | None:
        """The entities of the instance; None: all entities."""
        if not self._scope:
            return None
        scopes = ((name, self._names.scopes.get(name, "")) for name in self._entities)
        return tuple(name for name, scope in scopes if f"{scope}/".startswith(f"{self._scope}/"))

    def _lower_settled(self, spec: SettledSpec, name: str, inside: tuple[str, ...] | None, origin: Origin) -> Settled:
        excepted: list[str] = []
        for number, written in enumerate(spec.except_):
            place = origin.child("except", number)
            full = self._body(written, place)
            if full is not None and full not in self._entities:
                self._sampling.sink.report("SC303", f"`{cut(written)}` is a link, but an entity is needed", place)
            elif full is not None and not any(map(_moves, self._entities[full].structures)):
                hint = "leave it out"
                self._sampling.sink.report("SC863", f"`{cut(written)}` cannot move", place, hint=hint)
            excepted.append(full or written)
        return Settled(name, spec.seconds, spec.within, math.radians(spec.within_deg), inside, tuple(excepted), origin)

    def _no_overlap(self, spec: NoOverlapSpec, name: str, inside: tuple[str, ...] | None, origin: Origin) -> NoOverlap:
        pairs: list[BodyPair] = []
        for number, written in enumerate(spec.except_):
            place = origin.child("except", number)
            a, b = (self._body(one, place.child(side)) or one for side, one in enumerate(written))
            pairs.append(BodyPair(a, b))
        return NoOverlap(name, spec.deeper_than, inside, tuple(pairs), origin)

    def _condition(self, spec: ConditionSpec, name: str, origin: Origin) -> Condition | None:
        sampling = self._sampling
        scenes: tuple[int, ...] | None = self._scenes
        if spec.scene_idxs is not None:
            place = origin.child("scene_idxs")
            scenes = resolve_scene_idxs(spec.scene_idxs, sampling.num_scenes, place, sampling.sink)
            among = frozenset(self._scenes)
            scenes = scenes and tuple(scene for scene in scenes if scene in among)
        if not scenes:
            return None
        place = origin.child("that")
        that: Any = spec.that
        if not isinstance(that, Template):
            that = Template("${true}" if that else "${false}")
        draws = fields_of(sampling, scope=self._scope).draw_names(that, place)
        if draws is None:
            return None
        for draw in draws.values():
            self._check_draw(draw, scenes, place)
        readings = [Reading(one, "draw", (full,)) for one, full in draws.items()]
        for written, (function, *arguments) in that.observations.items():
            span = that.place(written)
            spans = [_part_span(written, one, span) for one in arguments]
            names = self._resolve_names(function, arguments, scenes, place, spans)
            readings.append(Reading(written, function, names))  # pyright: ignore[reportArgumentType]
        return Condition(name, scenes, spec.after, that.within(None), spec.because, tuple(readings), origin)

    def _check_draw(self, name: str, scenes: tuple[int, ...], place: Origin) -> None:
        """Reports a shared draw without a value in a scene of the condition at `place`."""
        try:
            self._sampling.batch(scenes).shared(name)
        except DrawError as error:
            report_draw_failure(error, place, self._sampling)

    def _resolve_names(
        self,
        function: str,
        arguments: list[str],
        scenes: tuple[int, ...],
        place: Origin,
        spans: Sequence[tuple[int, int]],
    ) -> tuple[str, ...]:
        """The full names of an observed quantity's objects. Reports unknown names. `spans`: of the arguments."""
        bodies, joints = (arguments[:1], arguments[1:]) if function == "qpos" else (arguments, [])
        full = tuple(self._body(body, place, scenes, span) or body for body, span in zip(bodies, spans, strict=False))
        for joint, span in zip(joints, spans[len(bodies) :], strict=True):
            found = find_body(full[0], self._entities)
            if found is not None and not has_joint(found[0], joint):
                known = [
                    link.joint.name
                    for structure in found[0].structures
                    if not isinstance(structure, BodyStructure)
                    for link in structure.links
                    if link.joint is not None and link.joint.type != "fixed"
                ]
                sink = self._sampling.sink
                message = f"`{cut(bodies[0])}` has no moving joint `{cut(joint)}`"
                sink.report("SC325", message, place, hint=suggest_name(joint, known, sink), span=span)
        return (*full, *joints)

    def _body(
        self, written: str, place: Origin, scenes: tuple[int, ...] = (), span: tuple[int, int] | None = None
    ) -> str | None:
        """The full name of an entity or ENTITY/LINK that exists in some of the scenes; None after an error."""
        mount = self._mounts.find(written, self._scope, (), place, span=span)
        if mount is None:
            return None
        entity = self._entities[mount.entity]
        if scenes and set(scenes).isdisjoint(entity.scene_idxs):
            message = f"`{cut(written)}` does not exist in any of these scenes"
            hint = "set `scene_idxs` to the scenes in which this must hold"
            self._sampling.sink.report("SC311", message, place, hint=hint, span=span)
            return None
        full = self._names.full_name(written, self._scope)
        return entity.name if full == entity.name else str(mount)


def _moves(structure: Any) -> bool:
    """Whether a simulation moves a body, or the root of an articulation."""
    return structure.body_type == "dynamic" if isinstance(structure, BodyStructure) else not structure.fix_root_link


def _part_span(call: str, part: str, span: tuple[int, int]) -> tuple[int, int]:
    """Returns the span of a quoted argument in a text, from the call and the call's own span."""
    at = max(call.find(f"'{part}'"), call.find(f'"{part}"'))
    if at < 0 or span[1] - span[0] != len(call):
        return span
    return span[0] + at + 1, span[0] + at + 1 + len(part)
