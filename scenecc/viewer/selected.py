"""Properties and controls of the selected body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.interrupt import interrupts_wait
from scenecc.viewer.texts import facts, line, pose

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import viser

    from scenecc.geometry.rotations import Pose7
    from scenecc.inspect import Item
    from scenecc.viewer.nodes import Key
    from scenecc.viewer.session import Session
    from scenecc.viewer.tasks import TaskQueue
    from scenecc.viewer.world import JointPosition

_UNSELECTED = "Click a body or its name."

_MOST_JOINTS = 64
"""Maximum number of sliders."""

_SHORTEST = 1e-6
"""Minimum range of a slider: viser rejects an empty one."""


@frozen
class Selected:
    """A selected body.

    Attributes:
        key: the body.
        item: properties of its entity.
        hidden, locked: whether the entity is.
        unmovable: why its pose cannot be written into the file; "" if it can.
        joints: the movable joints of its articulation.
    """

    key: Key
    item: Item
    hidden: bool
    locked: bool
    unmovable: str
    joints: tuple[JointPosition, ...]


class SelectedPanel:
    """The controls, in a viser container. Ctrl-C waits for the end of each method that changes them."""

    def __init__(self, gui: viser.GuiApi, mail: TaskQueue, session: Session) -> None:
        self._hidden = self._box(gui, "Hidden", "Hide it in the view")
        self._locked = self._box(gui, "Locked", "Ignore clicks in the view, and moves")
        self._move = self._box(gui, "Move", "Drag it; its pose is written to the file")
        self._note = gui.add_html("", visible=False)
        self._undo = gui.add_button("Undo move", visible=False, hint="Restore the file before the last move")
        self._gui, self._mail, self._set_joint = gui, mail, session.set_joint
        self._of: Any = None
        self._joints: list[Any] = []
        self._joint_folder = gui.add_folder("Joints", visible=False)
        self._pose = gui.add_html("", visible=False)
        self._facts = gui.add_html(line(_UNSELECTED))
        self._hidden.on_update(_poster(mail, "hide", self._hidden, lambda on: session.hide(hidden=on)))
        self._locked.on_update(_poster(mail, "lock", self._locked, lambda on: session.lock(locked=on)))
        self._move.on_update(_poster(mail, "move", self._move, lambda on: session.move(on=on)))
        self._undo.on_click(lambda _: mail.post("undo", session.undo))

    @staticmethod
    def _box(gui: viser.GuiApi, label: str, hint: str) -> viser.GuiCheckboxHandle:
        return gui.add_checkbox(label, initial_value=False, visible=False, hint=hint)

    @property
    def text(self) -> str:
        """All displayed text."""
        return f"{self._facts.content}\n{self._pose.content}\n{self._note.content}"

    @interrupts_wait()
    def tell(self, selected: Selected | None, *, moves: bool) -> None:
        """Shows a body; None: nothing is selected. `moves`: whether it can be dragged now."""
        self._facts.content = line(_UNSELECTED) if selected is None else facts(selected.item)
        for box in (self._hidden, self._locked, self._move):
            box.visible = selected is not None
        if selected is not None:
            self._hidden.value, self._locked.value, self._move.value = selected.hidden, selected.locked, moves
            self._move.disabled = selected.locked or bool(selected.unmovable)
        self._tell_joints(selected)
        note = "" if selected is None or not selected.unmovable else f"It cannot be moved here: {selected.unmovable}."
        self._note.content, self._note.visible = (line(note) if note else ""), bool(note)

    @interrupts_wait()
    def tell_joints(self, joints: Sequence[JointPosition]) -> None:
        """Shows the positions of the selected articulation's joints."""
        for slider, joint in zip(self._joints, joints, strict=False):
            slider.value = min(max(joint.position, joint.low), joint.high)

    @interrupts_wait()
    def tell_pose(self, name: str, now: Pose7 | None) -> None:
        """Shows the current pose of the selected body; None: it does not move."""
        self._pose.content, self._pose.visible = (pose(name, now) if now else ""), now is not None

    def _tell_joints(self, selected: Selected | None) -> None:
        """Replaces the sliders if the joints differ. Sliders of the same joints stay, so that they can be dragged."""
        joints = () if selected is None else selected.joints[:_MOST_JOINTS]
        of = None if selected is None or not joints else (*selected.key[:2], len(joints))
        if of != self._of:
            for slider in self._joints:
                slider.remove()
            self._of, self._joint_folder.visible = of, bool(joints)
            with self._joint_folder:
                self._joints = [self._slider(number, joint) for number, joint in enumerate(joints)]
        self.tell_joints(joints)

    def _slider(self, number: int, joint: JointPosition) -> Any:
        start = min(max(joint.position, joint.low), joint.high)
        span = max(joint.high - joint.low, _SHORTEST)
        slider = self._gui.add_slider(
            joint.name or f"joint {number}",
            min=joint.low,
            max=joint.low + span,
            step=span / 200,
            initial_value=start,
            hint=f"[{joint.unit}]; the file is not changed",
        )

        def update(event: Any) -> None:
            if event.client is not None:
                self._mail.post(("joint", number), lambda: self._set_joint(number, float(slider.value)))

        slider.on_update(update)
        return slider

    @interrupts_wait()
    def tell_refusal(self, text: str) -> None:
        """Shows why an action on the selected body failed."""
        self._note.content, self._note.visible = line(text), True

    @interrupts_wait()
    def tell_undo(self, *, possible: bool) -> None:
        """Shows whether a move can be undone."""
        self._undo.visible = possible


def _poster(mail: TaskQueue, key: str, box: Any, act: Callable[[bool], None]) -> Callable[[Any], None]:
    """Returns a callback that posts changes of a checkbox by a browser, but not by this program."""

    def update(event: Any) -> None:
        if event.client is not None:
            mail.post(key, lambda: act(bool(box.value)))

    return update
