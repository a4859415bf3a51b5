"""scenecc: a compiler for scenes in robot simulation."""
