"""Where placed entities stand: poses that a plan's `placements` describe, over many scenes at once, in numpy alone."""
