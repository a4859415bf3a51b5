"""What the engine holds against what the plan asks: an independent reading, after every build."""
