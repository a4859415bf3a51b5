"""From a scene file as written to one that needs no other file: parameters, expressions, repetition, includes, prefabs.

It works on plain data; every node of what comes out can be led back to where it was written.
"""
