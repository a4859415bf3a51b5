"""Articulations, or single bodies, as URDF."""
