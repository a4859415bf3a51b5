"""Writes live scenes of SAPIEN and ManiSkill as scene files. Values without a getter come from a recording."""
