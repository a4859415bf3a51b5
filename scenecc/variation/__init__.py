"""Variation: expressions and forms, the bounds of their values, and sampling over all scenes at once."""
