"""A cache of results by file content, in memory and in the user's cache folder."""

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
"""Largest number of results of one kind in memory."""


@dataclass(frozen=True)
class ContentCache:
    """Results of one kind, each a JSON value.

    Attributes:
        kind: the folder in the cache folder.
        version: of the results. Increase it if the result for the same content changes.
        packages: packages whose version a result depends on.
    """

    kind: str
    version: int
    packages: tuple[str, ...]
    _results: dict[str, Any] = field(default_factory=dict[str, Any])

    @cached_property
    def _versions(self) -> tuple[object, ...]:
        return (self.version, *map(version, self.packages))

    def key(self, *identity: object) -> str:
        """Returns the key of a result: a hash of versions and of the `repr` of `identity`."""
        return sha256(repr((self._versions, identity)).encode()).hexdigest()

    def file(self, key: str) -> Path:
        """Returns the path of a result."""
        return cache_folder(self.kind) / key

    def find(self, key: str) -> Any:
        """Returns a stored result, or None."""
        if key not in self._results:
            content = read_result(self.file(key))
            if content is None:
                return None
            self._remember(key, json.loads(content))
        return self._results[key]

    def keep(self, key: str, result: Any) -> None:
        """Stores a result. A file that cannot be written is skipped."""
        self._remember(key, result)
        keep_result(self.file(key), json.dumps(result).encode())

    def forget(self) -> None:
        """Empties the memory, as in a new process."""
        self._results.clear()

    def _remember(self, key: str, result: Any) -> None:
        if len(self._results) >= _MOST_KEPT:
            del self._results[next(iter(self._results))]
        self._results[key] = result
