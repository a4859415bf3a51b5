"""Rotations and poses, for one or for many at once."""

SIDES = 32
"""Corners of a circle of a cone or ring, as of SAPIEN's cylinders."""
