"""Whether the files of a plan still hold what they held when it was made."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.plan import AssetFile

_SHOWN = 12


def check_same(known: AssetFile, found: AssetFile, origin: Origin, sink: Sink) -> None:
    """Reports a file that changed (SC716).

    Args:
        known: the file as the plan has it; without a hash it is taken as it is.
        found: the same as it was read now.
        origin: where it is named.
        sink: takes the fault.
    """
    if known.sha256 is None:
        return
    before = {"": known.sha256} | {one.uri: one.sha256 for one in known.names}
    after = {"": found.sha256} | {one.uri: one.sha256 for one in found.names}
    for uri in dict.fromkeys([*before, *after]):
        if before.get(uri) != after.get(uri):
            name = f"{known.uri}: the file `{uri}`, which it names," if uri else f"{known.uri}: the file"
            was, now = (_shown(hashes.get(uri)) for hashes in (before, after))
            hint = "compile the scene again, or put the file back"
            sink.report("SC716", f"{name} is not what it was: {now} now, {was} in the plan", origin, hint=hint)


def _shown(digest: str | None) -> str:
    return "nothing" if digest is None else f"SHA-256 {digest[:_SHOWN]}…"
