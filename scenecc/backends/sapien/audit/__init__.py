"""After every build: what only the engine decides (counts, order, poses, masses, cooked meshes) against the plan."""
