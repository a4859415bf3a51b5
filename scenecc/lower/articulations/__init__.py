"""Articulations as written, in the scene file or in a robot's, to structures of the plan."""
