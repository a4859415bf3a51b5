"""What constraints, lights and cameras hold on to."""

from __future__ import annotations

from scenecc.diagnostics.frozen import frozen


@frozen
class Mount:
    """A body that something is fastened to.

    Attributes:
        entity: its name in the plan.
        link: of an articulation; None: the entity is a body.
    """

    entity: str
    link: str | None = None
