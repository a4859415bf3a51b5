"""Rotations and poses, single or batched; surfaces of solids; OBJ and PLY."""
