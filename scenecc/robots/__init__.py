"""Reads URDF with SRDF, and MJCF, into descriptions of links and joints. Independent of engine and scene language."""
