"""`scenecc.sweep`: many seeds and scenes of files, on many processes or machines, into one table."""
