"""Results that follow from the content of files: kept in memory, and in the user's cache folder for other processes."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from scenecc.files import cache_folder, keep_result, read_result

_MOST_KEPT: Final = 4096
"""Results of a kind in memory."""


@dataclass(frozen=True)
class ContentCache:
    """Results of one kind, each a JSON value.

    Attributes:
        kind: the folder below the cache folder.
        version: of what is kept. Raise it where a result is another one for the same content.
        packages: those whose version a result depends on.
    """

    kind: str
    version: int
    packages: tuple[str, ...]
    _results: dict[str, Any] = field(default_factory=dict[str, Any])

    @cached_property
    def _versions(self) -> tuple[object, ...]:
        return (self.version, *map(version, self.packages))

    def key(self, *identity: object) -> str:
        """The key of a result: a hash of versions and of `identity`, of which `repr` tells all."""
        return sha256(repr((self._versions, identity)).encode()).hexdigest()

    def file(self, key: str) -> Path:
        """Where a result is kept."""
        return cache_folder(self.kind) / key

    def find(self, key: str) -> Any:
        """What was kept; None if nothing was."""
        if key not in self._results:
            content = read_result(self.file(key))
            if content is None:
                return None
            self._remember(key, json.loads(content))
        return self._results[key]

    def keep(self, key: str, result: Any) -> None:
        """Keeps a result. A file that cannot be written is left out."""
        self._remember(key, result)
        keep_result(self.file(key), json.dumps(result).encode())

    def forget(self) -> None:
        """Empties the memory, as in a new process."""
        self._results.clear()

    def _remember(self, key: str, result: Any) -> None:
        if len(self._results) >= _MOST_KEPT:
            del self._results[next(iter(self._results))]
        self._results[key] = result
