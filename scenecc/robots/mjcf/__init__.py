"""MJCF: robots and bodies as MuJoCo's files describe them, built as ManiSkill's loader builds them."""

from scenecc.robots.mjcf.read import read_mjcf

__all__ = ["read_mjcf"]
