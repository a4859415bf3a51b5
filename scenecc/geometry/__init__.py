"""Rotations and poses, for one or for many at once."""
