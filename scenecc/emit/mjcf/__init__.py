"""One scene as a model of MuJoCo."""
