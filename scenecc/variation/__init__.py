"""Variation: expressions, forms, what they can give, and the draws, over all scenes at once."""
