"""What `scenecc check` finds by building and simulating a scene: bodies that overlap, that nothing supports, that do
not stay.
"""
