"""Reads meshes and images, each content once, with one library per format.

HDR, EXR and KTX images, which SAPIEN reads but no library here does, are checked by our own code.
"""
