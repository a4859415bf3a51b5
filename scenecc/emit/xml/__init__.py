"""What the files of MuJoCo and of ROS have in common: elements, numbers, frames, meshes beside them, what they lack."""
