"""Reads meshes and images, once for each content, with one library per format.

What no library reads and SAPIEN does (HDR, EXR and KTX images) is checked here.
"""
