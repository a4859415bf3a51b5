"""Scenes that meet every pair of what a file draws, and the pairs that episodes never met."""
