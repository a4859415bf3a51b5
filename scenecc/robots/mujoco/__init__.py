"""Reads MJCF: MuJoCo's own compiler resolves the file, and robots are described from the compiled model."""
