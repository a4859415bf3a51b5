"""The audit after every build: compares counts, order, poses, masses and cooked meshes with the plan."""
