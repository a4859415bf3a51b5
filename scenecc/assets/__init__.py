"""Images and meshes that a scene names: what libraries read of them, and what a build needs of them."""
