"""Poses of placed entities, from a plan's `placements`, vectorized over scenes with NumPy."""
