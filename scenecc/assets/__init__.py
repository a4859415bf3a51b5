"""Files that others made and a scene uses: what one library for each format reads of them, once for each content.

What no library reads and SAPIEN does (HDR, EXR and KTX images) is checked here.
"""
