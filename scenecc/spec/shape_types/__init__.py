"""Shapes, one module a type: loaded when a document has one."""
