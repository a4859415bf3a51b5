"""Assembles articulations with attached parts: joins drafts of several files and trees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.articulations.drafts import AttachedPart, DraftJoint
from scenecc.lower.local_poses import local_pose
from scenecc.plan.articulation import MAX_LINKS
from scenecc.robots.ignored_sets import MAX_SETS, Pairs, cover_pairs, order_pair, symmetric

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.geometry.rotations import Pose7
    from scenecc.lower.articulations.drafts import Alternative, ArticulationDraft, DraftLink, LinkTreeDrafter
    from scenecc.lower.fields import FieldLowerer
    from scenecc.robots.description import DescribedConstraint


@dataclass(frozen=True, slots=True)
class Assembly:
    """An articulation with its parts.

    Attributes:
        draft: of the articulation.
        constraints: of its files; their roots are called "".
        pose: of its root in the frame of its file.
    """

    draft: ArticulationDraft
    constraints: tuple[DescribedConstraint, ...] = ()
    pose: Pose7 = IDENTITY_POSE


FileDrafter = Callable[[Any, "Origin", "Alternative"], Assembly | None]
"""Makes a draft of the only articulation in a file; None after an error."""


class ArticulationAssembler:
    """Joins an articulation and its parts to one draft.

    Args:
        trees: makes drafts of trees.
        files: makes drafts of files.
        fields: of the entity.
        sink: receives the diagnostics.
    """

    def __init__(self, trees: LinkTreeDrafter, files: FileDrafter, fields: FieldLowerer, sink: Sink) -> None:
        self._trees = trees
        self._files = files
        self._fields = fields
        self._sink = sink
        # Several alternatives share a node, which is lowered once.
        self._known: dict[tuple[int, tuple[Any, ...]], Assembly | None] = {}
        self._joints: dict[int, DraftJoint] = {}

    def assemble(self, keys: Any, origin: Origin, one: Alternative) -> Assembly | None:
        """Assembles an articulation or a part with all its attachments; None after an error.

        Args:
            keys: as written.
            origin: of the articulation or part.
            one: the alternative.
        """
        made = self._own(keys, origin, one)
        good = made is not None and self._follows_own(made.draft)
        if keys.attach:
            good &= self._is_by_name(keys, origin)
        # An error in a part is not reported again for its attachments.
        missing: list[str] = []
        for name, part in keys.attach.items():
            place = origin.child("attach", name)
            if part.fix_root_link is not None:
                message = "`fix_root_link` of a part is ignored: its root is attached to `to`"
                self._sink.report("SC337", message, place.child("fix_root_link"), at="key")
            added = self.assemble(part, place, one.parts[name])
            whole = None
            if made is not None and added is not None and not any(map(part.to.startswith, missing)):
                whole = self._attach_part(made, added, part, name, place)
            if whole is None:
                good = False
                missing += filter(None, (_prefix(name, part),))
            made = whole or made
        return made if good else None

    def _own(self, keys: Any, origin: Origin, one: Alternative) -> Assembly | None:
        known = (id(keys), tuple(one.values.items()))
        if known not in self._known:
            if "root" in keys.model_fields_set:
                self._known[known] = Assembly(self._trees.draft(keys.root, origin.child("root"), self._fields))
            else:
                self._known[known] = _with_files(self._files(keys, origin, one))
        return self._known[known]

    def _follows_own(self, draft: ArticulationDraft) -> bool:
        """Whether joints follow only joints of the same file or tree; otherwise reports it."""
        good, joints = True, set(_joint_names(draft.links))
        for link in draft.links:
            mimic = None if link.joint is None else link.joint.mimic
            if link.joint is not None and mimic is not None and mimic.source not in joints:
                message = (
                    f"`{cut(link.joint.name)}` follows `{cut(mimic.source)}`, which is not a joint of the same part"
                )
                hint = suggest_name(mimic.source, sorted(joints), self._sink)
                self._sink.report("SC521", message, mimic.origin, hint=hint)
                good = False
        return good

    def _is_by_name(self, keys: Any, origin: Origin) -> bool:
        """Whether joint positions are given by name if there are parts; otherwise reports it."""
        good = True
        for key in ("qpos", "qvel"):
            written = getattr(keys, key, None)
            if written is not None and written.__class__ is not dict:
                message = f"`{key}` must be a mapping by joint name if there is `attach`"
                hint = f"`{key}: {{JOINT: 0.1, PART/JOINT: 0.2}}`: the order of a list changes with the parts"
                self._sink.report("SC325", message, origin.child(key), hint=hint)
                good = False
        return good

    def _attach_part(self, whole: Assembly, made: Assembly, part: Any, name: str, place: Origin) -> Assembly | None:
        """Attaches one more part; None after an error."""
        draft, added = whole.draft, made.draft
        to = self._number(draft, part.to, place.child("to"))
        ignored = [self._number(draft, one, place.child("ignore", i)) for i, one in enumerate(part.ignore)]
        prefix = _prefix(name, part)
        start, shift = len(draft.links), _bit_count(draft.links)
        root = replace(added.links[0], joint=self._joint(part, place))
        added = replace(added, links=(root, *added.links[1:]))
        links = tuple(_rename_link(link, prefix, to or 0, start, shift) for link in added.links)
        known = {constraint.name for constraint in whole.constraints}
        constraints = tuple(_rename_constraint(one, prefix) for one in made.constraints)
        double = next((one.name for one in constraints if one.name in known), None)
        unique = self._is_unique(draft.links, links, place) if double is None else self._report_double(double, place)
        if to is None or None in ignored or not unique:
            return None
        nested = (replace(one, prefix=prefix + one.prefix, start=start + one.start) for one in added.parts)
        joined = replace(
            draft,
            links=(*draft.links, *links),
            ignored={**draft.ignored, **{bit + shift: written for bit, written in added.ignored.items()}},
            parts=(*draft.parts, AttachedPart(part, place, added, prefix, start), *nested),
        )
        distinct = self._with_bits(joined, start, [one for one in ignored if one is not None], place)
        return distinct and replace(whole, draft=distinct, constraints=(*whole.constraints, *constraints))

    def _number(self, draft: ArticulationDraft, name: str, place: Origin) -> int | None:
        """The number of a link; None if there is none, which is reported."""
        names = [link.name for link in draft.links]
        if name in names:
            return names.index(name)
        hint = suggest_name(name, names, self._sink)
        message = f"this is attached to an articulation without the link `{cut(name)}`"
        self._sink.report("SC331", message, place, hint=hint)
        return None

    def _joint(self, part: Any, place: Origin) -> DraftJoint:
        """Makes the joint between a part and its parent link."""
        known = self._joints.get(id(part))
        if known is None:
            if part.joint is None:
                pose = None
                if part.pose is not None:
                    pose = local_pose(part.pose, place, ("pose",), "a part", self._fields)
                known = DraftJoint("fixed", "", place, pose)
            else:
                known = self._trees.joint(part.joint, place.child("joint"), self._fields)
                if known.mimic is not None:
                    message = "the joint of a part cannot follow another joint"
                    hint = "remove `mimic`, and drive both joints"
                    self._sink.report("SC521", message, known.mimic.origin, hint=hint)
            self._joints[id(part)] = known
        return known

    def _is_unique(self, links: Sequence[DraftLink], added: Sequence[DraftLink], place: Origin) -> bool:
        """Whether all link and joint names are unique; otherwise reports it."""
        if len(links) + len(added) > MAX_LINKS:
            message = f"with this part there are {len(links) + len(added)} links, and PhysX holds {MAX_LINKS}"
            hint = "merge links that are fixed to one another"
            self._sink.report("SC519", message, place, at="key", hint=hint)
            return False
        for names in (_link_names, _joint_names):
            known = set(names(links))
            double = next((name for name in names(added) if name in known), None)
            if double is not None:
                return self._report_double(double, place)
        return True

    def _report_double(self, name: str, place: Origin) -> bool:
        hint = "give the part another `prefix`, or remove `prefix`"
        message = f"`{cut(name)}` is already the name of a link, joint or constraint of the articulation"
        self._sink.report("SC326", message, place, at="key", hint=hint)
        return False

    def _with_bits(
        self, joined: ArticulationDraft, start: int, ignored: Sequence[int], place: Origin
    ) -> ArticulationDraft | None:
        """Adds bits for the pairs of `ignore`; None if there are too few bits."""
        links, first = joined.links, _bit_count(joined.links)
        if not ignored and first <= MAX_SETS:
            return joined
        added = {
            (one, number)
            for one in ignored
            for number in range(start, len(links))
            if links[one].collides and links[number].collides
        }
        wanted, apart = _pairs(links)
        free = symmetric(added | apart, len(links))
        # Pairs with a bit and pairs that never collide need no more.
        sets = cover_pairs(added - apart, free)
        if first + len(sets) > MAX_SETS:
            sets, first = cover_pairs((wanted | added) - _next_to(links), free), 0
            links = tuple(replace(link, ignore_bits=0) for link in links)
            joined = replace(joined, ignored={})
        if len(sets) > MAX_SETS:
            message = f"links that ignore one another need {len(sets)} bits with this part, and SAPIEN has {MAX_SETS}"
            hint = "remove pairs that never touch, or write `disable_self_collisions: true` with `srdf: none`"
            self._sink.report("SC336", message, place, at="key", hint=hint)
            return None
        bits = [0] * len(links)
        for bit, together in enumerate(sets, first):
            for number in together:
                bits[number] |= 1 << bit
        whole = tuple(
            replace(link, ignore_bits=link.ignore_bits | more) if more else link
            for link, more in zip(links, bits, strict=True)
        )
        here = dict.fromkeys(range(first, first + len(sets)), place.child("ignore")) if first else {}
        return replace(joined, links=whole, ignored={**joined.ignored, **here})


def _with_files(made: Assembly | None) -> Assembly | None:
    """Sets the file of each link."""
    if made is None:
        return None
    links = tuple(replace(link, file=made.draft.file) for link in made.draft.links)
    return replace(made, draft=replace(made.draft, links=links, file=None))


def _prefix(name: str, part: Any) -> str:
    """The prefix of a part's names."""
    return f"{name}/" if part.prefix is None else part.prefix


def _rename_link(link: DraftLink, prefix: str, to: int, start: int, shift: int) -> DraftLink:
    """Converts a link of a part to a link of the whole. `to`: parent link of the part; `shift`: bits in use."""
    joint = link.joint
    if joint is not None:
        mimic = joint.mimic and replace(joint.mimic, source=prefix + joint.mimic.source)
        joint = replace(joint, name=joint.name and prefix + joint.name, mimic=mimic)
    parent = to if link.parent is None else start + link.parent
    return replace(link, name=prefix + link.name, parent=parent, joint=joint, ignore_bits=link.ignore_bits << shift)


def _rename_constraint(constraint: DescribedConstraint, prefix: str) -> DescribedConstraint:
    (root, parent), (_, child) = constraint.parent, constraint.child
    return replace(
        constraint, name=prefix + constraint.name, parent=(root, prefix + parent), child=(root, prefix + child)
    )


def _link_names(links: Iterable[DraftLink]) -> Iterator[str]:
    return (link.name for link in links)


def _joint_names(links: Iterable[DraftLink]) -> Iterator[str]:
    return (link.joint.name for link in links if link.joint is not None and link.joint.name)


def _bit_count(links: Iterable[DraftLink]) -> int:
    """Number of bits of the third collision integer in use, from the lowest."""
    return max(link.ignore_bits.bit_length() for link in links)


def _pairs(links: Sequence[DraftLink]) -> tuple[Pairs, Pairs]:
    """Pairs of links with collision shapes: those with a common bit, and all that ignore one another."""
    numbers = [number for number, link in enumerate(links) if link.collides]
    wanted = {pair for pair in combinations(numbers, 2) if links[pair[0]].ignore_bits & links[pair[1]].ignore_bits}
    return wanted, wanted | _next_to(links)


def _next_to(links: Sequence[DraftLink]) -> Pairs:
    """Pairs of parent and child link with collision shapes, which PhysX ignores."""
    return {
        order_pair(link.parent, number)
        for number, link in enumerate(links)
        if link.parent is not None and link.collides and links[link.parent].collides
    }
