"""Live scenes of SAPIEN and ManiSkill as scene files: what no getter gives back is recorded, all else is read."""
