"""Files that others made and a scene uses: checks that they are whole, by one library for each format.

What no library reads and SAPIEN does (HDR, EXR and KTX images) is checked here.
"""
