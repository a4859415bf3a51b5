"""The progress of a build, on the page and for the caller."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    import viser


class BuildProgress:
    """A bar on the page, visible inside a `with` block once more than one scene is counted; the first build, always."""

    def __init__(self, server: viser.ViserServer, told: Callable[[int, int], None] | None) -> None:
        """`told`: also called with (scenes done, total scenes), if given."""
        self._text = server.gui.add_markdown("", visible=False)
        self._bar = server.gui.add_progress_bar(0, visible=False)
        self._told = told

    def __enter__(self) -> None:
        """Waits for a count."""

    def __exit__(self, *error: object) -> None:
        """Hides the bar."""
        self._text.visible = self._bar.visible = False

    def tell_first(self) -> None:
        """Shows that the first scene is being built."""
        self._text.content, self._text.visible = "Building the scene", True

    def tell(self, done: int, total: int) -> None:
        """Shows that some scenes are built."""
        if total > 1:
            self._text.content = f"Building: {done} of {total} scenes"
            self._bar.value = 100 * done / total
            self._text.visible = self._bar.visible = True
        if self._told is not None:
            self._told(done, total)
