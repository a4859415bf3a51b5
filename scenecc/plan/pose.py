"""A pose as seven numbers."""

from __future__ import annotations

"""p [m] then q (wxyz), of unit length."""
