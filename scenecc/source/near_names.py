"""The name that was probably meant by a path to a file that is not there."""

from __future__ import annotations

import difflib
import os
from itertools import islice
from pathlib import Path
from typing import NamedTuple

_LISTED_NAMES = 1000
_GUESSES = 20


class _Listing(NamedTuple):
    names: tuple[str, ...]
    by_lower: dict[str, str]
    by_stem: dict[str, str]


class NearNames:
    """Suggestions for missing files. Lists each folder once, so it is for one compilation."""

    def __init__(self) -> None:
        self._listings: dict[Path, _Listing] = {}
        self._guesses_left = _GUESSES

    def hint(self, path: Path) -> str | None:
        """What to say about a missing file.

        Args:
            path: absolute, without links and `..`.
        """
        folder = next((parent for parent in path.parents if parent.is_dir()), Path(path.anchor))
        missing, *rest = path.relative_to(folder).parts
        guess = self._guess(missing, self._listing(folder))
        if guess is not None:
            return f"did you mean `{'/'.join([guess, *rest])}`?"
        return f"there is no folder {folder / missing}" if rest else None

    def _guess(self, missing: str, listing: _Listing) -> str | None:
        alike = listing.by_lower.get(missing.lower()) or listing.by_stem.get(Path(missing).stem.lower())
        # Comparing letters costs milliseconds in a full folder: ten thousand slips get no ten thousand guesses.
        if alike is not None or self._guesses_left <= 0 or len(missing) > 255:
            return alike
        self._guesses_left -= 1
        close = difflib.get_close_matches(missing, listing.names, n=1, cutoff=0.7)
        return close[0] if close else None

    def _listing(self, folder: Path) -> _Listing:
        if folder not in self._listings:
            try:
                with os.scandir(folder) as entries:
                    names = sorted((entry.name for entry in islice(entries, _LISTED_NAMES)), reverse=True)
            except OSError:
                names = []
            # Reversed: of several alike the first in the alphabet stays.
            self._listings[folder] = _Listing(
                tuple(names), {name.lower(): name for name in names}, {Path(name).stem.lower(): name for name in names}
            )
        return self._listings[folder]
