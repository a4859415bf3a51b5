"""What bare SAPIEN builds and ManiSkill cannot handle."""

from __future__ import annotations

UNFIT = "SC811"
"""Its code."""
