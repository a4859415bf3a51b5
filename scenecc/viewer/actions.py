"""The interface from the page to the session."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import viser

    from scenecc.viewer.nodes import Key
    from scenecc.viewer.options import ViewOptions


class Actions(Protocol):
    """Actions that a page can request."""

    def look_at(self, look: ViewOptions) -> None:
        """Changes what is shown."""
        ...

    def play(self) -> None:
        """Starts or stops the simulation."""
        ...

    def step(self, n: int) -> None:
        """Simulates some steps."""
        ...

    def reset(self, seed: int) -> None:
        """Resets everything to its start."""
        ...

    def rebuild(self, seed: int) -> None:
        """Rebuilds the scene with a seed."""
        ...

    def give(self, name: str, value: Any) -> None:
        """Sets a parameter; `AS_WRITTEN`: to the file's own value."""
        ...

    def give_nothing(self) -> None:
        """Resets all parameters to the file's values."""
        ...

    def select(self, key: Key) -> None:
        """Selects a body and shows its properties."""
        ...

    def search(self) -> None:
        """Lists the objects that match the search."""
        ...

    def hide(self, *, hidden: bool) -> None:
        """Hides or shows the entity of the selected body."""
        ...

    def show_all(self) -> None:
        """Shows all hidden entities."""
        ...

    def lock(self, *, locked: bool) -> None:
        """Locks or unlocks the entity of the selected body against clicks and moves."""
        ...

    def move(self, *, on: bool) -> None:
        """Adds a gizmo to the selected body, or removes it."""
        ...

    def undo(self) -> None:
        """Undoes the last move."""
        ...

    def set_joint(self, number: int, position: float) -> None:
        """Moves a joint of the selected articulation."""
        ...

    def check(self) -> None:
        """Shows what `scenecc check` finds at the start."""
        ...

    def record(self, browser: viser.ClientHandle, seconds: float) -> None:
        """Simulates for a time [s], and sends a browser a video of its view."""
        ...
