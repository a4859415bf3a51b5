"""Files of starts: poses and joint positions at which the scenes of a file have come to rest."""
