"""Where things stand: poses in every form, frames and what stands relative to what, rotations."""
