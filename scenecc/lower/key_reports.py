"""Reports of keys that exclude each other, and of keys that do nothing where they stand."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink


def report_exclusive_keys(
    first: str, second: str, origin: Origin, sink: Sink, *, message: str = "", related: str = "the first"
) -> None:
    """Reports the second of two keys that exclude each other (SC111).

    Args:
        first: key of the node.
        second: key of the node, at which it is told.
        origin: of the node.
        sink: takes the diagnostic.
        message: in place of the usual one.
        related: what the first one is called.
    """
    message = message or f"`{first}` and `{second}` exclude each other"
    place = origin.child(second)
    sink.report("SC111", message, place, at="key", related=[(related, origin.child(first), "key")])


def report_unused_key(key: str, where: str, origin: Origin, sink: Sink, *, hint: str = "") -> None:
    """Reports a key that does nothing (SC115).

    Args:
        key: of the node.
        where: it does nothing: "on a light without a shadow".
        origin: of the node.
        sink: takes the diagnostic.
        hint: in place of the usual one, to leave the key out.
    """
    hint = hint or f"leave `{key}` out"
    sink.report("SC115", f"`{key}` does nothing {where}", origin.child(key), at="key", hint=hint)
