"""Why a file cannot be used."""

from __future__ import annotations


class AssetError(Exception):
    """Why an asset cannot be used: a code of band 4 or 6, a message and what to do."""

    def __init__(self, code: str, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.code, self.message, self.hint = code, message, hint
