"""Scenes as GLB: what is seen, or what collides, for people and their viewers. Nothing of physics is in it."""
