"""From a scene file to one that refers to no other scene file: parameters, expressions, repetition, includes, prefabs.

It works on plain data. Every node of the result can be traced to its origin.
"""
