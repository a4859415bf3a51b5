"""Temporary: until images are read by Pillow."""

from scenecc.checks.images import IMAGE_SUFFIXES, check_image, image_size

__all__ = ["IMAGE_SUFFIXES", "check_image", "image_size"]
