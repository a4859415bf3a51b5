"""MJCF as MuJoCo means it: its own compiler resolves the file, and robots are described from the compiled model."""
