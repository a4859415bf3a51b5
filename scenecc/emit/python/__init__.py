"""A plan as a readable script of plain SAPIEN calls."""
