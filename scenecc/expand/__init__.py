"""Expands parameters, expressions, repetition, includes and prefabs into one self-contained scene file.

Input and output are plain data. Every node of the result can be traced to its origin.
"""
