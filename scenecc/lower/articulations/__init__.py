"""Lowers articulations, from the scene file or a robot file, to structures of the plan."""
