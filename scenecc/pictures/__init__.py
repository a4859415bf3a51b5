"""Pictures as files: what a camera measures as colours, sheets of many pictures, PNG, GIF and MP4.

Takes arrays and knows nothing of scenes. Pillow and ffmpeg are loaded when something is drawn or written.
"""
