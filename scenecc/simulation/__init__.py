"""`scenecc check`: builds and simulates a scene to find bodies that overlap, fall, or move away."""
