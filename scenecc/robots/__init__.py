"""Descriptions of robots: URDF with SRDF, and MJCF, read into one tree of links and joints. No engine, no language."""
